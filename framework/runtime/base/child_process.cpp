#include "runtime/base/child_process.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <linux/close_range.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <stdexcept>

extern char** environ;

namespace plumbline::runtime {

namespace {

std::vector<char*> pointers(std::vector<std::string>& texts) {
  std::vector<char*> list;
  for (std::string& text : texts) list.push_back(text.data());
  list.push_back(nullptr);
  return list;
}

/// Ours, with `settings` in place of what has their names.
std::vector<std::string> environment_with(const std::vector<std::string>& settings) {
  std::vector<std::string> all = settings;
  for (char** entry = environ; *entry; ++entry) {
    const std::string text = *entry, name = text.substr(0, text.find('=') + 1);
    if (std::none_of(settings.begin(), settings.end(), [&](const std::string& s) { return s.rfind(name, 0) == 0; }))
      all.push_back(text);
  }
  return all;
}

struct Words {
  char* const* arguments;
  char* const* environment;
};

/// In the child. Other threads of ours may have held any lock at the fork, so only what is safe in a signal handler
/// may be called here. `failure` is a pipe that execve() closes; what went wrong goes into it.
[[noreturn]] void become(const ChildStart& start, const Words& words, int log, int failure, pid_t parent) {
  setpgid(0, 0);
  if (start.ends_with_this_thread) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);  // it ended before
  }
  for (int signal = 1; signal < NSIG; ++signal) std::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  const rlimit data{start.memory_limit, start.memory_limit};
  if (start.memory_limit) setrlimit(RLIMIT_DATA, &data);
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  dup2(nothing, STDIN_FILENO);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  syscall(SYS_close_range, child_channel, ~0U, CLOSE_RANGE_CLOEXEC);
  if (start.channel == child_channel) fcntl(child_channel, F_SETFD, 0);
  if (start.channel >= 0 && start.channel != child_channel) {
    if (failure == child_channel) failure = fcntl(failure, F_DUPFD_CLOEXEC, child_channel + 1);
    dup2(start.channel, child_channel);
  }
  execve(words.arguments[0], words.arguments, words.environment);
  const int error = errno;
  [[maybe_unused]] const ssize_t written = write(failure, &error, sizeof error);
  _exit(127);
}

}  // namespace

ChildProcess start_child(const ChildStart& start) {
  std::vector<std::string> arguments = start.arguments, environment = environment_with(start.settings);
  const std::vector<char*> argument_list = pointers(arguments), environment_list = pointers(environment);
  const Words words{argument_list.data(), environment_list.data()};
  ChildProcess child;
  int failure[2] = {-1, -1}, error = 0;
  child.log = memfd_create("plumbline-child", MFD_CLOEXEC);
  // Both ends share its place, which only appending keeps right.
  if (child.log < 0 || fcntl(child.log, F_SETFL, O_APPEND) != 0 || pipe2(failure, O_CLOEXEC) != 0) error = errno;
  if (!error) {
    const pid_t parent = getpid();
    child.pid = fork();
    if (child.pid == 0) become(start, words, child.log, failure[1], parent);
    if (child.pid < 0) error = errno;
  }
  if (failure[1] >= 0) close(failure[1]);
  if (!error) {
    while (read(failure[0], &error, sizeof error) < 0 && errno == EINTR) {
    }
    if (!error && (child.handle = static_cast<int>(syscall(SYS_pidfd_open, child.pid, 0))) < 0) error = errno;
    if (error) finish_child(child);
  }
  if (failure[0] >= 0) close(failure[0]);
  if (!error) return child;
  if (child.log >= 0) close(child.log);
  throw std::runtime_error("cannot start " + start.arguments.at(0) + ": " + std::strerror(error));
}

ChildEnd finish_child(ChildProcess& child) {
  ChildEnd end;
  rusage used{};
  kill(-child.pid, SIGKILL);
  while (wait4(child.pid, &end.status, 0, &used) < 0 && errno == EINTR) {
  }
  end.peak_mebibytes = static_cast<double>(used.ru_maxrss) / 1024;
  if (child.handle >= 0) close(child.handle);
  child.handle = -1;
  return end;
}

static off_t size_of(int file) {
  struct stat info {};
  return fstat(file, &info) == 0 ? info.st_size : 0;
}

void empty_log(int log) {
  if (ftruncate(log, 0) != 0) throw std::runtime_error(std::string("cannot empty a log: ") + std::strerror(errno));
}

void shorten_log(int log) {
  constexpr off_t most = off_t{16} << 20, kept = off_t{1} << 20;
  const off_t size = size_of(log);
  if (size > most) fallocate(log, FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, size - kept);
}

std::string end_of_log(int log, size_t most) {
  const off_t size = size_of(log);
  std::string text(std::min(most, static_cast<size_t>(size)), '\0');
  const ssize_t count = pread(log, text.data(), text.size(), size - static_cast<off_t>(text.size()));
  text.resize(std::max<ssize_t>(count, 0));
  return text;
}

static constexpr off_t kLastWords = 600;  // [bytes]

std::string last_words(int log) {
  std::string text = end_of_log(log, kLastWords);
  while (!text.empty() && (std::isspace(static_cast<unsigned char>(text.back())) || !text.back())) text.pop_back();
  if (text.empty()) return "it printed nothing";
  const size_t last = text.rfind('\n');
  // Of a line that is longer, not from the middle of a letter of several bytes.
  const auto is_inside_a_letter = [](const std::string& s) {
    return !s.empty() && (static_cast<unsigned char>(s.front()) & 0xC0) == 0x80;
  };
  if (last == std::string::npos) {
    while (is_inside_a_letter(text)) text.erase(0, 1);
    return "the last it printed: " + text;
  }
  // Interpreters print where they were, and then what is wrong: that comes first here. What stands before it begins
  // with a whole line.
  std::string before = text.substr(0, last);
  if (size_of(log) > kLastWords)
    before.erase(0, before.find('\n') == std::string::npos ? before.size() : before.find('\n') + 1);
  return "the last it printed: " + text.substr(last + 1) + (before.empty() ? "" : "\nbefore that:\n" + before);
}

namespace {

std::string rounded(double value) { return fmt::format("{:.{}f}", value, value < 10 ? 1 : 0); }

}  // namespace

std::string mebibytes_text(uint64_t bytes) { return rounded(static_cast<double>(bytes) / (1 << 20)) + " MiB"; }

std::string lateness_text(double seconds, int log) {
  return "it took longer than its limit of " + rounded(seconds) + " s and was killed; " + last_words(log);
}

constexpr const char* peak_words = ", with a peak of ";

std::string without_peaks(std::string text) {
  const std::string words = peak_words, unit = " MiB";
  for (auto at = text.find(words); at != std::string::npos; at = text.find(words, at)) {
    const auto end = text.find_first_not_of("0123456789.", at + words.size());
    if (end == std::string::npos || text.compare(end, unit.size(), unit) != 0)
      at += words.size();
    else
      text.erase(at, end + unit.size() - at);
  }
  return text;
}

std::string death_text(const ChildEnd& end, int log, uint64_t memory_limit) {
  const std::string with = peak_words + rounded(end.peak_mebibytes) + " MiB; ";
  std::string text;
  if (WIFSIGNALED(end.status)) {
    const int signal = WTERMSIG(end.status);
    text = "its process died of signal " + std::to_string(signal) + " (" + strsignal(signal) + ")" + with;
    if (signal == SIGKILL) text += "the system kills so when memory is short, and so does kill -9; ";
  } else {
    text = "its process ended by itself with exit code " + std::to_string(WEXITSTATUS(end.status)) + with;
  }
  if (memory_limit) text += "its limit of memory is " + mebibytes_text(memory_limit) + "; ";
  return text + last_words(log);
}

}  // namespace plumbline::runtime

#include "photo/colmap/program.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <map>
#include <mutex>
#include <regex>
#include <stdexcept>

#include "base/text/whole_file.hpp"
#include "plumbline/stop.hpp"

extern char** environ;

namespace plumbline::colmap {
namespace {

namespace fs = std::filesystem;

constexpr int poll_milliseconds = 20;

/// The end of what was printed, without its last line breaks.
std::string last_words(const fs::path& log) {
  constexpr size_t most = 600;
  std::string text = text::read_whole(log);
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  if (text.size() > most) text = "…" + text.substr(text.size() - most);
  return text.empty() ? "it printed nothing" : "the last it printed: " + text;
}

/// Our environment, but no window: COLMAP is linked to Qt and looks for a display even on the command line.
std::vector<std::string> settings() {
  std::vector<std::string> result = {"QT_QPA_PLATFORM=offscreen"};
  for (char** entry = environ; *entry; ++entry)
    if (std::strncmp(*entry, "QT_QPA_PLATFORM=", 16) != 0) result.emplace_back(*entry);
  return result;
}

std::vector<char*> pointers(std::vector<std::string>& words) {
  std::vector<char*> result;
  for (auto& word : words) result.push_back(word.data());
  result.push_back(nullptr);
  return result;
}

pid_t start(const std::string& program, const std::vector<std::string>& arguments, const fs::path& log) {
  std::vector<std::string> words = {program}, environment = settings();
  words.insert(words.end(), arguments.begin(), arguments.end());
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&files, STDOUT_FILENO, log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND, 0600);
  posix_spawn_file_actions_adddup2(&files, STDOUT_FILENO, STDERR_FILENO);
  pid_t child = -1;
  const int error =
      posix_spawnp(&child, program.c_str(), &files, nullptr, pointers(words).data(), pointers(environment).data());
  posix_spawn_file_actions_destroy(&files);
  if (error == ENOENT)
    throw std::runtime_error("the program '" + program +
                             "' is not installed: install it (Debian: apt install colmap), or use adjust.schur or "
                             "adjust.ceres, which need no other program");
  if (error) throw std::runtime_error("the program '" + program + "' cannot be started: " + std::strerror(error));
  return child;
}

/// Ends the child when the scope does, if it has not ended by itself.
class Child {
 public:
  explicit Child(pid_t pid) : pid_(pid), handle_(static_cast<int>(syscall(SYS_pidfd_open, pid, 0))) {}
  ~Child() {
    if (!ended_) {
      kill(pid_, SIGKILL);
      wait();
    }
    if (handle_ >= 0) close(handle_);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Waits a moment; true if the child has ended, then `status` is known.
  bool has_ended(int& status) {
    pollfd watched{handle_, POLLIN, 0};
    poll(handle_ >= 0 ? &watched : nullptr, handle_ >= 0 ? 1 : 0, poll_milliseconds);
    const pid_t found = waitpid(pid_, &status, WNOHANG);
    if (found < 0 && errno != EINTR) throw std::runtime_error("the program 'colmap' cannot be waited for");
    return ended_ = found == pid_;
  }

 private:
  void wait() const {
    while (waitpid(pid_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  pid_t pid_;
  int handle_;
  bool ended_ = false;
};

}  // namespace

ScratchFolder::ScratchFolder() {
  std::error_code error;
  const fs::path where = fs::temp_directory_path(error);
  if (error) throw std::runtime_error("TMPDIR names no folder in which COLMAP could work: " + error.message());
  std::string name = (where / "plumbline-colmap-XXXXXX").string();
  if (!mkdtemp(name.data()))
    throw std::runtime_error("cannot make a folder for COLMAP in " + where.string() + ": " + std::strerror(errno));
  path_ = name;
}

ScratchFolder::~ScratchFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
}

fs::path ScratchFolder::make(const std::string& name) const {
  fs::create_directory(path_ / name);
  return path_ / name;
}

std::string run_program(const std::string& program, const std::vector<std::string>& arguments, double seconds,
                        const fs::path& log) {
  const auto begin = std::chrono::steady_clock::now();
  Child child(start(program, arguments, log));
  int status = 0;
  while (!child.has_ended(status)) {
    stop_point();
    if (std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count() > seconds) {
      throw std::runtime_error("'colmap " + arguments.at(0) + "' took longer than time_limit, " +
                               fmt::format("{:g}", seconds) + " s, and was ended; " + last_words(log));
    }
  }
  if (WIFSIGNALED(status))
    throw std::runtime_error("'colmap " + arguments.at(0) + "' died of signal " + std::to_string(WTERMSIG(status)) +
                             " (" + strsignal(WTERMSIG(status)) + "); " + last_words(log));
  if (WEXITSTATUS(status) != 0)
    throw std::runtime_error("'colmap " + arguments.at(0) + "' failed with exit code " +
                             std::to_string(WEXITSTATUS(status)) + "; " + last_words(log));
  return text::read_whole(log);
}

std::string version_of(const std::string& program) {
  static std::mutex mutex;
  static std::map<std::string, std::string> known;
  const std::scoped_lock lock(mutex);
  const auto [found, fresh] = known.try_emplace(program);
  if (!fresh) return found->second;
  constexpr double seconds = 20;
  const ScratchFolder scratch;
  try {
    const std::string said = run_program(program, {"help"}, seconds, scratch.path() / "log");
    std::smatch match;
    if (std::regex_search(said, match, std::regex("COLMAP [0-9][^ \n]*"))) found->second = match.str();
  } catch (const Stopped&) {
    known.erase(found);
    throw;
  } catch (const std::exception&) {  // what is wrong with it the work will tell
  }
  return found->second;
}

bool is_installed(const std::string& program) {
  if (program.find('/') != std::string::npos) return access(program.c_str(), X_OK) == 0;
  const char* path = std::getenv("PATH");
  std::string rest = path ? path : "/usr/bin:/bin";
  for (size_t at = 0; at <= rest.size();) {
    const size_t end = std::min(rest.find(':', at), rest.size());
    if (access((fs::path(rest.substr(at, end - at)) / program).c_str(), X_OK) == 0) return true;
    at = end + 1;
  }
  return false;
}

}  // namespace plumbline::colmap

#include "runtime/plugins/plugin_scan.hpp"

#include <fcntl.h>
#include <link.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <set>
#include <sstream>
#include <stdexcept>

#include "runtime/base/digest.hpp"
#include "runtime/plugins/elf.hpp"
#include "runtime/plugins/library.hpp"
#include "runtime/plugins/plugin_check.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

constexpr char good = '+', bad = '-';  // first byte of the child's word

const std::string hung = "hung", hang_text = "hangs while it is loaded";

int seconds_to_load() {
  const char* set = std::getenv("PLUMBLINE_SCAN_SECONDS");
  const int seconds = set ? std::atoi(set) : 0;
  return seconds > 0 ? seconds : 20;
}

/// What else decides which libraries the loader finds.
std::string loader_settings() {
  std::string text = file_identity("/etc/ld.so.cache");
  for (const char* name : {"LD_LIBRARY_PATH", "LD_PRELOAD"})
    if (const char* value = std::getenv(name)) text += std::string(" ") + value;
  return text;
}

/// The files of all libraries of this process, one a line, each with its identity.
std::string loaded_files() {
  std::string text;
  dl_iterate_phdr(
      [](dl_phdr_info* info, size_t, void* result) {
        if (info->dlpi_name && info->dlpi_name[0] == '/')
          *static_cast<std::string*>(result) +=
              std::string(info->dlpi_name) + '\t' + file_identity(info->dlpi_name) + '\n';
        return 0;
      },
      &text);
  return text;
}

/// Three texts, each after its length: linked build ids, files, table.
std::string join(const std::vector<std::string>& parts) {
  std::string text;
  for (const std::string& part : parts) text += std::to_string(part.size()) + ":" + part;
  return text;
}

std::vector<std::string> split(const std::string& text) {
  std::vector<std::string> parts;
  for (size_t at = 0; at < text.size();) {
    const size_t colon = text.find(':', at);
    const std::string digits = text.substr(at, colon == std::string::npos ? 0 : colon - at);
    if (digits.empty() || digits.size() > 9 || digits.find_first_not_of("0123456789") != std::string::npos) return {};
    const size_t size = std::stoul(digits);
    if (size > text.size() - colon - 1) return {};
    parts.push_back(text.substr(colon + 1, size));
    at = colon + 1 + size;
  }
  return parts;
}

/// Of the loaded files those that are the libraries of `ids` ("soname:build-id"), by the names behind their links.
std::vector<std::string> files_behind(const std::vector<std::string>& ids, const std::string& loaded) {
  std::set<std::string> names, files;
  for (const std::string& id : ids) names.insert(id.substr(0, id.find(':')));
  std::istringstream lines(loaded);
  for (std::string line; std::getline(lines, line);) {
    const fs::path path = line.substr(0, line.find('\t'));
    std::error_code ignored;
    if (names.count(path.filename()) > 0) files.insert(fs::weakly_canonical(path, ignored).filename());
  }
  files.erase("");
  return {files.begin(), files.end()};
}

PluginScan read_description(const std::string& description) {
  PluginScan scan;
  const auto parts = split(description);
  if (parts.size() != 3) throw std::runtime_error("is no description of a plugin");
  std::istringstream ids(parts[0]);
  for (std::string line; std::getline(ids, line);) scan.linked_build_ids.push_back(line);
  scan.linked_files = files_behind(scan.linked_build_ids, parts[1]);
  scan.table = std::make_unique<PluginTable>(parts[2]);
  return scan;
}

bool files_are_the_same(const std::string& list) {
  std::istringstream lines(list);
  for (std::string line; std::getline(lines, line);) {
    const size_t tab = line.find('\t');
    if (tab == std::string::npos || file_identity(line.substr(0, tab)) != line.substr(tab + 1)) return false;
  }
  return true;
}

/// Where the description of a library is remembered; empty if there is no such place.
fs::path memory_of(const std::string& sha256, const Roles& roles) {
  const char* cache = std::getenv("XDG_CACHE_HOME");
  const char* home = std::getenv("HOME");
  fs::path folder;
  if (cache && *cache)
    folder = fs::path(cache) / "plumbline" / "plugins";
  else if (home && *home)
    folder = fs::path(home) / ".cache" / "plumbline" / "plugins";
  if (folder.empty()) return folder;
  // The rules of this host are part of the name: what another one accepted is scanned anew.
  std::string rules = "scan 2 abi " + std::to_string(PLUMBLINE_ABI_MAJOR) + "." + std::to_string(PLUMBLINE_ABI_MINOR);
  for (const auto& [name, role] : roles.all()) {
    rules += "|" + name;
    for (const auto* ports : {&role.inputs, &role.outputs})
      for (const RolePort& port : *ports)
        rules += "," + port.name + " " + port.type + " " + port.frames + " " + std::to_string(port.cardinality);
  }
  return folder / (sha256 + "-" + sha256_of(rules.data(), rules.size()).substr(0, 16));
}

bool recall(const fs::path& memory, PluginScan& scan) {
  std::ifstream stream(memory, std::ios::binary);
  if (!stream) return false;
  std::ostringstream content;
  content << stream.rdbuf();
  const auto parts = split(content.str());
  if (parts.size() != 3 || parts[0] != loader_settings()) return false;
  if (parts[1] == hung) {
    scan.problem = parts[2];
    return true;
  }
  if (sha256_of(parts[2].data(), parts[2].size()) != parts[1]) return false;  // damaged
  try {
    const auto inner = split(parts[2]);
    if (inner.size() != 3 || !files_are_the_same(inner[1])) return false;
    scan = read_description(parts[2]);
    return true;
  } catch (const std::exception&) {
    return false;
  }
}

/// `check` is the hash of the description, or `hung` for the words of a library that hung.
void remember(const fs::path& memory, const std::string& check, const std::string& description) {
  std::error_code ignored;
  fs::create_directories(memory.parent_path(), ignored);
  const fs::path making = memory.string() + "." + std::to_string(getpid());
  std::ofstream stream(making, std::ios::binary);
  stream << join({loader_settings(), check, description});
  stream.close();
  if (stream) fs::rename(making, memory, ignored);
  fs::remove(making, ignored);
}

/// In the child: the word, `good` and the description, or `bad` and what is wrong.
std::string word_about(const fs::path& library, const Roles& roles) {
  try {
    const plumbline_plugin_table* table = open_table(library);
    if (const std::string problem = check_table(table, roles); !problem.empty()) return bad + problem;
    const std::string description = serialise(*table);
    // A host asks again: the second answer must be the first.
    const plumbline_plugin_table* again = open_table(library);
    if (!check_table(again, roles).empty() || serialise(*again) != description)
      return bad + std::string("returns another table at the second call of plumbline_plugin(); make it static");
    std::string ids;
    for (const std::string& id : linked_build_ids(table)) ids += id + '\n';
    return good + join({ids, loaded_files(), description});
  } catch (const std::exception& error) {
    return bad + std::string(error.what());
  } catch (...) {
    return bad + std::string("throws something that is no std::exception while it is loaded");
  }
}

void write_all(int file, const std::string& text) {
  for (size_t at = 0; at < text.size();) {
    const ssize_t count = write(file, text.data() + at, text.size() - at);
    if (count <= 0) return;
    at += static_cast<size_t>(count);
  }
}

[[noreturn]] void be_the_child(const fs::path& library, const Roles& roles, int word, int log) {
  setpgid(0, 0);  // so that what the library starts ends with it
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
  if (nothing >= 0) dup2(nothing, STDIN_FILENO);
  const rlimit no_core{0, 0};
  setrlimit(RLIMIT_CORE, &no_core);
  for (const int signal : {SIGINT, SIGTERM, SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL, SIGPIPE})
    std::signal(signal, SIG_DFL);
  write_all(word, join({word_about(library, roles)}));
  _exit(0);
}

int milliseconds_until(Clock::time_point deadline) {
  const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
  return static_cast<int>(std::max<long>(left, 0));
}

/// One that closed its end without a word may still go on for ever.
bool ended_by(pid_t child, Clock::time_point deadline) {
  const int handle = static_cast<int>(syscall(SYS_pidfd_open, child, 0));
  if (handle < 0) return false;
  pollfd ending{handle, POLLIN, 0};
  int ready = 0;
  do {
    ready = poll(&ending, 1, milliseconds_until(deadline));
  } while (ready < 0 && errno == EINTR);
  close(handle);
  return ready > 0;
}

/// Reads until the child's word is whole, its length going before it, or it is done. False: the time was up.
bool listen(int word, Clock::time_point deadline, std::string& text) {
  char buffer[1 << 16];
  while (true) {
    pollfd waiting{word, POLLIN, 0};
    const int ready = poll(&waiting, 1, milliseconds_until(deadline));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const ssize_t count = read(word, buffer, sizeof buffer);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return true;
    text.append(buffer, static_cast<size_t>(count));
    if (split(text).size() == 1) return true;
  }
}

/// What the library printed while it was loaded: the last lines.
std::string tail_of(int log) {
  char buffer[400];
  const off_t size = lseek(log, 0, SEEK_END);
  const off_t from = std::max<off_t>(0, size - static_cast<off_t>(sizeof buffer));
  const ssize_t count = pread(log, buffer, sizeof buffer, from);
  std::string text(buffer, static_cast<size_t>(std::max<ssize_t>(count, 0)));
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  return text.empty() ? "" : "; it printed: " + text;
}

std::string end_text(int status, bool in_time, int seconds) {
  if (!in_time)
    return hang_text + " (" + std::to_string(seconds) +
           " s, PLUMBLINE_SCAN_SECONDS); look at its static initialisers, or take it off the search path";
  if (WIFSIGNALED(status))
    return "dies while it is loaded: signal " + std::to_string(WTERMSIG(status)) + " (" + strsignal(WTERMSIG(status)) +
           "); look at its static initialisers and at the pointers of its table";
  return "ends the program while it is loaded (exit code " + std::to_string(WEXITSTATUS(status)) +
         "); a library must not call exit()";
}

PluginScan scan_in_child(const fs::path& library, const Roles& roles, std::string& description) {
  PluginScan scan;
  int ends[2];
  const int log = memfd_create("plumbline-scan", MFD_CLOEXEC);
  if (log < 0 || pipe2(ends, O_CLOEXEC) != 0)
    throw std::runtime_error(std::string("cannot be looked at: ") + std::strerror(errno));
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error(std::string("cannot be looked at: ") + std::strerror(errno));
  if (child == 0) be_the_child(library, roles, ends[1], log);
  setpgid(child, child);
  close(ends[1]);
  std::string said;
  const int seconds = seconds_to_load();
  const auto deadline = Clock::now() + std::chrono::seconds(seconds);
  bool in_time = listen(ends[0], deadline, said);
  close(ends[0]);
  // A child that gave its word ends by itself, unless a thread of the library holds it; nothing of it is needed.
  const std::vector<std::string> words = split(said);
  const bool spoke = words.size() == 1 && !words[0].empty();
  int status = 0;
  if (!spoke) in_time = in_time && ended_by(child, deadline);
  if (!in_time || spoke) kill(-child, SIGKILL);
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  kill(-child, SIGKILL);  // what it may have started
  if (!spoke)
    scan.problem = end_text(status, in_time, seconds) + tail_of(log);
  else
    (words[0][0] == bad ? scan.problem : description) = words[0].substr(1);
  close(log);
  return scan;
}

}  // namespace

PluginScan scan_plugin(const fs::path& library, const std::string& sha256, const Roles& roles, bool look_again) {
  PluginScan scan;
  const fs::path memory = memory_of(sha256, roles);
  if (!memory.empty() && !look_again && recall(memory, scan)) return scan;
  std::string description;
  try {
    scan = scan_in_child(library, roles, description);
    if (scan.problem.empty()) {
      scan = read_description(description);
      // The child may have been overwritten by the library it loaded: what it says is checked once more here, where the
      // pointers are our own.
      scan.problem = check_table(&scan.table->table(), roles);
    }
  } catch (const std::exception& error) {
    scan.problem = error.what();
  }
  if (memory.empty()) return scan;
  if (scan.problem.empty()) remember(memory, sha256_of(description.data(), description.size()), description);
  if (scan.problem.rfind(hang_text, 0) == 0)
    remember(memory, hung, scan.problem + "; remembered: `plumbline doctor` looks again");
  return scan;
}

}  // namespace plumbline::runtime

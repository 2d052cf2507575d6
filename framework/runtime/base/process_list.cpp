#include "runtime/base/process_list.hpp"

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

/// The name of a process may hold blanks and brackets. No pid: it is gone.
ProcessStat read_stat(const fs::path& process) {
  ProcessStat found;
  std::ifstream stream(process / "stat");
  std::string text;
  std::getline(stream, text);
  const size_t name = text.find('('), name_end = text.rfind(')');
  if (name == std::string::npos || name_end == std::string::npos || name_end + 4 >= text.size()) return found;
  found.name = text.substr(name + 1, name_end - name - 1);
  found.state = text[name_end + 2];
  char* next = nullptr;
  std::strtol(text.c_str() + name_end + 4, &next, 10);  // the parent
  found.group = static_cast<pid_t>(std::strtol(next, nullptr, 10));
  found.pid = static_cast<pid_t>(std::strtol(text.c_str(), nullptr, 10));
  return found;
}

bool has_setting(pid_t pid, const std::string& setting) {
  std::ifstream stream("/proc/" + std::to_string(pid) + "/environ", std::ios::binary);
  std::string text(1, '\0');
  text.append(std::istreambuf_iterator<char>(stream), {});
  return text.find('\0' + setting + '\0') != std::string::npos;
}

std::vector<ProcessStat> find_left(pid_t leader, const std::string& setting) {
  std::vector<ProcessStat> left;
  for (const ProcessStat& process : running_processes()) {
    if (process.pid == leader || process.state == 'Z' || process.state == 'X') continue;
    if (process.group == leader || has_setting(process.pid, setting)) left.push_back(process);
  }
  return left;
}

}  // namespace

ProcessStat process_stat(pid_t process) { return read_stat("/proc/" + std::to_string(process)); }

std::vector<ProcessStat> running_processes() {
  std::vector<ProcessStat> found;
  std::error_code error;
  for (fs::directory_iterator entry("/proc", error), end; !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (name.find_first_not_of("0123456789") != std::string::npos) continue;
    if (ProcessStat process = read_stat(entry->path()); process.pid > 0) found.push_back(std::move(process));
  }
  return found;
}

std::string left_running(pid_t leader, const std::string& setting) {
  std::vector<ProcessStat> left = find_left(leader, setting);
  std::sort(left.begin(), left.end(), [](const ProcessStat& a, const ProcessStat& b) { return a.pid < b.pid; });
  std::string text;
  for (size_t i = 0; i < std::min<size_t>(left.size(), 3); ++i)
    text += (i ? ", '" : "'") + left[i].name + "' (process " + std::to_string(left[i].pid) + ")";
  return left.size() > 3 ? text + " and " + std::to_string(left.size() - 3) + " more" : text;
}

void kill_left_running(pid_t leader, const std::string& setting) {
  for (const ProcessStat& process : find_left(leader, setting)) kill(process.pid, SIGKILL);
}

}  // namespace plumbline::runtime

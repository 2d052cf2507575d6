#include "served_runs.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <set>

#include "commands.hpp"
#include "live_progress.hpp"
#include "runtime/record/record.hpp"

namespace plumbline::cli {

namespace fs = std::filesystem;

namespace {

constexpr size_t most_runs = 2000, longest_text = 64 * 1024, piece = 1 << 20, longest_line = 64 << 20;
constexpr int deepest = 3;

std::string joined(const std::string& folder, const std::string& name) {
  return folder == "." ? name : folder + "/" + name;
}

/// The parts of a relative path; none if one of them is empty, hidden, "." or "..".
std::vector<std::string> parts_of(const std::string& path) {
  std::vector<std::string> parts;
  for (size_t at = 0; at <= path.size();) {
    const size_t end = std::min(path.find('/', at), path.size());
    parts.push_back(path.substr(at, end - at));
    if (parts.back().empty() || parts.back()[0] == '.') return {};
    at = end + 1;
  }
  return parts;
}

/// The file below `folder`, no part of its path being a link; -1 if there is none.
int open_below(int folder, const std::vector<std::string>& parts, int flags) {
  int at = fcntl(folder, F_DUPFD_CLOEXEC, 0);
  for (size_t i = 0; i < parts.size() && at >= 0; ++i) {
    const bool last = i + 1 == parts.size();
    const int next = openat(at, parts[i].c_str(), O_NOFOLLOW | O_CLOEXEC | (last ? flags : O_PATH | O_DIRECTORY));
    ::close(at);
    at = next;
  }
  return at;
}

/// What the nodes say that ran to the end, of one that ran in rounds the last: an earlier one is no result of the run.
bool is_invalid(const std::vector<const nlohmann::ordered_json*>& nodes) {
  std::map<std::string, bool> last;
  for (const auto* node : nodes) {
    bool& invalid = last[node->value("name", "")] = false;
    for (const auto& metric : node->value("metrics", nlohmann::ordered_json::array()))
      invalid = invalid || (metric.value("name", "") == "invalid" && metric.contains("value") &&
                            metric["value"].is_number() && metric["value"].get<double>() > 0);
  }
  return std::any_of(last.begin(), last.end(), [](const auto& one) { return one.second; });
}

/// What is known of a run whose record has no end. A process is told by its number on its own machine only, and until
/// that is started anew.
std::string state_without_end(const nlohmann::ordered_json& start) {
  const nlohmann::ordered_json host = start.value("host", nlohmann::ordered_json::object());
  utsname here{};
  uname(&here);
  const std::string name = host.value("name", here.nodename), boot = host.value("boot", "");
  if (name != here.nodename) return "no end in its record, from " + name;
  const int process = start.value("process", 0);
  const bool alive =
      process > 0 && (boot.empty() || boot == runtime::boot_id()) && (kill(process, 0) == 0 || errno == EPERM);
  return alive ? "running" : "ended without a word";
}

}  // namespace

std::string ServedRuns::name_of(const Json& node) {
  const int round = node.value("round", 0);
  return node.value("name", "") + (round > 0 ? "@" + std::to_string(round) : "");
}

ServedRuns::ServedRuns(const fs::path& folder)
    : folder_(folder), descriptor_(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC)) {
  if (descriptor_ < 0)
    throw UsageError(folder.string() + " is no folder that can be shown: " + std::strerror(errno) +
                     "; give the output folder of a run, or one that holds several, such as out");
}

ServedRuns::~ServedRuns() { ::close(descriptor_); }

ServedRuns::File ServedRuns::open(const std::string& path) const {
  const auto parts = parts_of(path);
  if (parts.empty()) return {};
  // O_NONBLOCK: a pipe that somebody put there must not hold us up.
  const int file = open_below(descriptor_, parts, O_RDONLY | O_NONBLOCK);
  struct stat info {};
  if (file >= 0 && fstat(file, &info) == 0 && S_ISREG(info.st_mode))
    return {file, static_cast<std::uint64_t>(info.st_size)};
  if (file >= 0) ::close(file);
  return {};
}

/// Folders with a run.jsonl; `folder` is taken over.
void ServedRuns::find(int folder, const std::string& path, int depth) {
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(fdopendir(folder), closedir);
  if (!entries) {
    ::close(folder);
    return;
  }
  std::set<std::string> folders;
  while (const dirent* entry = readdir(entries.get())) {
    struct stat info {};
    if (fstatat(folder, entry->d_name, &info, AT_SYMLINK_NOFOLLOW) != 0) continue;
    const std::string name = entry->d_name;
    if (name == "run.jsonl" && S_ISREG(info.st_mode)) found_.push_back(path);
    if (S_ISDIR(info.st_mode) && name[0] != '.' && depth < deepest) folders.insert(name);
  }
  for (const std::string& name : folders) {
    if (found_.size() >= most_runs) return;
    const int below = openat(folder, name.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (below >= 0) find(below, joined(path, name), depth + 1);
  }
}

void ServedRuns::take(const std::string& line, Run& run) {
  Json json = Json::parse(line, nullptr, false);
  if (!json.is_object()) {
    ++run.lines_not_read;
    return;
  }
  const std::string event = json.value("event", "");
  if (event == "run_start") {
    run.start = std::move(json);
  } else if (event == "run_end" || event == "killed") {
    json.erase("owned");
    run.end = std::move(json);
  } else if (event == "node") {
    for (const char* large : {"fields", "keys", "used", "inputs", "computed", "parameters", "connections"})
      json.erase(large);
    const std::string name = name_of(json);
    if (!run.nodes.count(name)) run.order.push_back(name);
    run.nodes[name] = std::move(json);
  }
}

/// Takes what was added to the record since the last look. Another file at its place begins anew.
void ServedRuns::follow(const std::string& id) {
  Run& run = runs_[id];
  const File record = open(joined(id, "run.jsonl"));
  struct stat info {};
  if (record.descriptor < 0 || fstat(record.descriptor, &info) != 0) {
    run = {};
    if (record.descriptor >= 0) ::close(record.descriptor);
    return;
  }
  if (info.st_dev != run.device || info.st_ino != run.inode || record.size < run.read) {
    run = {};
    run.device = info.st_dev, run.inode = info.st_ino;
  }
  take_lines(record, run);
  ::close(record.descriptor);
}

/// In pieces: a file of that name may be of any size, and have no line in it.
void ServedRuns::take_lines(const File& record, Run& run) {
  std::string text;
  while (run.read + text.size() < record.size && text.size() < longest_line) {
    const size_t had = text.size();
    text.resize(had + std::min<std::uint64_t>(piece, record.size - run.read - had));
    const ssize_t count =
        pread(record.descriptor, text.data() + had, text.size() - had, static_cast<off_t>(run.read + had));
    text.resize(had + static_cast<size_t>(std::max<ssize_t>(count, 0)));
    if (count <= 0) return;
    size_t at = 0;
    for (size_t end = text.find('\n', had); end != std::string::npos; end = text.find('\n', at)) {
      try {
        take(text.substr(at, end - at), run);
      } catch (const Json::exception&) {
        ++run.lines_not_read;
      }
      at = end + 1;
    }
    run.read += at;  // a line that is just being written is taken when it is whole
    text.erase(0, at);
  }
}

/// A folder that was deleted and made again, or exchanged, is another one under its name: that is meant.
void ServedRuns::reopen() const {
  const int now = ::open(folder_.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC);
  struct stat had {
  }, has{};
  if (now < 0) return;
  const bool same =
      fstat(descriptor_, &had) == 0 && fstat(now, &has) == 0 && had.st_dev == has.st_dev && had.st_ino == has.st_ino;
  if (!same) dup3(now, descriptor_, O_CLOEXEC);  // in one step: others open files below it meanwhile
  ::close(now);
}

void ServedRuns::look() {
  reopen();
  found_.clear();
  const int top = openat(descriptor_, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (top >= 0) find(top, ".", 0);
  for (const std::string& id : found_) follow(id);
  std::erase_if(runs_, [&](const auto& run) {
    return std::find(found_.begin(), found_.end(), run.first) == found_.end() || run.second.start.is_null();
  });
}

std::string ServedRuns::text_of(const std::string& path, size_t most) const {
  const File file = open(path);
  if (file.descriptor < 0) return {};
  std::string text(std::min<std::uint64_t>(file.size, most), '\0');
  const ssize_t count = pread(file.descriptor, text.data(), text.size(), 0);
  ::close(file.descriptor);
  text.resize(std::max<ssize_t>(count, 0));
  return text;
}

ServedRuns::Json ServedRuns::progress(const std::string& id) const {
  const auto parts = id == "." ? std::vector<std::string>{} : parts_of(id);
  std::vector<std::string> path = parts;
  path.emplace_back(LiveProgress::file_name);
  const int file = open_below(descriptor_, path, O_RDONLY | O_NONBLOCK);
  if (file < 0) return nullptr;
  std::string text(longest_text, '\0');
  const ssize_t count = pread(file, text.data(), text.size(), 0);
  ::close(file);
  text.resize(std::max<ssize_t>(count, 0));
  const Json json = Json::parse(text, nullptr, false);
  return json.is_object() ? json : Json(nullptr);
}

ServedRuns::Json ServedRuns::summary(const std::string& id, const Run& run) const {
  Json json{{"id", id}};
  json["pipeline"] = fs::path(run.start.value("pipeline", "")).stem().string();
  json["arguments"] = run.start.value("arguments", Json::array());
  json["time"] = run.start.value("time", "");
  size_t warnings = 0;
  std::string error;
  std::vector<const Json*> nodes;
  for (const std::string& name : run.order) {
    const Json& node = run.nodes.at(name);
    const std::string status = node.value("status", "");
    if (status == "failed" && error.empty()) error = node.value("error", "");
    warnings += node.value("warnings", Json::array()).size();
    nodes.push_back(&node);
  }
  const bool says_so = run.end.is_object() && run.end.contains("usable");
  const bool invalid = says_so ? !run.end.value("usable", true) : is_invalid(nodes);
  json["ended"] = run.nodes.size();
  json["warnings"] = warnings;
  json["invalid"] = invalid;
  if (!error.empty()) json["error"] = error;
  if (run.end.is_null()) {
    json["status"] = state_without_end(run.start);
    json["seconds"] = nullptr;
    json["start"] = run.start.value("start", 0.0);
    if (json["status"] == "running") json["progress"] = progress(id);
  } else if (run.end.value("event", "") == "killed") {
    json["status"] = "killed: " + run.end.value("by", "");
  } else {
    const std::string status = run.end.value("status", "");
    json["status"] = status == "ok" && invalid ? "not usable" : status;
    json["seconds"] = run.end.value("seconds", 0.0);
  }
  json["files"] = Json::array();
  const Json outputs = run.end.is_object() ? run.end.value("outputs", Json::object()) : Json::object();
  for (const auto& [file, how] : outputs.items())
    if (how == "written") json["files"].push_back(file);
  return json;
}

ServedRuns::Json ServedRuns::list() {
  const std::scoped_lock lock(mutex_);
  look();
  std::vector<Json> all;
  for (const auto& [id, run] : runs_) {
    try {
      all.push_back(summary(id, run));
    } catch (const Json::exception&) {  // a record that is none of ours must not hide the others
      all.push_back({{"id", id}, {"pipeline", id}, {"time", ""}, {"status", "its record cannot be read"}});
    }
  }
  std::sort(all.begin(), all.end(), [](const Json& a, const Json& b) { return a["time"] > b["time"]; });
  return all;
}

ServedRuns::Json ServedRuns::run(const std::string& id) {
  const std::scoped_lock lock(mutex_);
  const auto found = runs_.find(id);
  if (found == runs_.end()) return nullptr;
  follow(id);
  const Run& run = found->second;
  if (run.start.is_null()) return nullptr;  // it was deleted since the last look
  Json json = summary(id, run);
  json["host"] = run.start.value("host", Json::object()).value("name", "");
  json["plumbline"] = run.start.value("plumbline", "");
  json["nodes"] = Json::array();
  for (const std::string& name : run.order) json["nodes"].push_back(run.nodes.at(name));
  for (const char* words : {"verdict.txt", "summary.txt", "next.txt"})
    if (const std::string text = text_of(joined(id, words), longest_text); !text.empty()) {
      json["words"] = text;
      break;
    }
  return json;
}

fs::path ServedRuns::record(const std::string& id) {
  const std::scoped_lock lock(mutex_);
  if (!runs_.count(id)) return {};
  follow(id);
  return runs_[id].start.is_null() ? fs::path() : folder_ / id / "run.jsonl";
}

}  // namespace plumbline::cli

#include "runtime/plugins/executable_node.hpp"

#include <fmt/core.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <thread>

#include "artifacts/file.hpp"
#include "runtime/base/child_process.hpp"
#include "runtime/base/group_memory.hpp"
#include "runtime/base/process_list.hpp"
#include "runtime/plugins/artifact_type.hpp"
#include "runtime/plugins/library.hpp"
#include "runtime/plugins/plugin_check.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;
using Clock = std::chrono::steady_clock;

namespace {

/// The folder of one run; gone with it.
class Exchange {
 public:
  Exchange(const ExecutableNode& node, const plumbline_host& host, const plumbline_node& entry)
      : node_(node), host_(host), entry_(entry) {
    std::string name = (fs::temp_directory_path() / "plumbline-node-XXXXXX").string();
    if (!mkdtemp(name.data())) throw std::runtime_error("cannot make " + name + ": " + std::strerror(errno));
    folder_ = name;
  }
  ~Exchange() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  Exchange(const Exchange&) = delete;
  Exchange& operator=(const Exchange&) = delete;

  const fs::path& folder() const { return folder_; }

  void write() {
    Json call{{"kind", entry_.kind}};
    call["parameters"] = Json::object();
    for (uint32_t i = 0; i < entry_.param_count; ++i)
      call["parameters"][entry_.params[i]->name] = value_of(*entry_.params[i]);
    if (node_.wants_seed) call["seed"] = host_.seed(host_.context);
    const plumbline_plugin_table& table = node_.table->table();
    for (uint32_t i = 0; i < table.type_count; ++i) {
      std::string name = table.types[i]->name;
      std::replace(name.begin(), name.end(), '/', '-');
      write_file(folder_ / "schemas" / (name + ".bfbs"), table.types[i]->schema);
    }
    references_ = Json::object();
    for (uint32_t i = 0; i < entry_.input_count; ++i) write_input(*entry_.inputs[i]);
    call["references"] = references_;
    fs::create_directories(folder_ / "outputs");  // a node may give metrics alone
    for (uint32_t i = 0; i < entry_.output_count; ++i)
      fs::create_directories(folder_ / "outputs" / entry_.outputs[i]->name);
    const std::string text = call.dump(1);
    write_file(folder_ / "call.json", {text.data(), text.size()});
  }

  /// What it says it used, beside what the manifest names.
  std::vector<std::string> used() const {
    std::vector<std::string> paths;
    std::error_code failed;
    if (!fs::is_regular_file(fs::symlink_status(folder_ / "used", failed))) return paths;
    if (fs::file_size(folder_ / "used") > largest_list)
      throw std::runtime_error("its list of used files is longer than " + mebibytes_text(largest_list));
    std::istringstream lines(content_of(folder_ / "used"));
    for (std::string line; std::getline(lines, line);) {
      const auto& files = node_.files;
      if (!line.empty() && std::find(files.begin(), files.end(), fs::path(line)) == files.end()) paths.push_back(line);
    }
    std::sort(paths.begin(), paths.end());
    paths.erase(std::unique(paths.begin(), paths.end()), paths.end());
    return paths;
  }

  /// Returns what the host has to say against them, or "" if it took all.
  std::string take_outputs() {
    for (const fs::path& port : sorted_entries(folder_ / "outputs")) {
      const std::string name = port.filename().string();
      if (!fs::is_directory(fs::symlink_status(port)))
        return "it wrote outputs/" + name + ", which is no folder of an output; write outputs/PORT/000000";
      for (const fs::path& file : sorted_entries(port)) {
        const std::string where = "its output file outputs/" + name + "/" + file.filename().string();
        if (!fs::is_regular_file(fs::symlink_status(file))) return where + " is no plain file";
        const std::string bytes = content_of(file);
        if (host_.commit(host_.context, name.c_str(), bytes.data(), bytes.size())) return where + " was refused";
      }
    }
    return "";
  }

  /// metrics.json, {"NAME": [VALUE, "UNIT"], …}, if it wrote one. Returns what is wrong with it, or "".
  std::string take_metrics() {
    const fs::path file = folder_ / "metrics.json";
    if (!fs::exists(fs::symlink_status(file))) return "";
    if (!fs::is_regular_file(fs::symlink_status(file))) return "its metrics.json is no plain file";
    const Json metrics = Json::parse(content_of(file), nullptr, false);
    if (metrics.is_discarded())
      return "its metrics.json is no JSON, which has no NaN and no Infinity: write null for a number that is not known";
    if (!metrics.is_object()) return "its metrics.json is no map {\"NAME\": [VALUE, \"UNIT\"], ...}";
    for (const auto& [name, metric] : metrics.items()) {
      const bool pair = metric.is_array() && metric.size() == 2 && metric[1].is_string();
      if (!pair || !(metric[0].is_number() || metric[0].is_null()))
        return "the metric '" + name + "' in its metrics.json is no [VALUE, \"UNIT\"], such as [0.001, \"m\"]; found " +
               metric.dump();
      const double value = metric[0].is_null() ? std::numeric_limits<double>::quiet_NaN() : metric[0].get<double>();
      host_.metric(host_.context, name.c_str(), value, metric[1].get<std::string>().c_str());
    }
    return "";
  }

 private:
  static constexpr uint64_t largest_list = uint64_t{16} << 20;

  static std::vector<fs::path> sorted_entries(const fs::path& folder) {
    std::vector<fs::path> entries;
    for (const auto& entry : fs::directory_iterator(folder)) entries.push_back(entry.path());
    std::sort(entries.begin(), entries.end());
    return entries;
  }

  static std::string content_of(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    std::string bytes(static_cast<size_t>(fs::file_size(file)), '\0');
    stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    if (!stream) throw std::runtime_error("cannot read " + file.string() + ": " + std::strerror(errno));
    return bytes;
  }

  static void write_file(const fs::path& path, plumbline_bytes bytes) {
    fs::create_directories(path.parent_path());
    std::ofstream stream(path, std::ios::binary);
    stream.write(static_cast<const char*>(bytes.data), static_cast<std::streamsize>(bytes.size));
    stream.close();
    if (!stream) throw std::runtime_error("cannot write " + path.string() + ": " + std::strerror(errno));
  }

  Json value_of(const plumbline_param& param) const {
    const char* given = host_.parameter(host_.context, param.name);
    const std::string text = given ? given : "";
    if (!param.is_list) return value_of(param, text);
    Json list = Json::array();
    for (size_t at = 0; !text.empty() && at <= text.size();) {
      const size_t end = std::min(text.find('\x1f', at), text.size());
      list.push_back(value_of(param, text.substr(at, end - at)));
      at = end + 1;
    }
    return list;
  }

  static Json value_of(const plumbline_param& param, const std::string& text) {
    if (param.kind == PLUMBLINE_NUMBER) return text == "nan" ? Json() : Json(std::strtod(text.c_str(), nullptr));
    if (param.kind == PLUMBLINE_INTEGER) return std::strtoll(text.c_str(), nullptr, 10);
    if (param.kind == PLUMBLINE_BOOLEAN) return text == "true";
    return text;
  }

  void write_input(const plumbline_port& port) {
    const size_t count = host_.item_count(host_.context, port.name);
    for (size_t i = 0; i < count; ++i) {
      plumbline_bytes bytes{};
      if (host_.get(host_.context, port.name, i, &bytes))
        throw std::runtime_error(std::string("cannot read input '") + port.name + "'");
      const std::string name = fmt::format("{:06}", i);
      write_file(folder_ / "inputs" / port.name / name, bytes);
      const plumbline_type& type = *type_of_port(node_.table->table(), port);
      if (may_name_files(type, bytes)) find_references(Json::parse(artifact_to_json(type, bytes)));
    }
  }

  /// Artifacts that stand for files name them by a field `uri`; a large cloud of points, or the bytes of a file, need
  /// not be searched for it.
  static bool may_name_files(const plumbline_type& type, plumbline_bytes bytes) {
    using namespace std::string_view_literals;
    if (type.name == std::string_view(artifact_traits<File>::name) &&
        flatbuffers::GetRoot<File>(bytes.data)->content()->size() > 0)
      return false;
    return std::string_view(static_cast<const char*>(type.schema.data), type.schema.size).find("\3\0\0\0uri\0"sv) !=
           std::string_view::npos;
  }

  void find_references(const Json& json) {
    if (json.is_object() && json.contains("uri") && json["uri"].is_string()) {
      const auto uri = json["uri"].get<std::string>();
      if (const char* path = uri.empty() ? nullptr : host_.resolve(host_.context, uri.c_str())) references_[uri] = path;
    }
    for (const auto& part : json)
      if (part.is_structured()) find_references(part);
  }

  const ExecutableNode& node_;
  const plumbline_host& host_;
  const plumbline_node& entry_;
  fs::path folder_;
  Json references_;
};

/// Waits for the end. "" or why it is killed.
std::string wait_for(const ChildProcess& child, const plumbline_host& host, const Limits& limits) {
  const auto start = Clock::now();
  const double limit = limits.seconds;
  GroupLimit memory(child.pid, limits.memory);
  while (true) {
    const double used = std::chrono::duration<double>(Clock::now() - start).count();
    if (limit > 0 && used > limit) return lateness_text(limit, child.log);
    const double left = limit > 0 ? 1000 * (limit - used) : 1e9;
    pollfd ending{child.handle, POLLIN, 0};
    if (poll(&ending, 1, static_cast<int>(std::ceil(std::min(100.0, left)))) > 0) return "";
    if (host.cancelled(host.context)) return "it was told to stop";
    if (const std::string problem = memory.broken(); !problem.empty()) return problem + "; " + last_words(child.log);
    shorten_log(child.log);
  }
}

/// Its outputs are whole when nothing that it has started can write them any more. Helpers that end by themselves with
/// the program, as Python's multiprocessing has them, get a moment for it. "" or what goes on.
std::string wait_for_what_it_started(const ChildProcess& child, const std::string& mark, const plumbline_host& host) {
  constexpr auto patience = std::chrono::seconds(2);
  const auto start = Clock::now();
  while (true) {
    const std::string left = left_running(child.pid, mark);
    if (left.empty()) return "";
    if (Clock::now() - start > patience)
      return "it ended while what it had started went on and might still have written its outputs: " + left +
             "; wait for it before the end (in Python: Popen.wait(), Process.join())";
    if (host.cancelled(host.context)) return "it was told to stop";
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

/// What it printed, line by line, into the record.
void tell(const plumbline_host& host, int log) {
  std::istringstream lines(end_of_log(log, size_t{1} << 18));
  int count = 0;
  for (std::string line; std::getline(lines, line) && count < 1000; ++count) {
    const bool warning = line.rfind("warning: ", 0) == 0;
    host.log(host.context, warning ? PLUMBLINE_WARNING : PLUMBLINE_INFO, line.c_str() + (warning ? 9 : 0));
  }
}

/// The first of its files that is not what was hashed when the node was found, as a sentence; empty: none.
std::string changed_file(const ExecutableNode& node) {
  for (const auto& [file, identity] : node.identities)
    if (file_identity(file) != identity)
      return file.string() + " is not the file any more that was looked at; run again";
  return "";
}

std::string run_once(const ExecutableNode& node, const plumbline_host& host, const plumbline_node& entry,
                     const Limits& limits, std::vector<std::string>& used) {
  if (limits.memory && host.reserve_memory(host.context, limits.memory)) return "it was told to stop";
  if (std::string problem = changed_file(node); !problem.empty()) return problem;
  Exchange exchange(node, host, entry);
  exchange.write();
  ChildStart start;
  start.arguments = node.command;
  start.arguments.push_back(exchange.folder().string());
  const char* path = std::getenv("PYTHONPATH");
  const std::string mark = "PLUMBLINE_NODE_RUN=" + exchange.folder().string();
  start.settings = {"PYTHONPATH=" + python_folder().string() + (path && *path ? std::string(":") + path : ""),
                    "PYTHONDONTWRITEBYTECODE=1", mark};
  start.memory_limit = limits.memory;
  start.ends_with_this_thread = true;
  ChildProcess child = start_child(start);
  std::string problem;
  try {
    problem = wait_for(child, host, limits);
    if (problem.empty()) problem = wait_for_what_it_started(child, mark, host);
    if (!problem.empty()) kill_left_running(child.pid, mark);
  } catch (...) {
    kill_left_running(child.pid, mark);
    finish_child(child);
    close(child.log);
    throw;
  }
  const ChildEnd end = finish_child(child);
  if (problem.empty() && (!WIFEXITED(end.status) || WEXITSTATUS(end.status) != 0))
    problem = death_text(end, child.log, limits.memory);
  if (problem.empty()) tell(host, child.log);
  close(child.log);
  if (problem.empty()) problem = changed_file(node);
  if (problem.empty()) problem = exchange.take_metrics();
  if (problem.empty()) used = exchange.used();
  return problem.empty() ? exchange.take_outputs() : problem;
}

}  // namespace

int ExecutableNode::run(const plumbline_host& host, const plumbline_node& entry, const Limits& given,
                        std::vector<std::string>& used) const {
  std::string problem;
  try {
    problem = run_once(
        *this, host, entry,
        {given.seconds > 0 ? given.seconds : limits.seconds, given.memory ? given.memory : limits.memory}, used);
  } catch (const std::exception& error) {
    problem = error.what();
  }
  if (problem.empty()) return 0;
  host.fail(host.context, problem.c_str());
  return 1;
}

fs::path python_folder() {
  std::error_code failed;
  const fs::path self = fs::read_symlink("/proc/self/exe", failed);
  const fs::path installed = self.parent_path().parent_path() / "share" / "plumbline" / "python";
  return fs::is_directory(installed, failed) ? installed : fs::path(PLUMBLINE_SOURCE_PYTHON);
}

}  // namespace plumbline::runtime

#include "runtime/record/run_record.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

template <typename Value>
void take(const Json& json, const char* key, Value& value) {
  if (const auto found = json.find(key); found != json.end() && !found->is_null()) found->get_to(value);
}

RecordedNode node_of(const Json& json) {
  RecordedNode node;
  take(json, "name", node.name);
  take(json, "kind", node.kind);
  take(json, "status", node.status);
  take(json, "error", node.error);
  take(json, "cause", node.cause);
  take(json, "round", node.round);
  take(json, "inputs", node.inputs);
  take(json, "start", node.start);
  take(json, "seconds", node.seconds);
  take(json, "items", node.items);
  take(json, "items_executed", node.items_executed);
  take(json, "fields", node.fields);
  take(json, "why", node.why);
  take(json, "keys", node.keys);
  take(json, "connections", node.connections);
  take(json, "outputs", node.outputs);
  take(json, "types", node.types);
  if (const auto computed = json.find("computed"); computed != json.end()) {
    take(*computed, "first", node.computed.first);
    take(*computed, "last", node.computed.last);
    take(*computed, "seconds", node.computed.seconds);
    take(*computed, "hosts", node.computed.hosts);
    take(*computed, "threads", node.computed.threads);
    take(*computed, "programs", node.computed.programs);
    take(*computed, "plugins", node.computed.plugins);
    take(*computed, "unknown_items", node.computed.unknown);
  }
  if (const auto plugin = json.find("plugin"); plugin != json.end()) {
    take(*plugin, "name", node.plugin);
    take(*plugin, "version", node.plugin_version);
    take(*plugin, "sha256", node.plugin_sha256);
  }
  if (const auto metrics = json.find("metrics"); metrics != json.end())
    for (const Json& metric : *metrics)
      node.metrics.push_back({metric.at("name").get<std::string>(),
                              metric.at("value").is_null() ? std::nan("") : metric.at("value").get<double>(),
                              metric.at("unit").get<std::string>()});
  return node;
}

void start_of(const Json& json, RecordedRun& run) {
  take(json, "plumbline", run.version);
  take(json, "time", run.time);
  take(json, "start", run.start);
  take(json.at("host"), "name", run.host);
  take(json, "pipeline", run.pipeline);
  take(json, "folder", run.folder);
  take(json, "store", run.store);
  take(json, "arguments", run.arguments);
  take(json, "variables", run.variables);
  if (const auto sources = json.find("sources"); sources != json.end())
    for (const Json& source : *sources)
      run.sources.push_back({source.at("path").get<std::string>(), source.at("text").get<std::string>()});
}

void end_of(const Json& json, RecordedRun& run) {
  take(json, "status", run.status);
  take(json, "usable", run.usable);
  take(json, "time", run.end_time);
  take(json, "seconds", run.seconds);
  // What lies in the folder may be of earlier runs, too: this one gave what it says that it wrote.
  std::vector<std::string> written;
  if (const auto outputs = json.find("outputs"); outputs != json.end())
    for (const auto& [output, how] : outputs->items())
      if (how == "written") written.push_back(output);
  const auto is_written = [&](const std::string& path) {
    return std::any_of(written.begin(), written.end(),
                       [&](const std::string& output) { return path == output || path.starts_with(output + "/"); });
  };
  if (const auto owned = json.find("owned"); owned != json.end())
    for (const auto& [path, hashes] : owned->at("files").items())
      if (!hashes.empty() && is_written(path)) run.delivered[path] = hashes.front().get<std::string>();
}

}  // namespace

const RecordedNode* RecordedRun::find(const std::string& name) const {
  for (auto node = nodes.rbegin(); node != nodes.rend(); ++node)
    if (node->name == name) return &*node;
  const size_t at = name.rfind('@');
  const std::string digits = at == std::string::npos ? "" : name.substr(at + 1);
  if (digits.empty() || digits.size() > 9 || digits.find_first_not_of("0123456789") != std::string::npos)
    return nullptr;
  return find(name.substr(0, at), std::stoul(digits));
}

const RecordedNode* RecordedRun::find(const std::string& name, size_t round) const {
  for (const RecordedNode& node : nodes)
    if (node.name == name && node.round == round) return &node;
  return nullptr;
}

RecordedRun read_run(const fs::path& path) {
  RecordedRun run;
  run.file = fs::is_directory(path) ? path / "run.jsonl" : path;
  std::ifstream stream(run.file);
  if (!stream)
    throw NoRunRecord("cannot read the run record " + run.file.string() +
                      ": give the output folder of a run, or the run.jsonl in it");
  bool started = false;
  size_t number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const Json json = Json::parse(line, nullptr, false);
    const std::string event = json.is_object() ? json.value("event", "") : "";
    if (event.empty() && stream.eof() && started) break;  // cut off by a crash
    try {
      if (event == "run_start") {
        start_of(json, run);
        started = true;
      } else if (event == "node") {
        run.nodes.push_back(node_of(json));
      } else if (event == "run_end") {
        end_of(json, run);
      } else if (event == "killed") {
        run.status = "killed: " + json.value("by", "");
      } else if (event.empty()) {
        throw std::runtime_error("no line of a run record");
      }
    } catch (const std::exception& error) {
      throw std::runtime_error(run.file.string() + ":" + std::to_string(number) + ": " + error.what() +
                               "; a record is the run.jsonl that `plumbline run` writes");
    }
  }
  if (!started) throw std::runtime_error(run.file.string() + " is no run record: it has no line run_start");
  if (run.status.empty()) run.status = "killed before its end";
  return run;
}

}  // namespace plumbline::runtime

#include "runtime/record.hpp"

#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "runtime/digest.hpp"
#include "runtime/ownership.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

std::string dump(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

double now() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

std::string utc() {
  const std::time_t time = std::time(nullptr);
  std::tm parts{};
  gmtime_r(&time, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts);
  return text;
}

/// Libraries that choose code by processor may differ in the last bits between machines; the record lets one see it.
std::string cpu_line(const std::string& name) {
  std::ifstream stream("/proc/cpuinfo");
  for (std::string text; std::getline(stream, text);)
    if (text.compare(0, name.size(), name) == 0 && text.find(": ") != std::string::npos)
      return text.substr(text.find(": ") + 2);
  return "";
}

Json parameters_json(const GraphNode& node) {
  Json json = Json::object();
  for (const auto& [name, text] : node.parameters) {
    std::string shown = text;
    for (char& c : shown)
      if (c == '\x1f') c = ',';
    json[name] = shown;
  }
  return json;
}

/// Once for all nodes: what a plugin was, and what it was linked with.
Json plugins_json(const Graph& graph) {
  std::map<std::string, const Plugin*> plugins;
  for (const GraphNode& node : graph.nodes) plugins[node.kind.plugin->identity.name] = node.kind.plugin;
  Json json = Json::array();
  for (const auto& [name, plugin] : plugins)
    json.push_back({{"name", name},
                    {"version", plugin->identity.version},
                    {"licence", plugin->identity.licence},
                    {"path", plugin->identity.path.string()},
                    {"sha256", plugin->sha256},
                    {"build_id", plugin->identity.build_id},
                    {"linked", plugin->linked_build_ids}});
  return json;
}

}  // namespace

Record::Record(OutputFolder& out, const Graph& graph, const RunInfo& info) : out_(out), graph_(graph), start_(now()) {
  utsname host{};
  uname(&host);
  Json json;
  json["event"] = "run_start";
  json["plumbline"] = info.version;
  json["time"] = utc();
  json["start"] = start_;
  json["host"] = {{"name", host.nodename},
                  {"system", std::string(host.sysname) + " " + host.release},
                  {"machine", host.machine},
                  {"cpu", cpu_line("model name")},
                  {"cpus", std::thread::hardware_concurrency()}};
  json["cpu_flags"] = cpu_line("flags");
  json["pipeline"] = graph.file;
  const std::string text = graph.sources.empty() ? "" : graph.sources[0].text;
  json["pipeline_sha256"] = sha256_of(text.data(), text.size());
  std::error_code gone;
  json["folder"] = std::filesystem::current_path(gone).string();
  json["sources"] = Json::array();
  for (const SourceFile& source : graph.sources)
    json["sources"].push_back({{"path", std::filesystem::absolute(source.path).lexically_normal().string()},
                               {"sha256", sha256_of(source.text.data(), source.text.size())},
                               {"text", source.text}});
  json["arguments"] = info.arguments;
  json["variables"] = graph.variables;
  json["seed"] = graph.seed;
  json["store"] = info.store.string();
  json["threads"] = info.threads;
  json["memory_limit"] = info.memory;
  json["plugins"] = plugins_json(graph);
  json["process"] = getpid();
  json["staging"] = out.staging_name();
  json["owned"] = Json::parse(ownership_text(out.owned()));
  out_.begin_record(dump(json));
}

std::string Record::node_line(const GraphNode& node, const NodeResult& result, const Graph* graph) {
  Json json;
  json["event"] = "node";
  json["name"] = node.name;
  json["kind"] = node.kind.node->kind;
  json["at"] = node.at.text();
  json["status"] = to_text(result.status);
  json["items"] = result.items;
  json["items_executed"] = result.items_executed;
  if (result.start > 0) json["start"] = result.start;
  json["seconds"] = result.seconds;
  json["item_seconds"] = result.item_seconds;
  const Plugin& plugin = *node.kind.plugin;
  json["plugin"] = {{"name", plugin.identity.name}, {"version", plugin.identity.version}, {"sha256", plugin.sha256}};
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  json["memory"] = {{"announced", result.memory_announced},
                    {"process_peak", static_cast<uint64_t>(usage.ru_maxrss) * 1024}};
  json["parameters"] = parameters_json(node);
  if (graph && !node.inputs.empty())
    for (const auto& [port, source] : node.inputs)
      json["connections"][port] = graph->nodes[source.node].name + "." + source.port;
  json["fields"] = result.fields;
  if (!result.why.empty()) json["why"] = result.why;
  for (const auto* side : {&result.inputs, &result.outputs}) {
    Json ports = Json::object();
    for (const auto& [port, hashes] : *side) ports[port] = hashes;
    json[side == &result.inputs ? "inputs" : "outputs"] = ports;
  }
  Json types = Json::object();
  for (const auto& [port, hashes] : result.outputs) types[port] = node.kind.output(port)->type;
  json["types"] = types;
  json["keys"] = result.keys;
  if (!result.metrics.empty()) {
    json["metrics"] = Json::array();
    for (const Metric& metric : result.metrics)
      json["metrics"].push_back({{"name", metric.name}, {"value", metric.value}, {"unit", metric.unit}});
  }
  if (!result.warnings.empty()) json["warnings"] = result.warnings;
  if (!result.messages.empty()) json["messages"] = result.messages;
  if (!result.error.empty()) json["error"] = result.error;
  if (!result.cause.empty()) json["cause"] = result.cause;
  return dump(json);
}

void Record::node(const GraphNode& node, const NodeResult& result) { out_.append(node_line(node, result, &graph_)); }

void Record::end(const RunResult& result, const std::vector<Delivery>& deliveries) {
  Json json;
  json["event"] = "run_end";
  json["time"] = utc();
  json["status"] = result.cancelled ? "cancelled" : result.ok() ? "ok" : "failed";
  for (const NodeStatus status :
       {NodeStatus::executed, NodeStatus::reused, NodeStatus::failed, NodeStatus::skipped, NodeStatus::cancelled})
    json[to_text(status)] = result.count(status);
  json["seconds"] = now() - start_;
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  json["peak_memory"] = static_cast<uint64_t>(usage.ru_maxrss) * 1024;
  json["outputs"] = Json::object();
  for (const Delivery& delivery : deliveries)
    json["outputs"][delivery.file] = delivery.problem.empty() ? "written" : delivery.problem;
  json["owned"] = Json::parse(ownership_text(out_.owned()));
  out_.append(dump(json));
}

}  // namespace plumbline::runtime

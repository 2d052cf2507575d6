#include "runtime/record/record.hpp"

#include <sys/resource.h>
#include <sys/utsname.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "runtime/base/digest.hpp"
#include "runtime/base/json_text.hpp"
#include "runtime/base/running_nodes.hpp"
#include "runtime/record/ownership.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

double now() { return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count(); }

std::string utc(double seconds) {
  const auto time = static_cast<std::time_t>(std::floor(seconds));
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

std::string boot_id() {
  std::ifstream stream("/proc/sys/kernel/random/boot_id");
  std::string id;
  std::getline(stream, id);
  return id;
}

Record::Record(OutputFolder& out, const Graph& graph, const RunInfo& info) : out_(out), graph_(graph), start_(now()) {
  utsname host{};
  uname(&host);
  Json json;
  const std::string time = utc(now());
  out.set_run({time, info.arguments});
  json["event"] = "run_start";
  json["plumbline"] = info.version;
  json["time"] = time;
  json["start"] = start_;
  json["host"] = {{"name", host.nodename},         {"system", std::string(host.sysname) + " " + host.release},
                  {"machine", host.machine},       {"boot", boot_id()},
                  {"cpu", cpu_line("model name")}, {"cpus", std::thread::hardware_concurrency()}};
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
  out_.begin_record(json_line(json));
  name_them_in_record(out_.record_file());
}

Record::~Record() { name_them_in_record(-1); }

namespace {

void write_parameters(JsonText& json, const GraphNode& node) {
  json.name("parameters").open('{');
  for (const auto& [name, text] : node.parameters) {
    if (text.find('\x1f') == std::string::npos) {
      json.field(name, text);
      continue;
    }
    std::string shown = text;
    std::replace(shown.begin(), shown.end(), '\x1f', ',');
    json.field(name, shown);
  }
  json.close('}');
}

void write_ports(JsonText& json, const char* name, const std::map<std::string, Hashes>& ports) {
  json.name(name).open('{');
  for (const auto& [port, hashes] : ports) json.field(port, hashes);
  json.close('}');
}

void write_metrics(JsonText& json, const std::vector<Metric>& metrics) {
  if (metrics.empty()) return;
  json.name("metrics").open('[');
  for (const Metric& metric : metrics)
    json.open('{').field("name", metric.name).field("value", metric.value).field("unit", metric.unit).close('}');
  json.close(']');
}

/// Of a reused result as well: when and where it was computed, which this run has not done.
void write_computed(JsonText& json, const NodeResult::Computed& computed) {
  if (computed.first <= 0) return;
  std::vector<std::string> threads;
  for (const int number : computed.threads) threads.push_back(std::to_string(number));
  const auto list = [](const std::set<std::string>& texts) {
    return std::vector<std::string>(texts.begin(), texts.end());
  };
  json.name("computed").open('{').field("first", utc(computed.first)).field("last", utc(computed.last));
  json.field("seconds", computed.seconds).field("hosts", list(computed.hosts)).field("threads", threads);
  json.field("programs", list(computed.programs)).field("plugins", list(computed.plugins));
  if (computed.unknown > 0) json.field("unknown_items", std::uint64_t{computed.unknown});
  json.close('}');
}

void write_texts(JsonText& json, const NodeResult& result) {
  if (!result.warnings.empty()) json.field("warnings", result.warnings);
  if (!result.messages.empty()) json.field("messages", result.messages);
  if (!result.error.empty()) json.field("error", result.error);
  if (result.status == NodeStatus::failed) json.field("failure", to_text(result.failure));
  if (!result.cause.empty()) json.field("cause", result.cause);
}

std::uint64_t peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace

std::string Record::node_line(const GraphNode& node, const NodeResult& result, bool with_connections) {
  const Plugin& plugin = *node.kind.plugin;
  JsonText json;
  json.open('{').field("event", "node").field("name", node.name).field("kind", node.kind.node->kind);
  if (result.round > 0) json.field("round", std::uint64_t{result.round});
  json.field("at", node.at.text()).field("status", to_text(result.status));
  json.field("items", std::uint64_t{result.items}).field("items_executed", std::uint64_t{result.items_executed});
  if (result.start > 0) json.field("start", result.start);
  json.field("seconds", result.seconds).field("item_seconds", result.item_seconds);
  write_computed(json, result.computed);
  json.name("plugin").open('{').field("name", plugin.identity.name).field("version", plugin.identity.version);
  json.field("sha256", plugin.sha256).close('}');
  json.name("memory").open('{').field("announced", std::uint64_t{result.memory_announced});
  if (result.memory_taken > 0) json.field("taken", std::uint64_t{result.memory_taken});
  json.field("process_peak", peak_memory()).close('}');
  write_parameters(json, node);
  if (with_connections && !node.connections.empty()) {
    json.name("connections").open('{');
    for (const auto& [port, text] : node.connections) json.field(port, text);
    json.close('}');
  }
  json.name("fields").open('{');
  for (const auto& [name, value] : result.fields) json.field(name, value);
  json.close('}');
  if (!result.why.empty()) json.field("why", result.why);
  if (!result.used.empty()) {
    json.name("used").open('{');
    for (const auto& [file, hash] : result.used) json.field(file, hash);
    json.close('}');
  }
  write_ports(json, "inputs", result.inputs);
  write_ports(json, "outputs", result.outputs);
  json.name("types").open('{');
  for (const auto& [port, hashes] : result.outputs) json.field(port, node.kind.output(port)->type);
  json.close('}').field("keys", result.keys);
  write_metrics(json, result.metrics);
  write_texts(json, result);
  return json.close('}').take();
}

void Record::node(const GraphNode& node, const NodeResult& result) { out_.append(node_line(node, result, true)); }

void Record::round(const RoundsEnd& end) {
  Json json{{"event", "round"}, {"round", end.rounds}, {"over", end.over}, {"finished", end.finished}};
  json["condition"] = end.text;
  if (!end.problem.empty()) json["error"] = end.problem;
  out_.append(json_line(json));
}

void Record::end(const RunResult& result, const std::vector<Delivery>& deliveries) {
  Json json;
  json["event"] = "run_end";
  json["time"] = utc(now());
  json["status"] = result.cancelled ? "cancelled" : result.ok() ? "ok" : "failed";
  json["usable"] = result.usable();
  for (const NodeStatus status :
       {NodeStatus::executed, NodeStatus::reused, NodeStatus::failed, NodeStatus::skipped, NodeStatus::cancelled})
    json[to_text(status)] = result.count(status);
  json["seconds"] = now() - start_;
  json["peak_memory"] = peak_memory();
  if (graph_.rounds.most > 0)
    json["rounds"] = {{"number", result.rounds.rounds},
                      {"most", graph_.rounds.most},
                      {"finished", result.rounds.finished},
                      {"condition", result.rounds.text}};
  json["outputs"] = Json::object();
  for (const Delivery& delivery : deliveries)
    json["outputs"][delivery.file] = delivery.problem.empty() ? "written" : delivery.problem;
  json["owned"] = Json::parse(ownership_text(out_.owned()));
  out_.append(json_line(json));
}

}  // namespace plumbline::runtime

// A run record in the formats of others: Chrome's trace events, and RO-Crate 1.1 (https://w3id.org/ro/crate/1.1) with
// the terms of the Process Run Crate profile.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <map>
#include <nlohmann/json.hpp>

#include "runtime/base/digest.hpp"
#include "runtime/record/run_record.hpp"

namespace plumbline::runtime {

namespace {

using Json = nlohmann::ordered_json;

std::string dumped(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

std::string utc_milliseconds(double seconds) {
  const auto whole = static_cast<std::time_t>(std::floor(seconds));
  std::tm parts{};
  gmtime_r(&whole, &parts);
  char text[40];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &parts);
  return fmt::format("{}.{:03}Z", text, static_cast<int>(std::floor((seconds - std::floor(seconds)) * 1000)));
}

Json reference(const std::string& id) { return {{"@id", id}}; }

/// An identifier of RFC 3986: what is no plain character is written as its bytes.
std::string uri_path(const std::string& path) {
  static const std::string plain = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~/";
  std::string text;
  for (const char c : path) {
    if (plain.find(c) != std::string::npos) {
      text += c;
      continue;
    }
    text += fmt::format("%{:02X}", static_cast<unsigned char>(c));
  }
  return text;
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// Whether this run computed it, and if not, who did.
std::string provenance_text(const RecordedNode& node) {
  if (node.status != "executed" && node.status != "reused") return "It gave no result in this run: " + node.status;
  std::string text =
      node.status == "executed" ? "Executed in this run" : "Taken over from an earlier run, not executed in this one";
  const size_t before = node.items - std::min(node.items, node.items_executed);
  if (node.status == "executed" && before > 0)
    text += "; " + std::to_string(before) + " of its " + std::to_string(node.items) + " items were taken over";
  const auto& computed = node.computed;
  if (computed.first.empty()) return text + "; when and where it was computed is not known";
  if (computed.unknown > 0)
    text += "; of " + std::to_string(computed.unknown) + " of its " + std::to_string(node.items) +
            " items it is not known when and where they were computed, the others were";
  return text + (computed.unknown > 0 ? " computed " : ". Computed ") + computed.first +
         (computed.last == computed.first ? "" : " to " + computed.last) + " on " + joined(computed.hosts) + ", " +
         joined(computed.threads) + " threads, plumbline " + joined(computed.programs) + ", plugin " +
         joined(computed.plugins);
}

}  // namespace

std::string chrome_trace(const RecordedRun& run) {
  std::vector<const RecordedNode*> nodes;
  for (const RecordedNode& node : run.nodes)
    if (node.start > 0) nodes.push_back(&node);
  std::sort(nodes.begin(), nodes.end(), [](const auto* a, const auto* b) { return a->start < b->start; });
  Json events = Json::array();
  events.push_back({{"name", "process_name"}, {"ph", "M"}, {"pid", 1}, {"args", {{"name", run.pipeline}}}});
  std::vector<double> free_at;  // by lane
  for (const RecordedNode* node : nodes) {
    size_t lane = 0;
    while (lane < free_at.size() && free_at[lane] > node->start) ++lane;
    if (lane == free_at.size()) free_at.push_back(0);
    free_at[lane] = node->start + node->seconds;
    events.push_back({{"name", label_of(node->name, node->round)},
                      {"cat", node->kind},
                      {"ph", "X"},
                      {"pid", 1},
                      {"tid", lane + 1},
                      {"ts", std::round((node->start - run.start) * 1e6)},
                      {"dur", std::round(node->seconds * 1e6)},
                      {"args",
                       {{"kind", node->kind},
                        {"round", node->round},
                        {"status", node->status},
                        {"items", node->items},
                        {"items_executed", node->items_executed},
                        {"why", node->why}}}});
  }
  // What was taken over took no time in this run: a mark at its beginning, with when it was computed.
  for (const RecordedNode& node : run.nodes)
    if (node.status == "reused")
      events.push_back({{"name", label_of(node.name, node.round) + " (taken over)"},
                        {"cat", node.kind},
                        {"ph", "i"},
                        {"s", "p"},
                        {"pid", 1},
                        {"tid", 0},
                        {"ts", 0},
                        {"args",
                         {{"kind", node.kind},
                          {"status", node.status},
                          {"computed", node.computed.first},
                          {"seconds", node.computed.seconds},
                          {"hosts", node.computed.hosts}}}});
  return dumped({{"displayTimeUnit", "ms"}, {"traceEvents", events}});
}

std::string ro_crate(const RecordedRun& run) {
  Json graph = Json::array();
  graph.push_back({{"@id", "ro-crate-metadata.json"},
                   {"@type", "CreativeWork"},
                   {"conformsTo", reference("https://w3id.org/ro/crate/1.1")},
                   {"about", reference("./")}});
  Json parts = Json::array({reference("run.jsonl")}), mentions = Json::array();
  Json files = Json::array(), actions = Json::array(), programs = Json::array();
  for (const auto& [path, hash] : run.delivered) {
    parts.push_back(reference(uri_path(path)));
    files.push_back({{"@id", uri_path(path)}, {"@type", "File"}, {"name", path}, {"sha256", hash}});
  }
  std::map<std::string, bool> seen;
  for (const RecordedNode& node : run.nodes) {
    const std::string program = "#plugin-" + uri_path(node.plugin) + "-" + node.plugin_sha256.substr(0, 12);
    if (!seen[program])
      programs.push_back({{"@id", program},
                          {"@type", "SoftwareApplication"},
                          {"name", node.plugin},
                          {"softwareVersion", node.plugin_version},
                          {"sha256", node.plugin_sha256}});
    seen[program] = true;
    const std::string id = "#node-" + uri_path(node.name) + (node.round > 1 ? "-" + std::to_string(node.round) : "");
    Json action = {{"@id", id},
                   {"@type", "CreateAction"},
                   {"name", label_of(node.name, node.round) + " (" + node.kind + "): " + node.status},
                   {"instrument", reference(program)},
                   {"actionStatus", node.status == "executed" || node.status == "reused"
                                        ? "http://schema.org/CompletedActionStatus"
                                        : "http://schema.org/FailedActionStatus"}};
    if (!node.error.empty()) action["error"] = node.error;
    if (node.start > 0) {
      action["startTime"] = utc_milliseconds(node.start);
      action["endTime"] = utc_milliseconds(node.start + node.seconds);
    } else if (!node.computed.first.empty()) {  // not in this run: it says so
      action["startTime"] = node.computed.first;
    }
    action["description"] = provenance_text(node);
    const auto artifacts = [&](const std::string& key, const std::map<std::string, Hashes>& ports) {
      for (const auto& [port, hashes] : ports)
        for (const std::string& hash : hashes) action[key].push_back(reference("#artifact-" + hash));
    };
    artifacts("result", node.outputs);
    artifacts("object", node.inputs);
    mentions.push_back(reference(id));
    actions.push_back(action);
    for (const auto& [port, hashes] : node.outputs)
      for (const std::string& hash : hashes) {
        const std::string artifact = "#artifact-" + hash;
        const auto type = node.types.find(port);
        if (!seen[artifact])
          files.push_back({{"@id", artifact},
                           {"@type", "CreativeWork"},
                           {"name", node.name + "." + port},
                           {"additionalType", type == node.types.end() ? "" : type->second},
                           {"sha256", hash}});
        seen[artifact] = true;
      }
  }
  std::string arguments;
  for (const std::string& argument : run.arguments) arguments += (arguments.empty() ? "" : " ") + argument;
  graph.push_back(
      {{"@id", "./"},
       {"@type", "Dataset"},
       {"name", "Run of " + run.pipeline},
       {"description", "plumbline run " + run.pipeline + (arguments.empty() ? "" : " " + arguments) + ": " +
                           run.status + (run.status == "ok" && !run.usable ? ", but not to be used as it is" : "")},
       {"datePublished", run.time},
       {"license", "the owner of the data decides"},
       {"hasPart", parts},
       {"mentions", mentions}});
  graph.push_back(
      {{"@id", "run.jsonl"}, {"@type", "File"}, {"name", "run record"}, {"encodingFormat", "application/jsonl"}});
  for (Json* list : {&files, &programs, &actions})
    for (Json& item : *list) graph.push_back(std::move(item));
  return dumped({{"@context", "https://w3id.org/ro/crate/1.1/context"}, {"@graph", graph}});
}

}  // namespace plumbline::runtime

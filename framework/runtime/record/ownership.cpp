#include "runtime/record/ownership.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "runtime/base/json_text.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

bool is_event(const std::string& line, const char* event) {
  return line.rfind(std::string("{\"event\":\"") + event + "\"", 0) == 0;
}

Ownership parse_ownership(const Json& json) {
  Ownership owned;
  for (const auto& [path, hashes] : json.at("files").items())
    for (const auto& hash : hashes) owned.files[path].insert(hash.get<std::string>());
  for (const auto& [output, from] : json.at("made_from").items()) owned.made_from[output] = from.get<std::string>();
  for (const auto& folder : json.at("folders")) owned.folders.insert(folder.get<std::string>());
  if (json.contains("origins"))
    for (const auto& [output, run] : json.at("origins").items())
      owned.origins[output] = {run.at("time").get<std::string>(), run.at("arguments").get<std::vector<std::string>>()};
  return owned;
}

void add_delivery(const Json& json, Ownership& owned, std::map<std::string, std::string>& displaced) {
  const std::string output = json.at("output").get<std::string>();
  for (const auto& [path, hash] : json.at("files").items()) owned.files[path].insert(hash.get<std::string>());
  for (const auto& folder : json.at("folders")) owned.folders.insert(folder.get<std::string>());
  owned.origins.erase(output);
  owned.made_from.erase(output);  // until its end a run does not say that it is whole
  displaced["old-" + std::to_string(json.at("number").get<size_t>())] = output;
}

}  // namespace

bool read_ownership(const fs::path& record, Ownership& owned, std::string& staging,
                    std::map<std::string, std::string>& displaced) {
  std::ifstream stream(record, std::ios::binary);
  std::string line;
  if (!std::getline(stream, line) || !is_event(line, "run_start")) return false;
  do {
    const bool start = is_event(line, "run_start"), deliver = is_event(line, "deliver");
    if (!start && !deliver && !is_event(line, "run_end")) continue;
    const Json json = Json::parse(line, nullptr, false);
    if (!json.is_object()) {
      if (start) return false;
      continue;
    }
    try {
      if (deliver) {
        add_delivery(json, owned, displaced);
        continue;
      }
      if (start) staging = json.value("staging", "");
      if (json.contains("owned")) owned = parse_ownership(json.at("owned"));
    } catch (const Json::exception&) {  // what cannot be understood proves nothing
    }
  } while (std::getline(stream, line));
  // The name comes from a file: it must not lead anywhere else.
  if (staging.rfind(".plumbline-", 0) != 0 || staging.find('/') != std::string::npos) staging.clear();
  return true;
}

std::string deliver_line(const std::string& output, size_t number, const std::map<std::string, std::string>& files,
                         const std::set<std::string>& folders) {
  Json json;
  json["event"] = "deliver";
  json["output"] = output;
  json["number"] = number;
  json["files"] = Json::object();
  for (const auto& [path, hash] : files) json["files"][path] = hash;
  json["folders"] = folders;
  return json_line(json);
}

std::string ownership_text(const Ownership& owned) {
  Json json;
  json["files"] = Json::object();
  for (const auto& [path, hashes] : owned.files) json["files"][path] = hashes;
  json["made_from"] = owned.made_from;
  json["folders"] = owned.folders;
  json["origins"] = Json::object();
  for (const auto& [output, run] : owned.origins)
    json["origins"][output] = {{"time", run.time}, {"arguments", run.arguments}};
  return json_line(json);
}

std::string record_owner(const fs::path& record) {
  std::ifstream stream(record);
  std::string line;
  std::getline(stream, line);
  const Json json = Json::parse(line, nullptr, false);
  if (!json.is_object() || !json.contains("process") || !json["process"].is_number()) return "";
  try {
    return " (process " + std::to_string(json.at("process").get<long>()) + " on " +
           json.at("host").at("name").get<std::string>() + ", since " + json.at("time").get<std::string>() + ")";
  } catch (const Json::exception&) {
    return "";
  }
}

}  // namespace plumbline::runtime

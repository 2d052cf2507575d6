#include "runtime/sweep/sweep_records.hpp"

#include <unistd.h>

#include <atomic>
#include <cmath>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>

#include "runtime/base/json_text.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

Json result_of(const CellRecord& record) {
  Json json;
  json["status"] = record.failed ? "failed" : "done";
  if (record.failed) json["error"] = record.error, json["failed_node"] = record.failed_node;
  json["metrics"] = Json::object();
  for (const auto& [name, metric] : record.metrics)
    json["metrics"][name] = {{"value", metric.value}, {"unit", metric.unit}};
  json["warnings"] = record.warnings;
  json["inputs"] = record.inputs;
  return json;
}

}  // namespace

std::string CellRecords::result_text(const CellRecord& record) { return json_line(result_of(record)) + "\n"; }

std::optional<CellRecord> CellRecords::find(const std::string& key) const {
  std::ifstream stream(path(key));
  if (!stream) return std::nullopt;
  try {
    const auto json = nlohmann::json::parse(stream);
    const auto& result = json.at("result");
    CellRecord record;
    record.failed = result.at("status") != "done";
    if (record.failed) result.at("error").get_to(record.error), result.at("failed_node").get_to(record.failed_node);
    for (const auto& [name, metric] : result.at("metrics").items())
      record.metrics[name] = {name, metric.at("value").is_null() ? std::nan("") : metric.at("value").get<double>(),
                              metric.at("unit")};
    result.at("warnings").get_to(record.warnings);
    result.at("inputs").get_to(record.inputs);
    json.at("run").at("seconds").get_to(record.seconds);
    json.at("run").at("host").get_to(record.host);
    record.run = json.at("run").value("id", "");
    return record;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

void CellRecords::put(const std::string& key, const CellRecord& record) const {
  Json json;
  json["result"] = result_of(record);
  json["run"] = {{"host", record.host}, {"id", record.run}, {"seconds", record.seconds}};
  const std::string text = json_line(json) + "\n";
  static std::atomic<uint64_t> count = 0;
  char host[65] = "host";
  gethostname(host, sizeof host - 1);
  const fs::path temporary =
      temporary_ / (std::string(host) + "-" + std::to_string(getpid()) + "-cell" + std::to_string(++count));
  const fs::path target = path(key);
  std::error_code error;
  fs::create_directories(target.parent_path(), error);
  {
    std::ofstream stream(temporary, std::ios::binary);
    stream << text;
    stream.close();
    if (!stream) {
      const std::string reason = std::strerror(errno);
      fs::remove(temporary, error);
      throw StoreError("cannot write " + target.string() + ": " + reason + "; check space and rights");
    }
  }
  fs::rename(temporary, target, error);
  if (error) throw StoreError("cannot write " + target.string() + ": " + error.message());
}

}  // namespace plumbline::runtime

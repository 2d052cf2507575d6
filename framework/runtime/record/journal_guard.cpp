#include "runtime/record/journal_guard.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "artifacts/file.hpp"
#include "runtime/base/printable.hpp"
#include "runtime/plugins/artifact_type.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

/// Kind, item, by, at. Not what it made of the item: beside the other reports of a round that may be something else.
using JournalReport = std::vector<std::string>;

std::vector<JournalReport> reports_in(std::istream& stream) {
  std::vector<JournalReport> reports;
  for (std::string text; std::getline(stream, text);) {
    const auto line = nlohmann::json::parse(text, nullptr, false);
    if (!line.is_object()) continue;
    JournalReport report;
    for (const char* key : {"kind", "item", "by", "at"})
      report.push_back(line.contains(key) && line[key].is_string() ? line[key].get<std::string>() : std::string());
    if (!report[2].empty() && !report[3].empty()) reports.push_back(std::move(report));
  }
  return reports;
}

/// The journal that a run gives; empty if it gives none, or does not hold it itself.
std::string journal_of(Store& store, const std::string& hash) {
  const Blob blob = store.get(hash);
  const auto* content = flatbuffers::GetRoot<File>(blob.bytes().data)->content();
  return content ? std::string(content->begin(), content->end()) : std::string();
}

}  // namespace

std::vector<std::string> missing_reports(std::istream& there, std::istream& now) {
  const std::vector<JournalReport> known = reports_in(now);
  const std::set<JournalReport> kept(known.begin(), known.end());
  std::vector<std::string> lost;
  for (const JournalReport& report : reports_in(there))
    if (!kept.contains(report)) lost.push_back(report[1] + " by " + report[2] + " at " + report[3]);
  return lost;
}

std::string lost_reports(const Graph& graph, Store& store, const RunResult& result, const fs::path& out) {
  for (const GraphOutput& output : graph.outputs) {
    if (fs::path(output.file).filename() != "journal.jsonl") continue;
    const auto& outputs = result.nodes[output.from.node].outputs;
    const auto found = outputs.find(output.from.port);
    if (found == outputs.end() || found->second.size() != 1) continue;
    if (std::string(graph.nodes[output.from.node].kind.output(output.from.port)->type) != artifact_traits<File>::name)
      continue;
    std::ifstream there(out / output.file, std::ios::binary);
    std::istringstream now(journal_of(store, found->second[0]));
    const std::vector<std::string> lost = missing_reports(there, now);
    if (lost.empty()) continue;
    constexpr size_t kNamed = 3;
    std::string words;
    for (size_t i = 0; i < std::min(kNamed, lost.size()); ++i) words += (i ? ", " : "") + lost[i];
    if (lost.size() > kNamed) words += " and " + std::to_string(lost.size() - kNamed) + " more";
    return printable((out / output.file).string() + " has " + std::to_string(lost.size()) +
                     (lost.size() > 1 ? " reports" : " report") + " that this run does not have: " + words +
                     ". Nothing was written. Did somebody else run this round? Then give both runs' reports, "
                     "or go on from that run's state; if those reports were wrong, take that file away");
  }
  return {};
}

}  // namespace plumbline::runtime

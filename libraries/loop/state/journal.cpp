#include "loop/state/journal.hpp"

#include <nlohmann/json.hpp>

#include "loop/state/hash.hpp"

namespace plumbline::loop {

std::string journal_start() { return std::string(64, '0'); }

std::string journal_head(const std::vector<std::string>& lines) {
  return lines.empty() ? journal_start() : sha256_hex(lines.back());
}

std::string journal_line(const JournalEntry& entry, const std::string& previous) {
  nlohmann::ordered_json line;
  line["previous"] = previous, line["round"] = entry.round;
  line["item"] = entry.item, line["kind"] = entry.kind, line["from"] = entry.from, line["to"] = entry.to;
  line["by"] = entry.by, line["at"] = entry.at, line["why"] = entry.why, line["rests_on"] = entry.rests_on;
  if (!entry.reason.empty()) line["reason"] = entry.reason;
  if (entry.reported_revision > 0) line["reported_revision"] = entry.reported_revision;
  if (entry.answered_revision > 0) line["answered_revision"] = entry.answered_revision;
  return line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

JournalFault check_journal(const std::vector<std::string>& lines) {
  std::string expected = journal_start();
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const auto line = nlohmann::json::parse(lines[i], nullptr, false);
    if (!line.is_object()) return {i + 1, "is no JSON object"};
    for (const char* key : {"previous", "round", "item", "kind", "from", "to", "by", "at", "why", "rests_on"})
      if (!line.contains(key)) return {i + 1, std::string("lacks '") + key + "'"};
    if (line["previous"] != expected)
      return {i + 1, i == 0 ? "does not begin a journal: lines before it are gone"
                            : "does not follow line " + std::to_string(i) +
                                  ": one of the two was changed, or lines between them are gone"};
    expected = sha256_hex(lines[i]);
  }
  return {};
}

}  // namespace plumbline::loop

#include "loop/exchange/rounds_beside.hpp"

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <stdexcept>

#include "base/text/whole_file.hpp"

namespace plumbline::loop {

namespace fs = std::filesystem;

namespace {

constexpr const char* kJournalFile = "journal.jsonl";
constexpr const char* kFollowersFile = "journal.next";
constexpr const char* kGivenEnd = ".given.jsonl";

/// Of a file that is not there: nothing.
std::string content_of(const fs::path& file) { return fs::is_regular_file(file) ? text::read_whole(file) : ""; }

/// One name of a folder, however it was typed.
fs::path one_name(const fs::path& folder) {
  std::error_code failed;
  fs::path name = fs::weakly_canonical(fs::absolute(folder), failed);
  if (failed) name = fs::absolute(folder).lexically_normal();
  return name.has_filename() ? name : name.parent_path();
}

/// What a journal says of one item: from and to of each of its lines.
struct Change {
  std::string from, to;
  std::size_t line = 0;  ///< of the journal, from 0
  int answered = 0;      ///< JournalEntry::answered_revision
};

std::map<std::string, std::vector<Change>> changes_of(const std::string& journal) {
  std::map<std::string, std::vector<Change>> changes;
  std::istringstream lines(journal);
  std::size_t number = 0;
  for (std::string text; std::getline(lines, text); ++number) {
    const auto line = nlohmann::json::parse(text, nullptr, false);
    if (!line.is_object()) continue;
    changes[line.value("item", "")].push_back(
        {line.value("from", ""), line.value("to", ""), number, line.value("answered_revision", 0)});
  }
  return changes;
}

/// A report, or a person who looked: what is only recalled and released again goes over STALE.
bool answers(const Change& change) {
  const bool was_asked = change.from == "RELEASED" || change.from == "EXECUTING";
  return change.to == "EXECUTED" || change.to == "REJECTED" || (was_asked && change.to == "PLANNED");
}

/// Whether the item was reported since it was given out with `revision`. `since`: lines of the journal by then; npos:
/// not known, then since the release before the last.
bool is_answered(const std::vector<Change>& changes, std::size_t since, int revision) {
  if (since == std::string::npos) {
    since = 0;
    std::vector<std::size_t> releases;
    for (const Change& change : changes)
      if (change.to == "RELEASED") releases.push_back(change.line);
    if (releases.size() > 1) since = releases[releases.size() - 2];
  }
  return std::any_of(changes.begin(), changes.end(), [&](const Change& change) {
    return change.answered == revision || (change.line >= since && answers(change));
  });
}

struct GivenFile {
  fs::path file;
  std::size_t since = std::string::npos;
};

/// Files of the rounds that the one in `folder` goes on from, or that have the same journal.
std::vector<GivenFile> files_beside(const fs::path& folder, const std::string& journal) {
  std::vector<GivenFile> files;
  std::error_code failed;
  std::set<fs::path> names;
  for (const auto& entry : fs::directory_iterator(folder.parent_path(), failed))
    if (entry.is_directory(failed) && one_name(entry.path()) != folder) names.insert(entry.path());
  for (const fs::path& other : names) {
    const std::string theirs = content_of(other / kJournalFile);
    if (theirs.empty() || !journal.starts_with(theirs)) continue;
    const auto lines = static_cast<std::size_t>(std::count(theirs.begin(), theirs.end(), '\n'));
    std::set<fs::path> given;
    for (const auto& entry : fs::directory_iterator(other, failed))
      if (entry.path().string().ends_with(kGivenEnd)) given.insert(entry.path());
    for (const fs::path& file : given) files.push_back({file, lines});
  }
  return files;
}

}  // namespace

std::vector<GivenItem> given_lines(const fs::path& file) {
  std::vector<GivenItem> given;
  std::istringstream lines(content_of(file));
  std::size_t number = 0;
  for (std::string text; std::getline(lines, text);) {
    ++number;
    if (text.empty()) continue;
    const auto line = nlohmann::ordered_json::parse(text, nullptr, false);
    const auto is_text = [&](const char* key) { return line.contains(key) && line[key].is_string(); };
    if (!line.is_object() || !is_text("item") || !is_text("robot") || !line.contains("revision") ||
        !line["revision"].is_number_integer())
      throw std::runtime_error(file.string() + ":" + std::to_string(number) + " is '" + text.substr(0, 60) +
                               "', expected item, revision and robot: which robot has what is not known; mend that "
                               "line, or take it out if no robot had it");
    given.push_back({line["item"].get<std::string>(), line["revision"].get<int>(), line["robot"].get<std::string>(),
                     is_text("order") ? line["order"].get<std::string>() : std::string(), file,
                     line.contains("journal") && line["journal"].is_number_unsigned()
                         ? line["journal"].get<std::size_t>()
                         : std::string::npos});
  }
  return given;
}

std::size_t journal_lines(const fs::path& folder) {
  const std::string journal = content_of(folder / kJournalFile);
  return static_cast<std::size_t>(std::count(journal.begin(), journal.end(), '\n'));
}

fs::path later_round(const fs::path& typed) {
  const fs::path folder = one_name(typed);
  const std::string journal = content_of(folder / kJournalFile);
  std::istringstream lines(journal.empty() ? std::string() : content_of(folder / kFollowersFile));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty()) continue;
    const fs::path next = one_name(folder / line);
    const std::string theirs = content_of(next / kJournalFile);
    if (theirs.size() <= journal.size() || !theirs.starts_with(journal)) continue;
    const fs::path last = later_round(next);  // journals grow from round to round: this ends
    return last.empty() ? next : last;
  }
  return {};
}

std::vector<GivenItem> unanswered(const fs::path& typed, const fs::path& given, const Job& job,
                                  const std::string& robot, const std::string& order) {
  const fs::path folder = typed.empty() ? fs::path() : one_name(typed);
  const std::string journal = typed.empty() ? std::string() : content_of(folder / kJournalFile);
  std::vector<GivenFile> files;
  if (!journal.empty()) files = files_beside(folder, journal);
  if (!given.empty()) files.push_back({given});
  const auto changes = changes_of(journal);
  std::map<std::string, int> asked;
  for (const JobItem& item : job.items) asked[item.id] = item.revision;
  std::vector<GivenItem> held;
  std::set<std::string> named;
  for (const GivenFile& file : files)
    for (const GivenItem& one : given_lines(file.file)) {
      const auto item = asked.find(one.item);
      if (item == asked.end() || (one.robot == robot && (one.order == order || one.order.empty()))) continue;
      // Without a journal nobody knows what was reported of an order before.
      if (one.revision < item->second && journal.empty()) continue;
      const auto known = changes.find(one.item);
      const bool is_over =
          one.revision < item->second && known != changes.end() &&
          is_answered(known->second, file.since != std::string::npos ? file.since : one.since, one.revision);
      if (!is_over && named.insert(one.item).second) held.push_back(one);
    }
  return held;
}

}  // namespace plumbline::loop

#include "runtime/record/journal_guard.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
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

/// What tells a report from others.
struct JournalReport {
  /// Kind, item, by, at. Not what it made of the item: beside the other reports of a round that may be something else.
  std::vector<std::string> done;
  /// Kind, item, by, round, why and what it rests on: what has no date of its own has that of the run, which another
  /// run of the same round has not.
  std::vector<std::string> said;
};

std::vector<JournalReport> reports_in(std::istream& stream) {
  std::vector<JournalReport> reports;
  for (std::string text; std::getline(stream, text);) {
    const auto line = nlohmann::json::parse(text, nullptr, false);
    if (!line.is_object()) continue;
    JournalReport report;
    for (const char* key : {"kind", "item", "by", "at"})
      report.done.push_back(line.contains(key) && line[key].is_string() ? line[key].get<std::string>() : std::string());
    report.said.assign(report.done.begin(), report.done.end() - 1);
    for (const char* key : {"round", "why", "rests_on"})
      report.said.push_back(line.contains(key) ? line[key].dump() : std::string());
    // What the program concluded follows from the reports again.
    const bool is_told = !report.done[2].empty() && report.done[2] != "plumbline";
    if (is_told && !report.done[3].empty()) reports.push_back(std::move(report));
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
  std::set<std::vector<std::string>> done, said;
  for (JournalReport& report : reports_in(now))
    done.insert(std::move(report.done)), said.insert(std::move(report.said));
  std::vector<std::string> lost;
  for (const JournalReport& report : reports_in(there))
    if (!done.contains(report.done) && !said.contains(report.said))
      lost.push_back(report.done[1] + " by " + report.done[2] + " at " + report.done[3]);
  return lost;
}

namespace {

/// A folder by one name, however it was typed: "rounds/2/" is "rounds/2", and a link is where it leads.
fs::path folder_by_name(const fs::path& typed) {
  std::error_code gone;
  fs::path folder = fs::weakly_canonical(fs::absolute(typed), gone);
  if (gone) folder = fs::absolute(typed).lexically_normal();
  return folder.has_filename() ? folder : folder.parent_path();
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

constexpr const char* kJournal = "journal.jsonl";

/// Beside a journal: the folders of the runs that went on from it, one a line, as seen from here.
constexpr const char* kFollowers = "journal.next";

/// What a run that would replace the journal in its own folder would lose.
std::string lost_words(const fs::path& file, const std::string& was, const std::string& now) {
  std::istringstream there(was), new_one(now);
  const std::vector<std::string> lost = missing_reports(there, new_one);
  if (lost.empty()) return {};
  constexpr size_t kNamed = 3;
  std::string words;
  for (size_t i = 0; i < std::min(kNamed, lost.size()); ++i) words += (i ? ", " : "") + lost[i];
  if (lost.size() > kNamed) words += " and " + std::to_string(lost.size() - kNamed) + " more";
  return printable(file.string() + " has " + std::to_string(lost.size()) + (lost.size() > 1 ? " reports" : " report") +
                   " that this run does not have: " + words +
                   ". Nothing was written. Did somebody else run this round? Then give both runs' reports, "
                   "or go on from that run's state; if those reports were wrong, take that file away");
}

/// Another run than that in `but` whose journal goes on from `journal`, the one in `folder`; empty: none.
fs::path other_follower(const fs::path& folder, const std::string& journal, const fs::path& but) {
  std::istringstream lines(text_of(folder / kFollowers));
  for (std::string line; std::getline(lines, line);) {
    const fs::path other = folder_by_name(folder / line);
    if (line.empty() || other == but) continue;
    const std::string theirs = text_of(other / kJournal);
    if (theirs.size() > journal.size() && theirs.starts_with(journal)) return other;
  }
  return {};
}

/// Folders with a journal beside a file that the run read.
std::set<fs::path> folders_read_from(const Graph& graph) {
  std::set<fs::path> folders;
  for (const GraphNode& node : graph.nodes)
    for (const auto& [name, text] : node.parameters) {
      const plumbline_param* param = node.kind.param(name);
      if (!param || param->kind != PLUMBLINE_FILE || text.empty()) continue;
      std::istringstream list(text);
      for (std::string file; std::getline(list, file, '\x1f');) {  // as lists are kept (GraphNode::parameters)
        std::error_code gone;
        const fs::path folder = folder_by_name(fs::absolute(fs::path(file)).parent_path());
        if (!file.empty() && fs::is_regular_file(folder / kJournal, gone)) folders.insert(folder);
      }
    }
  return folders;
}

/// Whether somebody reported something: a journal of a simulation may be made as often as one likes.
bool is_of_a_site(const std::string& journal) {
  for (std::istringstream lines(journal); lines.good();) {
    std::string text;
    std::getline(lines, text);
    const auto line = nlohmann::json::parse(text, nullptr, false);
    if (line.is_object() && line.value("at", "") != "") return true;
  }
  return false;
}

}  // namespace

JournalGuard::JournalGuard(const Graph& graph, Store& store, const RunResult& result, fs::path out)
    : out_(folder_by_name(out)) {
  for (const GraphOutput& output : graph.outputs) {
    if (fs::path(output.file).filename() != kJournal) continue;
    const auto& outputs = result.nodes[output.from.node].outputs;
    const auto found = outputs.find(output.from.port);
    if (found == outputs.end() || found->second.size() != 1) continue;
    if (std::string(graph.nodes[output.from.node].kind.output(output.from.port)->type) != artifact_traits<File>::name)
      continue;
    const std::string now = journal_of(store, found->second[0]), there = text_of(out_ / output.file);
    refusal_ = lost_words(out / output.file, there, now);
    if (!refusal_.empty() || !is_of_a_site(now)) return;
    const fs::path folder = folder_by_name((out_ / output.file).parent_path());
    if (const fs::path next = other_follower(folder, there, {}); !there.empty() && there != now && !next.empty()) {
      refusal_ = printable((out / output.file).string() + " is what " + (next / kJournal).string() +
                           " goes on from, and this run gives another one. Nothing was written. Go on from that "
                           "round's state; if it is to count for nothing, take its folder away");
      return;
    }
    // Jobs of older rounds may be read beside it, with reports that came late: the nearest round is gone on from.
    fs::path nearest;
    std::size_t longest = 0;
    for (const fs::path& before : folders_read_from(graph)) {
      const std::string journal = before == folder ? std::string() : text_of(before / kJournal);
      if (journal.size() > longest && now.starts_with(journal)) nearest = before, longest = journal.size();
    }
    if (longest > 0) follow(nearest, now);
  }
}

/// `other`: the run that went on from `before` already; empty: none.
void JournalGuard::refuse_another(const fs::path& before, const fs::path& other) {
  if (other.empty()) return;
  refusal_ = printable("a round was already run on this state: " + (other / kJournal).string() + " goes on from " +
                       (before / kJournal).string() +
                       ". Nothing was written: there would be two jobs for the same items, and neither had what was "
                       "reported to the other. Run this round into " +
                       other.string() + " with both runs' reports, or go on from " + (other / "state.json").string() +
                       "; if that run is to count for nothing, take its folder away");
}

/// Two runs on one state would be two jobs for the same items, and each would lack what was reported to the other.
void JournalGuard::follow(const fs::path& before, const std::string& now) {
  const std::string journal = text_of(before / kJournal);
  if (journal.empty() || !now.starts_with(journal)) return;
  const fs::path note = before / kFollowers;
  const int file = ::open(note.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  const int failed = errno;
  if (file < 0 && (failed == EACCES || failed == EROFS || failed == EPERM)) {
    refuse_another(before, other_follower(before, journal, out_));
    warning_ = printable(note.string() + " cannot be written (" + std::strerror(failed) +
                         "): a second run on this state would not be noticed");
    return;
  }
  if (file < 0) {
    refusal_ = printable("cannot write " + note.string() + " (" + std::strerror(failed) +
                         "): without it a second run on this state would not be noticed. Nothing was written. Copy " +
                         before.string() + " to where you may write, and go on from there");
    return;
  }
  locks_.push_back(file);
  while (::flock(file, LOCK_EX) != 0 && errno == EINTR) {
  }
  refuse_another(before, other_follower(before, journal, out_));
  if (!refusal_.empty()) return;
  const std::string line = out_.lexically_relative(before).string() + "\n";
  std::istringstream known(text_of(note));
  for (std::string there; std::getline(known, there);)
    if (there + "\n" == line) return;
  if (::write(file, line.data(), line.size()) != static_cast<ssize_t>(line.size()))
    refusal_ = printable("cannot write " + note.string() + ": " + std::strerror(errno) + ". Nothing was written");
}

JournalGuard::~JournalGuard() {
  for (const int lock : locks_) ::close(lock);
}

}  // namespace plumbline::runtime

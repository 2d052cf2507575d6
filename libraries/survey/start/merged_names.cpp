#include "survey/start/merged_names.hpp"

#include <algorithm>
#include <set>

#include "base/text/words.hpp"
#include "survey/model/station_identity.hpp"
#include "survey/start/reused_names.hpp"

namespace plumbline::survey {

namespace {

constexpr double kSameMark = 0.01;                  // [m]
constexpr const char* kInvented = "free-station-";  // SurveyBuilder::start_unnamed_set_up
constexpr size_t kMostNamedPoints = 8;

/// "monday" of "survey/monday.gsi": short enough to stand in front of a point's name.
std::string stem(const std::string& file) {
  const std::string name =
      file.substr(file.find_last_of("/\\") == std::string::npos ? 0 : file.find_last_of("/\\") + 1);
  const size_t dot = name.rfind('.');
  return dot == std::string::npos || dot == 0 ? name : name.substr(0, dot);
}

}  // namespace

MergedNames::MergedNames(const std::vector<SurveyObservations>& surveys, const MergeOptions& options)
    : surveys_(surveys), options_(options) {
  std::set<std::string> used;
  for (size_t i = 0; i < surveys_.size(); ++i) {
    const std::string base = surveys_[i].files.empty() ? "file " + std::to_string(i + 1) : stem(surveys_[i].files[0]);
    std::string name = base;
    for (int k = 2; !used.insert(name).second; ++k) name = base + "-" + std::to_string(k);
    files_.push_back(name);
  }
  renamed_.resize(surveys_.size());
  decide_stations();
  decide_targets();
}

std::string MergedNames::of(size_t file, const std::string& id) const {
  const auto at = renamed_[file].find(id);
  return at == renamed_[file].end() ? id : at->second;
}

StationEvidence MergedNames::evidence(const std::string& station, size_t a, size_t b) const {
  const auto contains = [](const std::vector<std::string>& list, const std::string& id) {
    return std::find(list.begin(), list.end(), id) != list.end();
  };
  if (contains(options_.same_stations, station) || contains(options_.same_stations, "*"))
    return {true, "you say that it is the same mark"};
  if (station.starts_with(kInvented)) return {false, "their files do not name them"};
  const StationEvidence seen = compare_figures(surveys_[a], surveys_[b], station);
  if (seen.decided) return seen;
  if (contains(options_.known, station)) return {true, "it is a known point"};
  return compare_marks(surveys_[a], surveys_[b], station);
}

void MergedNames::decide_station(const std::string& station, const std::vector<size_t>& files) {
  // Files whose mark is shown to be the same as that of an earlier one share its name.
  std::vector<std::vector<size_t>> groups;
  std::vector<std::string> reasons;
  std::string doubt;
  for (const size_t file : files) {
    bool placed = false;
    for (size_t g = 0; g < groups.size() && !placed; ++g)
      for (const size_t other : groups[g]) {
        const StationEvidence found = evidence(station, other, file);
        if (!found.same) {
          doubt = found.reason;
          continue;
        }
        groups[g].push_back(file);
        reasons[g] = found.reason;
        placed = true;
        break;
      }
    if (placed) continue;
    groups.push_back({file});
    reasons.emplace_back();
  }
  const auto names = [&](const std::vector<size_t>& group) {
    std::vector<std::string> list;
    for (const size_t file : group) list.push_back(files_[file]);
    return text::join(list, kMostNamedPoints);
  };
  for (size_t g = 0; g < groups.size(); ++g)
    if (groups[g].size() > 1)
      find(Finding::Severity::warning,
           "station " + station + " of " + names(groups[g]) + " was united to one point: " + reasons[g] +
               ". If these are two marks, give one another name",
           {station});
  if (groups.size() < 2) return;
  std::vector<std::string> now;
  for (const auto& group : groups) {
    const std::string name = files_[group.front()] + ":" + station;
    now.push_back(name);
    for (const size_t file : group) renamed_[file][station] = name;
  }
  find(Finding::Severity::warning,
       "station " + station + " is occupied in " + names(files) + ", and nothing shows that it is the same mark (" +
           doubt + "): they are points of their own, " + text::join(now, kMostNamedPoints) +
           (station.starts_with(kInvented) ? "" : "; if it is one mark, name it in same_stations"),
       now);
}

void MergedNames::decide_stations() {
  std::map<std::string, std::vector<size_t>> occupied;
  std::vector<std::set<std::string>> sighted(surveys_.size());
  for (size_t i = 0; i < surveys_.size(); ++i) {
    for (const SetUp& s : surveys_[i].set_ups) {
      std::vector<size_t>& files = occupied[s.station];
      if (files.empty() || files.back() != i) files.push_back(i);
    }
    for (const Observation& o : surveys_[i].observations) sighted[i].insert(o.to);
  }
  for (const std::string& station : options_.same_stations)
    if (const auto found = occupied.find(station);
        station != "*" && (found == occupied.end() || found->second.size() < 2))
      find(Finding::Severity::warning,
           "same_stations names " + station + ", which is occupied in " +
               (found == occupied.end() ? std::string("no file") : files_[found->second.front()] + " only") +
               ": there is nothing to unite; check the name",
           {station});
  for (const auto& [station, files] : occupied) {
    if (files.size() > 1) {
      decide_station(station, files);
      continue;
    }
    if (station.starts_with(kInvented)) continue;
    std::vector<std::string> elsewhere;
    for (size_t i = 0; i < surveys_.size(); ++i)
      if (i != files.front() && sighted[i].contains(station)) elsewhere.push_back(files_[i]);
    if (!elsewhere.empty())
      find(Finding::Severity::note,
           "station " + station + " of " + files_[files.front()] + " is the target of that name in " +
               text::join(elsewhere, kMostNamedPoints),
           {station});
  }
}

/// Numbers that began again on another day: one name, two marks. A known point, or one to which both files give the
/// same coordinates, is one mark whatever the sights say; those are for the adjustment to find.
void MergedNames::decide_targets() {
  std::vector<std::map<std::string, Eigen::Vector3d>> places;
  for (const SurveyObservations& survey : surveys_) places.push_back(seen_places(survey));
  std::vector<std::map<std::string, Eigen::Vector3d>> given(surveys_.size());
  for (size_t i = 0; i < surveys_.size(); ++i)
    for (const Point& p : surveys_[i].points) given[i].emplace(p.id, p.coordinates);
  const auto is_one_mark = [&](const std::string& id, size_t a, size_t b) {
    if (std::find(options_.known.begin(), options_.known.end(), id) != options_.known.end()) return true;
    const auto one = given[a].find(id), other = given[b].find(id);
    return one != given[a].end() && other != given[b].end() &&
           (one->second - other->second).head<2>().norm() < kSameMark;
  };
  for (size_t b = 1; b < surveys_.size(); ++b)
    for (size_t a = 0; a < b; ++a) {
      auto there = places[a], here = places[b];
      for (const size_t file : {a, b})
        for (const auto& [id, name] : renamed_[file]) there.erase(id), here.erase(id);
      std::vector<std::string> reused;
      for (const std::string& id : reused_names(there, here))
        if (!is_one_mark(id, a, b)) reused.push_back(id);
      if (reused.size() < 2) continue;
      std::vector<std::string> now;
      for (const std::string& id : reused) now.push_back(renamed_[b][id] = files_[b] + ":" + id);
      find(Finding::Severity::warning,
           "the names " + text::join(reused, kMostNamedPoints) + " stand for other marks in " + files_[b] +
               " than in " + files_[a] +
               " (their places do not fit each other): numbering began again. They are points of their own, " +
               text::join(now, 3) + "; where it is one mark after all, the sights to it are wrong",
           now);
    }
}

}  // namespace plumbline::survey

#include "survey/start/merge_surveys.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/text/text.hpp"
#include "base/text/words.hpp"
#include "plumbline/stop.hpp"
#include "survey/model/common_info.hpp"
#include "survey/model/reduced_readings.hpp"
#include "survey/model/repeated_readings.hpp"
#include "survey/model/repeated_rows.hpp"
#include "survey/start/alike_names.hpp"
#include "survey/start/merged_names.hpp"
#include "survey/start/stations_apart.hpp"

namespace plumbline::survey {

namespace {

constexpr double kSamePlace = 0.01;            // [m]
constexpr double kFixedContradiction = 0.001;  // [m]
constexpr double kOtherFrame = 0.5;            // [m]; points do not move that far between two days

template <typename Item>
void append(const std::vector<Item>& from, std::vector<Item>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

constexpr size_t most_named = 8;

std::string in_metres(double value) { return text::format_fixed(value, 3) + " m"; }

class Merger {
 public:
  Merger(const std::vector<SurveyObservations>& surveys, const MergeOptions& options)
      : surveys_(surveys), names_(surveys, options), files_(names_.files()) {
    drop_points_.resize(surveys_.size());
    drop_coordinates_.assign(surveys_.size(), 0);
  }
  MergedSurvey run();

 private:
  void compare_coordinates();
  void compare_coordinates(size_t a, size_t b);
  void refuse_fixed(const Point& a, const Point& b, size_t file_a, size_t file_b) const;
  std::string name_in(size_t file, const std::string& id) const { return names_.of(file, id); }
  void tell_tables_of_points();
  void merge_points(size_t file);
  int instrument_of(const std::string& name);
  void merge_observations(size_t file);
  void merge_groups(size_t file);
  void find(Finding::Severity severity, const std::string& text, std::vector<std::string> points) {
    merged_.findings.push_back({severity, text, std::move(points)});
  }

  const std::vector<SurveyObservations>& surveys_;
  const MergedNames names_;
  const std::vector<std::string>& files_;  // a short, unique name of each
  MergedSurvey merged_;
  std::vector<char> drop_coordinates_;              // of free points, by file
  std::vector<std::set<std::string>> drop_points_;  // likewise, of single points
  std::map<std::string, size_t> index_;
  std::set<std::string> set_up_ids_;
  int pointings_ = 0;
  CommonInfo common_;
};

void Merger::refuse_fixed(const Point& a, const Point& b, size_t file_a, size_t file_b) const {
  for (int k = 0; k < 3; ++k) {
    const auto axis = static_cast<size_t>(k);
    const bool fixed = a.roles[axis] == CoordinateRole::fixed && b.roles[axis] == CoordinateRole::fixed;
    if (fixed && std::abs(a.coordinates[k] - b.coordinates[k]) > kFixedContradiction)
      throw NetworkError("the fixed point " + a.id + " has in " + files_[file_a] + " another " + "ENH"[k] + " (" +
                         in_metres(a.coordinates[k]) + ", " + place(a.source) + ") than in " + files_[file_b] + " (" +
                         in_metres(b.coordinates[k]) + ", " + place(b.source) + "): mend one of the files");
  }
}

void Merger::compare_coordinates(size_t a, size_t b) {
  std::map<std::string, const Point*> known;
  for (const Point& p : surveys_[a].points) known[name_in(a, p.id)] = &p;
  std::vector<std::string> different, keyed, approximate;
  size_t shared = 0;
  double largest = 0, largest_approximate = 0;
  for (const Point& p : surveys_[b].points) {
    const auto at = known.find(name_in(b, p.id));
    if (at == known.end()) continue;
    refuse_fixed(*at->second, p, a, b);
    const Eigen::Vector3d d = p.coordinates - at->second->coordinates;
    double worst = kNotGiven;
    for (int k = 0; k < 3; ++k)
      if (!std::isnan(d[k])) worst = std::isnan(worst) ? std::abs(d[k]) : std::max(worst, std::abs(d[k]));
    if (std::isnan(worst)) continue;
    ++shared;
    largest = std::max(largest, worst);
    const size_t before = keyed.size();
    for (int k = 0; k < 3; ++k) {
      const auto axis = static_cast<size_t>(k);
      if (!p.known[axis] || !at->second->known[axis] || !(std::abs(d[k]) > kFixedContradiction)) continue;
      keyed.push_back(at->first + " (" + "ENH"[k] + " " + in_metres(at->second->coordinates[k]) + " and " +
                      in_metres(p.coordinates[k]) + ")");
    }
    if (!(worst > kSamePlace)) continue;
    (keyed.size() > before ? different : approximate).push_back(at->first);
    if (keyed.size() == before) largest_approximate = std::max(largest_approximate, worst);
  }
  const size_t beside = different.size();  // known in both files
  different.insert(different.end(), approximate.begin(), approximate.end());
  const auto differ = [&](const std::vector<std::string>& ids, double by) {
    return "the coordinates of " + text::join(ids, most_named) + " in " + files_[b] + " differ from those in " +
           files_[a] + " by up to " + in_metres(by);
  };
  // Most of them far off: the two files count from different origins, and no coordinate of the later one helps.
  if (!different.empty() && 2 * different.size() >= shared && largest > kOtherFrame) {
    drop_coordinates_[b] = 1;
    find(Finding::Severity::warning,
         differ(different, largest) + ": the files are in different frames. The coordinates of " + files_[b] +
             " are not used, its points are computed from the observations",
         different);
    return;
  }
  if (!keyed.empty())
    find(Finding::Severity::warning,
         "known points are keyed in with other coordinates in " + files_[a] + " than in " + files_[b] + ": " +
             text::join(keyed, most_named) + "; those of " + files_[a] + " hold. Give the right ones as control",
         {different.begin(), different.begin() + static_cast<std::ptrdiff_t>(beside)});
  drop_points_[b].insert(different.begin(), different.end());
  if (!approximate.empty())
    find(Finding::Severity::warning,
         differ(approximate, largest_approximate) + "; those of " + files_[a] + " are taken as approximate values",
         approximate);
}

void Merger::compare_coordinates() {
  for (size_t b = 1; b < surveys_.size(); ++b) {
    stop_point();
    for (size_t a = 0; a < b && !drop_coordinates_[b]; ++a)
      if (!drop_coordinates_[a]) compare_coordinates(a, b);
  }
}

/// A table of points among files of readings: somebody may have meant it as control, and it holds nothing.
void Merger::tell_tables_of_points() {
  std::set<std::string> sighted;
  for (size_t f = 0; f < surveys_.size(); ++f)
    for (const Observation& o : surveys_[f].observations) sighted.insert({name_in(f, o.from), name_in(f, o.to)});
  for (size_t f = 0; f < surveys_.size(); ++f) {
    const SurveyObservations& s = surveys_[f];
    if (!s.observations.empty() || !s.coordinates.empty() || !s.vectors.empty() || !s.local_coordinates.empty())
      continue;
    std::vector<std::string> points;
    for (const Point& p : s.points)
      if (!p.coordinates.array().isNaN().all() && !p.known[0] && !p.known[1] && !p.known[2] &&
          p.roles[0] != CoordinateRole::fixed && sighted.contains(name_in(f, p.id)))
        points.push_back(name_in(f, p.id));
    if (points.size() < 2) continue;
    find(Finding::Severity::warning,
         files_[f] + " has coordinates of " + std::to_string(points.size()) + " points that the other files sight (" +
             text::join(points, most_named) +
             ") and no readings: they are taken as approximate values. If they are known, give the file as the control",
         points);
  }
}

/// Points of the same name are one now: the first coordinates, the strongest role, which brings its coordinates along.
void Merger::merge_points(size_t file) {
  std::vector<Point>& all = merged_.survey.points;
  for (Point p : surveys_[file].points) {
    p.id = name_in(file, p.id);
    for (int k = 0; k < 3; ++k)
      if ((drop_coordinates_[file] || drop_points_[file].contains(p.id)) && p.roles[k] <= CoordinateRole::free)
        p.coordinates[k] = kNotGiven;
    const auto [at, is_new] = index_.try_emplace(p.id, all.size());
    if (is_new) {
      all.push_back(p);
      continue;
    }
    Point& known = all[at->second];
    for (int k = 0; k < 3; ++k) {
      const auto axis = static_cast<size_t>(k);
      const bool stronger = p.roles[axis] > known.roles[axis] && !std::isnan(p.coordinates[k]);
      if (std::isnan(known.coordinates[k]) || stronger) known.coordinates[k] = p.coordinates[k];
      known.roles[axis] = std::max(known.roles[axis], p.roles[axis]);
    }
    for (size_t k = 0; k < 3; ++k)
      known.known[k] = known.known[k] || (p.known[k] && known.coordinates[static_cast<Eigen::Index>(k)] ==
                                                            p.coordinates[static_cast<Eigen::Index>(k)]);
    if (known.code.empty()) known.code = p.code;
    if (known.description.empty()) known.description = p.description;
  }
}

/// Its index; -1 if it has no name.
int Merger::instrument_of(const std::string& name) {
  if (name.empty()) return -1;
  std::vector<std::string>& all = merged_.survey.instruments;
  const auto at = std::find(all.begin(), all.end(), name);
  const auto index = static_cast<int>(at - all.begin());
  if (at == all.end()) all.push_back(name);
  return index;
}

/// Observations and what refers to them, behind those that are there already.
void Merger::merge_observations(size_t file) {
  const SurveyObservations& s = surveys_[file];
  SurveyObservations& all = merged_.survey;
  const int set_up_offset = static_cast<int>(all.set_ups.size());
  const int observation_offset = static_cast<int>(all.observations.size());
  std::vector<int> instruments;  // of the file -> of all
  for (const std::string& name : s.instruments) instruments.push_back(instrument_of(name));
  const int own_instrument = common_.several_instruments ? instrument_of(s.info.instrument) : -1;
  const bool reduced = common_.several_formats && is_of_adjustment_program(s.info);
  for (SetUp set_up : s.set_ups) {
    if (const std::string now = name_in(file, set_up.station); now != set_up.station) {
      if (set_up.id.starts_with(set_up.station)) set_up.id = now + set_up.id.substr(set_up.station.size());
      set_up.station = now;
    }
    if (!set_up_ids_.insert(set_up.id).second) {
      set_up.id = files_[file] + ":" + set_up.id;
      set_up_ids_.insert(set_up.id);
    }
    all.set_ups.push_back(std::move(set_up));
  }
  int next_pointing = pointings_;
  for (Observation o : s.observations) {
    if (o.set_up >= 0) o.set_up += set_up_offset;
    if (o.pointing >= 0) o.pointing += pointings_;
    o.instrument = o.instrument >= 0 ? instruments.at(o.instrument) : own_instrument;
    if (reduced) o.corrections.emplace_back(kReducedBefore);
    next_pointing = std::max(next_pointing, o.pointing + 1);
    for (std::string* id : {&o.from, &o.to, &o.second_to}) *id = name_in(file, *id);
    all.observations.push_back(std::move(o));
  }
  pointings_ = next_pointing;
  for (ObservationCovariance c : s.covariances) {
    for (int& i : c.indices) i += observation_offset;
    all.covariances.push_back(std::move(c));
  }
  for (LocalCoordinate c : s.local_coordinates) {
    if (c.set_up >= 0) c.set_up += set_up_offset;
    c.point = name_in(file, c.point);
    all.local_coordinates.push_back(std::move(c));
  }
}

void Merger::merge_groups(size_t file) {
  SurveyObservations& all = merged_.survey;
  for (CoordinateGroup g : surveys_[file].coordinates) {
    for (auto& c : g.components) c.point = name_in(file, c.point);
    all.coordinates.push_back(std::move(g));
  }
  for (VectorGroup g : surveys_[file].vectors) {
    for (auto& v : g.vectors) {
      v.from = name_in(file, v.from);
      v.to = name_in(file, v.to);
    }
    all.vectors.push_back(std::move(g));
  }
}

MergedSurvey Merger::run() {
  common_ = common_info(surveys_, files_);
  merged_.survey.info = common_.info;
  append(common_.findings, merged_.findings);
  append(names_.findings(), merged_.findings);
  compare_coordinates();
  tell_tables_of_points();
  for (size_t i = 0; i < surveys_.size(); ++i) {
    stop_point();
    append(surveys_[i].files, merged_.survey.files);
    merge_points(i);
    merge_observations(i);
    merge_groups(i);
    append(surveys_[i].skipped, merged_.survey.skipped);
    append(surveys_[i].warnings, merged_.survey.warnings);
  }
  return std::move(merged_);
}

}  // namespace

MergedSurvey merge_surveys(const std::vector<SurveyObservations>& all, const MergeOptions& options) {
  if (all.empty()) return {};
  std::vector<SurveyObservations> surveys = all;
  const std::vector<std::string> repeated = take_out_repeated_readings(surveys);
  std::vector<Finding> parted;
  for (SurveyObservations& survey : surveys) {
    std::vector<std::string> known = options.known;
    append(options.same_stations, known);
    const bool all_same = std::find(known.begin(), known.end(), "*") != known.end();
    if (!all_same) append(part_stations(survey, known), parted);
  }
  MergedSurvey merged;
  if (surveys.size() == 1 && options.same_stations.empty())
    merged.survey = std::move(surveys.front());
  else
    merged = Merger(surveys, options).run();
  for (const std::string& text : repeated) merged.findings.push_back({Finding::Severity::warning, text, {}});
  append(take_out_repeated_rows(merged.survey), merged.findings);
  append(parted, merged.findings);
  // A folder's files were joined before, with the same known points, and what was found stands in `warnings`.
  const std::vector<std::string>& said = merged.survey.warnings;
  for (Finding& finding : examine_known_names(merged.survey, options.known)) {
    append(finding.points, merged.known_by_other_names);
    if (std::find(said.begin(), said.end(), finding.text) == said.end()) merged.findings.push_back(std::move(finding));
  }
  return merged;
}

}  // namespace plumbline::survey

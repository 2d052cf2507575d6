#include <algorithm>
#include <cmath>
#include <map>

#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {

namespace {

template <typename Item>
void append(const std::vector<Item>& from, std::vector<Item>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

/// The first file that has something of the file as a whole decides; what differs is nobody's any more.
void merge_info(const NetworkInfo& info, NetworkInfo& all) {
  if (all.format == info.format) return;
  all.format = "several";
  all.largest_misclosure = kNotGiven;
}

/// Points of the same name become one: the first coordinates, the strongest role.
void merge_points(const std::vector<Point>& points, std::map<std::string, size_t>& index, std::vector<Point>& all) {
  for (const Point& p : points) {
    const auto [at, is_new] = index.try_emplace(p.id, all.size());
    if (is_new) {
      all.push_back(p);
      continue;
    }
    Point& known = all[at->second];
    for (int k = 0; k < 3; ++k) {
      if (std::isnan(known.coordinates[k])) known.coordinates[k] = p.coordinates[k];
      known.roles[k] = std::max(known.roles[k], p.roles[k]);
    }
  }
}

/// Observations and what refers to them, behind those that are there already.
void merge_observations(const SurveyObservations& s, int& pointings, SurveyObservations& all) {
  const int set_up_offset = static_cast<int>(all.set_ups.size());
  const int observation_offset = static_cast<int>(all.observations.size());
  int next_pointing = pointings;
  append(s.set_ups, all.set_ups);
  for (Observation o : s.observations) {
    if (o.set_up >= 0) o.set_up += set_up_offset;
    if (o.pointing >= 0) o.pointing += pointings;
    next_pointing = std::max(next_pointing, o.pointing + 1);
    all.observations.push_back(std::move(o));
  }
  pointings = next_pointing;
  for (ObservationCovariance c : s.covariances) {
    for (int& i : c.indices) i += observation_offset;
    all.covariances.push_back(std::move(c));
  }
  for (LocalCoordinate c : s.local_coordinates) {
    if (c.set_up >= 0) c.set_up += set_up_offset;
    all.local_coordinates.push_back(std::move(c));
  }
}

}  // namespace

SurveyObservations merge_surveys(const std::vector<SurveyObservations>& surveys) {
  if (surveys.empty()) return {};
  if (surveys.size() == 1) return surveys.front();
  SurveyObservations all;
  all.info = surveys.front().info;
  std::map<std::string, size_t> index;
  int pointings = 0;
  for (const SurveyObservations& s : surveys) {
    merge_info(s.info, all.info);
    append(s.files, all.files);
    merge_points(s.points, index, all.points);
    merge_observations(s, pointings, all);
    append(s.coordinates, all.coordinates);
    append(s.vectors, all.vectors);
    append(s.skipped, all.skipped);
    append(s.warnings, all.warnings);
  }
  return all;
}

}  // namespace plumbline::survey

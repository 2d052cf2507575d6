#include "survey_files.hpp"

#include <algorithm>
#include <set>

namespace plumbline::campaign {
namespace {

int shifted(int index, std::size_t by) { return index < 0 ? index : index + static_cast<int>(by); }

}  // namespace

survey::SurveyObservations merge(const std::vector<survey::SurveyObservations>& parts) {
  survey::SurveyObservations all;
  std::set<std::string> known;
  int next_pointing = 0;
  for (const survey::SurveyObservations& part : parts) {
    if (all.files.empty()) all.info = part.info;
    const std::size_t set_ups = all.set_ups.size(), observations = all.observations.size();
    int highest = -1;
    all.files.insert(all.files.end(), part.files.begin(), part.files.end());
    for (const auto& point : part.points) {
      if (known.insert(point.id).second) all.points.push_back(point);
    }
    all.set_ups.insert(all.set_ups.end(), part.set_ups.begin(), part.set_ups.end());
    for (survey::Observation o : part.observations) {
      highest = std::max(highest, o.pointing);
      o.set_up = shifted(o.set_up, set_ups);
      o.pointing = shifted(o.pointing, static_cast<std::size_t>(next_pointing));
      all.observations.push_back(std::move(o));
    }
    next_pointing += highest + 1;
    for (survey::ObservationCovariance c : part.covariances) {
      for (int& index : c.indices) index = shifted(index, observations);
      all.covariances.push_back(std::move(c));
    }
    for (survey::LocalCoordinate l : part.local_coordinates) {
      l.set_up = shifted(l.set_up, set_ups);
      all.local_coordinates.push_back(std::move(l));
    }
    all.coordinates.insert(all.coordinates.end(), part.coordinates.begin(), part.coordinates.end());
    all.vectors.insert(all.vectors.end(), part.vectors.begin(), part.vectors.end());
    all.skipped.insert(all.skipped.end(), part.skipped.begin(), part.skipped.end());
    all.warnings.insert(all.warnings.end(), part.warnings.begin(), part.warnings.end());
  }
  return all;
}

}  // namespace plumbline::campaign

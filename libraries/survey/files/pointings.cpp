#include "survey/files/pointings.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>
#include <utility>

#include "base/text/text.hpp"

namespace plumbline::survey {
namespace {

const Observation** place_of(Pointing& pointing, ObservationKind kind) {
  switch (kind) {
    case ObservationKind::direction:
      return &pointing.direction;
    case ObservationKind::zenith_angle:
      return &pointing.zenith_angle;
    case ObservationKind::slope_distance:
      return &pointing.slope_distance;
    case ObservationKind::horizontal_distance:
      return &pointing.horizontal_distance;
    case ObservationKind::height_difference:
      return &pointing.height_difference;
    default:
      return nullptr;
  }
}

}  // namespace

std::vector<Pointing> pointings_of(const SurveyObservations& survey, const std::string& writer) {
  std::vector<Pointing> all;
  std::map<std::pair<int, int>, std::size_t> index;  // set-up and pointing
  for (const Observation& observation : survey.observations) {
    const auto cannot = [&](const char* why) {
      throw std::runtime_error(writer + ": cannot hold the observation " + text::quoted(observation.from) + " to " +
                               text::quoted(observation.to) + ": " + why);
    };
    if (observation.set_up < 0 || static_cast<std::size_t>(observation.set_up) >= survey.set_ups.size())
      cannot("it belongs to no set-up");
    std::size_t at = all.size();
    if (observation.pointing >= 0) at = index.try_emplace({observation.set_up, observation.pointing}, at).first->second;
    if (at == all.size()) all.push_back({.first = &observation});
    const Observation** place = place_of(all[at], observation.kind);
    if (!place) cannot("the format has no place for angles and azimuths");
    if (*place) cannot("its sighting has two values of one kind");
    if (std::isnan(observation.value)) cannot("it has no value");
    *place = &observation;
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Pointing& a, const Pointing& b) { return a.first->set_up < b.first->set_up; });
  return all;
}

}  // namespace plumbline::survey

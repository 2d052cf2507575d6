#include "survey/model/reading_sigmas.hpp"

#include <cmath>
#include <map>
#include <string>

namespace plumbline::survey {

ReadingSigmas::ReadingSigmas(const NetworkModel& model, const AdjustOptions& options, const StochasticState& state)
    : m_(model), options_(options), state_(state) {
  for (const std::string& name : m_.survey.instruments) {
    const auto given = options_.instruments.find(name);
    profiles_.push_back(given == options_.instruments.end() ? options_.profile : given->second);
  }
  profiles_.push_back(options_.profile);
  for (const InstrumentProfile& p : profiles_) centred_.push_back(p.without_instrument_centring());
}

const InstrumentProfile& ReadingSigmas::profile_of(const Observation& o, bool with_instrument_centring) const {
  const size_t own = o.instrument >= 0 ? static_cast<size_t>(o.instrument) : profiles_.size() - 1;
  return (with_instrument_centring ? profiles_ : centred_)[own];
}

double ReadingSigmas::operator()(int index) const {
  const MeanObservation& mean = m_.observations[static_cast<size_t>(index)];
  const Observation& o = mean.observation;
  const double factor = state_.sigma_factors[group_of(o.kind)];
  if (!std::isnan(o.sigma)) return factor * o.sigma;
  const Eigen::Vector2d& lengths = m_.lengths[static_cast<size_t>(index)];
  const double horizontal = lengths[0], slope = lengths[1];
  // Of a set-up it is an unknown, or there is none; of a single angle or distance it is in their standard deviation.
  const InstrumentProfile& p = profile_of(o, !options_.centring_per_set_up || o.set_up < 0);
  const auto place = [&](const std::string& id) { return m_.initial[static_cast<size_t>(m_.index.at(id))]; };
  switch (o.kind) {
    case ObservationKind::direction:
      return factor * p.direction(horizontal, slope, mean.sets, mean.single_face);
    case ObservationKind::azimuth:
      return factor * p.azimuth(horizontal, slope, mean.sets);
    case ObservationKind::angle: {
      const Eigen::Vector3d right = place(o.second_to) - place(o.from), left = place(o.to) - place(o.from);
      const double other = std::max(kShortestHorizontal, right.head<2>().norm());
      return factor * p.angle({horizontal, other}, {slope, std::max(other, right.norm())},
                              (right - left).head<2>().norm(), mean.sets);
    }
    case ObservationKind::zenith_angle:
      return factor * p.zenith_angle(slope, mean.sets, mean.single_face);
    case ObservationKind::slope_distance:
    case ObservationKind::horizontal_distance:
      return factor * p.distance(slope, mean.sets);
    case ObservationKind::height_difference:
      return factor * p.levelled(std::isnan(o.levelling_length) ? slope : o.levelling_length);
  }
  return kNotGiven;
}

std::vector<double> ReadingSigmas::centrings() const {
  std::vector<double> sizes(m_.survey.set_ups.size(), 0.0);
  if (!options_.centring_per_set_up) return sizes;
  std::map<std::string, int> tied;  // what else knows a point; its own set-up is one
  for (const SetUp& s : m_.survey.set_ups) ++tied[s.station];
  for (const MeanObservation& mean : m_.observations) {
    const Observation& o = mean.observation;
    tied[o.to] += 2;
    if (!o.second_to.empty()) tied[o.second_to] += 2;
    if (o.set_up < 0) tied[o.from] += 2;
  }
  for (const CoordinateGroup& g : m_.survey.coordinates)
    for (const auto& c : g.components) tied[c.point] += 2;
  for (const VectorGroup& g : m_.survey.vectors)
    for (const auto& v : g.vectors) tied[v.from] += 2, tied[v.to] += 2;
  for (size_t i = 0; i < m_.ids.size(); ++i)
    if (m_.roles[i][0] == CoordinateRole::fixed) tied[m_.ids[i]] += 2;
  for (size_t i = 0; i < m_.observations.size(); ++i) {
    const Observation& o = m_.observations[i].observation;
    if (o.set_up < 0 || !takes_part(i) || !std::isnan(o.sigma)) continue;
    const auto set_up = static_cast<size_t>(o.set_up);
    if (tied.at(m_.survey.set_ups[set_up].station) > 1) sizes[set_up] = profile_of(o, true).instrument_centring;
  }
  return sizes;
}

}  // namespace plumbline::survey

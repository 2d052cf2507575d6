#include "survey/network/reading_sigmas.hpp"

#include <algorithm>
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
  for (const InstrumentProfile& p : profiles_) {
    centred_.push_back(p.without_instrument_centring());
    own_.push_back(p.without_centring());
  }
}

const InstrumentProfile& ReadingSigmas::profile_of(const Observation& o,
                                                   const std::vector<InstrumentProfile>& profiles) const {
  return profiles[o.instrument >= 0 ? static_cast<size_t>(o.instrument) : profiles.size() - 1];
}

double ReadingSigmas::factor(int index) const {
  return state_.sigma_factors[group_of(m_.observations[index].observation.kind)];
}

double ReadingSigmas::operator()(int index) const {
  const Observation& o = m_.observations[index].observation;
  if (!is_centred_by_profile(o)) return factor(index) * o.sigma;
  // Of a set-up it is an unknown, or there is none; of a single angle or distance it is in their standard deviation.
  const bool in_reading = !options_.centring_per_set_up || o.set_up < 0;
  const double whole = sigma_by(profile_of(o, in_reading ? profiles_ : centred_), index);
  if (std::isnan(o.sigma)) return factor(index) * whole;
  const double without = sigma_by(profile_of(o, own_), index);
  return factor(index) * std::sqrt(o.sigma * o.sigma + std::max(0.0, whole * whole - without * without));
}

double ReadingSigmas::own(int index) const {
  const Observation& o = m_.observations[index].observation;
  return std::isnan(o.sigma) ? sigma_by(profile_of(o, own_), index) : o.sigma;
}

Eigen::Vector2d ReadingSigmas::lengths_between(const std::string& from, const std::string& to) const {
  const auto place = [&](const std::string& id) { return m_.initial[m_.index.at(id)]; };
  const Eigen::Vector3d d = place(to) - place(from);
  const double horizontal = std::max(kShortestHorizontal, d.head<2>().norm());
  return {horizontal, std::max(horizontal, d.norm())};
}

double ReadingSigmas::sigma_by(const InstrumentProfile& p, int index) const {
  const MeanObservation& mean = m_.observations[index];
  const Observation& o = mean.observation;
  const Eigen::Vector2d& lengths = m_.lengths[index];
  const double horizontal = lengths[0], slope = lengths[1];
  switch (o.kind) {
    case ObservationKind::direction:
      return p.direction(horizontal, slope, mean.sets, mean.single_face);
    case ObservationKind::azimuth:
      return p.azimuth(horizontal, slope, mean.sets);
    case ObservationKind::angle: {
      const auto place = [&](const std::string& id) { return m_.initial[m_.index.at(id)]; };
      const Eigen::Vector2d other = lengths_between(o.from, o.second_to);
      return p.angle({horizontal, other[0]}, {slope, other[1]}, (place(o.second_to) - place(o.to)).head<2>().norm(),
                     mean.sets);
    }
    case ObservationKind::zenith_angle: {
      InstrumentProfile level = p;
      level.height_centring = 0;
      const double centring = std::hypot(p.instrument_centring, p.target_centring);
      return std::hypot(level.zenith_angle(slope, mean.sets, mean.single_face),
                        std::hypot(p.height_centring * std::sin(o.value), centring * std::cos(o.value)) / slope);
    }
    case ObservationKind::slope_distance:
    case ObservationKind::horizontal_distance:
      return p.distance(slope, mean.sets);
    case ObservationKind::height_difference:
      return p.levelled(std::isnan(o.levelling_length) ? slope : o.levelling_length);
  }
  return kNotGiven;
}

std::vector<Eigen::Vector2d> ReadingSigmas::centrings() const {
  std::vector<Eigen::Vector2d> sizes(m_.survey.set_ups.size(), Eigen::Vector2d::Zero());
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
    if (o.set_up < 0 || !takes_part(i) || !is_centred_by_profile(o)) continue;
    const auto set_up = static_cast<size_t>(o.set_up);
    if (tied.at(m_.survey.set_ups[set_up].station) > 1)
      sizes[set_up] = {profile(o).instrument_centring, profile(o).instrument_height};
  }
  return sizes;
}

}  // namespace plumbline::survey

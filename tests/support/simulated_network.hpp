// A facade with markers in rows and free stations in front of it, observed in one set; reproducible noise.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey::test {

/// Standard normal numbers: splitmix64 and Box-Muller, the same on every machine.
class Normal {
 public:
  /// Neighbouring seeds must not give the same stream shifted, so the seed is mixed first.
  explicit Normal(std::uint64_t seed) : state_(seed) { state_ = mixed() ^ 0xD1B54A32D192ED03ULL; }
  double operator()() {
    const double u = uniform(), v = uniform();
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
  }
  double uniform() { return (static_cast<double>(mixed() >> 11) + 1) * 0x1p-53; }  // (0, 1]

 private:
  std::uint64_t mixed() {
    std::uint64_t z = (state_ += 0x9E3779B97F4A7C15ULL);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ULL;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBULL;
    return z ^ (z >> 31);
  }
  std::uint64_t state_;
};

struct SimulatedNetwork {
  SurveyObservations survey;
  std::vector<Eigen::Vector3d> truth;  // of survey.points
};

struct SimulationSettings {
  int columns = 4, rows = 3, set_ups = 3;
  double angle_sigma = 1.5e-5;    // [rad]
  double distance_sigma = 0.001;  // [m]
  double noise = 1;               // factor on the sigmas; 0: exact
  bool coordinates = true;        // markers carry their true coordinates as approximations
  bool sigmas = true;             // observations carry their sigmas
};

inline SimulatedNetwork simulate(const SimulationSettings& s, std::uint64_t seed) {
  SimulatedNetwork n;
  Normal normal(seed);
  const auto add_point = [&](const std::string& id, const Eigen::Vector3d& p) {
    Point point;
    point.id = id;
    if (s.coordinates) point.coordinates = p;
    n.survey.points.push_back(point);
    n.truth.push_back(p);
  };
  for (int r = 0; r < s.rows; ++r)
    for (int c = 0; c < s.columns; ++c)
      add_point("M" + std::to_string(r) + std::to_string(c), {100 + 4.0 * c, 250 + 0.3 * (c % 2), 2 + 3.0 * r});
  const size_t markers = n.truth.size();
  for (int i = 0; i < s.set_ups; ++i) {
    const std::string id = "S" + std::to_string(i + 1);
    add_point(id, {98 + 6.0 * i, 235 - 2.0 * (i % 2), 1.6});
    n.survey.set_ups.push_back({id, id, kNotGiven, {}});
    const double orientation = 0.7 + 1.9 * i;
    for (size_t m = 0; m < markers; ++m) {
      const Eigen::Vector3d d = n.truth[m] - n.truth.back();
      const double h = std::hypot(d.x(), d.y());
      const double values[] = {std::remainder(std::atan2(d.x(), d.y()) - orientation, 2 * std::numbers::pi),
                               std::atan2(h, d.z()), d.norm()};
      const ObservationKind kinds[] = {ObservationKind::direction, ObservationKind::zenith_angle,
                                       ObservationKind::slope_distance};
      for (int k = 0; k < 3; ++k) {
        Observation o;
        o.kind = kinds[k];
        o.set_up = i;
        o.pointing = static_cast<int>(static_cast<size_t>(i) * markers + m);
        o.from = id;
        o.to = n.survey.points[m].id;
        const double sigma = k == 2 ? s.distance_sigma : s.angle_sigma;
        o.value = values[k] + s.noise * sigma * normal();
        if (s.sigmas) o.sigma = sigma;
        n.survey.observations.push_back(o);
      }
    }
  }
  return n;
}

}  // namespace plumbline::survey::test

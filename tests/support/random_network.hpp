// Random survey networks of many kinds, observed with small random errors; reproducible. The points carry their true
// coordinates; without_coordinates() takes them away from all that are not held.
#pragma once

#include <algorithm>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

#include "simulated_network.hpp"

namespace plumbline::survey::test {

enum class NetworkKind {
  levels,          // height differences
  directions,      // plane: sets of directions, some distances
  angles,          // plane: angles between neighbouring targets, some distances
  distances,       // plane: distances only, three points held
  traverse,        // plane: directions and distances from point to point
  free_stations,   // space: set-ups at unknown places that see markers, readings missing at random
  theodolite,      // space: the same without distances, except two
  mixed,           // space: free stations, levelling, single distances, vectors
  space_distances  // space: slope distances only, five points held
};
inline constexpr NetworkKind kNetworkKinds[] = {
    NetworkKind::levels,     NetworkKind::directions, NetworkKind::angles,
    NetworkKind::distances,  NetworkKind::traverse,   NetworkKind::free_stations,
    NetworkKind::theodolite, NetworkKind::mixed,      NetworkKind::space_distances};
inline constexpr const char* kNetworkKindNames[] = {"levels",     "directions", "angles",
                                                    "distances",  "traverse",   "free stations",
                                                    "theodolite", "mixed",      "space distances"};
/// Found by GoogleTest, which names its cases by it.
inline void PrintTo(NetworkKind kind, std::ostream* out) { *out << kNetworkKindNames[static_cast<int>(kind)]; }

class RandomNetwork {
 public:
  SurveyObservations survey;
  std::vector<Eigen::Vector3d> truth;

  RandomNetwork(NetworkKind kind, std::uint64_t seed) : random_(seed * 16 + static_cast<std::uint64_t>(kind)) {
    switch (kind) {
      case NetworkKind::levels:
        levels();
        break;
      case NetworkKind::directions:
        stations_in_the_plane(false);
        break;
      case NetworkKind::angles:
        stations_in_the_plane(true);
        break;
      case NetworkKind::distances:
        distances_only(false);
        break;
      case NetworkKind::traverse:
        traverse();
        break;
      case NetworkKind::free_stations:
        free_stations(0.15, true);
        break;
      case NetworkKind::theodolite:
        theodolite();
        break;
      case NetworkKind::mixed:
        mixed();
        break;
      case NetworkKind::space_distances:
        distances_only(true);
        break;
    }
  }

  SurveyObservations without_coordinates() const {
    SurveyObservations stripped = survey;
    for (Point& p : stripped.points)
      for (int k = 0; k < 3; ++k)
        if (p.roles[k] != CoordinateRole::fixed) p.coordinates[k] = kNotGiven;
    return stripped;
  }

 private:
  static constexpr double kAngle = 1e-5, kLength = 0.001;  // standard deviations

  bool happens(double probability) { return random_.uniform() <= probability; }
  int number(int from, int to) {
    return std::min(to, from + static_cast<int>(random_.uniform() * static_cast<double>(to - from + 1)));
  }
  double within(double a, double b) { return a + (b - a) * random_.uniform(); }

  int add_point(const std::string& id, const Eigen::Vector3d& p, bool plan, bool height) {
    Point point;
    point.id = id;
    point.coordinates = p;
    if (!plan) point.roles[0] = point.roles[1] = CoordinateRole::unused;
    if (!height) point.roles[2] = CoordinateRole::unused;
    survey.points.push_back(point);
    truth.push_back(p);
    return static_cast<int>(truth.size()) - 1;
  }
  void hold(int i) {
    for (CoordinateRole& role : survey.points[i].roles)
      if (role != CoordinateRole::unused) role = CoordinateRole::fixed;
  }
  void hold_first(int count) {
    for (int i = 0; i < count; ++i) hold(i);
  }
  /// Points that keep a twentieth of the size from each other.
  void scatter(const std::string& prefix, int count, double size, double height, bool with_height) {
    while (count > 0) {
      const Eigen::Vector3d p(within(0, size), within(0, size), with_height ? within(0, height) : 0);
      const auto near = [&](const Eigen::Vector3d& q) { return (p - q).head<2>().norm() < 0.05 * size; };
      if (std::any_of(truth.begin(), truth.end(), near)) continue;
      add_point(prefix + std::to_string(truth.size()), p, true, with_height);
      --count;
    }
  }
  int set_up_at(int i) {
    const std::string& id = survey.points[i].id;
    survey.set_ups.push_back({id + "/" + std::to_string(survey.set_ups.size()), id, kNotGiven, {}});
    orientation_ = within(0, 2 * std::numbers::pi);
    return static_cast<int>(survey.set_ups.size()) - 1;
  }
  void observe(ObservationKind kind, int set_up, int from, int to, int second = -1) {
    const auto azimuth = [&](int i) {
      const Eigen::Vector3d d = truth[i] - truth[from];
      return std::atan2(d.x(), d.y());
    };
    const Eigen::Vector3d d = truth[to] - truth[from];
    Observation o;
    o.kind = kind;
    o.set_up = set_up;
    o.from = survey.points[from].id;
    o.to = survey.points[to].id;
    o.sigma = kLength;
    switch (kind) {
      case ObservationKind::direction:
        o.value = azimuth(to) - orientation_;
        break;
      case ObservationKind::azimuth:
        o.value = azimuth(to);
        break;
      case ObservationKind::angle:
        o.second_to = survey.points[second].id;
        o.value = azimuth(second) - azimuth(to);
        break;
      case ObservationKind::zenith_angle:
        o.value = std::atan2(d.head<2>().norm(), d.z());
        break;
      case ObservationKind::slope_distance:
        o.value = d.norm();
        break;
      case ObservationKind::horizontal_distance:
        o.value = d.head<2>().norm();
        break;
      case ObservationKind::height_difference:
        o.value = d.z();
        break;
    }
    const bool angular = kind == ObservationKind::direction || kind == ObservationKind::angle ||
                         kind == ObservationKind::azimuth || kind == ObservationKind::zenith_angle;
    if (angular) o.sigma = kAngle;
    o.value += o.sigma * random_();
    if (angular && kind != ObservationKind::zenith_angle)
      o.value -= 2 * std::numbers::pi * std::floor(o.value / (2 * std::numbers::pi));
    survey.observations.push_back(o);
  }

  void levels() {
    const int n = number(4, 10);
    for (int i = 0; i < n; ++i) add_point("B" + std::to_string(i), {0, 0, within(0, 30)}, false, true);
    for (int i = 1; i < n; ++i) observe(ObservationKind::height_difference, -1, number(0, i - 1), i);
    for (int k = 0; k < n; ++k) {
      const int a = number(0, n - 1), b = number(0, n - 1);
      if (a != b) observe(ObservationKind::height_difference, -1, a, b);
    }
    hold_first(number(0, 2));
  }

  void stations_in_the_plane(bool angles) {
    const int n = number(5, 9);
    const double size = happens(0.5) ? 30 : 2000;
    scatter("P", n, size, 0, false);
    for (int i = 0; i < n; ++i) {
      if (happens(0.3)) continue;
      std::vector<int> targets;
      for (int j = 0; j < n; ++j)
        if (j != i && happens(0.6)) targets.push_back(j);
      if (targets.size() < 2) continue;
      const int set_up = angles ? -1 : set_up_at(i);
      for (size_t k = 0; k < targets.size(); ++k) {
        if (!angles) observe(ObservationKind::direction, set_up, i, targets[k]);
        if (angles && k > 0) observe(ObservationKind::angle, -1, i, targets[k - 1], targets[k]);
        if (happens(0.2)) observe(ObservationKind::horizontal_distance, set_up, i, targets[k]);
      }
    }
    if (happens(0.3)) observe(ObservationKind::azimuth, -1, 0, 1);
    hold_first(happens(0.5) ? 0 : 2);
  }

  void distances_only(bool space) {
    const int n = number(5, 9);
    scatter("P", n, happens(0.5) ? 20 : 500, 15, space);
    const auto kind = space ? ObservationKind::slope_distance : ObservationKind::horizontal_distance;
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < i; ++j)
        if (happens(space ? 0.85 : 0.7)) observe(kind, -1, i, j);
    hold_first(space ? 5 : 3);
  }

  void traverse() {
    const int n = number(4, 10);
    Eigen::Vector3d p = Eigen::Vector3d::Zero();
    double course = within(0, 6);
    for (int i = 0; i < n; ++i) {
      add_point("T" + std::to_string(i), p, true, false);
      course += within(-1.2, 1.2);
      p += within(20, 80) * Eigen::Vector3d(std::sin(course), std::cos(course), 0);
    }
    for (int i = happens(0.5) ? 0 : 1; i + 1 < n; ++i) {
      const int set_up = set_up_at(i);
      for (int j : {i - 1, i + 1}) {
        if (j < 0) continue;
        observe(ObservationKind::direction, set_up, i, j);
        if (j > i || happens(0.5)) observe(ObservationKind::horizontal_distance, happens(0.5) ? set_up : -1, i, j);
      }
    }
    if (happens(0.5)) observe(ObservationKind::azimuth, -1, 0, 1);
    hold(0);
    if (happens(0.5)) hold(happens(0.5) ? 1 : n - 1);
  }

  /// Markers first, then the stations.
  void free_stations(double missing, bool distances) {
    const int markers = number(5, 12), stations = number(2, 5);
    scatter("M", markers, 25, 12, true);
    for (int s = 0; s < stations; ++s) {
      const int station =
          add_point("S" + std::to_string(s), {within(-10, 35), within(-25, -10), within(1, 3)}, true, true);
      const int set_up = set_up_at(station);
      const double seen = within(0.3, 1);
      for (int m = 0; m < markers; ++m) {
        if (!happens(seen)) continue;
        if (!happens(missing)) observe(ObservationKind::direction, set_up, station, m);
        if (!happens(missing)) observe(ObservationKind::zenith_angle, set_up, station, m);
        if (distances && !happens(missing)) observe(ObservationKind::slope_distance, set_up, station, m);
      }
    }
    hold_first(number(0, 1) * number(2, 3));
  }

  void theodolite() {
    free_stations(0.05, false);
    observe(ObservationKind::slope_distance, -1, 0, 1);
    observe(ObservationKind::slope_distance, -1, 2, 3);
  }

  void mixed() {
    free_stations(0.3, true);
    const int n = static_cast<int>(truth.size());
    for (int k = 0; k < n / 2; ++k) {
      const int a = number(0, n - 1), b = number(0, n - 1);
      if (a == b) continue;
      observe(happens(0.5) ? ObservationKind::height_difference : ObservationKind::slope_distance, -1, a, b);
    }
    if (happens(0.6)) return;
    VectorGroup group;
    group.vectors.push_back({survey.points[0].id, survey.points[1].id, 0, 0});
    group.values = truth[1] - truth[0] + 0.002 * Eigen::Vector3d(random_(), random_(), random_());
    group.covariance = 4e-6 * Eigen::Matrix3d::Identity();
    survey.vectors.push_back(group);
  }

  Normal random_;
  double orientation_ = 0;
};

}  // namespace plumbline::survey::test

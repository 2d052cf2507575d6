// One point from any three observations that tie it to known points: what no construction with rays, circles or spheres
// covers, such as a direction, a slope distance and a zenith angle from three different stations.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "geometry/linear_algebra/decompositions.hpp"
#include "survey/model/observation_equations.hpp"
#include "survey/start/approximate_frame.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

double azimuth_of(const Vector3d& d) { return std::atan2(d.x(), d.y()); }

/// Gauss-Newton with damping; nullopt unless it ends where all conditions hold and the point is determined by them.
std::optional<Vector3d> improve(const std::vector<PointCondition>& conditions, Vector3d p) {
  constexpr int kIterations = 25;
  constexpr double kAgreement = 0.02, kWeakest = 1e-3;  // radians, or parts of a distance
  const auto n = static_cast<Eigen::Index>(conditions.size());
  const auto misclosures = [&](const Vector3d& at) {
    Eigen::VectorXd v(n);
    for (Eigen::Index i = 0; i < n; ++i) v[i] = conditions[i].misclosure(at);
    return v;
  };
  const double size = std::max(1.0, (conditions.front().known - p).norm()), step = 1e-6 * size;
  Eigen::VectorXd v = misclosures(p);
  Eigen::MatrixXd a(n, 3);
  double damping = 1e-3;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    for (int k = 0; k < 3; ++k)
      a.col(k) =
          (misclosures(p + step * Vector3d::Unit(k)) - misclosures(p - step * Vector3d::Unit(k))) * (size / (2 * step));
    const Eigen::Matrix3d normal = a.transpose() * a;
    const Vector3d move = (normal + damping * Eigen::Matrix3d::Identity()).ldlt().solve(-(a.transpose() * v)) * size;
    if (!move.allFinite()) return std::nullopt;
    const Eigen::VectorXd moved = misclosures(p + move);
    if (moved.squaredNorm() < v.squaredNorm()) {
      p += move;
      v = moved;
      damping = std::max(1e-9, 0.1 * damping);
      if (move.norm() < 1e-7 * size) break;
    } else {
      damping *= 10;
      if (damping > 1e6) break;
    }
  }
  const linear_algebra::SingularValues svd(a);
  if (!(v.cwiseAbs().maxCoeff() < kAgreement) || svd.singularValues()[2] < kWeakest) return std::nullopt;
  return p;
}

/// Bytes that are equal for equal conditions only.
std::string key_of(const std::vector<PointCondition>& conditions) {
  std::string key;
  for (const PointCondition& c : conditions) {
    const double numbers[] = {static_cast<double>(c.kind),
                              c.known.x(),
                              c.known.y(),
                              c.known.z(),
                              c.value,
                              c.second.x(),
                              c.second.y(),
                              c.second.z()};
    key.append(reinterpret_cast<const char*>(numbers), sizeof numbers);
  }
  return key;
}

/// All around the known points, at the measured distances or at those of the network.
std::vector<Vector3d> starts_of(const std::vector<PointCondition>& conditions) {
  constexpr int kAzimuths = 8;
  double spread = 1;
  for (const PointCondition& c : conditions) spread = std::max(spread, (c.known - conditions.front().known).norm());
  std::vector<Vector3d> starts;
  for (size_t i = 0; i < conditions.size() && i < 6; ++i) {
    const bool measured =
        conditions[i].kind == PointCondition::slope || conditions[i].kind == PointCondition::horizontal;
    for (const double part : {1.0, 0.3, 3.0}) {
      if (measured && part != 1.0) continue;
      const double length = measured ? conditions[i].value : part * spread;
      for (int k = 0; k < kAzimuths; ++k)
        for (const double rise : {-0.5, 0.0, 0.5}) {
          const double azimuth = 2 * std::numbers::pi * (k + 0.5) / kAzimuths;
          starts.push_back(conditions[i].known +
                           length * Vector3d(std::sin(azimuth), std::cos(azimuth), rise).normalized());
        }
    }
  }
  return starts;
}

/// The starts that contradict the conditions least: an iteration is dear, and from the others it ends there or nowhere.
std::vector<Vector3d> best_starts_of(const std::vector<PointCondition>& conditions) {
  constexpr size_t kMost = 48;
  std::vector<std::pair<double, Vector3d>> rated;
  for (const Vector3d& start : starts_of(conditions)) {
    double sum = 0;
    for (const PointCondition& c : conditions) sum += std::min(1.0, std::abs(c.misclosure(start)));
    rated.emplace_back(sum, start);
  }
  std::stable_sort(rated.begin(), rated.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vector3d> best;
  for (size_t i = 0; i < std::min(kMost, rated.size()); ++i) best.push_back(rated[i].second);
  return best;
}

/// Places that fit the conditions, the best first and those that fit nearly as well.
std::vector<std::pair<double, Vector3d>> places_of(const std::vector<PointCondition>& conditions) {
  std::vector<std::pair<double, Vector3d>> places;
  for (const Vector3d& start : best_starts_of(conditions)) {
    const auto p = improve(conditions, start);
    if (!p) continue;
    double sum = 0, length = 0;
    for (const PointCondition& c : conditions) {
      sum += std::abs(c.misclosure(*p));
      length = std::max(length, (*p - c.known).norm());
    }
    const auto same = [&](const auto& q) { return (q.second - *p).norm() < 0.01 * length; };
    if (std::none_of(places.begin(), places.end(), same)) places.emplace_back(sum, *p);
  }
  if (places.empty()) return places;
  std::stable_sort(places.begin(), places.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  const double clear = places.front().first + 0.02;
  while (places.back().first > clear) places.pop_back();
  return places;
}

}  // namespace

double PointCondition::misclosure(const Vector3d& p) const {
  const Vector3d d = p - known;
  const double h = d.head<2>().norm();
  switch (kind) {
    case ray:
      return wrap_angle(azimuth_of(d) - value);
    case angle:
      return wrap_angle(azimuth_of(second - p) - azimuth_of(known - p) - value);
    case slope:
      return (d.norm() - value) / value;
    case horizontal:
      return (h - value) / value;
    case elevation:
      return std::atan2(d.z(), h) - value;
    case rise:
      return (d.z() - value) / 10;
  }
  return 0;
}

std::map<std::string, std::vector<PointCondition>> Frame::collect_conditions() const {
  using C = PointCondition;
  std::map<std::string, std::vector<PointCondition>> conditions;
  const auto is_known = [&](const std::string& id) { return has_plan(id) && has_height(id); };
  const auto at = [&](const std::string& id, double lift) {
    return Vector3d(plan_.at(id).x(), plan_.at(id).y(), height_.at(id) + lift);
  };
  // `lift`: height of the known end of the sight as the point would have it.
  const auto add = [&](C::Kind kind, const std::string& known, const std::string& unknown, double lift, double value) {
    if (std::isnan(value) || !is_known(known) || has_plan(unknown) || heightless(unknown)) return;
    conditions[unknown].push_back({kind, at(known, lift), value, Vector3d::Zero()});
  };
  const auto add_line = [&](const std::string& a, const std::string& b, double horizontal, double slope, double lift) {
    add(C::slope, a, b, lift, slope);
    add(C::slope, b, a, -lift, slope);
    if (!std::isnan(slope)) return;
    add(C::horizontal, a, b, lift, horizontal);
    add(C::horizontal, b, a, -lift, horizontal);
  };
  for (const DistanceLine& d : figures_.distances) add_line(d.from, d.to, d.horizontal, d.slope, d.heights);
  for (const HeightDifference& d : figures_.height_differences) {
    add(C::rise, d.from, d.to, 0, d.value);
    add(C::rise, d.to, d.from, 0, -d.value);
  }
  for (size_t f = 0; f < figures_.figures.size(); ++f) {
    const Figure& figure = figures_.figures[f];
    const PolarSight* first = nullptr;
    for (const PolarSight& s : figure.sights) {
      add_line(figure.station, s.to, s.horizontal, s.slope, s.heights);
      const double elevation = 0.5 * std::numbers::pi - s.zenith;
      add(C::elevation, figure.station, s.to, s.heights, elevation);
      add(C::elevation, s.to, figure.station, -s.heights, -elevation);
      if (!std::isnan(orientation_[f])) {
        add(C::ray, figure.station, s.to, 0, s.direction + orientation_[f]);
        add(C::ray, s.to, figure.station, 0, s.direction + orientation_[f] + std::numbers::pi);
      } else if (!std::isnan(s.direction) && is_known(s.to)) {
        if (first != nullptr && !has_plan(figure.station))
          conditions[figure.station].push_back(
              {C::angle, at(first->to, 0), s.direction - first->direction, at(s.to, 0)});
        if (first == nullptr) first = &s;
      }
    }
  }
  return conditions;
}

bool Frame::place_by_conditions() {
  if (scale_open_) return false;
  for (auto& [id, conditions] : collect_conditions()) {
    if (conditions.size() < 3) continue;
    if (has_height(id)) conditions.push_back({PointCondition::rise, {0, 0, height_.at(id)}, 0, Vector3d::Zero()});
    const auto [found, is_new] = figures_.places_found->try_emplace(key_of(conditions));
    if (is_new) found->second = places_of(conditions);
    const std::vector<std::pair<double, Vector3d>>& places = found->second;
    if (places.empty()) continue;
    const int count = static_cast<int>(std::min<size_t>(places.size(), 4));
    const Vector3d p = places[count > 1 ? choices_.choose(name_ + id + " all", count) : 0].second;
    set_plan(id, p.head<2>());
    set_height(id, p.z());
    return true;
  }
  return false;
}

}  // namespace plumbline::survey

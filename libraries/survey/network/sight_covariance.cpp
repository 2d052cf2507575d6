#include "survey/network/sight_covariance.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <string>

namespace plumbline::survey {

namespace {

using Eigen::MatrixXd;
using Eigen::RowVector3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Geometry of a sight: lengths as measured where they are, the bearing from the approximate coordinates.
struct Sight {
  Vector3d along, across;                                  ///< horizontal unit vectors, across to the right
  double horizontal = 0, slope = 0, cosine = 0, sine = 1;  ///< of the zenith angle
};

Sight sight_to(const NetworkModel& m, const Observation& o, const std::string& to, const Eigen::Vector2d& lengths) {
  const auto place = [&](const std::string& id) { return m.initial[m.index.at(id)]; };
  Vector3d d = place(to) - place(o.from);
  const double own = o.set_up >= 0 ? m.survey.set_ups[o.set_up].instrument_height : 0.0;
  d.z() += or_zero(to == o.to ? o.target_height : o.second_target_height) - or_zero(or_else(o.instrument_height, own));
  Sight s;
  s.horizontal = lengths[0], s.slope = std::max(lengths[0], lengths[1]);
  const double plan = d.head<2>().norm();
  s.along = plan > 0 ? Vector3d(d.x() / plan, d.y() / plan, 0) : Vector3d::UnitY().eval();
  s.across = {s.along.y(), -s.along.x(), 0};
  s.sine = s.horizontal / s.slope;
  s.cosine = std::sqrt(std::max(0.0, 1 - s.sine * s.sine)) * (d.z() < 0 ? -1 : 1);
  if (o.kind == ObservationKind::zenith_angle) s.cosine = std::cos(o.value), s.sine = std::sin(o.value);
  return s;
}

/// Change of a reading by a displacement E, N, H of what it is taken to. Distances of which the profile has a centring
/// of their own have it there.
RowVector3d by_target(ObservationKind kind, const Sight& s, bool own_distance_centring) {
  switch (kind) {
    case ObservationKind::direction:
    case ObservationKind::azimuth:
    case ObservationKind::angle:
      return s.across / s.horizontal;
    case ObservationKind::zenith_angle:
      return (s.cosine * s.along - s.sine * Vector3d::UnitZ()) / s.slope;
    case ObservationKind::slope_distance:
      return (own_distance_centring ? 0.0 : s.sine) * s.along + s.cosine * Vector3d::UnitZ();
    case ObservationKind::horizontal_distance:
      return (own_distance_centring ? 0.0 : 1.0) * s.along;
    case ObservationKind::height_difference:
      return RowVector3d::Zero();  // levelled
  }
  return RowVector3d::Zero();
}

}  // namespace

MatrixXd sight_covariance(const NetworkModel& m, const ReadingSigmas& sigmas, const std::vector<int>& members) {
  const auto n = static_cast<Eigen::Index>(members.size());
  MatrixXd covariance = MatrixXd::Zero(n, n);
  std::map<std::string, MatrixXd> by_mark;  // n x 3
  std::map<std::string, Vector3d> sizes;    // [m]
  const auto put = [&](const std::string& mark, Eigen::Index row, const RowVector3d& change, const Vector3d& size) {
    by_mark.try_emplace(mark, MatrixXd::Zero(n, 3)).first->second.row(row) += change;
    sizes.try_emplace(mark, size);
  };
  for (Eigen::Index k = 0; k < n; ++k) {
    const auto i = static_cast<size_t>(members[k]);
    const Observation& o = m.observations[i].observation;
    covariance(k, k) = std::pow(sigmas.own(static_cast<int>(i)), 2);
    if (!is_centred_by_profile(o)) continue;  // the file's holds all
    const InstrumentProfile& profile = sigmas.profile(o);
    const bool own = !std::isnan(profile.distance_centring);
    const Vector3d target(profile.target_centring, profile.target_centring, profile.height_centring);
    const Vector3d instrument(profile.instrument_centring, profile.instrument_centring, 0);
    const std::string& to = o.second_to.empty() ? o.to : o.second_to;
    const Eigen::Vector2d lengths = o.second_to.empty() ? m.lengths[i] : sigmas.lengths_between(o.from, to);
    const RowVector3d change = by_target(o.kind, sight_to(m, o, to, lengths), own);
    put("to " + to, k, change, target);
    RowVector3d by_instrument = -change;
    if (!o.second_to.empty()) {  // an angle: right arm less left arm
      const RowVector3d left = by_target(o.kind, sight_to(m, o, o.to, m.lengths[i]), own);
      put("to " + o.to, k, -left, target);
      by_instrument += left;
    }
    if (o.set_up < 0 && o.kind != ObservationKind::height_difference) put("at " + o.from, k, by_instrument, instrument);
  }
  for (const auto& [mark, change] : by_mark)
    covariance += change * sizes.at(mark).cwiseAbs2().asDiagonal() * change.transpose();
  VectorXd factors(n);
  for (Eigen::Index k = 0; k < n; ++k) factors[k] = sigmas.factor(members[k]);
  return factors.asDiagonal() * covariance * factors.asDiagonal();
}

MatrixXd covariance_of(const VectorGroup& g, const NetworkModel& m) {
  if (!g.is_geocentric || (g.horizontal_factor == 1 && g.vertical_factor == 1)) return g.covariance;
  const Vector3d factors(g.horizontal_factor, g.horizontal_factor, g.vertical_factor);
  MatrixXd all = MatrixXd::Zero(g.covariance.rows(), g.covariance.cols());
  for (size_t k = 0; k < g.vectors.size(); ++k) {
    const Eigen::Matrix3d axes = m.map->horizon(m.initial[m.index.at(g.vectors[k].from)]);
    const auto at = static_cast<Eigen::Index>(3 * k);
    all.block<3, 3>(at, at) = axes.transpose() * factors.asDiagonal() * axes;
  }
  return all * g.covariance * all.transpose();
}

Eigen::Matrix3d polar_covariance(const Vector3d& p, const InstrumentProfile& profile) {
  const double s = std::max(kShortestHorizontal, p.norm());
  const double h = std::max(kShortestHorizontal, p.head<2>().norm());
  Eigen::Matrix3d axes;  // along the sight, across, up across
  axes.col(0) = p / s;
  axes.col(1) = Vector3d(p.y(), -p.x(), 0) / h;
  axes.col(2) = axes.col(0).cross(axes.col(1));
  const Vector3d sigmas(profile.distance(s, 1), h * profile.direction(h, s, 1, true),
                        s * profile.zenith_angle(s, 1, true));
  return axes * sigmas.cwiseAbs2().asDiagonal() * axes.transpose();
}

}  // namespace plumbline::survey

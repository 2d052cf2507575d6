#include "survey/adjust/left_out_control.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <set>

#include "geometry/statistics.hpp"

namespace plumbline::survey {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Coordinates in whole millimetres may be off by half of one, evenly [m].
constexpr double kWritten = 0.0005;
/// Chance that any sound point that was left out is said to speak against the result.
constexpr double kAlphaOfAll = 0.01;

struct Place {
  Vector3d position = Vector3d::Constant(kNotGiven);
  Matrix3d covariance = Matrix3d::Zero();
};

/// What was known of a point before it was left out: by the control, by the coordinates of a file, or keyed in.
Place known_place(const std::string& id, const SurveyObservations& survey, const ControlPoints& control,
                  double known_sigma) {
  Place known;
  const auto at = std::find(control.ids.begin(), control.ids.end(), id);
  if (at != control.ids.end()) {
    const auto row = static_cast<Eigen::Index>(3 * (at - control.ids.begin()));
    known.position = control.coordinates.segment<3>(row);
    if (control.covariance.size() > 0) known.covariance = control.covariance.block<3, 3>(row, row);
    return known;
  }
  for (const CoordinateGroup& group : survey.coordinates) {
    if (!group.is_control) continue;
    for (std::size_t a = 0; a < group.components.size(); ++a) {
      if (group.components[a].point != id) continue;
      const auto row = static_cast<Eigen::Index>(a);
      known.position[group.components[a].axis] = group.values[row];
      known.covariance(group.components[a].axis, group.components[a].axis) = group.covariance(row, row);
    }
  }
  for (const Point& point : survey.points)
    for (int axis = 0; point.id == id && axis < 3; ++axis) {
      const bool fixed = point.roles[static_cast<std::size_t>(axis)] == CoordinateRole::fixed;
      if ((!fixed && !point.known[static_cast<std::size_t>(axis)]) || std::isfinite(known.position[axis])) continue;
      known.position[axis] = point.coordinates[axis];
      if (!fixed) known.covariance(axis, axis) = known_sigma * known_sigma;
    }
  return known;
}

KnownPoint compared(const std::string& id, const Place& known, const NetworkResult& adjusted) {
  KnownPoint result;
  result.id = id;
  const auto point =
      std::find_if(adjusted.points.begin(), adjusted.points.end(), [&](const ResultPoint& p) { return p.id == id; });
  if (point == adjusted.points.end()) return result;
  const Matrix3d covariance = adjusted.covariance(*point, *point) + known.covariance;
  std::vector<Eigen::Index> axes;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double difference = point->position[axis] - known.position[axis];
    if (!std::isfinite(difference) || !std::isfinite(covariance(axis, axis))) continue;
    axes.push_back(axis);
    result.difference[axis] = difference, result.sigma[axis] = std::sqrt(known.covariance(axis, axis));
  }
  if (axes.empty()) return result;
  Eigen::MatrixXd of_both = covariance(axes, axes);
  of_both.diagonal().array() += kWritten * kWritten / 3;
  const Eigen::VectorXd difference = result.difference(axes);
  result.statistic = difference.dot(of_both.ldlt().solve(difference));
  result.rank = static_cast<int>(axes.size());
  return result;
}

}  // namespace

std::vector<KnownPoint> compare_with_left_out(const SurveyObservations& survey, const ControlPoints& control,
                                              const AdjustOptions& options, const NetworkResult& adjusted) {
  std::vector<KnownPoint> left_out;
  std::set<std::string> ids;  // one may be excluded in two places
  for (const ExcludedItem& item : options.exclude)
    if (item.kind == ExcludedItem::Kind::control && ids.insert(item.what).second)
      left_out.push_back(compared(item.what, known_place(item.what, survey, control, options.known_sigma), adjusted));
  const auto tested = std::count_if(left_out.begin(), left_out.end(), [](const KnownPoint& k) { return k.rank > 0; });
  for (KnownPoint& k : left_out)
    if (k.rank > 0) k.critical = chi_squared_quantile(1 - kAlphaOfAll / static_cast<double>(tested), k.rank);
  return left_out;
}

}  // namespace plumbline::survey

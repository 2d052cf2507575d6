#include "least_squares/problem/defects.hpp"

#include <fmt/core.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/linear_algebra/decompositions.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::least_squares {
namespace {

constexpr double undetermined_ratio = 1000;
constexpr double no_information = 1e-12;  ///< [1/m²]: a standard deviation of 1000 km

std::string text(const Eigen::Vector3d& v) { return fmt::format("({:.3f}, {:.3f}, {:.3f})", v.x(), v.y(), v.z()); }

/// Axis names where a direction is one.
std::string direction(Eigen::Vector3d v) {
  v.normalize();
  Eigen::Index largest = 0;
  v.cwiseAbs().maxCoeff(&largest);
  if (v(largest) < 0) v = -v;
  const char* names[] = {"x", "y", "z"};
  if (v(largest) > 1 - 1e-9) return names[largest];
  return text(v);
}

/// Orthonormal basis of the part of `subspace` on which `rows` of it vanish, and of the rest.
void split(const Eigen::MatrixXd& subspace, const Eigen::MatrixXd& rows, Eigen::MatrixXd& vanishing,
           Eigen::MatrixXd& rest) {
  const linear_algebra::SingularValues svd(rows, Eigen::ComputeFullV);
  const Eigen::Index columns = subspace.cols();
  Eigen::Index rank = 0;
  while (rank < svd.singularValues().size() && svd.singularValues()(rank) > 1e-4) ++rank;
  rest = subspace * svd.matrixV().leftCols(rank);
  vanishing = subspace * svd.matrixV().rightCols(columns - rank);
}

std::string describe_rotation(const Eigen::Vector3d& axis, const Eigen::Vector3d& through, double extent,
                              const std::vector<NamedPoint>& fixed) {
  Eigen::Vector3d unit = axis.normalized();
  Eigen::Index largest = 0;
  unit.cwiseAbs().maxCoeff(&largest);
  if (unit(largest) < 0) unit = -unit;  // so that the two points come in an order that does not hang on rounding
  std::vector<const NamedPoint*> on_axis;
  for (const auto& point : fixed)
    if ((point.position - through).cross(unit).norm() < 0.02 * extent) on_axis.push_back(&point);
  std::sort(on_axis.begin(), on_axis.end(),
            [&](const NamedPoint* a, const NamedPoint* b) { return a->position.dot(unit) < b->position.dot(unit); });
  if (on_axis.size() >= 2 && (on_axis.back()->position - on_axis.front()->position).norm() > 1e-3 * extent)
    return "rotation about the line through " + on_axis.front()->name + " and " + on_axis.back()->name;
  if (on_axis.size() == 1)
    return "rotation about the axis through " + on_axis.front()->name + " along " + direction(unit);
  return "rotation about the axis through " + text(through) + " along " + direction(unit);
}

/// Rotations of a subspace whose scale is zero and in which no translation is left (`translations`: those split off
/// before).
void name_rotations(const Eigen::MatrixXd& rotations, const Eigen::MatrixXd& translations,
                    const Eigen::Vector3d& centre, double extent, const std::vector<NamedPoint>& fixed,
                    std::vector<std::string>& names) {
  const Eigen::Index count = rotations.cols();
  Eigen::MatrixXd axes = rotations.middleRows(3, 3);
  Eigen::MatrixXd combination = Eigen::MatrixXd::Identity(count, count);
  if (count == 3) combination = axes.inverse();  // all rotations are open: the axes x, y, z tell it best
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::VectorXd motion = rotations * combination.col(i);
    const Eigen::Vector3d axis = motion.segment<3>(3);
    // Free translations may be added at will: with all three free, the axis may pass through the centre.
    Eigen::Vector3d shift = motion.head<3>() * extent;
    if (translations.cols() > 0) {
      const Eigen::MatrixXd free = translations.topRows(3);
      shift -= free * linear_algebra::minimum_norm_solution(free, shift);
    }
    const Eigen::Vector3d through = centre + axis.cross(shift) / axis.squaredNorm();
    names.push_back(describe_rotation(axis, through, extent, fixed));
  }
}

}  // namespace

Eigen::Vector3d centre_of(const std::vector<NamedPoint>& points) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : points) sum += point.position;
  return points.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(points.size()));
}

Eigen::MatrixXd motion_basis(const std::vector<NamedPoint>& points, const Eigen::Vector3d& centre) {
  Eigen::MatrixXd basis(3 * static_cast<Eigen::Index>(points.size()), motion_count);
  for (size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d arm = points[i].position - centre;
    auto rows = basis.middleRows<3>(3 * static_cast<Eigen::Index>(i));
    rows.leftCols<3>().setIdentity();
    rows.middleCols<3>(3) = -skew(arm);
    rows.col(6) = arm;
  }
  return basis;
}

std::vector<std::string> describe_motions(const Eigen::MatrixXd& subspace, const Eigen::Vector3d& centre, double extent,
                                          const std::vector<NamedPoint>& fixed) {
  std::vector<std::string> names;
  if (subspace.cols() == 0) return names;
  // Translations in units of the extent, so that all seven numbers are comparable; then an orthonormal basis.
  Eigen::MatrixXd scaled = subspace;
  scaled.topRows(3) /= extent;
  scaled = linear_algebra::orthonormal_columns(scaled);
  Eigen::MatrixXd rigid, scale, translations, rotations;
  split(scaled, scaled.row(6), rigid, scale);
  if (rigid.cols() > 0) split(rigid, rigid.middleRows(3, 3), translations, rotations);
  if (translations.cols() == 3) {
    for (const char* axis : {"x", "y", "z"}) names.push_back(std::string("translation along ") + axis);
  } else {
    for (Eigen::Index i = 0; i < translations.cols(); ++i)
      names.push_back("translation along " + direction(translations.col(i).head<3>()));
  }
  if (rotations.cols() > 0) name_rotations(rotations, translations, centre, extent, fixed, names);
  if (scale.cols() > 0) names.push_back("scale");
  return names;
}

DatumAnalysis analyse_datum(const Eigen::MatrixXd& information, const std::vector<NamedPoint>& points,
                            const std::vector<NamedPoint>& fixed, bool with_scale, double weak_ratio) {
  const Eigen::Index count = with_scale ? motion_count : motion_count - 1;
  const Eigen::Vector3d centre = centre_of(points);
  const Eigen::MatrixXd basis = motion_basis(points, centre).leftCols(count);
  const Eigen::MatrixXd metric = basis.transpose() * basis / static_cast<double>(points.size());
  double extent = 0;
  for (const auto& point : points) extent = std::max(extent, (point.position - centre).norm());
  // Points on one line leave the metric itself singular; a small share of the extent keeps their rotation comparable.
  Eigen::MatrixXd regular = metric;
  regular.diagonal().array() += 1e-6 * std::max(1e-6, extent * extent);
  const linear_algebra::GeneralizedSymmetricEigen solver(information.topLeftCorner(count, count), regular);
  const Eigen::VectorXd& values = solver.eigenvalues();
  const double best = std::max(values.maxCoeff(), 1e-300);
  DatumAnalysis result;
  std::vector<int> open, weak;
  for (int i = 0; i < count; ++i) {
    const double ratio = std::sqrt(best / std::max(values(i), 1e-300));
    if (values(i) < no_information || ratio > undetermined_ratio) {
      open.push_back(i);
    } else {
      result.weakest_sigma = std::max(result.weakest_sigma, 1 / std::sqrt(values(i)));
      if (ratio > weak_ratio) weak.push_back(i);
    }
  }
  const auto describe = [&](const std::vector<int>& which) {
    Eigen::MatrixXd subspace = Eigen::MatrixXd::Zero(motion_count, static_cast<Eigen::Index>(which.size()));
    subspace.topRows(count) = solver.eigenvectors()(Eigen::all, which);
    return describe_motions(subspace, centre, std::max(extent, 1e-9), fixed);
  };
  result.undetermined = describe(open);
  result.weak = describe(weak);
  return result;
}

}  // namespace plumbline::least_squares

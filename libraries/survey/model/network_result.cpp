#include "survey/model/network_result.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plumbline::survey {

bool NetworkResult::compares_known_points() const {
  return std::any_of(known_points.begin(), known_points.end(), [](const KnownPoint& k) { return k.rank > 0; });
}

const ResultPoint& NetworkResult::point(const std::string& id) const {
  for (const ResultPoint& p : points)
    if (p.id == id) return p;
  throw std::out_of_range("no point '" + id + "' in the network");
}

namespace {

/// Of a coordinate that does not exist NaN, of one that is held zero.
Eigen::MatrixXd covariance_of_points(const std::vector<const ResultPoint*>& points,
                                     const least_squares::Cofactors& cofactors) {
  std::vector<int> unknowns;
  std::vector<Eigen::Index> rows, missing;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto row = static_cast<Eigen::Index>(3 * i + k);
      if (std::isnan(points[i]->position[static_cast<Eigen::Index>(k)])) missing.push_back(row);
      if (points[i]->unknowns[k] < 0 || (!missing.empty() && missing.back() == row)) continue;
      unknowns.push_back(points[i]->unknowns[k]);
      rows.push_back(row);
    }
  const auto n = static_cast<Eigen::Index>(3 * points.size());
  Eigen::MatrixXd result = Eigen::MatrixXd::Zero(n, n);
  result(rows, rows) = cofactors.joint(unknowns);
  for (const Eigen::Index row : missing) {
    result.row(row).setConstant(kNotGiven);
    result.col(row).setConstant(kNotGiven);
  }
  return result;
}

}  // namespace

Eigen::Matrix3d NetworkResult::covariance(const ResultPoint& a, const ResultPoint& b) const {
  if (!cofactors.is_whole()) {
    if (&a == &b || a.id == b.id) return covariance_of_points({&a}, cofactors);
    return covariance_of_points({&a, &b}, cofactors).topRightCorner<3, 3>();
  }
  Eigen::Matrix3d c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const bool exist = !std::isnan(a.position[i]) && !std::isnan(b.position[j]);
      const bool both = a.unknowns[i] >= 0 && b.unknowns[j] >= 0;
      c(i, j) = !exist ? kNotGiven : both ? cofactors(a.unknowns[i], b.unknowns[j]) : 0.0;
    }
  return c;
}

Eigen::Matrix3d NetworkResult::relative_covariance(const ResultPoint& a, const ResultPoint& b) const {
  if (!cofactors.is_whole()) {
    const Eigen::MatrixXd c = covariance_of_points({&a, &b}, cofactors);
    return c.topLeftCorner<3, 3>() + c.bottomRightCorner<3, 3>() - c.topRightCorner<3, 3>() -
           c.bottomLeftCorner<3, 3>();
  }
  const Eigen::Matrix3d ab = covariance(a, b);
  return covariance(a, a) + covariance(b, b) - ab - ab.transpose();
}

Eigen::MatrixXd NetworkResult::covariance_of(const std::vector<std::size_t>& some) const {
  std::vector<const ResultPoint*> chosen;
  for (const std::size_t i : some) chosen.push_back(&points.at(i));
  return covariance_of_points(chosen, cofactors);
}

Eigen::MatrixXd NetworkResult::full_covariance() const {
  if (!cofactors.is_whole())
    throw std::runtime_error("the joint covariance of all " + std::to_string(points.size()) + " points would take " +
                             std::to_string(72 * points.size() * points.size() >> 20U) +
                             " MiB and was not made: ask for some of the points, or for the whole (covariance=full)");
  const auto n = static_cast<Eigen::Index>(points.size());
  Eigen::MatrixXd full(3 * n, 3 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) full.block<3, 3>(3 * i, 3 * j) = covariance(points[i], points[j]);
  return full;
}

}  // namespace plumbline::survey

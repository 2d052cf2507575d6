#include "geometry/tag_under_pose.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/vectors.hpp"

namespace plumbline {
namespace {

using Matrix36 = Eigen::Matrix<double, 3, 6>;

/// Mean of the rotation matrices exp([w]x), w normal with `sigma` about each axis: this multiple of the identity. A
/// turned plate looks smaller whichever way it is turned, so without it the camera would seem too far away.
double mean_rotation(double sigma) {
  const double square = sigma * sigma;
  return (1 + 2 * (1 - square) * std::exp(-0.5 * square)) / 3;
}

/// The second-order part of a rotation, (w wᵀ − |w|² I) c / 2, is linear in the products of the components of w, which
/// have variances 2 sigma⁴ (squares) and sigma⁴ (mixed) and no covariances: its derivatives by them in that measure.
Matrix36 by_products(const Eigen::Vector3d& c, double sigma) {
  Matrix36 columns;
  for (int i = 0; i < 3; ++i) {
    columns.col(i) = std::numbers::sqrt2 * 0.5 * (c(i) * Eigen::Vector3d::Unit(i) - c);
    const int j = (i + 1) % 3;
    columns.col(3 + i) = 0.5 * (c(j) * Eigen::Vector3d::Unit(i) + c(i) * Eigen::Vector3d::Unit(j));
  }
  return sigma * sigma * columns;
}

/// L⁻¹ rows, then sums += rowsᵀ rows; 8 × 8 row by row each, of the sums the first seven rows.
PLUMBLINE_CLONES
void whiten_and_add(const double* lower, const double* inverse, double* rows, double* sums) {
  for (int r = 0; r < 8; ++r) {
    double* own = rows + 8 * r;
    V4 left = load<V4>(own), right = load<V4>(own + 4);
    for (int k = 0; k < r; ++k) {
      const double factor = lower[8 * r + k];
      left -= factor * load<V4>(rows + 8 * k);
      right -= factor * load<V4>(rows + 8 * k + 4);
    }
    store<V4>(own, left * inverse[r]);
    store<V4>(own + 4, right * inverse[r]);
  }
  for (int c = 0; c < 7; ++c) {
    double* to = sums + 8 * c;
    V4 left = load<V4>(to), right = load<V4>(to + 4);
    for (int r = 0; r < 8; ++r) {
      const double factor = rows[8 * r + c];
      left += factor * load<V4>(rows + 8 * r);
      right += factor * load<V4>(rows + 8 * r + 4);
    }
    store<V4>(to, left);
    store<V4>(to + 4, right);
  }
}

}  // namespace

bool TagWeight::compute(const Eigen::Matrix<double, 8, 8>& covariance) {
  for (int c = 0; c < 8; ++c) {
    const double pivot = covariance(c, c) - lower_.row(c).head(c).squaredNorm();
    if (!(pivot > 0)) return false;
    inverse_(c) = 1 / std::sqrt(pivot);
    for (int r = c + 1; r < 8; ++r) {
      double sum = covariance(r, c);
      for (int k = 0; k < c; ++k) sum -= lower_(r, k) * lower_(c, k);
      lower_(r, c) = sum * inverse_(c);
    }
  }
  return true;
}

void PoseEquations::add(const ProjectedTag& tag, const TagWeight& weight) {
  Eigen::Matrix<double, 8, 8, Eigen::RowMajor> rows;  // by a rotation vector in the camera frame and the translation
  for (int i = 0; i < 4; ++i) {
    const auto k = static_cast<std::size_t>(i);
    rows.block<2, 3>(2 * i, 0) = -tag.by_point[k] * skew(tag.rotated[k]);
    rows.block<2, 3>(2 * i, 3) = tag.by_point[k];
  }
  rows.col(6) = tag.residuals;
  rows.col(7).setZero();
  whiten_and_add(weight.lower_.data(), weight.inverse_.data(), rows.data(), sums.data());
}

TagInWorld::TagInWorld(const TagView& view, double sigma)
    : pixels_(view.pixels), pixel_covariances_(view.pixel_covariances) {
  const double shrunk = mean_rotation(sigma);
  std::array<Eigen::Matrix3d, 4> turned;
  std::array<Matrix36, 4> products;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d arm = view.corner_in_world(static_cast<int>(i)) - view.anchor_in_world;
    corners_[i] = view.anchor_in_world + shrunk * arm;
    turned[i] = sigma * skew(arm);
    products[i] = by_products(arm, sigma);
    for (std::size_t j = 0; j <= i; ++j)
      spread_[i][j] =
          view.anchor_covariance + turned[i] * turned[j].transpose() + products[i] * products[j].transpose();
  }
}

bool TagInWorld::project(const BrownCamera& camera, const MatrixPose& pose, ProjectedTag& tag) const {
  for (std::size_t i = 0; i < 4; ++i) {
    tag.rotated[i] = pose.rotation * corners_[i];
    const auto projection = project_with_slope(camera, tag.rotated[i] + pose.translation);
    if (!projection) return false;
    tag.residuals.segment<2>(static_cast<Eigen::Index>(2 * i)) = pixels_[i] - projection->pixel;
    tag.by_point[i] = projection->by_point;
  }
  return tag.residuals.allFinite();
}

Eigen::Matrix<double, 8, 8> TagInWorld::covariance(const MatrixPose& pose, const ProjectedTag& tag) const {
  Eigen::Matrix<double, 8, 8> result;
  std::array<Eigen::Matrix<double, 2, 3>, 4> by_world;
  for (std::size_t i = 0; i < 4; ++i) {
    by_world[i] = tag.by_point[i] * pose.rotation;
    const auto row = static_cast<Eigen::Index>(2 * i);
    for (std::size_t j = 0; j <= i; ++j)
      result.block<2, 2>(row, static_cast<Eigen::Index>(2 * j)) =
          (by_world[i] * spread_[i][j]).eval() * by_world[j].transpose();
    result.block<2, 2>(row, row) += pixel_covariances_[i];
  }
  return result;
}

double TagInWorld::distance(const BrownCamera& camera, const MatrixPose& pose) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  ProjectedTag tag;
  TagWeight weight;
  if (!project(camera, pose, tag) || !weight.compute(covariance(pose, tag))) return infinity;
  weight.whiten(tag.residuals);
  return tag.residuals.squaredNorm();
}

}  // namespace plumbline

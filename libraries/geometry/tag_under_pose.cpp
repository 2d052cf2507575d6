#include "geometry/tag_under_pose.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/lens_distortion.hpp"

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

PLUMBLINE_INLINE V4 at(const OfCorners& numbers) { return load<V4>(numbers.data()); }
PLUMBLINE_INLINE double sum_of(const V4& v) { return (v[0] + v[1]) + (v[2] + v[3]); }
PLUMBLINE_CLONES
bool project_corners(const BrownCamera& camera, const double* rotation, const double* translation,
                     const TagInWorld::Numbers& in, ProjectedTag& tag) {
  const V4 corner[3] = {at(in.corners[0]), at(in.corners[1]), at(in.corners[2])};
  V4 p[3];
  for (std::size_t c = 0; c < 3; ++c) {
    const V4 turned = rotation[c] * corner[0] + rotation[3 + c] * corner[1] + rotation[6 + c] * corner[2];
    store<V4>(tag.rotated[c].data(), turned);
    p[c] = turned + translation[c];
  }
  for (int k = 0; k < 4; ++k)
    if (!(p[2][k] > 0)) return false;
  const V4 inverse = 1 / p[2], x = p[0] * inverse, y = p[1] * inverse;
  Distorted<V4> d;
  distort(camera, x, y, d);
  store<V4>(tag.residuals[0].data(), at(in.pixels[0]) - (camera.fx * d.x + camera.cx));
  store<V4>(tag.residuals[1].data(), at(in.pixels[1]) - (camera.fy * d.y + camera.cy));
  const V4 slope[2][2] = {{camera.fx * d.by_xx * inverse, camera.fx * d.by_xy * inverse},
                          {camera.fy * d.by_xy * inverse, camera.fy * d.by_yy * inverse}};
  for (std::size_t r = 0; r < 2; ++r) {
    store<V4>(tag.by_point[3 * r].data(), slope[r][0]);
    store<V4>(tag.by_point[3 * r + 1].data(), slope[r][1]);
    store<V4>(tag.by_point[3 * r + 2].data(), -(slope[r][0] * x + slope[r][1] * y));
  }
  return std::isfinite(tag.sum_of_squares());
}

/// J S Jᵀ, column by column.
PLUMBLINE_CLONES
void propagate(const double* rotation, const ProjectedTag& tag, const TagInWorld::Numbers& in, TagCovariance& to) {
  V4 by[2][3];  // of each pixel by its corner in the world
  for (std::size_t r = 0; r < 2; ++r)
    for (std::size_t c = 0; c < 3; ++c)
      by[r][c] = at(tag.by_point[3 * r]) * rotation[3 * c] + at(tag.by_point[3 * r + 1]) * rotation[3 * c + 1] +
                 at(tag.by_point[3 * r + 2]) * rotation[3 * c + 2];
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const auto& spread = in.spread[corner];
    V4 half[2][3];
    for (std::size_t r = 0; r < 2; ++r)
      for (std::size_t c = 0; c < 3; ++c)
        half[r][c] = by[r][0] * at(spread[c]) + by[r][1] * at(spread[3 + c]) + by[r][2] * at(spread[6 + c]);
    for (std::size_t q = 0; q < 2; ++q) {
      const double own[3] = {by[q][0][corner], by[q][1][corner], by[q][2][corner]};
      double* column = to[4 * q + corner].data();
      for (std::size_t r = q; r < 2; ++r)
        store<V4>(column + 4 * r, half[r][0] * own[0] + half[r][1] * own[1] + half[r][2] * own[2]);
      for (std::size_t r = q; r < 2; ++r) column[4 * r + corner] += in.pixel_covariances[q + r][corner];
    }
  }
}

PLUMBLINE_CLONES
bool factorise(const TagCovariance& covariance, TagWeight& weight) {
  V4 upper[4], lower[8];  // of each column: rows 0 to 3 (of the first four), 4 to 7
  for (std::size_t c = 0; c < 8; ++c) {
    if (c < 4) upper[c] = load<V4>(covariance[c].data());
    lower[c] = load<V4>(covariance[c].data() + 4);
  }
  for (std::size_t c = 0; c < 8; ++c) {
    double* own = weight.lower[c].data();
    const double pivot = c < 4 ? upper[c][c] : lower[c][c - 4];
    if (!(pivot > 0)) return false;
    const double inverse = weight.inverse_pivots[c] = 1 / pivot;
    store<V4>(own, c < 4 ? upper[c] * inverse : V4{});
    store<V4>(own + 4, lower[c] * inverse);
    for (std::size_t k = c + 1; k < 4; ++k) upper[k] -= own[k] * upper[c];
    for (std::size_t k = c + 1; k < 8; ++k) lower[k] -= own[k] * lower[c];
    for (std::size_t r = 0; r <= c; ++r) own[r] = 0;
  }
  return true;
}

PLUMBLINE_CLONES
double distance_of(const ProjectedTag& tag, const TagWeight& weight) {
  V4 upper = at(tag.residuals[0]), lower = at(tag.residuals[1]);
  for (std::size_t c = 0; c < 4; ++c) {
    const double y = upper[c];
    upper -= y * load<V4>(weight.lower[c].data());
    lower -= y * load<V4>(weight.lower[c].data() + 4);
  }
  for (std::size_t c = 4; c < 8; ++c) lower -= lower[c - 4] * load<V4>(weight.lower[c].data() + 4);
  return sum_of(upper * upper * load<V4>(weight.inverse_pivots.data()) +
                lower * lower * load<V4>(weight.inverse_pivots.data() + 4));
}

/// Four numbers of four corners to the corners' rows.
PLUMBLINE_INLINE void transpose(const V4& a, const V4& b, const V4& c, const V4& d, double* rows) {
  const V4 ab_low = __builtin_shufflevector(a, b, 0, 4, 2, 6), ab_high = __builtin_shufflevector(a, b, 1, 5, 3, 7),
           cd_low = __builtin_shufflevector(c, d, 0, 4, 2, 6), cd_high = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  store<V4>(rows, __builtin_shufflevector(ab_low, cd_low, 0, 1, 4, 5));
  store<V4>(rows + 8, __builtin_shufflevector(ab_high, cd_high, 0, 1, 4, 5));
  store<V4>(rows + 16, __builtin_shufflevector(ab_low, cd_low, 2, 3, 6, 7));
  store<V4>(rows + 24, __builtin_shufflevector(ab_high, cd_high, 2, 3, 6, 7));
}

/// Derivatives by a rotation vector in the camera frame and the translation, and the residuals, times L⁻¹; then sums +=
/// rowsᵀ D⁻¹ rows, of the sums the first seven rows.
PLUMBLINE_CLONES
void whiten_and_add(const ProjectedTag& tag, const TagWeight& weight, double* sums) {
  double rows[64];
  const V4 zero = {0, 0, 0, 0}, arm[3] = {at(tag.rotated[0]), at(tag.rotated[1]), at(tag.rotated[2])};
  for (std::size_t r = 0; r < 2; ++r) {
    const V4 m[3] = {at(tag.by_point[3 * r]), at(tag.by_point[3 * r + 1]), at(tag.by_point[3 * r + 2])};
    transpose(m[2] * arm[1] - m[1] * arm[2], m[0] * arm[2] - m[2] * arm[0], m[1] * arm[0] - m[0] * arm[1], m[0],
              rows + 32 * r);
    transpose(m[1], m[2], at(tag.residuals[r]), zero, rows + 32 * r + 4);
  }
  for (std::size_t r = 1; r < 8; ++r) {
    double* own = rows + 8 * r;
    V4 left = load<V4>(own), right = load<V4>(own + 4);
    for (std::size_t k = 0; k < r; ++k) {
      const double factor = weight.lower[k][r];
      left -= factor * load<V4>(rows + 8 * k);
      right -= factor * load<V4>(rows + 8 * k + 4);
    }
    store<V4>(own, left);
    store<V4>(own + 4, right);
  }
  for (std::size_t c = 0; c < 7; ++c) {
    double* to = sums + 8 * c;
    V4 left = load<V4>(to), right = load<V4>(to + 4);
    for (std::size_t r = 0; r < 8; ++r) {
      const double factor = rows[8 * r + c] * weight.inverse_pivots[r];
      left += factor * load<V4>(rows + 8 * r);
      right += factor * load<V4>(rows + 8 * r + 4);
    }
    store<V4>(to, left);
    store<V4>(to + 4, right);
  }
}

}  // namespace

double ProjectedTag::sum_of_squares() const {
  double sum = 0;
  for (const OfCorners& axis : residuals)
    for (const double residual : axis) sum += residual * residual;
  return sum;
}

bool TagWeight::compute(const TagCovariance& covariance) { return factorise(covariance, *this); }

double TagWeight::distance(const ProjectedTag& tag) const { return distance_of(tag, *this); }

void PoseEquations::add(const ProjectedTag& tag, const TagWeight& weight) { whiten_and_add(tag, weight, sums.data()); }

TagInWorld::TagInWorld(const TagView& view, const TagPoseOptions& options) {
  const double sigma = options.plate_rotation_sigma, of_shape = options.tag_shape_sigma * view.tag_size;
  const double shrunk = mean_rotation(sigma);
  std::array<Eigen::Matrix3d, 4> turned;
  std::array<Matrix36, 4> products;
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d arm = view.corner_in_world(static_cast<int>(i)) - view.anchor_in_world;
    const Eigen::Vector3d corner = view.anchor_in_world + shrunk * arm;
    for (std::size_t c = 0; c < 3; ++c) numbers_.corners[c][i] = corner(static_cast<Eigen::Index>(c));
    for (std::size_t c = 0; c < 2; ++c) numbers_.pixels[c][i] = view.pixels[i](static_cast<Eigen::Index>(c));
    const Eigen::Matrix2d& pixel = view.pixel_covariances[i];
    numbers_.pixel_covariances[0][i] = pixel(0, 0);
    numbers_.pixel_covariances[1][i] = pixel(1, 0);
    numbers_.pixel_covariances[2][i] = pixel(1, 1);
    turned[i] = sigma * skew(arm);
    products[i] = by_products(arm, sigma);
  }
  for (std::size_t i = 0; i < 4; ++i)
    for (std::size_t j = 0; j <= i; ++j) {
      Eigen::Matrix3d spread =
          view.anchor_covariance + turned[i] * turned[j].transpose() + products[i] * products[j].transpose();
      if (i == j) spread.diagonal().array() += of_shape * of_shape;  // each corner for itself
      for (std::size_t e = 0; e < 9; ++e) {
        const double value = spread(static_cast<Eigen::Index>(e / 3), static_cast<Eigen::Index>(e % 3));
        numbers_.spread[j][e][i] = value;
        numbers_.spread[i][3 * (e % 3) + e / 3][j] = value;
      }
    }
}

bool TagInWorld::project(const BrownCamera& camera, const MatrixPose& pose, ProjectedTag& tag) const {
  return project_corners(camera, pose.rotation.data(), pose.translation.data(), numbers_, tag);
}

void TagInWorld::covariance(const MatrixPose& pose, const ProjectedTag& tag, TagCovariance& result) const {
  propagate(pose.rotation.data(), tag, numbers_, result);
}

double TagInWorld::distance(const BrownCamera& camera, const MatrixPose& pose) const {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  ProjectedTag tag;
  TagWeight weight;
  TagCovariance spread;
  if (!project(camera, pose, tag)) return infinity;
  covariance(pose, tag, spread);
  return weight.compute(spread) ? weight.distance(tag) : infinity;
}

}  // namespace plumbline

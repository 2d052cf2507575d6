#include "photo/block/tag_bound.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "base/text/words.hpp"
#include "geometry/linear_algebra/decompositions.hpp"
#include "least_squares/problem/defects.hpp"
#include "least_squares/sparse/dense_cholesky.hpp"
#include "photo/bundle/kernels.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::block {

namespace {

using Eigen::Index;
using Matrix26 = Eigen::Matrix<double, 2, 6>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// "the position of A and B", or a motion of the whole block, for a null vector of the scaled information.
std::string name_of_defect(const BoundProblem& problem, const Eigen::VectorXd& change) {
  std::vector<least_squares::NamedPoint> points, held;
  for (const BoundPlate& plate : problem.plates) points.push_back({plate.anchor, plate.position});
  for (const std::size_t j : problem.control) held.push_back(points[j]);
  Eigen::VectorXd moved(static_cast<Index>(3 * points.size()));
  double largest = 0;
  for (std::size_t j = 0; j < points.size(); ++j) {
    moved.segment<3>(static_cast<Index>(3 * j)) = change.segment<3>(static_cast<Index>(6 * j));
    largest = std::max(largest, moved.segment<3>(static_cast<Index>(3 * j)).norm());
  }
  const Eigen::Vector3d centre = least_squares::centre_of(points);
  const Eigen::MatrixXd basis = least_squares::motion_basis(points, centre);
  const Eigen::VectorXd motion = linear_algebra::minimum_norm_solution(basis, moved);
  if (largest > 0 && (basis * motion - moved).norm() < 0.05 * moved.norm()) {
    double extent = 1e-9;
    for (const auto& point : points) extent = std::max(extent, (point.position - centre).norm());
    const auto names = least_squares::describe_motions(motion, centre, extent, held);
    if (!names.empty()) return names.front() + " of the whole block";
  }
  std::vector<std::string> loose;
  for (std::size_t j = 0; j < points.size() && largest > 0; ++j)
    if (moved.segment<3>(static_cast<Index>(3 * j)).norm() > 0.3 * largest) loose.push_back(points[j].name);
  if (loose.size() > 6) loose = {loose[0], loose[1], loose[2], std::to_string(loose.size() - 3) + " others"};
  return loose.empty() ? "the interior orientation" : "the position of " + text::enumerate(loose);
}

Eigen::MatrixXd inverse(const Eigen::MatrixXd& covariance) {
  if (covariance.isDiagonal(0) && (covariance.diagonal().array() > 0).all())
    return covariance.diagonal().cwiseInverse().asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success) throw std::runtime_error("a covariance that is given is not positive definite");
  return factor.solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

}  // namespace

TagBound::TagBound(const BoundProblem& problem, Extent extent)
    : problem_(problem),
      camera_at_(static_cast<Index>(6 * problem.plates.size())),
      batch_at_(camera_at_ + static_cast<Index>(problem.free_parameters.size())),
      size_(batch_at_ + (problem.batch_scale_sigma > 0 ? problem.batches : 0)),
      information_(Eigen::MatrixXd::Zero(size_, size_)) {
  std::vector<std::vector<const BoundTag*>> by_image(problem_.cam_from_world.size());
  for (const BoundTag& tag : problem_.tags) by_image.at(tag.image).push_back(&tag);
  std::vector<Index> place(static_cast<std::size_t>(size_));
  std::iota(place.begin(), place.end(), Index{0});
  for (std::size_t i = 0; i < by_image.size(); ++i) {
    stop_point();
    const std::string name = i < problem_.images.size() ? problem_.images[i] : "number " + std::to_string(i + 1);
    if (!by_image[i].empty()) eliminate(problem_.cam_from_world[i], by_image[i], name, place, information_);
  }
  information_.triangularView<Eigen::StrictlyLower>() = information_.transpose();
  add_priors();
  invert(extent);
}

/// Whitened derivatives of a tag's corners by the pose (rotation in the camera frame, translation) and the rest.
void TagBound::derivatives(const RigidTransform& pose, const BoundTag& tag, DerivativesByPose& by_pose,
                           DerivativesByRest& by_rest) const {
  const BoundPlate& plate = problem_.plates[tag.plate];
  const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix(),
                        plate_rotation = plate.world_from_plate.toRotationMatrix();
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector3d arm = plate_rotation * plate.corners_in_plate[i],
                          in_camera = rotation * (plate.position + arm) + pose.translation;
    const auto projection = project_with_slope(problem_.camera, in_camera);
    if (!projection)
      throw std::runtime_error("anchor " + plate.anchor +
                               " lies behind an image that shows it; poses and points do not "
                               "belong together");
    const Eigen::Matrix2d whiten =
        Eigen::LLT<Eigen::Matrix2d>(tag.covariances[i]).matrixL().solve(Eigen::Matrix2d::Identity());
    const Eigen::Matrix<double, 2, 3> slope = whiten * projection->by_point;
    const auto row = static_cast<Index>(2 * i);
    by_pose.block<2, 3>(row, 0) = -slope * skew(in_camera - pose.translation);
    by_pose.block<2, 3>(row, 3) = slope;
    by_rest.block<2, 3>(row, 0) = slope * rotation;
    by_rest.block<2, 3>(row, 3) = -slope * rotation * skew(arm);
    const auto camera =
        pixel_by_parameters(problem_.camera, in_camera.x() / in_camera.z(), in_camera.y() / in_camera.z());
    for (std::size_t k = 0; k < problem_.free_parameters.size(); ++k)
      by_rest.block<2, 1>(row, 6 + static_cast<Index>(k)) = whiten * camera.col(problem_.free_parameters[k]);
    if (scales_batches())
      by_rest.block<2, 1>(row, 6 + static_cast<Index>(problem_.free_parameters.size())) =
          slope * rotation * plate_rotation * (plate.corners_in_plate[i] - plate.tag_centre_in_plate);
  }
}

/// Adds to a symmetric matrix what an image says of the rest once its pose is eliminated (Schur complement), above the
/// diagonal and on it; `place` tells where in the matrix an unknown is.
void TagBound::eliminate(const RigidTransform& cam_from_world, const std::vector<const BoundTag*>& tags,
                         const std::string& image, const std::vector<Index>& place, Eigen::MatrixXd& matrix) const {
  /// Neighbouring unknowns: where they are in the matrix, and in the derivatives by all that the image touches.
  struct Part {
    Index at;
    int size, column;
  };
  std::vector<Part> parts;
  int width = 0;
  const auto part_of = [&](Index first, Index size) {
    const Index at = place[first];
    const auto known = std::find_if(parts.begin(), parts.end(), [&](const Part& part) { return part.at == at; });
    if (known != parts.end()) return *known;
    parts.push_back({at, static_cast<int>(size), width});
    width += static_cast<int>(size);
    return parts.back();
  };
  const auto cameras = batch_at_ - camera_at_;
  const auto most = static_cast<int>(6 * tags.size() + static_cast<std::size_t>(size_ - camera_at_));
  Matrix6 pose = Matrix6::Zero();
  std::vector<double> cross(static_cast<std::size_t>(6 * most));  // 6 × most, row by row
  DerivativesByPose by_pose;
  DerivativesByRest by_rest;
  for (const BoundTag* tag : tags) {
    derivatives(cam_from_world, *tag, by_pose, by_rest);
    std::array<Part, 3> own;
    std::size_t count = 0;
    own[count++] = part_of(static_cast<Index>(6 * tag->plate), 6);
    if (cameras > 0) own[count++] = part_of(camera_at_, cameras);
    if (scales_batches()) own[count++] = part_of(batch_at_ + problem_.plates[tag->plate].batch, 1);
    std::array<bundle::Outer, 10> jobs;
    int job = 0;
    const auto add = [&](double* to, Index stride, const double* a, int a_size, int a_stride, const double* b,
                         int b_size) { jobs[job++] = {to, stride, a, b, a_size, b_size, a_stride, rest_stride}; };
    jobs[job++] = {pose.data(), 6, by_pose.data(), by_pose.data(), 6, 6, 6, 6};
    for (std::size_t i = 0, from = 0; i < count; from += static_cast<std::size_t>(own[i++].size)) {
      add(cross.data() + own[i].column, most, by_pose.data(), 6, 6, by_rest.data() + from, own[i].size);
      for (std::size_t j = 0, other = 0; j < count; other += static_cast<std::size_t>(own[j++].size))
        if (own[i].at >= own[j].at)
          add(&matrix(own[j].at, own[i].at), matrix.rows(), by_rest.data() + from, own[i].size, rest_stride,
              by_rest.data() + other, own[j].size);
    }
    bundle::add_outer(8, jobs.data(), job);
  }
  // Rotations are of order one and translations of metres, so the pivots can be compared with the largest.
  const Eigen::LDLT<Matrix6> factor(pose);
  if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 1e-12 * factor.vectorD().maxCoeff()))
    throw std::runtime_error("image " + image + " with " + std::to_string(tags.size()) +
                             " tags does not determine its pose");
  using Rows = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::RowMajor>;
  const Rows solved = -factor.solve(Eigen::Map<const Rows>(cross.data(), 6, most));
  std::vector<bundle::Outer> jobs;
  for (const Part& a : parts)
    for (const Part& b : parts)
      if (a.at >= b.at)
        jobs.push_back({&matrix(b.at, a.at), matrix.rows(), cross.data() + a.column, solved.data() + b.column, a.size,
                        b.size, most, most});
  bundle::add_outer(6, jobs.data(), static_cast<int>(jobs.size()));
}

void TagBound::add_priors() {
  const Index cameras = batch_at_ - camera_at_;
  if (problem_.camera_prior.size() > 0)
    information_.block(camera_at_, camera_at_, cameras, cameras) += inverse(problem_.camera_prior);
  if (scales_batches())
    for (Index k = batch_at_; k < size_; ++k)
      information_(k, k) += 1 / (problem_.batch_scale_sigma * problem_.batch_scale_sigma);
  std::vector<Index> rows;
  for (const std::size_t j : problem_.control)
    for (Index c = 0; c < 3; ++c) rows.push_back(static_cast<Index>(6 * j) + c);
  if (!rows.empty()) information_(rows, rows) += inverse(problem_.control_covariance);
}

void TagBound::invert(Extent extent) {
  // Scaled to a unit diagonal (Jacobi), so that the pivots tell what is determined. Plates that no image shows are
  // left out; their bound is infinite. Coordinates of anchors come last: theirs can be had alone.
  std::vector<Index> used;
  const auto take = [&](bool coordinates) {
    for (Index k = 0; k < size_; ++k)
      if (information_(k, k) > 0 && (k < camera_at_ && k % 6 < 3) == coordinates) used.push_back(k);
    return static_cast<Index>(used.size());
  };
  const Index first = extent == Extent::anchors ? take(false) : 0;
  if (extent == Extent::everything) take(false);
  take(true);
  const Eigen::VectorXd scale = information_.diagonal()(used).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * information_(used, used) * scale.asDiagonal();
  const Eigen::MatrixXd inverse = inverse_of_scaled(scaled, used, scale, first);
  const std::vector<Index> wanted(used.begin() + first, used.end());
  const auto wanted_scale = scale.tail(inverse.rows()).asDiagonal();
  covariance_ = Eigen::MatrixXd::Zero(size_, size_);
  covariance_.diagonal().setConstant(std::numeric_limits<double>::infinity());
  covariance_(wanted, wanted) = wanted_scale * inverse * wanted_scale;
}

/// The block of the inverse from unknown `first` on. Throws if pivots say that something is undetermined. Those in the
/// order of the unknowns are quick to have and enough where they are far from nothing; the others are decided by
/// pivoting.
Eigen::MatrixXd TagBound::inverse_of_scaled(const Eigen::MatrixXd& scaled, const std::vector<Index>& used,
                                            const Eigen::VectorXd& scale, Index first) const {
  constexpr double certain = 1e-9, undetermined = 1e-13;
  least_squares::Cholesky quick;
  if (quick.compute(scaled) && quick.smallest_pivot() > certain) return quick.inverse(first);
  const Eigen::LDLT<Eigen::MatrixXd> factor(scaled);
  if (factor.info() == Eigen::Success && factor.vectorD().minCoeff() > undetermined) {
    const Eigen::MatrixXd all = factor.solve(Eigen::MatrixXd::Identity(scaled.rows(), scaled.cols()));
    return all.bottomRightCorner(scaled.rows() - first, scaled.rows() - first);
  }
  const linear_algebra::SymmetricEigen spectrum(scaled);
  Eigen::VectorXd change = Eigen::VectorXd::Zero(size_);
  change(used) = scale.cwiseProduct(spectrum.eigenvectors().col(0));
  throw std::runtime_error("the geometry leaves " + name_of_defect(problem_, change) +
                           " undetermined: control that is missing or lies on one line, or plates in too few images");
}

Eigen::MatrixXd TagBound::anchors() const {
  std::vector<Index> rows;
  for (std::size_t j = 0; j < problem_.plates.size(); ++j)
    for (Index c = 0; c < 3; ++c) rows.push_back(static_cast<Index>(6 * j) + c);
  return covariance_(rows, rows);
}

BoundInformation TagBound::of_image(const RigidTransform& cam_from_world, const std::vector<BoundTag>& tags) const {
  std::vector<const BoundTag*> known;
  for (const BoundTag& tag : tags)
    if (information_(static_cast<Index>(6 * tag.plate), static_cast<Index>(6 * tag.plate)) > 0) known.push_back(&tag);
  BoundInformation result;
  std::vector<Index> place(static_cast<std::size_t>(size_), -1);
  const auto take = [&](Index first, Index size) {
    if (size == 0 || place[first] >= 0) return;
    for (Index k = first; k < first + size; ++k) {
      place[k] = static_cast<Index>(result.unknowns.size());
      result.unknowns.push_back(k);
    }
  };
  for (const BoundTag* tag : known) {
    take(static_cast<Index>(6 * tag->plate), 6);
    take(camera_at_, batch_at_ - camera_at_);
    if (scales_batches()) take(batch_at_ + problem_.plates[tag->plate].batch, 1);
  }
  if (known.empty()) return result;
  const auto used = static_cast<Index>(result.unknowns.size());
  result.matrix.setZero(used, used);
  eliminate(cam_from_world, known, "that is added", place, result.matrix);
  result.matrix.triangularView<Eigen::StrictlyLower>() = result.matrix.transpose();
  return result;
}

BoundInformation TagBound::of_survey(std::size_t plate, double sigma) const {
  BoundInformation result;
  for (Index c = 0; c < 3; ++c) result.unknowns.push_back(static_cast<Index>(6 * plate) + c);
  result.matrix = Eigen::Matrix3d::Identity() / (sigma * sigma);
  return result;
}

Eigen::VectorXd TagBound::height_gain(const BoundInformation& more, const std::vector<std::size_t>& plates) const {
  if (more.unknowns.empty()) return Eigen::VectorXd::Zero(static_cast<Index>(plates.size()));
  std::vector<Index> heights;
  for (const std::size_t j : plates) heights.push_back(static_cast<Index>(6 * j + 2));
  const auto n = static_cast<Index>(more.unknowns.size());
  const Eigen::MatrixXd across = covariance_(heights, more.unknowns),
                        grown =
                            Eigen::MatrixXd::Identity(n, n) + covariance_(more.unknowns, more.unknowns) * more.matrix;
  // R (I + C R)^-1 is symmetric, so its transpose can be solved for.
  const Eigen::MatrixXd weight = linear_algebra::solve(grown.transpose(), more.matrix);
  return (across * weight).cwiseProduct(across).rowwise().sum();
}

Eigen::MatrixXd tag_bound(const BoundProblem& problem) {
  return TagBound(problem, TagBound::Extent::anchors).anchors();
}

}  // namespace plumbline::block

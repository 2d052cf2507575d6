#include "judgement/tag_bound.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "plumbline/stop.hpp"

namespace plumbline::evaluate {

namespace {

using Eigen::Index;
using Matrix26 = Eigen::Matrix<double, 2, 6>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Derivatives of a pixel by the camera's parameters, by central differences: the model is smooth and of order one.
Eigen::Matrix<double, 2, BrownCamera::parameter_count> by_camera(const BrownCamera& camera, double x, double y) {
  Eigen::Matrix<double, 2, BrownCamera::parameter_count> slope;
  const auto values = camera.parameters();
  for (int i = 0; i < BrownCamera::parameter_count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double step = i < 4 ? 1e-2 : 1e-5;
    Eigen::Vector2d ends[2];
    for (int side = 0; side < 2; ++side) {
      auto moved = values;
      moved[k] += side ? step : -step;
      project_normalised(moved.data(), x, y, ends[side].data());
    }
    slope.col(i) = (ends[1] - ends[0]) / (2 * step);
  }
  return slope;
}

class Bound {
 public:
  explicit Bound(const BoundProblem& problem)
      : p_(problem),
        camera_at_(static_cast<Index>(6 * problem.plates.size())),
        batch_at_(camera_at_ + static_cast<Index>(problem.free_parameters.size())),
        size_(batch_at_ + (problem.batch_scale_sigma > 0 ? problem.batches : 0)),
        rest_(Eigen::MatrixXd::Zero(size_, size_)) {}

  Eigen::MatrixXd solve() {
    std::vector<std::vector<const BoundTag*>> by_image(p_.cam_from_world.size());
    for (const BoundTag& tag : p_.tags) by_image.at(tag.image).push_back(&tag);
    for (std::size_t i = 0; i < by_image.size(); ++i) {
      stop_point();
      if (!by_image[i].empty()) eliminate(i, by_image[i]);
    }
    add_priors();
    return anchors();
  }

 private:
  bool scales_batches() const { return p_.batch_scale_sigma > 0; }

  /// Columns of the rest that a tag touches: its plate, the camera, its batch.
  std::vector<Index> columns_of(const BoundTag& tag) const {
    std::vector<Index> columns;
    for (Index k = 0; k < 6; ++k) columns.push_back(static_cast<Index>(6 * tag.plate) + k);
    for (Index k = camera_at_; k < batch_at_; ++k) columns.push_back(k);
    if (scales_batches()) columns.push_back(batch_at_ + p_.plates[tag.plate].batch);
    return columns;
  }

  /// Whitened derivatives of a tag's corners by the pose (rotation in the camera frame, translation) and the rest.
  void derivatives(const BoundTag& tag, Eigen::Matrix<double, 8, 6>& by_pose, Eigen::MatrixXd& by_rest) const {
    const RigidTransform& pose = p_.cam_from_world[tag.image];
    const BoundPlate& plate = p_.plates[tag.plate];
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix(),
                          plate_rotation = plate.world_from_plate.toRotationMatrix();
    for (std::size_t i = 0; i < 4; ++i) {
      const Eigen::Vector3d arm = plate_rotation * plate.corners_in_plate[i],
                            in_camera = rotation * (plate.position + arm) + pose.translation;
      const auto projection = project_with_slope(p_.camera, in_camera);
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
      const auto camera = by_camera(p_.camera, in_camera.x() / in_camera.z(), in_camera.y() / in_camera.z());
      for (std::size_t k = 0; k < p_.free_parameters.size(); ++k)
        by_rest.block<2, 1>(row, 6 + static_cast<Index>(k)) = whiten * camera.col(p_.free_parameters[k]);
      if (scales_batches())
        by_rest.block<2, 1>(row, by_rest.cols() - 1) =
            slope * rotation * plate_rotation * (plate.corners_in_plate[i] - plate.tag_centre_in_plate);
    }
  }

  /// Adds what an image says of the rest once its pose is eliminated (Schur complement).
  void eliminate(std::size_t image, const std::vector<const BoundTag*>& tags) {
    Matrix6 pose = Matrix6::Zero();
    std::vector<Index> place(static_cast<std::size_t>(size_), -1), columns;
    Eigen::MatrixXd cross = Eigen::MatrixXd::Zero(6, static_cast<Index>(6 * tags.size()) + size_ - camera_at_);
    for (const BoundTag* tag : tags) {
      const std::vector<Index> touched = columns_of(*tag);
      Eigen::Matrix<double, 8, 6> by_pose;
      Eigen::MatrixXd by_rest(8, static_cast<Index>(touched.size()));
      derivatives(*tag, by_pose, by_rest);
      pose += by_pose.transpose() * by_pose;
      const Eigen::MatrixXd own = by_rest.transpose() * by_rest, mixed = by_pose.transpose() * by_rest;
      for (std::size_t a = 0; a < touched.size(); ++a) {
        for (std::size_t b = 0; b < touched.size(); ++b)
          rest_(touched[a], touched[b]) += own(static_cast<Index>(a), static_cast<Index>(b));
        Index& where = place[static_cast<std::size_t>(touched[a])];
        if (where < 0) {
          where = static_cast<Index>(columns.size());
          columns.push_back(touched[a]);
        }
        cross.col(where) += mixed.col(static_cast<Index>(a));
      }
    }
    // Rotations are of order one and translations of metres, so the pivots can be compared with the largest.
    const Eigen::LDLT<Matrix6> factor(pose);
    if (factor.info() != Eigen::Success || !(factor.vectorD().minCoeff() > 1e-12 * factor.vectorD().maxCoeff()))
      throw std::runtime_error("image " + std::to_string(image + 1) + " with " + std::to_string(tags.size()) +
                               " tags does not determine its pose");
    const auto used = static_cast<Index>(columns.size());
    const Eigen::MatrixXd reduced = cross.leftCols(used).transpose() * factor.solve(cross.leftCols(used));
    for (Index a = 0; a < used; ++a)
      for (Index b = 0; b < used; ++b)
        rest_(columns[static_cast<std::size_t>(a)], columns[static_cast<std::size_t>(b)]) -= reduced(a, b);
  }

  void add_priors() {
    if (p_.camera_prior.size() > 0)
      rest_.block(camera_at_, camera_at_, batch_at_ - camera_at_, batch_at_ - camera_at_) += inverse(p_.camera_prior);
    if (scales_batches())
      for (Index k = batch_at_; k < size_; ++k) rest_(k, k) += 1 / (p_.batch_scale_sigma * p_.batch_scale_sigma);
    const Eigen::MatrixXd information = inverse(p_.control_covariance);
    for (std::size_t a = 0; a < p_.control.size(); ++a)
      for (std::size_t b = 0; b < p_.control.size(); ++b)
        rest_.block<3, 3>(static_cast<Index>(6 * p_.control[a]), static_cast<Index>(6 * p_.control[b])) +=
            information.block<3, 3>(static_cast<Index>(3 * a), static_cast<Index>(3 * b));
  }

  static Eigen::MatrixXd inverse(const Eigen::MatrixXd& covariance) {
    const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
    if (factor.info() != Eigen::Success)
      throw std::runtime_error("a covariance that is given is not positive definite");
    return factor.solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
  }

  Eigen::MatrixXd anchors() const {
    // Scaled to a unit diagonal (Jacobi), so that the pivots tell what is determined. Plates that no image shows are
    // left out; their bound is infinite.
    std::vector<Index> used;
    for (Index k = 0; k < size_; ++k)
      if (rest_(k, k) > 0) used.push_back(k);
    const auto n = static_cast<Index>(used.size());
    Eigen::VectorXd scale(n);
    for (Index k = 0; k < n; ++k)
      scale(k) = 1 / std::sqrt(rest_(used[static_cast<std::size_t>(k)], used[static_cast<std::size_t>(k)]));
    Eigen::MatrixXd scaled(n, n);
    for (Index a = 0; a < n; ++a)
      for (Index b = 0; b < n; ++b)
        scaled(a, b) =
            scale(a) * scale(b) * rest_(used[static_cast<std::size_t>(a)], used[static_cast<std::size_t>(b)]);
    const Eigen::LDLT<Eigen::MatrixXd> factor(scaled);
    const double weakest = factor.vectorD().minCoeff();
    if (factor.info() != Eigen::Success || !(weakest > 1e-13))
      throw std::runtime_error("the geometry leaves something undetermined (smallest pivot " + std::to_string(weakest) +
                               " of 1): control that is missing or lies on one line, or plates in too few images");
    const Eigen::MatrixXd whole = factor.solve(Eigen::MatrixXd::Identity(n, n));
    std::vector<Index> place(static_cast<std::size_t>(size_), -1);
    for (Index k = 0; k < n; ++k) place[static_cast<std::size_t>(used[static_cast<std::size_t>(k)])] = k;
    const auto rows = static_cast<Index>(3 * p_.plates.size());
    Eigen::MatrixXd bound = Eigen::MatrixXd::Constant(rows, rows, 0);
    for (Index a = 0; a < rows; ++a)
      for (Index b = 0; b < rows; ++b) {
        const Index i = place[static_cast<std::size_t>(6 * (a / 3) + a % 3)],
                    j = place[static_cast<std::size_t>(6 * (b / 3) + b % 3)];
        if (i >= 0 && j >= 0)
          bound(a, b) = scale(i) * scale(j) * whole(i, j);
        else if (a == b)
          bound(a, b) = std::numeric_limits<double>::infinity();
      }
    return bound;
  }

  const BoundProblem& p_;
  const Index camera_at_, batch_at_, size_;
  Eigen::MatrixXd rest_;
};

}  // namespace

Eigen::MatrixXd tag_bound(const BoundProblem& problem) { return Bound(problem).solve(); }

}  // namespace plumbline::evaluate

#include "block/tag_block_model.hpp"

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plumbline::adjust {
namespace {

using Matrix8 = Eigen::Matrix<double, 8, 8>;

/// The four corners of one tag in one image. Parameters: pose, anchor, plate turn, interior orientation, tag scale,
/// corner inset.
struct TagCost {
  std::array<Eigen::Vector2d, 4> corners;
  std::array<Eigen::Matrix2d, 4> whitening;
  MarkerPlate plate;
  const Eigen::Matrix3d* cam_from_local;
  const Eigen::Matrix3d* local_from_plate;
  const double* sigma_factor;

  template <typename T>
  bool project_corner(size_t k, const T* pose, const T* anchor, const T* turn, const T* interior, const T& scale,
                      T* pixel) const {
    using Vector = Eigen::Matrix<T, 3, 1>;
    const double half = 0.5 * plate.tag_size;
    const double sx = k == 1 || k == 2 ? half : -half, sy = k >= 2 ? half : -half;
    const Vector in_plate(T(plate.tag_centre_in_plate.x()) + scale * T(sx),
                          T(plate.tag_centre_in_plate.y()) + scale * T(sy), T(plate.tag_centre_in_plate.z()));
    const Vector nominal = local_from_plate->cast<T>() * in_plate;
    Vector turned, in_camera;
    ceres::AngleAxisRotatePoint(turn, nominal.data(), turned.data());
    const Vector ray(anchor[0] + turned[0] - pose[0], anchor[1] + turned[1] - pose[1], anchor[2] + turned[2] - pose[2]);
    const Vector approximate = cam_from_local->cast<T>() * ray;
    ceres::AngleAxisRotatePoint(pose + 3, approximate.data(), in_camera.data());
    if (!(in_camera[2] > T(1e-6))) return false;
    project_normalised(interior, T(in_camera[0] / in_camera[2]), T(in_camera[1] / in_camera[2]), pixel);
    return true;
  }

  template <typename T>
  bool operator()(const T* pose, const T* anchor, const T* turn, const T* interior, const T* scale, const T* inset,
                  T* residual) const {
    using Pixel = Eigen::Matrix<T, 2, 1>;
    std::array<Pixel, 4> pixels;
    for (size_t k = 0; k < 4; ++k)
      if (!project_corner(k, pose, anchor, turn, interior, scale[0], pixels[k].data())) return false;
    for (size_t k = 0; k < 4; ++k) {
      // Both edges at the corner move inwards by the inset: along each edge by inset / sin(angle between them).
      const Pixel next = (pixels[(k + 1) % 4] - pixels[k]).normalized(),
                  previous = (pixels[(k + 3) % 4] - pixels[k]).normalized();
      const T sine = abs(T(next[0] * previous[1] - next[1] * previous[0]));
      const Pixel drawn = pixels[k] + (inset[0] / sine) * (next + previous);
      const T dx = drawn[0] - T(corners[k].x()), dy = drawn[1] - T(corners[k].y());
      residual[2 * k] = (whitening[k](0, 0) * dx + whitening[k](0, 1) * dy) / T(*sigma_factor);
      residual[2 * k + 1] = (whitening[k](1, 0) * dx + whitening[k](1, 1) * dy) / T(*sigma_factor);
    }
    return true;
  }
};

/// W (x − x0) over any number of parameter blocks.
class LinearCost : public ceres::CostFunction {
 public:
  LinearCost(Eigen::MatrixXd whitening, Eigen::VectorXd target, const std::vector<int>& sizes)
      : whitening_(std::move(whitening)), target_(std::move(target)) {
    set_num_residuals(static_cast<int>(whitening_.rows()));
    mutable_parameter_block_sizes()->assign(sizes.begin(), sizes.end());
  }
  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    Eigen::VectorXd x(target_.size());
    Eigen::Index at = 0;
    for (size_t b = 0; b < parameter_block_sizes().size(); ++b) {
      const Eigen::Index size = parameter_block_sizes()[b];
      x.segment(at, size) = Eigen::Map<const Eigen::VectorXd>(parameters[b], size);
      if (jacobians && jacobians[b]) {
        const auto columns = whitening_.middleCols(at, size);
        Eigen::Map<Eigen::MatrixXd> column(jacobians[b], size, columns.rows());  // row-major, seen transposed
        column = columns.transpose();
      }
      at += size;
    }
    Eigen::Map<Eigen::VectorXd>(residuals, whitening_.rows()) = whitening_ * (x - target_);
    return true;
  }

 private:
  Eigen::MatrixXd whitening_;
  Eigen::VectorXd target_;
};

Eigen::MatrixXd root_of(const Eigen::MatrixXd& covariance, const char* what) {
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success || !covariance.allFinite())
    throw std::runtime_error(std::string("the covariance of ") + what + " is not positive definite");
  return factor.matrixL();
}

Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& lower) {
  return lower.triangularView<Eigen::Lower>().solve(Eigen::MatrixXd::Identity(lower.rows(), lower.cols()));
}

void add_interior(const TagBlock& block, const TagBlockOptions& options, TagState& state, TagModel& result) {
  constexpr int count = BrownCamera::parameter_count;
  std::vector<bool> free(count, false);
  std::vector<std::string> labels;
  std::vector<int> chosen;
  for (const auto& name : options.free_interior)
    if (std::find_if(BrownCamera::parameter_names.begin(), BrownCamera::parameter_names.end(),
                     [&](const char* known) { return name == known; }) == BrownCamera::parameter_names.end())
      throw std::runtime_error("unknown interior parameter '" + name +
                               "'; known are fx, fy, cx, cy, k1, k2, k3, p1, p2");
  for (int i = 0; i < count; ++i) {
    const std::string name = BrownCamera::parameter_names[static_cast<size_t>(i)];
    labels.push_back("interior orientation " + name);
    const bool named =
        std::find(options.free_interior.begin(), options.free_interior.end(), name) != options.free_interior.end();
    // A prior without variance means that the calibration held the parameter: so do we.
    const bool exact = block.camera_covariance.size() > 0 && !(block.camera_covariance(i, i) > 0);
    free[static_cast<size_t>(i)] = options.self_calibration && named && !exact;
    if (free[static_cast<size_t>(i)]) chosen.push_back(i);
  }
  result.interior_columns = result.model.add_kept(state.interior.data(), free, labels);
  if (chosen.empty()) return;
  if (block.camera_covariance.size() > 0) {
    const Eigen::MatrixXd inverse =
        inverse_of(root_of(block.camera_covariance(chosen, chosen), "the calibration's interior orientation"));
    Eigen::MatrixXd whitening = Eigen::MatrixXd::Zero(inverse.rows(), count);
    whitening(Eigen::all, chosen) = inverse;
    const auto given = block.camera.parameters();
    result.model.add_term(
        std::make_unique<LinearCost>(whitening, Eigen::Map<const Eigen::VectorXd>(given.data(), count),
                                     std::vector<int>{count}),
        {state.interior.data()}, group_interior, 0);
  }
  if (options.fixed_aspect && free[0] && free[1]) {
    constexpr double sigma = 1e-3;  // [px]: far below what any image tells, far above rounding
    Eigen::MatrixXd row = Eigen::MatrixXd::Zero(1, count);
    row(0) = block.camera.fy / block.camera.fx / sigma;
    row(1) = -1 / sigma;
    result.model.add_term(std::make_unique<LinearCost>(row, Eigen::VectorXd::Zero(count), std::vector<int>{count}),
                          {state.interior.data()}, group_aspect, 0);
  }
}

void add_prior(BlockModel& model, double* value, double expected, double sigma, int group, int label) {
  model.add_term(std::make_unique<LinearCost>(Eigen::MatrixXd::Constant(1, 1, 1 / sigma),
                                              Eigen::VectorXd::Constant(1, expected), std::vector<int>{1}),
                 {value}, group, label);
}

void add_batches(const TagBlockOptions& options, TagState& state, TagModel& result) {
  for (size_t b = 0; b < state.scales.size(); ++b) {
    const std::string batch = " of batch '" + state.batch_names[b] + "'";
    result.scale_columns.push_back(
        result.model.add_kept(&state.scales[b], {options.tag_scale_sigma > 0}, {"tag scale" + batch})[0]);
    result.inset_columns.push_back(
        result.model.add_kept(&state.insets[b], {options.corner_inset_sigma > 0}, {"corner inset" + batch})[0]);
    if (options.tag_scale_sigma > 0 && std::isfinite(options.tag_scale_sigma))
      add_prior(result.model, &state.scales[b], 1, options.tag_scale_sigma, group_scale, static_cast<int>(b));
    if (options.corner_inset_sigma > 0)
      add_prior(result.model, &state.insets[b], 0, options.corner_inset_sigma, group_inset, static_cast<int>(b));
  }
}

void add_control(const TagBlock& block, const TagBlockOptions& options, TagState& state, TagModel& result) {
  std::vector<int> rows;
  std::vector<double*> values;
  for (size_t k = 0; k < block.control.plates.size(); ++k) {
    const auto at = std::find(state.plates.begin(), state.plates.end(), block.control.plates[k]);
    if (at == state.plates.end()) continue;  // surveyed, but in no image
    result.control_plates.push_back(static_cast<int>(at - state.plates.begin()));
    values.push_back(state.anchors[static_cast<size_t>(at - state.plates.begin())].data());
    for (int c = 0; c < 3; ++c) rows.push_back(3 * static_cast<int>(k) + c);
  }
  if (values.empty()) return;
  Eigen::VectorXd target = block.control.position(rows);
  for (Eigen::Index i = 0; i < target.size(); ++i) target(i) -= state.origin(i % 3);
  if (options.weighting == TagBlockOptions::Weighting::lambda)
    result.control_root =
        options.corner_sigma / std::sqrt(options.lambda) * Eigen::MatrixXd::Identity(target.size(), target.size());
  else
    result.control_root = root_of(block.control.covariance(rows, rows), "the control points");
  result.model.add_term(
      std::make_unique<LinearCost>(inverse_of(result.control_root), target, std::vector<int>(values.size(), 3)), values,
      group_control, 0);
}

}  // namespace

void TagState::fold() {
  for (size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector3d turn(poses[i][3], poses[i][4], poses[i][5]);
    cam_from_local[i] = (quaternion_from_rotation_vector(turn) * cam_from_local[i]).normalized();
    camera_matrices[i] = cam_from_local[i].toRotationMatrix();
    poses[i][3] = poses[i][4] = poses[i][5] = 0;
  }
  for (size_t j = 0; j < turns.size(); ++j) {
    local_from_plate[j] = (quaternion_from_rotation_vector(turns[j]) * local_from_plate[j]).normalized();
    plate_matrices[j] = local_from_plate[j].toRotationMatrix();
    turns[j].setZero();
  }
}

Eigen::Vector3d TagState::tag_centre(const TagBlock& block, size_t plate) const {
  return anchors[plate] +
         plate_matrices[plate] * block.plates[static_cast<size_t>(plates[plate])].plate.tag_centre_in_plate;
}

Matrix8 corner_root(const TagObservation& observation, const TagBlockOptions& options) {
  if (options.weighting == TagBlockOptions::Weighting::lambda) return options.corner_sigma * Matrix8::Identity();
  Matrix8 root = Matrix8::Zero();
  for (Eigen::Index k = 0; k < 4; ++k) {
    const Eigen::LLT<Eigen::Matrix2d> factor(observation.covariances[static_cast<size_t>(k)]);
    if (factor.info() != Eigen::Success)
      throw std::runtime_error("the covariance of a tag corner is not positive definite");
    root.block<2, 2>(2 * k, 2 * k) = factor.matrixL();
  }
  return root;
}

TagModel build_tag_model(const TagBlock& block, const TagBlockOptions& options, TagState& state) {
  TagModel result;
  BlockModel& model = result.model;
  for (const char* name :
       {"images", "control", "interior prior", "tag scale prior", "corner inset prior", "aspect condition"})
    model.add_group(name);
  for (size_t j = 0; j < state.plates.size(); ++j) {
    const std::string name = block.plates[static_cast<size_t>(state.plates[j])].anchor;
    result.anchor_columns.push_back(
        model.add_kept(state.anchors[j].data(), {true, true, true}, {name + " x", name + " y", name + " z"})[0]);
    model.add_kept(state.turns[j].data(), {true, true, true},
                   {name + " plate rotation x", name + " plate rotation y", name + " plate rotation z"});
  }
  add_interior(block, options, state, result);
  add_batches(options, state, result);
  for (auto& pose : state.poses) model.add_pose(pose.data());
  for (size_t i = 0; i < state.observations.size(); ++i) {
    const TagObservation& seen = block.observations[static_cast<size_t>(state.observations[i])];
    const size_t image =
        static_cast<size_t>(std::find(state.images.begin(), state.images.end(), seen.image) - state.images.begin());
    const size_t plate =
        static_cast<size_t>(std::find(state.plates.begin(), state.plates.end(), seen.plate) - state.plates.begin());
    const size_t batch = static_cast<size_t>(state.batch_of_plate[plate]);
    const Matrix8 whitening = inverse_of(corner_root(seen, options));
    auto* cost = new TagCost{seen.corners,
                             {},
                             block.plates[static_cast<size_t>(seen.plate)].plate,
                             &state.camera_matrices[image],
                             &state.plate_matrices[plate],
                             &state.image_sigma_factor};
    for (Eigen::Index k = 0; k < 4; ++k) cost->whitening[static_cast<size_t>(k)] = whitening.block<2, 2>(2 * k, 2 * k);
    model.add_term(std::make_unique<ceres::AutoDiffCostFunction<TagCost, 8, 6, 3, 3, 9, 1, 1>>(cost),
                   {state.poses[image].data(), state.anchors[plate].data(), state.turns[plate].data(),
                    state.interior.data(), &state.scales[batch], &state.insets[batch]},
                   group_images, static_cast<int>(i), true);
  }
  if (!options.free_network) add_control(block, options, state, result);
  return result;
}

Eigen::MatrixXd kept_motions(const TagBlock& block, const TagState& state, const TagModel& model) {
  std::vector<NamedPoint> anchors;
  for (const auto& anchor : state.anchors) anchors.push_back({"", anchor});
  const Eigen::Vector3d centre = centre_of(anchors);
  const Eigen::MatrixXd basis = motion_basis(anchors, centre);
  Eigen::MatrixXd motions = Eigen::MatrixXd::Zero(model.model.kept_count(), motion_count);
  for (size_t j = 0; j < anchors.size(); ++j) {
    const Eigen::Index column = model.anchor_columns[j];
    motions.middleRows<3>(column) = basis.middleRows<3>(3 * static_cast<Eigen::Index>(j));
    motions.block<3, 3>(column + 3, 3).setIdentity();
    // What the images see, the tag, is scaled about the centre; its offset to the anchor is a known length and stays.
    motions.block<3, 1>(column, 6) = state.tag_centre(block, j) - centre;
  }
  for (size_t b = 0; b < state.scales.size(); ++b)
    if (model.scale_columns[b] >= 0) motions(model.scale_columns[b], 6) = state.scales[b];
  return motions;
}

}  // namespace plumbline::adjust

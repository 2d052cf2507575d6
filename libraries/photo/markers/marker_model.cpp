#include "photo/markers/marker_model.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace plumbline::markers {
namespace {

using bundle::Kind;

void add_known(Kind kind, int index, Eigen::VectorXd target, Eigen::MatrixXd whitening, int group, MarkerModel& model) {
  model.problem.known.push_back({{{kind, index}}, std::move(target), std::move(whitening), group});
}

/// What is known of any camera: square pixels within a per cent, a principal point near the middle, no more distortion
/// than lenses have. Weak enough to leave to the photographs what they determine, and what keeps a block of few
/// photographs from running away.
void add_interior(const MarkerCamera& camera, bool is_used, int c, MarkerModel& model) {
  bundle::Camera entry{camera.id, bundle::lens_of(camera.camera.lens), 0, {}};
  const Eigen::Index all = bundle::value_count(entry.lens);
  const int interior_count = static_cast<int>(camera.camera.names().size());
  entry.free.assign(static_cast<size_t>(all), false);
  const bool has_prior = camera.covariance.size() > 0;
  std::vector<int> chosen;
  for (int k = 0; k < interior_count && is_used && !camera.held; ++k)
    if (!has_prior || camera.covariance(k, k) > 0) chosen.push_back(k), entry.free[k] = true;
  model.problem.cameras.push_back(std::move(entry));
  if (chosen.empty()) return;
  Eigen::VectorXd target = Eigen::VectorXd::Zero(all);
  Eigen::MatrixXd whitening;
  if (has_prior) {
    const auto start = camera.camera.parameters();
    target.head(interior_count) = Eigen::Map<const Eigen::VectorXd>(start.data(), interior_count);
    const Eigen::LLT<Eigen::MatrixXd> factor(camera.covariance(chosen, chosen).eval());
    if (factor.info() != Eigen::Success)
      throw std::runtime_error("the covariance of camera '" + camera.id + "' is not positive definite");
    const auto n = static_cast<Eigen::Index>(chosen.size());
    whitening = Eigen::MatrixXd::Zero(n, all);
    const Eigen::MatrixXd inverse = factor.matrixL().solve(Eigen::MatrixXd::Identity(n, n));
    whitening(Eigen::all, chosen) = inverse;
  } else {
    const double extent = std::max(camera.camera.width, camera.camera.height);
    const bool is_fisheye = camera.camera.lens == LensModel::fisheye;
    whitening = Eigen::MatrixXd::Zero(interior_count - 1, all);
    target(2) = 0.5 * (camera.camera.width - 1), target(3) = 0.5 * (camera.camera.height - 1);
    whitening(0, 0) = 1 / (0.01 * extent), whitening(0, 1) = -whitening(0, 0);
    whitening(1, 2) = whitening(2, 3) = 1 / (0.05 * extent);
    whitening(3, 4) = 1 / 0.5, whitening(4, 5) = 1 / 1.0, whitening(5, 6) = 1 / 1.0;
    whitening(6, 7) = 1 / (is_fisheye ? 1.0 : 0.01);  // k4, or p1
    if (!is_fisheye) whitening(7, 8) = 1 / 0.01;
  }
  add_known(Kind::camera, c, target, whitening, group_interior, model);
}

/// What a tag may differ from a square by, with its prior.
void add_shape(const MarkerOptions& options, int j, MarkerModel& model) {
  static_assert(shape_count == bundle::form_count);
  bundle::Plate& plate = model.problem.plates.back();
  plate.form_begin = options.shape_sigma > 0 ? 0 : shape_count - 1;
  plate.form_end = options.twist_sigma > 0 ? shape_count : shape_count - 1;
  const int count = plate.form_end - plate.form_begin;
  if (count == 0) return;
  Eigen::MatrixXd whitening = Eigen::MatrixXd::Zero(count, shape_count);
  for (int k = 0; k < count; ++k)
    whitening(k, plate.form_begin + k) =
        1 / (plate.form_begin + k + 1 < shape_count ? options.shape_sigma : options.twist_sigma);
  add_known(Kind::form, j, Eigen::VectorXd::Zero(shape_count), whitening, group_shape, model);
}

void add_marker(const Marker& marker, const RigidTransform& start, const MarkerOptions& options, MarkerModel& model) {
  const int j = static_cast<int>(model.problem.plates.size());
  const std::string name = "tag " + marker.name();
  model.problem.plates.push_back({name, {marker.size}, j});
  model.problem.batches.push_back({name, options.size_sigma > 0, false});
  model.state.plates.emplace_back().set(start.rotation, start.translation);
  model.state.scales.push_back(1), model.state.insets.push_back(0), model.state.forms.emplace_back();
  if (options.size_sigma > 0)
    add_known(Kind::scale, j, Eigen::VectorXd::Ones(1), Eigen::MatrixXd::Constant(1, 1, 1 / options.size_sigma),
              group_size, model);
  add_shape(options, j, model);
  if (!marker.world_from_tag) return;
  Eigen::VectorXd weights(6), place = Eigen::VectorXd::Zero(6);
  weights << Eigen::Vector3d::Constant(1 / options.layout_position_sigma),
      Eigen::Vector3d::Constant(1 / options.layout_rotation_sigma);
  place.head<3>() = marker.world_from_tag->translation;
  add_known(Kind::plate, j, place, weights.asDiagonal(), group_layout, model);
  model.problem.known.back().world_from_plate = marker.world_from_tag->rotation;
}

/// Prior of a camera's inset: what its detector states, as a root mean square over its images, because what it errs by
/// is much the same in all of them.
double inset_prior(const MarkerBlock& block, const MarkerOptions& options, size_t camera) {
  double squares = 0, count = 0;
  for (const MarkerImage& image : block.images)
    if (image.camera == static_cast<int>(camera) && image.inset_sigma > 0)
      squares += image.inset_sigma * image.inset_sigma, count += 1;
  return count > 0 ? std::sqrt(squares / count) : options.inset_sigma;
}

}  // namespace

MarkerModel build_model(const MarkerBlock& block, const MarkerOptions& options, const MarkerStart& start,
                        const std::vector<bool>& use) {
  MarkerModel model;
  for (const char* name : {"corners", "corners that were not refined", "layout", "tag size", "tag shape",
                           "interior orientation", "corner inset"})
    model.problem.groups.push_back({name});
  constexpr int none = -1, seen = 0;
  std::vector<int> image_index(block.images.size(), none), marker_index(block.markers.size(), none);
  for (size_t v = 0; v < block.views.size(); ++v) {
    const MarkerView& view = block.views[v];
    const size_t i = static_cast<size_t>(view.image), m = static_cast<size_t>(view.marker);
    if (!use[v] || !start.cam_from_world[i] || !start.world_from_tag[m]) continue;
    model.views.push_back(static_cast<int>(v));
    image_index[i] = marker_index[m] = seen;
  }
  std::vector<bool> camera_used(block.cameras.size(), false);
  for (size_t i = 0; i < block.images.size(); ++i) {
    if (image_index[i] == none) continue;
    const MarkerImage& image = block.images[i];
    image_index[i] = static_cast<int>(model.images.size());
    camera_used[image.camera] = true;
    model.images.push_back(static_cast<int>(i));
    model.problem.images.push_back({image.path, image.camera});
    const RigidTransform& pose = *start.cam_from_world[i];
    model.state.images.emplace_back().set(pose.rotation, pose.inverse().translation);
  }
  for (size_t m = 0; m < block.markers.size(); ++m) {
    if (marker_index[m] == none) continue;
    marker_index[m] = static_cast<int>(model.markers.size());
    model.markers.push_back(static_cast<int>(m));
    add_marker(block.markers[m], *start.world_from_tag[m], options, model);
  }
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    add_interior(block.cameras[c], camera_used[c], static_cast<int>(c), model);
    const auto values = start.cameras[c].parameters();
    std::copy(values.begin(), values.end(), model.state.interiors.emplace_back().begin());
    const bool has_inset = options.inset_sigma > 0 && camera_used[c];
    model.problem.batches.push_back({"camera " + block.cameras[c].id, false, has_inset});
    model.state.scales.push_back(1), model.state.insets.push_back(0);
    if (has_inset)
      add_known(Kind::inset, model.inset_batch(c), Eigen::VectorXd::Zero(1),
                Eigen::MatrixXd::Constant(1, 1, 1 / inset_prior(block, options, c)), group_inset, model);
  }
  for (const int v : model.views) {
    const MarkerView& view = block.views[v];
    bundle::ImageTag tag;
    tag.image = image_index[view.image], tag.plate = marker_index[view.marker];
    tag.corners = view.corners;
    for (size_t q = 0; q < 4; ++q) {
      const Eigen::Matrix2d lower = view.covariances[q].llt().matrixL();
      tag.whitening[q] = lower.inverse();
    }
    tag.group = view.refined ? group_refined : group_unrefined;
    tag.robust = true;
    tag.inset = model.inset_batch(static_cast<size_t>(block.images[view.image].camera));
    model.problem.image_tags.push_back(tag);
  }
  return model;
}

bool in_one_line(const MarkerBlock& block, const MarkerModel& model) {
  const Eigen::Index count = static_cast<Eigen::Index>(model.markers.size());
  Eigen::MatrixXd centres(3, count);
  double size = 0;
  for (Eigen::Index j = 0; j < count; ++j) {
    centres.col(j) = model.state.plates[j].position;
    size = std::max(size, block.markers[model.markers[j]].size);
  }
  const Eigen::MatrixXd offsets = centres.colwise() - centres.rowwise().mean();
  const Eigen::Matrix3d scatter = offsets * offsets.transpose() / static_cast<double>(count);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(scatter);
  return std::sqrt(std::max(0.0, spread.eigenvalues()(1))) < 0.1 * size;
}

bundle::Datum datum_of(const MarkerBlock& block, const MarkerModel& model, const bundle::Layout& layout) {
  if (has_layout(block)) return {};
  bundle::Datum datum = bundle::inner_datum(model.problem, layout, 6);
  if (in_one_line(block, model))
    for (size_t k = 0, centres = datum.held.size(); k < centres; ++k) datum.held.push_back(datum.held[k] + 3);
  return datum;
}

}  // namespace plumbline::markers

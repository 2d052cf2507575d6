#include "photo/markers/marker_run.hpp"

#include <algorithm>
#include <cmath>

#include "photo/markers/marker_trial.hpp"

namespace plumbline::markers {

void fill_cameras(const MarkerBlock& block, const MarkerRun& run, MarkerResult& result) {
  constexpr int count = BrownCamera::parameter_count;
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    AdjustedMarkerCamera camera;
    camera.camera = camera_of(block, run.model, c);
    camera.covariance = Eigen::MatrixXd::Zero(count, count);
    const auto& free = run.layout->free_values(static_cast<int>(c));
    if (!free.empty()) camera.covariance(free, free) = run.cofactor({bundle::Kind::camera, static_cast<int>(c)});
    const int batch = run.model.inset_batch(c);
    camera.inset = run.model.state.insets[batch];
    if (run.model.problem.batches[batch].inset_free)
      camera.inset_sigma = std::sqrt(run.cofactor({bundle::Kind::inset, batch})(0, 0));
    for (const bundle::Image& image : run.model.problem.images) camera.images += image.camera == static_cast<int>(c);
    result.cameras.push_back(camera);
  }
}

void fill_markers(const MarkerBlock& block, const MarkerRun& run, MarkerResult& result) {
  std::vector<int> plates, centres, images(run.model.markers.size(), 0);
  for (const bundle::ImageTag& tag : run.model.problem.image_tags) ++images[tag.plate];
  for (int j = 0; j < static_cast<int>(run.model.markers.size()); ++j) {
    plates.push_back(run.layout->block({bundle::Kind::plate, j}));
    for (int c = 0; c < 3; ++c) centres.push_back(6 * j + c);
  }
  const Eigen::MatrixXd cofactor = run.adjusted.cofactors->joint(plates);
  result.centre_covariance = cofactor(centres, centres);
  for (size_t j = 0; j < run.model.markers.size(); ++j) {
    AdjustedMarker marker;
    marker.marker = run.model.markers[j];
    marker.world_from_tag = {run.model.state.plates[j].rotation, run.model.state.plates[j].position};
    marker.scale = run.model.state.scales[j];
    if (run.model.problem.batches[j].scale_free)
      marker.scale_sigma = std::sqrt(run.cofactor({bundle::Kind::scale, static_cast<int>(j)})(0, 0));
    marker.shape = run.model.state.forms[j];
    const double half = 0.5 * block.markers[marker.marker].size * marker.scale;
    marker.corners = shaped_corners(half, marker.shape);
    for (Eigen::Vector3d& corner : marker.corners) corner = marker.world_from_tag * corner;
    const Eigen::Index at = 6 * static_cast<Eigen::Index>(j);
    marker.centre_covariance = cofactor.block<3, 3>(at, at);
    marker.rotation_covariance = cofactor.block<3, 3>(at + 3, at + 3);
    marker.images = images[j];
    result.markers.push_back(marker);
  }
}

void fill_images(const MarkerBlock& block, const MarkerRun& run, MarkerResult& result) {
  result.images.resize(block.images.size());
  for (size_t i = 0; i < result.images.size(); ++i) result.images[i].image = static_cast<int>(i);
  for (size_t i = 0; i < run.model.images.size(); ++i) {
    AdjustedMarkerImage& image = result.images[run.model.images[i]];
    image.oriented = true;
    image.centre = run.model.state.images[i].position;
    image.cam_from_world = cam_from_world(run.model.state.images[i]);
    image.covariance = run.cofactor({bundle::Kind::image, static_cast<int>(i)});
  }
}

void fill_views(const MarkerBlock& block, const MarkerRun& run, MarkerResult& result) {
  std::vector<double> camera_squares(block.cameras.size(), 0);
  double squares = 0;
  for (size_t k = 0; k < run.model.views.size(); ++k) {
    AdjustedMarkerView seen;
    seen.view = run.model.views[k];
    const MarkerView& view = block.views[seen.view];
    const auto& quality = run.reliability.tags[k];
    double sum = 0;
    for (size_t r = 0; r < 8; ++r) {
      seen.residuals[r / 2](static_cast<Eigen::Index>(r % 2)) = -quality[r].residual;
      sum += quality[r].residual * quality[r].residual;
      seen.largest_w = std::max(seen.largest_w, std::abs(quality[r].w));
      seen.smallest_redundancy = std::min(seen.smallest_redundancy, quality[r].redundancy_number);
    }
    seen.rms = std::sqrt(sum / 8);
    squares += sum;
    AdjustedMarkerImage& image = result.images[view.image];
    ++image.tags, image.rms += sum / 8;
    const size_t c = static_cast<size_t>(block.images[view.image].camera);
    ++result.cameras[c].views, camera_squares[c] += sum / 8;
    result.views.push_back(seen);
  }
  for (auto& image : result.images)
    if (image.tags) image.rms = std::sqrt(image.rms / image.tags);
  for (size_t c = 0; c < camera_squares.size(); ++c)
    if (result.cameras[c].views) result.cameras[c].rms = std::sqrt(camera_squares[c] / result.cameras[c].views);
  result.rms = std::sqrt(squares / (8.0 * static_cast<double>(std::max<size_t>(1, result.views.size()))));
}

std::array<Eigen::Vector3d, 4> shaped_corners(double half, const TagShape& shape) {
  std::array<Eigen::Vector3d, 4> corners;
  for (size_t k = 0; k < 4; ++k) {
    const double u = k == 1 || k == 2 ? 1 : -1, v = k >= 2 ? 1 : -1;
    corners[k] = half * Eigen::Vector3d(u + shape[0] * u + shape[1] * v + shape[2] * (u * v),
                                        v - shape[0] * v + shape[1] * u + shape[3] * (u * v), shape[4] * (u * v));
  }
  return corners;
}

}  // namespace plumbline::markers

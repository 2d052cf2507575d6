// Which lens took photographs of tags that calibrate their cameras.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "photo/markers/marker_block.hpp"

namespace plumbline::markers {
namespace {

bool calibrates_itself(const MarkerCamera& camera) {
  return !camera.held && (camera.covariance.size() == 0 || camera.any_lens);
}

MarkerBlock with_fisheyes(const MarkerBlock& block) {
  MarkerBlock other = block;
  for (MarkerCamera& camera : other.cameras) {
    if (!calibrates_itself(camera)) continue;
    camera.camera.lens = LensModel::fisheye;
    camera.camera.fx = camera.camera.fy = 0, camera.covariance = {};  // what EXIF says of it is that of a pinhole
  }
  return other;
}

/// Angle off the axis of the tag that lies furthest from it, of cameras that calibrate themselves [rad].
double widest_angle(const MarkerBlock& block, const MarkerResult& result) {
  double widest = 0;
  for (const AdjustedMarkerView& seen : result.views) {
    const MarkerView& view = block.views[seen.view];
    const AdjustedMarkerImage& image = result.images[view.image];
    const size_t camera = static_cast<size_t>(block.images[view.image].camera);
    if (!calibrates_itself(block.cameras[camera])) continue;
    for (const AdjustedMarker& marker : result.markers) {
      if (marker.marker != view.marker) continue;
      for (const Eigen::Vector3d& corner : marker.corners) {
        const Eigen::Vector3d ray = image.cam_from_world * corner;
        widest = std::max(widest, std::atan2(ray.head<2>().norm(), ray.z()));
      }
    }
  }
  return widest;
}

std::optional<MarkerResult> adjusted_if_possible(const MarkerBlock& block, const MarkerOptions& options) {
  try {
    return adjust_marker_block(block, options);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

/// Where Brown's model fits nothing: the block with the fisheye's, if that fits most views well.
bool take_as_fisheye(MarkerBlock& block, const MarkerOptions& options, MarkerResult& result) {
  constexpr double good = 1e-3;  // of the image's longer side
  if (std::none_of(block.cameras.begin(), block.cameras.end(), calibrates_itself)) return false;
  MarkerBlock other = with_fisheyes(block);
  const auto as_fisheye = adjusted_if_possible(other, options);
  int extent = 0;
  for (const MarkerCamera& camera : block.cameras)
    extent = std::max({extent, camera.camera.width, camera.camera.height});
  if (!as_fisheye || 2 * as_fisheye->views.size() < block.views.size() || as_fisheye->rms > good * extent) return false;
  block = std::move(other);
  result = *as_fisheye;
  result.warnings.insert(
      result.warnings.begin(),
      fmt::format(
          "the lens is a fisheye: Brown's model does not adjust at all; with the fisheye's (Kannala and Brandt) "
          "the tags fit to {:.2f} px. A calibration (camera=) holds whichever it has",
          result.rms));
  return true;
}

}  // namespace

MarkerResult adjust_lens_and_block(MarkerBlock& block, const MarkerOptions& options) {
  constexpr double wide = 35 * std::numbers::pi / 180, clearly = 0.85;
  MarkerResult result;
  try {
    result = adjust_marker_block(block, options);
  } catch (const std::runtime_error&) {  // rays that Brown's polynomial does not reach
    if (take_as_fisheye(block, options, result)) return result;
    throw;
  }
  if (widest_angle(block, result) < wide) return result;
  MarkerBlock other = with_fisheyes(block);
  const auto as_fisheye = adjusted_if_possible(other, options);
  if (!as_fisheye || as_fisheye->views.size() < result.views.size() || !(as_fisheye->rms < clearly * result.rms))
    return result;
  const std::string text = fmt::format(
      "the lens is a fisheye: over {:.0f} degrees off the axis, the tags fit to {:.2f} px with the fisheye's model "
      "(Kannala and Brandt, 8 parameters) and to {:.2f} px with Brown's (9). The block is adjusted with the fisheye's; "
      "a calibration (camera=) holds whichever it has",
      widest_angle(other, *as_fisheye) * 180 / std::numbers::pi, as_fisheye->rms, result.rms);
  block = std::move(other);
  result = *as_fisheye;
  result.warnings.insert(result.warnings.begin(), text);
  return result;
}

}  // namespace plumbline::markers

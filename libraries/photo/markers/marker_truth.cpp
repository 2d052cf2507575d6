#include "photo/markers/marker_truth.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "photo/markers/marker_scatter.hpp"

namespace plumbline::markers {
namespace {

/// The same photographs with those of the change as a camera of their own; both go on from where the adjustment left
/// them.
std::optional<MarkerBlock> with_camera_divided(const MarkerBlock& block, const MarkerResult& result,
                                               std::size_t camera) {
  const CameraTruth& truth = result.cameras[camera].truth;
  if (!truth.change || !divides(*truth.change)) return std::nullopt;
  MarkerBlock divided = block;
  for (std::size_t c = 0; c < divided.cameras.size(); ++c)
    if (!divided.cameras[c].held) divided.cameras[c].camera = result.cameras[c].camera;
  divided.cameras.push_back(divided.cameras[camera]);
  divided.cameras.back().id += " (second part)";
  for (const int k : truth.change->second)
    for (MarkerImage& image : divided.images)
      if (image.camera == static_cast<int>(camera) && image.path == truth.evidence.paths[k])
        image.camera = static_cast<int>(divided.cameras.size()) - 1;
  return divided;
}

}  // namespace

void judge_cameras(const MarkerBlock& block, const MarkerModel& model, const bundle::Layout& layout,
                   const bundle::Adjusted& adjusted, MarkerResult& result) {
  std::vector<int> heights;
  for (const MarkerCamera& camera : block.cameras) heights.push_back(camera.camera.height);
  const std::vector<PhotographShare> shares = shares_of(model.problem, layout, model.state, heights);
  const Eigen::MatrixXd cofactor = kept_cofactor(model.problem, layout, *adjusted.cofactors);
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const bundle::Placement& plate : model.state.plates)
    middle += plate.position / static_cast<double>(model.state.plates.size());
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    AdjustedMarkerCamera& camera = result.cameras[c];
    camera.formal_covariance = camera.covariance;
    if (camera.covariance.isZero(0)) continue;
    std::vector<int> members;
    std::vector<std::string> paths;
    for (size_t i = 0; i < model.images.size(); ++i)
      if (model.problem.images[i].camera == static_cast<int>(c))
        members.push_back(static_cast<int>(i)), paths.push_back(model.problem.images[i].name);
    CameraEvidence evidence =
        evidence_of(shares, cofactor, 1, interior_columns(model.problem, layout, static_cast<int>(c)), members, paths);
    std::vector<RigidTransform> poses;
    for (const int i : evidence.members) {
      const bundle::Placement& image = model.state.images[i];
      poses.push_back({image.rotation, image.rotation * (middle - image.position)});
    }
    camera.truth = judge_camera(std::move(evidence), camera.camera, poses);
    camera.covariance = in_nine(camera.truth.evidence, camera.truth.empirical.written);
    const std::string of = block.cameras.size() > 1 ? "camera " + block.cameras[c].id + ": " : "";
    for (const std::string& text : warnings_of(camera.truth)) result.warnings.push_back(of + text);
  }
  add_scatter(model, layout, shares, cofactor, result);
}

std::string as_two_cameras(const MarkerBlock& block, const MarkerOptions& options, const MarkerResult& result,
                           std::size_t c) {
  const auto divided = with_camera_divided(block, result, c);
  if (!divided) return "";
  try {
    const MarkerResult two = adjust_marker_block(*divided, options);
    const AdjustedMarkerCamera &first = two.cameras[c], &second = two.cameras.back();
    const auto sigma = [](const AdjustedMarkerCamera& camera) { return std::sqrt(camera.covariance(0, 0)); };
    return as_two_cameras(first.camera, sigma(first), second.camera, sigma(second), two.rms, result.rms);
  } catch (const std::runtime_error&) {
    return "";
  }
}

std::string as_two_cameras(const BrownCamera& first, double first_sigma, const BrownCamera& second, double second_sigma,
                           double rms_of_two, double rms_of_one) {
  std::string lengths;
  if (std::abs(second.fx - first.fx) > 2 * std::hypot(first_sigma, second_sigma))
    lengths = fmt::format(", fx {:.1f} \u00b1 {:.1f} and {:.1f} \u00b1 {:.1f} px,", first.fx, first_sigma, second.fx,
                          second_sigma);
  return fmt::format(
      "as two cameras{} they fit to {:.3f} px rms, as one to {:.3f} px: put these photographs into a folder of their "
      "own",
      lengths, rms_of_two, rms_of_one);
}

}  // namespace plumbline::markers

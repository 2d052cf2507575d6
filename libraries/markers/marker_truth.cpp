#include "markers/marker_truth.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "plumbline/stop.hpp"

namespace plumbline::markers {
namespace {

/// Derivatives of the whitened rows by the effects that a photograph may have of its own.
std::vector<Eigen::MatrixXd> effects_of(const MarkerBlock& block, const MarkerState& state,
                                        const adjustment::PartitionedSystem& system) {
  std::vector<Eigen::MatrixXd> effects;
  for (const adjustment::ObservationRows& rows : system.observations) {
    effects.emplace_back();
    if (rows.group != group_refined && rows.group != group_unrefined) continue;
    const MarkerView& view = block.views[static_cast<size_t>(state.views[static_cast<size_t>(rows.label)])];
    const MarkerImage& image = block.images[static_cast<size_t>(view.image)];
    const int height = block.cameras[static_cast<size_t>(image.camera)].camera.height;
    Eigen::MatrixXd pixels(8, effect_count);
    for (size_t q = 0; q < 4; ++q)
      pixels.middleRows<2>(2 * static_cast<Eigen::Index>(q)) = effects_at(view.corners[q], height);
    effects.back() =
        view_root(view).triangularView<Eigen::Lower>().solve(pixels) / state.sigma_factors[view.refined ? 0 : 1];
  }
  return effects;
}

/// The same photographs with those of the change as a camera of their own; both go on from where the adjustment left
/// them.
std::optional<MarkerBlock> with_camera_divided(const MarkerBlock& block, const MarkerResult& result,
                                               std::size_t camera) {
  const CameraTruth& truth = result.cameras[camera].truth;
  if (!truth.change || !divides(*truth.change)) return std::nullopt;
  MarkerBlock divided = block;
  divided.views.clear();  // the same observations as of one camera
  for (const AdjustedMarkerView& view : result.views)
    divided.views.push_back(block.views[static_cast<std::size_t>(view.view)]);
  for (std::size_t c = 0; c < divided.cameras.size(); ++c)
    if (!divided.cameras[c].held) divided.cameras[c].camera = result.cameras[c].camera;
  divided.cameras.push_back(divided.cameras[camera]);
  divided.cameras.back().id += " (second part)";
  for (const int k : truth.change->second)
    for (MarkerImage& image : divided.images)
      if (image.camera == static_cast<int>(camera) && image.path == truth.evidence.paths[static_cast<std::size_t>(k)])
        image.camera = static_cast<int>(divided.cameras.size()) - 1;
  return divided;
}

std::string of_camera(const MarkerBlock& block, std::size_t camera) {
  return block.cameras.size() > 1 ? "camera " + block.cameras[camera].id + ": " : "";
}

/// Puts `now` where the first of `before` stands among the warnings.
void retell(const std::vector<std::string>& before, const std::vector<std::string>& now,
            std::vector<std::string>& warnings) {
  auto at = warnings.end();
  for (const std::string& text : before) {
    const auto found = std::find(warnings.begin(), warnings.end(), text);
    if (found != warnings.end()) at = warnings.erase(found);
  }
  warnings.insert(at, now.begin(), now.end());
}

std::vector<std::string> told_of(const MarkerBlock& block, const MarkerResult& result, std::size_t camera) {
  std::vector<std::string> words = warnings_of(result.cameras[camera].truth);
  for (std::string& text : words) text.insert(0, of_camera(block, camera));
  return words;
}

std::optional<TwoCameras> as_two_cameras(const MarkerBlock& block, const MarkerOptions& options,
                                         const MarkerResult& result, std::size_t camera) {
  const auto divided = with_camera_divided(block, result, camera);
  if (!divided) return std::nullopt;
  MarkerOptions same = options;
  same.reject_above = 0;
  try {
    const MarkerResult found = adjust_marker_block(*divided, same);
    TwoCameras two;
    two.first = found.cameras[camera].camera, two.second = found.cameras.back().camera;
    two.first_covariance = found.cameras[camera].covariance, two.second_covariance = found.cameras.back().covariance;
    two.rms_as_one = result.rms, two.rms_as_two = found.rms;
    two.more_unknowns = found.unknowns - result.unknowns, two.redundancy = found.degrees_of_freedom;
    return two;
  } catch (const Stopped&) {
    throw;
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

}  // namespace

void judge_cameras(const MarkerBlock& block, const MarkerState& state, const MarkerModel& model,
                   const adjust::AdjustedBlock& adjusted, MarkerResult& result) {
  const std::vector<PhotographShare> shares = shares_of(adjusted.linear, effects_of(block, state, adjusted.linear));
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const auto& centre : state.centres)
    middle += Eigen::Map<const Eigen::Vector3d>(centre.data()) / static_cast<double>(state.centres.size());
  for (size_t c = 0; c < block.cameras.size(); ++c) {
    AdjustedMarkerCamera& camera = result.cameras[c];
    camera.formal_covariance = camera.covariance;
    if (camera.covariance.isZero(0)) continue;
    std::vector<int> members;
    std::vector<std::string> paths;
    for (size_t i = 0; i < state.images.size(); ++i) {
      const MarkerImage& image = block.images[static_cast<size_t>(state.images[i])];
      if (image.camera == static_cast<int>(c)) members.push_back(static_cast<int>(i)), paths.push_back(image.path);
    }
    CameraEvidence evidence =
        evidence_of(shares, adjusted.solution.kept_cofactor, 1, model.interior_columns[c], members, paths);
    std::vector<RigidTransform> poses;
    for (const int i : evidence.members) {
      const Eigen::Map<const Eigen::Vector3d> centre(state.poses[static_cast<size_t>(i)].data());
      const Eigen::Quaterniond& turn = state.cam_from_world[static_cast<size_t>(i)];
      poses.push_back({turn, turn * (middle - centre)});
    }
    camera.truth = judge_camera(std::move(evidence), camera.camera, poses);
    camera.covariance = in_nine(camera.truth.evidence, camera.truth.empirical.written);
    for (const std::string& text : told_of(block, result, c)) result.warnings.push_back(text);
  }
}

void try_two_cameras(const MarkerBlock& block, const MarkerOptions& options, MarkerResult& result) {
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    const auto two = as_two_cameras(block, options, result, c);
    if (!two) continue;
    const std::vector<std::string> before = told_of(block, result, c);
    const std::string words = of_camera(block, c) + settle_change(result.cameras[c].truth, *two);
    std::vector<std::string> now = told_of(block, result, c);
    now.insert(now.begin() + (result.cameras[c].truth.change ? 1 : 0), words);
    retell(before, now, result.warnings);
  }
}

std::string withdraw_scatter(const MarkerBlock& block, MarkerResult& result) {
  std::string scatter;
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    CameraTruth& truth = result.cameras[c].truth;
    const std::string words = in_words(truth.empirical, truth.scatter);
    if (truth.change || words.empty()) continue;
    retell({of_camera(block, c) + words}, {}, result.warnings);
    truth.scatter.clear();
    scatter += (scatter.empty() ? "" : "; ") + of_camera(block, c) + scatter_in_words(truth.empirical);
  }
  return scatter;
}

}  // namespace plumbline::markers

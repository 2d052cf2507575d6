// The parts of a tag block adjustment: approximate values, and the block as block/bundle takes it.
#pragma once

#include <optional>

#include "photo/block/tag_block.hpp"

namespace plumbline::block {

/// What takes part, and where it is approximately.
struct TagStart {
  std::vector<int> images;  ///< of the block, those that take part
  std::vector<int> plates;
  std::vector<int> observations;
  std::vector<RigidTransform> cam_from_world;    ///< in the order of `images`
  std::vector<RigidTransform> world_from_plate;  ///< in the order of `plates`
};

/// Places plates from the images that see them and images from the plates they see, until nothing is added. `left_out`
/// tells what could not be placed; `use` tells which of block.observations may be used. Throws if fewer than two images
/// are left.
TagStart start_tag_block(const TagBlock& block, const std::vector<bool>& use, std::vector<std::string>& left_out);

/// Carries approximate values that lie in another frame than the control over to it and says so in `warnings`: survey
/// on a site grid, design in the frame of the building. Throws std::runtime_error that names the cause if the control's
/// distances are not those of the block (another unit), or if single control points lie where others should.
void move_to_control(const TagBlock& block, TagStart& start, std::vector<std::string>& warnings);

/// A control point against where the approximate values and all the other control have it.
struct FarControl {
  int plate = 0;
  size_t of = 0;        ///< control points that are placed
  Eigen::Vector3d off;  ///< survey minus that [m]
  /// It is ten times further off than any of the others is without it, and without any other one they are five times
  /// further off: then it is wrong, whatever the approximate values are worth.
  bool alone = false;
};

/// The control point without which the others agree best with the approximate values, by a similarity. Nothing below
/// six points or on a line. Throws as start_tag_block().
std::optional<FarControl> furthest_control(const TagBlock& block);
std::string in_words(const FarControl& far, const TagBlock& block);

enum TagGroup {
  group_images,
  group_control,
  group_interior,
  group_scale,
  group_inset,
  group_aspect,
  group_principal_points
};

/// The block in a local frame: world minus `origin`. Groups are those of the enumeration.
struct TagModel {
  bundle::Problem problem;
  bundle::State state;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< whole metres
  int control_term = -1;                             ///< index into problem.known
  std::vector<int> control_plates;  ///< indices into problem.plates, in the order of the control term's rows
};
/// Gives every image a principal point of its own, `sigma` [px] about the camera's.
void free_principal_points(double sigma, bundle::Problem& problem, bundle::State& state);

TagModel build_tag_model(const TagBlock& block, const TagBlockOptions& options, const TagStart& start);

/// Fills result.tests from result.groups: images against the detector's own covariances (before image_variance_factor),
/// within what detectors are wrong by; control and priors by the chi-squared test at 1e-4. Groups without redundancy
/// are not tested.
void test_groups(const TagBlock& block, TagBlockResult& result);

/// Control and priors that fail the tests of test_groups(). Where a prior does, it may be that which control
/// contradicts.
std::vector<least_squares::VarianceComponent> failing_but_images(
    const std::vector<least_squares::VarianceComponent>& groups);

/// Control points one of which is wrong, and which the others do not tell.
struct ControlRivals {
  RejectedControl worst;
  std::vector<int> others;  ///< plates
};

/// What the tests of single control points say.
struct ControlTests {
  std::optional<RejectedControl> worst;  ///< of the points that contradict and have no rival that which does so most
  std::vector<ControlRivals> rivals;
  std::vector<int> hidden;  ///< plates whose control may be off in some direction without that it shows
};

/// Tests each control point but those of the plates `kept`, whatever their errors are (control_suspects.hpp).
ControlTests test_control(const TagModel& model, const TagStart& start, const bundle::Adjusted& adjusted,
                          const std::vector<int>& kept = {});

/// What the rest of the block says of these control plates: the same formula, for all of them together, is the
/// adjustment without them to first order (Cook & Weisberg 1982, 2.2).
WithheldControl withheld_control(const TagModel& model, const TagStart& start, const bundle::Adjusted& adjusted,
                                 const std::vector<int>& plates);

/// Fills result.models: score tests at 1e-4 of what the camera model leaves out (d1 and d2, a principal point of each
/// image), at the minimum in `model`. Blocks of more than 300 images and those with little redundancy are not tested.
/// What of it does not hold is added to result.anchor_covariance, mode by mode, as large as the images show it.
void test_models(const TagBlockOptions& options, const TagModel& model, const bundle::Adjusted& adjusted,
                 TagBlockResult& result);

/// Throws std::runtime_error if the block has fewer than two images, no tag of a known plate or a plate without size.
void require_usable(const TagBlock& block);

/// A covariance of control that weights can be made of. Survey networks may hold points as exact, or have the singular
/// covariance of a free network: then a hundredth of a millimetre on top keeps the weights finite, far below what any
/// survey reaches. A regular covariance stays as it is: whoever compares a result with the survey relies on its being
/// the very one that was used.
Eigen::MatrixXd regular_covariance(Eigen::MatrixXd covariance);

}  // namespace plumbline::block

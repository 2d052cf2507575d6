// The cost of a tag block as its adjustment has it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>

#include "photo/block/tag_block_model.hpp"
#include "photo/block/tag_cost.hpp"
#include "plain_options.hpp"
#include "synthetic_block.hpp"
#include "test_support.hpp"

namespace test_tag_cost {

using namespace plumbline;
using test::error_of;
using testing::HasSubstr;

/// The cost that anybody computes of a result is the one that the adjustment reached, and no other place has less.
TEST(TagCost, IsWhatTheAdjustmentMinimised) {
  auto synthetic = test::make_block({.floors = 1});
  synthetic.block.cameras[0].interior = synthetic.camera;
  block::TagBlockOptions options;
  options.self_calibration = options.estimate_image_variance = false;
  options.tag_scale_sigma = options.reject_above = 0;
  options.loss = block::RobustLoss::none;
  const auto result = block::adjust_tag_block(synthetic.block, options);
  std::map<std::string, Eigen::Vector3d> start, found;
  for (size_t j = 0; j < result.plates.size(); ++j) {
    const size_t plate = static_cast<size_t>(result.plates[j]);
    found[synthetic.block.plates[plate].anchor] = result.anchors.segment<3>(3 * static_cast<Eigen::Index>(j));
    start[synthetic.block.plates[plate].anchor] = synthetic.anchors[plate];
  }
  const double at_start = block::cost_of_tag_block(synthetic.block, start).total();
  // Where an adjustment starts by itself, from approximate poses and from true ones.
  const block::TagCost own_start = block::start_cost_of_tag_block(synthetic.block);
  EXPECT_GT(own_start.total(), 10 * result.weighted_sum_of_squares);
  EXPECT_EQ(own_start.left_out, 0);
  block::TagBlock at_truth = synthetic.block;
  at_truth.cameras[0].interior = synthetic.camera;
  for (size_t i = 0; i < at_truth.images.size(); ++i) at_truth.images[i].cam_from_world = synthetic.cam_from_world[i];
  EXPECT_LT(block::start_cost_of_tag_block(at_truth).total(), 0.01 * own_start.total());
  block::TagBlock adjusted = synthetic.block;
  for (size_t i = 0; i < adjusted.images.size(); ++i) adjusted.images[i].cam_from_world = result.cam_from_world[i];
  const block::TagCost cost = block::cost_of_tag_block(adjusted, found);
  EXPECT_NEAR(cost.total() / result.weighted_sum_of_squares, 1, 1e-7);
  EXPECT_EQ(cost.corner_rows + cost.control_rows, result.observations);
  EXPECT_EQ(cost.left_out, 0);
  EXPECT_GT(at_start, 1.1 * cost.total());
  adjusted.images[3].cam_from_world->translation.x() += 1e-4;
  EXPECT_GT(block::cost_of_tag_block(adjusted, found).total(), cost.total());
  found.erase(synthetic.block.plates[0].anchor);
  EXPECT_GT(block::cost_of_tag_block(adjusted, found).left_out, 0);
}

/// With sizes of tags, insets and the camera unknown under their priors, the cost is still what was minimised, and less
/// than that of tags of the printed size.
TEST(TagCost, CountsWhatIsAssumedOfTagsAndCalibration) {
  auto synthetic = test::make_block({.floors = 1});
  block::TagBlockOptions options;
  options.estimate_image_variance = false;
  options.reject_above = 0;
  options.loss = block::RobustLoss::none;
  options.corner_inset_sigma = 0.3;
  for (auto& plate : synthetic.block.plates) plate.plate.tag_size *= 1.0015;
  const auto result = block::adjust_tag_block(synthetic.block, options);
  ASSERT_NEAR(result.batches.at(0).scale, 1 / 1.0015, 3e-4);
  std::map<std::string, Eigen::Vector3d> found;
  for (size_t j = 0; j < result.plates.size(); ++j)
    found[synthetic.block.plates[result.plates[j]].anchor] =
        result.anchors.segment<3>(3 * static_cast<Eigen::Index>(j));
  block::TagBlock adjusted = synthetic.block;
  adjusted.cameras[0].interior = result.cameras[0].interior;
  for (size_t i = 0; i < adjusted.images.size(); ++i) adjusted.images[i].cam_from_world = result.cam_from_world[i];
  block::TagCostPriors priors;
  priors.tag_scale_sigma = options.tag_scale_sigma;
  priors.corner_inset_sigma = options.corner_inset_sigma;
  priors.calibration = synthetic.block.cameras;
  const block::TagCost cost = block::cost_of_tag_block(adjusted, found, priors);
  EXPECT_NEAR(cost.total() / result.weighted_sum_of_squares, 1, 1e-7);
  EXPECT_GT(cost.priors, 1);
  EXPECT_GT(block::cost_of_tag_block(adjusted, found).total(), 1.1 * cost.total()) << "tags of the printed size";
  // Every adjustment starts at the printed size and at the calibration: no prior is strained there.
  EXPECT_EQ(block::start_cost_of_tag_block(synthetic.block, priors).priors, 0);
  EXPECT_EQ(block::start_cost_of_tag_block(synthetic.block, priors).total(),
            block::start_cost_of_tag_block(synthetic.block).total());
  adjusted.cameras[0].interior.fx += 5;
  EXPECT_GT(block::cost_of_tag_block(adjusted, found, priors).priors, cost.priors);
}

}  // namespace test_tag_cost

// What cannot be adjusted is refused, and the refusal names what is missing.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "synthetic_block.hpp"

namespace test_tag_block_degenerate {

using namespace plumbline;
using test::error_of;
using testing::HasSubstr;

std::string refusal(const block::TagBlock& block, const block::TagBlockOptions& options = test::bound_options()) {
  return error_of([&] { block::adjust_tag_block(block, options); });
}

test::SyntheticBlock flat_block() { return test::make_block({.floors = 1, .scatter = 0}); }

TEST(DegenerateTagBlock, OneImage) {
  auto synthetic = flat_block();
  synthetic.block.images.resize(1);
  std::erase_if(synthetic.block.observations, [](const auto& seen) { return seen.image > 0; });
  EXPECT_THAT(refusal(synthetic.block), HasSubstr("at least 2 images, this one has 1"));
}

TEST(DegenerateTagBlock, NoTags) {
  auto synthetic = flat_block();
  synthetic.block.observations.clear();
  EXPECT_THAT(refusal(synthetic.block), HasSubstr("no image shows a tag of a known plate"));
}

TEST(DegenerateTagBlock, NoPoseAtAll) {
  auto synthetic = flat_block();
  for (auto& image : synthetic.block.images) image.cam_from_world.reset();
  EXPECT_THAT(refusal(synthetic.block), HasSubstr("at least 2 oriented images"));
}

TEST(DegenerateTagBlock, NoControl) {
  auto synthetic = flat_block();
  synthetic.use_control({});
  const std::string text = refusal(synthetic.block);
  for (const char* motion : {"translation along x", "translation along y", "translation along z", "along x", "along y",
                             "along z", "scale", "0 of 11 anchors", "free network"})
    EXPECT_THAT(text, HasSubstr(motion));
}

TEST(DegenerateTagBlock, OneControlPoint) {
  auto synthetic = flat_block();
  synthetic.use_control({0});
  const std::string text = refusal(synthetic.block);
  EXPECT_THAT(text, HasSubstr("rotation about the axis through F01-C01-R1 along x"));
  EXPECT_THAT(text, HasSubstr("rotation about the axis through F01-C01-R1 along z"));
  EXPECT_THAT(text, HasSubstr("scale"));
  EXPECT_THAT(text, testing::Not(HasSubstr("translation")));
}

TEST(DegenerateTagBlock, TwoControlPoints) {
  auto synthetic = flat_block();
  synthetic.use_control({0, 7});
  const std::string text = refusal(synthetic.block);
  EXPECT_THAT(text,
              HasSubstr("leaves rotation about the line through F01-C01-R1 and F01-C04-R2 of the block undetermined"));
}

TEST(DegenerateTagBlock, OneColumn) {
  auto synthetic = test::make_block({.floors = 3, .scatter = 0});
  synthetic.use_control(synthetic.choose([](int, int column, int) { return column == 3; }));
  EXPECT_THAT(
      refusal(synthetic.block),
      HasSubstr("leaves rotation about the line through F01-C03-R1 and F03-C03-R2 of the block undetermined: 6 of 33"));
}

TEST(DegenerateTagBlock, TwoPartsWithoutCommonPlates) {
  auto synthetic = flat_block();
  // Half of the images sees the left two columns only, the other half the right two; all control is on the left.
  std::erase_if(synthetic.block.observations, [&](const auto& seen) {
    const double x = synthetic.anchors[seen.plate].x();
    return seen.image % 2 == 0 ? x > 2.5 : x < 3.5;
  });
  std::erase_if(synthetic.block.plates, [](const auto&) { return false; });
  synthetic.use_control(synthetic.choose([](int, int column, int) { return column <= 2; }));
  EXPECT_THAT(refusal(synthetic.block), HasSubstr("falls into 2 parts"));
}

TEST(DegenerateTagBlock, ControlCovarianceThatIsNone) {
  auto synthetic = flat_block();
  synthetic.block.control.covariance(0, 0) = -1;
  EXPECT_THAT(refusal(synthetic.block), HasSubstr("covariance of the control points is not positive definite"));
}

TEST(DegenerateTagBlock, UnknownInteriorParameter) {
  auto synthetic = flat_block();
  auto options = test::bound_options();
  options.free_interior = {"fx", "ck"};
  EXPECT_THAT(refusal(synthetic.block, options), HasSubstr("unknown interior parameter 'ck'; known are fx, fy"));
}

TEST(DegenerateTagBlock, WhatCannotBePlacedIsNamedAndLeftOut) {
  auto synthetic = flat_block();
  synthetic.block.images.push_back({"empty.jpg", std::nullopt});
  synthetic.block.plates.push_back(synthetic.block.plates.front());
  synthetic.block.plates.back().anchor = "F09-C09-R1";
  const auto result = block::adjust_tag_block(synthetic.block, test::bound_options());
  EXPECT_EQ(result.left_out,
            (std::vector<std::string>{"empty.jpg: no tag of a known plate", "F09-C09-R1: its tag is in no image"}));
  EXPECT_FALSE(result.cam_from_world.back());
}

}  // namespace test_tag_block_degenerate

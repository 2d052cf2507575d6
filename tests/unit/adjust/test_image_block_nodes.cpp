// Blocks of measured targets from their files to what is adjusted.
#include <gmock/gmock.h>

#include <array>
#include <fstream>

#include "adjuster_inputs.hpp"
#include "artifacts/block.hpp"
#include "artifacts/file.hpp"
#include "artifacts/fitted_datum.hpp"
#include "artifacts/image_block.hpp"
#include "node_harness.hpp"
#include "synthetic_facade.hpp"

namespace test_image_block_nodes {

using namespace plumbline;
using namespace plumbline::test;
using testing::HasSubstr;

/// Said before anything is read, so that a file that is refused tells it as well: eight bytes for one.
TEST(ReadBlockNodes, WhatReadingALargeFileTakesIsAnnounced) {
  const auto announced = [](const char* kind, const char* parameter, const std::string& name, size_t bytes) {
    const TemporaryFolder folder;
    const auto file = folder.path() / name;
    std::ofstream(file) << std::string(bytes, '\n');
    NodeHarness node(kind);
    node.set(parameter, (std::string(parameter) == "file" ? file : folder.path()).string());
    EXPECT_THROW(node.run(), NodeFailed) << kind;
    return node.announced();
  };
  constexpr size_t large = 9'000'000;
  const std::vector<std::array<const char*, 3>> readers = {{"read.bal", "file", "problem.bal"},
                                                           {"read.photomodeler", "file", "a-pmexport.txt"},
                                                           {"read.aicon", "folder", "block.phc"},
                                                           {"read.image_block", "folder", "a-pmexport.txt"}};
  for (const auto& [kind, parameter, name] : readers) {
    EXPECT_EQ(announced(kind, parameter, name, large), 8 * large) << kind;
    EXPECT_EQ(announced(kind, parameter, name, 1000), 0u) << kind << ": not worth waiting for";
  }
  EXPECT_EQ(announced("read.image_block", "folder", "photograph.jpg", large), 0u) << "is not read";
}

class ImageBlockNodes : public testing::TestWithParam<std::string> {};
INSTANTIATE_TEST_SUITE_P(Adjusters, ImageBlockNodes, testing::Values("adjust.schur", "adjust.ceres"), test_name);

TEST_P(ImageBlockNodes, AiconFolderToAdjustedBlock) {
  PLUMBLINE_REQUIRE_DATA("blocks/aicon/example.phc");
  NodeHarness read("read.image_block");
  read.set("folder", data_file("blocks/aicon").string());
  read.run();
  NodeHarness adjust(GetParam());
  adjust.input<ImageBlock>("block", read.output<ImageBlock>("block"));
  adjust.run();
  const BlockT block = adjust.output<Block>("block");
  EXPECT_EQ(block.adjuster, GetParam());
  EXPECT_EQ(block.datum, "free");
  EXPECT_NEAR(block.statistics->sigma0, 0.81, 0.01);
  EXPECT_EQ(block.statistics->degrees_of_freedom, 18804);
  EXPECT_EQ(block.statistics->datum_defect, 6);
  ASSERT_TRUE(block.targets);
  const TargetBlockT& targets = *block.targets;
  EXPECT_NEAR(targets.image_sigma, 0.000405, 0.01 * 0.000405);
  EXPECT_NEAR(targets.image_sigma_px, 0.098, 0.002);
  EXPECT_EQ(targets.points.size(), 150u);
  EXPECT_EQ(targets.images.size(), 115u);
  ASSERT_EQ(targets.cameras.size(), 1u);
  EXPECT_EQ(targets.cameras[0]->interior_orientation[0]->name, "Ck");
  EXPECT_NEAR(targets.cameras[0]->interior_orientation[0]->sigma, 2.51e-4, 2e-6);
  EXPECT_FALSE(targets.cameras[0]->interior_orientation[5]->estimated);
  EXPECT_EQ(targets.cameras[0]->correlations.size(), 28u);
  EXPECT_EQ(targets.images[0]->correlations.size(), 21u);
  EXPECT_EQ(block.left_out.size(), 2u);
  EXPECT_EQ(adjust.output<Points>("points").covariance.size(), 450u * 451u / 2u);
  EXPECT_EQ(adjust.output<Poses>("poses").poses.size(), 115u);
}

ImageBlockT photomodeler_block(bool with_control) {
  NodeHarness read("read.photomodeler");
  read.set("file", data_file("blocks/photomodeler_cam/pmexports/weighted-with-orient-pmexport.txt").string());
  if (with_control) read.set("control", data_file("blocks/photomodeler_cam/ref/ctrlpts-weighted.txt").string());
  read.run();
  return read.output<ImageBlock>("block");
}

TEST_P(ImageBlockNodes, PhotoModelerExportWithControl) {
  PLUMBLINE_REQUIRE_DATA("blocks/photomodeler_cam/ref/ctrlpts-weighted.txt");
  NodeHarness adjust(GetParam());
  adjust.input<ImageBlock>("block", photomodeler_block(true));
  adjust.run();
  const BlockT block = adjust.output<Block>("block");
  EXPECT_EQ(block.datum, "control");
  EXPECT_NEAR(block.statistics->sigma0, 1.60984, 0.001);
  EXPECT_EQ(block.targets->control.size(), 4u);
  EXPECT_EQ(block.targets->control[0]->use, "weighted");
  EXPECT_TRUE(block.warnings.empty());
}

TEST_P(ImageBlockNodes, WarnsOfControlThatContradictsTheImages) {
  PLUMBLINE_REQUIRE_DATA("blocks/photomodeler_cam/ref/ctrlpts-weighted.txt");
  ImageBlockT spoilt = photomodeler_block(true);
  ASSERT_EQ(spoilt.control.size(), 4u);
  spoilt.control[2]->position.z() += 0.05;
  NodeHarness adjust(GetParam());
  adjust.input<ImageBlock>("block", spoilt);
  adjust.run();
  EXPECT_THAT(adjust.output<Block>("block").warnings,
              testing::Contains(HasSubstr("control and images contradict each other")));
  // Across the plane of four points an error of each looks like that of any other; the largest w was an innocent one's.
  const std::string wrong = spoilt.control[2]->id;
  for (const auto& point : spoilt.control)
    EXPECT_THAT(adjust.output<Block>("block").warnings[0], HasSubstr(point->id)) << "wrong: " << wrong;
  EXPECT_THAT(adjust.output<Block>("block").warnings[0], HasSubstr("would explain it alike"));
  EXPECT_EQ(adjust.metric("invalid"), 1);
}

/// A parameter that did nothing but falsify the sigma that was told.
TEST_P(ImageBlockNodes, TheSigmaThatIsGivenIsInPlaceOfTheFiles) {
  PLUMBLINE_REQUIRE_DATA("blocks/photomodeler_cam/ref/ctrlpts-weighted.txt");
  const auto told = [&](const char* name, const char* value) {
    NodeHarness adjust(GetParam());
    if (*name) adjust.set(name, value);
    adjust.input<ImageBlock>("block", photomodeler_block(true));
    adjust.run();
    return std::pair(adjust.output<Block>("block"), testing::PrintToString(adjust.warnings()));
  };
  const BlockT plain = told("", "").first;
  for (const char* sigma : {"0.05", "0.0001"})
    EXPECT_NEAR(told("image_sigma", sigma).first.targets->image_sigma_px, plain.targets->image_sigma_px,
                0.1 * plain.targets->image_sigma_px)
        << sigma;
  EXPECT_THAT(told("loss", "tukey").second, HasSubstr("without effect on a block of measured targets: loss; leave"));
  EXPECT_EQ(told("", "").second.find("without effect"), std::string::npos);
}

TEST_P(ImageBlockNodes, WarnsOfTargetsThatContradictTheirCamera) {
  PLUMBLINE_REQUIRE_DATA("blocks/photomodeler_cam/ref/ctrlpts-weighted.txt");
  ImageBlockT spoilt = photomodeler_block(false);
  for (auto& camera : spoilt.cameras) camera->parameters[3] += 0.01;  // K1 of another lens
  NodeHarness adjust(GetParam());
  adjust.input<ImageBlock>("block", spoilt);
  adjust.run();
  ASSERT_FALSE(adjust.output<Block>("block").warnings.empty());
  EXPECT_THAT(adjust.output<Block>("block").warnings[0], HasSubstr("the images contradict"));
}

TEST(ReadAicon, AnEmptyFolderIsRefused) {
  const TemporaryFolder folder;
  NodeHarness read("read.aicon");
  read.set("folder", folder.path().string());
  EXPECT_THAT(failure(read), HasSubstr("holds no *.ior file; an AICON block needs .phc, .obc, .eor and .ior"));
}

}  // namespace test_image_block_nodes

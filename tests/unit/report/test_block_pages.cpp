// The page of a block as the adjusters give it: what it says is what was adjusted.
#include <fmt/core.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <map>
#include <sstream>

#include "node_harness.hpp"
#include "show/report/image_block_page.hpp"
#include "show/report/tag_block_json.hpp"
#include "synthetic_facade.hpp"

namespace plumbline::report {
namespace test_block_pages {

using test::NodeHarness;
using testing::HasSubstr;
using Json = nlohmann::ordered_json;

/// Every edge drawn 0.4 px inwards, as detectors do.
void draw_inwards(test::SyntheticFacade& facade) {
  for (ImageTagsT& image : facade.images)
    for (auto& tag : image.tags) {
      const auto corners = tag->corners;
      for (size_t k = 0; k < 4; ++k) {
        const Eigen::Vector2d to = (corners[(k + 1) % 4] - corners[k]).normalized(),
                              back = (corners[(k + 3) % 4] - corners[k]).normalized();
        tag->corners[k] += 0.4 / std::abs(to.x() * back.y() - to.y() * back.x()) * (to + back);
      }
    }
}

/// Twice the same camera under two names, by turns; one corner is wrong.
test::SyntheticFacade facade_of(CameraT& cameras) {
  auto facade = test::make_facade({.floors = 1, .pixel_sigma = 0.2, .survey_sigma = 0.001});
  draw_inwards(facade);
  cameras = facade.camera_artifact();
  cameras.id = "left";
  cameras.others.push_back(std::make_unique<CameraT>(facade.camera_artifact()));
  cameras.others[0]->id = "right";
  for (size_t i = 0; i < facade.images.size(); ++i) facade.images[i].camera = i % 2 ? "right" : "left";
  facade.images[3].tags[2]->corners[1].x() += 40;
  return facade;
}

TagBlockInput adjusted() {
  CameraT cameras;
  auto facade = facade_of(cameras);
  NodeHarness node("adjust.schur");
  node.input<Camera>("camera", cameras);
  node.input<Plates>("plates", facade.plates);
  node.input<Poses>("poses", facade.poses);
  node.input<Points>("control", facade.control);
  for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
  node.set("self_calibration", "free");
  node.run();
  return {node.output<Block>("block"),   node.output<Points>("points"), node.output<Poses>("poses"),
          node.output<Camera>("camera"), std::move(facade.plates),      std::move(facade.images)};
}

TEST(BlockPages, ResidualsOfATagBlockAreThoseOfTheAdjustment) {
  const TagBlockInput input = adjusted();
  const Json json = tag_block_json(input);
  std::map<std::string, double> rms;
  for (const auto& image : input.block.images) rms[image->path] = image->rms;
  ASSERT_EQ(json["images"].size(), input.observations.size());
  for (const Json& image : json["images"])
    EXPECT_NEAR(image["rms_px"].get<double>(), rms.at(image["path"].get<std::string>()), 1e-6) << image["path"];
  EXPECT_NEAR(json["statistics"]["sigma0"].get<double>(), input.block.statistics->sigma0, 1e-12);
  EXPECT_NEAR(json["cameras"][0]["corner_inset"].get<double>(), 0.4, 0.1);
}

TEST(BlockPages, EveryCameraHasItsOwnValuesAndCorrelations) {
  const Json json = tag_block_json(adjusted());
  ASSERT_EQ(json["cameras"].size(), 2u);
  for (const Json& camera : json["cameras"]) {
    EXPECT_EQ(camera["images"], 4);
    EXPECT_EQ(camera["interior_orientation"][0]["name"], "fx");
    const auto& list = camera["correlations"];
    EXPECT_TRUE(
        std::any_of(list.begin(), list.end(), [](const Json& c) { return c["of"] == "fx" && c["with"] == "fy"; }));
  }
}

TEST(BlockPages, ARejectedTagIsShownWithItsReason) {
  const TagBlockInput input = adjusted();
  const Json json = tag_block_json(input);
  ASSERT_EQ(json["rejected"].size(), input.block.rejected.size());
  ASSERT_GE(json["rejected"].size(), 1u);
  EXPECT_EQ(json["rejected"][0]["image"], input.block.rejected[0]->path);
  Markup html;
  write_image_block(html, json, "Title", "", {});
  for (const char* expected : {"σ0", "contradict all others of the plate or image", "Of the photographs"})
    EXPECT_THAT(html.str(), HasSubstr(expected));
}

TEST(BlockPages, ThingsThatAreNotOfOneAdjustmentAreRefused) {
  TagBlockInput input = adjusted();
  for (auto& pose : input.poses.poses) pose->path = "another/" + pose->path;
  EXPECT_THROW(tag_block_json(input), std::runtime_error);
}

TEST(BlockPages, ResidualsOfATargetBlockAreThoseOfTheAdjustment) {
  PLUMBLINE_REQUIRE_DATA("blocks/aicon");
  NodeHarness read("read.aicon"), adjust("adjust.schur");
  read.set("folder", test::data_file("blocks/aicon"));
  read.run();
  const auto measured = read.output<ImageBlock>("block");
  adjust.input<ImageBlock>("block", measured);
  adjust.run();
  const auto block = adjust.output<Block>("block");
  const Json json = target_block_json(block, measured);
  double squares = 0;
  for (const Json& seen : json["observations"]) squares += seen["rms_px"].get<double>() * seen["rms_px"].get<double>();
  EXPECT_NEAR(std::sqrt(squares / static_cast<double>(json["observations"].size())),
              json["statistics"]["rms_px"].get<double>(), 1e-6);
  EXPECT_EQ(json["observations"].size(), 9972u);
  for (const Json& point : json["points"]) EXPECT_GT(point["largest_angle_deg"].get<double>(), 5) << point["id"];
  EXPECT_THROW(target_block_json(adjusted().block, measured), std::runtime_error);
}

/// The AICON block; every second target of the first forty is known to 0.05 mm, those between are check points whose
/// heights are `off` by as much to the same side [m].
Json aicon_with_checks(double off, NodeHarness& adjust) {
  NodeHarness read("read.image_block");
  const test::TemporaryFolder folder;
  std::ofstream list(folder.path() / "control.txt");
  std::ifstream coordinates(test::data_file("blocks/aicon/example.obc"));
  std::string line, checks;  // a list's values stand between unit separators
  for (int k = 0; k < 40 && std::getline(coordinates, line); ++k) {
    std::istringstream columns(line);
    std::string id;
    Eigen::Vector3d at;
    columns >> id >> at.x() >> at.y() >> at.z();
    if (k % 2 == 1) checks += (checks.empty() ? "" : "\x1f") + id, at.z() += 1e3 * off;
    list << id << ", P" << id << fmt::format(", {:.7f}, {:.7f}, {:.7f}", 1e-3 * at.x(), 1e-3 * at.y(), 1e-3 * at.z())
         << ", 0.00005, 0.00005, 0.00005\n";
  }
  list.close();
  read.set("folder", test::data_file("blocks/aicon"));
  read.set("control", (folder.path() / "control.txt").string());
  read.set("check", checks);
  read.run();
  const auto measured = read.output<ImageBlock>("block");
  adjust.input<ImageBlock>("block", measured);
  adjust.run();
  return target_block_json(adjust.output<Block>("block"), measured);
}

/// Once "They hold", of twenty that were three standard deviations off to the same side.
TEST(BlockPages, CheckPointsThatAreOffTogetherDoNotHold) {
  PLUMBLINE_REQUIRE_DATA("blocks/aicon/example.obc");
  NodeHarness sound("adjust.schur"), shifted("adjust.schur");
  const Json good = aicon_with_checks(0, sound)["check_points"], bad = aicon_with_checks(2e-4, shifted)["check_points"];
  EXPECT_TRUE(good["holds"]) << good["words"];
  EXPECT_EQ(sound.metric("invalid"), 0);
  EXPECT_GT(good["degrees_of_freedom"], 50);
  for (const Json& point : bad["points"]) EXPECT_FALSE(point["contradicts"]) << point;
  EXPECT_FALSE(bad["holds"]);
  EXPECT_EQ(shifted.metric("invalid"), 1) << "as the adjuster says";
  EXPECT_GT(bad["nees"].get<double>(), bad["limit"].get<double>());
  EXPECT_THAT(bad["words"][0].get<std::string>(), HasSubstr("together are off by more"));
}

/// Two surveyed points that were withheld; `off`: of the second one's height [m].
BlockT with_checks(double off) {
  BlockT block;
  block.statistics = std::make_unique<StatisticsT>();
  block.targets = std::make_unique<TargetBlockT>();
  block.targets->image_sigma_px = block.targets->image_sigma = 1;
  for (const std::string id : {"1003", "1004"}) {
    auto point = std::make_unique<AdjustedPointT>();
    point->id = id, point->covariance = {1e-6, 0, 0, 1e-6, 0, 4e-6};
    block.targets->points.push_back(std::move(point));
    auto known = std::make_unique<AdjustedControlT>();
    known->id = id, known->use = "check";
    known->given_sigma = Eigen::Vector3d::Constant(1e-3);
    known->residual = Eigen::Vector3d(1e-3, 0, id == "1004" ? off : 0);
    known->w = Eigen::Vector3d(0.7, 0, id == "1004" ? off / 2.24e-3 : 0);
    block.targets->control.push_back(std::move(known));
  }
  return block;
}

/// Once the page had the root mean square alone, and a check point 50 mm off was a row like the others.
TEST(BlockPages, CheckPointsOfATargetBlockAreJudged) {
  const Json sound = target_block_json(with_checks(2e-3), {}), wrong = target_block_json(with_checks(-0.05), {});
  EXPECT_TRUE(sound["check_points"]["holds"]);
  EXPECT_FALSE(wrong["check_points"]["holds"]);
  EXPECT_NEAR(sound["check_points"]["points"][1]["nees"].get<double>(), 0.5 + 0.8, 1e-9) << "1 of 2, and 4 of 5";
  EXPECT_NEAR(wrong["check_points"]["largest_nees"].get<double>(), 500.5, 1e-9);
  EXPECT_NEAR(wrong["check_points"]["limit_of_a_point"].get<double>(), 17.7, 0.1) << "0.05 % of chi squared of 3";
  ASSERT_EQ(wrong["check_points"]["words"].size(), 1u);
  EXPECT_THAT(wrong["check_points"]["words"][0].get<std::string>(),
              testing::StartsWith("check point 1004 contradicts"));
  EXPECT_FALSE(wrong["points"][0]["contradicts"]);
  EXPECT_TRUE(wrong["points"][1]["contradicts"]);
  Markup good, bad;
  write_image_block(good, sound, "Block", "", {});
  write_image_block(bad, wrong, "Block", "", {});
  EXPECT_THAT(good.str(),
              testing::HasSubstr("allow, largest NEES of a point 1.3 of 3 degrees of freedom (at most 17.7)"));
  EXPECT_THAT(bad.str(), testing::HasSubstr("They do not hold, largest NEES of a point 500.5 of 3 degrees of freedom"));
  EXPECT_THAT(bad.str(), testing::HasSubstr("22.3 !"));
}

/// Once each point was drawn twice and the first 3000 alone in space, without a word: 70 MB of 500 000 measurements.
TEST(BlockPages, OfManyPointsSomeAreDrawnAndThePageSaysWhich) {
  Json json = tag_block_json(adjusted());
  const auto page = [&](int points) {
    json["points"] = Json::array();
    for (int i = 0; i < points; ++i)
      json["points"].push_back(
          {{"id", "P" + std::to_string(i)}, {"position", {i % 100, i / 100, i % 7}}, {"sigma", {1e-3, 1e-3, 1e-3}}});
    Markup html;
    write_image_block(html, json, "Title", "", {});
    return html.str();
  };
  EXPECT_THAT(page(3000), HasSubstr("dots are points."));
  const std::string many = page(10000);
  EXPECT_THAT(many, HasSubstr("dots are points, one in 4 of 10000."));
  EXPECT_THAT(many, HasSubstr("{\"n\":\"P9996\""));
  EXPECT_LT(many.size(), 1.3 * static_cast<double>(page(3000).size()));
}

/// Of two that are equally bad the first is shown first; what somebody measured by hand comes before all others.
TEST(BlockPages, TheWorstObservationsAreTheWorst) {
  Json json = tag_block_json(adjusted());
  json["observations"] = Json::array();
  for (int i = 0; i < 40; ++i)
    json["observations"].push_back({{"image", "I"},
                                    {"point", "P" + std::to_string(i)},
                                    {"corners", {{1, 1}}},
                                    {"residuals", {{1, 0}}},
                                    {"rms_px", i == 7 || i == 30 ? 9.0 : 0.01 * i},
                                    {"control", i == 3}});
  Markup html;
  write_image_block(html, json, "Title", "", {});
  std::vector<std::string> shown;
  const std::string text = html.str();
  for (size_t at = text.find("<div class=\"name\">P"); at != std::string::npos;
       at = text.find("<div class=\"name\">P", at + 1))
    if (std::isdigit(static_cast<unsigned char>(text[at + 19])))
      shown.push_back(text.substr(at + 18, text.find(' ', at + 18) - at - 18));
  EXPECT_THAT(shown, testing::ElementsAre("P3", "P7", "P30", "P39", "P38", "P37", "P36", "P35"));
}

/// Before the page is made, so that a block that is not that of the measurements tells it as well.
TEST(BlockPages, WhatThePageOfManyTargetsTakesIsAnnounced) {
  const auto announced = [](size_t measurements) {
    ImageBlockT measured;
    measured.measurements.resize(measurements);
    NodeHarness node("report.target_block");
    BlockT block;
    block.statistics = std::make_unique<StatisticsT>();
    node.input<Block>("block", block);
    node.input<ImageBlock>("measured", measured);
    EXPECT_THROW(node.run(), test::NodeFailed);
    return node.announced();
  };
  EXPECT_EQ(announced(25'000), 25'000u * 2600u);
  EXPECT_EQ(announced(1000), 0u);
}

}  // namespace test_block_pages
}  // namespace plumbline::report

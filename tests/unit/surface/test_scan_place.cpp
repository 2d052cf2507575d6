// dense.import: a scan that lies one panel beside its own looks the same on a facade of equal panels, unless it shows
// where the facade ends.
#include <gtest/gtest.h>

#include <fstream>
#include <vector>

#include "artifacts/design.hpp"
#include "artifacts/surface_judgement.hpp"
#include "artifacts/surface_points.hpp"
#include "artifacts/surfaces.hpp"
#include "artifacts/transform.hpp"
#include "node_harness.hpp"

namespace test_scan_place {

using namespace plumbline;
using namespace plumbline::test;

constexpr int kColumns = 4, kRows = 2;
constexpr double kPitch = 1.02;  // panels of 1 m with joints of 20 mm

const std::vector<double> kAlike(kRows, 1.0);  // heights of rows of panels
constexpr double kJoint = kPitch - 1;

/// Middle of a row.
double middle_of(const std::vector<double>& heights, size_t row) {
  double up = 5 - 0.5 * heights[0];
  for (size_t r = 0; r < row; ++r) up += heights[r] + kJoint;
  return up + 0.5 * heights[row];
}

/// To the south.
DesignT facade(const std::vector<double>& heights = kAlike) {
  DesignT design;
  design.facade_normal = design.site_origin = Eigen::Vector3d::Constant(std::nan(""));
  for (size_t row = 0; row < heights.size(); ++row)
    for (int column = 0; column < kColumns; ++column) {
      auto element = std::make_unique<DesignElementT>();
      element->name = "P" + std::to_string(row) + std::to_string(column), element->guid = element->name + "-guid";
      element->class_ = "IfcPlate", element->is_panel = true;
      element->placement = {Eigen::Quaterniond::Identity(), {20 + kPitch * column, 30, middle_of(heights, row)}};
      element->position = element->placement.translation;
      element->box_low = {-0.5, 0, -0.5 * heights[row]}, element->box_high = {0.5, 0.05, 0.5 * heights[row]};
      element->facade = std::make_unique<FacadeFrameT>();
      element->facade->out = {0, -1, 0}, element->facade->up = {0, 0, 1}, element->facade->right = {1, 0, 0};
      element->facade->confirmed = true, element->facade->source = "own_axes";
      design.elements.push_back(std::move(element));
    }
  return design;
}

/// Of some columns, moved, with the ground before the facade.
std::string scan(int first, int last, const Eigen::Vector3d& moved, const std::vector<double>& heights = kAlike) {
  std::string text;
  char line[120];
  const auto add = [&](double x, double y, double z) {
    std::snprintf(line, sizeof line, "%.6f %.6f %.6f\n", x + moved.x(), y + moved.y(), z + moved.z());
    text += line;
  };
  for (int column = first; column <= last; ++column)
    for (size_t row = 0; row < heights.size(); ++row)
      for (int i = 0; i < 25; ++i)
        for (int j = 0; j < 25; ++j)
          add(20 + kPitch * column - 0.48 + 0.04 * i, 29.999 + 1e-4 * ((7 * i + 3 * j) % 5),
              middle_of(heights, row) + heights[row] * (0.04 * j - 0.48));
  for (int i = 0; i < 400; ++i) add(18 + 0.02 * i, 25, 4);
  return text;
}

struct Placed {
  TemporaryFolder folder;
  NodeHarness depth{"dense.import"}, panels{"surface.panels"}, judge{"surface.judge"};
  SurfacePointsT points;
  SurfaceJudgementT judgement;

  explicit Placed(const std::string& cloud, bool confirmed = false, bool registered = false,
                  const std::vector<double>& heights = kAlike) {
    const std::string path = (folder.path() / "scan.xyz").string();
    std::ofstream(path) << cloud;
    depth.set("file", path), depth.set("unit", "m"), depth.set("noise", "0.001");
    if (confirmed) depth.set("place_confirmed", "true");
    depth.input<Design>("design", facade(heights));
    if (registered) {
      TransformT registration;
      registration.to_from_from = {Eigen::Quaterniond::Identity(), Eigen::Vector3d::Zero()}, registration.scale = 1;
      depth.input<Transform>("registration", registration);
    }
    depth.run();
    points = depth.output<SurfacePoints>("surface");
    panels.input<SurfacePoints>("surface", points), panels.run();
    judge.input<Surfaces>("surfaces", panels.output<Surfaces>("surfaces"));
    judge.input<Design>("design", facade(heights));
    judge.set("rules", "*: flatness(0.1m)=3mm, bow=3mm"), judge.run();
    judgement = judge.output<SurfaceJudgement>("judgement");
  }
};

TEST(ScanPlace, OneThatEndsWhereTheFacadeDoesIsConfirmedByIt) {
  const Placed right(scan(0, kColumns - 1, {0, 0, 0}));
  EXPECT_EQ(right.points.place_doubt, "");
  EXPECT_TRUE(right.points.warnings.empty()) << right.points.warnings[0];
  EXPECT_EQ(right.judgement.passed, 2 * kColumns * kRows);
}

TEST(ScanPlace, OneThatIsMovedByAPanelIsNotJudged) {
  for (const auto& [moved, words] :
       {std::pair<Eigen::Vector3d, const char*>{{kPitch, 0, 0},
                                                "6 of 8 panels, and on 8 if it is moved by 1.02 m to the left"},
        {{-kPitch, 0, 0}, "6 of 8 panels, and on 8 if it is moved by 1.02 m to the right"},
        {{0, 0, kPitch}, "4 of 8 panels, and on 8 if it is moved by 1.02 m down"}}) {
    const Placed beside(scan(0, kColumns - 1, moved));
    EXPECT_NE(beside.points.place_doubt.find(words), std::string::npos) << beside.points.place_doubt;
    EXPECT_EQ(beside.judgement.passed, 0);
    EXPECT_EQ(beside.judgement.not_judged, 2 * kColumns * kRows);
    EXPECT_EQ(beside.judge.metric("invalid"), 1) << "exit code 3";
    for (const auto& request : beside.judgement.requests) EXPECT_NE(request->not_judged, "");
  }
  const Placed known(scan(0, kColumns - 1, {kPitch, 0, 0}), true);
  EXPECT_EQ(known.judgement.passed, 12) << "what is not hung yet has no points";
  const Placed registered(scan(0, kColumns - 1, {kPitch, 0, 0}), false, true);
  EXPECT_EQ(registered.points.place_doubt, "");
}

/// Parapets and windows in turn: no panel has an equal one beside it, and a storey looks like the next one all the
/// same.
TEST(ScanPlace, OneThatIsMovedByAStoreyOfPanelsOfSeveralSizesIsNotJudged) {
  const std::vector<double> heights = {0.6, 1.4, 0.6, 1.4, 0.6, 1.4};
  const double storey = 2 + 2 * kJoint;
  for (const auto& [moved, words] :
       {std::pair<Eigen::Vector3d, const char*>{{0, 0, storey},
                                                "16 of 24 panels, and on 24 if it is moved by 2.04 m down"},
        {{0, 0, -2 * storey}, "8 of 24 panels, and on 24 if it is moved by 4.08 m up"},
        {{kPitch, 0, storey}, "12 of 24 panels, and on 24 if it is moved by 1.02 m to the left and 2.04 m down"}}) {
    const Placed beside(scan(0, kColumns - 1, moved, heights), false, false, heights);
    EXPECT_NE(beside.points.place_doubt.find(words), std::string::npos) << beside.points.place_doubt;
    EXPECT_EQ(beside.judgement.passed, 0);
  }
  const Placed right(scan(0, kColumns - 1, {0, 0, 0}, heights), false, false, heights);
  EXPECT_EQ(right.points.place_doubt, "");
  EXPECT_TRUE(right.points.warnings.empty()) << right.points.warnings[0];
  EXPECT_EQ(right.judgement.passed, 48);
}

TEST(ScanPlace, WhatNothingConfirmsIsSaid) {
  const Placed part(scan(1, 2, {0, 0, 0}));
  EXPECT_EQ(part.points.place_doubt, "");
  ASSERT_EQ(part.points.warnings.size(), 1U);
  EXPECT_NE(part.points.warnings[0].find("Nothing in the scan confirms which panel is which: moved by 1.02 m to the "),
            std::string::npos)
      << part.points.warnings[0];
  EXPECT_EQ(part.panels.output<Surfaces>("surfaces").warnings, part.points.warnings) << "the page has it from there";
  EXPECT_EQ(part.judgement.passed, 8);
}

}  // namespace test_scan_place

// Deviations, verdicts and panel fits, against values worked out by hand.
#include <gtest/gtest.h>

#include "ifc/as_built.hpp"

namespace plumbline::bim {
namespace {

Element anchor_at(const std::string& name, const Eigen::Vector3d& position) {
  Element element;
  element.name = name;
  element.guid = "guid of " + name;
  element.position = position;
  element.is_anchor = true;
  return element;
}

AsBuiltAnchor measured(const std::string& id, const Eigen::Vector3d& position, double sigma = 0.0005) {
  AsBuiltAnchor anchor;
  anchor.id = id;
  anchor.position = position;
  anchor.covariance = Eigen::Matrix3d::Identity() * sigma * sigma;
  return anchor;
}

/// Four anchors on a facade along y = 0, and a slab behind it.
Design facade() {
  Design design;
  design.file_name = "d.ifc";
  for (int i = 0; i < 4; ++i)
    design.elements.push_back(anchor_at("A" + std::to_string(i), {2.0 * (i % 2), 0, 2.0 * (i / 2)}));
  Element slab;
  slab.name = "Slab";
  slab.position = {1, 4, 0};
  design.elements.push_back(slab);
  return design;
}

std::vector<AnchorDeviation> matched(const Design& design, const AsBuilt& as_built) {
  std::vector<std::string> unmatched;
  return match_anchors(design, as_built, unmatched);
}

std::string message_of(const Design& design, const AsBuilt& as_built) {
  try {
    matched(design, as_built);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Verdict, HasAGuardBand) {
  EXPECT_EQ(verdict_of(0.003, 0.001, 0.005, 2), Verdict::pass);
  EXPECT_EQ(verdict_of(-0.0031, 0.001, 0.005, 2), Verdict::undecided);
  EXPECT_EQ(verdict_of(0.007, 0.001, 0.005, 2), Verdict::undecided);
  EXPECT_EQ(verdict_of(-0.0071, 0.001, 0.005, 2), Verdict::fail);
  EXPECT_EQ(verdict_of(0.001, kUnknown, 0.005, 2), Verdict::undecided);
  EXPECT_EQ(verdict_of(0.006, kUnknown, 0.005, 2), Verdict::fail);
  EXPECT_EQ(verdict_of(kUnknown, 0.001, 0.005, 2), Verdict::not_measured);
}

TEST(Verdict, ProbabilityIsTheNormalDistributions) {
  EXPECT_NEAR(conformance_probability(0, 0.001, 0.00195996398), 0.95, 1e-6);
  EXPECT_NEAR(conformance_probability(0.005, 0.001, 0.005), 0.5, 1e-6);
  EXPECT_EQ(conformance_probability(0.004, 0, 0.005), 1);
  EXPECT_TRUE(std::isnan(conformance_probability(0.004, kUnknown, 0.005)));
}

TEST(FacadeNormal, PointsAwayFromTheBuilding) {
  Design design = facade();
  ASSERT_TRUE(estimate_facade_normal(design));
  EXPECT_NEAR((*estimate_facade_normal(design) - Eigen::Vector3d(0, -1, 0)).norm(), 0, 1e-12);
  design.elements[4].position.y() = -4;
  EXPECT_NEAR((*estimate_facade_normal(design) - Eigen::Vector3d(0, 1, 0)).norm(), 0, 1e-12);
  design.elements[1].position = {0, 2, 0};  // anchors on two facades
  EXPECT_FALSE(estimate_facade_normal(design));
}

TEST(Deviation, IsAsBuiltMinusDesign) {
  AsBuilt as_built;
  as_built.anchors = {measured("A1", {2.003, -0.004, 0.001}), measured("A3", {2, 0, 2.0071})};
  const Design design = facade();
  const auto anchors = matched(design, as_built);
  ASSERT_EQ(anchors.size(), 4u);
  EXPECT_EQ(anchors[0].verdict, Verdict::not_measured);
  EXPECT_NEAR((anchors[1].deviation - Eigen::Vector3d(0.003, -0.004, 0.001)).norm(), 0, 1e-12);
  EXPECT_NEAR(anchors[1].out_of_plane, 0.004, 1e-12);
  EXPECT_NEAR(anchors[1].in_plane, std::sqrt(0.000010), 1e-12);
  EXPECT_EQ(anchors[1].verdict, Verdict::undecided);  // 5.0 mm in plan, ± 1 mm
  EXPECT_EQ(anchors[3].verdict, Verdict::fail);
  EXPECT_LT(anchors[3].pass_probability, 0.001);
}

TEST(Deviation, MisfitsAreNamed) {
  Design design = facade();
  AsBuilt as_built;
  as_built.anchors = {measured("B7", {0, 0, 0})};
  EXPECT_NE(message_of(design, as_built).find("none of the 1 anchors ('B7', …) fits an element of d.ifc"),
            std::string::npos);
  as_built.anchors.push_back(measured("A1", {2, 0, 0}));
  std::vector<std::string> unmatched;
  match_anchors(design, as_built, unmatched);
  EXPECT_EQ(unmatched, std::vector<std::string>{"B7"});
  as_built.anchors = {measured("A1", {2, 0, 0}), measured("guid of A1", {2, 0, 0})};
  EXPECT_NE(message_of(design, as_built).find("are the same element"), std::string::npos);
  as_built.anchors = {measured("A1", {691002, 5335000, 520})};
  EXPECT_NE(message_of(design, as_built).find("not in the project frame"), std::string::npos);
  design.elements[4].name = "A1";  // a slab of the same name: the anchor is meant
  as_built.anchors = {measured("A1", {2, 0, 0})};
  EXPECT_EQ(message_of(design, as_built), "no error");
  design.elements[0].name = "A1";
  EXPECT_NE(message_of(design, as_built).find("fits 3 elements"), std::string::npos);
}

TEST(PanelFit, RecoversAPoseAndLeavesOutWhatItCannotTell) {
  Design design = facade();
  Element panel;
  panel.name = "P";
  panel.is_panel = panel.has_box = true;
  panel.box_low = {-0.1, -0.3, -0.1};
  panel.box_high = {2.1, -0.2, 2.1};
  design.elements.push_back(panel);
  const Eigen::Vector3d centre(1, -0.25, 1), shift(0.002, -0.001, 0.003), turn(0.0004, -0.0003, 0.0002);
  AsBuilt as_built;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector3d p = design.elements[static_cast<std::size_t>(i)].position;
    as_built.anchors.push_back(measured("A" + std::to_string(i), p + shift + turn.cross(p - centre)));
  }
  auto anchors = matched(design, as_built);
  auto fits = fit_panels(design, anchors, 0.3);
  ASSERT_EQ(fits.size(), 1u);
  EXPECT_EQ(fits[0].anchors.size(), 4u);
  EXPECT_NEAR((fits[0].translation - shift).norm(), 0, 1e-12);
  EXPECT_NEAR((fits[0].rotation - turn).norm(), 0, 1e-12);
  EXPECT_TRUE(fit_panels(design, anchors, 0.1).empty());  // its anchors are 0.2 m off
  design.elements.back().anchor_guids = {"guid of A2"};   // what the design says goes first
  EXPECT_EQ(fit_panels(design, anchors, 0.3)[0].anchors.size(), 1u);
  design.elements.back().anchor_guids.clear();

  as_built.anchors.resize(1);  // one anchor tells a shift only
  anchors = matched(design, as_built);
  fits = fit_panels(design, anchors, 0.3);
  EXPECT_EQ(fits[0].rotation.norm(), 0);
  EXPECT_NEAR((fits[0].translation - anchors[0].deviation).norm(), 0, 1e-12);
}

}  // namespace
}  // namespace plumbline::bim

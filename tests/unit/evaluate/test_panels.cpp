// Panels from the deviations of their anchors, against motions that are known.
#include <gtest/gtest.h>

#include "../bim/facing.hpp"
#include "building/judgement/own_anchors.hpp"
#include "building/judgement/panels.hpp"
#include "building/judgement/worst_first.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_panels {

using judgement::test::mm;

/// A facade that looks to -y: a panel of 2 m by 2 m about (1, 0, 1), held at its corners a, b (below), c, d (above).
DeviationInputs facade(std::size_t anchors) {
  const char* names[] = {"a", "c", "b", "d"};  // the first two stand above each other
  const Eigen::Vector3d places[] = {{0, 0, 0}, {0, 0, 2}, {2, 0, 0}, {2, 0, 2}};
  DeviationInputs inputs;
  PanelCase panel;
  panel.guid = "guid", panel.name = "P", panel.low = {0, -0.01, 0}, panel.high = {2, 0.01, 2};
  panel.tolerances = tolerances_of({}, {});
  for (std::size_t i = 0; i < anchors; ++i) {
    AnchorCase anchor;
    anchor.id = names[i], anchor.floor = 2, anchor.use = "check", anchor.element.guid = std::string("g") + names[i];
    anchor.design = places[i], anchor.tolerances = tolerances_of({}, {});
    inputs.anchors.push_back(anchor);
    inputs.model.ids.push_back(names[i]);
    inputs.model.positions.push_back(places[i]);
    panel.anchors.push_back(i);
  }
  inputs.model.covariance = judgement::test::isotropic(anchors, 0.3 * mm);
  inputs.panels.push_back(panel);
  plumbline::test::face(inputs, {0, -1, 0});
  return inputs;
}

void move(DeviationInputs& inputs, const Eigen::Vector3d& shift, const Eigen::Vector3d& turn) {
  for (Eigen::Vector3d& p : inputs.model.positions)
    p += shift + turn.cross(Eigen::Vector3d(p - Eigen::Vector3d(1, 0, 1)));
}

/// An L goes round a corner, and its box is in front of anchors that are the neighbour's: that had two of its four.
TEST(Panels, APanelRoundACornerTakesNoAnchorFromItsNeighbours) {
  std::vector<PanelCase> panels(3);  // about the corner at (0, 0): to -y, to -x, and round it
  panels[0].low = {1.01, -0.125, 1.05}, panels[0].high = {2.99, -0.075, 2.95};
  panels[1].low = {-0.125, 1.01, 1.05}, panels[1].high = {-0.075, 2.99, 2.95};
  panels[2].low = {-0.125, -0.125, 1.05}, panels[2].high = {0.97, 0.97, 2.95};
  std::vector<AnchorCase> anchors;
  for (const double along : {1.0, 3.0})
    for (const double z : {1.0, 3.0})
      for (const bool west : {false, true}) {
        AnchorCase& anchor = anchors.emplace_back();
        anchor.design = west ? Eigen::Vector3d(0, along, z) : Eigen::Vector3d(along, 0, z);
      }
  find_own_anchors(panels, std::vector<std::set<std::string>>(3), anchors, 0.3);
  EXPECT_EQ(panels[0].anchors.size(), 4u);
  EXPECT_EQ(panels[1].anchors.size(), 4u);
  EXPECT_EQ(panels[2].anchors.size(), 4u) << "the two mullions at its ends hold it as well";
}

TEST(Panels, AStiffMotionIsFoundAndLeavesNothing) {
  DeviationInputs inputs = facade(4);
  // Outward is -y, right is +x. Lean outward at the top: turn about +x by +: z -> -y. So the vector is (+, ., .).
  move(inputs, {2 * mm, -3 * mm, 1 * mm}, {4e-4, 3e-4, -2e-4});
  const DeviationT deviation = judge_deviations(inputs, {});
  ASSERT_EQ(deviation.panels.size(), 1u);
  const PanelDeviationT& p = *deviation.panels[0];
  EXPECT_EQ(p.floor, 2);
  EXPECT_EQ(p.fixings.size(), 4u);
  EXPECT_NEAR(p.out_of_plane->value, 3 * mm, 1e-12);
  EXPECT_NEAR(p.sideways->value, 2 * mm, 1e-12);
  EXPECT_NEAR(p.vertical->value, 1 * mm, 1e-12);
  EXPECT_NEAR(p.lean, 4e-4, 1e-12);
  EXPECT_NEAR(p.turn, 2e-4, 1e-12);   // about -z: the right side comes outward
  EXPECT_NEAR(p.roll, -3e-4, 1e-12);  // about +y the right side goes down
  EXPECT_NEAR(p.warp->value, 0, 1e-12);
  EXPECT_NEAR(p.misfit->value, 0, 1e-12);
  // A corner p = (±1, 0, ±1) m moves by r × p = (3e-4 pz, -2e-4 px - 4e-4 pz, -3e-4 px): most where px = pz.
  EXPECT_NEAR(p.tilt->value, std::sqrt(0.3 * 0.3 + 0.6 * 0.6 + 0.3 * 0.3) * mm, 1e-12);
  // A mean of four anchors of 0.3 mm; a lean is a difference of means over 2 m.
  EXPECT_NEAR(p.out_of_plane->u, 0.15 * mm, 1e-12);
  EXPECT_NEAR(p.u_lean, 0.15e-3, 1e-9);
  EXPECT_EQ(p.verdict, ToleranceVerdict::pass);
  // The top right corner leans and turns outward on top of the shift: 3 + 0.4 + 0.2 mm.
  EXPECT_NEAR(p.corner->value, 3.6 * mm, 1e-12);
  EXPECT_EQ(p.decided_by, "corner");
  EXPECT_NEAR(p.fixings[0]->shim, -(3 - 0.4 - 0.2) * mm, 1e-12);
}

TEST(Panels, WarpAndMisfitAreWhatAStiffPanelCannotFollow) {
  DeviationInputs inputs = facade(4);
  const double signs[] = {1, -1, -1, 1};  // a saddle: opposite corners alike
  for (std::size_t i = 0; i < 4; ++i) inputs.model.positions[i].y() -= 9 * mm * signs[i];
  DeviationT deviation = judge_deviations(inputs, {});
  EXPECT_NEAR(deviation.panels[0]->warp->value, 9 * mm, 1e-12);
  EXPECT_NEAR(deviation.panels[0]->tilt->value, 0, 1e-12);
  EXPECT_EQ(deviation.panels[0]->verdict, ToleranceVerdict::fail);
  EXPECT_EQ(deviation.panels[0]->decided_by, "warp");

  inputs = facade(4);
  inputs.model.positions[2].x() += 4 * mm, inputs.model.positions[3].x() += 4 * mm;  // the columns stand apart
  deviation = judge_deviations(inputs, {});
  EXPECT_NEAR(deviation.panels[0]->misfit->value, 2 * mm, 1e-12);
  EXPECT_NEAR(deviation.panels[0]->sideways->value, 2 * mm, 1e-12);
}

TEST(Panels, WhatTheAnchorsCannotTellIsUnknown) {
  DeviationInputs inputs = facade(2);  // above each other
  move(inputs, {0, -1 * mm, 0}, {1e-3, 0, 0});
  DeviationT deviation = judge_deviations(inputs, {});
  const PanelDeviationT& two = *deviation.panels[0];
  EXPECT_NEAR(two.lean, 1e-3, 1e-12);
  EXPECT_TRUE(std::isnan(two.turn));
  EXPECT_TRUE(std::isfinite(two.roll));
  EXPECT_TRUE(std::isnan(two.warp->value));
  EXPECT_NEAR(two.misfit->value, 0, 1e-12);

  inputs = facade(1);
  move(inputs, {0, -1 * mm, 0}, Eigen::Vector3d::Zero());
  deviation = judge_deviations(inputs, {});
  EXPECT_NEAR(deviation.panels[0]->out_of_plane->value, 1 * mm, 1e-12);
  EXPECT_TRUE(std::isnan(deviation.panels[0]->lean) && std::isnan(deviation.panels[0]->tilt->value));
  EXPECT_EQ(deviation.panels[0]->tilt->verdict, ToleranceVerdict::not_measured);
}

/// One point says where it hangs and nothing of how it is turned: three of its corners may be anywhere.
TEST(Panels, OneAnchorAloneShowsNoPanelToBeInPlace) {
  DeviationInputs inputs = facade(1);
  DeviationT deviation = judge_deviations(inputs, {});
  EXPECT_EQ(deviation.anchors[0]->verdict, ToleranceVerdict::pass);
  EXPECT_EQ(deviation.panels[0]->verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(deviation.panels[0]->decided_by, "one_anchor");
  EXPECT_EQ(
      deviation.panels[0]->reason,
      "its place is known from anchor a alone, three of the six ways in which it can be off: how it is turned about "
      "that anchor is not known, nor where its corners are");
  EXPECT_EQ(deviation.verdict, ToleranceVerdict::undecided);
  EXPECT_TRUE(std::isinf(deviation.panels[0]->tau_pass)) << "at no tolerance";
  inputs.model.positions[0].y() -= 9 * mm;
  EXPECT_EQ(judge_deviations(inputs, {}).panels[0]->verdict, ToleranceVerdict::fail) << "what is out is out";
}

/// Two points tell five of the six ways in which a stiff body moves. The plan of its brackets holds such a panel too
/// (Gate.TwoBracketsDoNotTellATurnAboutTheirLine).
TEST(Panels, AnchorsInOneLineShowNoPanelToBeInPlace) {
  const auto judged = [](const DeviationInputs& inputs) { return std::move(judge_deviations(inputs, {}).panels[0]); };
  const auto two = judged(facade(2));
  EXPECT_EQ(two->verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(two->decided_by, "anchors_in_line");
  EXPECT_EQ(two->reason,
            "its 2 anchors are in one line: how it is turned about that is not known, nor how far its corners are out; "
            "where the panel below or a sill holds its bottom edge, held_below says so");
  EXPECT_TRUE(std::isinf(two->tau_pass)) << "at no tolerance";
  EXPECT_TRUE(std::isnan(two->pass_probability)) << "of what is asked, a part is known";
  EXPECT_EQ(judged(facade(4))->verdict, ToleranceVerdict::pass);
  EXPECT_EQ(judged(facade(3))->verdict, ToleranceVerdict::pass);
  DeviationInputs out = facade(2);
  for (Eigen::Vector3d& p : out.model.positions) p.y() -= 9 * mm;
  EXPECT_EQ(judged(out)->verdict, ToleranceVerdict::fail) << "what is out is out";
  // All that is asked of a strip along its anchors is known.
  DeviationInputs strip = facade(2);
  strip.panels[0].low.x() = -0.04, strip.panels[0].high.x() = 0.04;
  EXPECT_EQ(judged(strip)->verdict, ToleranceVerdict::pass) << judged(strip)->reason;
  strip.panels[0].high.x() = 0.06;
  EXPECT_EQ(judged(strip)->verdict, ToleranceVerdict::undecided);
  // Heights alone: a turn about a vertical line changes none.
  DeviationInputs heights = facade(2);
  heights.panels[0].tolerances = {{Axis::vertical, {5 * mm, "rule"}}};
  EXPECT_EQ(judged(heights)->verdict, ToleranceVerdict::pass) << judged(heights)->reason;
}

TEST(Panels, UnmeasuredAnchorsAreLeftOutAndAPanelWithoutAnyIsNotListed) {
  DeviationInputs inputs = facade(4);
  inputs.model.positions[1].setConstant(std::nan(""));
  DeviationT deviation = judge_deviations(inputs, {});
  EXPECT_EQ(deviation.panels[0]->fixings.size(), 3u);
  EXPECT_EQ(deviation.panels[0]->missing, std::vector<std::string>{"c"});
  EXPECT_EQ(deviation.panels[0]->verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(deviation.panels[0]->decided_by, "missing_anchor");
  for (auto& p : inputs.model.positions) p.setConstant(std::nan(""));
  EXPECT_TRUE(judge_deviations(inputs, {}).panels.empty());
}

TEST(Panels, NeverPassOnAnAnchorThatFails) {
  DeviationInputs inputs = facade(4);
  inputs.model.positions[0].y() -= 7 * mm;  // one of four: shift 1.75, warp 1.75 mm, each within 5 mm
  const DeviationT deviation = judge_deviations(inputs, {});
  EXPECT_EQ(deviation.anchors[0]->verdict, ToleranceVerdict::fail);
  EXPECT_LT(std::abs(deviation.panels[0]->out_of_plane->value), 2 * mm);
  EXPECT_EQ(deviation.panels[0]->verdict, ToleranceVerdict::fail);
  EXPECT_EQ(deviation.panels[0]->decided_by, "anchor");
  EXPECT_NE(deviation.panels[0]->reason.find("anchor a horizontal 7.0 mm (limit 5 mm)"), std::string::npos)
      << deviation.panels[0]->reason;
}

/// A rule for the panel's place in its plane limited the slots of its anchors only, and the page said "judged: yes".
TEST(Panels, AreHeldAgainstTheLengthInTheirPlaneWhereThatIsAsked) {
  DeviationInputs inputs = facade(4);
  move(inputs, {3 * mm, 0, -4 * mm}, Eigen::Vector3d::Zero());
  EXPECT_EQ(judge_deviations(inputs, {}).panels[0]->in_plane, nullptr);
  EXPECT_EQ(judge_deviations(inputs, {}).panels[0]->verdict, ToleranceVerdict::pass) << "each within its 5 mm";
  inputs.panels[0].tolerances = tolerances_of({0.005, true, {parse_rule("*: in_plane=3mm")}}, {});
  const DeviationT result = judge_deviations(inputs, {});
  const PanelDeviationT& p = *result.panels[0];
  ASSERT_NE(p.in_plane, nullptr);
  EXPECT_NEAR(p.in_plane->value, 5 * mm, 1e-12);
  EXPECT_NEAR(p.in_plane->u, 0.15 * mm, 1e-12);
  EXPECT_EQ(p.in_plane->tolerance, 3 * mm);
  EXPECT_EQ(p.verdict, ToleranceVerdict::fail);
  EXPECT_EQ(p.decided_by, "in_plane");
  EXPECT_EQ(p.reason, "in plane 5.0 mm (limit 3 mm)");
  EXPECT_LT(p.pass_probability, 0.01);
  inputs.panels[0].tolerances = tolerances_of({0.005, true, {parse_rule("*: in_plane=6mm")}}, {});
  EXPECT_EQ(judge_deviations(inputs, {}).panels[0]->verdict, ToleranceVerdict::pass);
}

/// Once 0.31 stood beside the FAIL of a panel one of whose anchors was out.
TEST(Panels, AreNoMoreProbableThanTheirAnchorsAndJoints) {
  DeviationInputs inputs = facade(4);
  inputs.model.positions[0].y() -= 7 * mm;
  const DeviationT deviation = judge_deviations(inputs, {});
  EXPECT_EQ(deviation.panels[0]->decided_by, "anchor");
  EXPECT_LE(deviation.panels[0]->pass_probability, deviation.anchors[0]->pass_probability);
  EXPECT_LT(deviation.panels[0]->pass_probability, 0.05);
}

/// The side is guessed or in dispute: what depends on it may not fail a panel.
void unconfirmed(DeviationInputs& inputs, ifc::FacadeSource source) {
  const ifc::FacadeFrame frame = ifc::frame_facing({0, -1, 0}, source, false);
  for (AnchorCase& anchor : inputs.anchors) anchor.facade = frame;
  for (PanelCase& panel : inputs.panels) panel.facade = frame;
}

TEST(Panels, NoneFailsByASideThatIsNotConfirmed) {
  DeviationInputs inputs = facade(4);
  // Outward 4 mm of +5/-2 mm by the truth; the guess has it the other way round.
  inputs.panels[0].tolerances = tolerances_of({0.005, true, {parse_rule("*: out_of_plane=+5/-2mm")}}, {});
  move(inputs, {0, 4 * mm, 0}, Eigen::Vector3d::Zero());
  ASSERT_EQ(judge_deviations(inputs, {}).panels[0]->verdict, ToleranceVerdict::fail);
  for (const auto source : {ifc::FacadeSource::guess, ifc::FacadeSource::plate}) {
    unconfirmed(inputs, source);
    const DeviationT result = judge_deviations(inputs, {});
    const PanelDeviationT& p = *result.panels[0];
    EXPECT_EQ(p.verdict, ToleranceVerdict::undecided) << p.reason;
    EXPECT_EQ(p.decided_by, "facade") << p.reason;
    EXPECT_NEAR(p.out_of_plane->value, 4 * mm, 1e-12) << "its size, without a sign";
    EXPECT_GE(p.corner->value, 0);
    EXPECT_EQ(p.out_of_plane->verdict, ToleranceVerdict::not_measured);
    EXPECT_TRUE(std::isinf(p.tau_pass));
  }
  // Of one value on both sides it fails whichever side it is, unless the plane itself is a guess.
  inputs.panels[0].tolerances = tolerances_of({0.005, true, {parse_rule("*: out_of_plane=3mm")}}, {});
  unconfirmed(inputs, ifc::FacadeSource::plate);
  EXPECT_EQ(judge_deviations(inputs, {}).panels[0]->verdict, ToleranceVerdict::fail);
  unconfirmed(inputs, ifc::FacadeSource::guess);
  EXPECT_EQ(judge_deviations(inputs, {}).panels[0]->verdict, ToleranceVerdict::undecided);
}

/// "Never too far out": of two anchors, or of four, a panel that leans a little is not out of a tolerance of nothing.
TEST(Panels, ATiltIsHeldAgainstTheMiddleOfTwoSides) {
  for (const std::size_t anchors : {2u, 4u}) {
    DeviationInputs inputs = facade(anchors);
    inputs.panels[0].tolerances = tolerances_of({0.005, true, {parse_rule("*: out_of_plane=+0/-5mm")}}, {});
    move(inputs, {0, 2.5 * mm, 0}, {2e-4, 0, 0});  // 2.5 mm in, leaning by 0.2 mm at its anchors
    const double saddle[] = {0.3, -0.3, -0.3, 0.3};
    for (std::size_t i = 0; anchors == 4 && i < 4; ++i) inputs.model.positions[i].y() += saddle[i] * mm;
    const DeviationT result = judge_deviations(inputs, {});
    const PanelDeviationT& p = *result.panels[0];
    EXPECT_EQ(p.tilt->verdict, ToleranceVerdict::pass) << anchors << ": " << p.decided_by << ": " << p.reason;
    EXPECT_EQ(p.verdict, anchors == 4 ? ToleranceVerdict::pass : ToleranceVerdict::undecided) << p.reason;
    EXPECT_NEAR(p.tilt->tolerance, 2.5 * mm, 1e-12);
    move(inputs, Eigen::Vector3d::Zero(), {4e-3, 0, 0});
    EXPECT_EQ(judge_deviations(inputs, {}).panels[0]->tilt->verdict, ToleranceVerdict::fail);
  }
}

TEST(Panels, NonePassesOnAnAnchorOfWhichSomethingIsNotJudged) {
  DeviationInputs inputs = facade(4);
  ASSERT_EQ(judge_deviations(inputs, {}).panels[0]->verdict, ToleranceVerdict::pass);
  inputs.anchors[2].refused = {{"Pset_Tolerance.OrthogonalTolerance '4.'", "design", "it is an IFCREAL"}};
  const DeviationT result = judge_deviations(inputs, {});
  EXPECT_EQ(result.anchors[2]->verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(result.panels[0]->verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(result.panels[0]->decided_by, "anchor");
  EXPECT_NE(result.panels[0]->reason.find("anchor b"), std::string::npos) << result.panels[0]->reason;
  EXPECT_NE(result.panels[0]->reason.find("IFCREAL"), std::string::npos) << result.panels[0]->reason;
}

/// The slider of the page goes by tau_pass and tau_fail alone: at the tolerance in force they say the verdict.
TEST(Panels, TurningPointsSayTheVerdictWhereMoreThanNumbersHoldsItDown) {
  const auto slider = [](const auto& row, double tau) {
    if (row.tau_pass <= tau) return ToleranceVerdict::pass;
    return row.tau_fail > tau ? ToleranceVerdict::fail : ToleranceVerdict::undecided;
  };
  DeviationInputs inputs = facade(4);
  inputs.model.positions[0].z() += 9 * mm;
  inputs.anchors[1].refused = {{"a", "design", "b"}};
  inputs.panels[0].refused = {{"c", "design", "d"}};
  DeviationT result = judge_deviations(inputs, {});
  EXPECT_EQ(slider(*result.anchors[1], 0.005), ToleranceVerdict::undecided);
  EXPECT_EQ(slider(*result.anchors[1], 1), ToleranceVerdict::undecided) << "at no tolerance";
  EXPECT_NE(slider(*result.panels[0], 1), ToleranceVerdict::pass);
  EXPECT_EQ(slider(*result.anchors[0], 0.005), ToleranceVerdict::fail);
  EXPECT_EQ(slider(*result.anchors[0], 0.02), ToleranceVerdict::pass);
  DeviationInputs missing = facade(4);
  missing.model.positions[2].setConstant(std::nan(""));
  EXPECT_EQ(slider(*judge_deviations(missing, {}).panels[0], 1), ToleranceVerdict::undecided);
  inputs.doubts = {test::doubt("contradicts itself")};
  result = judge_deviations(inputs, {});
  for (const double tau : {0.001, 0.005, 0.02, 1.0}) {
    for (const auto& anchor : result.anchors) EXPECT_EQ(slider(*anchor, tau), ToleranceVerdict::undecided) << tau;
    for (const auto& panel : result.panels) EXPECT_EQ(slider(*panel, tau), ToleranceVerdict::undecided) << tau;
  }
}

/// What proves nothing proves nothing of an axis or a length either, and says why.
TEST(Panels, DoubtsReachEveryAxisAndLength) {
  DeviationInputs inputs = facade(4);
  inputs.model.positions[0].z() += 9 * mm;
  inputs.doubts = {test::doubt("contradicts itself")};
  const DeviationT result = judge_deviations(inputs, {});
  for (const auto& anchor : result.anchors) {
    for (const auto& axis : anchor->axes)
      EXPECT_TRUE(axis->verdict == ToleranceVerdict::undecided || axis->verdict == ToleranceVerdict::not_measured)
          << anchor->id << " " << axis->axis;
    EXPECT_NE(anchor->note.find("the survey: contradicts itself"), std::string::npos) << anchor->note;
  }
  const PanelDeviationT& p = *result.panels[0];
  for (const auto* length : {p.out_of_plane.get(), p.sideways.get(), p.vertical.get(), p.tilt.get(), p.warp.get(),
                             p.misfit.get(), p.corner.get()})
    EXPECT_TRUE(length->verdict == ToleranceVerdict::undecided || length->verdict == ToleranceVerdict::not_measured);
  EXPECT_NE(p.reason.find("the survey: contradicts itself"), std::string::npos) << p.reason;
}

TEST(Panels, JointsBetweenNeighbours) {
  DeviationInputs inputs = facade(4);
  DeviationInputs right = facade(4);  // the same panel 2.02 m to the right: a joint of 20 mm
  PanelCase neighbour = right.panels[0];
  neighbour.guid = "right", neighbour.name = "Q", neighbour.low.x() += 2.02, neighbour.high.x() += 2.02,
  neighbour.anchors.clear();
  for (AnchorCase anchor : right.anchors) {
    anchor.id += "2", anchor.element.guid += "2", anchor.design.x() += 2.02;
    neighbour.anchors.push_back(inputs.anchors.size());
    inputs.model.ids.push_back(anchor.id);
    // 4 mm to the right below, 3 mm above: turned in its plane.
    inputs.model.positions.push_back(anchor.design + Eigen::Vector3d(anchor.design.z() > 1 ? 3 * mm : 4 * mm, 0, 0));
    inputs.anchors.push_back(anchor);
  }
  inputs.panels.push_back(neighbour);
  inputs.model.covariance = judgement::test::isotropic(8, 0.3 * mm);
  for (std::size_t i = 0; i < 4; ++i) inputs.model.positions[i].x() -= 1 * mm;
  const DeviationT deviation = judge_deviations(inputs, {});
  ASSERT_EQ(deviation.panels[0]->joints.size(), 1u);
  const PanelJointT& joint = *deviation.panels[0]->joints[0];
  EXPECT_EQ(joint.side, "right");
  EXPECT_EQ(joint.panel, "right");
  EXPECT_NEAR(joint.design, 20 * mm, 1e-12);
  // The stiff panel takes half of the turn that the rows show: its anchors' heights speak against any.
  EXPECT_NEAR(joint.narrowest, 24.25 * mm, 1e-9);
  EXPECT_NEAR(joint.widest, 24.75 * mm, 1e-9);
  EXPECT_NEAR(joint.change->value, 4.75 * mm, 1e-9);
  EXPECT_NEAR(joint.change->tolerance, 10 * mm, 1e-12);
  EXPECT_EQ(deviation.panels[1]->joints[0]->side, "left");
  // Two columns of two anchors: each side's end moves with the mean of all four, turned about the centre. The two
  // panels share no anchor, so the variances add: at the lower end (1/4 + (1 m)²·2/(8 m²)) σ² each, in x.
  EXPECT_NEAR(joint.change->u, 0.3 * mm * std::sqrt(2 * (0.25 + 1.0 / 8)), 1e-6);
  // Sheets before wider cores: the page had 20 mm of the bodies here, and 32 of the same joint where surfaces are.
  for (PanelCase& panel : inputs.panels) {
    panel.outer = {panel.low, panel.high};
    panel.outer.min().x() += 6 * mm, panel.outer.max().x() -= 6 * mm;
  }
  const DeviationT of_sheets = judge_deviations(inputs, {});
  EXPECT_NEAR(of_sheets.panels[0]->joints[0]->design, 32 * mm, 1e-12);
  EXPECT_NEAR(of_sheets.panels[0]->joints[0]->narrowest, 36.25 * mm, 1e-9);
  EXPECT_NEAR(of_sheets.panels[0]->joints[0]->change->value, 4.75 * mm, 1e-9) << "what it is judged by is the same";
}

/// The order in which a site mends: failures, what is open, what was not measured, what passes; in each the larger
/// share of its tolerance first, whichever sign or length it has.
TEST(WorstFirst, OfAnchorsAndPanels) {
  using V = ToleranceVerdict;
  DeviationT d;
  const auto anchor = [&](const char* id, V verdict, double value, double tolerance) {
    auto a = std::make_unique<AnchorDeviationT>();
    a->id = id, a->verdict = verdict, a->decided_by = "vertical";
    for (const char* axis : {"horizontal", "vertical"}) {
      auto judged = std::make_unique<JudgedAxisT>();
      judged->axis = axis, judged->value = axis[0] == 'v' ? value : 99, judged->tolerance = tolerance;
      a->axes.push_back(std::move(judged));
    }
    d.anchors.push_back(std::move(a));
  };
  anchor("p1", V::pass, 1 * mm, 5 * mm), anchor("n", V::not_measured, 0, 5 * mm), anchor("f1", V::fail, 6 * mm, 5 * mm);
  anchor("u", V::undecided, 5 * mm, 5 * mm), anchor("f2", V::fail, -9 * mm, 5 * mm),
      anchor("p2", V::pass, -2 * mm, 5 * mm);
  anchor("f3", V::fail, 7 * mm, 8 * mm);  // the least of its tolerance
  std::string order;
  for (const AnchorDeviationT* a : worst_first(d)) order += a->id + " ";
  EXPECT_EQ(order, "f2 f1 f3 u n p2 p1 ");

  const auto panel = [&](const char* name, double out, double warp) {
    auto p = std::make_unique<PanelDeviationT>();
    p->name = name, p->verdict = V::pass;
    for (auto [length, value] : {std::pair{&p->out_of_plane, out}, {&p->warp, warp}}) {
      *length = std::make_unique<JudgedLengthT>();
      (*length)->value = value, (*length)->tolerance = 5 * mm;
    }
    d.panels.push_back(std::move(p));
  };
  // What has no number does not part those that have one.
  anchor("x1", V::undecided, std::nan(""), 5 * mm), anchor("x2", V::undecided, 4 * mm, 5 * mm),
      anchor("x3", V::undecided, std::nan(""), 5 * mm), anchor("x4", V::undecided, 6 * mm, 5 * mm);
  order.clear();
  for (const AnchorDeviationT* a : worst_first(d)) order += a->id + " ";
  EXPECT_EQ(order, "f2 f1 f3 x4 u x2 x1 x3 n p2 p1 ");

  panel("a", 1 * mm, 2 * mm), panel("b", -4 * mm, 1 * mm), panel("c", 3 * mm, std::nan(""));
  order.clear();
  for (const PanelDeviationT* p : worst_panels_first(d)) order += p->name + " ";
  EXPECT_EQ(order, "b c a ");
}

}  // namespace test_panels
}  // namespace plumbline::judgement

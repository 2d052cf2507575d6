// Panels from the deviations of their anchors, against motions that are known.
#include "judgement/panels.hpp"

#include <gtest/gtest.h>

#include "small_building.hpp"

namespace plumbline::evaluate {
namespace {

using test::mm;

/// A facade that looks to -y: a panel of 2 m by 2 m about (1, 0, 1), held at its corners a, b (below), c, d (above).
Inputs facade(int anchors) {
  const char* names[] = {"a", "c", "b", "d"};  // the first two stand above each other
  const Eigen::Vector3d places[] = {{0, 0, 0}, {0, 0, 2}, {2, 0, 0}, {2, 0, 2}};
  Inputs inputs;
  inputs.design.emplace();
  PanelEntry panel;
  panel.guid = "guid", panel.name = "P", panel.centre = {1, 0, 1};
  for (int i = 0; i < anchors; ++i) {
    inputs.anchors.push_back({names[i], 2, 1, 1, AnchorUse::check});
    inputs.survey.ids.push_back(names[i]);
    inputs.survey.positions.push_back(places[i]);
    panel.anchors.push_back(names[i]);
  }
  inputs.model = inputs.survey;
  *inputs.design = inputs.survey;
  test::set_sigmas(inputs, 0.3 * mm, 0.4 * mm);
  inputs.panels.push_back(panel);
  return inputs;
}

void move(Inputs& inputs, const Eigen::Vector3d& shift, const Eigen::Vector3d& turn) {
  for (Eigen::Vector3d& p : inputs.model.positions)
    p += shift + turn.cross(Eigen::Vector3d(p - inputs.panels[0].centre));
}

TEST(Panels, AStiffMotionIsFoundAndLeavesNothing) {
  Inputs inputs = facade(4);
  // Outward is -y, right is +x. Lean outward at the top: turn about +x by +: z -> -y. So the vector is (+, ., .).
  move(inputs, {2 * mm, -3 * mm, 1 * mm}, {4e-4, 3e-4, -2e-4});
  const AccuracyT accuracy = evaluate_accuracy(inputs, {});
  ASSERT_EQ(accuracy.panels.size(), 1u);
  const PanelAccuracyT& p = *accuracy.panels[0];
  EXPECT_EQ(p.floor, 2);
  EXPECT_EQ(p.anchors.size(), 4u);
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
  EXPECT_EQ(p.decided_by, "out_of_plane");
}

TEST(Panels, WarpAndMisfitAreWhatAStiffPanelCannotFollow) {
  Inputs inputs = facade(4);
  const double signs[] = {1, -1, -1, 1};  // a saddle: opposite corners alike
  for (std::size_t i = 0; i < 4; ++i) inputs.model.positions[i].y() -= 9 * mm * signs[i];
  AccuracyT accuracy = evaluate_accuracy(inputs, {});
  EXPECT_NEAR(accuracy.panels[0]->warp->value, 9 * mm, 1e-12);
  EXPECT_NEAR(accuracy.panels[0]->tilt->value, 0, 1e-12);
  EXPECT_EQ(accuracy.panels[0]->verdict, ToleranceVerdict::fail);
  EXPECT_EQ(accuracy.panels[0]->decided_by, "warp");

  inputs = facade(4);
  inputs.model.positions[2].x() += 4 * mm, inputs.model.positions[3].x() += 4 * mm;  // the columns stand apart
  accuracy = evaluate_accuracy(inputs, {});
  EXPECT_NEAR(accuracy.panels[0]->misfit->value, 2 * mm, 1e-12);
  EXPECT_NEAR(accuracy.panels[0]->sideways->value, 2 * mm, 1e-12);
}

TEST(Panels, WhatTheAnchorsCannotTellIsUnknown) {
  Inputs inputs = facade(2);  // above each other
  move(inputs, {0, -1 * mm, 0}, {1e-3, 0, 0});
  AccuracyT accuracy = evaluate_accuracy(inputs, {});
  const PanelAccuracyT& two = *accuracy.panels[0];
  EXPECT_NEAR(two.lean, 1e-3, 1e-12);
  EXPECT_TRUE(std::isnan(two.turn));
  EXPECT_TRUE(std::isfinite(two.roll));
  EXPECT_TRUE(std::isnan(two.warp->value));
  EXPECT_NEAR(two.misfit->value, 0, 1e-12);

  inputs = facade(1);
  move(inputs, {0, -1 * mm, 0}, Eigen::Vector3d::Zero());
  accuracy = evaluate_accuracy(inputs, {});
  EXPECT_NEAR(accuracy.panels[0]->out_of_plane->value, 1 * mm, 1e-12);
  EXPECT_TRUE(std::isnan(accuracy.panels[0]->lean) && std::isnan(accuracy.panels[0]->tilt->value));
  EXPECT_EQ(accuracy.panels[0]->tilt->verdict, ToleranceVerdict::not_measured);
}

TEST(Panels, UnmeasuredAnchorsAreLeftOutAndAPanelWithoutAnyIsNotListed) {
  Inputs inputs = facade(4);
  inputs.model.positions[1].setConstant(std::nan(""));
  AccuracyT accuracy = evaluate_accuracy(inputs, {});
  EXPECT_EQ(accuracy.panels[0]->anchors.size(), 3u);
  EXPECT_EQ(accuracy.panels[0]->anchors_listed, 4);
  for (auto& p : inputs.model.positions) p.setConstant(std::nan(""));
  EXPECT_TRUE(evaluate_accuracy(inputs, {}).panels.empty());
}

}  // namespace
}  // namespace plumbline::evaluate

// Unitised panels, each on two brackets and in the stack joint of the one below: a column of five against finite
// geometry, what is said where nobody knows what holds an edge, and what must not pass.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <numbers>

#include "building/judgement/panel_stack.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_panel_stack {

using judgement::test::mm;

constexpr double kWidth = 1.5, kHeight = 3.58, kJoint = 0.02, kPitch = kHeight + kJoint;

/// A column of panels 1.5 m wide on two brackets each, 0.2 m from their sides and `bracket` above their bottom edges.
struct Column {
  DeviationInputs inputs;
  ifc::FacadeFrame axes;
  double bracket;
  Eigen::Vector3d origin;

  explicit Column(const Eigen::Vector3d& out = {0, -1, 0}, double above = 3.3,
                  const Eigen::Vector3d& at = Eigen::Vector3d::Zero(), const std::string& prefix = "P")
      : axes(ifc::frame_facing(out, ifc::FacadeSource::rule, true)), bracket(above), origin(at), prefix_(prefix) {}

  Eigen::Vector3d at(double right, double up, double out) const {
    return origin + right * axes.right + up * axes.up + out * axes.out;
  }
  std::size_t add_anchor(const std::string& id, const Eigen::Vector3d& place) {
    AnchorCase anchor;
    anchor.id = id, anchor.element.guid = "g" + id, anchor.use = "check", anchor.facade = axes;
    anchor.design = place, anchor.tolerances = tolerances_of({}, {});
    inputs.anchors.push_back(anchor);
    inputs.model.ids.push_back(id), inputs.model.positions.push_back(place);
    return inputs.anchors.size() - 1;
  }
  PanelCase& add_panel(const std::string& name, double left, double bottom) {
    PanelCase panel;
    panel.guid = "g" + name, panel.name = name, panel.facade = axes;
    Eigen::Matrix3d turn;
    turn << axes.right, axes.up, axes.out;
    panel.frame_from_panel = {Eigen::Quaterniond(turn), at(left, bottom, 0)};
    panel.low = {0, 0, -0.05}, panel.high = {kWidth, kHeight, 0.05};
    panel.tolerances = tolerances_of({0.004, true, {}}, {});
    for (const double along : {0.2, kWidth - 0.2})
      panel.anchors.push_back(add_anchor(name + (along < 1 ? "L" : "R"), at(left + along, bottom + bracket, -0.1)));
    inputs.panels.push_back(panel);
    return inputs.panels.back();
  }
  void add_column(int panels, double left = 0) {
    for (int k = 0; k < panels; ++k) add_panel(prefix_ + std::to_string(k), left, k * kPitch);
  }
  void add_sill(double left = 0) {
    for (const double along : {0.1, kWidth - 0.1}) {
      const std::size_t a =
          add_anchor("S" + prefix_ + std::to_string(inputs.anchors.size()), at(left + along, -0.02, 0));
      inputs.anchors[a].is_sill = true;
    }
  }
  void hold(const StackJoint& joint) {
    for (PanelCase& panel : inputs.panels) panel.held_below = joint;
  }
  void move(std::size_t anchor, double out) { inputs.model.positions[anchor] += out * axes.out; }
  DeviationT judged(double sigma = 0.3 * mm) {
    if (inputs.model.covariance.size() == 0)
      inputs.model.covariance = judgement::test::isotropic(inputs.model.ids.size(), sigma);
    return judge_deviations(inputs, {});
  }

 private:
  std::string prefix_;
};

StackJoint joint(double sigma, double sill_sigma = nan) { return {sigma, sill_sigma, "rule"}; }

// ---- finite geometry: a stiff body on two hooks and one place of its bottom edge ----

struct Body {
  Eigen::Matrix3d turn;
  Eigen::Vector3d from, to;  ///< a place of it by design, and where that is
  Eigen::Vector3d operator()(const Eigen::Vector3d& place) const { return to + turn * (place - from); }
};

/// Its hooks' middle and direction are where the brackets are; about them it is turned until `edge` is `held` out.
Body hung(const std::array<Eigen::Vector3d, 2>& hooks, const std::array<Eigen::Vector3d, 2>& brackets,
          const Eigen::Vector3d& edge, const Eigen::Vector3d& out, double held) {
  const Eigen::Vector3d line = (brackets[1] - brackets[0]).normalized();
  const Eigen::Matrix3d aligned =
      Eigen::Quaterniond::FromTwoVectors(hooks[1] - hooks[0], line).normalized().toRotationMatrix();
  Body body{aligned, 0.5 * (hooks[0] + hooks[1]), 0.5 * (brackets[0] + brackets[1])};
  double low = -0.1, high = 0.1;
  const auto off = [&](double angle) {
    body.turn = Eigen::AngleAxisd(angle, line) * aligned;
    return out.dot(body(edge) - edge) - held;
  };
  const bool rises = off(high) > off(low);
  for (int i = 0; i < 60; ++i) ((off(0.5 * (low + high)) > 0) == rises ? high : low) = 0.5 * (low + high);
  off(0.5 * (low + high));
  return body;
}

/// The bodies of a column with its sill last; `slack`: of each bottom edge in its joint.
std::vector<Body> bodies_of(const Column& column, int panels, const std::vector<double>& slack) {
  std::vector<Body> bodies;
  for (int k = 0; k < panels; ++k) {
    std::array<Eigen::Vector3d, 2> hooks, brackets;
    for (std::size_t i = 0; i < 2; ++i) {
      const std::size_t anchor = column.inputs.panels[k].anchors[i];
      hooks[i] = column.inputs.anchors[anchor].design, brackets[i] = column.inputs.model.positions[anchor];
    }
    const Eigen::Vector3d edge = column.at(0.5 * kWidth, k * kPitch - (k > 0 ? 0.5 * kJoint : 0), 0);
    double held = slack[k];
    if (k > 0) {
      held += column.axes.out.dot(bodies.back()(edge) - edge);
    } else {
      for (std::size_t s = 2 * panels; s < column.inputs.anchors.size(); ++s)
        held += 0.5 * column.axes.out.dot(column.inputs.model.positions[s] - column.inputs.anchors[s].design);
    }
    bodies.push_back(hung(hooks, brackets, edge, column.axes.out, held));
  }
  return bodies;
}

/// What is left is of the second order: a tenth of the deviations leaves a hundredth of it.
TEST(PanelStack, FiveStiffBodiesOnTwoHooksAndAnEdgeStandWhereItSays) {
  for (const double off : {3 * mm, 0.3 * mm}) {
    test::Normal normal(7);
    Column column({0, -1, 0}, 2.6);
    column.add_column(5), column.add_sill();
    column.hold(joint(0));
    for (Eigen::Vector3d& p : column.inputs.model.positions) p += off * Eigen::Vector3d(normal(), normal(), normal());
    const DeviationT judged = column.judged();
    const std::vector<Body> bodies = bodies_of(column, 5, std::vector<double>(5, 0.0));
    double worst = 0;
    for (std::size_t k = 0; k < 5; ++k) {
      const PanelDeviationT& panel = *judged.panels[k];
      ASSERT_TRUE(panel.below) << k;
      EXPECT_EQ(panel.below->by, k == 0 ? "sill" : "panel");
      for (const auto& corner : panel.corners) {
        ASSERT_TRUE(corner->movement.allFinite()) << k << " " << corner->name;
        const Eigen::Vector3d moved = bodies[k](corner->design) - corner->design;
        worst = std::max(worst, (moved - corner->movement).norm());
      }
    }
    EXPECT_LT(worst, 0.12 * mm * std::pow(off / (3 * mm), 2));
  }
}

/// The same bodies on brackets, a sill and joints drawn 3000 times, the brackets of a floor with an error in common.
TEST(PanelStack, StatedUncertaintiesAreThoseOfDrawnColumns) {
  constexpr int kDraws = 3000;
  Column column({0, -1, 0}, 2.6);
  column.add_column(5), column.add_sill();
  column.hold(joint(0.4 * mm));
  const auto n = static_cast<Eigen::Index>(3 * column.inputs.anchors.size());
  Eigen::MatrixXd covariance = 0.3 * mm * 0.3 * mm * Eigen::MatrixXd::Identity(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j)
      if (i % 3 == j % 3) covariance(i, j) += (i / 6 == j / 6 ? 0.09 : 0.04) * mm * mm;
  column.inputs.model.covariance = covariance;
  const DeviationT judged = column.judged();
  const Eigen::MatrixXd root = covariance.llt().matrixL();
  const std::vector<Eigen::Vector3d> design = column.inputs.model.positions;
  test::Normal normal(11);
  std::array<double, 5> edge{}, lean{};
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::VectorXd z(n);
    for (double& one : z) one = normal();
    const Eigen::VectorXd off = root * z;
    for (std::size_t i = 0; i < design.size(); ++i)
      column.inputs.model.positions[i] = design[i] + off.segment<3>(3 * static_cast<Eigen::Index>(i));
    std::vector<double> slack;
    for (int k = 0; k < 5; ++k) slack.push_back(0.4 * mm * normal());
    const std::vector<Body> bodies = bodies_of(column, 5, slack);
    for (std::size_t k = 0; k < 5; ++k) {
      const Eigen::Vector3d bottom = column.at(0.5 * kWidth, static_cast<double>(k) * kPitch, 0),
                            top = bottom + kHeight * column.axes.up;
      const auto out = [&](const Eigen::Vector3d& p) { return column.axes.out.dot(bodies[k](p) - p); };
      edge[k] += out(bottom) * out(bottom), lean[k] += std::pow((out(top) - out(bottom)) / kHeight, 2);
    }
  }
  for (std::size_t k = 0; k < 5; ++k) {
    const PanelDeviationT& panel = *judged.panels[k];
    EXPECT_NEAR(std::sqrt(edge[k] / kDraws) / panel.below->u, 1, 0.05) << k;
    EXPECT_NEAR(std::sqrt(lean[k] / kDraws) / panel.u_lean, 1, 0.05) << k;
  }
}

/// r = (H - h)/h: with the other sign from edge to edge, and with all brackets' own errors below a bound for r < 1.
TEST(PanelStack, AnErrorIsHandedOnByWhatLiesAboveTheBracketsOverWhatLiesBelow) {
  for (const double above : {3.3, 2.6, 1.5}) {
    Column column({0, -1, 0}, above);
    column.add_column(12), column.add_sill();
    column.hold(joint(0));
    const DeviationT judged = column.judged(1 * mm);
    // From the middle of one joint to that of the next.
    const double h = above + 0.5 * kJoint, r = (kPitch - h) / h;
    double variance = std::pow(judged.panels[1]->below->u, 2);
    for (std::size_t k = 2; k < 12; ++k) {
      // Two brackets of 1 mm each.
      variance = std::pow(kPitch / h, 2) * 0.5 * mm * mm + r * r * variance;
      EXPECT_NEAR(judged.panels[k]->below->u, std::sqrt(variance), 1e-9) << above << " " << k;
      EXPECT_NEAR(judged.panels[k]->below->handed_on, -(kHeight - above) / h, 1e-12);
    }
    const double bound = std::sqrt(0.5 * (1 + r) / (1 - r)) * mm;
    if (r < 1) {
      EXPECT_LT(std::sqrt(variance), 1.001 * bound);
    } else {
      EXPECT_GT(std::sqrt(variance), 5 * mm) << "grows";
    }
    // A sill alone that is 2 mm out.
    for (const std::size_t sill : {24u, 25u}) column.move(sill, 2 * mm);
    const DeviationT moved = column.judged();
    double expected = 2 * mm;
    EXPECT_NEAR(moved.panels[0]->below->out_of_plane, expected, 1e-12);
    expected *= -(kPitch - above) / above + 0.5 * kJoint / above;  // its sill is at its edge, its joint above that
    for (std::size_t k = 1; k < 6; ++k) {
      if (k > 1) expected *= -r;
      EXPECT_NEAR(moved.panels[k]->below->out_of_plane, expected, 1e-9) << above << " " << k;
    }
    bool warned = false;
    for (const std::string& warning : moved.warnings)
      warned = warned || warning.find("mid-height") != std::string::npos;
    EXPECT_EQ(warned, r > 1) << above;
  }
}

TEST(PanelStack, WhatAllBracketsAndTheSillShareIsHandedOnAsItIs) {
  Column column;
  column.add_column(6), column.add_sill();
  column.hold(joint(0));
  for (Eigen::Vector3d& p : column.inputs.model.positions) p += 2 * mm * column.axes.out;
  const auto n = static_cast<Eigen::Index>(3 * column.inputs.anchors.size());
  Eigen::MatrixXd shared(n, n);
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) shared(i, j) = i % 3 == j % 3 ? 0.25 * mm * mm : 0;
  column.inputs.model.covariance = shared;
  const DeviationT judged = column.judged();
  for (const auto& panel : judged.panels) {
    EXPECT_NEAR(panel->below->out_of_plane, 2 * mm, 1e-9);
    EXPECT_NEAR(panel->below->u, 0.5 * mm, 1e-9);
    EXPECT_NEAR(panel->lean, 0, 1e-9);
    EXPECT_NEAR(panel->u_lean, 0, 1e-9);
  }
}

TEST(PanelStack, ASillThatIsOutLetsNoPanelPass) {
  Column column;
  column.add_column(3), column.add_sill();
  EXPECT_EQ(column.judged().panels[0]->decided_by, "anchors_in_line") << "nobody says that anything holds it";
  column.hold(joint(0.2 * mm));
  DeviationT judged = column.judged();
  for (const auto& panel : judged.panels) EXPECT_EQ(panel->verdict, ToleranceVerdict::pass) << panel->reason;
  for (const std::size_t sill : {6u, 7u}) column.move(sill, 8 * mm);
  judged = column.judged();
  EXPECT_EQ(judged.panels[0]->verdict, ToleranceVerdict::fail) << judged.panels[0]->reason;
  EXPECT_EQ(judged.panels[0]->decided_by, "corner");
  EXPECT_NEAR(judged.panels[0]->corner->value, 8 * mm, 1e-9);
  // A knee of what carries it is no motion of a stiff panel: the edge is out of its joint at the ends.
  Column bent;
  bent.add_column(3), bent.add_sill();
  bent.hold(joint(0.2 * mm));
  bent.move(6, 8 * mm), bent.move(7, -8 * mm);
  judged = bent.judged();
  EXPECT_EQ(judged.panels[0]->verdict, ToleranceVerdict::fail) << judged.panels[0]->reason;
  EXPECT_EQ(judged.panels[0]->decided_by, "warp") << judged.panels[0]->reason;
}

/// 8 mm out with a rule of 4 mm, drawn: whatever is measured of it and however badly, at most the risk passes.
/// Measured 8 mm out and 0.4 m below the edge: once an assumed sill stood in for it, and the panel passed.
TEST(PanelStack, NoSillIsAssumedWhereOneWasMeasuredNearby) {
  for (const double below : {0.02, 0.4, 0.7}) {
    Column column;
    column.add_column(2), column.add_sill();
    column.hold(joint(0.2 * mm, 0.5 * mm));
    for (const std::size_t sill : {4, 5}) {
      column.inputs.anchors[sill].design = column.inputs.model.positions[sill] += (0.02 - below) * column.axes.up;
      column.move(sill, 8 * mm);
    }
    const DeviationT judged = column.judged();
    EXPECT_EQ(judged.panels[0]->below->by, below < 0.3 ? "sill" : below < 0.6 ? "unknown" : "assumed_sill") << below;
    if (below > 0.6) continue;
    EXPECT_NE(judged.panels[0]->verdict, ToleranceVerdict::pass) << below;
    EXPECT_EQ(judged.panels[0]->below->why.find("nothing is assumed instead") != std::string::npos, below > 0.3);
  }
}

TEST(PanelStack, HardlyAnyPanelOnABadSillPasses) {
  for (const double sigma : {0.3 * mm, 1 * mm, 3 * mm}) {
    test::Normal normal(3);
    int passed = 0;
    for (int draw = 0; draw < 200; ++draw) {
      Column column;
      column.add_column(1), column.add_sill();
      column.hold(joint(0.2 * mm));
      for (Eigen::Vector3d& p : column.inputs.model.positions)
        p += sigma * Eigen::Vector3d(normal(), normal(), normal());
      for (const std::size_t sill : {2u, 3u}) column.move(sill, 4.3 * mm);
      passed += column.judged(sigma).panels[0]->verdict == ToleranceVerdict::pass;
    }
    EXPECT_LE(passed, 10) << sigma;
  }
}

TEST(PanelStack, WhereNobodyKnowsWhatHoldsAnEdgeItIsSaid) {
  const auto reason = [](const DeviationT& judged, std::size_t panel) {
    EXPECT_EQ(judged.panels[panel]->verdict, ToleranceVerdict::undecided);
    EXPECT_EQ(judged.panels[panel]->decided_by, "held_below");
    EXPECT_TRUE(std::isinf(judged.panels[panel]->tau_pass));
    return judged.panels[panel]->reason;
  };
  Column column;
  column.add_column(2);
  column.hold(joint(0.2 * mm));
  DeviationT judged = column.judged();
  EXPECT_EQ(reason(judged, 0).find("no sill was measured below: "), 0u) << judged.panels[0]->reason;
  EXPECT_EQ(reason(judged, 1),
            "its bottom edge is held by panel P0, and how far out the top edge of that is is not known");
  column.hold(joint(0.2 * mm, 0.5 * mm));
  judged = column.judged();
  for (const auto& panel : judged.panels) EXPECT_EQ(panel->verdict, ToleranceVerdict::pass) << panel->reason;
  ASSERT_EQ(judged.warnings.size(), 1u);
  EXPECT_EQ(judged.warnings[0],
            "The sill below P0 was not measured: it is taken to be in place to 0.5 mm (standard "
            "deviation, with that of the joint), which nothing here measures.");
  column.hold(joint(0.2 * mm, 4 * mm));
  judged = column.judged();
  EXPECT_EQ(judged.panels[0]->verdict, ToleranceVerdict::undecided) << "4 mm of 4 mm";
  // One place of a sill, at its end.
  Column end;
  end.add_column(1), end.add_sill();
  end.hold(joint(0, 0.5 * mm));
  end.inputs.model.positions[3].setConstant(nan);
  EXPECT_EQ(reason(end.judged(), 0),
            "its sill was measured on one side of its middle alone, at SP2: measure it on the other side, too");
}

TEST(PanelStack, OfTwoPanelsBelowNoneIsGuessedAndOneThatWasNotMeasuredIsNoSill) {
  Column bond;
  bond.add_panel("A", 0, 0), bond.add_panel("B", kWidth + kJoint, 0), bond.add_panel("C", 0.5 * kWidth, kPitch);
  bond.hold(joint(0, 0.5 * mm));
  DeviationT judged = bond.judged();
  EXPECT_EQ(judged.panels[2]->decided_by, "held_below");
  EXPECT_EQ(judged.panels[2]->reason,
            "more than one panel is below, A, B: which of them holds its bottom edge is not known");
  // The same above A alone, by a third of its width.
  Column part;
  part.add_panel("A", 0, 0), part.add_panel("C", 1.0, kPitch);
  part.hold(joint(0, 0.5 * mm));
  EXPECT_EQ(part.judged().panels[1]->reason,
            "panel A is below 0.50 m of its 1.50 m alone: what else holds its bottom edge is not known");
  // Neither anchor of A was measured; nor is A tied to any.
  for (const bool loose : {false, true}) {
    Column blind;
    blind.add_column(2);
    blind.hold(joint(0, 0.5 * mm));
    for (const std::size_t anchor : {0u, 1u}) blind.inputs.model.positions[anchor].setConstant(nan);
    if (loose) {
      blind.inputs.loose.push_back(blind.inputs.panels[0]), blind.inputs.loose[0].anchors.clear();
      blind.inputs.panels.erase(blind.inputs.panels.begin());
    }
    const DeviationT found = blind.judged();
    ASSERT_EQ(found.panels.size(), 1u);
    EXPECT_EQ(found.panels[0]->decided_by, "held_below") << loose;
    EXPECT_NE(found.panels[0]->reason.find("held by panel P0"), std::string::npos) << found.panels[0]->reason;
  }
}

/// Three of four anchors tell all of a panel, and what the fourth does nobody knows: nor what stands on it.
TEST(PanelStack, WhatStandsOnAPanelWithAnAnchorThatWasNotMeasuredWaitsForIt) {
  Column column;
  column.add_column(3);
  for (const double along : {0.2, kWidth - 0.2})
    column.inputs.panels[0].anchors.push_back(column.add_anchor(along < 1 ? "bl" : "br", column.at(along, 0.1, -0.1)));
  column.hold(joint(0));
  DeviationT judged = column.judged();
  EXPECT_FALSE(judged.panels[0]->below) << "its anchors tell all of it";
  for (const auto& panel : judged.panels) EXPECT_EQ(panel->verdict, ToleranceVerdict::pass) << panel->reason;
  column.inputs.model.positions[7].setConstant(nan);
  judged = column.judged();
  EXPECT_EQ(judged.panels[0]->decided_by, "missing_anchor");
  for (const std::size_t k : {1u, 2u}) {
    EXPECT_EQ(judged.panels[k]->decided_by, "held_below");
    EXPECT_EQ(judged.panels[k]->reason,
              "its bottom edge is held by way of panel P0, of which anchor br was not measured");
  }
}

/// Turned about the vertical, mirrored, and with a second column round the corner: each panel hangs as it did.
TEST(PanelStack, TurnedMirroredAndRoundTheCornerItIsTheSame) {
  const auto column_at = [](const Eigen::Vector3d& out, const Eigen::Vector3d& at, bool mirrored) {
    Column column(out, 3.0, at);
    column.add_column(4), column.add_sill();
    column.hold(joint(0.3 * mm));
    test::Normal normal(5);
    for (std::size_t i = 0; i < column.inputs.anchors.size(); ++i) {
      const Eigen::Vector3d off = 1.5 * mm * Eigen::Vector3d(normal(), normal(), normal());
      // Mirrored: the left one of two has what the right one had, and right is left.
      const std::size_t place = mirrored ? i ^ 1u : i;
      column.inputs.model.positions[place] +=
          (mirrored ? -1 : 1) * off.x() * column.axes.right + off.y() * column.axes.up + off.z() * column.axes.out;
    }
    return column;
  };
  const auto same = [](const PanelDeviationT& a, const PanelDeviationT& b, double sign) {
    EXPECT_EQ(a.verdict, b.verdict) << a.name;
    EXPECT_EQ(a.decided_by, b.decided_by);
    EXPECT_NEAR(a.lean, b.lean, 1e-12);
    EXPECT_NEAR(a.turn, sign * b.turn, 1e-12);
    EXPECT_NEAR(a.u_lean, b.u_lean, 1e-12);
    EXPECT_NEAR(a.below->out_of_plane, b.below->out_of_plane, 1e-12);
    EXPECT_NEAR(a.below->u, b.below->u, 1e-12);
    EXPECT_NEAR(a.warp->value, b.warp->value, 1e-12);
    EXPECT_NEAR(a.corner->value, b.corner->value, 1e-12);
    EXPECT_NEAR(a.pass_probability, b.pass_probability, 0.02);
  };
  Column first = column_at({0, -1, 0}, Eigen::Vector3d::Zero(), false);
  const DeviationT judged = first.judged();
  const double angle = 37 * std::numbers::pi / 180;
  const DeviationT turned = column_at({std::sin(angle), std::cos(angle), 0}, {40, -7, 12}, false).judged();
  const DeviationT mirrored = column_at({0, -1, 0}, Eigen::Vector3d::Zero(), true).judged();
  // Round a corner of 90°, 5 cm from it: no neighbour of the first.
  Column both = first;
  both.inputs.model.covariance = {};
  Column other = column_at({1, 0, 0}, {kWidth + 0.05, 0.05, 0}, false);
  for (AnchorCase anchor : other.inputs.anchors) anchor.id = "x" + anchor.id, both.inputs.anchors.push_back(anchor);
  for (std::size_t i = 0; i < other.inputs.model.ids.size(); ++i)
    both.inputs.model.ids.push_back("x" + other.inputs.model.ids[i]),
        both.inputs.model.positions.push_back(other.inputs.model.positions[i]);
  for (PanelCase panel : other.inputs.panels) {
    for (std::size_t& anchor : panel.anchors) anchor += first.inputs.anchors.size();
    panel.guid += "x", both.inputs.panels.push_back(panel);
  }
  const DeviationT corner = both.judged();
  ASSERT_EQ(corner.panels.size(), 8u);
  for (std::size_t k = 0; k < 4; ++k) {
    same(*judged.panels[k], *turned.panels[k], 1);
    same(*judged.panels[k], *mirrored.panels[k], -1);
    same(*judged.panels[k], *corner.panels[k], 1);
    same(*judged.panels[k], *corner.panels[k + 4], 1);
  }
}

/// The joint between two panels that stand on each other: what both share cancels in it.
TEST(PanelStack, JointsKnowWhatBothPanelsShare) {
  Column column;
  column.add_column(2), column.add_sill();
  column.hold(joint(0));
  const DeviationT judged = column.judged(1 * mm);
  ASSERT_EQ(judged.panels[1]->joints.size(), 1u);
  // Heights at the ends of the joint rest on two brackets each, those of one panel on no other's.
  const double end = 0.5 * kWidth / (0.5 * kWidth - 0.2);
  EXPECT_NEAR(judged.panels[1]->joints[0]->change->u, mm * std::sqrt(2 * 0.5 * (1 + end * end)), 2e-6);
}

TEST(PanelStack, RulesSayWhatHolds) {
  const auto words = [](const std::string& text) {
    try {
      parse_held_below(text);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  const HeldBelowRule rule = parse_held_below("class=IfcPlate: sigma=3mm, play=4mm, sill_sigma=0.002m");
  EXPECT_NEAR(rule.joint.sigma, std::sqrt(9 + 16.0 / 3) * mm, 1e-12);
  EXPECT_NEAR(rule.joint.sill_sigma, 2 * mm, 1e-12);
  EXPECT_NE(words("*: sill_sigma=2mm").find("does not say how well the edge is held"), std::string::npos);
  EXPECT_NE(words("*: sigma=2").find("found 'sigma=2', expected sigma, play or sill_sigma"), std::string::npos);
  EXPECT_NE(words("*: sgima=2mm").find("found 'sgima=2mm'"), std::string::npos);
  EXPECT_NE(words("*: sigma=200mm").find("from 0 to 100 mm"), std::string::npos);
  EXPECT_NE(words("*: sigma=2mm, sigma=3mm").find("expected each name once"), std::string::npos);
  HeldBelow held;
  std::vector<ifc::NotApplied> refused;
  const std::vector<ifc::Property> properties = {{"Pset_StackJoint", "Play", "", 0.003, "IFCLENGTHMEASURE"}};
  ifc::ElementFacts panel;
  EXPECT_FALSE(held.of(panel, refused));
  panel.properties = &properties;
  ASSERT_TRUE(held.of(panel, refused));
  EXPECT_NEAR(held.of(panel, refused)->sigma, 3 * mm / std::sqrt(3), 1e-12);
  held.rules = {parse_held_below("*: sigma=1mm"), parse_held_below("*: sigma=2mm")};
  EXPECT_NEAR(held.of(panel, refused)->sigma, 2 * mm, 1e-12) << "the later rule";
  EXPECT_TRUE(refused.empty());
  held.rules.clear();
  const std::vector<ifc::Property> wrong = {{"Pset_StackJoint", "Sigma", "4.", 4, "IFCREAL"},
                                            {"Pset_StackJoint", "Plaz", "", 0.003, "IFCLENGTHMEASURE"}};
  panel.properties = &wrong;
  EXPECT_FALSE(held.of(panel, refused));
  ASSERT_EQ(refused.size(), 3u);
  EXPECT_EQ(refused[0].asked, "Pset_StackJoint.Sigma '4.'");
  EXPECT_EQ(refused[1].reason, "expected Sigma, Play or SillSigma");
}

}  // namespace test_panel_stack
}  // namespace plumbline::judgement

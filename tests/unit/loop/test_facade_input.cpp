// What the planner gets from a judgement: directions of each facade, and what it must not plan.
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "build/loop/facade_input.hpp"
#include "build/loop/panel_limits.hpp"
#include "loop/fit/plan_settings.hpp"
#include "loop/gate/gate.hpp"

namespace plumbline::loop {
namespace test_facade_input {

struct Input {
  DeviationT deviation;
  PointsT model;
  DesignT design;
};

std::unique_ptr<FacadeFrameT> facing(const Eigen::Vector3d& out, const std::string& name) {
  auto frame = std::make_unique<FacadeFrameT>();
  const Eigen::Matrix3d axes = facade_axes(out);
  frame->right = axes.col(0), frame->up = axes.col(1), frame->out = axes.col(2);
  frame->confirmed = true, frame->facade = name;
  return frame;
}

std::unique_ptr<JudgedLengthT> within(double tolerance) {
  auto length = std::make_unique<JudgedLengthT>();
  length->tolerance = tolerance;
  return length;
}

/// One panel of 2 x 4 m on four anchors at `place`, its anchors 5 mm too far out.
void add_panel(Input& input, const std::string& name, const Eigen::Vector3d& place, const Eigen::Vector3d& out) {
  const Eigen::Matrix3d axes = facade_axes(out);
  auto panel = std::make_unique<PanelDeviationT>();
  panel->guid = panel->name = name, panel->floor = 1, panel->facade = facing(out, name);
  panel->sideways = within(0.005), panel->vertical = within(0.005), panel->out_of_plane = within(0.005);
  panel->shift.setZero(), panel->rotation.setZero();
  const char* corners[] = {"bottom_left", "bottom_right", "top_left", "top_right"};
  for (int k = 0; k < 4; ++k) {
    const Eigen::Vector3d at = place + (k % 2) * 2.0 * axes.col(0) + (k / 2) * 2.0 * axes.col(1);
    auto corner = std::make_unique<PanelCornerT>();
    corner->name = corners[k], corner->design = at, corner->movement.setZero();
    panel->corners.push_back(std::move(corner));
    auto anchor = std::make_unique<AnchorDeviationT>();
    anchor->id = name + std::to_string(k), anchor->class_ = "IfcPlate", anchor->floor = 1;
    anchor->design = at, anchor->deviation = 0.005 * out, anchor->as_built = anchor->design + anchor->deviation;
    anchor->target_offset.setZero(), anchor->facade = facing(out, name);
    auto point = std::make_unique<PointT>();
    point->id = anchor->id, point->position = anchor->as_built, point->sigma.setConstant(0.0003);
    input.model.points.push_back(std::move(point));
    auto fixing = std::make_unique<PanelFixingT>();
    fixing->anchor = anchor->id;
    panel->fixings.push_back(std::move(fixing));
    input.deviation.anchors.push_back(std::move(anchor));
  }
  input.deviation.panels.push_back(std::move(panel));
}

Input two_facades() {
  Input input;
  add_panel(input, "South", {0, 0, 0}, {0, -1, 0});
  add_panel(input, "East", {20, 5, 0}, {1, 0, 0});
  const std::size_t n = 3 * input.model.points.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) input.model.covariance.push_back(i == j ? 0.0003 * 0.0003 : 0.0);
  return input;
}

std::string fault_of(const Input& input, const FacadeRules& rules) {
  try {
    facade_of(input.deviation, input.model, input.design, nullptr, rules);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return {};
}

TEST(FacadeInput, EachFacadeIsSetAlongItsOwnDirections) {
  const Input input = two_facades();
  const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, {});
  EXPECT_TRUE(faults_of(made.facade).empty());
  EXPECT_TRUE(made.notes.empty());
  const Fit fit = plan_settings(made.facade, {1, 1, 1, 1e-9});
  ASSERT_EQ(fit.settings.size(), 8u);
  for (const Eigen::Vector3d& setting : fit.settings) EXPECT_LT((setting - Eigen::Vector3d(0, 0, -0.005)).norm(), 1e-6);
}

/// The judgement failed it by its warp, the plan knew the middle of the edge alone and released it.
TEST(FacadeInput, APanelOnATwistedEdgeWaits) {
  for (const auto verdict : {ToleranceVerdict::pass, ToleranceVerdict::undecided, ToleranceVerdict::fail}) {
    Input input = two_facades();
    PanelDeviationT& south = *input.deviation.panels[0];
    south.warp = within(0.005), south.warp->value = -0.008, south.warp->verdict = verdict;
    const auto open = [&] {
      return facade_of(input.deviation, input.model, input.design, nullptr, {}).facade.panels[0].open;
    };
    EXPECT_EQ(open(), "") << "nothing is said to hold its edge";
    south.below = std::make_unique<PanelSupportT>();
    south.below->by = "unknown", south.below->place.setConstant(std::numeric_limits<double>::quiet_NaN());
    EXPECT_EQ(open().find("the ends of what holds its bottom edge are off by 8.0 mm") != std::string::npos,
              verdict != ToleranceVerdict::pass);
  }
}

TEST(FacadeInput, WhatFacesNobodyKnowsWhereIsSaidAndWaits) {
  Input input = two_facades();
  input.deviation.anchors[5]->facade->confirmed = false, input.deviation.anchors[5]->facade->note = "a guess";
  const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, {});
  ASSERT_EQ(made.notes.size(), 1u);
  EXPECT_NE(made.notes[0].find("anchor East1: which way it faces is not confirmed (a guess)"), std::string::npos);
  EXPECT_FALSE(made.facade.brackets[5].measured());
  for (auto& anchor : input.deviation.anchors) anchor->facade->confirmed = false;
  EXPECT_NE(fault_of(input, {}).find("nobody can be told to move one to the right"), std::string::npos);
  for (auto& panel : input.deviation.panels) panel->facade->confirmed = false;
  FacadeRules rules;
  rules.normal = {0, -1, 0};
  EXPECT_EQ(fault_of(input, rules), "");
}

/// "5 mm out" was into the building on the facade behind.
TEST(FacadeInput, ADirectionAgainstOneThatIsConfirmedIsRefused) {
  FacadeRules rules;
  rules.normal = {0, -1, 0};
  const std::string east = fault_of(two_facades(), rules);
  EXPECT_EQ(east.find("facade_normal says that all of it faces (0.00, -1.00, 0.00), and East0, East1, East2, East3"),
            0u)
      << east;
  EXPECT_NE(east.find("face (1.00, 0.00, 0.00) (facade East, confirmed): they would be set the wrong way"),
            std::string::npos)
      << east;
  Input input;
  add_panel(input, "South", {0, 0, 0}, {0, -1, 0});
  for (std::size_t i = 0; i < 12; ++i)
    for (std::size_t j = 0; j <= i; ++j) input.model.covariance.push_back(i == j ? 0.0003 * 0.0003 : 0.0);
  rules.normal = {0, 1, 0};
  EXPECT_NE(fault_of(input, rules), "");
  rules.normal = {0.3, -1, 0};
  EXPECT_EQ(fault_of(input, rules), "");
}

/// Nobody measured its anchors, so the judgement does not have it; the one above cannot be hung first all the same.
TEST(FacadeInput, APanelWaitsForTheOneBelowAlsoWhereThatOneIsNotPlanned) {
  Input input = two_facades();
  const auto add_element = [&](const std::string& name, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    auto element = std::make_unique<DesignElementT>();
    element->guid = "guid-" + name, element->name = name, element->is_panel = true;
    element->position.setZero(), element->box_low = low, element->box_high = high;
    input.design.elements.push_back(std::move(element));
  };
  add_element("Low", {0.1, -0.1, -2.0}, {1.9, 0.1, -0.02});
  add_element("Beside", {-2.1, -0.1, 0.0}, {-0.02, 0.1, 2.0});
  add_element("Behind", {0.1, 1.0, -2.0}, {1.9, 1.2, -0.02});
  FacadeRules rules;
  const auto before = [&](const std::string& id) -> std::vector<std::string> {
    const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, rules);
    EXPECT_TRUE(faults_of(made.facade).empty());
    for (const Panel& panel : made.facade.panels)
      if (panel.id == id) return panel.depends_on;
    return {"none"};
  };
  EXPECT_EQ(before("South"), std::vector<std::string>{"Low"});
  EXPECT_TRUE(before("East").empty());
  const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, rules);
  EXPECT_TRUE(std::any_of(made.notes.begin(), made.notes.end(), [](const std::string& note) {
    return note.find("panel Low is not planned and is below South") != std::string::npos;
  }));
  for (const char* standing : {"Low", "*"}) {
    rules.standing = {standing};
    EXPECT_TRUE(before("South").empty()) << standing;
  }
  // What is under one that hangs is not next.
  add_element("Lowest", {0.1, -0.1, -4.0}, {1.9, 0.1, -2.02});
  rules.standing = {"Low"};
  EXPECT_TRUE(before("South").empty());
  rules.standing.clear();
  EXPECT_EQ(before("South"), std::vector<std::string>{"Low"});
  rules.standing = {"Lwo"};
  EXPECT_NE(fault_of(input, rules).find("'standing' names 'Lwo', which is no panel of the design"), std::string::npos);
}

/// Rows with windows between have no joint that would say which of them is first.
TEST(FacadeInput, APanelWaitsForTheNextOneBelowAlsoAcrossARibbonOfWindows) {
  Input input;
  for (const auto& [name, height] : {std::pair("Low", 0.0), {"Middle", 4.1}, {"High", 8.2}})
    add_panel(input, name, {0, 0, height}, {0, -1, 0});
  add_panel(input, "Aside", {2.02, 0, 4.1}, {0, -1, 0});
  const std::size_t n = 3 * input.model.points.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) input.model.covariance.push_back(i == j ? 0.0003 * 0.0003 : 0.0);
  FacadeRules rules;
  const auto before = [&](const std::string& id) {
    const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, rules);
    EXPECT_TRUE(faults_of(made.facade).empty());
    return std::find_if(made.facade.panels.begin(), made.facade.panels.end(),
                        [&](const Panel& p) { return p.id == id; })
        ->depends_on;
  };
  EXPECT_EQ(before("Middle"), std::vector<std::string>{"Low"});
  EXPECT_EQ(before("High"), std::vector<std::string>{"Middle"}) << "what is below that waits by itself";
  EXPECT_TRUE(before("Low").empty());
  EXPECT_TRUE(before("Aside").empty());
  rules.after["Low"] = {"Middle"}, rules.after["Middle"] = {"High"};
  EXPECT_EQ(before("Low"), std::vector<std::string>{"Middle"}) << "from the top downward, as it is said";
  EXPECT_TRUE(before("High").empty());
}

/// A GlobalId tells nobody which panel to hang.
TEST(FacadeInput, PanelsOfOneNameAreToldApartByTagOrAnchor) {
  Input input = two_facades();
  for (auto& panel : input.deviation.panels) panel->name = "Panel";
  const auto ids = [&](const LoopStateT* state) {
    const FacadeInput made = facade_of(input.deviation, input.model, input.design, state, {});
    return std::vector<std::string>{made.facade.panels.at(0).id, made.facade.panels.at(1).id};
  };
  using Ids = std::vector<std::string>;
  EXPECT_EQ(ids(nullptr), (Ids{"Panel at South0", "Panel at East0"}));
  for (const auto& [guid, tag] : {std::pair("South", "P-17"), {"East", "P-18"}}) {
    auto element = std::make_unique<DesignElementT>();
    element->guid = guid, element->name = "Panel", element->tag = tag, element->is_panel = true;
    element->position.setZero(), element->box_low.setConstant(std::nan("")), element->box_high = element->box_low;
    input.design.elements.push_back(std::move(element));
  }
  EXPECT_EQ(ids(nullptr), (Ids{"P-17", "P-18"}));
  input.design.elements[1]->tag = "P-17";
  EXPECT_EQ(ids(nullptr), (Ids{"Panel at South0", "Panel at East0"})) << "a tag of two says nothing";
  // What a site has begun with it keeps.
  LoopStateT state;
  auto item = std::make_unique<LoopItemT>();
  item->id = item->guid = "South", item->kind = "panel", item->expected.setZero();
  state.items.push_back(std::move(item));
  EXPECT_EQ(ids(&state), (Ids{"South", "Panel at East0"}));
}

TEST(FacadeInput, NamesThatDifferInCaseAloneAreTold) {
  Input input = two_facades();
  EXPECT_TRUE(facade_of(input.deviation, input.model, input.design, nullptr, {}).notes.empty());
  input.deviation.anchors[4]->id = input.model.points[4]->id = input.deviation.panels[1]->fixings[0]->anchor = "SOUTH0";
  const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, {});
  ASSERT_EQ(made.notes.size(), 1u);
  EXPECT_EQ(made.notes[0].find("brackets South0 and SOUTH0 have one name but for case"), 0u) << made.notes[0];
}

/// The judgement says what holds bottom edges, and where; the planner looks for nothing of its own.
TEST(FacadeInput, WhatHoldsABottomEdgeIsThatOfTheJudgement) {
  Input input = two_facades();
  add_panel(input, "Above", {0, 0, 2.02}, {0, -1, 0});
  input.model.covariance.clear();
  for (std::size_t i = 0; i < 36; ++i)
    for (std::size_t j = 0; j <= i; ++j) input.model.covariance.push_back(i == j ? 0.0003 * 0.0003 : 0.0);
  const auto support = [](const std::string& by) {
    auto below = std::make_unique<PanelSupportT>();
    below->by = by, below->place = Eigen::Vector3d(1, 0, 2.01), below->sigma = 0.0004, below->sill_sigma = 0.0003;
    return below;
  };
  auto& panels = input.deviation.panels;
  for (std::size_t p : {0u, 2u}) panels[p]->fixings.erase(panels[p]->fixings.begin(), panels[p]->fixings.begin() + 2);
  panels[0]->below = support("sill"), panels[0]->below->sills = {"South0", "South1"};
  panels[0]->below->weights = {0.5, 0.5}, panels[0]->below->place.z() = 0;
  panels[2]->below = support("panel"), panels[2]->below->panel = panels[2]->below->name = "South";
  FacadeRules rules;
  rules.brackets = {parse_bracket_rule("name~[2-3]$|^East|^Above: out=20mm"),
                    parse_bracket_rule("name~^South[01]$: out=20mm")};  // of the sill alone: it does no harm
  FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, rules);
  const std::vector<Panel>& planned = made.facade.panels;
  ASSERT_TRUE(planned[0].below && planned[2].below);
  EXPECT_EQ(planned[0].below->panel, -1);
  EXPECT_EQ(planned[0].below->sills, (std::vector<std::pair<std::size_t, double>>{{0, 0.5}, {1, 0.5}}));
  EXPECT_TRUE(made.facade.brackets[0].is_sill && made.facade.brackets[1].is_sill);
  EXPECT_FALSE(made.facade.brackets[2].is_sill);
  EXPECT_EQ(planned[2].below->panel, 0);
  EXPECT_EQ(planned[2].below->sigma, 0.0004);
  EXPECT_EQ(planned[2].below->sill_sigma, 0.0003);
  EXPECT_EQ(planned[2].depends_on, std::vector<std::string>{"South"});
  EXPECT_FALSE(planned[1].below);
  const Fit fit = plan_settings(made.facade);
  for (const PanelGate& gate : judge_plan(made.facade, fit))
    EXPECT_NE(gate.obstacle, Obstacle::not_told) << gate.reason;
  panels[0]->below = support("unknown"), panels[0]->below->why = "no sill was measured below";
  made = facade_of(input.deviation, input.model, input.design, nullptr, {});
  EXPECT_EQ(made.facade.panels[0].below_unknown, "no sill was measured below");
  EXPECT_FALSE(made.facade.panels[0].below);
}

/// '4 mm' as text is no tolerance: nobody may hang a panel by the 5 mm that are assumed instead.
TEST(FacadeInput, WhatWasAskedOfPanelsAndCouldNotBeJudgedHoldsThem) {
  Input input = two_facades();
  for (auto& panel : input.deviation.panels) {
    for (const char* axis : {"out_of_plane", "vertical"}) {
      panel->limits.push_back(std::make_unique<PanelLimitT>());
      PanelLimitT& limit = *panel->limits.back();
      limit.axis = axis, limit.above = limit.below = 0.005;
      limit.source = panel->name == "South" ? "default" : "class=IfcPlate: out_of_plane=5mm, vertical=5mm";
    }
  }
  auto request = std::make_unique<JudgementRequestT>();
  request->asked = "Pset_Tolerance.OrthogonalTolerance '4 mm'", request->not_judged = "it is text";
  input.deviation.requests.push_back(std::move(request));
  const auto gates = [&] {
    const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, {});
    return judge_plan(made.facade, plan_settings(made.facade));
  };
  EXPECT_EQ(gates()[0].verdict, GateVerdict::go) << "of anchors: brackets are set to what panels need";
  input.deviation.requests[0]->panels = 1;
  EXPECT_EQ(gates()[0].verdict, GateVerdict::hold);
  EXPECT_EQ(gates()[0].reason.find("not judged: Pset_Tolerance.OrthogonalTolerance '4 mm': it is text; a rule"), 0u)
      << gates()[0].reason;
  EXPECT_EQ(gates()[1].verdict, GateVerdict::go) << "a rule says all that it is held against";
  input.deviation.requests[0]->asked = "Pset_tolerance.OrthogonalTolerance '4 mm'";
  EXPECT_EQ(gates()[0].verdict, GateVerdict::hold) << "however the set is written";
  input.deviation.requests[0]->not_judged = "nothing here measures it";
  EXPECT_EQ(gates()[0].verdict, GateVerdict::go) << "its flatness is not how it hangs";
}

/// The value of a judged length is held against one side of its tolerance; what is planned may come to lie on the
/// other.
TEST(FacadeInput, ATolerancesTwoSidesAndTheStricterOfTwoPanelsCount) {
  Input input;
  add_panel(input, "A", {0, 0, 0}, {0, -1, 0});
  add_panel(input, "B", {2.02, 0, 0}, {0, -1, 0});
  for (std::size_t i = 0; i < 3 * input.model.points.size(); ++i)
    for (std::size_t j = 0; j <= i; ++j) input.model.covariance.push_back(i == j ? 1e-7 : 0.0);
  const auto limit = [&](std::size_t panel, const char* axis, double above, double below) {
    auto made = std::make_unique<PanelLimitT>();
    made->axis = axis, made->above = above, made->below = below;
    input.deviation.panels[panel]->limits.push_back(std::move(made));
  };
  limit(0, "horizontal", 0.004, 0.004), limit(0, "vertical", 0.005, 0.002), limit(0, "out_of_plane", 0, 0.006);
  limit(0, "joint", 0.010, 0.004), limit(1, "joint", 0.003, 0.008), limit(1, "horizontal", 0.007, 0.007);
  auto joint = std::make_unique<PanelJointT>();
  joint->panel = joint->name = "B", joint->side = "right", joint->design = 0.020, joint->change = within(0.010);
  input.deviation.panels[0]->joints.push_back(std::move(joint));
  const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, {});
  ASSERT_TRUE(faults_of(made.facade).empty()) << faults_of(made.facade)[0];
  const Fit fit = plan_settings(made.facade);
  const double low[] = {-0.004, -0.002, -0.006}, high[] = {0.004, 0.005, 0};
  for (const JudgedValue& value : fit.judged)
    if (value.quantity == Quantity::corner && value.panel == 0) {
      EXPECT_EQ(value.low, low[value.direction]) << value.direction;
      EXPECT_EQ(value.high, high[value.direction]) << value.direction;
    }
  EXPECT_EQ(made.facade.panels[1].limits.out, 0.007) << "that along the facade where none is said";
  ASSERT_EQ(made.facade.joints.size(), 1u);
  EXPECT_NEAR(made.facade.joints[0].most, 0.023, 1e-12);
  EXPECT_NEAR(made.facade.joints[0].least, 0.016, 1e-12);
}

/// Of a tower that is measured floor by floor the rest is work, too.
TEST(FacadeInput, PanelsThatNobodyMeasuredAreToldWithWhatToDo) {
  Input input = two_facades();
  const auto add_element = [&](const std::string& name, const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    auto element = std::make_unique<DesignElementT>();
    element->guid = "guid-" + name, element->name = name, element->is_panel = true, element->storey_guid = "storey-2";
    element->position.setZero(), element->box_low = low, element->box_high = high;
    input.design.elements.push_back(std::move(element));
  };
  for (int i = 1; i < 3; ++i) {
    auto storey = std::make_unique<DesignStoreyT>();
    storey->guid = "storey-" + std::to_string(i), storey->floor = i;
    input.design.storeys.push_back(std::move(storey));
  }
  add_element("High", {0.1, -0.1, 30.0}, {1.9, 0.1, 32.0}), add_element("Bare", {50, 50, 30}, {52, 50.1, 32});
  auto anchor = std::make_unique<DesignElementT>();
  anchor->guid = anchor->name = "HighAnchor", anchor->is_anchor = true, anchor->position = {0.1, 0, 30.1};
  input.design.elements.push_back(std::move(anchor));
  FacadeRules rules;
  FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, rules);
  ASSERT_EQ(made.unplanned.size(), 2u);
  EXPECT_EQ(made.unplanned[0].id, "Bare");
  EXPECT_EQ(made.unplanned[0].why.find("no anchor is there"), 0u) << made.unplanned[0].why;
  EXPECT_EQ(made.unplanned[1].why, "not one anchor there was measured: measure them, then run again");
  EXPECT_EQ(made.unplanned[1].floor, 2);
  // Another campaign says nothing of what hangs by a round before.
  LoopStateT state;
  auto item = std::make_unique<LoopItemT>();
  item->id = "High", item->kind = "panel", item->guid = "guid-High", item->status = ItemStatus::verified;
  item->setting.setZero(), item->pending.setZero(), item->expected.setZero();
  state.items.push_back(std::move(item));
  made = facade_of(input.deviation, input.model, input.design, &state, rules);
  ASSERT_EQ(made.unplanned.size(), 1u);
  EXPECT_EQ(made.unplanned[0].id, "Bare");
  rules.standing = {"*"};
  EXPECT_TRUE(facade_of(input.deviation, input.model, input.design, nullptr, rules).unplanned.empty());
}

/// Needed and not planned is something else than not needed.
/// Once a panel whose anchors failed 3 mm in space was GO with 3.3 mm, and a length that is not asked along an axis was
/// a tolerance of nan mm, which nobody had given.
TEST(FacadeInput, LengthsInThePlaneAndInSpaceHoldItsCornersToo) {
  PanelDeviationT judged;
  judged.sideways = within(NAN), judged.vertical = within(0.004), judged.out_of_plane = within(NAN);
  const auto ask = [&](const char* axis, double above, double below) {
    auto limit = std::make_unique<PanelLimitT>();
    limit->axis = axis, limit->above = above, limit->below = below;
    judged.limits.push_back(std::move(limit));
  };
  EXPECT_EQ(limits_of(judged).right, 1) << "nothing is asked";
  EXPECT_EQ(limits_of(judged).back(2), 1);
  EXPECT_EQ(limits_of(judged).up, 0.004);
  ask("vertical", 0.005, 0.001), ask("in_plane", 0.003, 0.003);
  CornerLimits limits = limits_of(judged);
  EXPECT_NEAR(limits.right, 0.003 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(limits.left, 0.003 / std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(limits.up, 0.003 / std::sqrt(2.0), 1e-12);
  EXPECT_EQ(limits.down, 0.001);
  EXPECT_EQ(limits.out, 1);
  ask("space", 0.003, 0.003);
  limits = limits_of(judged);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(limits[k], 0.003 / std::sqrt(3.0), 1e-12) << k;
  EXPECT_NEAR(limits.back(2), 0.003 / std::sqrt(3.0), 1e-12);
  EXPECT_EQ(limits.back(1), 0.001);
}

TEST(FacadeInput, ABracketAtAPanelThatIsNotPlannedIsNoBracketWithoutPanel) {
  Input input = two_facades();
  input.deviation.panels.pop_back();  // East: nobody measured it, or two panels are at its place
  FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, {});
  EXPECT_FALSE(made.facade.brackets[4].holds_unplanned) << "the design has no panel there";
  auto element = std::make_unique<DesignElementT>();
  element->guid = element->name = "East", element->is_panel = true;
  element->position.setZero(), element->box_low = {19.9, 4.9, -0.1}, element->box_high = {20.1, 7.1, 2.1};
  input.design.elements.push_back(std::move(element));
  made = facade_of(input.deviation, input.model, input.design, nullptr, {});
  for (std::size_t b = 0; b < 8; ++b) EXPECT_EQ(made.facade.brackets[b].holds_unplanned, b >= 4) << b;
  const Fit fit = plan_settings(made.facade);
  EXPECT_EQ(std::count(fit.notes.begin(), fit.notes.end(),
                       "bracket East0 holds a panel that is not planned: it has no setting before that is"),
            1);
  // Likewise where which way it faces is not confirmed.
  input = two_facades();
  input.deviation.panels[1]->facade->confirmed = false;
  made = facade_of(input.deviation, input.model, input.design, nullptr, {});
  for (std::size_t b = 0; b < 8; ++b) EXPECT_EQ(made.facade.brackets[b].holds_unplanned, b >= 4) << b;
}

TEST(FacadeInput, BracketsOfUnknownTypeAndUnknownPanelsAreNamed) {
  const Input input = two_facades();
  FacadeRules rules;
  rules.brackets = {parse_bracket_rule("name~^South: right=20mm, up=15mm, out=25mm")};
  EXPECT_NE(fault_of(input, rules).find("no rule of 'brackets' selects East0 (IfcPlate)"), std::string::npos)
      << fault_of(input, rules);
  rules.brackets.clear(), rules.after["South"] = {"West"};
  EXPECT_EQ(fault_of(input, rules), "'after' names panel 'West', which is none of the 2 panels with measured anchors");
  rules.after = {{"South", {"East"}}};
  const FacadeInput ordered = facade_of(input.deviation, input.model, input.design, nullptr, rules);
  for (const Panel& panel : ordered.facade.panels)
    EXPECT_EQ(panel.depends_on, panel.id == "South" ? std::vector<std::string>{"East"} : std::vector<std::string>{});
  rules.after = {{"South", {"East"}}, {"East", {"South"}}};
  const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, rules);
  ASSERT_EQ(faults_of(made.facade).size(), 1u);
  EXPECT_NE(faults_of(made.facade)[0].find("South needs East needs South"), std::string::npos);
}

/// What a round before has seen hang holds its brackets, and what it has set is not set again.
TEST(FacadeInput, TheStateOfTheRoundBeforeHolds) {
  const Input input = two_facades();
  LoopStateT state;
  const auto add = [&](const char* kind, const char* id, ItemStatus status) {
    auto item = std::make_unique<LoopItemT>();
    item->kind = kind, item->id = id, item->status = status;
    state.items.push_back(std::move(item));
  };
  add("panel", "East", ItemStatus::verified), add("bracket", "South2", ItemStatus::executed);
  add("bracket", "South3", ItemStatus::planned);
  const FacadeInput made = facade_of(input.deviation, input.model, input.design, &state, {});
  for (const Panel& panel : made.facade.panels) EXPECT_EQ(panel.installed, panel.id == "East") << panel.id;
  for (const Bracket& bracket : made.facade.brackets)
    EXPECT_EQ(bracket.fixed, bracket.id == "South2" || bracket.id.rfind("East", 0) == 0) << bracket.id;
  for (const Bracket& bracket : facade_of(input.deviation, input.model, input.design, nullptr, {}).facade.brackets)
    EXPECT_FALSE(bracket.fixed) << bracket.id;
}

/// Each bound of a place below: under it, over half of the narrower one's width, and in the same plane.
TEST(FacadeInput, WhatIsBelowIsUnderThePanelAndBeneathItsWidth) {
  const auto waits = [](const Eigen::Vector3d& low, const Eigen::Vector3d& high) {
    Input input = two_facades();
    auto element = std::make_unique<DesignElementT>();
    element->guid = "guid", element->name = "Low", element->is_panel = true;
    element->position.setZero(), element->box_low = low, element->box_high = high;
    input.design.elements.push_back(std::move(element));
    const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, {});
    const auto& panels = made.facade.panels;  // South stands from x 0 to 2 at y 0, from z 0 on
    const auto south = std::find_if(panels.begin(), panels.end(), [](const Panel& p) { return p.id == "South"; });
    return south->depends_on == std::vector<std::string>{"Low"};
  };
  EXPECT_TRUE(waits({0, -0.1, -2}, {2, 0.1, -0.19})) << "a joint of 190 mm";
  EXPECT_TRUE(waits({0, -0.1, -6}, {2, 0.1, -2.1})) << "windows between, and no joint";
  EXPECT_TRUE(waits({0, -0.1, -2}, {2, 0.1, 0.019})) << "they overlap by 19 mm";
  EXPECT_FALSE(waits({0, -0.1, -2}, {2, 0.1, 0.021})) << "it stands in its way, not below";
  EXPECT_TRUE(waits({0.98, -0.1, -2}, {4, 0.1, -0.02})) << "over just more than half of the width";
  EXPECT_FALSE(waits({1.02, -0.1, -2}, {4, 0.1, -0.02})) << "over just less than half";
  EXPECT_TRUE(waits({1.5, -0.1, -2}, {1.9, 0.1, -0.02})) << "a narrow one under it";
  EXPECT_FALSE(waits({1.9, -0.1, -2}, {2.3, 0.1, -0.02})) << "a narrow one under its edge";
}

TEST(FacadeInput, APointThatWasJudgedAndIsNotInTheModelIsNamed) {
  Input input = two_facades();
  input.model.points[2]->id = "another";
  EXPECT_NE(fault_of(input, {}).find("anchor South2 was judged, but is no point of 'model'"), std::string::npos);
  input = two_facades();
  input.model.covariance.clear();
  EXPECT_NE(fault_of(input, {}).find("the model has no covariance"), std::string::npos);
}

/// Two panels of 2 x 2 m side by side, 20 mm apart, the second 0.5 m higher; a third above the first: the edges of a
/// joint are where both panels are.
TEST(FacadeInput, EdgesOfAJointReachAsFarAsBothPanels) {
  Input input;
  add_panel(input, "A", {0, 0, 0}, {0, -1, 0});
  add_panel(input, "B", {2.02, 0, 0.5}, {0, -1, 0});
  add_panel(input, "C", {-0.3, 0, 2.03}, {0, -1, 0});
  const auto joint = [&](const char* to, const char* side, double width, double tolerance) {
    auto j = std::make_unique<PanelJointT>();
    j->panel = j->name = to, j->side = side, j->design = width, j->change = within(tolerance);
    input.deviation.panels[0]->joints.push_back(std::move(j));
  };
  joint("B", "right", 0.020, 0.004), joint("C", "above", 0.030, 0.006);
  const std::size_t n = 3 * input.model.points.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) input.model.covariance.push_back(i == j ? 1e-7 : 0.0);
  const FacadeInput made = facade_of(input.deviation, input.model, input.design, nullptr, {});
  ASSERT_EQ(made.facade.joints.size(), 2u);
  const auto expect = [](const Eigen::Vector3d& found, double x, double z, const char* what) {
    EXPECT_LT((found - Eigen::Vector3d(x, 0, z)).norm(), 1e-12) << what << ": " << found.transpose();
  };
  const Joint &beside = made.facade.joints[0], &above = made.facade.joints[1];
  expect(beside.on_a[0], 2, 0.5, "A's right edge, from B's bottom"), expect(beside.on_a[1], 2, 2, "to its own top");
  expect(beside.on_b[0], 2.02, 0.5, "B's left edge"), expect(beside.on_b[1], 2.02, 2, "to A's top");
  expect(above.on_a[0], 0, 2, "A's top, from its left"), expect(above.on_a[1], 1.7, 2, "to C's right");
  expect(above.on_b[0], 0, 2.03, "C's bottom"), expect(above.on_b[1], 1.7, 2.03, "to its right");
  EXPECT_EQ(beside.across, Eigen::Vector3d::UnitX());
  EXPECT_EQ(above.across, Eigen::Vector3d::UnitZ());
  EXPECT_EQ(beside.nominal, 0.020);
  EXPECT_EQ(above.nominal, 0.030);
  EXPECT_DOUBLE_EQ(beside.least, 0.016);
  EXPECT_DOUBLE_EQ(beside.most, 0.024);
  EXPECT_DOUBLE_EQ(above.least, 0.024);
  EXPECT_DOUBLE_EQ(above.most, 0.036);
  EXPECT_EQ(beside.step_most, 0.004) << "as its width, if nothing is said";
  FacadeRules rules;
  rules.step_tolerance = 0.0015;
  EXPECT_EQ(facade_of(input.deviation, input.model, input.design, nullptr, rules).facade.joints[0].step_most, 0.0015);
  EXPECT_EQ(beside.side_of_a, Side::right);
  EXPECT_EQ(beside.side_of_b, Side::left);
  EXPECT_EQ(above.side_of_a, Side::top);
  EXPECT_EQ(above.side_of_b, Side::bottom);
}

/// Brackets were planned with another range than was said of them.
TEST(FacadeInput, ARuleOfBracketsOrHooksThatHoldsNowhereIsRefused) {
  const Input input = two_facades();
  const auto fault = [&](const std::vector<std::string>& brackets, const std::vector<std::string>& hooks) {
    FacadeRules rules;
    for (const std::string& text : brackets) rules.brackets.push_back(parse_bracket_rule(text));
    for (const std::string& text : hooks) rules.hooks.push_back(parse_hook_rule(text));
    return fault_of(input, rules);
  };
  const std::string wide = "*: right=20mm, up=15mm, out=25mm", narrow = "name~^South: out=5mm";
  EXPECT_EQ(fault({wide, narrow}, {}), "");
  EXPECT_EQ(fault({narrow, wide}, {}), "'brackets': rule '" + narrow + "': it holds nowhere: '" + wide +
                                           "' stands after it and selects its anchors and others; put the narrower "
                                           "rule last, or take it out");
  EXPECT_EQ(
      fault({}, {"name=South0: slides", "*: fixed"}).find("'hooks': rule 'name=South0: slides': it holds nowhere"), 0u);
  EXPECT_EQ(fault({wide, "name=nobody: out=5mm"}, {}),
            "'brackets': rule 'name=nobody: out=5mm': it selects no bracket");
}

}  // namespace test_facade_input
}  // namespace plumbline::loop

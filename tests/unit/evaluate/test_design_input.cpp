// From a design, its matches and its plates to what is judged: which way panels face when the plate table says
// otherwise, and the command that is printed for it.
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "build/evaluate/design_input.hpp"
#include "building/ifc/facade_artifact.hpp"
#include "building/judgement/tolerance_classes.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_design_input {

using test::mm;

/// Two floors of three anchors on a facade to the south, two panels between them; the panels' side is confirmed.
struct Site {
  DesignT design;
  ElementMatchesT matches;
  PlatesT plates;
  PointSet model;
  std::string prefix;

  /// `of_plates`: direction in which the plates look; zero: the table gives none.
  Site(const Eigen::Vector3d& of_plates, const std::string& names = "S-") : prefix(names) {
    design.file_name = "d.ifc";
    for (int floor = 1; floor <= 2; ++floor)
      for (int column = 0; column < 3; ++column) {
        DesignElementT& e = add(names + std::to_string(floor) + std::to_string(column), "IfcMechanicalFastener",
                                {2.0 * column, 0, 3.0 * floor});
        e.is_anchor = true;
        auto match = std::make_unique<ElementMatchT>();
        match->anchor = e.name, match->guid = e.guid, match->position = e.position, match->target_offset.setZero();
        matches.matches.push_back(std::move(match));
        auto plate = std::make_unique<PlateT>();
        plate->anchor = e.name, plate->floor = floor, plate->column = column + 1, plate->role = "check";
        plate->nominal_rotation = of_plates.norm() > 0
                                      ? Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), of_plates)
                                      : Eigen::Quaterniond::Identity();
        plates.plates.push_back(std::move(plate));
        model.ids.push_back(e.name), model.positions.push_back(e.position);
      }
    for (int column = 0; column < 2; ++column) {
      DesignElementT& e = add("P" + names + std::to_string(column), "IfcPlate", {2.0 * column, -0.1, 3});
      e.is_panel = true, e.box_low = {0.01, -0.02, 0}, e.box_high = {1.99, 0.02, 3};
      for (const int k : {0, 1, 3, 4}) e.anchor_guids.push_back(design.elements[column + k]->guid);
    }
    model.covariance = test::isotropic(model.ids.size(), 0.3 * mm);
  }

  DesignElementT& add(const std::string& name, const std::string& ifc_class, const Eigen::Vector3d& place) {
    auto e = std::make_unique<DesignElementT>();
    e->guid = "g" + name, e->name = name, e->class_ = ifc_class, e->position = place;
    e->placement = {Eigen::Quaterniond::Identity(), place};
    e->box_low.setConstant(NAN), e->box_high.setConstant(NAN);
    ifc::FacadeFrame frame = ifc::frame_facing({0, -1, 0}, ifc::FacadeSource::panel, true);
    frame.facade = "A (180°)";
    e->facade = ifc::to_artifact(frame);
    design.elements.push_back(std::move(e));
    return *design.elements.back();
  }

  DeviationT judge(const judgement::ToleranceTable& tolerances = {}) const {
    auto inputs = deviation_inputs(design, matches, plates, tolerances, 0.3, {});
    inputs.model = model;
    return judgement::judge_deviations(inputs, {});
  }
};

TEST(DesignInput, PlatesThatContradictTheDesignLeaveThePanelsWithoutOrders) {
  Site site({0, 1, 0});  // the plate table: 0°; the design: 180°
  site.model.positions[0].y() -= 4 * mm;
  const DeviationT result = site.judge();
  EXPECT_FALSE(result.anchors[0]->facade->confirmed);
  ASSERT_EQ(result.panels.size(), 2u);
  for (const auto& panel : result.panels) {
    EXPECT_FALSE(panel->facade->confirmed) << panel->name;
    EXPECT_NE(panel->facade->note.find("plate table"), std::string::npos) << panel->facade->note;
    EXPECT_EQ(panel->verdict, ToleranceVerdict::undecided);
    for (const auto& fixing : panel->fixings) EXPECT_TRUE(std::isnan(fixing->shim)) << fixing->anchor;
  }
  // One plate of four that says otherwise is enough.
  Site one({0, -1, 0});
  one.plates.plates[0]->nominal_rotation = site.plates.plates[0]->nominal_rotation;
  EXPECT_FALSE(one.judge().panels[0]->facade->confirmed);
  EXPECT_TRUE(one.judge().panels[1]->facade->confirmed) << "none of its plates contradicts";
  EXPECT_TRUE(Site({0, -1, 0}).judge().panels[0]->facade->confirmed);
  EXPECT_TRUE(Site({0, 0, 0}).judge().panels[0]->facade->confirmed);
}

/// Of a design that ties no anchors to its panels, nobody was told that those near a panel are taken for its own.
TEST(DesignInput, PanelsThatTakeAnchorsByNearnessAreTold) {
  const auto said = [](const DeviationT& result) {
    std::string text;
    for (const auto& request : result.requests) text += request->by + ": " + request->asked + "\n";
    for (const std::string& warning : result.warnings) text += warning + "\n";
    return text;
  };
  Site site({0, -1, 0});
  EXPECT_EQ(said(site.judge()).find("panel_reach"), std::string::npos) << "the design says it of both";
  for (auto& element : site.design.elements)
    if (element->is_panel) element->anchor_guids.clear();
  const DeviationT alike = site.judge();
  EXPECT_NE(
      said(alike).find("panel_reach: which anchors hold a panel: the design says it of 0 of 2; the others hang on "
                       "those within 0.3 m\n"),
      std::string::npos)
      << said(alike);
  EXPECT_EQ(said(alike).find("different numbers"), std::string::npos);
  EXPECT_EQ(alike.not_judged, 0) << "supposed, and judged";
  DesignElementT& fifth = site.add("S-K1", "IfcMechanicalFastener", {0.6, 0, 4.5});
  fifth.is_anchor = true;
  EXPECT_NE(said(site.judge()).find("different numbers of anchors, PS-1 on 4 and PS-0 on 5:"), std::string::npos)
      << said(site.judge());
}

/// In a stack the brackets at the joints are of the panels below and above, and the lowest panel stands on sills: it
/// has fewer, and every such building was told to look whether that is so.
TEST(DesignInput, TheLowestPanelOfAStackHasFewerAnchorsThanOthers) {
  Site site({0, -1, 0});
  std::erase_if(site.design.elements, [](const auto& element) { return element->is_panel; });
  for (int column = 0; column < 3; ++column)
    site.add("S-3" + std::to_string(column), "IfcMechanicalFastener", {2.0 * column, 0, 9}).is_anchor = true;
  for (int floor = 0; floor < 3; ++floor) {
    DesignElementT& panel = site.add("P" + std::to_string(floor), "IfcPlate", {0, -0.1, 3.0 * floor});
    panel.is_panel = true, panel.box_low = {0.01, -0.02, 0}, panel.box_high = {1.99, 0.02, 3};
  }
  std::string said;
  for (const std::string& warning : site.judge().warnings) said += warning + "\n";
  EXPECT_EQ(said.find("different numbers of anchors"), std::string::npos) << said;
  DesignElementT& fifth = site.add("S-K1", "IfcMechanicalFastener", {0.6, 0, 4.5});
  fifth.is_anchor = true;
  DesignElementT& fourth = site.add("P3", "IfcPlate", {2, -0.1, 3});
  fourth.is_panel = true, fourth.box_low = {0.01, -0.02, 0}, fourth.box_high = {1.99, 0.02, 3};
  site.add("P4", "IfcPlate", {2, -0.1, 6});
  DesignElementT& last = *site.design.elements.back();
  last.is_panel = true, last.box_low = {0.01, -0.02, 0}, last.box_high = {1.99, 0.02, 3};
  said.clear();
  for (const std::string& warning : site.judge().warnings) said += warning + "\n";
  EXPECT_NE(said.find("different numbers of anchors"), std::string::npos) << "one of a middle row took a fifth\n"
                                                                          << said;
}

/// A project's table is for all of its buildings: what this one has nothing of is told, a slip of the pen is not
/// judged.
TEST(DesignInput, RowsForOtherBuildingsAreToldAndSlipsAreNotJudged) {
  const Site site({0, -1, 0});
  for (const auto& element : site.design.elements) element->storey = "Level 1";
  std::vector<std::string> warnings;
  const auto judged = [&](const std::string& rows, const std::vector<std::string>& rules = {}) {
    judgement::ToleranceTable table;
    table.rules = parse_tolerance_classes("class,select,optional,vertical_mm,joint_mm\n" + rows, "t.csv");
    for (const std::string& rule : rules) table.rules.push_back(judgement::parse_rule(rule));
    const DeviationT result = site.judge(table);
    warnings = result.warnings;
    std::string why;
    for (const auto& request : result.requests) why += request->not_judged;
    return why;
  };
  for (const char* row : {"A,class=IfcDoor,,3,\n", "A,storey=Level 12,,3,\n", "A,class=IfcPlate & name=S-10,,3,\n",
                          "A,name~^T-,yes,3,\n", "A,storey=Ground,ja,3,\n"}) {
    EXPECT_EQ(judged(row), "") << row;
    EXPECT_NE(testing::PrintToString(warnings).find("rows that nothing in this building is of: 't.csv:2, class A: "),
              std::string::npos)
        << testing::PrintToString(warnings);
  }
  EXPECT_EQ(
      judged("A,class=IfcMechanicalFastenr,,3,\n"),
      "it selects no anchor and no panel: no anchor and no panel has the class 'IfcMechanicalFastenr', the nearest "
      "here is 'IfcMechanicalFastener'; a row for other buildings says 'yes' in the column 'optional'");
  for (const auto& [row, part] : std::vector<std::pair<std::string, std::string>>{
           {"A,class=IfcFastener,,3,\n", "nearest here is 'IfcMechanicalFastener'"},
           {"A,storey=Levle 1,,3,\n", "the nearest here is 'Level 1'"},
           {"A,storey=Ground,,3,\n", "has the storey 'Ground'; a row"},
           {"A,name~^T-,,3,\n", "has a name in which '^T-' finds anything"},
           {"A,class=IfcMechanicalFastener,,,3\n", "joint is not judged of anchors"}})
    EXPECT_NE(judged(row).find(part), std::string::npos) << row << judged(row);
  EXPECT_NE(judged("A,*,,3,\n", {"class=IfcDoor: vertical=3mm"}), "") << "a rule of the run is for this building";
  EXPECT_EQ(judged("A,*,,2,\n", {"*: vertical=8mm"}), "") << "whoever runs it wants it wider";
  EXPECT_NE(testing::PrintToString(warnings).find("holds nowhere in this run: its rule '*: vertical=8mm'"),
            std::string::npos)
      << testing::PrintToString(warnings);
}

/// The facade looks to the south: out is along y, whether the table gives an azimuth or not.
TEST(DesignInput, MountingIsAlongTheFacadeWhereThePlatesDoNotSayHowTheyFace) {
  for (const Eigen::Vector3d& of_plates : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0, -1, 0)}) {
    Site site(of_plates);
    if (of_plates.norm() > 0)
      for (auto& plate : site.plates.plates)
        plate->nominal_rotation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
    for (auto& plate : site.plates.plates) plate->mounting_sigma = {0.3 * mm, 0.2 * mm, 3 * mm};  // right, up, out
    const auto inputs = deviation_inputs(site.design, site.matches, site.plates, {}, 0.3, {});
    const Eigen::Vector3d sigma = inputs.anchors[0].mounting.diagonal().cwiseSqrt();
    EXPECT_LT((sigma - Eigen::Vector3d(0.3 * mm, 3 * mm, 0.2 * mm)).norm(), 1e-9) << sigma.transpose();
  }
}

/// Left out of the plate table, an anchor was judged more surely than the others: by what it sits on its mounting less.
TEST(DesignInput, AnAnchorThatNoPlateListsIsKnownNoBetterAndIsNamed) {
  Site site({0, -1, 0});
  judgement::Mounting mounting;
  mounting.sigma = 0.5 * mm;
  mounting.rules.push_back(judgement::parse_mounting("name=S-11: right=0.3mm, up=0.2mm, out=3mm"));
  const auto judged = [&] {
    auto inputs = deviation_inputs(site.design, site.matches, site.plates, {}, 0.3, mounting);
    inputs.model = site.model;
    return inputs;
  };
  const auto listed = judged();
  const auto without = [&](std::size_t which) {
    site.plates.plates.erase(site.plates.plates.begin() + which);
    site.matches.matches.erase(site.matches.matches.begin() + which);
  };
  without(1), without(0);  // S-11 and S-10
  const auto unlisted = judged();
  for (const char* name : {"S-10", "S-11"}) {
    const auto of = [&](const judgement::DeviationInputs& inputs) {
      for (const auto& anchor : inputs.anchors)
        if (anchor.id == name) return anchor.mounting;
      throw std::runtime_error(name);
    };
    EXPECT_GT(of(listed).trace(), 1e-8);
    EXPECT_LT((of(unlisted) - of(listed)).norm(), 1e-12) << name;
  }
  const DeviationT result = judgement::judge_deviations(judged(), {});
  const std::string said = testing::PrintToString(result.warnings);
  EXPECT_NE(said.find("Measured and not in the plate table: S-10, S-11."), std::string::npos) << said;
  EXPECT_EQ(testing::PrintToString(Site({0, -1, 0}).judge().warnings).find("plate table"), std::string::npos);
}

TEST(DesignInput, AFloorThatContradictsTheStoreyIsNamed) {
  Site site({0, -1, 0});
  for (auto& element : site.design.elements) {
    const bool low = element->position.z() < 4;
    element->storey = low ? "Ground" : "First", element->storey_guid = low ? "s0" : "s1";
  }
  EXPECT_EQ(testing::PrintToString(site.judge().warnings).find("storey"), std::string::npos);
  for (auto& plate : site.plates.plates) plate->floor = 1;
  EXPECT_NE(testing::PrintToString(site.judge().warnings)
                .find("Floor 1 of the plate table is 2 storeys of the design (Ground, First)"),
            std::string::npos);
  for (std::size_t i = 0; i < 6; ++i) site.plates.plates[i]->floor = i < 3 ? 1 : 2;
  site.plates.plates[1]->floor = 2;
  const std::string said = testing::PrintToString(site.judge().warnings);
  EXPECT_NE(said.find("The plate table has S-11 on floor 2, the design in the storey 'Ground', whose other anchors are "
                      "on floor 1 (2 of them)"),
            std::string::npos)
      << said;
}

/// The last rule holds. Who wrote the narrow one first asked for something that nobody would judge.
TEST(DesignInput, ANarrowRuleThatALaterWideOneReplacesIsNotJudged) {
  const Site site({0, -1, 0});
  std::vector<std::string> warnings;
  const auto not_judged = [&](std::vector<std::string> rules) {
    judgement::ToleranceTable table;
    for (const std::string& rule : rules) table.rules.push_back(judgement::parse_rule(rule));
    std::vector<std::string> found;
    const DeviationT result = site.judge(table);
    warnings = result.warnings;
    for (const auto& request : result.requests)
      if (!request->not_judged.empty()) found.push_back(request->asked + ": " + request->not_judged);
    return found;
  };
  const std::string narrow = "class=IfcMechanicalFastener: vertical=2mm", wide = "*: vertical=8mm";
  const auto found = not_judged({narrow, wide});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NE(found[0].find(narrow + ": it holds nowhere"), std::string::npos) << found[0];
  EXPECT_NE(found[0].find(wide), std::string::npos) << found[0];
  EXPECT_TRUE(not_judged({wide, narrow}).empty()) << "from the general to the special";
  EXPECT_TRUE(not_judged({narrow, "name=" + site.design.elements[0]->name + ": vertical=8mm"}).empty())
      << "it holds for the others";
  EXPECT_TRUE(not_judged({"*: vertical=8mm", "*: vertical=2mm"}).empty()) << "nothing narrower is lost";
  const std::string few = "name=" + site.design.elements[0]->name + ": vertical=8mm";
  warnings.clear();
  EXPECT_TRUE(not_judged({few, "*: vertical=2mm"}).empty()) << "the stricter limit is judged";
  EXPECT_NE(testing::PrintToString(warnings).find("The rule '" + few + "' holds nowhere: '*: vertical=2mm' stands "),
            std::string::npos)
      << "who gave one anchor more, and all of them less after it, meant something else: "
      << testing::PrintToString(warnings);
  EXPECT_TRUE(not_judged({"*: vertical=2mm", few}).empty());
  EXPECT_EQ(not_judged({narrow, "*: vertical=0mm"}).size(), 1u) << "not judged at all is wider than any";
}

/// A place of a sill holds no panel, and a rule that nothing follows is not judged.
TEST(DesignInput, WhatHoldsPanelsBelowIsSaidByRules) {
  Site site({0, -1, 0});
  HeldBelow held;
  held.rules = {parse_held_below("class=IfcPlate: sigma=0.5mm"), parse_held_below("name=none: sigma=1mm")};
  held.sills = {ifc::Selection("name~^S-1"), ifc::Selection("name~^SILL")};
  auto inputs = deviation_inputs(site.design, site.matches, site.plates, {}, 0.3, {}, held);
  ASSERT_EQ(inputs.panels.size(), 2u);
  for (const PanelCase& panel : inputs.panels) {
    ASSERT_TRUE(panel.held_below);
    EXPECT_NEAR(panel.held_below->sigma, 0.5 * mm, 1e-12);
    EXPECT_EQ(panel.anchors.size(), 2u);
    for (const std::size_t anchor : panel.anchors) EXPECT_FALSE(inputs.anchors[anchor].is_sill);
  }
  const auto request = [&](const std::string& asked) {
    for (const Request& one : inputs.requests)
      if (one.asked == asked) return std::to_string(one.panels) + " " + std::to_string(one.anchors) + one.not_judged;
    return std::string("none");
  };
  EXPECT_EQ(request("class=IfcPlate: sigma=0.5mm"), "2 0");
  EXPECT_EQ(request("name=none: sigma=1mm"), "0 0it selects no panel");
  EXPECT_EQ(request("name~^S-1"), "0 3");
  EXPECT_EQ(request("name~^SILL"), "0 0it selects no anchor");
  inputs.model = site.model;
  const DeviationT judged = judge_deviations(std::move(inputs), {});
  for (const auto& panel : judged.panels) EXPECT_EQ(panel->verdict, ToleranceVerdict::pass) << panel->reason;
  // A panel of the design without any anchor is found below all the same: no sill is assumed in its place.
  Site above({0, -1, 0});
  DesignElementT& lower = above.add("PL", "IfcPlate", {0, -0.1, -0.02});
  lower.is_panel = true, lower.box_low = {0.01, -0.02, -3}, lower.box_high = {1.99, 0.02, 0};
  held.rules = {parse_held_below("*: sigma=0.5mm, sill_sigma=0.5mm")};
  held.sills.clear();
  for (auto& panel : above.design.elements)
    if (panel->is_panel && panel->name != "PL") {
      panel->anchor_guids.erase(panel->anchor_guids.begin(), panel->anchor_guids.begin() + 2);
      panel->placement.translation.z() = 3;
    }
  lower.placement.translation.z() = 2.98;
  auto more = deviation_inputs(above.design, above.matches, above.plates, {}, 0.01, {}, held);
  ASSERT_EQ(more.loose.size(), 1u);
  more.model = above.model;
  const DeviationT stacked = judge_deviations(std::move(more), {});
  EXPECT_EQ(stacked.panels[0]->decided_by, "held_below");
  EXPECT_NE(stacked.panels[0]->reason.find("held by panel PL"), std::string::npos) << stacked.panels[0]->reason;
  EXPECT_EQ(stacked.panels[1]->below->by, "assumed_sill");
}

/// As with tolerances. What a rule decides is counted, not what it selects.
TEST(DesignInput, ANarrowRuleOfHeldBelowThatALaterWideOneReplacesIsNotJudged) {
  const Site site({0, -1, 0});
  const auto requests = [&](const std::vector<std::string>& rules) {
    HeldBelow held;
    for (const std::string& rule : rules) held.rules.push_back(parse_held_below(rule));
    held.sills = {ifc::Selection("name~^S-1")};
    const auto inputs = deviation_inputs(site.design, site.matches, site.plates, {}, 0.3, {}, held);
    std::vector<std::string> found;
    for (const Request& one : inputs.requests)
      if (one.by == "held_below") found.push_back(std::to_string(one.panels) + one.not_judged);
    return found;
  };
  const std::string narrow = "name=PS-0: sigma=2mm", wide = "*: sigma=0.5mm";
  const auto replaced = requests({narrow, wide});
  EXPECT_EQ(replaced[0], "0it holds nowhere: '" + wide +
                             "' stands after it and selects its panels and others; put the narrower rule last, or "
                             "take it out");
  EXPECT_EQ(replaced[1], "2");
  EXPECT_EQ(requests({wide, narrow}), (std::vector<std::string>{"1", "1"})) << "from the general to the special";
  EXPECT_EQ(requests({wide, narrow, "name=PS-1: sigma=1mm"}), (std::vector<std::string>{"0", "1", "1"}))
      << "nothing narrower is lost";
  EXPECT_EQ(requests({narrow, "name=PS-1: sigma=1mm"}), (std::vector<std::string>{"1", "1"}));
}

TEST(DesignInput, ANarrowRuleOfMountingThatALaterWideOneReplacesIsNotJudged) {
  const Site site({0, -1, 0});
  const auto requests = [&](const std::vector<std::string>& rules) {
    Mounting mounting;
    for (const std::string& rule : rules) mounting.rules.push_back(parse_mounting(rule));
    std::vector<std::string> found;
    for (const Request& one : deviation_inputs(site.design, site.matches, site.plates, {}, 0.3, mounting).requests)
      if (one.by == "mounting") found.push_back(one.not_judged);
    return found;
  };
  const std::string narrow = "name=S-11: out=3mm", wide = "*: out=1mm", beside = "*: right=1mm";
  EXPECT_EQ(requests({narrow, wide}).at(0),
            "it holds nowhere: '" + wide +
                "' stands after it and selects its anchors and others; put the narrower rule last, or take it out");
  EXPECT_EQ(requests({wide, narrow}), (std::vector<std::string>{"", ""}));
  EXPECT_EQ(requests({narrow, beside}), (std::vector<std::string>{"", ""})) << "another axis replaces nothing";
}

/// The rule that is printed, by what a user would copy.
std::string rule_in(const std::string& warning) {
  std::smatch found;
  return std::regex_search(warning, found, std::regex("design\\.with\\.facades=\\['([^']*)'\\]")) ? found[1].str() : "";
}

/// The rule acts on the design before any plate is seen: it has to say the direction that the warning speaks of.
TEST(DesignInput, TheCommandOfTheWarningSaysTheDirectionItSpeaksOf) {
  Site site({0, 1, 0});
  Site other({0, 0, 0}, "N-");  // a second facade 50 m away, of which nothing is open
  for (auto& e : other.design.elements) {
    e->position.y() += 50, e->placement.translation.y() += 50;
    site.design.elements.push_back(std::move(e));
  }
  std::vector<std::string> warnings;
  for (const std::string& warning : site.judge().warnings)
    if (warning.find("design.with.facades") != std::string::npos) warnings.push_back(warning);
  ASSERT_EQ(warnings.size(), 1u) << "anchors and the panels they hold are one facade";
  EXPECT_NE(warnings[0].find("If it faces 0°"), std::string::npos) << warnings[0];
  EXPECT_EQ(warnings[0].find("confirmed'"), std::string::npos) << warnings[0];
  const std::string rule = rule_in(warnings[0]);
  ASSERT_NE(rule, "") << warnings[0];
  const ifc::FacadeRule parsed = ifc::parse_facade_rule(rule);
  ASSERT_TRUE(parsed.out) << rule;
  EXPECT_LT((*parsed.out - Eigen::Vector3d(0, 1, 0)).norm(), 1e-6) << rule;
  for (const auto& e : site.design.elements) {
    const ifc::ElementFacts facts{e->class_, e->guid, e->name, "", "", "", "", nullptr};
    EXPECT_EQ(parsed.selection.matches(facts), e->name.find("S-") != std::string::npos) << rule << " " << e->name;
  }
}

/// A rule for the anchors alone that turns them round leaves no panel confirmed the other way.
TEST(DesignInput, ARuleForTheAnchorsThatContradictsThePanelsSideIsNotPassedOver) {
  Site site({0, 0, 0});
  for (auto& e : site.design.elements)
    if (e->is_anchor) e->facade = ifc::to_artifact(ifc::frame_facing({0, 1, 0}, ifc::FacadeSource::rule, true));
  const DeviationT result = site.judge();
  EXPECT_FALSE(result.panels[0]->facade->confirmed);
  EXPECT_EQ(result.panels[0]->facade->source, "panel") << "no plate has said anything";
}

/// The plate table may lack anchors that the design has: their floor is that of their storey, and so is the panel's.
TEST(DesignInput, PanelsStandOnTheFloorOfTheirAnchors) {
  Site site({0, 0, 0});
  for (auto& e : site.design.elements) e->storey_guid = e->position.z() > 4 ? "upper" : "lower";
  for (const std::size_t i : {0u, 1u, 2u, 3u, 4u}) {  // 5, on the upper floor, stays listed
    site.matches.matches[i].reset(), site.plates.plates[i].reset();
  }
  std::erase(site.matches.matches, nullptr), std::erase(site.plates.plates, nullptr);
  const DeviationT result = site.judge();
  for (const auto& anchor : result.anchors)
    EXPECT_EQ(anchor->floor, anchor->storey_guid == "upper" ? 2 : 0) << anchor->id;
  for (const auto& panel : result.panels) EXPECT_EQ(panel->floor, 2) << panel->name;
  int panels_of_second = 0;
  for (const auto& floor : result.floors)
    if (floor->floor == 2) panels_of_second += floor->panels_passed + floor->panels_undecided + floor->panels_failed;
  EXPECT_EQ(panels_of_second, 2);
  // Where no floor of its anchors is known, its own storey tells it.
  for (auto& e : site.design.elements)
    if (e->is_panel) e->storey_guid = "upper", e->anchor_guids = {site.design.elements[0]->guid};
  for (const auto& panel : site.judge().panels) EXPECT_EQ(panel->floor, 2) << panel->name;
}

/// Three panels of 1.5 m x 3 m in a row with joints of 20 mm, four brackets 0.1 m within each, 60 mm behind its face;
/// the design does not tie them.
struct Row : Site {
  Row() : Site({0, -1, 0}) {
    design.elements.clear(), matches.matches.clear(), plates.plates.clear(), model = {};
    for (int p = 0; p < 3; ++p) {
      DesignElementT& e = add("P" + std::to_string(p), "IfcPlate", {1.52 * p, 0, 0});
      e.is_panel = true, e.box_low = {0, -0.02, 0}, e.box_high = {1.5, 0.02, 3};
      for (int corner = 0; corner < 4; ++corner)
        anchor("A" + std::to_string(p) + std::to_string(corner),
               {1.52 * p + (corner % 2 ? 1.4 : 0.1), 0.06, corner < 2 ? 0.1 : 2.9});
    }
  }
  void anchor(const std::string& name, const Eigen::Vector3d& place) {
    DesignElementT& e = add(name, "IfcMechanicalFastener", place);
    e.is_anchor = true;
    auto match = std::make_unique<ElementMatchT>();
    match->anchor = name, match->guid = e.guid, match->position = place, match->target_offset.setZero();
    matches.matches.push_back(std::move(match));
    model.ids.push_back(name), model.positions.push_back(place);
    model.covariance = test::isotropic(model.ids.size(), 0.3 * mm);
  }
  /// By name, of each panel.
  std::vector<std::string> held() const {
    const DeviationInputs inputs = deviation_inputs(design, matches, plates, {}, 0.3, {});
    std::vector<std::string> all;
    for (const PanelCase& panel : inputs.panels) {
      all.push_back(panel.name + ":");
      for (const std::size_t i : panel.anchors) all.back() += " " + inputs.anchors[i].id;
    }
    return all;
  }
};

/// Brackets of the neighbours are no more than 220 mm away, and hold another panel.
TEST(DesignInput, APanelHasItsOwnBracketsOnly) {
  Row row;
  EXPECT_EQ(row.held(),
            (std::vector<std::string>{"P0: A00 A01 A02 A03", "P1: A10 A11 A12 A13", "P2: A20 A21 A22 A23"}));
  // A neighbour whose brackets stand out does not tilt the panel.
  for (std::size_t i = 0; i < row.model.ids.size(); ++i)
    if (row.model.ids[i][1] == '2') row.model.positions[i].y() -= 40 * mm;
  const DeviationT result = row.judge();
  ASSERT_EQ(result.panels.size(), 3u);
  EXPECT_NEAR(result.panels[1]->out_of_plane->value, 0, 1e-9);
  EXPECT_EQ(result.panels[1]->fixings.size(), 4u);
  // One in the joint between two holds both, one that the design ties to another panel does not.
  row.anchor("J", {1.51, 0.06, 1.5});
  EXPECT_EQ(row.held()[0], "P0: A00 A01 A02 A03 J");
  EXPECT_EQ(row.held()[1], "P1: A10 A11 A12 A13 J");
  row.design.elements[0]->anchor_guids = {"gA00", "gJ"};
  EXPECT_EQ(row.held()[0], "P0: A00 J");
  EXPECT_EQ(row.held()[1], "P1: A10 A11 A12 A13");
  // What hangs before a panel on the same brackets has them too.
  Row shaded;
  DesignElementT& shade = shaded.add("shade", "IfcPlate", {0, -0.2, 0});
  shade.is_panel = true, shade.box_low = {0, -0.02, 0}, shade.box_high = {1.5, 0.02, 3};
  EXPECT_EQ(shaded.held().back(), "shade: A00 A01 A02 A03");
}

TEST(DesignInput, APanelWhoseBracketsAreAllOfOthersIsNotJudged) {
  Row row;
  std::erase_if(row.design.elements, [](const auto& e) { return e->is_anchor && e->name[1] == '1'; });
  std::erase_if(row.matches.matches, [](const auto& m) { return m->anchor[1] == '1'; });
  const DeviationT result = row.judge();
  EXPECT_EQ(result.panels.size(), 2u);
  ASSERT_EQ(result.not_judged, 1);
  const auto request = std::find_if(result.requests.begin(), result.requests.end(),
                                    [](const auto& r) { return !r->not_judged.empty(); });
  EXPECT_EQ((*request)->asked, "panels P1");
  EXPECT_NE((*request)->not_judged.find("are nearer to other panels"), std::string::npos) << (*request)->not_judged;
}

TEST(DesignInput, TwoPanelsAtOnePlaceAreNotReady) {
  Row row;
  ASSERT_EQ(row.judge().not_judged, 0);
  DesignElementT& twin = row.add("twin", "IfcPlate", {1.52 * 1, 0, 0});
  twin.is_panel = true, twin.box_low = {0, -0.02, 0}, twin.box_high = {1.5, 0.02, 3};
  const DeviationT result = row.judge();
  EXPECT_EQ(result.not_judged, 1);
  EXPECT_NE(result.verdict, ToleranceVerdict::pass);
  const auto request = std::find_if(result.requests.begin(), result.requests.end(),
                                    [](const auto& r) { return !r->not_judged.empty(); });
  EXPECT_NE((*request)->asked.find("P1 and twin"), std::string::npos) << (*request)->asked;
}

}  // namespace test_design_input
}  // namespace plumbline::judgement

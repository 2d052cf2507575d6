// Deviations judged per axis, against values worked out by hand; the guard band's promise over simulated campaigns.
#include <gtest/gtest.h>

#include "../bim/facing.hpp"
#include "building/ifc/limit_words.hpp"
#include "building/judgement/deviation.hpp"
#include "building/judgement/mounting.hpp"
#include "geometry/exchanged_places.hpp"
#include "geometry/statistics.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_deviation {

using judgement::test::isotropic;
using judgement::test::mm;
using judgement::test::Normal;

const Eigen::Vector3d kOut(0, -1, 0);

AnchorDeviationT judge(const Eigen::Vector3d& deviation, double u, const Tolerances& tolerances, double k = 2) {
  AnchorDeviationT out;
  judge_anchor(deviation, u > 0 ? Eigen::MatrixXd(u * u * Eigen::Matrix3d::Identity()) : Eigen::MatrixXd(),
               ifc::frame_facing(kOut, ifc::FacadeSource::rule, true), tolerances, {0.005, 1 - normal_probability(k)},
               out);
  return out;
}

const JudgedAxisT& axis(const AnchorDeviationT& anchor, const std::string& name) {
  for (const auto& a : anchor.axes)
    if (a->axis == name) return *a;
  throw std::runtime_error("no axis " + name);
}

TEST(AnchorJudgement, HorizontalAndVerticalByDefault) {
  const Tolerances tolerances = tolerances_of({}, {});
  // 7 mm out of plane: what only heights were judged by was green.
  const AnchorDeviationT anchor = judge({0, -7 * mm, 1 * mm}, 0.2 * mm, tolerances);
  EXPECT_EQ(anchor.verdict, ToleranceVerdict::fail);
  EXPECT_EQ(anchor.decided_by, "horizontal");
  EXPECT_NEAR(axis(anchor, "out_of_plane").value, 7 * mm, 1e-12);
  EXPECT_NEAR(axis(anchor, "in_plane").value, 1 * mm, 1e-12);
  EXPECT_NEAR(axis(anchor, "space").value, std::sqrt(50.0) * mm, 1e-12);
  EXPECT_EQ(axis(anchor, "vertical").verdict, ToleranceVerdict::pass);
  EXPECT_EQ(axis(anchor, "space").verdict, ToleranceVerdict::not_measured);  // told, not judged
  EXPECT_NEAR(axis(anchor, "horizontal").u, 0.2 * mm, 1e-12);
}

/// The side by the sign once stood beside the verdict: 0.3 mm of "5 mm" undecided.
TEST(AnchorJudgement, TheLimitThatIsToldIsThatWhichDecides) {
  const Tolerances tolerances = tolerances_of({0.005, false, {parse_rule("*: vertical=+5/-0mm")}}, {});
  const auto limit_at = [&](double z) { return axis(judge({0, 0, z}, 0.6 * mm, tolerances), "vertical").tolerance; };
  EXPECT_EQ(limit_at(0.3 * mm), 0);
  EXPECT_EQ(limit_at(-0.3 * mm), 0);
  EXPECT_EQ(limit_at(4 * mm), 5 * mm);
  EXPECT_EQ(limit_at(9 * mm), 5 * mm);
  EXPECT_EQ(judge({0, 0, 0.3 * mm}, 0.6 * mm, tolerances).verdict, ToleranceVerdict::undecided);
  const auto words = [](double metres) { return std::to_string(static_cast<int>(std::lround(1e3 * metres))); };
  const AnchorDeviationT anchor = judge({0, 0, 0.3 * mm}, 0.6 * mm, tolerances);
  EXPECT_EQ(ifc::limits_in_words(axis(anchor, "vertical"), words), "+5/-0");
  EXPECT_EQ(ifc::limits_in_words(axis(anchor, "horizontal"), words), "5");
}

TEST(AnchorJudgement, WithoutUncertaintyNothingIsDecided) {
  EXPECT_EQ(judge({0, 0, 9 * mm}, 0, tolerances_of({}, {})).verdict, ToleranceVerdict::undecided);
  EXPECT_TRUE(std::isnan(judge({0, 0, 9 * mm}, 0, tolerances_of({}, {})).pass_probability));
}

TEST(AnchorJudgement, ProbabilityIsThatOfAllAxesTogether) {
  const ToleranceTable vertical{5 * mm, false, {parse_rule("*: horizontal=0mm")}};
  EXPECT_NEAR(judge({0, 0, 5 * mm}, 1 * mm, tolerances_of(vertical, {})).pass_probability, 0.5, 2e-3);
  // Rayleigh: P(r <= 2 sigma) = 1 - exp(-2); with the height's P(|z| <= 2 sigma) = 0.9545.
  const Tolerances both = tolerances_of({2 * mm, false, {}}, {});
  EXPECT_NEAR(judge({0, 0, 0}, 1 * mm, both).pass_probability, (1 - std::exp(-2.0)) * 0.9545, 3e-3);
}

TEST(ToleranceRules, LaterRulesAndTheDesignGoBeforeTheDefault) {
  const std::vector<ifc::Property> properties = {{"Pset_Tolerance", "VerticalTolerance", "3.", 3 * mm}};
  ifc::ElementFacts element;
  element.ifc_class = "IfcMechanicalFastener", element.name = "A1", element.properties = &properties;
  ToleranceTable table;
  Tolerances found = tolerances_of(table, element);
  EXPECT_EQ(found[Axis::vertical].value, 3 * mm);
  EXPECT_EQ(found[Axis::vertical].source, "design: Pset_Tolerance.VerticalTolerance");
  EXPECT_EQ(found[Axis::horizontal].value, 5 * mm);
  table.rules = {parse_rule("class=IfcMechanicalFastener: vertical=8mm, out_of_plane=2mm"),
                 parse_rule("name=A1: vertical=0.004m, horizontal=0mm")};
  found = tolerances_of(table, element);
  EXPECT_EQ(found[Axis::vertical].value, 4 * mm);
  EXPECT_EQ(found[Axis::out_of_plane].value, 2 * mm);
  EXPECT_FALSE(found.contains(Axis::horizontal));
  for (const char* wrong : {"*", "*: vertical", "*: upward=3mm", "*: vertical=3", "*: vertical=-3mm", "*: vertical=2m",
                            "x=y: vertical=3mm"})
    EXPECT_THROW(parse_rule(wrong), std::runtime_error) << wrong;
}

TEST(ExchangedPlaces, AreThoseOfAnotherThingAndNotOfANeighbour) {
  const std::vector<Eigen::Vector3d> places = {{0, 0, 0}, {0.5, 0, 0}, {10, 0, 0}, {14, 0, 0}};
  std::vector<Eigen::Vector3d> found = places;
  std::swap(found[0], found[1]);
  const auto close = exchanged_places(found, places);
  ASSERT_EQ(close.size(), 1u);
  EXPECT_TRUE(close[0].mutual && close[0].thing == 0 && close[0].place == 1);
  found = places;
  found[2] = places[3] + Eigen::Vector3d(0.3, 0, 0);
  EXPECT_TRUE(exchanged_places(found, places).empty()) << "0.3 m beside it is another place";
  found[2] = places[3] + Eigen::Vector3d(0.2, 0, 0);
  ASSERT_EQ(exchanged_places(found, places).size(), 1u);
  EXPECT_FALSE(exchanged_places(found, places)[0].mutual);
  found = places;
  found[0] = places[1] + Eigen::Vector3d(0.15, 0, 0);
  EXPECT_TRUE(exchanged_places(found, places).empty()) << "a quarter of half a metre is 0.125 m";
}

/// A grid of anchors on a facade along x.
DeviationInputs grid(int columns, int rows) {
  DeviationInputs inputs;
  inputs.design_file = "d.ifc";
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column) {
      AnchorCase anchor;
      anchor.id = "A" + std::to_string(row) + "." + std::to_string(column);
      anchor.element.guid = "g" + anchor.id, anchor.instance = inputs.anchors.size() + 1;
      anchor.storey_guid = "s" + std::to_string(row), anchor.element.storey = "Level " + std::to_string(row + 1);
      anchor.floor = row + 1, anchor.use = "check";
      anchor.design = {2.0 * column, 0, 3.0 * row};
      anchor.tolerances = tolerances_of({}, {});
      inputs.model.ids.push_back(anchor.id);
      inputs.model.positions.push_back(anchor.design);
      inputs.anchors.push_back(anchor);
    }
  inputs.model.covariance = isotropic(inputs.model.ids.size(), 0.4 * mm);
  plumbline::test::face(inputs, kOut);
  return inputs;
}

TEST(CommonShift, OneOutlierIsNoCommonShift) {
  DeviationInputs inputs = grid(5, 4);
  Normal normal(3);
  for (auto& p : inputs.model.positions) p += Eigen::Vector3d(normal(), normal(), normal()) * 1 * mm;
  inputs.model.positions[7] += Eigen::Vector3d(0.5, 0, 0);  // a mean would be shifted by 25 mm
  const DeviationT result = judge_deviations(inputs, {});
  ASSERT_TRUE(result.common_shift);
  EXPECT_FALSE(result.common_shift->significant);
  EXPECT_EQ(result.anchors[7]->verdict, ToleranceVerdict::fail);
}

TEST(CommonShift, AShiftedDatumIsNamedWithItsTurn) {
  DeviationInputs inputs = grid(5, 4);
  Normal normal(4);
  const Eigen::Vector3d shift(6 * mm, -3 * mm, 2 * mm);
  for (auto& p : inputs.model.positions)
    p += shift + Eigen::Vector3d(0, 0, 5e-4).cross(p - Eigen::Vector3d(4, 0, 4.5)) +
         Eigen::Vector3d(normal(), normal(), normal()) * 0.8 * mm;
  inputs.model.positions[3] += Eigen::Vector3d(0.3, 0, 0);
  const DeviationT result = judge_deviations(inputs, {});
  ASSERT_TRUE(result.common_shift->significant);
  EXPECT_NEAR((result.common_shift->shift - shift).norm(), 0, 0.8 * mm);
  EXPECT_NEAR(result.common_shift->rotation.z(), 5e-4, 2e-4);
  EXPECT_GT(result.common_shift->would_pass, result.passed + 5);
  EXPECT_NE(result.common_shift->words.find("do not share their datum"), std::string::npos);
  EXPECT_EQ(result.warnings.back(), result.common_shift->words);
}

TEST(CommonShift, SoundCampaignsGiveNoAlarm) {
  int alarms = 0;
  for (int trial = 0; trial < 200; ++trial) {
    DeviationInputs inputs = grid(4, 3);
    Normal normal(static_cast<std::uint64_t>(trial) + 10);
    for (auto& p : inputs.model.positions) p += Eigen::Vector3d(normal(), normal(), normal()) * 3 * mm;
    alarms += judge_deviations(inputs, {}).common_shift->significant;
  }
  EXPECT_LE(alarms, 2);
}

/// A side of 0 mm is a side without room, not the smallest tolerance: half a millimetre in common is no wrong datum.
TEST(CommonShift, ASideOfZeroRaisesNoAlarm) {
  DeviationInputs inputs = grid(5, 4);
  inputs.model.covariance = isotropic(inputs.model.ids.size(), 0.05 * mm);
  for (auto& anchor : inputs.anchors)
    anchor.tolerances = tolerances_of({0.005, true, {parse_rule("*: vertical=+0/-5mm")}}, {});
  Normal normal(9);
  for (std::size_t i = 0; i < inputs.model.positions.size(); ++i)
    inputs.model.positions[i] += Eigen::Vector3d(normal(), normal(), normal()) * 0.05 * mm +
                                 Eigen::Vector3d(0, 0, -0.5 * mm) +
                                 Eigen::Vector3d(0, 0, inputs.anchors[i].floor == 2 ? -0.6 * mm : 0);
  const DeviationT result = judge_deviations(inputs, {});
  EXPECT_FALSE(result.common_shift->significant) << result.common_shift->words;
  // A side that is smaller than the other counts: 1 mm outward, of which half is worth saying.
  for (auto& anchor : inputs.anchors)
    anchor.tolerances = tolerances_of({0.005, true, {parse_rule("*: vertical=+5/-1mm")}}, {});
  EXPECT_TRUE(judge_deviations(inputs, {}).common_shift->significant);
}

/// On a measurement that contradicts itself nothing would pass; what is refused would not either.
TEST(CommonShift, WouldPassHoldsOfWhatCanPass) {
  DeviationInputs inputs = grid(5, 4);
  Normal normal(4);
  for (auto& p : inputs.model.positions)
    p += Eigen::Vector3d(6 * mm, 0, 0) + Eigen::Vector3d(normal(), normal(), normal()) * 0.3 * mm;
  const DeviationT sound = judge_deviations(inputs, {});
  ASSERT_TRUE(sound.common_shift->significant);
  EXPECT_EQ(sound.common_shift->would_pass, 20);
  inputs.anchors[3].refused = {{"a", "design", "b"}};
  EXPECT_EQ(judge_deviations(inputs, {}).common_shift->would_pass, 19);
  inputs.doubts = {test::doubt("contradicts itself")};
  const DeviationT doubted = judge_deviations(inputs, {});
  ASSERT_TRUE(doubted.common_shift->significant);
  EXPECT_EQ(doubted.common_shift->would_pass, 0);
  EXPECT_EQ(doubted.common_shift->words.find("would pass"), std::string::npos) << doubted.common_shift->words;
  for (const auto& group : doubted.group_shifts) {
    EXPECT_EQ(group->would_pass, 0);
    EXPECT_EQ(group->words.find("would pass"), std::string::npos) << group->words;
  }
}

TEST(GroupShifts, OnAMeasurementInDoubtDoNotSayWhatWouldPass) {
  DeviationInputs inputs = grid(5, 4);
  Normal normal(5);
  for (std::size_t i = 0; i < inputs.model.positions.size(); ++i) {
    inputs.model.positions[i] += Eigen::Vector3d(normal(), normal(), normal()) * 0.8 * mm;
    if (inputs.anchors[i].floor == 2) inputs.model.positions[i].z() -= 12 * mm;
  }
  inputs.doubts = {test::doubt("contradicts itself")};
  const DeviationT result = judge_deviations(inputs, {});
  ASSERT_TRUE(result.group_shifts.at(0)->significant);
  EXPECT_EQ(result.group_shifts[0]->would_pass, 0);
  EXPECT_EQ(result.group_shifts[0]->words.find("would pass"), std::string::npos) << result.group_shifts[0]->words;
}

TEST(AnchorJudgement, KeepsTheNoteOfTheMatch) {
  AnchorDeviationT out;
  out.note = "found by its tag";
  judge_anchor({0, 0, 0}, 1e-8 * Eigen::Matrix3d::Identity(), {},
               tolerances_of({0.005, true, {parse_rule("*: out_of_plane=4mm")}}, {}), {}, out);
  EXPECT_NE(out.note.find("found by its tag"), std::string::npos) << out.note;
  EXPECT_NE(out.note.find("nothing says which way it faces"), std::string::npos) << out.note;
}

TEST(Deviation, NothingPassesOnAMeasurementThatContradictsItself) {
  DeviationInputs inputs = grid(3, 3);
  inputs.model.positions[4].z() += 9 * mm;
  ASSERT_EQ(judge_deviations(inputs, {}).passed, 8);
  inputs.doubts = {test::doubt("wrong calibration", MeasurementPart::image_block)};
  const DeviationT result = judge_deviations(inputs, {});
  ASSERT_EQ(result.doubts.size(), 1u);
  EXPECT_EQ(result.doubts[0]->reason, "wrong calibration");
  EXPECT_EQ(result.passed, 0);
  EXPECT_EQ(result.undecided, 9);
  EXPECT_EQ(result.failed, 0) << "what proves nothing to be in order proves nothing to be out of it";
}

/// A floor passes by its worst anchor; that all of them are in order at once is less probable, and is told.
TEST(Deviation, AllAtOnceIsLessProbableThanEach) {
  DeviationInputs inputs = grid(2, 4);
  for (auto& p : inputs.model.positions) p.z() += 3.3 * mm;
  inputs.model.covariance = isotropic(inputs.model.ids.size(), 1 * mm);
  const DeviationT result = judge_deviations(inputs, {});
  ASSERT_EQ(result.passed, 8);
  double missed = 0;
  for (const auto& floor : result.floors) {
    EXPECT_EQ(floor->verdict, ToleranceVerdict::pass);
    double of_floor = 0;
    for (const auto& anchor : result.anchors)
      if (anchor->floor == floor->floor) of_floor += 1 - anchor->pass_probability;
    EXPECT_NEAR(floor->pass_together, 1 - of_floor, 1e-12);
    EXPECT_LT(floor->pass_together, 0.95) << "each passes with more than 95 %";
    missed += of_floor;
  }
  EXPECT_NEAR(result.pass_together, std::max(0.0, 1 - missed), 1e-12);
  inputs.model.positions[2].setConstant(std::nan(""));
  const DeviationT gap = judge_deviations(inputs, {});
  EXPECT_TRUE(std::isnan(gap.pass_together)) << "of what was not measured nobody knows";
  inputs = grid(2, 4), inputs.doubts = {test::doubt("contradicts itself")};
  EXPECT_TRUE(std::isnan(judge_deviations(inputs, {}).pass_together));
}

TEST(Mounting, RulesGoBeforeThePlateTableWhichGoesBeforeTheDefault) {
  const Mounting mounting{0.5 * mm,
                          {parse_mounting("class=IfcPlate: right=1mm, up=1mm, out=1mm"),
                           parse_mounting("batch=march & name~^A: out=0.002m")}};
  // A plate that faces east: its right is north, it looks out to the east.
  const Eigen::Quaterniond east((Eigen::Matrix3d() << 0, 0, 1, 1, 0, 0, 0, 1, 0).finished());
  ifc::ElementFacts anchor;
  const auto sigmas = [&](const std::vector<double>& of_plate) {
    const Eigen::Matrix3d c = mounting.covariance(anchor, of_plate, east);
    EXPECT_LT((c - Eigen::Matrix3d(c.diagonal().asDiagonal())).norm(), 1e-18);
    return Eigen::Vector3d(c.diagonal().cwiseSqrt() / mm);
  };
  EXPECT_LT((sigmas({}) - Eigen::Vector3d(0.5, 0.5, 0.5)).norm(), 1e-9);
  EXPECT_LT((sigmas({0.1 * mm, 0.2 * mm, 0.3 * mm}) - Eigen::Vector3d(0.3, 0.1, 0.2)).norm(), 1e-9);
  anchor.name = "A1", anchor.batch = "march";
  EXPECT_LT((sigmas({0.1 * mm, 0.2 * mm, 0.3 * mm}) - Eigen::Vector3d(2, 0.1, 0.2)).norm(), 1e-9);
  anchor.ifc_class = "IfcPlate", anchor.name = "B1";
  EXPECT_LT((sigmas({0.1 * mm, 0.2 * mm, 0.3 * mm}) - Eigen::Vector3d(1, 1, 1)).norm(), 1e-9);
  EXPECT_EQ(mounting.words(2), "0.5 mm on each axis of a plate; 2 plates by the plate table; " +
                                   mounting.rules[0].text + "; " + mounting.rules[1].text);
  EXPECT_EQ(Mounting{}.words(0), "");
  for (const char* wrong : {"*", "*: 1mm", "*: up", "*: up=1", "*: up=-1mm", "*: x=1mm", "*: up=101mm", "y=z: up=1mm"})
    EXPECT_THROW(parse_mounting(wrong), std::runtime_error) << wrong;
}

/// What nobody measures is in the anchor's uncertainty, and hides what it is larger than.
TEST(Mounting, IsPartOfTheAnchorsUncertaintyAndOfPanelsAndVerdicts) {
  DeviationInputs inputs = grid(3, 3);
  inputs.model.positions[4].z() += 4.2 * mm;  // + 1.645 × 0.4 mm = 4.86 mm
  inputs.model.positions[5].z() += 6 * mm;
  EXPECT_EQ(judge_deviations(inputs, {}).anchors[4]->verdict, ToleranceVerdict::pass);
  inputs.mounting = "0.5 mm";
  inputs.anchors[4].mounting = Eigen::Vector3d(0, 0, 0.5 * mm).cwiseAbs2().asDiagonal();  // √(0.16 + 0.25) = 0.64 mm
  const DeviationT result = judge_deviations(inputs, {});
  EXPECT_EQ(result.anchors[4]->verdict, ToleranceVerdict::undecided);
  EXPECT_NEAR(axis(*result.anchors[4], "vertical").u, std::sqrt(0.41) * mm, 1e-9);
  EXPECT_NEAR(axis(*result.anchors[4], "horizontal").u, 0.4 * mm, 1e-9);
  EXPECT_NEAR(result.anchors[4]->covariance[8], 0.41e-6, 1e-12);
  EXPECT_NEAR(axis(*result.anchors[5], "vertical").u, 0.4 * mm, 1e-9);
  EXPECT_EQ(result.mounting, "0.5 mm");
}

TEST(Deviation, AnchorsInEachOthersPlaceAreNamed) {
  DeviationInputs inputs = grid(3, 3);
  EXPECT_TRUE(judge_deviations(inputs, {}).warnings.empty());
  std::swap(inputs.model.positions[2], inputs.model.positions[5]);
  const DeviationT result = judge_deviations(inputs, {});
  ASSERT_FALSE(result.warnings.empty());
  EXPECT_EQ(result.warnings[0], inputs.anchors[2].id + " and " + inputs.anchors[5].id +
                                    " were measured in each other's place: their plates are exchanged in the plate "
                                    "table, or on the facade.");
}

TEST(Deviation, FloorsSharingAStoreyCostTheStoreyOnly) {
  DeviationInputs inputs = grid(3, 3);
  for (auto& anchor : inputs.anchors) anchor.storey_guid = anchor.floor == 3 ? "top" : "hall";
  const DeviationT result = judge_deviations(inputs, {});
  ASSERT_EQ(result.floors.size(), 3u);
  EXPECT_EQ(result.floors[0]->storey_guid, "");
  EXPECT_EQ(result.floors[2]->storey_guid, "top");
  EXPECT_EQ(result.passed, 9);
  EXPECT_NE(result.warnings.at(0).find("2 floors of the plate table have their anchors in one storey"),
            std::string::npos);
}

TEST(Deviation, PointsOfAnotherFrameAreRefused) {
  DeviationInputs inputs = grid(3, 2);
  for (auto& p : inputs.model.positions) p += Eigen::Vector3d(691000, 5335000, 500);
  EXPECT_THROW(judge_deviations(inputs, {}), std::runtime_error);
}

TEST(Deviation, WhatHasNoElementOrNoMeasurementIsListedWithTheReason) {
  DeviationInputs inputs = grid(3, 1);
  inputs.model.positions[1].setConstant(std::nan(""));
  inputs.anchors[2].element.guid.clear(), inputs.anchors[2].design.setConstant(std::nan(""));
  const DeviationT result = judge_deviations(inputs, {});
  EXPECT_EQ(result.anchors[1]->note, "not measured");
  EXPECT_EQ(result.anchors[2]->note, "no element of the design fits");
  EXPECT_EQ(result.verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(result.not_measured, 2);
}

/// JCGM 106: with k = 1.645 an item just out of tolerance passes in at most 5 % of measurements, per axis and in space.
TEST(Deviation, FalsePassesKeepTheGuardBandsPromise) {
  const ToleranceTable tables[] = {{5 * mm, false, {parse_rule("*: horizontal=0mm")}},
                                   {5 * mm, false, {parse_rule("*: vertical=0mm")}},
                                   {5 * mm, false, {parse_rule("*: horizontal=0mm, vertical=0mm, out_of_plane=5mm")}},
                                   {5 * mm, false, {parse_rule("*: horizontal=0mm, vertical=0mm, in_plane=5mm")}},
                                   {5 * mm, false, {parse_rule("*: horizontal=0mm, vertical=0mm, space=5mm")}}};
  const Eigen::Vector3d truths[] = {{0, 0, 5.0001 * mm},
                                    {3.5357 * mm, 3.5357 * mm, 0},
                                    {0, -5.0001 * mm, 0},
                                    {4.001 * mm, 0, 3 * mm},
                                    {3 * mm, 3 * mm, 2.6459 * mm}};
  Normal normal(1);
  for (std::size_t i = 0; i < 5; ++i) {
    const Tolerances tolerances = tolerances_of(tables[i], {});
    int passed = 0;
    for (int trial = 0; trial < 1000; ++trial) {
      const Eigen::Vector3d noise(normal(), normal(), normal());
      passed += judge(truths[i] + noise * 0.5 * mm, 0.5 * mm, tolerances, 1.645).verdict == ToleranceVerdict::pass;
    }
    EXPECT_LE(passed, 70) << i;  // 50 expected at most, plus three standard deviations
  }
}

}  // namespace test_deviation
}  // namespace plumbline::judgement

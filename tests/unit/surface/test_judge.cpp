// Verdicts of panels and joints: each the last rule's, none where nothing was measured, and as many wrong ones as the
// risk allows.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "building/ifc/enlarged_surfaces.hpp"
#include "building/judgement/surfaces.hpp"
#include "geometry/packed_symmetric.hpp"
#include "surface/dense/straightedge.hpp"

namespace plumbline::judgement {
namespace test_judge {

std::unique_ptr<PanelSurfaceFiguresT> panel(const std::string& name, double gap, double sigma) {
  auto result = std::make_unique<PanelSurfaceFiguresT>();
  result->face = std::make_unique<SurfaceFaceT>();
  result->face->id = name, result->face->guid = name + "-guid";
  result->face->origin = {2.0 * (name[0] - 'A'), 0, 0}, result->face->width = 1.5, result->face->height = 1.2;
  result->face->right = {1, 0, 0}, result->face->up = {0, 0, 1}, result->face->out = {0, -1, 0};
  result->offset = 0, result->tilt = {0, 0};
  auto entry = std::make_unique<SurfaceGapT>();
  entry->length = 1, entry->gap = gap, entry->sigma = sigma, entry->positions = 10;
  result->flatness.push_back(std::move(entry));
  result->form = {0.001, -0.002, 0.0005}, result->form_sigma = {3e-4, 4e-4, 1e-4};
  Eigen::Matrix<double, 6, 6> random = Eigen::Matrix<double, 6, 6>::Identity() * 1e-8;
  random(3, 3) = 9e-8, random(4, 4) = 7e-8, random(5, 5) = 1e-8;
  result->coefficients_random = pack_symmetric(random);
  result->coefficients_factor = {0, 0, 0, 0, 3e-4, 0};  // rank 1: of the second bow
  return result;
}

std::unique_ptr<JointFiguresT> joint(const std::vector<double>& widths, double sigma) {
  auto result = std::make_unique<JointFiguresT>();
  result->first = "A", result->second = "B", result->nominal_width = 0.012,
  result->looked_at = static_cast<int>(widths.size());
  for (size_t i = 0; i < widths.size(); ++i) {
    auto place = std::make_unique<JointPlaceT>();
    place->along = 0.02 * static_cast<double>(i), place->width = widths[i], place->width_sigma = sigma;
    place->step = std::nan(""), place->step_sigma = std::nan("");
    result->places.push_back(std::move(place));
  }
  return result;
}

SurfacesT surfaces() {
  SurfacesT result;
  result.rank = 1;
  for (const char* name : {"A", "B", "C"}) result.panels.push_back(panel(name, 0.002, 2e-4));
  result.panels[2]->not_measured = "no point was measured on it";
  return result;
}

SurfaceJudgementT judged(const SurfacesT& what, const std::vector<std::string>& rules, double risk = 0.05) {
  std::vector<SurfaceRule> parsed;
  for (const auto& rule : rules) parsed.push_back(parse_surface_rule(rule));
  std::map<std::string, ifc::ElementFacts> facts;
  for (const char* name : {"A", "B", "C"})
    facts[std::string(name) + "-guid"] = {"IfcPlate", std::string(name) + "-guid",           name, "", "",
                                          "",         name[0] == 'A' ? "Level 1" : "Level 2"};
  return judge_surfaces(what, facts, parsed, risk);
}

TEST(JudgeSurfaces, FlatnessByTheLastRuleThatSelects) {
  const auto result =
      judged(surfaces(), {"*: flatness(1m)=3mm", "storey=Level 2: flatness(1m)=1mm", "*: flatness(2m)=4mm"});
  ASSERT_EQ(result.verdicts.size(), 6U);
  EXPECT_EQ(result.verdicts[0]->verdict, ToleranceVerdict::pass);
  EXPECT_NEAR(result.verdicts[0]->probability, 1, 1e-6);
  EXPECT_NE(result.verdicts[1]->not_judged.find("straightedges"), std::string::npos)
      << "no straightedge of 2 m was laid";
  EXPECT_EQ(result.verdicts[2]->verdict, ToleranceVerdict::fail);
  EXPECT_EQ(result.verdicts[2]->rule, "storey=Level 2: flatness(1m)=1mm");
  EXPECT_EQ(result.verdicts[4]->verdict, ToleranceVerdict::not_measured);
  EXPECT_EQ(result.verdicts[4]->not_judged, "no point was measured on it");
  EXPECT_EQ(result.passed, 1);
  EXPECT_EQ(result.failed, 1);
  EXPECT_EQ(result.not_judged, 4);
}

/// Half of a panel is no panel: a scan that ends there says nothing of the other half, unless what it saw fails.
TEST(JudgeSurfaces, WhatWasHalfSeenDoesNotPass) {
  SurfacesT what = surfaces();
  what.panels[0]->coverage = 0.48, what.panels[1]->coverage = 0.8;
  const auto result = judged(what, {"*: flatness(1m)=3mm"});
  EXPECT_EQ(result.verdicts[0]->verdict, ToleranceVerdict::not_measured);
  EXPECT_EQ(result.verdicts[0]->not_judged,
            "its limit is kept where points are, and they cover 48 % of it: what the rest is nobody saw");
  EXPECT_EQ(result.verdicts[1]->verdict, ToleranceVerdict::pass);
  const auto bows = judged(what, {"*: bow=9mm, twist=3mm"});
  EXPECT_EQ(bows.verdicts[0]->verdict, ToleranceVerdict::not_measured);
  EXPECT_EQ(bows.verdicts[1]->verdict, ToleranceVerdict::not_measured) << "twist of the same panel";
  EXPECT_EQ(bows.verdicts[2]->verdict, ToleranceVerdict::pass);
  EXPECT_EQ(judged(what, {"*: bow=0.5mm"}).verdicts[0]->verdict, ToleranceVerdict::fail);
  what.panels[0]->flatness[0]->gap = 0.009;
  EXPECT_EQ(judged(what, {"*: flatness(1m)=3mm"}).verdicts[0]->verdict, ToleranceVerdict::fail);
}

TEST(JudgeSurfaces, NearTheLimitItIsUndecided) {
  SurfacesT what = surfaces();
  what.panels[0]->flatness[0]->gap = 0.0029, what.panels[1]->flatness[0]->gap = 0.0031;
  const auto result = judged(what, {"*: flatness(1m)=3mm"});
  EXPECT_EQ(result.verdicts[0]->verdict, ToleranceVerdict::undecided);
  EXPECT_NEAR(result.verdicts[0]->probability, 0.6915, 1e-3);
  EXPECT_EQ(result.verdicts[1]->verdict, ToleranceVerdict::undecided);
}

TEST(JudgeSurfaces, BowTakesBothDirectionsAndTheSystematicPart) {
  const auto result = judged(surfaces(), {"*: bow=2.6mm, twist=0.4mm"});
  EXPECT_NEAR(result.verdicts[0]->value, -0.002, 1e-12);
  EXPECT_NEAR(result.verdicts[0]->sigma, 4e-4, 1e-12) << "7e-8 random and 9e-8 systematic";
  EXPECT_EQ(result.verdicts[0]->verdict, ToleranceVerdict::undecided);
  EXPECT_NEAR(result.verdicts[0]->probability, 0.933, 0.01);
  EXPECT_EQ(result.verdicts[1]->verdict, ToleranceVerdict::undecided);
  EXPECT_NEAR(result.verdicts[1]->probability, 0.159, 0.005);
}

TEST(JudgeSurfaces, JointsByTheirWorstPlace) {
  SurfacesT what = surfaces();
  what.joints.push_back(joint({0.012, 0.013, 0.0151, 0.012}, 1e-4));
  const auto result =
      judged(what, {"name=A: joint=+3/-4mm, narrowest=8mm, widest=20mm, step=2mm", "name=C: joint=1mm"});
  ASSERT_EQ(result.verdicts.size(), 4U);
  EXPECT_NEAR(result.verdicts[0]->value, 0.0031, 1e-12) << "against the width of the design";
  EXPECT_NEAR(result.verdicts[0]->along, 0.04, 1e-12);
  EXPECT_EQ(result.verdicts[0]->verdict, ToleranceVerdict::undecided)
      << "3.1 ± 0.1 mm, the worst of four places, against 3 mm";
  EXPECT_EQ(result.verdicts[1]->verdict, ToleranceVerdict::pass);
  EXPECT_EQ(result.verdicts[2]->verdict, ToleranceVerdict::pass);
  EXPECT_EQ(result.verdicts[3]->not_judged, "one of its panels was not measured");
  what.joints[0]->places[2]->width = 0.0154;
  EXPECT_EQ(judged(what, {"*: joint=3mm"}).verdicts[0]->verdict, ToleranceVerdict::fail);
}

/// Neighbours that moved together are flush and have joints as designed: where they are is a question of its own.
TEST(JudgeSurfaces, PanelsThatMovedTogetherAreTold) {
  SurfacesT what = surfaces();
  Eigen::Matrix3d plane = Eigen::Matrix3d::Zero();
  plane.diagonal() << 4e-8, 1e-8, 1e-8;
  for (auto& panel : what.panels)
    panel->offset = 0.008, panel->tilt = {0.001, 0}, panel->covariance = pack_symmetric(plane);
  what.panels[1]->offset = 0.0042;
  what.joints.push_back(joint({0.012, 0.012}, 1e-4));
  for (auto& place : what.joints[0]->places) place->step = 0, place->step_sigma = 1e-4, place->shift = 0.007;
  for (auto& place : what.joints[0]->places) place->shift_sigma = 2e-4;
  const auto result = judged(what, {"*: offset=+5/-10mm, shift=6mm, joint=2mm, step=1mm"});
  ASSERT_EQ(result.verdicts.size(), 6U);
  EXPECT_EQ(result.verdicts[0]->verdict, ToleranceVerdict::fail);
  EXPECT_NEAR(result.verdicts[0]->value, 0.00875, 1e-12) << "the right corners: half a width of 1.5 m further out";
  EXPECT_NEAR(result.verdicts[0]->sigma, std::sqrt(4e-8 + 0.75 * 0.75 * 1e-8 + 0.6 * 0.6 * 1e-8), 1e-9);
  EXPECT_EQ(result.verdicts[1]->verdict, ToleranceVerdict::undecided) << "4.95 ± 0.22 mm";
  std::map<std::string, ToleranceVerdict> of_joint;
  for (const auto& verdict : result.verdicts)
    if (!verdict->second.empty()) of_joint[verdict->quantity] = verdict->verdict;
  EXPECT_EQ(of_joint.at("shift"), ToleranceVerdict::fail);
  EXPECT_EQ(of_joint.at("joint"), ToleranceVerdict::pass);
  EXPECT_EQ(of_joint.at("step"), ToleranceVerdict::pass);
}

TEST(JudgeSurfaces, WhereNobodySaysWhereTheMeasurementLiesItsPlaceIsNotJudged) {
  SurfacesT what = surfaces();
  what.rank = 0;
  for (auto& panel : what.panels) panel->coefficients_factor.clear();
  what.joints.push_back(joint({0.012, 0.012}, 1e-4));
  const auto result = judged(what, {"*: offset=5mm, shift=6mm"});
  EXPECT_EQ(result.passed, 0);
  EXPECT_NE(result.verdicts[0]->not_judged.find("'place_sigma'"), std::string::npos) << result.verdicts[0]->not_judged;
  EXPECT_NE(result.verdicts.back()->not_judged.find("nobody said"), std::string::npos);
}

/// A scanner's beam makes all places of a joint too wide, or too narrow, alike: it is one chance, and not one a place.
TEST(JudgeSurfaces, WhatAllPlacesShareIsOneChance) {
  SurfacesT what = surfaces();
  what.joint_rank = 1;
  what.joints.push_back(joint(std::vector<double>(20, 0.012), std::hypot(2e-3, 1e-4)));
  for (auto& place : what.joints[0]->places) place->width_random = 1e-4, place->width_factor = {2e-3};
  const auto at_limit = [&](const std::string& rule) { return judged(what, {rule}); };
  EXPECT_NEAR(at_limit("*: joint=4mm").verdicts[0]->probability, 0.954, 0.015) << "and some chance of a place";
  EXPECT_EQ(at_limit("*: joint=5mm").verdicts[0]->verdict, ToleranceVerdict::pass);
  for (auto& place : what.joints[0]->places) place->views = 3;
  EXPECT_LT(at_limit("*: joint=4mm").verdicts[0]->probability, 0.1) << "in photographs nobody says that it is one";
}

/// How far a scan lies beside its place is one error of all places of a joint, not one a place: sound joints were
/// undecided with "kept with 20 %", and those that are out did not fail.
TEST(JudgeSurfaces, ThePlaceOfTheScanIsOneErrorOfAJointsShift) {
  const auto shifted = [&](double shift, double place_sigma, double own, int views) {
    SurfacesT what = surfaces();
    what.joints.push_back(joint(std::vector<double>(60, 0.012), 1e-4));
    for (auto& place : what.joints[0]->places) {
      place->shift = shift, place->shift_sigma = std::hypot(place_sigma, own);
      place->width_random = 2 * own, place->views = views;
    }
    return std::pair(judged(what, {"*: shift=5mm"}).verdicts[0]->verdict,
                     judged(what, {"*: shift=5mm"}).verdicts[0]->probability);
  };
  for (const int views : {0, 3}) {
    EXPECT_NEAR(shifted(0, 2e-3, 3e-4, views).second, 0.97, 0.01);
    EXPECT_EQ(shifted(0, 2e-3, 3e-4, views).first, ToleranceVerdict::pass);
    EXPECT_EQ(shifted(0.002, 1e-3, 3e-4, views).first, ToleranceVerdict::pass);
    EXPECT_EQ(shifted(0.0082, 1e-3, 3e-4, views).first, ToleranceVerdict::fail);
    EXPECT_EQ(shifted(0.0182, 1e-3, 3e-4, views).first, ToleranceVerdict::fail);
    EXPECT_EQ(shifted(-0.0082, 1e-3, 3e-4, views).first, ToleranceVerdict::fail);
    EXPECT_EQ(shifted(0.0062, 1e-3, 3e-4, views).first, ToleranceVerdict::undecided);
    EXPECT_EQ(shifted(0.0042, 1e-3, 3e-4, views).first, ToleranceVerdict::undecided);
  }
}

/// From the last point to an edge it is an exponential's way: the worst of many places is further off than normal.
TEST(JudgeSurfaces, JointsOfAScanDoNotFailByTheTailsOfTheirEdges) {
  std::mt19937_64 random(5);
  std::exponential_distribution<double> way(1);
  constexpr int trials = 400, places = 20;
  constexpr double mean = 5e-4;
  int failed = 0;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<double> widths;
    for (int i = 0; i < places; ++i) widths.push_back(0.0149 + mean * (way(random) + way(random) - 2));
    SurfacesT what = surfaces();
    what.joints.push_back(joint(widths, std::sqrt(2) * mean));
    for (auto& place : what.joints[0]->places) place->width_random = place->width_sigma;
    failed += judged(what, {"*: joint=3mm"}).verdicts[0]->verdict == ToleranceVerdict::fail;
  }
  EXPECT_LE(failed, 0.05 * trials + 3 * std::sqrt(0.05 * trials));
}

TEST(JudgeSurfaces, AJointThatIsClosedSomewhereDoesNotPass) {
  SurfacesT what = surfaces();
  what.joints.push_back(joint(std::vector<double>(14, 0.012), 1e-4));
  what.joints[0]->looked_at = 19, what.joints[0]->closed = 5;
  const auto result = judged(what, {"*: joint=3mm, narrowest=8mm"});
  for (const auto& verdict : result.verdicts) {
    EXPECT_EQ(verdict->verdict, ToleranceVerdict::not_measured);
    EXPECT_NE(verdict->not_judged.find("at 5 of 19 places along it no gap is to be seen"), std::string::npos);
  }
}

/// Somebody goes there to look.
TEST(JudgeSurfaces, TheNarrowestPlaceIsTheNarrowestOneWhereAllKeepTheLimit) {
  SurfacesT what = surfaces();
  what.joints.push_back(joint({0.012, 0.0092, 0.025, 0.020}, 3e-4));
  what.joints[0]->places[2]->width_sigma = 0.008;
  const auto result = judged(what, {"*: narrowest=1mm, widest=60mm"});
  ASSERT_EQ(result.verdicts.size(), 2U);
  EXPECT_EQ(result.verdicts[0]->verdict, ToleranceVerdict::pass);
  EXPECT_NEAR(result.verdicts[0]->value, 0.0092, 1e-12);
  EXPECT_NEAR(result.verdicts[0]->along, 0.02, 1e-12);
  EXPECT_LT(result.verdicts[0]->probability, 0.9999) << "the probability is of all places";
  EXPECT_NEAR(result.verdicts[1]->value, 0.025, 1e-12);
}

/// An expansion joint of 80 mm is as built, and a rule of the width itself that means the others has nothing to say of
/// it.
TEST(JudgeSurfaces, AnAbsoluteWidthThatTheDesignDoesNotKeepIsNotAskedOfIt) {
  SurfacesT what = surfaces();
  what.joints.push_back(joint({0.012, 0.013}, 1e-4));
  what.joints.push_back(joint({0.080, 0.081}, 1e-4));
  what.joints[1]->nominal_width = 0.08, what.joints[1]->first = "B", what.joints[1]->second = "C";
  const auto result = judged(what, {"*: narrowest=8mm, widest=20mm, joint=4mm"});
  EXPECT_EQ(result.failed, 0);
  EXPECT_EQ(result.passed, 5) << "of the expansion joint the narrowest place and the width against the design's";
  ASSERT_EQ(result.remarks.size(), 1U);
  EXPECT_EQ(result.remarks[0].rfind("widest = 20 mm is not asked of 1 joint which the design itself has outside of it, "
                                    "B | C with 80 mm for one",
                                    0),
            0U)
      << result.remarks[0];
  EXPECT_EQ(result.requests[0]->not_judged, "");
  what.joints.erase(what.joints.begin());
  EXPECT_NE(judged(what, {"*: widest=20mm"}).requests[0]->not_judged.find("the design has all of its joints outside"),
            std::string::npos)
      << "a rule that is asked of none holds nothing";
}

/// By 18 of the standard deviations that are stated of the place: what rests on it is not decided, and nothing else.
TEST(JudgeSurfaces, WhatLiesBesideItsPlaceAsAWholeLeavesOffsetsAndShiftsOpen) {
  SurfacesT what = surfaces();
  for (const auto& one : what.panels)
    one->covariance = pack_symmetric(Eigen::Matrix3d(Eigen::Matrix3d::Identity() * 1e-8));
  what.joints.push_back(joint({0.012, 0.012}, 1e-4));
  for (const auto& place : what.joints[0]->places) place->shift = 0.0062, place->shift_sigma = 5e-4;
  EXPECT_EQ(judged(what, {"*: offset=4mm, shift=4mm"}).failed, 1);
  what.beside_its_place = "all 3 panels lie 9.0 ± 0.5 mm before their place";
  const auto result = judged(what, {"*: offset=4mm, shift=4mm, joint=3mm, bow=9mm"});
  EXPECT_EQ(result.failed, 0);
  for (const auto& verdict : result.verdicts) {
    if (verdict->panel == "C") continue;
    const bool of_place = verdict->quantity == "offset" || verdict->quantity == "shift";
    EXPECT_EQ(verdict->not_judged.find("lies beside its place alike") != std::string::npos, of_place)
        << verdict->quantity << ": " << verdict->not_judged;
  }
  EXPECT_NE(result.requests[0]->not_judged, "") << "exit code 3";
}

/// Joints 3 mm to the right alike left all offsets of all facades open, and panels that keep their limit either way.
TEST(JudgeSurfaces, WhatLiesBesideItsPlaceIsJudgedWhereItComesToTheSameEitherWay) {
  SurfacesT what = surfaces();
  for (const auto& one : what.panels)
    one->covariance = pack_symmetric(Eigen::Matrix3d(Eigen::Matrix3d::Identity() * 1e-8)), one->offset = 0.003;
  what.joints.push_back(joint({0.012, 0.012}, 1e-4));
  what.joints[0]->upright = true, what.joints[0]->first_panel = 0;
  for (const auto& place : what.joints[0]->places) place->shift = 0.0032, place->shift_sigma = 2e-4;
  what.beside_its_place = "all 3 upright joints lie 3.0 ± 0.1 mm to the right of their place";
  what.beside.push_back(std::make_unique<BesidePlaceT>());
  BesidePlaceT& beside = *what.beside[0];
  beside.facade = {0, -1, 0}, beside.right = 0.003;
  const auto verdict = [&](const std::string& quantity, const std::string& limit) {
    const auto result = judged(what, {"*: " + quantity + "=" + limit});
    const SurfaceVerdictT& first = *result.verdicts[0];
    return first.not_judged.empty() ? std::string(EnumNameToleranceVerdict(first.verdict)) : "not judged";
  };
  EXPECT_EQ(verdict("offset", "10mm"), "pass");
  EXPECT_EQ(verdict("offset", "1mm"), "fail") << "nothing is said of the way out";
  EXPECT_EQ(verdict("shift", "10mm"), "pass") << "3.2 or 0.2";
  EXPECT_EQ(verdict("shift", "2mm"), "not judged") << "3.2 fails, 0.2 does not";
  beside.right = 0.006;
  EXPECT_EQ(verdict("shift", "2mm"), "not judged") << "3.2 and -2.8 mm both fail, and what lies between does not";
  beside.right = std::nan(""), beside.out = 0.003;
  EXPECT_EQ(verdict("shift", "2mm"), "fail");
  EXPECT_EQ(verdict("offset", "10mm"), "pass");
  EXPECT_EQ(verdict("offset", "1mm"), "not judged");
  beside.out = 0.006;
  EXPECT_EQ(verdict("offset", "1mm"), "not judged") << "3 and -3 mm both fail, and what lies between does not";
  what.panels[0]->offset = 0.012;
  EXPECT_EQ(verdict("offset", "5mm"), "fail") << "12 or 6";
  beside.facade = {1, 0, 0};
  what.panels[0]->offset = 0.003;
  EXPECT_EQ(verdict("offset", "1mm"), "fail") << "another facade";
}

TEST(JudgeSurfaces, TheWorstPlaceIsTheFurthestWhereAllFail) {
  SurfacesT what = surfaces();
  what.joints.push_back(joint({0.030, 0.034, 0.031}, 1e-4));
  EXPECT_NEAR(judged(what, {"*: joint=3mm"}).verdicts[0]->value, 0.022, 1e-12);
}

TEST(JudgeSurfaces, WhatIsSmallerThanItsCellsDoesNotPassAsFlat) {
  SurfacesT what = surfaces();
  what.panels[0]->hidden = 0.004, what.panels[1]->hidden = 0.0005;
  const auto result = judged(what, {"*: flatness(1m)=3mm"});
  EXPECT_EQ(result.verdicts[0]->verdict, ToleranceVerdict::not_measured);
  EXPECT_NE(result.verdicts[0]->not_judged.find("waves of 4.0 mm"), std::string::npos);
  EXPECT_EQ(result.verdicts[1]->verdict, ToleranceVerdict::pass);
}

/// Joints of forty places whose true width lies just within, or just beyond, the limit: wrong verdicts stay within the
/// risk whether errors are each place's own or common to all.
TEST(JudgeSurfaces, WrongVerdictsStayWithinTheRisk) {
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0, 1);
  constexpr int trials = 1500;
  constexpr double sigma = 2e-4, tiny = 1e-6;
  for (bool common : {false, true}) {
    int failed_good = 0, passed_bad = 0;
    for (int trial = 0; trial < trials; ++trial) {
      std::vector<double> good, bad;
      const double z = normal(random);
      for (int i = 0; i < 40; ++i) {
        const double error = sigma * (common ? z : normal(random));
        good.push_back(0.015 - tiny + error), bad.push_back((i == 20 ? 0.015 + tiny : 0.013) + error);
      }
      SurfacesT what = surfaces();
      what.joints.push_back(joint(good, sigma)), what.joints.push_back(joint(bad, sigma));
      const auto result = judged(what, {"*: joint=3mm"});
      failed_good += result.verdicts[0]->verdict == ToleranceVerdict::fail;
      passed_bad += result.verdicts[1]->verdict == ToleranceVerdict::pass;
    }
    EXPECT_LE(failed_good, 0.05 * trials + 3 * std::sqrt(0.05 * trials)) << common;
    EXPECT_LE(passed_bad, 0.05 * trials + 3 * std::sqrt(0.05 * trials)) << common;
  }
}

TEST(JudgeSurfaces, ARuleThatSelectsNothingIsSaid) {
  const auto result = judged(surfaces(), {"storey=Roof: bow=1mm"});
  ASSERT_EQ(result.requests.size(), 1U);
  EXPECT_EQ(result.requests[0]->not_judged, "it selects no panel that was looked at");
  EXPECT_TRUE(result.verdicts.empty());
}

TEST(JudgeSurfaces, APanelThatNobodyLookedAtIsNotJudged) {
  SurfacesT what = surfaces();
  what.panels.erase(what.panels.begin() + 1);
  const auto left_out = [&](const std::string& id, const std::string& guid, const std::string& reason) {
    what.left_out.push_back(std::make_unique<SurfaceLeftOutT>());
    what.left_out.back()->id = id, what.left_out.back()->guid = guid, what.left_out.back()->reason = reason;
  };
  left_out("B", "B-guid", "nothing looks at it and the design does not say which side is outside");
  left_out("B", "of another panel of that name", "the design gives no shape that a face could be taken from");
  const auto result = judged(what, {"*: flatness(1m)=3mm", "name=A: bow=3mm"});
  EXPECT_EQ(result.not_judged, 2) << "B, and C that has no points";
  EXPECT_NE(result.requests[0]->not_judged.find("B"), std::string::npos) << result.requests[0]->not_judged;
  EXPECT_EQ(result.requests[1]->not_judged, "");
  const auto verdict =
      std::find_if(result.verdicts.begin(), result.verdicts.end(), [](const auto& v) { return v->panel == "B"; });
  ASSERT_NE(verdict, result.verdicts.end());
  EXPECT_EQ((*verdict)->not_judged, "nothing looks at it and the design does not say which side is outside");
}

/// A rule of joints alone passed by the joints of the others.
TEST(JudgeSurfaces, NorAreTheJointsOfAPanelThatWasLeftOut) {
  SurfacesT what = surfaces();
  what.panels.erase(what.panels.begin() + 1);
  what.left_out.push_back(std::make_unique<SurfaceLeftOutT>());
  what.left_out[0]->id = "B", what.left_out[0]->guid = "B-guid", what.left_out[0]->reason = "it is no rectangle";
  EXPECT_NE(judged(what, {"*: joint=3mm"}).requests[0]->not_judged.find("no joint was looked at"), std::string::npos);
  what.joints.push_back(joint(std::vector<double>(14, 0.012), 1e-4));
  what.joints[0]->second = "C";
  const auto result = judged(what, {"*: joint=3mm"});
  EXPECT_EQ(result.not_judged, 1);
  EXPECT_NE(result.requests[0]->not_judged.find("B (none of its joints was looked at: it is no rectangle)"),
            std::string::npos)
      << result.requests[0]->not_judged;
}

TEST(JudgeSurfaces, WhatFitsLessWellIsLessCertain) {
  SurfacesT what = surfaces();
  what.panels[0]->flatness[0]->gap = 0.0026;
  what.joints.push_back(joint({0.012, 0.0145}, 1e-4));
  EXPECT_EQ(judged(what, {"*: flatness(1m)=3mm, bow=3mm, joint=3mm"}).verdicts[0]->verdict, ToleranceVerdict::pass);
  ifc::enlarge(what, 9);
  const auto result = judged(what, {"*: flatness(1m)=3mm, bow=3mm, joint=3mm"});
  EXPECT_EQ(result.verdicts[0]->verdict, ToleranceVerdict::undecided);
  EXPECT_NEAR(result.verdicts[0]->sigma, 6e-4, 1e-12);
  EXPECT_NEAR(result.verdicts[1]->sigma, 1.2e-3, 1e-12) << "bow: random and systematic part";
  EXPECT_NEAR(result.verdicts.back()->sigma, 3e-4, 1e-12);
}

TEST(JudgeSurfaces, RulesThatAreNoneAreQuoted) {
  for (const char* rule : {"*: flatness=3mm", "*: flatness(3)=3mm", "*: bow=3", "*: bow=-3mm", "*: width=3mm",
                           "*: bow(1m)=3mm", "*: step=+3/-1mm", "flatness(1m)=3mm", "*: bow=3m", "*:"}) {
    try {
      parse_surface_rule(rule);
      ADD_FAILURE() << rule;
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find(rule), std::string::npos) << error.what();
    }
  }
  const SurfaceRule rule = parse_surface_rule("class=IfcPlate: joint=+4/-3mm, flatness(100mm)=1mm");
  EXPECT_NEAR(rule.limits[0].upper, 0.004, 1e-15);
  EXPECT_NEAR(rule.limits[0].lower, -0.003, 1e-15);
  EXPECT_NEAR(rule.limits[1].length, 0.1, 1e-15);
}

TEST(JudgeSurfaces, ARuleOfWhichNothingOrNotAllIsJudgedSaysSo) {
  SurfacesT what = surfaces();
  const auto without = judged(what, {"*: step=2mm, joint=3mm", "name=A: flatness(1m)=3mm"});
  ASSERT_EQ(without.requests.size(), 2U);
  EXPECT_NE(without.requests[0]->not_judged.find("step: no joint was looked at"), std::string::npos)
      << without.requests[0]->not_judged;
  EXPECT_NE(without.requests[0]->not_judged.find("joint: no joint"), std::string::npos);
  EXPECT_EQ(without.requests[1]->not_judged, "");
  what.joints.push_back(joint({0.012, 0.012}, 1e-4));
  EXPECT_NE(
      judged(what, {"name=C: joint=3mm"}).requests[0]->not_judged.find("no joint lies at a panel that it selects"),
      std::string::npos);
  const auto partly = judged(what, {"*: flatness(1m)=3mm, flatness(2m)=4mm"});
  EXPECT_NE(partly.requests[0]->not_judged.find("flatness(1m): 1 of 3 are not judged: C (no point was measured on it)"),
            std::string::npos)
      << partly.requests[0]->not_judged;
  EXPECT_NE(partly.requests[0]->not_judged.find("flatness(2m): 3 of 3 are not judged: A, B, C"), std::string::npos);
  // What a later rule judges is judged.
  const auto later = judged(what, {"*: flatness(1m)=3mm", "name=C: bow=1mm", "name=A: flatness(1m)=2.5mm"});
  EXPECT_EQ(later.requests[2]->not_judged, "");
}

TEST(JudgeSurfaces, AJointPassesOnlyIfItWasSeenAlongEnoughOfIt) {
  SurfacesT what = surfaces();
  what.joints.push_back(joint({0.012}, 1e-4));
  what.joints[0]->looked_at = 150;
  const auto result = judged(what, {"*: joint=3mm"});
  EXPECT_EQ(result.passed, 0);
  EXPECT_EQ(result.verdicts[0]->verdict, ToleranceVerdict::not_measured);
  EXPECT_NE(result.verdicts[0]->not_judged.find("1 of 150 places"), std::string::npos)
      << result.verdicts[0]->not_judged;
  what.joints[0]->places[0]->width = 0.02;
  EXPECT_EQ(judged(what, {"*: joint=3mm"}).failed, 1) << "one place is enough to fail";
  what.joints[0] = joint({0.012, 0.012, 0.012}, 1e-4);
  what.joints[0]->looked_at = 4;
  EXPECT_EQ(judged(what, {"*: joint=3mm"}).passed, 1);
  what.joints[0]->looked_at = 5;
  const auto some = judged(what, {"*: joint=3mm"});
  EXPECT_EQ(some.passed, 0) << "what hides two fifths of a joint hides how wide it is";
  EXPECT_NE(
      some.verdicts[0]->not_judged.find("3 of 5 places along it, where it keeps the limit; to pass it needs 75 %"),
      std::string::npos)
      << some.verdicts[0]->not_judged;
  for (auto& place : what.joints[0]->places) place->step = 0, place->step_sigma = 1e-4;
  EXPECT_EQ(judged(what, {"*: step=2mm"}).passed, 1) << "steps are those of the panels' surfaces";
}

TEST(JudgeSurfaces, JointsOfPanelsThatShareAName) {
  SurfacesT what = surfaces();
  what.panels.push_back(panel("A", 0.002, 2e-4));  // another A, with another GlobalId
  what.panels[3]->face->origin.x() = 20;
  what.panels[3]->face->guid = "B-guid";  // that the rule for level 2 selects
  what.joints.push_back(joint({0.012, 0.012}, 1e-4));
  what.joints[0]->first = "A", what.joints[0]->second = "C";
  what.joints[0]->first_panel = 0, what.joints[0]->second_panel = 0;
  const std::vector<std::string> rules = {"storey=Level 1: joint=3mm", "name=B: joint=1mm"};
  auto result = judged(what, rules);
  ASSERT_EQ(result.verdicts.size(), 1U);
  EXPECT_EQ(result.verdicts[0]->rule, rules[0]) << "the joint is of the first A, not of the other";
  EXPECT_EQ(result.verdicts[0]->item, 0);
  what.joints[0]->first_panel = what.joints[0]->second_panel = 3;
  EXPECT_EQ(judged(what, rules).verdicts[0]->rule, rules[1]);
  what.joints[0]->first_panel = what.joints[0]->second_panel = -1;
  EXPECT_NE(judged(what, rules).verdicts[0]->not_judged.find("share their names"), std::string::npos);
}

/// Panels of points 20 mm apart with 2 mm of noise, flat but for a hollow of one size of cell: wrong verdicts stay
/// within the risk, although the largest of thousands of noisy gaps is judged, and what is clearly hollow fails.
TEST(JudgeSurfaces, TheLargestOfManyNoisyGapsIsNoHollow) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal(0, 1);
  constexpr double noise = 0.002, limit = 0.0025, tiny = 1e-6;
  constexpr int trials = 150;
  int looked_hollow = 0;  // flat panels that would fail if the largest gap were judged as one chosen beforehand
  const auto verdict = [&](double hollow) {
    surface::HeightGrid grid(24, 24, {1.2, 1.2});
    for (int i = 0; i < 60; ++i)
      for (int j = 0; j < 60; ++j) {
        const Eigen::Vector2d place(0.02 * i - 0.59, 0.02 * j - 0.59);
        const bool in = place.x() > 0 && place.x() < 0.05 && place.y() > 0 && place.y() < 0.05;
        grid.add(place, noise * normal(random) - (in ? hollow : 0), noise, Eigen::VectorXd());
      }
    const surface::Gap gap = grid.largest_gap(1);
    SurfacesT what;
    what.panels.push_back(panel("A", gap.gap, gap.sigma));
    auto& entry = *what.panels[0]->flatness[0];
    entry.positions = gap.positions, entry.noise_mean = gap.noise_mean, entry.noise_sigma = gap.noise_sigma;
    const auto result = judged(what, {"*: flatness(1m)=2.5mm"});
    looked_hollow += hollow == 0 && result.verdicts[0]->probability <= 0.05;
    return result.verdicts[0]->verdict;
  };
  int flat_failed = 0, good_failed = 0, bad_passed = 0, hollow_failed = 0;
  for (int trial = 0; trial < trials; ++trial) {
    flat_failed += verdict(0) == ToleranceVerdict::fail;
    good_failed += verdict(limit - tiny) == ToleranceVerdict::fail;
    bad_passed += verdict(limit + tiny) == ToleranceVerdict::pass;
    hollow_failed += verdict(0.01) == ToleranceVerdict::fail;
  }
  const double most = 0.05 * trials + 3 * std::sqrt(0.05 * trials);
  EXPECT_GT(looked_hollow, 0.2 * trials);
  EXPECT_LE(flat_failed, most);
  EXPECT_LE(good_failed, most);
  EXPECT_LE(bad_passed, most);
  EXPECT_GE(hollow_failed, 0.9 * trials) << "a hollow of 10 mm, five times the noise of a point";
}

/// A dent of 10 mm in a panel that is measured to 0.5 mm: its points are no outliers that flatness could do without.
TEST(JudgeSurfaces, ADeepDentDoesNotPassByBeingAnOutlier) {
  const surface::PanelFace face{"A", surface::facade_plane({0, 0, 0}, {0, -1, 0}), 1.5, 1.2};
  const auto verdict = [&](double dent, bool strewn) {
    std::mt19937_64 random(4);
    std::normal_distribution<double> normal(0, 1);
    surface::MeasuredTile tile;
    for (int i = 0; i < 75; ++i)
      for (int j = 0; j < 60; ++j) {
        const Eigen::Vector2d at(0.02 * i - 0.74, 0.02 * j - 0.59);
        const bool in = strewn ? (i + 7 * j) % 30 == 0 : at.x() > 0.1 && at.x() < 0.3 && std::abs(at.y()) < 0.1;
        const double height = 5e-4 * normal(random) - (in ? dent : 0);
        tile.points.push_back({face.plane.world({at.x(), at.y(), height}).cast<float>(), 5e-4F});
      }
    const surface::PanelSurface measured = surface::measure_panel(face, {tile}, {});
    EXPECT_EQ(measured.not_measured, "");
    const surface::Gap& gap = measured.flatness.back();
    SurfacesT what;
    what.panels.push_back(panel("A", gap.gap, gap.sigma));
    auto& entry = *what.panels[0]->flatness[0];
    entry.noise_mean = gap.noise_mean, entry.noise_sigma = gap.noise_sigma, entry.with_outlying = gap.with_outlying;
    return std::move(judged(what, {"*: flatness(1m)=3mm"}).verdicts[0]);
  };
  EXPECT_EQ(verdict(0, false)->verdict, ToleranceVerdict::pass);
  const auto dented = verdict(0.01, false);
  EXPECT_NE(dented->verdict, ToleranceVerdict::pass);
  EXPECT_NE(dented->not_judged.find("a dent or something in front"), std::string::npos) << dented->not_judged;
  EXPECT_EQ(verdict(0.01, true)->verdict, ToleranceVerdict::pass) << "single points that lie elsewhere are outliers";
}

}  // namespace test_judge
}  // namespace plumbline::judgement

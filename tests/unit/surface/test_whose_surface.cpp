// Whether what was measured is the panel: a net, a board or the wall behind is as flat; two panels at one place; points
// too far apart; rules that contradict each other.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "building/judgement/surfaces.hpp"
#include "geometry/packed_symmetric.hpp"
#include "surface/dense/panel_surface.hpp"

namespace plumbline::judgement {
namespace test_whose_surface {

surface::PanelFace face(const std::string& name, const Eigen::Vector3d& middle = {0, 0, 0}) {
  return {name, surface::facade_plane(middle, {0, -1, 0}), 1.5, 1.2};
}

/// Points every `apart` m on a part of the panel, flat, `out` before the design's face at the middle and leaning by
/// `lean` m per m.
surface::PanelSurface measured(const surface::PanelFace& of, double out, double lean = 0, double apart = 0.02,
                               double part = 1) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal(0, 1);
  surface::MeasuredTile tile;
  tile.centre = of.plane.origin;
  for (double u = -0.75 + 0.5 * apart; u < 0.75; u += apart)
    for (double v = -0.6 + 0.5 * apart; v < -0.6 + 1.2 * part; v += apart) {
      const Eigen::Vector3d at = of.plane.world({u, v, out + lean * v + 3e-4 * normal(random)});
      tile.points.push_back({(at - tile.centre).cast<float>(), 3e-4F});
    }
  return surface::measure_panel(of, {tile}, {});
}

std::unique_ptr<PanelSurfaceFiguresT> figures(const surface::PanelFace& of, const surface::PanelSurface& panel) {
  auto result = std::make_unique<PanelSurfaceFiguresT>();
  result->face = std::make_unique<SurfaceFaceT>();
  result->face->id = of.id, result->face->guid = of.id + "-guid", result->face->origin = of.plane.origin;
  result->face->right = of.plane.axes.col(0), result->face->up = of.plane.axes.col(1);
  result->face->out = of.plane.axes.col(2), result->face->width = of.width, result->face->height = of.height;
  result->not_measured = panel.not_measured, result->coverage = panel.coverage;
  result->spacing = panel.spacing, result->covering_cell = panel.covering_cell;
  result->offset = panel.plane(0), result->tilt = panel.plane.tail<2>(), result->form = panel.form.tail<3>();
  result->coefficients_random = pack_symmetric(panel.form_random);
  for (const surface::Gap& gap : panel.flatness) {
    auto entry = std::make_unique<SurfaceGapT>();
    entry->length = gap.length, entry->gap = gap.gap, entry->sigma = gap.sigma, entry->positions = gap.positions;
    entry->noise_mean = gap.noise_mean, entry->noise_sigma = gap.noise_sigma;
    result->flatness.push_back(std::move(entry));
  }
  return result;
}

std::unique_ptr<JointFiguresT> joint_of(int first, int second, double width) {
  auto joint = std::make_unique<JointFiguresT>();
  joint->first = "A", joint->second = "B", joint->first_panel = first, joint->second_panel = second;
  joint->nominal_width = 0.012, joint->looked_at = 1, joint->places.push_back(std::make_unique<JointPlaceT>());
  joint->places[0]->width = width, joint->places[0]->width_sigma = 1e-4;
  return joint;
}

SurfaceJudgementT judged(const SurfacesT& surfaces, const std::vector<std::string>& rules,
                         double within = kPlausiblePlace) {
  std::vector<SurfaceRule> parsed;
  for (const std::string& rule : rules) parsed.push_back(parse_surface_rule(rule));
  return judge_surfaces(surfaces, {}, parsed, 0.05, within);
}

SurfacesT one(double out, double lean = 0) {
  SurfacesT surfaces;
  surfaces.panels.push_back(figures(face("A"), measured(face("A"), out, lean)));
  return surfaces;
}

void expect_open(const SurfaceJudgementT& result, const std::string& because) {
  EXPECT_EQ(result.passed + result.failed + result.undecided, 0);
  for (const auto& verdict : result.verdicts)
    EXPECT_NE(verdict->not_judged.find(because), std::string::npos) << verdict->quantity << ": " << verdict->not_judged;
  for (const auto& request : result.requests) EXPECT_NE(request->not_judged, "") << "else it would be ready";
}

TEST(WhoseSurface, WhatHangsBeforeAPanelIsNotTakenForIt) {
  const std::vector<std::string> rules = {"*: flatness(1m)=3mm, bow=3mm, twist=3mm"};
  EXPECT_EQ(judged(one(0.004), rules).passed, 3);
  EXPECT_EQ(judged(one(-0.012), rules).passed, 3) << "as far as panels are";
  expect_open(judged(one(0.035), rules), "up to 35.0 mm before the design's face");
  expect_open(judged(one(0.035), rules), "a net, a board or a scaffold before the panel");
  expect_open(judged(one(0.018), rules), "within 15.0 mm ('within' of surface.judge)");
  expect_open(judged(one(-0.045), rules), "behind the design's face");
  expect_open(judged(one(-0.045), rules), "the wall where no panel hangs");
  expect_open(judged(one(0.005, 0.03), rules), "up to 23.");  // a board that leans: 18 mm more at its top
  EXPECT_EQ(judged(one(0.035), rules, 0.05).passed, 3) << "who knows that it is the panel says so";
  SurfacesT unknown = one(0);
  unknown.panels[0]->offset = std::nan("");
  expect_open(judged(unknown, rules), "is not known");
}

TEST(WhoseSurface, NorDoesItFail) {
  SurfacesT net = one(0.035);
  net.panels[0]->flatness.back()->gap = 0.02;
  expect_open(judged(net, {"*: flatness(1m)=3mm"}), "may be a net");
}

TEST(WhoseSurface, AJointAtItIsNotJudged) {
  SurfacesT surfaces = one(0.035);
  surfaces.panels.push_back(figures(face("B", {1.52, 0, 0}), measured(face("B", {1.52, 0, 0}), 0.001)));
  surfaces.joints.push_back(joint_of(0, 1, 0.012));
  expect_open(judged(surfaces, {"*: joint=3mm"}), "of A: what was measured lies up to 35.0 mm before");
  EXPECT_EQ(judged(surfaces, {"*: joint=3mm"}, 0.05).passed, 1);
}

TEST(WhoseSurface, OfTwoPanelsAtOnePlaceNobodyKnowsWhichItIs) {
  SurfacesT surfaces = one(0.001);
  surfaces.panels.push_back(figures(face("B", {0.2, 0.004, 0.1}), measured(face("B"), 0.001)));
  surfaces.panels.push_back(figures(face("C", {1.52, 0, 0}), measured(face("C", {1.52, 0, 0}), 0.001)));
  surfaces.panels.push_back(figures(face("D", {0, -0.3, 0}), measured(face("D", {0, -0.3, 0}), 0.001)));
  const auto result = judged(surfaces, {"*: flatness(1m)=3mm"});
  ASSERT_EQ(result.verdicts.size(), 4U);
  EXPECT_NE(result.verdicts[0]->not_judged.find("the design has B at the same place"), std::string::npos);
  EXPECT_NE(result.verdicts[1]->not_judged.find("the design has A at the same place"), std::string::npos);
  EXPECT_EQ(result.passed, 2) << "the neighbour, and a sunshade 300 mm before it";
  // What the scan gave to one of them alone is of both, too.
  surfaces.panels[1]->not_measured = "no point was measured on it";
  EXPECT_NE(judged(surfaces, {"*: flatness(1m)=3mm"}).verdicts[0]->not_judged, "");
}

TEST(WhoseSurface, WhereTheWholeMayBeElsewhereNothingIsJudged) {
  SurfacesT surfaces = one(0.001);
  surfaces.joints.push_back(joint_of(0, 0, 0.012));
  surfaces.place_doubt = "it may be the panels beside";
  expect_open(judged(surfaces, {"*: flatness(1m)=3mm, joint=3mm"}), "it may be the panels beside");
}

/// Points further apart than cells are wide leave most of these empty: nobody failed to see the panel.
TEST(WhoseSurface, PointsTooFarApartAreNamedWithTheCellThatWouldDo) {
  const auto reason = [](double apart, double part) {
    SurfacesT surfaces;
    surfaces.panels.push_back(figures(face("A"), measured(face("A"), 0.001, 0, apart, part)));
    return judged(surfaces, {"*: flatness(1m)=3mm"}).verdicts[0]->not_judged;
  };
  const std::string coarse = reason(0.065, 1), coarser = reason(0.12, 1), half = reason(0.02, 0.55);
  EXPECT_NE(coarse.find("of its cells: they are 6"), std::string::npos) << coarse;
  EXPECT_NE(coarse.find("mm all cells have points"), std::string::npos) << coarse;
  EXPECT_NE(coarser.find("are needed: they are 1"), std::string::npos) << coarser;
  EXPECT_NE(coarser.find("coverage counts in cells of 50 mm"), std::string::npos) << coarser;
  EXPECT_NE(half.find("what the rest is nobody saw"), std::string::npos) << half;
  SurfacesT sparse;
  sparse.panels.push_back(figures(face("A"), measured(face("A"), 0.001, 0, 0.075)));
  const auto both = judged(sparse, {"*: flatness(0.1m)=3mm, bow=3mm"});
  for (const auto& verdict : both.verdicts)
    EXPECT_NE(verdict->not_judged.find("mm apart, and with 'cell'"), std::string::npos)
        << verdict->quantity << ": " << verdict->not_judged;
  // The cell that is named does what is said of it.
  surface::PanelOptions wider;
  wider.cell = measured(face("A"), 0.001, 0, 0.065).covering_cell;
  ASSERT_GT(wider.cell, 0.065);
  EXPECT_LT(wider.cell, 0.15);
  const surface::PanelFace of = face("A");
  surface::MeasuredTile tile;
  for (double u = -0.75 + 0.0325; u < 0.75; u += 0.065)
    for (double v = -0.6 + 0.0325; v < 0.6; v += 0.065)
      tile.points.push_back({of.plane.world({u, v, 0.001}).cast<float>(), 3e-4F});
  EXPECT_GT(surface::measure_panel(of, {tile}, wider).coverage, 0.97);
}

TEST(SurfaceRules, WhatContradictsItselfIsRefusedWithBothPlaces) {
  const auto refusal = [](const std::string& rule) {
    try {
      parse_surface_rule(rule);
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string("(taken)");
  };
  const std::string twice = refusal("*: flatness(1m)=3mm, bow=4mm, flatness(1000mm)=5mm");
  EXPECT_NE(twice.find("found 'flatness(1000mm)=5mm', and before it 'flatness(1m)=3mm'"), std::string::npos) << twice;
  EXPECT_NE(refusal("*: flatness(1m)=3mm, flatness( 1.0m )=3mm"), "(taken)");
  const std::string never = refusal("*: narrowest=20mm, widest=8mm");
  EXPECT_NE(never.find("found 'widest=8mm', and before it 'narrowest=20mm'"), std::string::npos) << never;
  EXPECT_NE(refusal("*: widest=8mm, step=1mm, narrowest=20mm").find("found 'narrowest=20mm'"), std::string::npos);
  EXPECT_EQ(refusal("*: narrowest=8mm, widest=20mm, flatness(1m)=3mm, flatness(2m)=4mm"), "(taken)");
}

TEST(SurfaceRules, TwoThatNoJointKeepsAreRefusedWithBoth) {
  SurfacesT surfaces = one(0.001);
  surfaces.panels.push_back(figures(face("B", {1.52, 0, 0}), measured(face("B", {1.52, 0, 0}), 0.001)));
  surfaces.joints.push_back(joint_of(0, 1, 0.012));
  try {
    judged(surfaces, {"name=A: narrowest=20mm", "name=B: widest=8mm"});
    ADD_FAILURE() << "both select the joint between A and B";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("'name=A: narrowest=20mm' and 'name=B: widest=8mm'"), std::string::npos)
        << error.what();
  }
  EXPECT_EQ(judged(surfaces, {"*: narrowest=20mm", "*: narrowest=8mm, widest=15mm"}).passed, 2)
      << "the later rule holds";
}

}  // namespace test_whose_surface
}  // namespace plumbline::judgement

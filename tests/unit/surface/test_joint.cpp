// Joints of a rendered facade against what was planted: width, step and what their standard deviations state.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <chrono>
#include <cstdio>

#include "surface/dense/edge_profile.hpp"
#include "surface/dense/facet_tile.hpp"
#include "surface/dense/joint.hpp"
#include "surface/dense/joint_pairs.hpp"
#include "surface/dense/joint_places.hpp"
#include "surface_site.hpp"

namespace plumbline::surface {
namespace test_joint {

using plumbline::testing::FacadeScene;

double width_at(double v) { return 0.0121 + 0.004 * v; }  // [m]
constexpr double kStep = 0.0023;                          // b stands out by it [m]

FacadeScene jointed(double panel, double gap, double step = kStep) {
  FacadeScene scene;
  scene.height = [step](double u, double) { return step * std::min(1.0, std::max(0.0, u / 0.004 + 0.5)); };
  scene.reflectance = [panel, gap](double u, double v) {
    return std::abs(u) < 0.5 * width_at(v) ? gap : panel + 0.15 * plumbline::testing::plaster(u, v, 0.002);
  };
  return scene;
}

std::vector<PanelFace> faces_of(const Site& site) {
  std::vector<PanelFace> faces(2);
  faces[0] = {"left", site.scene.plane, 0.16, 0.24};
  faces[1] = {"right", site.scene.plane, 0.16, 0.24};
  faces[0].plane.origin = site.scene.plane.world({-0.086, 0, 0});
  faces[1].plane.origin = site.scene.plane.world({0.086, 0, 0});
  return faces;
}

struct Outcome {
  std::vector<Joint> joints;
  MeasuredJoint joint;
};

/// `unmeasured`: number of a panel without figures, as if nothing showed on it; `seen_by`: numbers of the photographs
/// that show the joint; `before`: where something stands before the left panel, from its middle.
Outcome measure(const Site& site, int unmeasured = -1, const std::vector<size_t>& seen_by = {0, 1, 2, 3, 4},
                const std::vector<Eigen::Vector2d>& before = {}) {
  Outcome outcome;
  const std::vector<PanelFace> faces = faces_of(site);
  std::vector<FacetTile> tiles;
  for (double side : {-1.0, 1.0})
    tiles.push_back(measure_tile(
        site.scene.plane, {{std::min(side * 0.01, side * 0.16), -0.12}, {std::max(side * 0.01, side * 0.16), 0.12}},
        site.facet_views(), site.orientations, {}));
  add_systematic_part(tiles, {site.scene.plane, site.scene.plane}, site.orientations);
  std::vector<MeasuredTile> measured;
  for (const FacetTile& tile : tiles) measured.push_back(tile.measured);
  PanelOptions options;
  options.border = 0.008;
  std::vector<PanelSurface> surfaces;
  for (const PanelFace& face : faces) surfaces.push_back(measure_panel(face, measured, options));
  if (unmeasured >= 0) {
    surfaces[unmeasured] = PanelSurface();
    surfaces[unmeasured].not_measured = "nothing on it to measure";
  }
  surfaces[0].before = before, surfaces[0].cell = 0.02;
  std::vector<FacetView> views;
  for (size_t k : seen_by) views.push_back(site.facet_views()[k]);
  outcome.joints = joints_of(faces);
  if (!outcome.joints.empty())
    outcome.joint = measure_joint(outcome.joints[0], faces, surfaces, views, site.orientations, {});
  return outcome;
}

TEST(Joint, WidthAndStepOfADarkJoint) {
  const Outcome outcome = measure(make_site(jointed(0.5, 0.05)));
  ASSERT_EQ(outcome.joints.size(), 1U);
  EXPECT_NEAR(outcome.joints[0].width, 0.012, 1e-9);
  ASSERT_GE(outcome.joint.stations.size(), 9U) << outcome.joint.not_measured;
  double squares = 0, width = 0;
  for (const JointStation& station : outcome.joint.stations) {
    const double error = station.width - width_at(station.along);
    width += error;
    squares += std::pow(error / station.width_sigma, 2);
    EXPECT_LT(std::abs(error), 1e-4);
    EXPECT_NEAR(station.step, kStep, 4 * station.step_sigma + 2e-5);
    EXPECT_LT(station.step_sigma, 1.5e-4);
  }
  const double count = static_cast<double>(outcome.joint.stations.size());
  EXPECT_LT(std::abs(width / count), 4e-5) << "a bias of all widths";
  EXPECT_LT(squares / count, 2.5) << "sigmas are too small";
  EXPECT_LT(outcome.joint.stations[outcome.joint.narrowest].along, 0) << "it widens upwards";
}

TEST(Joint, ALightJointIsFoundAsWell) {
  const Outcome outcome = measure(make_site(jointed(0.2, 0.9)));
  ASSERT_GE(outcome.joint.stations.size(), 9U) << outcome.joint.not_measured;
  for (const JointStation& station : outcome.joint.stations) EXPECT_NEAR(station.width, width_at(station.along), 1e-4);
}

TEST(Joint, WhereNoEdgeShowsNothingIsStated) {
  FacadeScene scene;
  scene.reflectance = [](double u, double v) { return 0.4 + 0.1 * plumbline::testing::plaster(u, v, 0.002); };
  const Outcome outcome = measure(make_site(scene));
  EXPECT_EQ(outcome.joint.stations.size(), 0U);
  EXPECT_NE(outcome.joint.not_measured, "");
}

/// Panels that touch over a third of their length: photographs look there, and no edge is to be seen.
TEST(Joint, WhereItIsClosedInPhotographsIsCounted) {
  FacadeScene scene = jointed(0.5, 0.05);
  const auto open = scene.reflectance;
  scene.reflectance = [open](double u, double v) {
    return std::abs(v) < 0.04 ? 0.5 + 0.15 * plumbline::testing::plaster(u, v, 0.002) : open(u, v);
  };
  const Outcome outcome = measure(make_site(scene));
  EXPECT_EQ(outcome.joint.not_measured, "");
  EXPECT_GE(outcome.joint.closed, 3);
  EXPECT_LE(outcome.joint.closed, 5) << "of 11 places 20 mm apart";
  EXPECT_EQ(measure(make_site(jointed(0.5, 0.05))).joint.closed, 0);
}

TEST(Joint, ACopyOfAPhotographIsNoOtherWitness) {
  const Site site = make_site(jointed(0.5, 0.05));
  EXPECT_NE(measure(site, -1, {0, 0}).joint.not_measured, "") << "two photographs are needed";
  const MeasuredJoint two = measure(site, -1, {0, 1}).joint, doubled = measure(site, -1, {0, 1, 0, 1}).joint;
  ASSERT_EQ(doubled.stations.size(), two.stations.size());
  for (size_t s = 0; s < two.stations.size(); ++s) {
    EXPECT_EQ(doubled.stations[s].views, 2);
    EXPECT_EQ(doubled.stations[s].width_sigma, two.stations[s].width_sigma);
  }
}

/// A tag's plate beside the joint hides the panel's edge by its own, over more places than a bulge has.
TEST(Joint, TheBorderOfWhatStandsBeforeAPanelIsNotItsEdge) {
  FacadeScene scene = jointed(0.5, 0.05);
  const auto without = scene.reflectance;
  scene.reflectance = [without](double u, double v) {
    return std::abs(v) < 0.03 && u < 0 && u > -0.5 * width_at(v) - 0.006 ? 0.05 : without(u, v);
  };
  const Site site = make_site(scene);
  const auto widest = [](const MeasuredJoint& joint) { return joint.stations.at(joint.widest).width; };
  EXPECT_GT(widest(measure(site).joint), 0.016) << "nothing says that it is another's";
  const MeasuredJoint joint = measure(site, -1, {0, 1, 2, 3, 4}, {{0.06, 0}}).joint;
  ASSERT_EQ(joint.not_measured, "");
  EXPECT_GE(joint.covered, 3);
  EXPECT_EQ(joint.closed, 0) << "whether it is nobody sees";
  EXPECT_NEAR(widest(joint), width_at(0.11), 3e-4);
  EXPECT_EQ(measure(site, -1, {0, 1, 2, 3, 4}, {{-0.04, 0}}).joint.covered, 0) << "further from the edge";
}

TEST(Joint, StretchesWithoutEdgesCountFrom60MillimetresOn) {
  std::vector<LookedAt> places;
  for (int s = 0; s < 20; ++s) places.push_back({0.02 * s, true, false});
  const auto but = [&](const std::vector<int>& without) {
    std::vector<JointStation> believed;
    for (int s = 0; s < 20; ++s)
      if (std::find(without.begin(), without.end(), s) == without.end()) believed.emplace_back().along = 0.02 * s;
    return without_edges(places, believed);
  };
  EXPECT_EQ(but({4, 5, 11}), 0) << "a tube before it";
  EXPECT_EQ(but({4, 5, 6, 11}), 3);
  places[5].edge = true;
  EXPECT_EQ(but({4, 5, 6}), 3) << "grain that looked like an edge";
  places[6].edge = true;
  EXPECT_EQ(but({4, 5, 6}), 0);
  places[5].edge = places[6].edge = false, places[5].looked = false;
  EXPECT_EQ(but({4, 5, 6}), 0) << "nobody looked";
}

/// A panel of glass or of plain paint has no measured surface, and the design's is not where it hangs: seen from one
/// side its edge is off by its height times the rays' slope.
TEST(Joint, BesideAPanelThatWasNotMeasuredTheHeightOfItsEdgeIsUnknown) {
  const FacadeScene scene = jointed(0.5, 0.05, 0.005);
  for (int unmeasured : {0, 1}) {
    FacadeScene moved = scene;
    if (unmeasured == 0) moved.height = [scene](double u, double v) { return scene.height(u, v) - 0.005; };
    const Site site = make_site(moved);
    for (const std::vector<size_t>& seen_by : {std::vector<size_t>{0, 1, 2, 3, 4}, {0, 2, 3}, {0, 1, 2}}) {
      const Outcome outcome = measure(site, unmeasured, seen_by);
      ASSERT_GE(outcome.joint.stations.size(), 9U) << outcome.joint.not_measured;
      double squares = 0;
      for (const JointStation& station : outcome.joint.stations) {
        squares += std::pow((station.width - width_at(station.along)) / station.width_sigma, 2);
        EXPECT_FALSE(std::isfinite(station.step));
      }
      const double count = static_cast<double>(outcome.joint.stations.size());
      EXPECT_LT(squares / count, 2.5) << "panel " << unmeasured << ", " << seen_by.size() << " photographs";
    }
    const Outcome two = measure(site, unmeasured, {0, 1});
    EXPECT_NE(two.joint.not_measured.find("panel '" + std::string(unmeasured == 0 ? "left" : "right") + "'"),
              std::string::npos)
        << "of two photographs the one says where the edge is and the other how high: nothing tells whether they show "
           "the same edge; "
        << two.joint.not_measured;
  }
}

TEST(Joint, WidthsAndStepsOfManyTrialsHaveTheErrorsTheyState) {
  Site site = make_site(jointed(0.5, 0.05));
  give_orientations_errors(site);
  const Eigen::Index size = site.orientations.size();
  const Eigen::MatrixXd root =
      (site.orientations.matrix + 1e-18 * Eigen::MatrixXd::Identity(size, size)).llt().matrixL();
  const std::vector<View> views = site.views;
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0, 1);
  double of_width = 0, of_step = 0, of_shift = 0;
  constexpr int trials = 20;
  for (int trial = 0; trial < trials; ++trial) {
    Eigen::VectorXd z(size);
    for (Eigen::Index i = 0; i < size; ++i) z(i) = normal(random);
    perturb(site, views, root * z);
    site.expose(1.5, 300 + static_cast<std::uint64_t>(trial));
    const Outcome outcome = measure(site);
    ASSERT_FALSE(outcome.joint.stations.empty());
    const JointStation& station = outcome.joint.stations[outcome.joint.stations.size() / 2];
    of_width += std::pow((station.width - width_at(station.along)) / station.width_sigma, 2) / trials;
    of_step += std::pow((station.step - kStep) / station.step_sigma, 2) / trials;
    of_shift += std::pow(station.shift / station.shift_sigma, 2) / trials;
  }
  // 20 degrees of freedom: 95 % within 0.48 and 1.71.
  EXPECT_LT(of_width, 1.9);
  EXPECT_GT(of_width, 0.2);
  EXPECT_LT(of_step, 1.9);
  EXPECT_GT(of_step, 0.2);
  EXPECT_LT(of_shift, 1.9);
  EXPECT_GT(of_shift, 0.2);
}

/// Panels that hang 8 mm aside: one edge lies beyond the joint's middle in the design, and is at its own panel's height
/// all the same.
TEST(Joint, AnEdgeBeyondTheMiddleOfTheDesignsJointIsStillItsPanels) {
  constexpr double aside = 0.008, step = 0.005;
  FacadeScene scene;
  scene.height = [](double u, double) { return u < aside ? 0.0 : step; };
  scene.reflectance = [](double u, double v) {
    return std::abs(u - aside) < 0.006 ? 0.05 : 0.5 + 0.15 * plumbline::testing::plaster(u, v, 0.002);
  };
  for (const std::vector<size_t>& seen_by : {std::vector<size_t>{0, 1, 2, 3, 4}, {0, 2, 3}}) {
    const Outcome outcome = measure(make_site(scene), -1, seen_by);
    ASSERT_GE(outcome.joint.stations.size(), 9U) << outcome.joint.not_measured;
    double off = 0;
    for (const JointStation& station : outcome.joint.stations) {
      EXPECT_NEAR(station.width, 0.012, 3e-4) << seen_by.size() << " photographs at " << station.along;
      EXPECT_NEAR(station.shift, aside, 3e-4) << "both panels hang aside, and the joint is as wide as designed";
      off += (station.width - 0.012) / static_cast<double>(outcome.joint.stations.size());
    }
    EXPECT_NEAR(off, 0, 2e-4) << "1 mm at its neighbour's height, from one side";
  }
}

/// Panels at an angle, as designed: a facade that is bent a little. Neither their widths nor their steps are off.
TEST(Joint, OfPanelsAtAnAngleIsAsTheDesignHasIt) {
  constexpr double turn = 9 * M_PI / 180, joint = 0.02, width = 0.5;
  const Eigen::Vector3d along(std::cos(turn), std::sin(turn), 0);
  std::vector<PanelFace> faces = {{"A", facade_plane({0, 0, 0}, {0, -1, 0}), width, 1},
                                  {"B", facade_plane({0, 0, 0}, {std::sin(turn), -std::cos(turn), 0}), width, 1}};
  const Eigen::Vector3d middle = Eigen::Vector3d(std::cos(turn / 2), std::sin(turn / 2), 0);
  faces[1].plane.origin = Eigen::Vector3d(0.5 * width, 0, 0) + joint * middle + 0.5 * width * along;
  const std::vector<Joint> joints = joints_of(faces);
  ASSERT_EQ(joints.size(), 1U);
  EXPECT_NEAR(joints[0].width, joint, 1e-9);
  EXPECT_NEAR(joints[0].step, 0, 1e-9);
  std::vector<PanelSurface> surfaces(2);
  for (PanelSurface& surface : surfaces) surface.half_width = 0.5 * width, surface.half_height = 0.5;
  for (const double out : {0.0, 0.0025}) {
    surfaces[1].form(0) = out;
    const auto [a, b] = edge_lines(joints[0], faces, surfaces);
    JointStation station;
    add_step(station, a, b, joints[0].plane, -0.5 * joint, 0.5 * joint);
    EXPECT_NEAR(station.step, out, 1e-4);
  }
  EXPECT_TRUE(pairs_without_joint(faces).empty());
}

TEST(Joint, AStepIsWhatItIsBeyondTheDesigns) {
  std::vector<PanelFace> faces = {{"A", facade_plane({0, 0, 0}, {0, -1, 0}), 0.5, 1},
                                  {"B", facade_plane({0.52, -0.016, 0}, {0, -1, 0}), 0.5, 1}};  // 16 mm thicker
  const std::vector<Joint> joints = joints_of(faces);
  ASSERT_EQ(joints.size(), 1U);
  EXPECT_NEAR(joints[0].step, 0.016, 1e-12);
  std::vector<PanelSurface> surfaces(2);
  for (PanelSurface& surface : surfaces) surface.half_width = 0.25, surface.half_height = 0.5;
  surfaces[1].form(0) = -0.008;
  const auto [a, b] = edge_lines(joints[0], faces, surfaces);
  JointStation station;
  add_step(station, a, b, joints[0].plane, -0.01, 0.01);
  EXPECT_NEAR(station.step, -0.008, 1e-12);
}

TEST(Joint, WhereAFacadeIsFoldedThereIsOneThatNobodyMeasures) {
  const auto turned = [](double degrees) {
    const double turn = degrees * M_PI / 180;
    const Eigen::Vector3d along(std::cos(turn), std::sin(turn), 0);
    std::vector<PanelFace> faces = {{"A", facade_plane({0, 0, 0}, {0, -1, 0}), 0.5, 1},
                                    {"B", facade_plane({0, 0, 0}, {std::sin(turn), -std::cos(turn), 0}), 0.5, 1}};
    faces[1].plane.origin = Eigen::Vector3d(0.27, 0, 0) + 0.25 * along;
    return pairs_without_joint(faces).size();
  };
  EXPECT_EQ(turned(5), 0U) << "measured";
  EXPECT_EQ(turned(20), 1U);
  EXPECT_EQ(turned(90), 0U) << "a corner of the building";
}

/// A bulge of an edge is where the joint is narrowest; one place by itself looked like an edge.
TEST(Joint, PlacesThatAreOffTogetherStay) {
  MeasuredJoint measured;
  std::vector<EdgePair> edges;
  for (int s = 0; s < 20; ++s) {
    JointStation station;
    const double bulge = s >= 8 && s < 12 ? 0.005 : 0, alone = s == 3 ? 0.006 : 0;
    station.along = 0.05 * s, station.width = 0.012 - bulge - alone, station.width_sigma = station.width_random = 1e-4;
    measured.stations.push_back(station);
    edges.push_back({{-0.006 + bulge + alone, 0.006}, {1e-8, 1e-8}});
  }
  measured.stations_looked_at = 20;
  keep_straight(measured, edges, 0.0015, 2);
  sum_up(measured, "both panels end");
  ASSERT_EQ(measured.stations.size(), 19U);
  EXPECT_NEAR(measured.stations[measured.narrowest].width, 0.007, 1e-12);
}

/// What meets at a corner of the building has no joint here, and that is said.
TEST(Joint, PanelsThatMeetAtACornerAreNamed) {
  const auto face = [](const std::string& id, const Eigen::Vector3d& middle, const Eigen::Vector3d& out) {
    return PanelFace{id, facade_plane(middle, out), 1, 2};
  };
  std::vector<PanelFace> faces = {face("A", {0, 0, 0}, {0, -1, 0}), face("B", {1.02, 0, 0}, {0, -1, 0}),
                                  face("C", {1.53, 0.51, 0}, {1, 0, 0}), face("D", {0, 0.1, 2.02}, {0, -1, 0})};
  EXPECT_EQ(joints_of(faces).size(), 1U);
  const auto corners = corners_between(faces);
  ASSERT_EQ(corners.size(), 1U) << "D stands 100 mm back, out of reach";
  EXPECT_EQ(corners[0], std::pair(size_t{1}, size_t{2}));
  ASSERT_EQ(words_of_pairs(faces, 0.06).size(), 1U);
  EXPECT_EQ(words_of_pairs(faces, 0.06)[0].rfind("panels B and C meet at a corner", 0), 0U);
  EXPECT_EQ(corners_between(faces, 0.15).size(), 2U);
  ASSERT_EQ(pairs_without_joint(faces, 0.15).size(), 1U);
  EXPECT_NE(pairs_without_joint(faces, 0.15)[0].why.find("stands 100 mm further out"), std::string::npos);
  faces.erase(faces.begin() + 2, faces.end());
  EXPECT_TRUE(words_of_pairs(faces, 0.06).empty());
}

PanelFace upright_face(const std::string& id, double x, double z, double width = 1, double height = 1) {
  return {id, facade_plane({x, 0, z}, {0, -1, 0}), width, height};
}

/// Outlines of sandwich panels overlap by the tongue: there is a joint, of which the design does not say where.
TEST(Joint, PanelsWhoseOutlinesOverlapHaveOneThatNobodyMeasures) {
  const std::vector<PanelFace> faces = {upright_face("A", 0, 0), upright_face("B", 0, 0.985),
                                        upright_face("C", 1.02, 0), upright_face("D", 1.02, 0.985)};
  EXPECT_EQ(joints_of(faces).size(), 2U) << "the upright ones";
  const auto pairs = pairs_without_joint(faces);
  ASSERT_EQ(pairs.size(), 2U);
  EXPECT_EQ(std::pair(pairs[0].a, pairs[0].b), std::pair(size_t{0}, size_t{1}));
  EXPECT_NE(pairs[0].why.find("overlap by 15 mm"), std::string::npos) << pairs[0].why;
  EXPECT_FALSE(pairs[0].upright);
  EXPECT_NEAR(pairs[0].origin.z(), 0.4925, 1e-9);
  const std::vector<PanelFace> layers = {upright_face("A", 0, 0), upright_face("behind", 0.001, 0.3)};
  EXPECT_TRUE(pairs_without_joint(layers).empty()) << "one lies before the other";
}

TEST(Joint, WiderThanAnyThatIsMeasuredItIsNamed) {
  const auto apart = [](double gap) {
    return std::vector<PanelFace>{upright_face("A", 0, 0), upright_face("B", 1 + gap, 0)};
  };
  EXPECT_EQ(joints_of(apart(0.08), 0.15).size(), 1U) << "an expansion joint";
  EXPECT_TRUE(pairs_without_joint(apart(0.08), 0.15).empty());
  const auto wide = pairs_without_joint(apart(0.08), 0.06);
  ASSERT_EQ(wide.size(), 1U);
  EXPECT_NE(wide[0].why.find("width of 80 mm is above 'widest' (60 mm)"), std::string::npos) << wide[0].why;
  EXPECT_NEAR(wide[0].width, 0.08, 1e-9);
  EXPECT_TRUE(wide[0].upright);
  for (const double gap : {0.18, 0.4}) {
    EXPECT_TRUE(pairs_without_joint(apart(gap), 0.15).empty()) << "a pilaster, a window: said, and not judged";
    ASSERT_EQ(words_of_pairs(apart(gap), 0.15).size(), 1U);
  }
  EXPECT_NE(words_of_pairs(apart(0.4), 0.15)[0].find("400 mm apart"), std::string::npos);
  EXPECT_TRUE(words_of_pairs(apart(0.6), 0.15).empty());
}

/// One that stands out by 60 mm and three that overlap are not four that stand out.
TEST(Joint, EachReasonIsSaidWithHowManyHaveIt) {
  std::vector<PanelFace> faces;
  for (int i = 0; i < 4; ++i) faces.push_back(upright_face("A" + std::to_string(i), 0, 0.985 * i));
  faces.push_back(upright_face("out", 1.01, 0));
  faces.back().plane.origin.y() = -0.06;
  const std::vector<std::string> words = words_of_pairs(faces, 0.15);
  ASSERT_EQ(words.size(), 2U);
  EXPECT_NE(words[0].find("A0 and A1 (and 2 more such pairs) is not measured: the outlines"), std::string::npos)
      << words[0];
  EXPECT_NE(words[1].find("A0 and out is not measured: one of its panels stands 60 mm"), std::string::npos) << words[1];
}

/// A tower: who is near to whom is looked up, not asked of 10⁸ pairs.
TEST(Joint, PairsOfTenThousandPanelsTakeNoMinute) {
  std::vector<PanelFace> faces;
  for (int row = 0; row < 200; ++row)
    for (int column = 0; column < 50; ++column)
      faces.push_back(upright_face(std::to_string(faces.size()), 1.02 * column, 1.02 * row));
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(joints_of(faces, 0.15).size(), 200U * 49 + 199 * 50);
  EXPECT_TRUE(words_of_pairs(faces, 0.15).empty());
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  std::printf("joints and words of 10 000 panels: %.2f s\n", took.count());
  EXPECT_LT(took.count(), 60) << "on a machine that does ten other things; 2 s on one that does not";
}

TEST(Joint, WhatHasAPanelBetweenIsNoNeighbour) {
  std::vector<PanelFace> faces;  // lamellae, 30 mm high, with joints of 10 mm
  for (int i = 0; i < 6; ++i) faces.push_back(upright_face("L" + std::to_string(i), 0, 0.04 * i, 1, 0.03));
  EXPECT_EQ(joints_of(faces, 0.15).size(), 5U);
  EXPECT_TRUE(pairs_without_joint(faces, 0.15).empty());
  EXPECT_TRUE(words_of_pairs(faces, 0.15).empty());
}

TEST(EdgeProfile, BothEdgesOfAGapToAFewThousandthsOfASample) {
  // Down to a gap of five samples under a blur of 1.7, where each edge lies in the other's skirt.
  for (double width : {5.0, 9.3, 20.6}) {
    const double first = 30.37, second = first + width;
    std::vector<double> samples;
    const auto phi = [](double t) { return 0.5 * std::erfc(-t / std::sqrt(2.0)); };
    for (int i = 0; i < 81; ++i) samples.push_back(150 - 100 * phi((i - first) / 1.7) + 80 * phi((i - second) / 1.7));
    EXPECT_NEAR(steepest(samples, 30, 8, false), first, 1.5);
    const auto gap = fit_gap(samples, std::floor(first), std::ceil(second), 12, true);
    ASSERT_TRUE(gap) << width;
    EXPECT_NEAR(gap->place[0], first, 3e-3);
    EXPECT_NEAR(gap->place[1], second, 3e-3);
    EXPECT_FALSE(fit_gap(samples, std::floor(first), std::ceil(second), 12, false)) << "the gap is dark";
  }
  EXPECT_FALSE(fit_gap(std::vector<double>(81, 80.0), 30, 40, 12, true));
}

}  // namespace test_joint
}  // namespace plumbline::surface

// Facets of a rendered facade against what was planted: heights, their stated random and systematic errors, and holes
// where nothing can be known.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "geometry/median.hpp"
#include "surface/dense/facet_tile.hpp"
#include "surface/dense/panel_surface.hpp"
#include "surface_site.hpp"

namespace plumbline::surface {
namespace test_facet {

using plumbline::testing::FacadeScene;

const Rectangle kArea{{-0.16, -0.12}, {0.16, 0.12}};

TEST(Facet, HeightsOfATiltedBowedPanelLieWithinTheirStandardDeviations) {
  FacadeScene scene;
  scene.height = [](double u, double v) { return 0.013 + 0.01 * u - 0.006 * v - 0.08 * u * u; };
  const Site site = make_site(scene);
  const FacetTile tile = measure_tile(site.scene.plane, kArea, site.facet_views(), site.orientations, {});
  const int measured = tile.outcomes[static_cast<size_t>(FacetOutcome::measured)];
  int all = 0;
  for (int count : tile.outcomes) all += count;
  EXPECT_GE(measured, 0.97 * all);
  double squares = 0, mean = 0;
  int far = 0;
  for (const MeasuredPoint& point : tile.measured.points) {
    const Eigen::Vector3d local = site.scene.plane.local(tile.measured.at(point));
    const double error = local.z() - site.scene.height(local.x(), local.y());
    squares += std::pow(error / point.sigma, 2), mean += error;
    far += std::abs(error) > 3 * point.sigma;
  }
  const double count = static_cast<double>(tile.measured.points.size());
  EXPECT_GT(squares / count, 0.6) << "sigmas are too large";
  EXPECT_LT(squares / count, 1.5) << "sigmas are too small";
  EXPECT_LE(far, 0.01 * count + 2);
  EXPECT_LT(std::abs(mean / count), 3e-5) << "a bias of all heights";
}

TEST(Facet, SystematicPartIsWhatWrongOrientationsDo) {
  FacadeScene scene;
  scene.height = [](double, double) { return 0.004; };
  Site site = make_site(scene, 0.5);
  const FacetTile right = measure_tile(site.scene.plane, kArea, site.facet_views(), site.orientations, {});
  // Each unknown by itself: rotation and translation of the second photograph, and the principal distance.
  const auto fit = [&](const FacetTile& tile) {
    Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const MeasuredPoint& point : tile.measured.points) {
      const Eigen::Vector3d local = site.scene.plane.local(tile.measured.at(point));
      const Eigen::Vector3d base(1, local.x(), local.y());
      normal += base * base.transpose(), sum += base * local.z();
    }
    return Eigen::Vector3d(normal.inverse() * sum);
  };
  const Eigen::Vector3d before = fit(right);
  const std::vector<View> views = site.views;
  for (int unknown = 0; unknown < 7; ++unknown) {
    site.views = views;
    const double step = unknown < 3 ? 2e-5 : unknown < 6 ? 5e-5 : 3.0;
    if (unknown == 6) {
      for (View& view : site.views) view.camera.fx += step, view.camera.fy += step;
    } else {
      RigidTransform& pose = site.views[1].cam_from_world;
      Eigen::Vector3d turn = Eigen::Vector3d::Zero();
      if (unknown < 3)
        turn(unknown) = step;
      else
        pose.translation(unknown - 3) += step;
      // R' = exp(δ) R with the translation kept.
      pose.rotation = quaternion_from_rotation_vector(turn) * pose.rotation;
    }
    const Eigen::Vector3d change =
        fit(measure_tile(site.scene.plane, kArea, site.facet_views(), site.orientations, {})) - before;
    Eigen::Vector3d predicted = Eigen::Vector3d::Zero();
    if (unknown == 6)
      predicted = step * (right.sensitivity.col(40) + right.sensitivity.col(41));
    else
      predicted = step * right.sensitivity.col(8 + unknown);
    EXPECT_NEAR(change(0), predicted(0), 0.08 * std::abs(predicted(0)) + 4e-6) << unknown;
    EXPECT_NEAR(change(1), predicted(1), 0.15 * std::abs(predicted(1)) + 4e-5) << unknown;
    EXPECT_NEAR(change(2), predicted(2), 0.15 * std::abs(predicted(2)) + 4e-5) << unknown;
  }
}

TEST(Facet, PlanesOfManyTrialsHaveTheErrorsTheyState) {
  FacadeScene scene;
  scene.height = [](double u, double) { return 0.003 + 0.008 * u; };
  Site site = make_site(scene);
  const Eigen::Index size = site.orientations.size();
  give_orientations_errors(site);
  const Eigen::MatrixXd& covariance = site.orientations.matrix;
  const Eigen::MatrixXd root = (covariance + 1e-18 * Eigen::MatrixXd::Identity(size, size)).llt().matrixL();
  const std::vector<View> views = site.views;
  PanelFace face{"panel", site.scene.plane, 0.32, 0.24};
  PanelOptions panel_options;
  panel_options.border = 0.005;
  double nees = 0, random_only = 0;
  constexpr int trials = 24;
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal(0, 1);
  for (int trial = 0; trial < trials; ++trial) {
    Eigen::VectorXd z(size);
    for (Eigen::Index i = 0; i < size; ++i) z(i) = normal(random);
    perturb(site, views, root * z);
    site.expose(1.5, 100 + static_cast<std::uint64_t>(trial));
    std::vector<FacetTile> tiles;
    const Rectangle halves[2] = {{{-0.16, -0.12}, {0, 0.12}}, {{0, -0.12}, {0.16, 0.12}}};
    for (const Rectangle& half : halves)
      tiles.push_back(measure_tile(site.scene.plane, half, site.facet_views(), site.orientations, {}));
    add_systematic_part(tiles, {site.scene.plane, site.scene.plane}, site.orientations);
    std::vector<MeasuredTile> measured;
    for (const FacetTile& tile : tiles) measured.push_back(tile.measured);
    const PanelSurface panel = measure_panel(face, measured, panel_options);
    ASSERT_EQ(panel.not_measured, "");
    const Eigen::Vector3d off = panel.plane - Eigen::Vector3d(0.003, 0.008, 0);
    nees += off.dot(panel.plane_covariance().ldlt().solve(off)) / 3 / trials;
    random_only += off.dot(panel.plane_random.ldlt().solve(off)) / 3 / trials;
  }
  // 72 degrees of freedom: 95 % within 0.70 and 1.35.
  EXPECT_GT(nees, 0.65);
  EXPECT_LT(nees, 1.4);
  EXPECT_GT(random_only, 20) << "without the systematic part the plane would be stated far too good";
}

TEST(Facet, HolesAreHoles) {
  FacadeScene plain;
  plain.reflectance = [](double, double) { return 0.5; };
  const Site painted = make_site(plain);
  const FacetTile none = measure_tile(painted.scene.plane, kArea, painted.facet_views(), painted.orientations, {});
  EXPECT_LE(none.measured.points.size(), 2U);
  // A pattern that repeats, seen by three photographs along a line and equally apart: several heights fit alike.
  FacadeScene repeating;
  repeating.reflectance = [](double u, double) { return 0.5 + 0.4 * std::sin(2 * M_PI * u / 0.012); };
  Site striped = make_site(repeating);
  for (int k = 0; k < 3; ++k) {
    View& view = striped.views[k];
    view.cam_from_world =
        plumbline::testing::looking(striped.scene.plane.world({0.6 * (k - 1), 0, 3}), striped.scene.plane.origin);
    striped.light[k] = plumbline::testing::photograph(striped.scene, view.camera, view.cam_from_world);
  }
  striped.views.resize(3), striped.light.resize(3);
  striped.expose(1.5, 2);
  TileOptions wide;  // heights that fit are 60 mm apart
  wide.facet.search = 0.08;
  const FacetTile several = measure_tile(striped.scene.plane, kArea, striped.facet_views(), striped.orientations, wide);
  EXPECT_LE(several.measured.points.size(), 3U) << "a pattern that repeats fits many heights";
  EXPECT_GT(several.outcomes[static_cast<size_t>(FacetOutcome::ambiguous)], 100);
  // A mirror: what each photograph shows is another thing.
  FacadeScene scene;
  Site mirror = make_site(scene);
  for (size_t k = 0; k < mirror.views.size(); ++k) {
    scene.plane = mirror.scene.plane;
    scene.reflectance = [k](double u, double v) { return plumbline::testing::plaster(u, v, 0.002, 1000 * (k + 1)); };
    mirror.light[k] = plumbline::testing::photograph(scene, mirror.views[k].camera, mirror.views[k].cam_from_world);
  }
  mirror.expose(1.5, 3);
  const FacetTile glass = measure_tile(mirror.scene.plane, kArea, mirror.facet_views(), mirror.orientations, {});
  EXPECT_LE(glass.measured.points.size(), 3U);
}

TEST(Facet, WhatIsTooLittleOrElsewhereGivesHolesAndNoSurface) {
  const Site site = make_site(FacadeScene());
  const auto outcomes = [&](const FacadePlane& plane, const std::vector<FacetView>& views) {
    return measure_tile(plane, kArea, views, site.orientations, {}).outcomes;
  };
  const std::vector<FacetView> all = site.facet_views();
  const auto few = static_cast<size_t>(FacetOutcome::too_few_views);
  const auto one = outcomes(site.scene.plane, {all[0]});
  EXPECT_GT(one[few], 100) << "one photograph";
  EXPECT_EQ(one[0], 0);
  const auto copies = outcomes(site.scene.plane, {all[0], all[1], all[0], all[1], all[1]});
  EXPECT_GT(copies[few], 100) << "two photographs and copies of them are no three that agree";
  EXPECT_EQ(copies[0], 0);
  FacadePlane elsewhere = site.scene.plane;  // where no two photographs overlap, nor any is
  elsewhere.origin += 20 * elsewhere.axes.col(0);
  EXPECT_EQ(outcomes(elsewhere, all)[0], 0);
  FacadePlane before = site.scene.plane;  // the design is 3 m off, behind the wall and before it
  for (const double out : {-3.0, 1.5}) {
    before.origin = site.scene.plane.origin + out * before.axes.col(2);
    const auto off = outcomes(before, all);
    int sum = 0;
    for (const int count : off) sum += count;
    EXPECT_LE(off[0], 0.01 * sum) << out;
  }
}

/// Two photographs have nobody who would outvote one of them: what they agree by is all there is.
TEST(Facet, TwoPhotographsOfDifferentThingsAgreeOnNothing) {
  FacadeScene scene;
  Site mirror = make_site(scene);
  mirror.views.resize(2), mirror.light.resize(2);
  for (size_t k = 0; k < 2; ++k) {
    scene.plane = mirror.scene.plane;
    scene.reflectance = [k](double u, double v) { return plumbline::testing::plaster(u, v, 0.002, 1000 * (k + 1)); };
    mirror.light[k] = plumbline::testing::photograph(scene, mirror.views[k].camera, mirror.views[k].cam_from_world);
  }
  mirror.expose(1.5, 3);
  TileOptions two;
  two.facet.min_views = 2;
  const FacetTile tile = measure_tile(mirror.scene.plane, kArea, mirror.facet_views(), mirror.orientations, two);
  // Of 192; some heights agree by chance, and there is no third photograph to contradict.
  EXPECT_LE(tile.measured.points.size(), 10U) << "a patch agrees with the mean of both whatever the other shows";
}

/// Relief that is finer than a facet: the height is that of its mean, and neighbouring places are off alike.
TEST(Facet, WhereAFacetIsNoPlaneItsSigmaSaysSo) {
  FacadeScene rough;
  rough.height = [](double u, double v) {
    return 0.0006 * std::sin(2 * M_PI * u / 0.0061) * std::sin(2 * M_PI * v / 0.0053);
  };
  const Site site = make_site(rough);
  const FacetTile tile = measure_tile(site.scene.plane, kArea, site.facet_views(), site.orientations, {});
  std::vector<double> ratios;
  for (const MeasuredPoint& point : tile.measured.points) {
    const Eigen::Vector3d local = site.scene.plane.local(tile.measured.at(point));
    ratios.push_back(std::abs(local.z()) / point.sigma);
  }
  ASSERT_GT(ratios.size(), 100U);
  const auto within = std::count_if(ratios.begin(), ratios.end(), [](double ratio) { return ratio < 3; });
  std::nth_element(ratios.begin(), ratios.begin() + static_cast<std::ptrdiff_t>(ratios.size() / 2), ratios.end());
  std::printf("relief: %zu points, median error over sigma %.2f, within 3 sigma %.3f\n", ratios.size(),
              ratios[ratios.size() / 2], static_cast<double>(within) / static_cast<double>(ratios.size()));
  EXPECT_GE(static_cast<double>(within), 0.99 * static_cast<double>(ratios.size()));
}

/// Those that agree were chosen for it: what the one that was left out shows is in the sigma of the height.
TEST(Facet, APhotographThatWasLeftOutCounts) {
  FacadeScene scene;
  Site site = make_site(scene);
  const auto sigma = [&] {
    const FacetTile tile = measure_tile(site.scene.plane, kArea, site.facet_views(), site.orientations, {});
    EXPECT_GT(tile.measured.points.size(), 100U);
    std::vector<double> sigmas;
    for (const MeasuredPoint& point : tile.measured.points) sigmas.push_back(static_cast<double>(point.sigma));
    return upper_median(sigmas);
  };
  const double undisputed = sigma();
  scene.plane = site.scene.plane;
  scene.reflectance = [](double u, double v) { return plumbline::testing::plaster(u, v, 0.002, 5000); };
  site.light[1] = plumbline::testing::photograph(scene, site.views[1].camera, site.views[1].cam_from_world);
  site.expose(1.5, 4);
  const auto map = map_at(site.views[0], site.scene.plane, {0, 0, 0}, 8);
  const Facet facet = match_facet(site.scene.plane, {0, 0}, map->ground_pixel(), 0, site.facet_views(), FacetOptions());
  ASSERT_EQ(facet.outcome, FacetOutcome::measured);
  EXPECT_EQ(facet.views.size(), site.views.size() - 1);
  EXPECT_GT(facet.set_aside, 4);
  EXPECT_GT(sigma(), 2 * undisputed);
}

}  // namespace test_facet
}  // namespace plumbline::surface

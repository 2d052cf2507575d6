// Rectified pairs and heights of cells: geometry that goes there and back, heights within their standard deviations,
// holes.
#include <gtest/gtest.h>

#include <cmath>

#include "surface/dense/orthophoto.hpp"
#include "surface/dense/pair_heights.hpp"
#include "surface_site.hpp"

namespace plumbline::surface {
namespace {

CellGrid cells_of(const Site& site) {
  CellGrid grid;
  grid.plane = site.scene.plane, grid.area = {{-0.1, -0.1}, {0.1, 0.1}}, grid.columns = grid.rows = 12;
  return grid;
}

TEST(Pairs, ARectifiedPlaceLiesInTheSameRowOfBothPhotographs) {
  const Site site = make_site({});
  const auto pairs = pairs_for(site.scene.plane, {0, 0}, site.views, 2, 10);
  ASSERT_GE(pairs.size(), 4U);
  for (const RectifiedPair& pair : pairs)
    for (const double h : {-0.03, 0.0, 0.02}) {
      const Eigen::Vector3d point = site.scene.plane.world({0.05, -0.04, h}), at = pair.rectified(point);
      EXPECT_LT((pair.world(at) - point).norm(), 1e-9);
      const View &left = site.views[pair.left], &right = site.views[pair.right];
      EXPECT_LT((*pair.source(left, at.head<2>()) - *project(left.camera, left.cam_from_world * point)).norm(), 1e-6);
      EXPECT_LT((*pair.source(right, {at.x() - at.z(), at.y()}) - *project(right.camera, right.cam_from_world * point))
                    .norm(),
                1e-6);
    }
  EXPECT_FALSE(rectified_pair(site.scene.plane, {0, 0}, site.views, 1, 1)) << "a photograph with itself";
}

/// Disparities half a pixel off, as a matcher that is drawn to whole ones gives them.
TEST(Pairs, RefinedHeightsLieWithinTheirStandardDeviationsWhereverTheyStarted) {
  plumbline::testing::FacadeScene scene;
  scene.height = [](double u, double) { return 0.004 + 0.01 * u; };
  const Site site = make_site(scene);
  const CellGrid grid = cells_of(site);
  const auto views = site.facet_views();
  const auto pairs = pairs_for(grid.plane, {0, 0}, site.views, 2, 10);
  PairOptions options;
  double squares = 0;
  int count = 0, holes = 0;
  for (size_t cell = 0; cell < grid.size(); ++cell) {
    const double truth = scene.height(grid.middle(cell).x(), 0);
    std::vector<PairHeight> said;
    for (const RectifiedPair& pair : pairs) {
      std::vector<float> near(100, static_cast<float>(truth + 0.0008));
      said.push_back(cell_height(grid, cell, near, 100, pair, views, options));
    }
    const Facet facet = agreed_facet(grid, cell, pairs, said, views, options);
    if (facet.outcome != FacetOutcome::measured) {
      ++holes;
      continue;
    }
    squares += std::pow((facet.height - truth) / facet.sigma, 2), ++count;
    EXPECT_LT(std::abs(facet.height - truth), 4e-4);
  }
  EXPECT_LT(holes, 15);
  EXPECT_GT(squares / count, 0.4);
  EXPECT_LT(squares / count, 1.7);
}

TEST(Pairs, WhatFewSayOrWhatShowsDifferentlyIsAHole) {
  plumbline::testing::FacadeScene plain;
  plain.reflectance = [](double, double) { return 0.5; };
  const Site site = make_site(plain), textured = make_site({});
  const CellGrid grid = cells_of(site);
  const auto pairs = pairs_for(grid.plane, {0, 0}, site.views, 2, 10);
  const auto facet_of = [&](const std::vector<FacetView>& views, size_t heights) {
    std::vector<PairHeight> said;
    for (const RectifiedPair& pair : pairs) {
      std::vector<float> near(heights, 0.0f);
      said.push_back(cell_height(grid, 60, near, 100, pair, views, {}));
    }
    return agreed_facet(grid, 60, pairs, said, views, {}).outcome;
  };
  EXPECT_EQ(facet_of(textured.facet_views(), 100), FacetOutcome::measured);
  EXPECT_EQ(facet_of(textured.facet_views(), 40), FacetOutcome::no_texture)
      << "the matcher is silent on most of the cell";
  EXPECT_NE(facet_of(site.facet_views(), 100), FacetOutcome::measured) << "a matcher's smooth guess on plain paint";
  std::vector<FacetView> mixed = textured.facet_views();
  for (size_t k = 0; k + 2 < mixed.size(); ++k) mixed[k].image = site.facet_views()[k].image;
  EXPECT_EQ(facet_of(mixed, 100), FacetOutcome::no_agreement);
}

/// Middle of the dark pixels on the picture's plane [m].
Eigen::Vector2d dark_middle(const Orthophoto& picture) {
  double count = 0;
  Eigen::Vector2d sum(0, 0);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const int grey = picture.grey[static_cast<size_t>(y * picture.width + x)];
      if (grey == 0 || grey > 130) continue;
      count += 1;
      sum += Eigen::Vector2d(picture.area.low.x() + (x + 0.5) * picture.pixel,
                             picture.area.high.y() - (y + 0.5) * picture.pixel);
    }
  EXPECT_GT(count, 100);
  return sum / count;
}

TEST(Orthophoto, ShowsEveryPlaceWhereItIsAndNothingThatWasNotSeen) {
  plumbline::testing::FacadeScene scene;
  scene.height = [](double, double) { return 0.01; };
  scene.reflectance = [](double u, double v) { return std::hypot(u - 0.03, v - 0.02) < 0.01 ? 0.0 : 1.0; };  // a dot
  const Site site = make_site(scene, 0);
  PanelFace face{"P", site.scene.plane, 0.2, 0.16};
  PanelSurface surface;
  surface.half_width = 0.1, surface.half_height = 0.08, surface.form(0) = 0.01;
  ASSERT_EQ(facades_of({face, face}).size(), 1U);
  Orthophoto picture = orthophoto_of({face}, {0}, 0.001, 0.02, 1e6);
  EXPECT_EQ(picture.width, 240);
  EXPECT_EQ(picture.height, 200);
  const auto views = site.facet_views();
  const int best = best_view(face, views);
  ASSERT_GE(best, 0);
  paint(face, surface, views[static_cast<size_t>(best)], 0.005, picture);
  EXPECT_EQ(picture.grey[0], 0) << "beyond the panel nothing is painted";
  const Eigen::Vector2d dot = dark_middle(picture);
  const Eigen::Vector3d at = face.plane.local(picture.plane.world({dot.x(), dot.y(), 0}));
  EXPECT_NEAR(at.x(), 0.03, 2e-4) << "a picture of the design's face would have it up to 4 mm beside";
  EXPECT_NEAR(at.y(), 0.02, 2e-4);
  EXPECT_NEAR(orthophoto_of({face}, {0}, 0.001, 0.02, 480).pixel, 0.01, 1e-9) << "no more than 480 pixels";
}

/// The picture's plane is that of its first panel: of another one, which lies deeper and leans, every place is at the
/// foot of its perpendicular on the picture's plane, and not on the panel's own.
TEST(Orthophoto, APanelThatLeansAgainstThePictureIsNotShifted) {
  plumbline::testing::FacadeScene scene;
  scene.height = [](double, double) { return 0.01; };
  scene.reflectance = [](double u, double v) { return std::hypot(u - 0.03, v - 0.02) < 0.01 ? 0.0 : 1.0; };
  const Site site = make_site(scene, 0);
  const PanelFace face{"P", site.scene.plane, 0.2, 0.16};
  const double lean = 4 * M_PI / 180;
  const PanelFace first{"first",
                        facade_plane(face.plane.world({0.1, 0, 0.2}),
                                     face.plane.axes * Eigen::Vector3d(std::sin(lean), 0, std::cos(lean))),
                        0.5, 0.4};
  ASSERT_EQ(facades_of({first, face}).size(), 1U);
  PanelSurface surface;
  surface.half_width = 0.1, surface.half_height = 0.08, surface.form(0) = 0.01;
  Orthophoto picture = orthophoto_of({first, face}, {0, 1}, 0.001, 0.02, 1e6);
  const auto views = site.facet_views();
  paint(face, surface, views[static_cast<size_t>(best_view(face, views))], 0.005, picture);
  const Eigen::Vector2d truth = picture.plane.local(face.plane.world({0.03, 0.02, 0.01})).head<2>();
  EXPECT_LT((dark_middle(picture) - truth).norm(), 2e-4) << (dark_middle(picture) - truth).transpose();
}

}  // namespace
}  // namespace plumbline::surface

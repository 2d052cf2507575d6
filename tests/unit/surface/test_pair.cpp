// Rectified pairs and heights of cells: geometry that goes there and back, heights within their standard deviations,
// holes.
#include <gtest/gtest.h>

#include <cmath>

#include "surface/dense/pair_heights.hpp"
#include "surface_site.hpp"

namespace plumbline::surface {
namespace test_pair {

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
  const std::vector<View> copies = {site.views[0], site.views[1], site.views[0], site.views[1]};
  EXPECT_EQ(from_own_places(site.scene.plane, {0, 0}, copies), (std::vector<size_t>{0, 1}));
  EXPECT_LE(pairs_for(site.scene.plane, {0, 0}, copies, 2, 10).size(), 1U) << "a copy says nothing that is new";
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

}  // namespace test_pair
}  // namespace plumbline::surface

// Points of a scan: sorted to faces, and planes with the errors that noise and registration really make.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "surface/dense/scan_tiles.hpp"

namespace plumbline::surface {
namespace test_scan_tiles {

const FacadePlane kPlane = facade_plane({105, 212, 31}, {-0.6, -0.8, 0});

std::vector<MeasuredTile> tiles_of(const std::vector<PanelFace>& faces, const std::vector<Eigen::Vector3d>& points,
                                   double sigma, const ScanPlace& place) {
  std::vector<MeasuredTile> measured;
  ScanTiles tiles(faces, 0.1, 0.5, [&](size_t t, size_t, const std::vector<MeasuredPoint>& some) {
    measured[t].points.insert(measured[t].points.end(), some.begin(), some.end());
  });
  measured.resize(tiles.tiles().size());
  for (const auto& point : points) tiles.add(point, sigma);
  tiles.flush();
  for (size_t t = 0; t < measured.size(); ++t) {
    EXPECT_EQ(measured[t].points.size(), tiles.tiles()[t].points);
    measured[t].centre = tiles.tiles()[t].centre;
    measured[t].factor = factor_of(place, measured[t].centre);
  }
  return measured;
}

TEST(ScanTiles, EveryPointGoesToTheNearestFaceOnce) {
  std::vector<PanelFace> faces(2);
  faces[0] = {"front", kPlane, 2, 3};
  faces[1] = {"side", facade_plane(kPlane.world({1.0, 0, -0.5}), kPlane.axes.col(0)), 1.2, 3};
  size_t count[2] = {0, 0};
  std::vector<size_t> face_of;
  ScanTiles tiles(faces, 0.1, 0.5,
                  [&](size_t t, size_t, const std::vector<MeasuredPoint>& some) { count[face_of[t]] += some.size(); });
  for (const ScanTile& tile : tiles.tiles()) face_of.push_back(tile.face);
  EXPECT_EQ(tiles.tiles().size(), 4U * 6 + 3 * 6);
  EXPECT_TRUE(tiles.add(kPlane.world({0.97, 0, 0.01}), 1e-3)) << "over both, nearer to the front";
  EXPECT_TRUE(tiles.add(kPlane.world({1.01, 0, -0.05}), 1e-3)) << "beyond the front's edge";
  EXPECT_FALSE(tiles.add(kPlane.world({0, 0, 0.2}), 1e-3)) << "too far before it";
  EXPECT_FALSE(tiles.add(kPlane.world({0, 1.6, 0}), 1e-3)) << "above it";
  EXPECT_FALSE(tiles.add({0, 0, 0}, 1e-3));
  for (int i = 0; i < 5000; ++i)
    EXPECT_TRUE(tiles.add(kPlane.world({0.9 * std::sin(i), 1.4 * std::cos(2.0 * i), 0}), 1e-3));
  tiles.flush();
  EXPECT_EQ(count[0], 5001U);
  EXPECT_EQ(count[1], 1U);
}

TEST(ScanTiles, PlanesHaveTheErrorsTheyStateAndMorePointsDoNotHelpAgainstTheRegistration) {
  const std::vector<PanelFace> faces = {{"panel", kPlane, 1.2, 1.0}};
  ScanPlace place;
  place.pivot = kPlane.world({3, -1, 10});
  Eigen::Matrix<double, 7, 1> sigma;
  sigma << 1e-4, 2e-4, 1e-4, 1e-3, 1e-3, 5e-4, 5e-5;
  Eigen::Matrix<double, 7, 7> correlated = Eigen::Matrix<double, 7, 7>::Identity();
  correlated(0, 4) = correlated(4, 0) = 0.6;
  place.covariance = sigma.asDiagonal() * correlated * sigma.asDiagonal();
  const Eigen::MatrixXd root = place.covariance.llt().matrixL();
  std::mt19937_64 random(7);
  std::normal_distribution<double> normal(0, 1);
  PanelOptions options;
  options.border = 0.01;
  double nees = 0;
  constexpr int trials = 200;
  for (int trial = 0; trial < trials; ++trial) {
    Eigen::VectorXd z(7);
    for (Eigen::Index i = 0; i < 7; ++i) z(i) = normal(random);
    const Eigen::VectorXd error = root * z;
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 24; ++i)
      for (int j = 0; j < 20; ++j) {
        const double u = (i + 0.5) / 24 * 1.2 - 0.6, v = (j + 0.5) / 20 - 0.5;
        const Eigen::Vector3d right = kPlane.world({u, v, 0.004 + 0.003 * u + 0.002 * normal(random)}),
                              arm = right - place.pivot;
        points.push_back(right + error.segment<3>(3) + Eigen::Vector3d(error.head<3>()).cross(arm) + error(6) * arm);
      }
    const PanelSurface panel = measure_panel(faces[0], tiles_of(faces, points, 0.002, place), options);
    ASSERT_EQ(panel.not_measured, "");
    const Eigen::Vector3d off = panel.plane - Eigen::Vector3d(0.004, 0.003, 0);
    nees += off.dot(panel.plane_covariance().ldlt().solve(off)) / 3 / trials;
    EXPECT_GT(panel.plane_systematic(0, 0), 20 * panel.plane_random(0, 0));
  }
  // 600 degrees of freedom: 99 % within 0.86 and 1.16.
  EXPECT_GT(nees, 0.85);
  EXPECT_LT(nees, 1.17);
}

TEST(ScanTiles, APlaceThatIsNoCovarianceIsRefused) {
  ScanPlace place;
  EXPECT_EQ(factor_of(place, {1, 2, 3}).cols(), 0);
  place.covariance = -Eigen::MatrixXd::Identity(6, 6);
  EXPECT_THROW(factor_of(place, {1, 2, 3}), std::invalid_argument);
  place.covariance = Eigen::MatrixXd::Identity(5, 5);
  EXPECT_THROW(factor_of(place, {1, 2, 3}), std::invalid_argument);
  EXPECT_THROW(ScanTiles({}, 0, 1, {}), std::invalid_argument);
}

}  // namespace test_scan_tiles
}  // namespace plumbline::surface

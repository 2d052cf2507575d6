// The covariance of one panel's plane, derived a second time by brute force: photographs are exposed anew and
// orientations drawn anew many times, and how the plane scatters is held against what is stated. Random and systematic
// part each by itself, because errors of one could hide in the other. Ten times as many draws with PLUMBLINE_LONG.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cstdlib>
#include <functional>

#include "surface/dense/facet_tile.hpp"
#include "surface/dense/panel_surface.hpp"
#include "surface_site.hpp"

namespace plumbline::surface {
namespace test_plane_covariance {

int draws() { return std::getenv("PLUMBLINE_LONG") ? 300 : 30; }

struct Plane {
  Site site;
  std::vector<View> right;  ///< orientations without errors
  Eigen::MatrixXd root;     ///< of their covariance
  std::mt19937_64 random{17};

  Plane() {
    plumbline::testing::FacadeScene scene;
    scene.height = [](double u, double v) { return 0.003 + 0.008 * u - 0.004 * v; };
    site = make_site(scene);
    give_orientations_errors(site);
    right = site.views;
    const Eigen::Index size = site.orientations.size();
    root = (site.orientations.matrix + 1e-18 * Eigen::MatrixXd::Identity(size, size)).llt().matrixL();
  }
  void draw_orientations() {
    std::normal_distribution<double> normal(0, 1);
    Eigen::VectorXd z(root.rows());
    for (double& value : z) value = normal(random);
    perturb(site, right, root * z);
  }
  PanelSurface measure() const {
    std::vector<FacetTile> tiles;
    for (const double left : {-0.12, 0.0})
      tiles.push_back(measure_tile(site.scene.plane, {{left, -0.1}, {left + 0.12, 0.1}}, site.facet_views(),
                                   site.orientations, {}));
    add_systematic_part(tiles, {site.scene.plane, site.scene.plane}, site.orientations);
    PanelOptions options;
    options.border = 0.005;
    return measure_panel({"panel", site.scene.plane, 0.24, 0.2}, {tiles[0].measured, tiles[1].measured}, options);
  }
};

/// How planes scatter about their mean, in units of the covariance that is stated: the identity, within what so many
/// draws leave. Each bound is 3.5 standard deviations of its statistic under normal errors.
void expect_scatter(const std::vector<Eigen::Vector3d>& planes, const Eigen::Matrix3d& stated, const char* what) {
  const double freedom = static_cast<double>(planes.size()) - 1;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& plane : planes) mean += plane / static_cast<double>(planes.size());
  const Eigen::Matrix3d whiten = Eigen::Matrix3d(stated.llt().matrixL()).inverse();
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& plane : planes) {
    const Eigen::Vector3d z = whiten * (plane - mean);
    scatter += z * z.transpose() / freedom;
  }
  EXPECT_NEAR(scatter.trace() / 3, 1, 3.5 * std::sqrt(2 / (3 * freedom))) << what << "\n" << scatter;
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(scatter(i, i), 1, 3.5 * std::sqrt(2 / freedom)) << what << " " << i << "\n" << scatter;
    for (int j = 0; j < i; ++j)
      EXPECT_NEAR(scatter(i, j), 0, 3.5 / std::sqrt(freedom)) << what << " " << i << j << "\n" << scatter;
  }
  const auto index = std::string(what) + "_mean_square";
  ::testing::Test::RecordProperty(index, std::to_string(scatter.trace() / 3));
  std::printf("%s: %zu draws, mean square over the stated covariance %.3f\n", what, planes.size(), scatter.trace() / 3);
}

TEST(PlaneCovariance, RandomPartIsWhatNewExposuresScatterBy) {
  Plane plane;
  std::vector<Eigen::Vector3d> found;
  Eigen::Matrix3d stated = Eigen::Matrix3d::Zero();
  for (int i = 0; i < draws(); ++i) {
    plane.site.expose(1.5, 500 + static_cast<std::uint64_t>(i));
    const PanelSurface panel = plane.measure();
    ASSERT_EQ(panel.not_measured, "");
    found.push_back(panel.plane), stated += panel.plane_random / draws();
  }
  expect_scatter(found, stated, "random");
}

TEST(PlaneCovariance, SystematicPartIsWhatNewOrientationsScatterBy) {
  Plane plane;
  std::vector<Eigen::Vector3d> found;
  Eigen::Matrix3d stated = Eigen::Matrix3d::Zero();
  for (int i = 0; i < draws(); ++i) {
    plane.draw_orientations();
    const PanelSurface panel = plane.measure();
    ASSERT_EQ(panel.not_measured, "");
    found.push_back(panel.plane), stated += panel.plane_systematic / draws();
  }
  expect_scatter(found, stated, "systematic");
}

}  // namespace test_plane_covariance
}  // namespace plumbline::surface

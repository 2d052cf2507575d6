// A rendered piece of a facade with the photographs' orientations: what tests of surfaces measure.
#pragma once

#include <memory>
#include <vector>

#include "facade_scene.hpp"
#include "surface/dense/facet.hpp"

namespace plumbline::surface {

struct Site {
  plumbline::testing::FacadeScene scene;
  std::vector<View> views;
  std::vector<std::vector<float>> light;
  std::vector<Pyramid> images;
  OrientationCovariance orientations;
  std::vector<FacetView> facet_views() const {
    std::vector<FacetView> list;
    for (size_t k = 0; k < views.size(); ++k) list.push_back({&views[k], &images[k]});
    return list;
  }
  void expose(double noise, std::uint64_t seed) {
    images.clear();
    for (size_t k = 0; k < light.size(); ++k)
      images.push_back(pyramid_of(
          plumbline::testing::exposed(light[k], views[k].camera.width, views[k].camera.height, noise, seed * 100 + k)));
  }
};

inline BrownCamera small_camera() {
  BrownCamera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = camera.fy = 4000, camera.cx = 321.3, camera.cy = 238.2;
  camera.k1 = -0.1, camera.k2 = 0.2, camera.p1 = 1e-4, camera.p2 = -2e-4;
  return camera;
}

/// Five photographs at 3 m: ground pixel 0.75 mm. The facade faces south-west, so that no axis is one of the world's.
inline Site make_site(plumbline::testing::FacadeScene scene, double noise = 1.5) {
  Site site;
  site.scene = std::move(scene);
  site.scene.plane = facade_plane({12.5, -3.25, 8.75}, {-0.6, -0.8, 0});
  const double places[5][3] = {{-1.1, -0.5, 3.0}, {1.2, -0.4, 3.1}, {0.1, 1.0, 2.9}, {-0.9, 0.8, 3.0}, {1.0, 0.9, 3.2}};
  for (int k = 0; k < 5; ++k) {
    View view;
    view.name = "p" + std::to_string(k);
    view.camera = small_camera();
    view.cam_from_world = plumbline::testing::looking(
        site.scene.plane.world({places[k][0], places[k][1], places[k][2]}), site.scene.plane.origin);
    view.orientation = k;
    site.views.push_back(view);
    site.light.push_back(plumbline::testing::photograph(site.scene, view.camera, view.cam_from_world));
  }
  site.expose(noise, 1);
  site.orientations.images = 5, site.orientations.cameras = 1;
  site.orientations.matrix = Eigen::MatrixXd::Zero(49, 49);
  return site;
}

/// Orientations that err by 0.05 mm and 0.02 mrad each, alike by 0.2 mm (a set-up that is off), and by 1 px in fx.
inline void give_orientations_errors(Site& site) {
  Eigen::MatrixXd& covariance = site.orientations.matrix;
  for (int k = 0; k < 5; ++k) {
    covariance.diagonal().segment<3>(8 * k).setConstant(std::pow(2e-5, 2));
    covariance.diagonal().segment<3>(8 * k + 3).setConstant(std::pow(5e-5, 2));
  }
  for (int a = 0; a < 5; ++a)  // all projection centres moved alike: dt = −R dC
    for (int b = 0; b < 5; ++b)
      covariance.block<3, 3>(8 * a + 3, 8 * b + 3) +=
          std::pow(2e-4, 2) * site.views[a].cam_from_world.rotation.toRotationMatrix() *
          site.views[b].cam_from_world.rotation.toRotationMatrix().transpose();
  covariance(40, 40) = covariance(41, 41) = covariance(40, 41) = covariance(41, 40) = 1.0;
}

/// `views` with one draw of errors of that covariance: root · z.
inline void perturb(Site& site, const std::vector<View>& views, const Eigen::VectorXd& error) {
  site.views = views;
  for (int k = 0; k < 5; ++k) {
    View& view = site.views[k];
    view.cam_from_world.rotation =
        quaternion_from_rotation_vector(error.segment<3>(8 * k)) * view.cam_from_world.rotation;
    view.cam_from_world.translation += error.segment<3>(8 * k + 3);
    view.camera.fx += error(40), view.camera.fy += error(41);
  }
}

}  // namespace plumbline::surface

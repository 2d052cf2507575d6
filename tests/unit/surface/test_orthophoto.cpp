// Orthophotos: places where they are, nothing that was not seen, and nothing that stands before a panel.
#include <gtest/gtest.h>

#include <cmath>

#include "surface/dense/panel_painter.hpp"
#include "surface_site.hpp"

namespace plumbline::surface {
namespace test_orthophoto {

/// The panel from the best photographs, at most so many.
PaintCounts paint_from(const std::vector<PanelFace>& faces, const PanelSurface& surface, const Site& site, size_t most,
                       Orthophoto& picture) {
  const auto all = site.facet_views();
  std::vector<PaintView> views;
  for (const size_t number : views_for_picture(faces[0], all))
    if (views.size() < most)
      views.push_back({all[number], Screens(faces, 0, all[number].view->cam_from_world.inverse().translation, 0.005)});
  const PanelPainter painter(faces[0], surface, views, 0.005, picture);
  PaintCounts counts;
  for (int row = 0; row < painter.rows(); row += 50)  // in pieces, whose seams must not show
    counts += painter.paint(painter.first_row() + row, painter.first_row() + std::min(row + 50, painter.rows()));
  return counts;
}

void paint_from_best(const PanelFace& face, const PanelSurface& surface, const Site& site, Orthophoto& picture) {
  EXPECT_GT(paint_from({face}, surface, site, 1, picture).unchecked, 0);
}

/// Middle of the dark pixels on the picture's plane [m].
Eigen::Vector2d dark_middle(const Orthophoto& picture) {
  double count = 0;
  Eigen::Vector2d sum(0, 0);
  for (int y = 0; y < picture.height; ++y)
    for (int x = 0; x < picture.width; ++x) {
      const int grey = picture.grey[y * picture.width + x];
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
  paint_from_best(face, surface, site, picture);
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
  paint_from_best(face, surface, site, picture);
  const Eigen::Vector2d truth = picture.plane.local(face.plane.world({0.03, 0.02, 0.01})).head<2>();
  EXPECT_LT((dark_middle(picture) - truth).norm(), 2e-4) << (dark_middle(picture) - truth).transpose();
}

/// A flat textured panel of 0.2 m x 0.16 m.
struct Panel {
  Site site;
  PanelFace face;
  PanelSurface surface;
  Panel() {
    plumbline::testing::FacadeScene scene;
    scene.reflectance = [](double u, double v) { return plumbline::testing::plaster(u, v, 0.004); };
    site = make_site(scene, 0);
    face = {"P", site.scene.plane, 0.2, 0.16};
    surface.half_width = 0.1, surface.half_height = 0.08;
  }
  Orthophoto empty() const { return orthophoto_of({face}, {0}, 0.001, 0.005, 1e6); }
};

/// A dark upright bar between u0 and u1, `height` before the facade, in all photographs.
void put_bar_before(Site& site, double u0, double u1, double height) {
  for (size_t k = 0; k < site.views.size(); ++k) {
    const View& view = site.views[k];
    const RigidTransform world_from_cam = view.cam_from_world.inverse();
    const Eigen::Vector3d eye = site.scene.plane.local(world_from_cam.translation);
    for (int y = 0; y < view.camera.height; ++y)
      for (int x = 0; x < view.camera.width; ++x) {
        const auto ray = unproject(view.camera, {static_cast<double>(x), static_cast<double>(y)});
        const Eigen::Vector3d along =
            site.scene.plane.axes.transpose() * (world_from_cam.rotation * Eigen::Vector3d(ray->x(), ray->y(), 1));
        const double u = (eye + along * ((height - eye.z()) / along.z())).x();
        if (u > u0 && u < u1)
          site.light[k][static_cast<size_t>(y) * static_cast<size_t>(view.camera.width) + static_cast<size_t>(x)] = 0;
      }
  }
  site.expose(0, 1);
}

/// Pixels that are shown and lie more than 25 grey values beside all that the clean picture has within a pixel: another
/// photograph has other pixels there.
int wrong_pixels(const Orthophoto& picture, const Orthophoto& clean) {
  int wrong = 0;
  for (int y = 8; y + 8 < picture.height; ++y)  // on the panel: 5 mm around it are joints
    for (int x = 8; x + 8 < picture.width; ++x) {
      const auto at = [&](const Orthophoto& of, int dx, int dy) {
        return int{of.grey[static_cast<size_t>(y + dy) * static_cast<size_t>(of.width) + static_cast<size_t>(x + dx)]};
      };
      int low = 255, high = 0;
      for (const int dy : {-1, 0, 1})
        for (const int dx : {-1, 0, 1})
          low = std::min(low, at(clean, dx, dy)), high = std::max(high, at(clean, dx, dy));
      const int grey = at(picture, 0, 0);
      wrong += grey > 0 && low > 0 && (grey < low - 25 || grey > high + 25);
    }
  return wrong;
}

TEST(Orthophoto, WhatStandsBeforeAPanelIsNotPaintedOntoIt) {
  Panel panel;
  Orthophoto clean = panel.empty();
  const PaintCounts undisturbed = paint_from({panel.face}, panel.surface, panel.site, 5, clean);
  EXPECT_GT(undisturbed.agreed, 0.999 * static_cast<double>(undisturbed.all()))
      << undisturbed.contradicted << " contradicted, " << undisturbed.unchecked << " unchecked";
  put_bar_before(panel.site, -0.015, 0.015, 0.25);
  Orthophoto alone = panel.empty(), checked = panel.empty(), two = panel.empty();
  paint_from({panel.face}, panel.surface, panel.site, 1, alone);
  EXPECT_GT(wrong_pixels(alone, clean), 1000) << "one photograph shows the bar on the panel";
  const PaintCounts counts = paint_from({panel.face}, panel.surface, panel.site, 5, checked);
  EXPECT_LE(wrong_pixels(checked, clean), 40) << "of 32000; pixels at the bar's blurred edge";
  EXPECT_GT(counts.agreed, 0.97 * static_cast<double>(counts.all()));
  // Of two nobody knows which one shows the panel: black, not a guess.
  const PaintCounts contradicting = paint_from({panel.face}, panel.surface, panel.site, 2, two);
  EXPECT_GT(contradicting.contradicted, 2000);
  EXPECT_LE(wrong_pixels(two, clean), 40);
  EXPECT_EQ(two.grey.size(), two.shown.size());
  for (size_t i = 0; i < two.grey.size(); ++i)
    EXPECT_EQ(two.grey[i] == 0, two.shown[i] == Shown::unseen || two.shown[i] == Shown::contradicted) << i;
}

TEST(Orthophoto, PhotographsOfAnotherBrightnessDoNotContradict) {
  Panel panel;
  for (size_t k = 0; k < panel.site.light.size(); ++k)
    for (float& light : panel.site.light[k])
      light = (0.6f + 0.1f * static_cast<float>(k)) * light + 0.05f * static_cast<float>(k % 2);
  panel.site.expose(1.5, 1);
  Orthophoto picture = panel.empty();
  const PaintCounts counts = paint_from({panel.face}, panel.surface, panel.site, 5, picture);
  EXPECT_GT(counts.agreed, 0.99 * static_cast<double>(counts.all())) << counts.contradicted;
}

TEST(Orthophoto, WhatAnotherPanelHidesIsNotSeen) {
  Panel panel;
  // A wide panel 0.1 m before the left half hides the left of it from every photograph.
  const PanelFace before{"before", facade_plane(panel.face.plane.world({-1.02, 0, 0.1}), panel.face.plane.axes.col(2)),
                         2, 4};
  // Beside it, one that hides nothing, and one behind the facade.
  const PanelFace beside{
      "beside", facade_plane(panel.face.plane.world({0.215, 0, 0.004}), panel.face.plane.axes.col(2)), 0.2, 0.16};
  const PanelFace behind{"behind", facade_plane(panel.face.plane.world({0, 0, -0.3}), panel.face.plane.axes.col(2)), 2,
                         2};
  Orthophoto picture = panel.empty(), free = panel.empty();
  EXPECT_EQ(paint_from({panel.face, beside, behind}, panel.surface, panel.site, 5, free).unseen, 0);
  paint_from({panel.face, beside, before, behind}, panel.surface, panel.site, 5, picture);
  int hidden_shown = 0, open_hidden = 0;
  for (int y = 10; y + 10 < picture.height; ++y)
    for (int x = 10; x + 10 < picture.width; ++x) {
      const Eigen::Vector3d place = picture.plane.world(
          {picture.area.low.x() + (x + 0.5) * picture.pixel, picture.area.high.y() - (y + 0.5) * picture.pixel, 0});
      bool seen = false;  // by any photograph: the way crosses the plane of `before` beside it
      for (const View& view : panel.site.views) {
        const Eigen::Vector3d from = before.plane.local(view.cam_from_world.inverse().translation),
                              to = before.plane.local(place);
        const Eigen::Vector3d at = from + from.z() / (from.z() - to.z()) * (to - from);
        seen = seen || std::abs(at.x()) > 0.5 * before.width || std::abs(at.y()) > 0.5 * before.height;
      }
      const bool shown =
          picture.grey[static_cast<size_t>(y) * static_cast<size_t>(picture.width) + static_cast<size_t>(x)] > 0;
      hidden_shown += shown && !seen, open_hidden += !shown && seen;
    }
  EXPECT_EQ(hidden_shown, 0);
  EXPECT_EQ(open_hidden, 0);
  EXPECT_GT(std::count(picture.shown.begin(), picture.shown.end(), Shown::unseen), 1000);
}

TEST(Orthophoto, PhotographsFromOnePlaceComeLast) {
  Panel panel;
  panel.site.views.push_back(panel.site.views[views_for_picture(panel.face, panel.site.facet_views())[0]]);
  panel.site.images.push_back(panel.site.images[0]);
  const auto order = views_for_picture(panel.face, panel.site.facet_views());
  ASSERT_EQ(order.size(), 6U);
  EXPECT_EQ(order.back(), 5U) << "what stands before the panel is at the same place in both";
}

}  // namespace test_orthophoto
}  // namespace plumbline::surface

// What simulate.facade photographs, by the geometry of rays written out a second time.
#include <gtest/gtest.h>

#include <cmath>

#include "panelled_facade.hpp"

namespace plumbline::simulate {
namespace test_panelled_facade {

/// Before the facade, `distance` out of it at (0.4, -0.2), looking straight at it; no lens errors.
struct View {
  double distance = 10, focal = 90;
  int width = 120, height = 90;
  Eigen::Vector3d centre{0.4, -0.2, 10};

  View(double out, double f, int w, int h, double right = 0.4)
      : distance(out), focal(f), width(w), height(h), centre(right, -0.2, out) {}
  BrownCamera camera() const {
    BrownCamera lens;
    lens.width = width, lens.height = height, lens.fx = lens.fy = focal;
    lens.cx = 0.5 * (width - 1), lens.cy = 0.5 * (height - 1);
    return lens;
  }
  std::vector<std::uint8_t> of(const PanelledFacade& facade) const {
    RigidTransform facade_from_cam;
    Eigen::Matrix3d axes;  // columns: right, down and forward of the camera
    axes << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    facade_from_cam.rotation = Eigen::Quaterniond(axes), facade_from_cam.translation = centre;
    return photograph(facade, camera(), (facade.world_from_facade * facade_from_cam).inverse(), {0, 2, 1});
  }
  /// Where the ray of a pixel meets the plane offset + a (u - u0) + b (v - v0).
  Eigen::Vector2d meets(int x, int y, const RaisedPanel& panel) const {
    const Eigen::Vector2d ray((x - 0.5 * (width - 1)) / focal, -(y - 0.5 * (height - 1)) / focal);
    const double way =
        (distance - panel.offset - panel.tilt_u * (centre.x() - panel.u) - panel.tilt_v * (centre.y() - panel.v)) /
        (1 + panel.tilt_u * ray.x() + panel.tilt_v * ray.y());
    return centre.head<2>() + way * ray;
  }
};

RaisedPanel plain_panel(double width, double height) {
  RaisedPanel panel;
  panel.u = 0.43, panel.v = -0.17, panel.width = width, panel.height = height, panel.skin = Skin::plain;
  return panel;
}

/// Every pixel whose ray meets the panel shows it, to its edges, and no other: but for those that an edge goes through.
void expect_shown(const View& view, const RaisedPanel& panel) {
  PanelledFacade facade;
  facade.world_from_facade.rotation = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized());
  facade.world_from_facade.translation = {100, 200, 30};
  facade.panels = {panel};
  const auto grey = view.of(facade);
  int shown = 0, beside = 0, wrong = 0;
  const double pixel = 1.1 * view.distance / view.focal;
  for (int y = 0; y < view.height; ++y)
    for (int x = 0; x < view.width; ++x) {
      const Eigen::Vector2d at = view.meets(x, y, panel);
      const double beyond =
          std::max(std::abs(at.x() - panel.u) - 0.5 * panel.width, std::abs(at.y() - panel.v) - 0.5 * panel.height);
      const int value = grey[static_cast<size_t>(y) * view.width + x];
      if (beyond < -pixel) ++shown, wrong += value != 141;  // 20 + 220 * 0.55
      if (beyond > pixel) ++beside, wrong += value > 40;    // the dark ground of the joints
    }
  EXPECT_EQ(wrong, 0) << panel.width << " x " << panel.height;
  EXPECT_GT(shown, 200);
  EXPECT_GT(beside, 500);
}

TEST(PanelledFacade, APanelIsShownToItsEdgesHoweverWideItIs) {
  for (const auto& [width, height] : {std::pair(6.2, 4.4), {1.9, 0.8}, {0.8, 3.1}}) {
    RaisedPanel panel = plain_panel(width, height);
    panel.offset = 0.02;
    expect_shown(View(10, 140, 140, 110), panel);
  }
}

TEST(PanelledFacade, ATiltedPanelIsShownWhereItsFaceIs) {
  RaisedPanel panel = plain_panel(0.7, 0.5);
  panel.offset = 0.01, panel.tilt_u = 0.05, panel.tilt_v = -0.04;
  expect_shown(View(2, 900, 500, 400), panel);
  panel.tilt_u = -0.05, panel.offset = -0.02;
  expect_shown(View(2, 900, 500, 400), panel);
}

/// The best plane of a panel is offset and tilts, whatever it is bowed by; its middle lies a bow above its edges.
TEST(PanelledFacade, FiguresOfAPanelAreThoseOfItsBestPlane) {
  RaisedPanel panel = plain_panel(1.4, 0.6);
  panel.offset = 0.002, panel.tilt_u = 0.003, panel.tilt_v = -0.001, panel.bow_u = 0.004, panel.bow_v = -0.0015;
  constexpr int n = 200;
  double mean = 0, along = 0, up = 0, squares_along = 0, squares_up = 0;
  for (int i = 0; i < n; ++i)
    for (int k = 0; k < n; ++k) {
      const double x = ((i + 0.5) / n - 0.5) * panel.width, y = ((k + 0.5) / n - 0.5) * panel.height;
      const double z = panel.at(panel.u + x, panel.v + y);
      mean += z / (n * n), along += x * z, up += y * z, squares_along += x * x, squares_up += y * y;
    }
  EXPECT_NEAR(mean, 0.002, 1e-7);
  EXPECT_NEAR(along / squares_along, 0.003, 1e-9);
  EXPECT_NEAR(up / squares_up, -0.001, 1e-9);
  const auto bow = [&](double half_u, double half_v) {
    return panel.at(panel.u, panel.v) -
           0.5 * (panel.at(panel.u + half_u, panel.v + half_v) + panel.at(panel.u - half_u, panel.v - half_v));
  };
  EXPECT_NEAR(bow(0.7, 0), 0.004, 1e-12);
  EXPECT_NEAR(bow(0, 0.3), -0.0015, 1e-12);
}

/// Plaster looks the same from everywhere; what glass shows lies elsewhere, and moves with who looks.
TEST(PanelledFacade, GlassLooksOtherFromElsewhere) {
  const auto difference = [](Skin skin) {
    PanelledFacade facade;
    facade.finest = 0.05;
    RaisedPanel panel = plain_panel(1.6, 1.2);
    panel.skin = skin, panel.grain = 5;
    facade.panels = {panel};
    const View left(3, 400, 300, 240, 0.1), right(3, 400, 300, 240, 0.7);
    const auto a = left.of(facade), b = right.of(facade);
    double sum = 0;
    int count = 0;
    // 0.6 m between them are 80 pixels of what lies in the facade's plane.
    for (int y = 60; y < 180; ++y)
      for (int x = 110; x < 190; ++x) {
        const int there = a[static_cast<size_t>(y) * 300 + x + 40], here = b[static_cast<size_t>(y) * 300 + x - 40];
        sum += std::abs(there - here), ++count;
      }
    return sum / count;
  };
  EXPECT_LT(difference(Skin::plaster), 1);
  EXPECT_GT(difference(Skin::glass), 5);
}

TEST(PanelledFacade, NoiseOfGreyValuesIsAsItIsAsked) {
  PanelledFacade facade;
  facade.panels = {plain_panel(60, 60)};
  const View view(5, 200, 200, 150);
  RigidTransform facade_from_cam;
  Eigen::Matrix3d axes;
  axes << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  facade_from_cam.rotation = Eigen::Quaterniond(axes), facade_from_cam.translation = view.centre;
  const auto grey = photograph(facade, view.camera(), facade_from_cam.inverse(), {6, 1, 3});
  double sum = 0, squares = 0;
  for (const std::uint8_t value : grey) sum += value, squares += value * value;
  const auto n = static_cast<double>(grey.size());
  EXPECT_NEAR(sum / n, 141, 0.2);
  EXPECT_NEAR(std::sqrt(squares / n - sum / n * (sum / n)), 6, 0.15);
}

}  // namespace test_panelled_facade
}  // namespace plumbline::simulate

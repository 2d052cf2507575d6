// What stands behind the anchors of an elevation: at its place, of this facade only, and as its files say.
#include <gtest/gtest.h>

#include <map>
#include <stdexcept>

#include "show/report/facade_backdrop.hpp"

namespace plumbline::report {
namespace test_facade_backdrop {

const std::map<std::string, std::string> kFolder = {
    {"facades.csv",
     "facade,width,height,pixel_m,origin_x,origin_y,origin_z,right_x,right_y,right_z,up_x,up_y,up_z\n"
     "facade_1,400,300,0.01,10,20,5,1,0,0,0,0,1\n"},
    {"facade_1.tfw", "0.01\n0\n0\n-0.01\n-1.995\n1.495\n"},
    {"facade_1.jpg", "Man"}};

std::vector<FacadePicture> pictures_of(const std::map<std::string, std::string>& folder) {
  return facade_pictures([&](const std::string& name) { return folder.at(name); });
}

/// A metre is 100 px; the facade looks to −y.
Eigen::Vector2d drawn(const Eigen::Vector3d& at) { return {100 * at.x(), 1000 - 100 * at.z()}; }
const LookedAt kBefore{{0, -1, 0}, {10, 20, 5}};

TEST(FacadeBackdrop, APictureStandsWhereItsFilesSay) {
  const auto pictures = pictures_of(kFolder);
  ASSERT_EQ(pictures.size(), 1U);
  EXPECT_NEAR(pictures[0].low_u, -2, 1e-9);
  EXPECT_NEAR(pictures[0].low_v, -1.5, 1e-9);
  Markup svg;
  EXPECT_TRUE(draw_pictures(svg, pictures, kBefore, drawn));
  // From x 8 to 12 m and z 3.5 to 6.5 m; "Man" is TWFu in base64.
  EXPECT_NE(svg.str().find("x=\"800\" y=\"350\" width=\"400\" height=\"300\""), std::string::npos) << svg.str();
  EXPECT_NE(svg.str().find("href=\"data:image/jpeg;base64,TWFu\""), std::string::npos) << svg.str();
}

TEST(FacadeBackdrop, WhatIsOfAnotherFacadeIsNotDrawn) {
  const auto pictures = pictures_of(kFolder);
  for (const LookedAt& other :
       {LookedAt{{1, 0, 0}, {10, 20, 5}}, LookedAt{{0, 1, 0}, {10, 20, 5}}, LookedAt{{0, -1, 0}, {10, 24, 5}}}) {
    Markup svg;
    EXPECT_FALSE(draw_pictures(svg, pictures, other, drawn));
    EXPECT_EQ(svg.str(), "");
  }
}

TEST(FacadeBackdrop, AFolderThatIsNoneIsRefusedWithWhatToDo) {
  auto broken = kFolder;
  broken["facade_1.tfw"] = "0.01\n0\n";
  try {
    pictures_of(broken);
    FAIL() << "read";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("connect its port 'folder'"), std::string::npos) << error.what();
  }
}

TEST(FacadeBackdrop, PanelsAreColouredAndThoseNotMeasuredAreGrey) {
  SurfacesT surfaces;
  for (const bool measured : {true, false}) {
    auto panel = std::make_unique<PanelSurfaceFiguresT>();
    panel->face = std::make_unique<SurfaceFaceT>();
    panel->face->id = measured ? "A" : "B";
    panel->face->origin = {measured ? 9.0 : 11.0, 20, 5};
    panel->face->right = {1, 0, 0}, panel->face->up = {0, 0, 1}, panel->face->out = {0, -1, 0};
    panel->face->width = panel->face->height = 1;
    if (measured) panel->coefficients = {0, 0.004, 0, 0, 0, 0}, panel->offset = 0;
    if (!measured) panel->not_measured = "no point was measured on it";
    surfaces.panels.push_back(std::move(panel));
  }
  Markup svg;
  ASSERT_TRUE(draw_heat(svg, surfaces, kBefore, drawn));
  const std::string& text = svg.str();
  EXPECT_NE(text.find("B: not measured, no point was measured on it"), std::string::npos);
  size_t polygons = 0;
  for (size_t at = text.find("<polygon"); at != std::string::npos; at = text.find("<polygon", at + 1)) ++polygons;
  EXPECT_EQ(polygons, static_cast<size_t>(kHeatCells * kHeatCells) + 1);
  // It leans: blue at the left, which is drawn first, red at the right.
  EXPECT_EQ(heat_colour(-0.005, 0.005), "rgb(33,102,172)");
  EXPECT_EQ(heat_colour(0.005, 0.005), "rgb(178,24,43)");
  EXPECT_LT(text.find(heat_colour(-0.0035, heat_range(surfaces))),
            text.find(heat_colour(0.0035, heat_range(surfaces))));
  Markup other;
  EXPECT_FALSE(draw_heat(other, surfaces, {{1, 0, 0}, {10, 20, 5}}, drawn));
}

}  // namespace test_facade_backdrop
}  // namespace plumbline::report

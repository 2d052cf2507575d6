// The page of surfaces: every panel on its elevation, measured or not, and joints with their extreme places.
#include <gtest/gtest.h>

#include <cmath>

#include "show/report/surface_page.hpp"

namespace plumbline::report {
namespace test_surface_page {

std::unique_ptr<PanelSurfaceFiguresT> panel_at(const std::string& name, double u, const Eigen::Vector3d& out) {
  auto panel = std::make_unique<PanelSurfaceFiguresT>();
  panel->face = std::make_unique<SurfaceFaceT>();
  SurfaceFaceT& face = *panel->face;
  face.id = name, face.out = out, face.up = {0, 0, 1}, face.right = face.up.cross(out);
  face.origin = u * face.right, face.width = 1, face.height = 2;
  panel->offset = 0.004, panel->coefficients = {0.004, 0, 0, 0, 0, 0};
  return panel;
}

TEST(SurfacePage, ShowsFacadesApartAndWhatWasNotMeasured) {
  SurfacesT surfaces;
  surfaces.panels.push_back(panel_at("A<1>", 0, {0, -1, 0}));
  surfaces.panels.push_back(panel_at("A2", 1.02, {0, -1, 0}));
  surfaces.panels.push_back(panel_at("B1", 0, {1, 0, 0}));
  surfaces.panels[1]->not_measured = "no point was measured on it";
  auto joint = std::make_unique<JointFiguresT>();
  joint->first = "A<1>", joint->second = "A2", joint->nominal_width = 0.012, joint->looked_at = 9,
  joint->upright = true;
  for (const double width : {0.0101, 0.0132}) {
    joint->places.push_back(std::make_unique<JointPlaceT>());
    joint->places.back()->width = width, joint->places.back()->width_sigma = 2e-4,
    joint->places.back()->along = 10 * width;
  }
  joint->narrowest = 0, joint->widest = 1, joint->largest_step = 0;
  surfaces.joints.push_back(std::move(joint));
  const std::string page = render_surface_page(surfaces, nullptr, "Surfaces");
  const auto count = [&](const std::string& part) {
    int found = 0;
    for (size_t at = 0; (at = page.find(part, at)) != std::string::npos; ++at) ++found;
    return found;
  };
  EXPECT_EQ(count("Elevation of "), 2);
  EXPECT_EQ(count("rgb("), 64 * 2 + 30) << "two measured panels and the bar of colours";
  EXPECT_EQ(count("A&lt;1&gt;: +4.00 mm out of the design"), 1);
  EXPECT_EQ(count("A2: not measured, no point was measured on it"), 1);
  EXPECT_EQ(count("10.10 ± 0.20"), 1);
  EXPECT_EQ(count("13.20 ± 0.20"), 1);
  EXPECT_EQ(count("2 of 9"), 1);
  EXPECT_EQ(count("Why it is not measured"), 0);
  surfaces.joints[0]->not_measured = "an edge is hidden";
  const std::string hidden = render_surface_page(surfaces, nullptr, "Surfaces");
  EXPECT_NE(hidden.find("Why it is not measured"), std::string::npos);
  EXPECT_NE(hidden.find("an edge is hidden"), std::string::npos);
  EXPECT_EQ(count("nan"), 0) << "no step where a panel was not measured";
}

}  // namespace test_surface_page
}  // namespace plumbline::report

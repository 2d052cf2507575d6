// Cameras and points in space on a plain canvas: no library and no WebGL, so it runs wherever the page opens.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "show/report/image_block_drawing.hpp"
#include "show/report/page_style.hpp"
#include "show/report/script_data.hpp"

namespace plumbline::report {

void draw_space(Markup& html, const std::vector<DrawnCamera>& cameras, const std::vector<DrawnPoint>& points) {
  if (points.size() < 3 || cameras.empty()) return;
  Eigen::Vector3d middle = Eigen::Vector3d::Zero(), forward = Eigen::Vector3d::Zero();
  for (const auto& p : points) middle += p.position / static_cast<double>(points.size());
  for (const auto& c : cameras) forward += c.forward;
  // Up is that of the frame unless the cameras look along it.
  const Eigen::Vector3d towards = -forward.normalized();
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  if (!(std::abs(towards.z()) < 0.9)) up = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d right = up.cross(towards.allFinite() ? towards : Eigen::Vector3d(1, 0, 0)).normalized();
  std::string list, seen;
  for (const auto& p : points)
    if (p.position.allFinite())
      list += (list.empty() ? "" : ",") + ("{\"n\":" + script_text(p.name)) +
              ",\"p\":" + script_vector(p.position - middle, 5) + "}";
  for (const auto& c : cameras)
    if (c.centre.allFinite() && c.forward.allFinite())
      seen += (seen.empty() ? "" : ",") + ("{\"n\":" + script_text(c.name)) +
              ",\"p\":" + script_vector(c.centre - middle, 5) + ",\"d\":" + script_vector(c.forward, 5) + "}";
  {
    Scope figure(html, "figure", {{"id", "space"}, {"hidden", "hidden"}, {"class", "screen"}});
    html.element("canvas",
                 {{"id", "space-canvas"},
                  {"width", "1040"},
                  {"height", "520"},
                  {"style", "max-width:100%"},
                  {"role", "img"},
                  {"aria-label", "Cameras and points in space; all numbers stand in the tables"}},
                 "");
    html.element("p", {{"class", "note"}}, "Drag to turn, wheel to zoom, tap a camera or a point for its name.");
  }
  html.open("script", {{"type", "application/json"}, {"id", "space-data"}})
      .raw("{\"axes\":[" + script_vector(right, 5) + "," + script_vector(up, 5) + "," +
           script_vector(right.cross(up), 5) + "],\"points\":[" + list + "],\"cameras\":[" + seen + "]}")
      .close();
  html.open("script").raw(image_block_script).close();
}

}  // namespace plumbline::report

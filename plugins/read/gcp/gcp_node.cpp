#include "gcp_node.hpp"

#include <cmath>
#include <cstdio>
#include <vector>

#include "base/text/csv_table.hpp"
#include "base/text/text.hpp"
#include "base/text/whole_file.hpp"
#include "control/points/control_files.hpp"
#include "control/points/image_points.hpp"
#include "control/points/openmvs_gcp.hpp"

namespace plumbline::gcp {
namespace {

using control::ControlPoint;
using control::ImagePoint;

struct Content {
  std::vector<ControlPoint> points;
  std::vector<ImagePoint> measured;  ///< pixels as they are written
  bool from_corner = false;          ///< what the format counts from
};

Content parse(const std::string& text, const std::string& file) {
  Content gcp;
  if (control::looks_like_openmvs_gcp(text)) {
    gcp.points = control::parse_control(text, file).points;
    for (const auto& row : control::parse_openmvs_gcp(text, file))
      gcp.measured.push_back({row.image, row.point, row.pixel, 0});
    return gcp;
  }
  try {
    gcp.points = control::parse_control(text, file).points;
    gcp.measured = control::parse_image_points(text, file, false);
    gcp.from_corner = true;
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string(error.what()) +
                             ". Expected is OpenDroneMap's gcp_list.txt, whose first line is a projection and whose "
                             "others are x y z column row image [name], or openMVS's table");
  }
  return gcp;
}

std::string control_csv(const std::vector<ControlPoint>& points) {
  std::string text = "name,E,N,H,sigma_E,sigma_N,sigma_H\n", without = "name,E,N,H\n";
  bool accurate = true;
  for (const ControlPoint& p : points) {
    const std::string row = text::csv_field(p.name) + "," + text::format_fixed(p.position.x(), 6) + "," +
                            text::format_fixed(p.position.y(), 6) + "," + text::format_fixed(p.position.z(), 6);
    without += row + "\n";
    accurate = accurate && p.sigma.allFinite();
    text += row + "," + text::format_fixed(p.sigma.x(), 6) + "," + text::format_fixed(p.sigma.y(), 6) + "," +
            text::format_fixed(p.sigma.z(), 6) + "\n";
  }
  return accurate ? text : without;
}

std::string measured_csv(const std::vector<ImagePoint>& measured, double shift) {
  std::string text = "image,point,x,y\n";
  for (const ImagePoint& m : measured)
    text += text::csv_field(m.image) + "," + text::csv_field(m.point) + "," +
            text::format_fixed(m.pixel.x() - shift, 4) + "," + text::format_fixed(m.pixel.y() - shift, 4) + "\n";
  return text;
}

FileT table(const std::string& name, const std::string& text) {
  FileT file;
  file.name = name, file.media_type = "text/csv";
  file.content.assign(text.begin(), text.end());
  return file;
}

}  // namespace

void ReadGcp::run(Context& context) {
  const Content gcp = parse(text::read_whole(file->path), file->path);
  PointsT result;
  std::size_t unknown = 0;
  for (const ControlPoint& p : gcp.points) {
    auto point = std::make_unique<PointT>();
    point->id = p.name, point->position = p.position, point->sigma = p.sigma, point->role = "control";
    unknown += p.sigma.allFinite() ? 0 : 1;
    result.points.push_back(std::move(point));
  }
  if (unknown > 0 && unknown < gcp.points.size())
    context.warn(file->path + ": " + std::to_string(unknown) + " of " + std::to_string(gcp.points.size()) +
                 " points have no accuracy; control.csv then has none of any");
  const bool from_corner = *pixel_origin == "by_format" ? gcp.from_corner : *pixel_origin == "corner";
  points.commit(result);
  control.commit(table("control.csv", control_csv(gcp.points)));
  measured.commit(table("measured.csv", measured_csv(gcp.measured, from_corner ? 0.5 : 0)));
}

}  // namespace plumbline::gcp

PLUMBLINE_PLUGIN("gcp", PLUMBLINE_BUILD_ID, "MIT", plumbline::gcp::ReadGcp)

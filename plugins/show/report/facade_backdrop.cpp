#include "show/report/facade_backdrop.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "show/report/format.hpp"
#include "show/report/plot.hpp"

namespace plumbline::report {
namespace {

std::string base64(const std::string& bytes) {
  static constexpr char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t three = 0;
    for (std::size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    for (std::size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : digits[three >> (18 - 6 * k) & 63];
  }
  return text;
}

/// Corners of a part of a panel, x and y from −1 to 1, as points of a polygon.
std::string part_points(const SurfaceFaceT& face, const Drawn& drawn, double x0, double x1, double y0, double y1) {
  std::string points;
  for (const auto& [x, y] : {std::pair(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}}) {
    const Eigen::Vector2d at = drawn(face.origin + 0.5 * x * face.width * face.right + 0.5 * y * face.height * face.up);
    points += (points.empty() ? "" : " ") + px(at.x()) + "," + px(at.y());
  }
  return points;
}

}  // namespace

/// Height of a panel over its design at x and y from −1 to 1 [m].
double surface_height(const PanelSurfaceFiguresT& panel, double x, double y) {
  const std::array<double, 6> base = {1, x, y, 1 - x * x, 1 - y * y, x * y};
  double height = 0;
  for (size_t i = 0; i < std::min(base.size(), panel.coefficients.size()); ++i)
    height += panel.coefficients[i] * base[i];
  return height;
}

bool is_measured(const PanelSurfaceFiguresT& panel) {
  return panel.not_measured.empty() && panel.coefficients.size() == 6;
}

/// What the colours end at: all panels of the page share it [m].
double heat_range(const SurfacesT& surfaces) {
  double largest = 5e-4;
  for (const auto& panel : surfaces.panels)
    if (is_measured(*panel))
      for (const double x : {-1.0, 0.0, 1.0})
        for (const double y : {-1.0, 0.0, 1.0}) largest = std::max(largest, std::abs(surface_height(*panel, x, y)));
  return round_up(largest);
}

/// Blue behind the design, white on it, red before it: also apart for eyes that do not tell red from green.
std::string heat_colour(double height, double range) {
  const double t = std::clamp(height / range, -1.0, 1.0);
  const std::array<double, 3> white = {247, 247, 247}, blue = {33, 102, 172}, red = {178, 24, 43};
  std::string colour = "rgb(";
  for (size_t c = 0; c < 3; ++c) {
    const double end = t < 0 ? blue[c] : red[c];
    colour += std::to_string(std::lround(white[c] + std::abs(t) * (end - white[c]))) + (c < 2 ? "," : ")");
  }
  return colour;
}

void draw_heat_bar(Markup& html, double range) {
  const Scope svg = drawing(html, 360, 40, "What the colours mean");
  for (int i = 0; i < 30; ++i)
    html.empty("rect", {{"x", px(30 + 10 * i)},
                        {"y", "4"},
                        {"width", "10.3"},
                        {"height", "14"},
                        {"fill", heat_colour((i + 0.5) / 15 * range - range, range)}});
  for (const double part : {-1.0, 0.0, 1.0})
    html.element("text", {{"x", px(180 + 150 * part)}, {"y", "34"}, {"text-anchor", "middle"}, {"font-size", "12"}},
                 signed_mm(part * range, 1) + (part == 0 ? " mm" : ""));
}

bool LookedAt::shows(const Eigen::Vector3d& other_out, const Eigen::Vector3d& other_place) const {
  return out.dot(other_out) > std::cos(10 * M_PI / 180) && std::abs(out.dot(other_place - place)) < 1.5;
}

void draw_jpeg(Markup& svg, const std::string& jpeg, double x, double y, double width, double height) {
  svg.empty("image", {{"x", px(x)},
                      {"y", px(y)},
                      {"width", px(width)},
                      {"height", px(height)},
                      {"preserveAspectRatio", "none"},
                      {"href", "data:image/jpeg;base64," + base64(jpeg)}});
}

bool draw_pictures(Markup& svg, const std::vector<FacadePicture>& pictures, const LookedAt& at, const Drawn& drawn) {
  bool any = false;
  for (const FacadePicture& picture : pictures) {
    if (!at.shows(picture.out(),
                  picture.place(0.5 * (picture.low_u + picture.high_u), 0.5 * (picture.low_v + picture.high_v))))
      continue;
    const Eigen::Vector2d corner = drawn(picture.place(picture.low_u, picture.high_v)),
                          other = drawn(picture.place(picture.high_u, picture.low_v));
    if (!(other.x() > corner.x() && other.y() > corner.y())) continue;
    draw_jpeg(svg, picture.jpeg, corner.x(), corner.y(), other.x() - corner.x(), other.y() - corner.y());
    any = true;
  }
  return any;
}

bool draw_heat(Markup& svg, const SurfacesT& surfaces, const LookedAt& at, const Drawn& drawn) {
  const double range = heat_range(surfaces);
  bool any = false;
  for (const auto& panel : surfaces.panels) {
    const SurfaceFaceT& face = *panel->face;
    if (!at.shows(face.out, face.origin)) continue;
    any = true;
    if (!is_measured(*panel)) {
      Scope grey(svg, "polygon",
                 {{"class", "heat"}, {"fill", "#cfcfcf"}, {"points", part_points(face, drawn, -1, 1, -1, 1)}});
      svg.element("title", face.id + ": not measured, " + panel->not_measured);
      continue;
    }
    Scope group(svg, "g", {{"class", "heat"}});
    svg.element("title", face.id + ": " + signed_mm(panel->offset, 2) + " mm out of the design at its middle");
    for (int r = 0; r < kHeatCells; ++r)
      for (int c = 0; c < kHeatCells; ++c) {
        const double x0 = 2.0 * c / kHeatCells - 1, x1 = 2.0 * (c + 1) / kHeatCells - 1;
        const double y0 = 2.0 * r / kHeatCells - 1, y1 = 2.0 * (r + 1) / kHeatCells - 1;
        svg.empty("polygon", {{"fill", heat_colour(surface_height(*panel, 0.5 * (x0 + x1), 0.5 * (y0 + y1)), range)},
                              {"points", part_points(face, drawn, x0, x1, y0, y1)}});
      }
  }
  return any;
}

std::vector<FacadePicture> facade_pictures(const std::function<std::string(const std::string&)>& bytes_of) {
  std::vector<FacadePicture> pictures;
  std::istringstream table(bytes_of("facades.csv"));
  std::string line;
  std::getline(table, line);  // names of the columns
  while (std::getline(table, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    std::string name;
    double width = 0, height = 0, pixel = 0;
    FacadePicture picture;
    words >> name >> width >> height >> pixel;
    for (Eigen::Vector3d* vector : {&picture.origin, &picture.right, &picture.up})
      words >> vector->x() >> vector->y() >> vector->z();
    std::istringstream world(bytes_of(name + ".tfw"));
    std::array<double, 6> numbers{};
    for (double& number : numbers) world >> number;
    if (!words || !world || !(pixel > 0))
      throw std::runtime_error("facades.csv or " + name + ".tfw of 'orthophoto' is none of surface.orthophoto: '" +
                               line + "'; connect its port 'folder'");
    picture.low_u = numbers[4] - 0.5 * pixel, picture.high_u = picture.low_u + width * pixel;
    picture.high_v = numbers[5] + 0.5 * pixel, picture.low_v = picture.high_v - height * pixel;
    picture.jpeg = bytes_of(name + ".jpg");
    pictures.push_back(std::move(picture));
  }
  return pictures;
}

}  // namespace plumbline::report

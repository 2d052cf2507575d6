#include "show/report/image_block_tables.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "show/report/block_json.hpp"
#include "show/report/format.hpp"
#include "show/report/image_block_drawing.hpp"
#include "show/report/language.hpp"

namespace plumbline::report {
namespace {

using namespace block_json;

constexpr double strong_correlation = 0.95;

/// A value to as many digits as its standard deviation deserves.
std::string rounded(double value, double sigma) {
  if (sigma > 0 && sigma < 1e-8) {
    return fmt::format("{:.{}e}", value, std::max(1, static_cast<int>(std::log10(std::abs(value) / sigma)) + 1));
  }
  const int digits = sigma > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 9) : 6;
  return fixed(value, digits);
}

void cell(Markup& html, const std::string& value) { html.element("td", value); }
void words(Markup& html, const std::string& value) { html.element("td", {{"class", "words"}}, value); }

void head(Markup& html, std::initializer_list<const char*> names) {
  Scope thead(html, "thead");
  Scope row(html, "tr");
  for (const char* name : names) html.element("th", name);
}

/// "0.195 px (1.17 µm)"; the pitch is not always known.
std::string pixels_and_micrometres(double value, double pitch_um) {
  return fixed(value, 3) + " px" + (pitch_um > 0 ? " (" + fixed(value * pitch_um, 2) + " µm)" : "");
}

void write_camera(Markup& html, const Json& camera, const Json& block) {
  html.element("h3", verbatim(text(camera, "id")));
  html.element("p", fixed(number(camera, "width"), 0) + " × " + fixed(number(camera, "height"), 0) + " px, " +
                        count(static_cast<long>(number(camera, "images")), "photograph", "photographs") +
                        ", residuals " +
                        pixels_and_micrometres(number(camera, "rms_px"), number(camera, "pixel_pitch_um")) + ". " +
                        text(camera, "source") + ".");
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table");
    head(html, {"Parameter", "Value", "Sigma", "Unit"});
    Scope body(html, "tbody");
    for (const Json& p : list(camera, "interior_orientation")) {
      const std::string name = text(p, "name");
      const double sigma = number(p, "sigma");
      Scope row(html, "tr");
      html.element("th", verbatim(name));
      cell(html, rounded(number(p, "value"), sigma));
      cell(html, flag(p, "estimated") ? rounded(sigma, sigma) : "held");
      cell(html, !text(p, "unit").empty() ? text(p, "unit") : name[0] == 'f' || name[0] == 'c' ? "px" : "1");
    }
    if (number(camera, "corner_inset_sigma") > 0) {
      Scope row(html, "tr");
      html.element("th", "corner inset");
      cell(html, rounded(number(camera, "corner_inset"), number(camera, "corner_inset_sigma")));
      cell(html, rounded(number(camera, "corner_inset_sigma"), number(camera, "corner_inset_sigma")));
      cell(html, "px");
    }
  }
  std::string strong;
  for (const Json& c : list(camera, "correlations"))
    if (std::abs(number(c, "correlation")) > strong_correlation)
      strong += (strong.empty() ? "" : ", ") + text(c, "of") + " – " + text(c, "with") + " " +
                signed_fixed(number(c, "correlation"), 3);
  html.element("p", {{"class", "note"}},
               strong.empty()
                   ? "No two parameters are correlated by more than 0.95."
                   : "Correlated by more than 0.95, so that neither can be told without the other: " + strong + ".");
  std::vector<DrawnResidual> residuals;
  std::map<std::string, std::string> camera_of;
  for (const Json& image : list(block, "images")) camera_of[text(image, "path")] = text(image, "camera");
  for (const Json& seen : list(block, "observations")) {
    if (camera_of[text(seen, "image")] != text(camera, "id")) continue;
    const auto at = pixels(seen, "corners"), r = pixels(seen, "residuals");
    for (size_t k = 0; k < at.size() && k < r.size(); ++k) residuals.push_back({at[k], r[k]});
  }
  draw_residuals(html, static_cast<int>(number(camera, "width")), static_cast<int>(number(camera, "height")),
                 residuals);
}

}  // namespace

void write_cameras(Markup& html, const Json& block) {
  Scope section(html, "section", {{"id", "cameras"}});
  html.element("h2", "Interior orientation");
  for (const Json& camera : list(block, "cameras")) write_camera(html, camera, block);
}

namespace {

/// The largest angle under which rays meet in a point that the photograph shows [deg].
std::map<std::string, double> largest_angles(const Json& block) {
  std::map<std::string, double> of_point, of_image;
  for (const Json& point : list(block, "points")) of_point[text(point, "id")] = number(point, "largest_angle_deg");
  for (const Json& seen : list(block, "observations")) {
    const auto point = of_point.find(text(seen, "point"));
    if (point == of_point.end() || !std::isfinite(point->second)) continue;
    double& angle = of_image[text(seen, "image")];
    angle = std::max(angle, point->second);
  }
  return of_image;
}

}  // namespace

void write_images(Markup& html, const Json& block) {
  const auto angles = largest_angles(block);
  Scope section(html, "section", {{"id", "photographs"}});
  html.element("h2", "Photographs");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  head(html, {"Photograph", "Points", "Residuals [px]", "Covered", "Largest angle [°]", "Centre x, y, z [m]",
              "Sigma [mm]", "Remarks"});
  Scope body(html, "tbody");
  for (const Json& image : list(block, "images")) {
    Scope row(html, "tr");
    html.element("th", verbatim(text(image, "path")));
    if (!flag(image, "oriented")) {
      for (int k = 0; k < 6; ++k) cell(html, unknown);
      words(html, "not oriented: " + text(image, "reason"));
      continue;
    }
    const Eigen::Vector3d centre = vector(image, "centre"), sigma = vector(image, "sigma");
    cell(html, fixed(number(image, "tags"), 0));
    cell(html, fixed(number(image, "rms_px"), 3));
    cell(html, percent(number(image, "coverage"), 0));
    const auto angle = angles.find(text(image, "path"));
    cell(html, angle == angles.end() ? unknown : fixed(angle->second, 0));
    cell(html, fixed(centre.x(), 4) + ", " + fixed(centre.y(), 4) + ", " + fixed(centre.z(), 4));
    cell(html, mm(sigma.norm(), 2));
    const double correlation = number(image, "interior_correlation");
    words(html, std::abs(correlation) > strong_correlation
                    ? "correlated by " + signed_fixed(correlation, 3) + " with the interior orientation"
                    : text(image, "reason"));
  }
}

void write_points(Markup& html, const Json& block) {
  constexpr size_t most = 500;
  const Json& points = list(block, "points");
  Scope section(html, "section", {{"id", "points"}});
  html.element("h2", "Points");
  if (points.size() > most)
    html.element("p", "The first " + std::to_string(most) + " of " + std::to_string(points.size()) +
                          "; all are in the files beside this page.");
  const bool sizes = !points.empty() && points[0].contains("size_ratio");
  double oriented = 0;
  for (const Json& image : list(block, "images")) oriented += flag(image, "oriented");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  {
    Scope thead(html, "thead");
    Scope row(html, "tr");
    for (const char* name : {"Point", "Rays", "Of the photographs", "Largest angle [°]", "x [m]", "y [m]", "z [m]",
                             "Sigma x [mm]", "Sigma y [mm]", "Sigma z [mm]"})
      html.element("th", name);
    if (sizes) html.element("th", "Size over nominal");
  }
  Scope body(html, "tbody");
  for (size_t i = 0; i < std::min(most, points.size()); ++i) {
    const Json& point = points[i];
    const Eigen::Vector3d at = vector(point, "position"), sigma = vector(point, "sigma");
    Scope row(html, "tr");
    html.element("th", verbatim(text(point, "id")));
    cell(html, fixed(number(point, "rays"), 0));
    cell(html, percent(number(point, "rays") / oriented, 0));
    cell(html, fixed(number(point, "largest_angle_deg"), 0));
    for (int k = 0; k < 3; ++k) cell(html, fixed(at(k), 5));
    for (int k = 0; k < 3; ++k) cell(html, mm(sigma(k), 3));
    if (sizes)
      cell(html, number(point, "size_ratio_sigma") > 0
                     ? fixed(number(point, "size_ratio"), 5) + " ± " + fixed(number(point, "size_ratio_sigma"), 5)
                     : fixed(number(point, "size_ratio"), 5));
  }
}

/// What check points say of the block; empty where they were not judged.
std::string check_verdict(const Json& block) {
  const auto checks = block.find("check_points");
  if (checks == block.end() || !checks->is_object()) return "";
  std::string said = flag(*checks, "holds")
                         ? "They hold: none is off by more than the standard deviations of block and "
                           "survey allow"
                         : "They do not hold";
  if (const double freedom = number(*checks, "degrees_of_freedom"); freedom > 0)
    said += ", NEES " + fixed(number(*checks, "nees"), 1) + " of " + fixed(freedom, 0) +
            " degrees of freedom (at most " + fixed(number(*checks, "limit"), 1) + ")";
  else if (const double own = number(*checks, "degrees_of_freedom_of_a_point"); own > 0)
    said += ", largest NEES of a point " + fixed(number(*checks, "largest_nees"), 1) + " of " + fixed(own, 0) +
            " degrees of freedom (at most " + fixed(number(*checks, "limit_of_a_point"), 1) + ")";
  said += ".";
  for (const Json& sentence : list(*checks, "words")) said += " " + sentence.get<std::string>() + ".";
  return said;
}

void write_control(Markup& html, const Json& block) {
  std::vector<const Json*> surveyed;
  for (const Json& point : list(block, "points"))
    if (point.contains("surveyed")) surveyed.push_back(&point);
  if (surveyed.empty()) return;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  long checks = 0;
  for (const Json* point : surveyed)
    if (text(*point, "role") == "check") squares += vector(*point, "difference").cwiseAbs2(), ++checks;
  Scope section(html, "section", {{"id", "control"}});
  html.element("h2", "Surveyed points");
  std::string said = "Adjusted minus surveyed. Control took part with its standard deviations.";
  if (checks > 0) {
    const Eigen::Vector3d rms = (squares / static_cast<double>(checks)).cwiseSqrt();
    said += " Check points were withheld: root mean square " + mm_unit(rms.x(), 1) + " in x, " + mm_unit(rms.y(), 1) +
            " in y, " + mm_unit(rms.z(), 1) + " in z over " + count(checks, "point", "points") +
            ", errors of the survey included. " + check_verdict(block);
  } else {
    said += " No point was withheld as a check (role check), so nothing here judges independently.";
  }
  html.element("p", said);
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  head(html, {"Point", "Role", "Rays", "dx [mm]", "dy [mm]", "dz [mm]", "Sigma of the survey [mm]",
              "Sigma of the adjusted point [mm]", "Largest |w|", "Residuals [px]"});
  Scope body(html, "tbody");
  const auto triple = [](const Eigen::Vector3d& v, int digits) {
    return mm(v.x(), digits) + ", " + mm(v.y(), digits) + ", " + mm(v.z(), digits);
  };
  for (const Json* point : surveyed) {
    const Eigen::Vector3d d = vector(*point, "difference"), given = vector(*point, "surveyed_sigma");
    Scope row(html, "tr");
    html.element("th", verbatim(text(*point, "id")));
    cell(html, text(*point, "role"));
    cell(html, fixed(number(*point, "rays"), 0));
    for (int k = 0; k < 3; ++k) cell(html, signed_mm(d(k), 2));
    cell(html, given.allFinite() ? triple(given, 1) : unknown);
    cell(html, triple(vector(*point, "sigma"), 1));
    const Eigen::Vector3d w = vector(*point, "w");
    if (!w.allFinite() || (text(*point, "role") == "check" && w.isZero(0)))
      cell(html, unknown);
    else
      cell(html, fixed(w.cwiseAbs().maxCoeff(), 1) + (flag(*point, "contradicts") ? " !" : ""));
    cell(html, fixed(number(*point, "rms_px"), 2));
  }
}

void write_rejected(Markup& html, const Json& block) {
  constexpr size_t most = 300;
  const Json& rejected = list(block, "rejected");
  if (rejected.empty()) return;
  Scope details(html, "details");
  html.element("summary", count(static_cast<long>(rejected.size()), "observation was", "observations were") +
                              " left out as blunders");
  if (rejected.size() > most) html.element("p", "The first " + std::to_string(most) + "; all are in block.json.");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  head(html, {"Photograph", "Point", "Why"});
  Scope body(html, "tbody");
  for (size_t i = 0; i < std::min(most, rejected.size()); ++i) {
    Scope row(html, "tr");
    html.element("th", verbatim(text(rejected[i], "image")));
    cell(html, verbatim(text(rejected[i], "point")));
    words(html, text(rejected[i], "reason"));
  }
}

}  // namespace plumbline::report

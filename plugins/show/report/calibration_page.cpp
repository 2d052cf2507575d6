#include "show/report/calibration_page.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <vector>

#include "show/report/format.hpp"
#include "show/report/image_block_drawing.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"

namespace plumbline::report {
namespace {

using Json = nlohmann::ordered_json;

double number(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_number() ? object[key].get<double>() : std::nan("");
}
std::string text(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
}
const Json& list(const Json& object, const char* key) {
  static const Json empty = Json::array();
  return object.contains(key) && object[key].is_array() ? object[key] : empty;
}

std::string rounded(double value, double sigma) {
  return fixed(value, sigma > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 9) : 6);
}

struct Counts {
  long used = 0, all = 0;
};

Counts counts_of(const Json& c) {
  Counts n;
  for (const Json& image : list(c, "images")) ++n.all, n.used += image.value("used", false);
  return n;
}

void write_verdict(Markup& html, const Json& c) {
  const Counts n = counts_of(c);
  {
    Scope box(html, "div",
              {{"class", list(c, "warnings").empty() && n.used == n.all ? "verdict pass" : "verdict undecided"}});
    Scope inner(html, "div");
    html.element("strong", "Calibrated on " + std::to_string(n.used) + " of " +
                               count(n.all, "photograph", "photographs") + ", residuals " +
                               fixed(number(c, "rms_px"), 3) + " px");
    const Json& halves = c["halves"];
    const double difference = number(halves, "median_difference_px"), expected = number(halves, "median_expected_px");
    html.element(
        "p", expected > 0
                 ? "Two halves of the photographs, calibrated by themselves, differ by " + fixed(difference, 3) +
                       " px in the median over the image; their uncertainties let " + fixed(expected, 3) + " px expect."
                 : "Too few photographs to calibrate two halves against each other: nothing checks the model.");
  }
  if (!list(c, "warnings").empty()) {
    Scope box(html, "div", {{"class", "warnings"}});
    html.element("h2", "What needs attention");
    Scope ul(html, "ul");
    for (const Json& w : list(c, "warnings")) html.element("li", w.get<std::string>());
  }
}

void write_parameters(Markup& html, const Json& c) {
  Scope section(html, "section", {{"id", "parameters"}});
  html.element("h2", "Parameters");
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table");
    {
      Scope thead(html, "thead");
      Scope row(html, "tr");
      for (const char* name : {"Parameter", "Value", "Sigma", "Unit"}) html.element("th", name);
    }
    Scope body(html, "tbody");
    for (const auto& [name, value] : c["parameters"].items()) {
      const double sigma = number(c["sigmas"], name.c_str());
      Scope row(html, "tr");
      html.element("th", verbatim(name));
      html.element("td", rounded(value.get<double>(), sigma));
      html.element("td", sigma > 0 ? rounded(sigma, sigma) : "held");
      html.element("td", name[0] == 'f' || name[0] == 'c' ? "px" : "1");
    }
  }
  html.element("p", {{"class", "note"}},
               text(c, "model") + ". Standard deviation of an image coordinate from the residuals: " +
                   fixed(number(c, "sigma_px"), 3) + " px; " + fixed(number(c, "degrees_of_freedom"), 0) +
                   " degrees of freedom.");
  html.element("h3", "Correlations");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  const Json& names = list(c, "parameter_order");
  {
    Scope thead(html, "thead");
    Scope row(html, "tr");
    html.element("th", "");
    for (const Json& name : names) html.element("th", verbatim(name.get<std::string>()));
  }
  Scope body(html, "tbody");
  const Json& correlations = list(c, "correlations");
  for (size_t i = 0; i < correlations.size(); ++i) {
    Scope row(html, "tr");
    html.element("th", verbatim(names[i].get<std::string>()));
    for (size_t j = 0; j < correlations[i].size(); ++j) {
      const double value = correlations[i][j].get<double>();
      html.open("td");
      if (i != j && std::abs(value) > 0.95)
        html.element("strong", signed_fixed(value, 2));
      else
        html.text(i == j ? "1" : signed_fixed(value, 2));
      html.close();
    }
  }
}

/// The uncertainty of a projection as a map of shades with its values.
void write_map(Markup& html, const Json& c) {
  const Json& grid = list(c, "projection_uncertainty_px");
  if (grid.empty()) return;
  std::vector<double> values;
  for (const Json& row : grid)
    for (const Json& v : row)
      if (v.is_number()) values.push_back(v.get<double>());
  if (values.empty()) return;
  const double low = *std::min_element(values.begin(), values.end()),
               high = *std::max_element(values.begin(), values.end());
  Scope section(html, "section", {{"id", "uncertainty"}});
  html.element("h2", "How sure is a projected point?");
  html.element(
      "p",
      "Standard deviation of a projected pixel that the uncertainty of the parameters leaves after an orientation "
      "took up what it can: " +
          fixed(low, 3) + " px at best, " + fixed(high, 3) + " px at worst.");
  constexpr double width = 760;
  const double height = width * number(c, "height") / number(c, "width");
  const size_t rows = grid.size(), columns = grid[0].size();
  const double w = width / static_cast<double>(columns), h = height / static_cast<double>(rows);
  Scope figure(html, "figure");
  {
    Scope svg = drawing(html, width, height, "Map of the projection uncertainty");
    for (size_t r = 0; r < rows; ++r)
      for (size_t k = 0; k < columns; ++k) {
        if (!grid[r][k].is_number()) continue;
        const double v = grid[r][k].get<double>(), shade = high > low ? (v - low) / (high - low) : 0;
        const double x = static_cast<double>(k) * w, y = static_cast<double>(r) * h;
        html.empty("rect", {{"x", px(x)},
                            {"y", px(y)},
                            {"width", px(w + 0.5)},
                            {"height", px(h + 0.5)},
                            {"class", "mean"},
                            {"fill-opacity", fixed(0.08 + 0.8 * shade, 2)},
                            {"stroke", "none"},
                            {"style", "stroke:none"}});
        if (r % 3 == 1 && k % 4 == 2) label(html, x + 0.5 * w, y + 0.5 * h + 4, fixed(v, 2), "small halo", "middle");
      }
  }
  html.element("figcaption", "Pixels of uncertainty over the image, one sigma in the worst direction.");
}

void write_residuals(Markup& html, const Json& c) {
  std::vector<DrawnResidual> residuals;
  for (const Json& image : list(c, "images"))
    for (const Json& r : list(image, "residuals"))
      residuals.push_back({{r[0].get<double>(), r[1].get<double>()}, {r[2].get<double>(), r[3].get<double>()}});
  Scope section(html, "section", {{"id", "residuals"}});
  html.element("h2", "Residuals and coverage");
  draw_residuals(html, static_cast<int>(number(c, "width")), static_cast<int>(number(c, "height")), residuals);
}

void write_images(Markup& html, const Json& c) {
  Scope section(html, "section", {{"id", "photographs"}});
  html.element("h2", "Photographs");
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table", {{"class", "sortable"}});
    {
      Scope thead(html, "thead");
      Scope row(html, "tr");
      for (const char* name : {"Photograph", "Points", "Residuals [px]", "Covered", "Tilt of the board [°]", "Remarks"})
        html.element("th", name);
    }
    Scope body(html, "tbody");
    for (const Json& image : list(c, "images")) {
      Scope row(html, "tr");
      html.element("th", verbatim(text(image, "path")));
      const bool used = image.value("used", false);
      html.element("td", used ? fixed(number(image, "points"), 0) : unknown);
      html.element("td", used ? fixed(number(image, "rms_px"), 3) : unknown);
      html.element("td", used ? percent(number(image, "coverage"), 0) : unknown);
      html.element("td", used ? fixed(number(image, "tilt_deg"), 0) : unknown);
      html.element("td", {{"class", "words"}}, used ? "" : "left out: " + text(image, "reason"));
    }
  }
  const Json& rejected = list(c, "rejected");
  if (rejected.empty()) return;
  Scope details(html, "details");
  html.element("summary", count(static_cast<long>(rejected.size()), "point", "points") + " left out as blunders");
  Scope ul(html, "ul");
  for (const Json& r : rejected) html.element("li", r.get<std::string>());
}

void write_camera(Markup& html, const Json& c) {
  write_parameters(html, c);
  write_map(html, c);
  write_residuals(html, c);
  write_images(html, c);
}

/// How the cameras stand to each other.
void write_rig(Markup& html, const Json& rig) {
  Scope section(html, "section", {{"id", "rig"}});
  html.element("h2", "The cameras of the rig");
  if (rig.empty()) {
    html.element("p",
                 "No two cameras have three photographs of the same moments: the last number of a photograph's name "
                 "has to be that of the moment.");
    return;
  }
  html.element(
      "p",
      "Camera from reference, from one adjustment of all cameras: the rig is the same at every moment, the "
      "board has a pose at each. Halves: how far two halves of the moments place the camera apart, in units of "
      "what their standard deviations make expected.");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  {
    Scope thead(html, "thead");
    Scope row(html, "tr");
    for (const char* name : {"Camera", "Reference", "Moments shared", "Left out", "Translation x, y, z [mm]",
                             "Sigma [mm]", "Turn [°]", "Sigma [°]", "Residuals here, alone [px]", "Halves"})
      html.element("th", name);
  }
  Scope body(html, "tbody");
  const auto triple = [](const Json& v) {
    return mm(v[0].get<double>(), 2) + ", " + mm(v[1].get<double>(), 2) + ", " + mm(v[2].get<double>(), 2);
  };
  for (const Json& pose : rig) {
    Scope row(html, "tr");
    const double w = std::clamp(std::abs(list(pose, "rotation")[0].get<double>()), 0.0, 1.0);
    double turn_variance = 0;
    for (const Json& v : list(pose, "rotation_sigma")) turn_variance += std::pow(v.get<double>(), 2) / 3;
    html.element("th", verbatim(text(pose, "camera")));
    html.element("td", verbatim(text(pose, "reference")));
    html.element("td", fixed(number(pose, "shared"), 0));
    html.element("td", std::to_string(list(pose, "left_out").size()));
    html.element("td", triple(list(pose, "translation")));
    html.element("td", triple(list(pose, "translation_sigma")));
    html.element("td", fixed(2 * std::acos(w) * 180 / M_PI, 3));
    html.element("td", fixed(std::sqrt(turn_variance) * 180 / M_PI, 4));
    html.element("td", fixed(number(pose, "rms_px"), 3) + ", " + fixed(number(pose, "separate_rms_px"), 3));
    const double halves = number(pose, "halves");
    html.element("td", std::isfinite(halves) ? fixed(std::sqrt(halves), 1) : "too few");
  }
}

}  // namespace

void write_calibration(Markup& html, const Json& c, const std::string& title, const std::string& subtitle) {
  Scope main(html, "main");
  const bool several = c.contains("cameras");
  {
    const std::string board = text(several && !list(c, "cameras").empty() ? c["cameras"][0] : c, "board");
    Scope header(html, "header");
    html.element("h1", title_spoken(title));
    html.element("p", {{"class", "subtitle"}}, verbatim(subtitle.empty() ? board : board + " · " + subtitle));
    if (!several) write_verdict(html, c);
  }
  if (!several) {
    write_camera(html, c);
    return;
  }
  write_rig(html, list(c, "rig"));
  for (const Json& camera : list(c, "cameras")) {
    html.element("h1", verbatim(text(camera, "id")));
    write_verdict(html, camera);
    write_camera(html, camera);
  }
}

}  // namespace plumbline::report

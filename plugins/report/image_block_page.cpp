#include "report/image_block_page.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "images/grey_image.hpp"
#include "report/format.hpp"
#include "report/image_block_drawing.hpp"

namespace plumbline::report {
namespace {

using Json = nlohmann::ordered_json;

constexpr double strong_correlation = 0.95;
constexpr size_t worst_shown = 8;

double number(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_number() ? object[key].get<double>() : std::nan("");
}
std::string text(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_string() ? object[key].get<std::string>() : "";
}
bool flag(const Json& object, const char* key) {
  return object.contains(key) && object[key].is_boolean() && object[key].get<bool>();
}
const Json& list(const Json& object, const char* key) {
  static const Json empty = Json::array();
  return object.contains(key) && object[key].is_array() ? object[key] : empty;
}
Eigen::Vector3d vector(const Json& object, const char* key) {
  const Json& v = list(object, key);
  if (v.size() != 3) return Eigen::Vector3d::Constant(std::nan(""));
  return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()};
}
std::vector<Eigen::Vector2d> pixels(const Json& object, const char* key) {
  std::vector<Eigen::Vector2d> result;
  for (const Json& p : list(object, key)) result.emplace_back(p.at(0).get<double>(), p.at(1).get<double>());
  return result;
}

/// A value to as many digits as its standard deviation deserves.
std::string rounded(double value, double sigma) {
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

void card(Markup& html, const std::string& name, const std::string& value, const std::string& more) {
  Scope box(html, "div", {{"class", "card"}});
  html.element("div", {{"class", "name"}}, name);
  html.element("div", {{"class", "value"}}, value);
  html.element("div", {{"class", "more"}}, more);
}

struct Summary {
  long oriented = 0, photographs = 0, weak = 0;
  double largest_sigma = 0, mean_sigma = std::nan("");
};

Summary summary_of(const Json& block) {
  Summary s;
  for (const Json& image : list(block, "images")) {
    ++s.photographs;
    s.oriented += flag(image, "oriented");
    s.weak += flag(image, "oriented") && !text(image, "reason").empty();
  }
  double sum = 0;
  long count = 0;
  for (const Json& point : list(block, "points")) {
    const Eigen::Vector3d sigma = vector(point, "sigma");
    if (!sigma.allFinite()) continue;
    s.largest_sigma = std::max(s.largest_sigma, sigma.maxCoeff());
    sum += sigma.squaredNorm() / 3, ++count;
  }
  if (count) s.mean_sigma = std::sqrt(sum / static_cast<double>(count));
  return s;
}

void write_messages(Markup& html, const std::string& title, const Json& messages) {
  constexpr size_t shown = 12;
  if (messages.empty()) return;
  Scope box(html, "div", {{"class", "warnings"}});
  html.element("h2", title);
  const auto items = [&](size_t from, size_t to) {
    Scope ul(html, "ul");
    for (size_t i = from; i < to; ++i) html.element("li", messages[i].get<std::string>());
  };
  items(0, std::min(shown, messages.size()));
  if (messages.size() <= shown) return;
  Scope details(html, "details");
  html.element("summary", std::to_string(messages.size() - shown) + " more");
  items(shown, messages.size());
}

void write_verdict(Markup& html, const Json& block, const Summary& s) {
  const double rms = number(block["statistics"], "rms_px");
  const bool sound = s.weak == 0 && list(block, "left_out").empty() && list(block, "warnings").empty();
  Scope box(html, "div", {{"class", sound ? "verdict pass" : "verdict undecided"}});
  Scope inner(html, "div");
  html.element("strong", std::to_string(s.oriented) + " of " + count(s.photographs, "photograph", "photographs") +
                             " hang together, " +
                             count(static_cast<long>(list(block, "points").size()), "point", "points") +
                             ", residuals " + fixed(rms, 2) + " px");
  std::string more = "Datum: " + text(block, "datum") + ".";
  if (s.weak)
    more += " " + count(s.weak, "photograph is", "photographs are") +
            " only weakly oriented; the table says which and why.";
  html.element("p", more);
}

void write_cards(Markup& html, const Json& block, const Summary& s) {
  const Json& statistics = block["statistics"];
  Scope section(html, "section", {{"id", "numbers"}});
  Scope cards(html, "div", {{"class", "cards"}});
  card(html, "Residuals", fixed(number(statistics, "rms_px"), 3) + " px",
       "root mean square of an image coordinate, over all that took part");
  card(html, "Points, 1 sigma", mm_unit(s.mean_sigma, 3),
       "of a coordinate, rms over all; the worst " + mm_unit(s.largest_sigma, 3));
  card(html, "Degrees of freedom", fixed(number(statistics, "degrees_of_freedom"), 0),
       fixed(number(statistics, "observations"), 0) + " observations, " + fixed(number(statistics, "unknowns"), 0) +
           " unknowns");
  card(html, "Left out", std::to_string(list(block, "rejected").size()),
       "observations as blunders; " + std::to_string(list(block, "left_out").size()) + " photographs or points");
}

void write_scene(Markup& html, const Json& block) {
  std::vector<DrawnCamera> cameras;
  std::vector<DrawnPoint> points;
  for (const Json& image : list(block, "images")) {
    if (!flag(image, "oriented")) continue;
    const Json& q = list(image, "rotation");
    if (q.size() != 4) continue;
    const Eigen::Quaterniond rotation(q[0].get<double>(), q[1].get<double>(), q[2].get<double>(), q[3].get<double>());
    const std::string path = text(image, "path");
    cameras.push_back({path.substr(path.find_last_of('/') + 1), vector(image, "centre"),
                       rotation.conjugate() * Eigen::Vector3d::UnitZ()});
  }
  for (const Json& point : list(block, "points")) points.push_back({text(point, "id"), vector(point, "position")});
  Scope section(html, "section", {{"id", "scene"}});
  html.element("h2", "Cameras and points");
  draw_scene(html, cameras, points);
  html.element("p", {{"class", "note"}}, "Squares with a stroke are cameras and the way they look; dots are points.");
}

void write_groups(Markup& html, const Json& block) {
  Scope section(html, "section", {{"id", "groups"}});
  html.element("h2", "Do the observations keep their promises?");
  html.element("p",
               "The variance factor compares what the residuals say with the standard deviations that observations "
               "came with: 1 is what was promised, 4 means that they are twice as uncertain. Image coordinates are "
               "weighted by their factor, so that the uncertainties below hold.");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  head(html, {"Kind of observation", "Number", "Redundancy", "Variance factor", "Standard deviations times"});
  Scope body(html, "tbody");
  for (const Json& group : list(block, "groups")) {
    Scope row(html, "tr");
    html.element("th", text(group, "name"));
    cell(html, fixed(number(group, "observations"), 0));
    cell(html, fixed(number(group, "redundancy"), 1));
    const double factor = number(group, "redundancy") > 1 ? number(group, "variance_factor") : std::nan("");
    cell(html, fixed(factor, 2));
    cell(html, fixed(std::sqrt(factor), 2));
  }
}

void write_camera(Markup& html, const Json& camera, const Json& block) {
  html.element("h3", text(camera, "id"));
  html.element("p", fixed(number(camera, "width"), 0) + " × " + fixed(number(camera, "height"), 0) + " px, " +
                        count(static_cast<long>(number(camera, "images")), "photograph", "photographs") +
                        ", residuals " + fixed(number(camera, "rms_px"), 3) + " px. " + text(camera, "source") + ".");
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table");
    head(html, {"Parameter", "Value", "Sigma", "Unit"});
    Scope body(html, "tbody");
    for (const Json& p : list(camera, "interior_orientation")) {
      const std::string name = text(p, "name");
      const double sigma = number(p, "sigma");
      Scope row(html, "tr");
      html.element("th", name);
      cell(html, rounded(number(p, "value"), sigma));
      cell(html, flag(p, "estimated") ? rounded(sigma, sigma) : "held");
      cell(html, name[0] == 'f' || name[0] == 'c' ? "px" : "1");
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
      strong += (strong.empty() ? "" : ", ") + text(c, "of") + " with " + text(c, "with") + " " +
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

void write_cameras(Markup& html, const Json& block) {
  Scope section(html, "section", {{"id", "cameras"}});
  html.element("h2", "Interior orientation");
  for (const Json& camera : list(block, "cameras")) write_camera(html, camera, block);
}

void write_images(Markup& html, const Json& block) {
  Scope section(html, "section", {{"id", "photographs"}});
  html.element("h2", "Photographs");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  head(html, {"Photograph", "Points", "Residuals [px]", "Covered", "Centre x, y, z [m]", "Sigma [mm]", "Remarks"});
  Scope body(html, "tbody");
  for (const Json& image : list(block, "images")) {
    Scope row(html, "tr");
    html.element("th", text(image, "path"));
    if (!flag(image, "oriented")) {
      for (int k = 0; k < 5; ++k) cell(html, unknown);
      words(html, "not oriented: " + text(image, "reason"));
      continue;
    }
    const Eigen::Vector3d centre = vector(image, "centre"), sigma = vector(image, "sigma");
    cell(html, fixed(number(image, "tags"), 0));
    cell(html, fixed(number(image, "rms_px"), 3));
    cell(html, percent(number(image, "coverage"), 0));
    cell(html, fixed(centre.x(), 4) + ", " + fixed(centre.y(), 4) + ", " + fixed(centre.z(), 4));
    cell(html, mm(sigma.norm(), 2));
    words(html, text(image, "reason"));
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
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  {
    Scope thead(html, "thead");
    Scope row(html, "tr");
    for (const char* name : {"Point", "Rays", "Largest angle [°]", "x [m]", "y [m]", "z [m]", "Sigma x [mm]",
                             "Sigma y [mm]", "Sigma z [mm]"})
      html.element("th", name);
    if (sizes) html.element("th", "Size over nominal");
  }
  Scope body(html, "tbody");
  for (size_t i = 0; i < std::min(most, points.size()); ++i) {
    const Json& point = points[i];
    const Eigen::Vector3d at = vector(point, "position"), sigma = vector(point, "sigma");
    Scope row(html, "tr");
    html.element("th", text(point, "id"));
    cell(html, fixed(number(point, "rays"), 0));
    cell(html, fixed(number(point, "largest_angle_deg"), 0));
    for (int k = 0; k < 3; ++k) cell(html, fixed(at(k), 5));
    for (int k = 0; k < 3; ++k) cell(html, mm(sigma(k), 3));
    if (sizes)
      cell(html, number(point, "size_ratio_sigma") > 0
                     ? fixed(number(point, "size_ratio"), 5) + " ± " + fixed(number(point, "size_ratio_sigma"), 5)
                     : fixed(number(point, "size_ratio"), 5));
  }
}

/// The worst observations and all blunders, each with a look into the photograph.
void write_worst(Markup& html, const Json& block, const PhotographFiles& files) {
  std::vector<std::pair<const Json*, std::string>> shown;
  for (const Json& seen : list(block, "rejected"))
    if (shown.size() < 2 * worst_shown) shown.emplace_back(&seen, text(seen, "reason"));
  std::vector<const Json*> order;
  for (const Json& seen : list(block, "observations")) order.push_back(&seen);
  std::stable_sort(order.begin(), order.end(),
                   [](const Json* a, const Json* b) { return number(*a, "rms_px") > number(*b, "rms_px"); });
  for (size_t i = 0; i < std::min(worst_shown, order.size()); ++i)
    shown.emplace_back(order[i], "residuals " + fixed(number(*order[i], "rms_px"), 2) + " px, largest |w| " +
                                     fixed(number(*order[i], "largest_w"), 1));
  if (shown.empty()) return;
  Scope section(html, "section", {{"id", "worst"}});
  html.element("h2", "The worst observations");
  html.element("p",
               "Blunders that were left out first, then the largest residuals that took part. Circles are the measured "
               "corners.");
  Scope cards(html, "div", {{"class", "cards"}});
  std::map<std::string, GreyImage> opened;
  for (const auto& [seen, what] : shown) {
    Scope box(html, "div", {{"class", "card"}});
    const std::string path = text(*seen, "image");
    const auto file = files.find(path);
    if (file != files.end()) {
      try {
        if (!opened.count(path)) {
          opened.clear();  // one photograph in memory
          opened[path] = read_grey_image(file->second);
        }
        draw_crop(html, opened[path], pixels(*seen, "corners"));
      } catch (const ImageFileError&) {
        html.element("div", {{"class", "more"}}, "the photograph cannot be read any more");
      }
    }
    html.element("div", {{"class", "name"}}, text(*seen, "point") + " in " + path);
    html.element("div", {{"class", "more"}}, what);
  }
}

}  // namespace

void write_image_block(Markup& html, const Json& block, const std::string& title, const std::string& subtitle,
                       const PhotographFiles& files) {
  const Summary summary = summary_of(block);
  Scope main(html, "main");
  {
    Scope header(html, "header");
    html.element("h1", title);
    if (!subtitle.empty()) html.element("p", {{"class", "subtitle"}}, subtitle);
    write_verdict(html, block, summary);
    write_messages(html, "What needs attention", list(block, "warnings"));
    write_messages(html, "Left out", list(block, "left_out"));
    Scope nav(html, "nav");
    for (const auto& [id, name] :
         std::initializer_list<std::pair<const char*, const char*>>{{"scene", "Cameras and points"},
                                                                    {"groups", "Observations"},
                                                                    {"cameras", "Interior orientation"},
                                                                    {"photographs", "Photographs"},
                                                                    {"points", "Points"},
                                                                    {"worst", "Worst"}})
      html.element("a", {{"href", std::string("#") + id}}, name);
  }
  write_cards(html, block, summary);
  write_scene(html, block);
  write_groups(html, block);
  write_cameras(html, block);
  write_images(html, block);
  write_points(html, block);
  write_worst(html, block, files);
}

}  // namespace plumbline::report

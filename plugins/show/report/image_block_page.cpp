#include "show/report/image_block_page.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "photo/images/grey_image.hpp"
#include "show/report/block_json.hpp"
#include "show/report/format.hpp"
#include "show/report/image_block_drawing.hpp"
#include "show/report/image_block_tables.hpp"
#include "show/report/language.hpp"

namespace plumbline::report {
namespace {

using namespace block_json;

constexpr size_t worst_shown = 8;

void cell(Markup& html, const std::string& value) { html.element("td", value); }

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
  const Json& cameras = list(block, "cameras");
  const double rms = number(statistics, "rms_px"),
               pitch = cameras.size() == 1 ? number(cameras[0], "pixel_pitch_um") : std::nan("");
  card(html, "Residuals", fixed(rms, 3) + " px",
       (pitch > 0 ? fixed(rms * pitch, 2) + " µm; " : std::string()) +
           "root mean square of an image coordinate, over all that took part");
  card(html, "Points, 1 sigma", mm_unit(s.mean_sigma, 3),
       std::isfinite(s.mean_sigma) ? "of a coordinate, rms over all; the worst " + mm_unit(s.largest_sigma, 3)
                                   : std::string("of a coordinate: none are stated"));
  card(html, "σ0", fixed(number(statistics, "sigma0"), 3),
       "standard deviation of unit weight; " + fixed(number(statistics, "degrees_of_freedom"), 0) +
           " degrees of freedom, " + fixed(number(statistics, "observations"), 0) + " observations, " +
           fixed(number(statistics, "unknowns"), 0) + " unknowns");
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
  const Json& all = list(block, "points");
  constexpr size_t most = 3000;
  const size_t step = std::max<size_t>(1, (all.size() + most - 1) / most);
  for (size_t i = 0; i < all.size(); i += step) points.push_back({text(all[i], "id"), vector(all[i], "position")});
  Scope section(html, "section", {{"id", "scene"}});
  html.element("h2", "Cameras and points");
  draw_space(html, cameras, points);
  draw_scene(html, cameras, points);
  html.element(
      "p", {{"class", "note"}},
      "Squares with a stroke are cameras and the way they look; dots are points" +
          (step > 1 ? ", one in " + std::to_string(step) + " of " + std::to_string(all.size()) : std::string()) + ".");
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
    const double factor = number(group, "redundancy") > 0.5 ? number(group, "variance_factor") : std::nan("");
    cell(html, fixed(factor, 2));
    cell(html, fixed(std::sqrt(factor), 2));
  }
}

void draw_worst_corner(Markup& html, const GreyImage& image, const Json& seen) {
  const auto corners = pixels(seen, "corners"), residuals = pixels(seen, "residuals");
  if (residuals.empty() || residuals.size() != corners.size()) return;
  const auto worst = std::max_element(residuals.begin(), residuals.end(),
                                      [](const auto& a, const auto& b) { return a.norm() < b.norm(); });
  const Eigen::Vector2d& measured = corners[worst - residuals.begin()];
  draw_corner(html, image, measured, measured - *worst);
}

/// Points that somebody measured by hand are looked at before those that a program matched; of equal ones the first.
std::vector<const Json*> worst_observations(const Json& block) {
  struct Seen {
    bool by_hand;
    double rms;
    size_t place;
    bool operator<(const Seen& other) const {
      return std::tuple(!by_hand, -rms, place) < std::tuple(!other.by_hand, -other.rms, other.place);
    }
  };
  const Json& observations = list(block, "observations");
  std::vector<Seen> order;
  for (const Json& seen : observations) {
    const double rms = number(seen, "rms_px");
    order.push_back({flag(seen, "control"), std::isfinite(rms) ? rms : 0, order.size()});
  }
  const auto end = order.begin() + static_cast<std::ptrdiff_t>(std::min(worst_shown, order.size()));
  std::partial_sort(order.begin(), end, order.end());
  std::vector<const Json*> worst;
  for (auto seen = order.begin(); seen != end; ++seen) worst.push_back(&observations[seen->place]);
  return worst;
}

/// The worst observations and all blunders, each with a look into the photograph.
void write_worst(Markup& html, const Json& block, const PhotographFiles& files) {
  std::vector<std::pair<const Json*, std::string>> shown;
  for (const Json& seen : list(block, "rejected"))
    if (shown.size() < 2 * worst_shown) shown.emplace_back(&seen, text(seen, "reason"));
  for (const Json* seen : worst_observations(block))
    shown.emplace_back(
        seen, "residuals " + fixed(number(*seen, "rms_px"), 2) + " px" +
                  (seen->contains("largest_w") ? ", largest |w| " + fixed(number(*seen, "largest_w"), 1) : ""));
  if (shown.empty()) return;
  Scope section(html, "section", {{"id", "worst"}});
  html.element("h2", "The worst observations");
  html.element(
      "p",
      "Blunders that were left out first, then the largest residuals that took part, each with its worst corner. "
      "Circles are what was measured, crosses where the adjustment puts it.");
  write_rejected(html, block);
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
        draw_worst_corner(html, opened[path], *seen);
      } catch (const ImageFileError&) {
        html.element("div", {{"class", "more"}}, "the photograph cannot be read any more");
      }
    }
    html.element("div", {{"class", "name"}}, verbatim(text(*seen, "point") + " in " + path));
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
    html.element("h1", title_spoken(title));
    if (!subtitle.empty()) html.element("p", {{"class", "subtitle"}}, verbatim(subtitle));
    write_verdict(html, block, summary);
    write_messages(html, "What needs attention", list(block, "warnings"));
    write_messages(html, "Left out", list(block, "left_out"));
    const Json& points = list(block, "points");
    const bool surveyed =
        std::any_of(points.begin(), points.end(), [](const Json& point) { return point.contains("surveyed"); });
    Scope nav(html, "nav");
    for (const auto& [id, name] :
         std::initializer_list<std::pair<const char*, const char*>>{{"scene", "Cameras and points"},
                                                                    {"control", "Surveyed points"},
                                                                    {"groups", "Observations"},
                                                                    {"cameras", "Interior orientation"},
                                                                    {"photographs", "Photographs"},
                                                                    {"points", "Points"},
                                                                    {"worst", "Worst"}})
      if (id != std::string("control") || surveyed) html.element("a", {{"href", std::string("#") + id}}, name);
  }
  write_cards(html, block, summary);
  write_scene(html, block);
  write_control(html, block);
  write_groups(html, block);
  write_cameras(html, block);
  write_images(html, block);
  write_points(html, block);
  write_worst(html, block, files);
}

}  // namespace plumbline::report

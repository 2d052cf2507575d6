// The building in space, and the numbers from which the slider recomputes verdicts where scripts run. Everything that
// the view shows stands in the tables too.
#include <Eigen/Geometry>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <stdexcept>

#include "show/report/format.hpp"
#include "show/report/page_style.hpp"
#include "show/report/plot.hpp"
#include "show/report/script_data.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// [from which tolerance on it passes, below which it fails] in m, to the last bit; null: nobody knows.
std::string turning_points(double tau_pass, double tau_fail) {
  return "[" + script_exact(tau_pass) + "," + script_exact(tau_fail) + "]";
}

/// Of several facades: which one something lies in, by its number; -1: in none. Of one: nothing.
class FacadeNumbers {
 public:
  explicit FacadeNumbers(const DeviationT& deviation) {
    if (deviation.facades.size() < 2) return;
    for (const auto& facade : deviation.facades) {
      const auto number = static_cast<int>(numbers_.size());
      if (!numbers_.try_emplace(facade->name, number).second) continue;
      names_ += (names_.empty() ? "[" : ",[") + script_text(facade->name) + "," + script_number(facade->out.x(), 4) +
                "," + script_number(facade->out.y(), 4) + "]";
    }
  }
  std::string of(const std::unique_ptr<FacadeFrameT>& frame) const {
    if (numbers_.empty()) return "";
    const auto found = numbers_.find(facade_of(frame));
    return ",\"o\":" + std::to_string(found == numbers_.end() ? -1 : found->second);
  }
  /// Names, each with the plan direction out of it.
  std::string all() const { return "[" + names_ + "]"; }

 private:
  std::map<std::string, int> numbers_;
  std::string names_;
};

std::string anchor_json(const AnchorDeviationT& a, const Eigen::Vector3d& origin, const FacadeNumbers& facades) {
  return "{\"n\":" + script_text(a.id) + ",\"f\":" + std::to_string(a.floor) + facades.of(a.facade) +
         ",\"p\":" + script_vector(a.design - origin, 4) + ",\"d\":" + script_vector(1e3 * a.deviation, 3) +
         ",\"w\":" + std::to_string(static_cast<int>(a.verdict)) + ",\"t\":" + turning_points(a.tau_pass, a.tau_fail) +
         "}";
}

constexpr int kViewCells = 4;  // of a panel in space, each way; view_script.cpp counts on it

/// Colours of a panel's measured surface, row by row from below; null where nothing was measured.
std::string heat_json(const std::string& guid, const std::optional<SurfacesT>& surfaces) {
  if (!surfaces || guid.empty()) return "null";
  const auto found = std::find_if(surfaces->panels.begin(), surfaces->panels.end(),
                                  [&](const auto& panel) { return panel->face->guid == guid; });
  if (found == surfaces->panels.end() || !is_measured(**found)) return "null";
  const double range = heat_range(*surfaces);
  std::string colours;
  for (int r = 0; r < kViewCells; ++r)
    for (int c = 0; c < kViewCells; ++c)
      colours += (colours.empty() ? "" : ",") +
                 script_text(heat_colour(
                     surface_height(**found, (c + 0.5) * 2 / kViewCells - 1, (r + 0.5) * 2 / kViewCells - 1), range));
  return "[" + colours + "]";
}

std::string panel_json(const PanelDeviationT& p, const Eigen::Vector3d& origin,
                       const std::map<std::string, std::size_t>& index, const std::optional<SurfacesT>& surfaces,
                       const FacadeNumbers& facades) {
  std::string anchors, corners, movements;
  for (const auto& fixing : p.fixings) {
    const auto anchor = index.find(fixing->anchor);
    if (anchor == index.end())
      throw std::runtime_error("input 'deviation': panel '" + p.name + "' hangs on anchor '" + fixing->anchor +
                               "', which is none of its anchors");
    anchors += (anchors.empty() ? "" : ",") + std::to_string(anchor->second);
  }
  for (const char* name : {"bottom_left", "bottom_right", "top_right", "top_left"}) {
    Eigen::Vector3d place = Eigen::Vector3d::Zero(), movement = Eigen::Vector3d::Constant(NAN);
    for (const auto& corner : p.corners)
      if (corner->name == name) place = corner->design, movement = corner->movement;
    corners += (corners.empty() ? "" : ",") + script_vector(place - origin, 4);
    movements += (movements.empty() ? "" : ",") + script_vector(1e3 * movement, 3);
  }
  return "{\"n\":" + script_text(p.name.empty() ? p.guid : p.name) + ",\"f\":" + std::to_string(p.floor) +
         facades.of(p.facade) + ",\"w\":" + std::to_string(static_cast<int>(p.verdict)) +
         ",\"m\":" + (p.missing.empty() ? "0" : "1") + ",\"t\":" + turning_points(p.tau_pass, p.tau_fail) + ",\"a\":[" +
         anchors + "],\"q\":[" + corners + "],\"v\":[" + movements + "],\"h\":" + heat_json(p.guid, surfaces) + "}";
}

/// Middle of the anchors.
Eigen::Vector3d origin_of(const DeviationT& d) {
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  double n = 0;
  for (const auto& anchor : d.anchors)
    if (anchor->design.allFinite()) origin += anchor->design, ++n;
  return n > 0 ? Eigen::Vector3d(origin / n) : origin;
}

/// The building, its grid with tags, and north.
std::string surroundings_json(const ReportInput& input, const Eigen::Vector3d& origin) {
  std::string edges, axes;
  for (const auto& [from, to] : input.building.edges)
    edges += (edges.empty() ? "" : ",") + script_vector(from - origin, 2) + "," + script_vector(to - origin, 2);
  Eigen::AlignedBox3d around;
  for (const auto& anchor : input.deviation->anchors)
    if (anchor->design.allFinite()) around.extend(Eigen::Vector3d(anchor->design));
  if (!around.isEmpty()) {
    const auto lines = grid_lines(input.grid, around.min(), around.max());
    for (std::size_t i = 0; i < lines.size(); ++i)
      axes += (axes.empty() ? "" : ",") + ("[" + script_text(input.grid[i].tag)) + "," +
              script_vector(lines[i].first - origin, 2) + "," + script_vector(lines[i].second - origin, 2) + "]";
  }
  return ",\"building\":[" + edges + "],\"grid\":[" + axes +
         "],\"north\":" + script_number(input.building.true_north, 6);
}

std::string data_of(const ReportInput& input) {
  std::string text;
  {
    const DeviationT& d = *input.deviation;
    const Eigen::Vector3d origin = origin_of(d);
    const FacadeNumbers facades(d);
    std::map<std::string, std::size_t> index;
    std::string anchors, panels;
    for (const auto& anchor : d.anchors) {
      index[anchor->id] = index.size();
      anchors += (anchors.empty() ? "" : ",\n") + anchor_json(*anchor, origin, facades);
    }
    for (const auto& panel : d.panels)
      panels += (panels.empty() ? "" : ",\n") + panel_json(*panel, origin, index, input.surfaces, facades);
    text = "{\"tau\":" + script_number(1e3 * d.tau, 6) + ",\"doubt\":" + (d.doubts.empty() ? "false" : "true") +
           ",\"facades\":" + facades.all() + ",\"anchors\":[" + anchors + "],\"panels\":[" + panels + "]";
  }
  text += surroundings_json(input, origin_of(*input.deviation));
  std::string heights;
  if (const AccuracyComparisonT* c = headline(input.accuracy))
    for (const auto& a : input.accuracy.anchors)
      if (a->use == c->use && a->survey)
        heights += (heights.empty() ? "" : ",") + script_number(1e3 * a->survey->dz, 6);
  return text + ",\"checks\":[" + heights + "]}";
}

/// `tau` [mm].
void write_tolerance_slider(Markup& html, double tau) {
  Scope box(html, "div", {{"class", "slider"}, {"id", "tau-slider"}, {"hidden", "hidden"}});
  html.element("label", {{"for", "tau-input"}}, "Try another tolerance");
  // The tolerance in force lies on the slider, whatever it is: a browser moves a value that does not.
  html.empty("input", {{"id", "tau-input"},
                       {"type", "range"},
                       {"min", script_number(std::min(1.0, tau), 6)},
                       {"max", script_number(std::max(20.0, tau), 6)},
                       {"step", "any"},
                       {"value", script_number(tau, 6)}});
  html.element("output", {{"for", "tau-input"}}, "");
}

/// What is shown in space: floor, facade, length of the arrows, and which of all that could be shown.
void write_choices(Markup& html, const ReportInput& input) {
  Scope bar(html, "div", {{"class", "slider"}});
  html.element("label", {{"for", "floor-input"}}, "Floor");
  html.open("select", {{"id", "floor-input"}});
  html.element("option", {{"value", ""}}, "all");
  html.close();
  if (input.deviation->facades.size() > 1) {
    html.element("label", {{"for", "facade-input"}}, "Facade");
    html.open("select", {{"id", "facade-input"}});
    html.element("option", {{"value", ""}}, "all");
    html.close();
  }
  html.element("label", {{"for", "factor-input"}}, "Arrows ×");
  html.empty(
      "input",
      {{"id", "factor-input"}, {"type", "range"}, {"min", "0"}, {"max", "500"}, {"step", "10"}, {"value", "100"}});
  html.element("output", {{"id", "factor-output"}}, "");
  for (const auto& [id, words] : {std::pair{"design-input", "design"}, std::pair{"built-input", "as built"}}) {
    Scope label(html, "label", {{"class", "tick"}, {"hidden", "hidden"}});
    html.empty("input", {{"id", id}, {"type", "checkbox"}, {"checked", "checked"}});
    html.text(words);
  }
  if (!input.building.edges.empty() || !input.grid.empty()) {
    Scope label(html, "label", {{"class", "tick"}});
    html.empty("input", {{"id", "around-input"}, {"type", "checkbox"}, {"checked", "checked"}});
    html.text(input.grid.empty() ? "building" : "building and grid");
  }
  if (input.surfaces) {
    Scope label(html, "label", {{"class", "tick"}});
    html.empty("input", {{"id", "heat-input"}, {"type", "checkbox"}, {"checked", "checked"}});
    html.text("surfaces");
  }
}

void write_canvas(Markup& html) {
  Scope stack(html, "div", {{"class", "stack"}});
  html.element("canvas",
               {{"id", "canvas"},
                {"width", "1040"},
                {"height", "560"},
                {"tabindex", "0"},
                {"role", "application"},
                {"aria-describedby", "picked"},
                {"aria-label",
                 "Anchors and panels in space: arrows turn, plus and minus zoom, n and p choose the next and the "
                 "previous anchor; all numbers stand in the tables"}},
               "");
}

}  // namespace

void write_view(Markup& html, const ReportInput& input) {
  if (!input.deviation) return;
  Scope part(html, "section", {{"id", "view"}});
  write_tolerance_slider(html, 1e3 * input.deviation->tau);
  {
    Scope badges(html, "div", {{"hidden", "hidden"}, {"id", "badges"}});
    for (const auto verdict :
         {ToleranceVerdict::not_measured, ToleranceVerdict::pass, ToleranceVerdict::undecided, ToleranceVerdict::fail})
      verdict_badge(html, verdict);
  }
  {
    Scope figure(html, "figure", {{"id", "space"}, {"hidden", "hidden"}, {"class", "screen"}});
    html.element("h2", "In space");
    write_choices(html, input);
    write_canvas(html);
    html.element(
        "p", {{"id", "picked"}, {"class", "note"}, {"aria-live", "polite"}},
        "Drag to turn, wheel or pinch to zoom, tap an anchor for its values; with the keyboard arrows, + and −, n "
        "and p.");
  }
  html.open("script", {{"type", "application/json"}, {"id", "judged"}}).raw(data_of(input)).close();
  html.open("script", {{"type", "text/plain"}, {"id", "three-js"}}).raw(three_script).close();
}

}  // namespace plumbline::report

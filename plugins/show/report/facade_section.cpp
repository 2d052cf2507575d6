// Elevations of the facades: are the anchors in place, how far out of plane, is the model right.
#include <cmath>

#include "show/report/facade_backdrop.hpp"
#include "show/report/facade_drawing.hpp"
#include "show/report/format.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

void write_legend(Markup& html) {
  Scope legend(html, "div", {{"class", "legend"}});
  const auto item = [&](ToleranceVerdict verdict, bool hollow, const std::string& text) {
    Scope span(html, "span");
    {
      Scope svg(html, "svg", {{"viewBox", "0 0 16 16"}, {"width", "16"}, {"height", "16"}, {"aria-hidden", "true"}});
      verdict_symbol(html, 8, 8.5, 5.5, verdict, hollow);
    }
    html.text(text);
  };
  item(ToleranceVerdict::pass, false, "pass");
  item(ToleranceVerdict::undecided, false, "undecided");
  item(ToleranceVerdict::fail, false, "fail");
  item(ToleranceVerdict::not_measured, false, "not measured");
  item(ToleranceVerdict::pass, true, "hollow: control anchor");
}

/// What stands behind the anchors, in words.
std::string words_of_behind(Behind behind) {
  return behind == Behind::heat
             ? " Colours: the panels' measured surfaces out of the design (red) or behind it (blue), "
               "grey where nothing was measured."
             : " Behind them the facade without perspective; what no photograph shows, or photographs "
               "show differently, is black.";
}

enum class Drawing { named, many, sheet };

void write_elevation(Markup& html, const ReportInput& input, const FacadeView& view, Drawing drawing) {
  const Elevation whole = elevation_of(input.accuracy, view);
  if (whole.spots.empty()) return;
  const bool many = drawing == Drawing::many;
  Scope figure(html, "figure");
  html.element("h3", view.question);
  const auto stretches = drawing == Drawing::sheet ? stretches_of(whole) : std::vector{whole};
  bool behind = false;
  for (const Elevation& part : stretches)
    behind = many ? draw_many(html, part, view, input) : draw_elevation(html, part, view, input);
  const Elevation& e = stretches.front();
  if (behind && view.behind == Behind::heat) draw_heat_bar(html, heat_range(*input.surfaces));
  const Eigen::Vector3d& right = e.sight.right;
  html.element("figcaption",
               "Arrows: " + view.name + ", drawn ×" + fixed(e.exaggeration, 0) +
                   " (the arrow at the right edge stands for " + tolerance(scale_deviation(e)) + ")" +
                   (many ? ", of those that do not pass. Names and numbers stand in the tables. "
                         : "; numbers: " + view.number + " in mm. " +
                               (e.prefixes.empty() ? "" : "Names without the part that a floor has in common. ")) +
                   (e.sight.unrolled.empty() ? "Drawn along the facade, " : "Unrolled along the facade, ") +
                   (std::abs(right.x()) >= std::abs(right.y()) ? "x " : "y ") +
                   (right.x() + right.y() >= 0 || std::max(right.x(), right.y()) > 0.7 ? "increasing" : "decreasing") +
                   " to the right." + (behind ? words_of_behind(view.behind) : ""));
}

}  // namespace

void write_floor_elevation(Markup& html, const ReportInput& input, const FacadeT* facade, int floor) {
  FacadeView view = built_view(*input.deviation, facade, false, floor);
  view.question = "Are the anchors in place?";
  write_elevation(html, input, view, Drawing::sheet);
}

void write_facade(Markup& html, const ReportInput& input) {
  Scope part(html, "section", {{"id", "facade"}});
  html.element("h2", "Facade");
  write_legend(html);
  Scope views(html, "div", {{"class", "views"}});
  const FacadeView model = model_view(input.accuracy);
  if (!input.deviation || input.deviation->facades.empty()) {
    const Drawing drawing = input.deviation && many(*input.deviation) ? Drawing::many : Drawing::named;
    if (input.deviation) write_elevation(html, input, built_view(*input.deviation, nullptr, false), drawing);
    return write_elevation(html, input, model, drawing);
  }
  const DeviationT& deviation = *input.deviation;
  const Drawing drawing = many(deviation) ? Drawing::many : Drawing::named;
  for (const auto& facade : deviation.facades) {
    write_elevation(html, input, built_view(deviation, facade.get(), false), drawing);
    write_elevation(html, input, built_view(deviation, facade.get(), true), drawing);
    write_elevation(html, input, only_of(model, *facade, deviation), drawing);
  }
  write_elevation(html, input, built_view(deviation, nullptr, false), drawing);
}

}  // namespace plumbline::report

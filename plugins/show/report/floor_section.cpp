// Drift chart and table of floors.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include "geometry/statistics.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

constexpr double height = 350, widest = 1040, widest_on_phone = 640;

/// Few floors make a narrow chart, which a telephone shows whole.
double width_of(const AccuracyComparisonT& c) {
  return std::clamp(80 + 110.0 * static_cast<double>(c.floors.size()), 380.0, widest);
}

/// Value with the half length of its confidence interval, in the units spoken.
struct Bar {
  double value, half;
};

Bar bar(double metres, double u, double factor) {
  return {in_units(metres), std::isfinite(u) ? in_units(u) * factor : 0};
}

/// Half height of the chart that holds the tolerance and all bars, in the units spoken.
double range_of(const AccuracyT& accuracy, const AccuracyComparisonT& c, double factor) {
  double largest = in_units(accuracy.tau);
  for (const auto& f : c.floors)
    for (const Bar b : {bar(f->mean_dz, f->u_mean_dz, factor), bar(f->drift, f->u_drift, factor)})
      if (std::isfinite(b.value)) largest = std::max(largest, std::abs(b.value) + b.half);
  return 1.08 * largest;
}

void draw_bar(Markup& svg, const Axes& axes, double x, const Bar& b, const std::string& css, bool square) {
  if (b.half > 0) {
    line(svg, x, axes.y(b.value - b.half), x, axes.y(b.value + b.half), css);
    for (const double end : {b.value - b.half, b.value + b.half})
      line(svg, x - 5, axes.y(end), x + 5, axes.y(end), css);
  }
  const double y = axes.y(b.value);
  if (square)
    svg.empty("rect", {{"class", css}, {"x", px(x - 5)}, {"y", px(y - 5)}, {"width", "10"}, {"height", "10"}});
  else
    svg.empty("circle", {{"class", css}, {"cx", px(x)}, {"cy", px(y)}, {"r", "5.5"}});
}

Axes drift_axes(const AccuracyComparisonT& c, double range) {
  Axes axes;
  const auto n = static_cast<double>(c.floors.size());
  axes.x = {-0.5, n - 0.5, 60, width_of(c) - 10};
  axes.y = {-range, range, height - 26, 30};
  axes.y_ticks = ticks(-range, range, 9);
  for (const double tick : axes.y_ticks) axes.y_labels.push_back(signed_fixed(tick, decimals_of(axes.y_ticks)));
  for (std::size_t i = 0; i < c.floors.size(); ++i) {
    axes.x_ticks.push_back(static_cast<double>(i));
    axes.x_labels.push_back("Floor " + std::to_string(c.floors[i]->floor));
  }
  axes.y_title = unit_of_lengths();
  return axes;
}

void draw_drift_chart(Markup& html, const AccuracyT& accuracy, const AccuracyComparisonT& c) {
  if (!(accuracy.confidence > 0 && accuracy.confidence < 1))
    throw std::runtime_error("the accuracy's 'confidence' is " + std::to_string(accuracy.confidence) +
                             ", expected a probability: its intervals cannot be drawn");
  const double factor = normal_quantile(0.5 + 0.5 * accuracy.confidence);
  const Axes axes = drift_axes(c, range_of(accuracy, c, factor));
  const double tau = in_units(accuracy.tau);
  Scope svg = drawing(html, width_of(c), height,
                      "Mean height residual and cumulative drift of every floor, with the tolerance band");
  html.empty("rect", {{"class", "tolerance"},
                      {"x", px(axes.x.pixel0)},
                      {"y", px(axes.y(tau))},
                      {"width", px(axes.x.pixel1 - axes.x.pixel0)},
                      {"height", px(axes.y(-tau) - axes.y(tau))}});
  draw_axes(html, axes);
  for (const double edge : {tau, -tau})
    line(html, axes.x.pixel0, axes.y(edge), axes.x.pixel1, axes.y(edge), "tolerance-edge");
  line(html, axes.x.pixel0, axes.y(0), axes.x.pixel1, axes.y(0), "zero");
  double last_x = 0, last_y = std::nan("");
  for (std::size_t i = 0; i < c.floors.size(); ++i) {
    const FloorAccuracyT& floor = *c.floors[i];
    if (!std::isfinite(floor.drift)) continue;
    const double x = axes.x(static_cast<double>(i)) + 14, y = axes.y(in_units(floor.drift));
    if (std::isfinite(last_y)) line(html, last_x, last_y, x, y, "drift");
    last_x = x, last_y = y;
  }
  for (std::size_t i = 0; i < c.floors.size(); ++i) {
    const FloorAccuracyT& floor = *c.floors[i];
    const double x = axes.x(static_cast<double>(i));
    if (std::isfinite(floor.mean_dz))
      draw_bar(html, axes, x - 14, bar(floor.mean_dz, floor.u_mean_dz, factor), "mean", false);
    if (std::isfinite(floor.drift))
      draw_bar(html, axes, x + 14, bar(floor.drift, floor.u_drift, factor), "drift", true);
  }
}

void write_drift_legend(Markup& html, const AccuracyT& accuracy, const AccuracyComparisonT& c) {
  Scope legend(html, "div", {{"class", "legend"}});
  const auto item = [&](const char* shape, const std::string& text) {
    Scope span(html, "span");
    html.raw(shape).text(text);
  };
  item(
      "<svg viewBox=\"0 0 14 14\" width=\"14\" height=\"14\" aria-hidden=\"true\"><circle class=\"mean\" cx=\"7\" "
      "cy=\"7\" r=\"5\"/></svg>",
      "mean residual r of the floor");
  if (c.drift_computed)
    item(
        "<svg viewBox=\"0 0 14 14\" width=\"14\" height=\"14\" aria-hidden=\"true\"><rect class=\"drift\" x=\"2\" "
        "y=\"2\" width=\"10\" height=\"10\"/></svg>",
        "cumulative drift D(F)");
  item(
      "<svg viewBox=\"0 0 22 14\" width=\"22\" height=\"14\" aria-hidden=\"true\"><rect class=\"tolerance\" "
      "width=\"22\" height=\"14\"/><line class=\"tolerance-edge\" x1=\"0\" y1=\"1\" x2=\"22\" y2=\"1\"/></svg>",
      "tolerance ±" + tolerance(accuracy.tau));
  item("", "bars: " + percent(accuracy.confidence, 0) + " confidence");
}

void cell(Markup& html, const std::string& text) { html.element("td", text); }

/// The floor that relative drift refers to.
const FloorAccuracyT* first_floor(const AccuracyComparisonT& c) {
  for (const auto& f : c.floors)
    if (f->anchors > 0) return f.get();
  return nullptr;
}

void write_floor_table(Markup& html, const AccuracyComparisonT& c) {
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html, {"Floor", "Anchors", "r ± u [mm]", "D(F) ± u [mm]", left("|D(F)| verdict"), "D(F) meets",
                    "against lowest floor ± u [mm]", "RMSE Δz [mm]", "largest |Δz| [mm]"});
  Scope body(html, "tbody");
  for (const auto& f : c.floors) {
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}}, "Floor " + std::to_string(f->floor));
    cell(html, std::to_string(f->anchors));
    cell(html, mm_with_u(f->mean_dz, f->u_mean_dz));
    cell(html, mm_with_u(f->drift, f->u_drift));
    verdict_cell(html, f->drift_verdict);
    cell(html, std::isfinite(f->drift)
                   ? (std::isfinite(f->smallest_tolerance_met) ? "±" + tolerance(f->smallest_tolerance_met) : "none")
                   : unknown);
    cell(html, f.get() == first_floor(c) ? "reference" : mm_with_u(f->relative_drift, f->u_relative_drift));
    cell(html, mm(f->rmse_z));
    cell(html, mm(f->max_abs_dz));
  }
}

}  // namespace

void write_floors(Markup& html, const AccuracyT& accuracy) {
  const AccuracyComparisonT* c = headline(accuracy);
  if (!c || c->floors.empty() || c->anchors == 0) return;
  Scope part(html, "section", {{"id", "floors"}});
  html.element("h2", "Drift from floor to floor");
  if (!c->evidence) html.element("p", "These are control anchors. " + c->evidence_note);
  {
    Scope figure(html, "figure", {{"class", width_of(*c) <= widest_on_phone ? "whole-chart" : ""}});
    write_drift_legend(html, accuracy, *c);
    draw_drift_chart(html, accuracy, *c);
  }
  write_floor_table(html, *c);
  html.element("p", {{"class", "note"}},
               "“D(F) meets” is the smallest tolerance of the sweep that |D(F)| stays within, without a guard band.");
}

}  // namespace plumbline::report

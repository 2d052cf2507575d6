// Pass rate over the tolerance, with its confidence band; the slider of the first screen moves its mark where scripts
// run.
#include <cmath>

#include "show/report/format.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

constexpr double width = 640, height = 340;

Axes pass_axes(const AccuracyComparisonT& c) {
  Axes axes;
  axes.x = {in_units(c.pass_rates.front()->tolerance), in_units(c.pass_rates.back()->tolerance), 60, width - 24};
  axes.y = {0, 1, height - 52, 30};
  for (const auto& rate : c.pass_rates) {
    axes.x_ticks.push_back(in_units(rate->tolerance));
    axes.x_labels.push_back(mm(rate->tolerance, 1));
  }
  for (const double tick : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) {
    axes.y_ticks.push_back(tick);
    axes.y_labels.push_back(fixed(100 * tick, 0) + "\u00A0%");
  }
  axes.x_title = "tolerance ± [mm]";
  axes.y_title = "anchors within the tolerance";
  return axes;
}

std::string points(const Axes& axes, const std::vector<std::pair<double, double>>& values) {
  std::string text;
  for (const auto& [x, y] : values) text += (text.empty() ? "" : " ") + px(axes.x(x)) + "," + px(axes.y(y));
  return text;
}

void draw_curve(Markup& html, const AccuracyT& accuracy, const AccuracyComparisonT& c) {
  const Axes axes = pass_axes(c);
  std::vector<std::pair<double, double>> curve, band;
  for (const auto& rate : c.pass_rates) {
    curve.emplace_back(in_units(rate->tolerance), rate->rate);
    band.emplace_back(in_units(rate->tolerance), rate->upper);
  }
  for (auto rate = c.pass_rates.rbegin(); rate != c.pass_rates.rend(); ++rate)
    band.emplace_back(in_units((*rate)->tolerance), (*rate)->lower);
  Scope svg = drawing(html, width, height, "Pass rate over the tolerance with its Wilson interval");
  html.empty("polygon", {{"class", "band"}, {"points", points(axes, band)}});
  draw_axes(html, axes);
  line(html, axes.x.pixel0, axes.y(0.95), axes.x.pixel1, axes.y(0.95), "goal");
  html.empty("polygon", {{"class", "band-edge"}, {"points", points(axes, band)}});
  html.empty("polyline", {{"class", "curve"}, {"points", points(axes, curve)}});
  for (const auto& [tau, rate] : curve)
    html.empty("circle", {{"class", "mean"}, {"cx", px(axes.x(tau))}, {"cy", px(axes.y(rate))}, {"r", "3.5"}});
  const double x = axes.x(in_units(accuracy.tau));
  html.empty("line", {{"class", "headline"},
                      {"id", "tau-marker"},
                      {"x1", px(x)},
                      {"x2", px(x)},
                      {"y1", px(axes.y(0))},
                      {"y2", px(axes.y(1) - 6)},
                      {"data-x0", px(axes.x.pixel0)},
                      {"data-x1", px(axes.x.pixel1)},
                      {"data-v0", px(1e3 * c.pass_rates.front()->tolerance)},
                      {"data-v1", px(1e3 * c.pass_rates.back()->tolerance)}});
}

void write_rate_table(Markup& html, const AccuracyComparisonT& c, double confidence) {
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Tolerance", "Within", "Evaluated", "Pass rate", "Wilson interval (" + percent(confidence, 0) + ")",
                    "at least, one-sided (" + percent(confidence, 0) + ")"});
  Scope body(html, "tbody");
  for (const auto& rate : c.pass_rates)
    table_row(html,
              {"±" + tolerance(rate->tolerance), std::to_string(rate->passed), std::to_string(rate->evaluated),
               percent(rate->rate), percent(rate->lower) + " to " + percent(rate->upper), percent(rate->exact_lower)});
}

}  // namespace

void write_pass_rates(Markup& html, const AccuracyT& accuracy) {
  const AccuracyComparisonT* c = headline(accuracy);
  if (!c || c->anchors == 0 || c->pass_rates.size() < 2) return;
  Scope part(html, "section", {{"id", "passrate"}});
  html.element("h2", "Pass rate");
  html.element("p", "Share of the " + std::to_string(c->anchors) + " " + anchors_of(*c) +
                        " whose height is within the tolerance. The band is what so few anchors can show (Wilson "
                        "interval); the dotted line "
                        "is 95\u00A0%, the dashed line the tolerance in force. Anchors of one building share errors, "
                        "so the band is rather too narrow.");
  {
    Scope figure(html, "figure", {{"class", "whole-chart"}});
    draw_curve(html, accuracy, *c);
  }
  folded(html, "All tolerances as a table", [&] { write_rate_table(html, *c, accuracy.confidence); });
}

}  // namespace plumbline::report

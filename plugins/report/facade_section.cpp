// Elevation of the facade: every anchor at its place, its verdict as shape and colour, its deviation as an exaggerated
// arrow.
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "report/anchor_names.hpp"
#include "report/format.hpp"
#include "report/plot.hpp"
#include "report/sections.hpp"

namespace plumbline::report {

namespace {

/// An anchor in the plane of the facade.
struct Spot {
  const AnchorAccuracyT* anchor;
  double along, height;  ///< [m]
};

/// Horizontal direction along which the anchors spread most; pointing to +x, or to +y where that is undecided.
Eigen::Vector2d facade_direction(const std::vector<const AnchorAccuracyT*>& anchors) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const auto* a : anchors) mean += Eigen::Vector2d(a->x, a->y) / static_cast<double>(anchors.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const auto* a : anchors) {
    const Eigen::Vector2d d = Eigen::Vector2d(a->x, a->y) - mean;
    scatter += d * d.transpose();
  }
  if (scatter.trace() < 1e-6) return {1, 0};  // one vertical column
  Eigen::Vector2d direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvectors().col(1);
  if (direction.x() < -1e-6 || (std::abs(direction.x()) <= 1e-6 && direction.y() < 0)) direction = -direction;
  return direction;
}

/// What one drawing shows.
struct View {
  std::string question;
  std::string name;  ///< "model minus survey"
  std::unique_ptr<AnchorDifferenceT> AnchorAccuracyT::*difference;
  bool mark_control;  ///< control anchors hollow
};

struct Elevation {
  std::vector<Spot> spots;
  Eigen::Vector2d direction;
  Scale x, y;                    ///< [m] to px
  double width = 0, height = 0;  ///< of the drawing [px]
  double pixels_per_metre = 1;
  double exaggeration = 1;
  std::map<int, std::string> prefixes;  ///< of names, left out in the drawing
};

double smallest_spacing(const std::vector<Spot>& spots) {
  double spacing = 1e9;
  for (std::size_t i = 0; i < spots.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double d = std::hypot(spots[i].along - spots[j].along, spots[i].height - spots[j].height);
      if (d > 0.05) spacing = std::min(spacing, d);
    }
  return spacing < 1e9 ? spacing : 2.0;
}

bool has_design(const AccuracyT& accuracy) { return accuracy.design && accuracy.design->anchors > 0; }

Elevation layout(const AccuracyT& accuracy, const View& view) {
  Elevation e;
  std::vector<const AnchorAccuracyT*> placed;
  for (const auto& a : accuracy.anchors)
    if (std::isfinite(a->x) && std::isfinite(a->y) && std::isfinite(a->z)) placed.push_back(a.get());
  if (placed.empty()) return e;
  e.direction = facade_direction(placed);
  e.prefixes = common_prefixes(accuracy);
  double left = 1e300, right = -1e300, low = 1e300, high = -1e300, largest = 0;
  for (const auto* a : placed) {
    const double along = e.direction.dot(Eigen::Vector2d(a->x, a->y));
    e.spots.push_back({a, along, a->z});
    left = std::min(left, along), right = std::max(right, along);
    low = std::min(low, a->z), high = std::max(high, a->z);
    if (const auto* d = (a->*view.difference).get())
      largest = std::max(largest, std::hypot(e.direction.dot(Eigen::Vector2d(d->dx, d->dy)), d->dz));
  }
  const double span_x = std::max(right - left, 1.0), span_y = std::max(high - low, 1.0);
  e.width = has_design(accuracy) ? 520 : 1040;
  const double margin_left = 72, margin_right = has_design(accuracy) ? 110 : 150, margin = 70;
  e.pixels_per_metre = std::min((e.width - margin_left - margin_right) / span_x, 900.0 / span_y);
  const double used = e.pixels_per_metre * span_x;
  const double start = margin_left + 0.5 * (e.width - margin_left - margin_right - used);
  e.height = e.pixels_per_metre * span_y + 2 * margin;
  e.x = {left, left + span_x, start, start + used};
  e.y = {low, low + span_y, e.height - margin, margin};
  // No arrow longer than nine tenths of the way to the next anchor, nor than the margins are wide.
  const double longest = std::min(0.9 * smallest_spacing(e.spots), 60 / e.pixels_per_metre);
  e.exaggeration = largest > 0 ? round_down(longest / largest) : 1;
  return e;
}

void draw_storeys(Markup& svg, const Elevation& e) {
  std::map<int, std::pair<double, int>> heights;
  for (const Spot& s : e.spots)
    if (s.anchor->floor > 0) heights[s.anchor->floor].first += s.height, ++heights[s.anchor->floor].second;
  double previous = std::nan("");
  for (const auto& [floor, sum] : heights) {
    const double mean = sum.first / sum.second;
    label(svg, 12, e.y(mean) + 4, "Floor " + std::to_string(floor), "small strong", "start");
    if (std::isfinite(previous))
      line(svg, 12, e.y(0.5 * (mean + previous)), e.width - 12, e.y(0.5 * (mean + previous)), "storey");
    previous = mean;
  }
}

/// A round deviation [m] whose arrow is 20 to 50 px long.
double scale_deviation(const Elevation& e) { return round_down(50 / (e.exaggeration * e.pixels_per_metre)); }

void draw_scale_arrow(Markup& svg, const Elevation& e) {
  const double deviation = scale_deviation(e), length = deviation * e.exaggeration * e.pixels_per_metre;
  const double x = e.width - 40, y = 0.5 * e.height;
  arrow(svg, x, y + 0.5 * length, x, y - 0.5 * length, "arrow");
  label(svg, x, y + 0.5 * length + 18, tolerance(deviation), "small", "middle");
}

void draw_elevation(Markup& html, const Elevation& e, const View& view) {
  Scope svg = drawing(html, e.width, e.height, "Elevation of the facade with " + view.name + " as arrows");
  draw_storeys(html, e);
  draw_scale_arrow(html, e);
  LabelPlacer labels({60, 2, e.width - 2, e.height - 2}, 13);
  const double half = 0.5 * scale_deviation(e) * e.exaggeration * e.pixels_per_metre;
  labels.block({e.width - 62, 0.5 * e.height - half - 4, e.width, 0.5 * e.height + half + 26});  // the scale arrow
  struct Tip {
    double x, y;
  };
  std::vector<Tip> tips;
  for (const Spot& s : e.spots) {
    const double x = e.x(s.along), y = e.y(s.height);
    Tip tip{x, y};
    if (const auto* d = (s.anchor->*view.difference).get()) {
      const double scale = e.exaggeration * e.pixels_per_metre;
      tip = {x + scale * e.direction.dot(Eigen::Vector2d(d->dx, d->dy)), y - scale * d->dz};
    }
    labels.block({x - 8, y - 8, x + 8, y + 8});
    labels.block_segment(x, y, tip.x, tip.y);
    tips.push_back(tip);
  }
  for (const Spot& s : e.spots) {
    const auto* d = (s.anchor->*view.difference).get();
    verdict_symbol(html, e.x(s.along), e.y(s.height), 6, d ? d->verdict : ToleranceVerdict::not_measured,
                   view.mark_control && s.anchor->use == AnchorUse::control);
  }
  // Above the symbols, or short arrows would vanish under them.
  for (std::size_t i = 0; i < e.spots.size(); ++i)
    arrow(html, e.x(e.spots[i].along), e.y(e.spots[i].height), tips[i].x, tips[i].y, "arrow");
  for (const Spot& s : e.spots) {
    const auto* d = (s.anchor->*view.difference).get();
    const std::string value = d ? " " + signed_mm(d->dz, 1) : "";
    const double x = e.x(s.along), y = e.y(s.height);
    const auto prefix = e.prefixes.find(s.anchor->floor);
    const std::string name = s.anchor->id.substr(prefix == e.prefixes.end() ? 0 : prefix->second.size());
    if (!labels.place(html, x, y, 13, name + value, "halo mark")) labels.place(html, x, y, 13, name, "halo mark");
  }
}

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

void write_view(Markup& html, const AccuracyT& accuracy, const View& view) {
  const Elevation e = layout(accuracy, view);
  if (e.spots.empty()) return;
  Scope figure(html, "figure");
  html.element("h3", view.question);
  draw_elevation(html, e, view);
  html.element("figcaption", "Arrows: " + view.name + ", drawn ×" + fixed(e.exaggeration, 0) +
                                 " (the arrow at the right edge stands for " + tolerance(scale_deviation(e)) +
                                 "); numbers: height deviation in mm. " +
                                 (e.prefixes.empty() ? "" : "Names without the part that a floor has in common. ") +
                                 "Drawn along the facade, " +
                                 (std::abs(e.direction.x()) >= std::abs(e.direction.y()) ? "x" : "y") +
                                 " increasing to the right.");
}

}  // namespace

void write_facade(Markup& html, const AccuracyT& accuracy) {
  Scope part(html, "section", {{"id", "facade"}});
  html.element("h2", "Facade");
  const bool with_design = has_design(accuracy);
  write_legend(html);
  Scope views(html, "div", {{"class", with_design ? "pair" : "views"}});
  write_view(html, accuracy, {"Is the model right?", "model minus survey", &AnchorAccuracyT::survey, true});
  if (with_design)
    write_view(html, accuracy, {"Are the anchors in place?", "as-built minus design", &AnchorAccuracyT::design, false});
}

}  // namespace plumbline::report

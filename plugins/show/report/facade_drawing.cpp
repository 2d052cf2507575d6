#include "show/report/facade_drawing.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>

#include "show/report/anchor_names.hpp"
#include "show/report/facade_backdrop.hpp"
#include "show/report/format.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// Horizontal direction along which the anchors spread most; pointing to +x, or to +y where that is undecided.
Eigen::Vector3d facade_direction(const std::vector<Spot>& anchors) {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Spot& a : anchors) mean += a.position.head<2>() / static_cast<double>(anchors.size());
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const Spot& a : anchors) {
    const Eigen::Vector2d d = a.position.head<2>() - mean;
    scatter += d * d.transpose();
  }
  if (scatter.trace() < 1e-6) return {1, 0, 0};  // one vertical column
  Eigen::Vector2d direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(scatter).eigenvectors().col(1);
  if (direction.x() < -1e-6 || (std::abs(direction.x()) <= 1e-6 && direction.y() < 0)) direction = -direction;
  return {direction.x(), direction.y(), 0};
}

/// Between two anchors that are not at one place [m].
double smallest_spacing(std::vector<Spot> spots) {
  std::sort(spots.begin(), spots.end(), [](const Spot& a, const Spot& b) { return a.along < b.along; });
  double spacing = 1e9;
  for (std::size_t i = 0; i < spots.size(); ++i)
    for (std::size_t j = i + 1; j < spots.size() && spots[j].along - spots[i].along < spacing; ++j) {
      const double d = std::hypot(spots[i].along - spots[j].along, spots[i].height - spots[j].height);
      if (d > 0.05) spacing = std::min(spacing, d);
    }
  return spacing < 1e9 ? spacing : 2.0;
}

double middle_of(const Elevation& e, const Quad& quad) {
  double sum = 0;
  for (const Eigen::Vector3d& corner : quad.corners) sum += e.sight.along(corner);
  return sum / static_cast<double>(quad.corners.size());
}

void draw_panels(Markup& svg, const Elevation& e, const FacadeView& view) {
  for (const Quad& quad : view.panels) {
    if (!e.holds(middle_of(e, quad))) continue;
    std::string points;
    for (const Eigen::Vector3d& corner : quad.corners) {
      const Eigen::Vector2d at = e.drawn(corner);
      points += (points.empty() ? "" : " ") + px(at.x()) + "," + px(at.y());
    }
    svg.empty("polygon", {{"class", std::string("quad ") + verdict_class(quad.verdict)}, {"points", points}});
  }
}

/// Names of panels where their anchors leave room, with the sign of the verdict: the middle often holds a check anchor.
void name_panels(Markup& svg, const Elevation& e, const FacadeView& view, LabelPlacer& labels) {
  for (const Quad& quad : view.panels) {
    if (!e.holds(middle_of(e, quad))) continue;
    const char* sign = quad.verdict == ToleranceVerdict::pass        ? "● "
                       : quad.verdict == ToleranceVerdict::undecided ? "▲ "
                       : quad.verdict == ToleranceVerdict::fail      ? "■ "
                                                                     : "✕ ";
    const auto at = [&](double across, double up) {
      const Eigen::Vector3d low = quad.corners[0] + across * (quad.corners[1] - quad.corners[0]);
      const Eigen::Vector3d high = quad.corners[3] + across * (quad.corners[2] - quad.corners[3]);
      return e.drawn(low + up * (high - low));
    };
    const auto placed = [&](const std::string& text) {
      for (const double up : {0.9, 0.1, 0.7, 0.3, 0.6, 0.4, 0.5})
        for (const double across : {0.5, 0.3, 0.7}) {
          const Eigen::Vector2d p = at(across, up);
          if (labels.place_at(svg, p.x(), p.y(), "middle", text, "small halo")) return true;
        }
      return false;
    };
    const std::string end = sign + end_of(quad.name);
    if (placed(sign + quad.name) || placed(end)) continue;
    const Eigen::Vector2d p = at(0.5, 0.9);
    label(svg, p.x(), p.y(), end, "small halo", "middle");
  }
}

void draw_storeys(Markup& svg, const Elevation& e) {
  std::map<int, std::pair<double, int>> heights;
  for (const Spot& s : e.spots)
    if (s.floor > 0) heights[s.floor].first += s.height, ++heights[s.floor].second;
  double previous = std::nan("");
  for (const auto& [floor, sum] : heights) {
    const double mean = sum.first / sum.second;
    label(svg, 12, e.y(mean) + 4, "Floor " + std::to_string(floor), "small strong", "start");
    if (std::isfinite(previous))
      line(svg, 12, e.y(0.5 * (mean + previous)), e.width - 12, e.y(0.5 * (mean + previous)), "storey");
    previous = mean;
  }
}

void draw_scale_arrow(Markup& svg, const Elevation& e) {
  const double deviation = scale_deviation(e), length = deviation * e.exaggeration * e.pixels_per_metre;
  const double x = e.width - 40, y = 0.5 * e.height;
  arrow(svg, x, y + 0.5 * length, x, y - 0.5 * length, "arrow");
  label(svg, x, y + 0.5 * length + 18, tolerance(deviation), "small", "middle");
}

/// What there is of it behind the anchors; false if nothing is.
bool draw_behind(Markup& svg, const Elevation& e, Behind behind, const ReportInput& input) {
  const LookedAt at{e.sight.right.cross(e.sight.up).normalized(), e.spots.front().position};
  const Drawn drawn = [&e](const Eigen::Vector3d& point) { return e.drawn(point); };
  if (behind == Behind::heat) return input.surfaces && draw_heat(svg, *input.surfaces, at, drawn);
  // A picture is flat: of a facade that is unrolled it would lie beside it.
  return behind == Behind::picture && e.sight.unrolled.empty() && draw_pictures(svg, input.pictures, at, drawn);
}

/// Verdicts in the order of drawing: what is to be mended lies above what is in order.
constexpr ToleranceVerdict kDrawn[] = {ToleranceVerdict::pass, ToleranceVerdict::not_measured,
                                       ToleranceVerdict::undecided, ToleranceVerdict::fail};

std::string move_to(double x, double y) { return "M" + px(x) + " " + px(y); }

/// As wide as the names need: some 110 px from anchor to anchor, within what a page can show.
void scale(Elevation& e) {
  const double span_x = std::max(e.right - e.left, 1.0), span_y = std::max(e.high - e.low, 1.0);
  const double margin_left = 72, margin_right = 150, margin = 70;
  e.width = std::clamp(margin_left + margin_right + 110 * span_x / e.spacing, 1040.0, 2400.0);
  e.pixels_per_metre =
      std::min((e.width - margin_left - margin_right) / span_x, std::max(900.0, 60 * span_y / e.spacing) / span_y);
  const double used = e.pixels_per_metre * span_x;
  const double start = margin_left + 0.5 * (e.width - margin_left - margin_right - used);
  e.height = e.pixels_per_metre * span_y + 2 * margin;
  e.x = {e.left, e.left + span_x, start, start + used};
  e.y = {e.low, e.low + span_y, e.height - margin, margin};
  // No arrow longer than nine tenths of the way to the next anchor, nor than the margins are wide.
  const double longest = std::min(0.9 * e.spacing, 60 / e.pixels_per_metre);
  // Nor is less than a tenth of a millimetre, which nobody measures, drawn as long as what matters.
  e.exaggeration = round_down(longest / std::max(e.largest, 1e-4));
}

}  // namespace

Elevation elevation_of(const AccuracyT& accuracy, const FacadeView& view) {
  Elevation e;
  for (const Spot& spot : view.spots)
    if (spot.position.allFinite()) e.spots.push_back(spot);
  if (e.spots.empty()) return e;
  e.sight = view.sight;
  if (e.sight.right.isZero()) e.sight.right = facade_direction(e.spots);
  e.prefixes = common_prefixes(accuracy);
  e.left = e.low = 1e300, e.right = e.high = -1e300;
  const auto reach = [&](const Eigen::Vector3d& p) {
    e.left = std::min(e.left, e.sight.along(p)), e.right = std::max(e.right, e.sight.along(p));
    e.low = std::min(e.low, e.sight.up.dot(p)), e.high = std::max(e.high, e.sight.up.dot(p));
  };
  for (Spot& spot : e.spots) {
    spot.along = e.sight.along(spot.position), spot.height = e.sight.up.dot(spot.position);
    reach(spot.position);
    if (spot.difference.allFinite())
      e.largest = std::max(e.largest, std::hypot(e.sight.right.dot(spot.difference), e.sight.up.dot(spot.difference)));
  }
  for (const Quad& quad : view.panels)
    for (const Eigen::Vector3d& corner : quad.corners) reach(corner);
  e.spacing = smallest_spacing(e.spots);
  scale(e);
  return e;
}

std::vector<Elevation> stretches_of(const Elevation& whole) {
  constexpr double most = 10;  // spacings
  const auto wanted = static_cast<std::size_t>(std::ceil((whole.right - whole.left) / (most * whole.spacing) - 1e-9));
  // Anchors in pairs are near to one another, but few.
  const std::size_t n = std::clamp<std::size_t>(wanted, 1, 1 + whole.spots.size() / 6);
  if (n == 1) return {whole};
  const double length = (whole.right - whole.left) / static_cast<double>(n);
  std::vector<Elevation> stretches(n, whole);
  for (std::size_t k = 0; k < n; ++k) {
    Elevation& e = stretches[k];
    e.left = whole.left + static_cast<double>(k) * length, e.right = e.left + length;
    constexpr double rounding = 1e-6;
    if (k > 0) e.from = e.left - rounding;
    if (k + 1 < n) e.to = e.right - rounding;
    std::erase_if(e.spots, [&](const Spot& spot) { return !e.holds(spot.along); });
    scale(e);
  }
  std::erase_if(stretches, [](const Elevation& e) { return e.spots.empty(); });
  return stretches;
}

double scale_deviation(const Elevation& e) { return round_length_down(50 / (e.exaggeration * e.pixels_per_metre)); }

bool draw_elevation(Markup& html, const Elevation& e, const FacadeView& view, const ReportInput& input) {
  Scope svg = drawing(html, e.width, e.height, "Elevation of the facade with " + view.name + " as arrows");
  const bool behind = draw_behind(html, e, view.behind, input);
  draw_panels(html, e, view);
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
    if (s.difference.allFinite()) {
      const double scale = e.exaggeration * e.pixels_per_metre;
      tip = {x + scale * e.sight.right.dot(s.difference), y - scale * e.sight.up.dot(s.difference)};
    }
    labels.block({x - 8, y - 8, x + 8, y + 8});
    labels.block_segment(x, y, tip.x, tip.y);
    tips.push_back(tip);
  }
  for (const Spot& s : e.spots) verdict_symbol(html, e.x(s.along), e.y(s.height), 6, s.verdict, s.control);
  // Above the symbols, or short arrows would vanish under them.
  for (std::size_t i = 0; i < e.spots.size(); ++i)
    arrow(html, e.x(e.spots[i].along), e.y(e.spots[i].height), tips[i].x, tips[i].y, "arrow");
  for (const Spot& s : e.spots) {
    const std::string value = std::isfinite(s.number) ? " " + signed_mm(s.number, 1) : "";
    const double x = e.x(s.along), y = e.y(s.height);
    const auto prefix = e.prefixes.find(s.floor);
    const bool cut = prefix != e.prefixes.end() && s.id.starts_with(prefix->second);
    const std::string name = s.id.substr(cut ? prefix->second.size() : 0);
    const std::string end = end_of(name);
    const auto placed = [&](const std::string& text) { return labels.place(html, x, y, 13, text, "halo mark"); };
    if (placed(name + value) || placed(name) || placed(end + value) || placed(end)) continue;
    // What finds no free place stands over something else: covered is better than lost.
    label(html, x + 9, y + 4, end + value, "halo small", "start");
  }
  name_panels(html, e, view, labels);
  return behind;
}

bool draw_many(Markup& html, const Elevation& e, const FacadeView& view, const ReportInput& input) {
  Scope svg = drawing(html, e.width, e.height, "Elevation of the facade with " + view.name + " as arrows");
  const bool behind = draw_behind(html, e, view.behind, input);
  std::map<ToleranceVerdict, std::string> quads, marks;
  std::string arrows;
  for (const Quad& quad : view.panels) {
    std::string& path = quads[quad.verdict];
    for (std::size_t i = 0; i < quad.corners.size(); ++i) {
      const Eigen::Vector2d at = e.drawn(quad.corners[i]);
      path += i == 0 ? move_to(at.x(), at.y()) : "L" + px(at.x()) + " " + px(at.y());
    }
    path += "z";
  }
  const double scale = e.exaggeration * e.pixels_per_metre;
  for (const Spot& s : e.spots) {
    const double x = e.x(s.along), y = e.y(s.height), r = s.verdict == ToleranceVerdict::fail ? 3 : 2.2;
    std::string& path = marks[s.verdict];
    path += move_to(x - r, y + r);
    if (s.verdict == ToleranceVerdict::undecided)
      path += "h" + px(2 * r) + "L" + px(x) + " " + px(y - r);
    else
      path += "h" + px(2 * r) + "v" + px(-2 * r) + "h" + px(-2 * r);
    path += "z";
    if (s.difference.allFinite() && s.verdict != ToleranceVerdict::pass)
      arrows += move_to(x, y) + "l" + px(scale * e.sight.right.dot(s.difference)) + " " +
                px(-scale * e.sight.up.dot(s.difference));
  }
  for (const ToleranceVerdict verdict : kDrawn)
    if (const auto found = quads.find(verdict); found != quads.end())
      html.empty("path", {{"class", std::string("quad ") + verdict_class(verdict)}, {"d", found->second}});
  draw_storeys(html, e);
  draw_scale_arrow(html, e);
  html.empty("path", {{"class", "shaft thin"}, {"d", arrows}});
  for (const ToleranceVerdict verdict : kDrawn)
    if (const auto found = marks.find(verdict); found != marks.end())
      html.empty("path", {{"class", std::string("symbol thin ") + verdict_class(verdict)}, {"d", found->second}});
  return behind;
}

}  // namespace plumbline::report

#include "show/report/network_drawing.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "geometry/median.hpp"
#include "show/report/format.hpp"
#include "show/report/plot.hpp"

namespace plumbline::report {

namespace {

constexpr double width = 1040, margin = 60;
/// Scales standard ellipses to 95 % in two dimensions: sqrt of the chi-square quantile.
constexpr double ellipse_95 = 2.4477;

/// Two coordinate axes of a drawing.
struct Projection {
  std::string name, horizontal, vertical;
  Eigen::Matrix<double, 2, 3> axes;
};

struct Spot {
  const NetworkPage::Point* point;
  Eigen::Vector2d at;
  Eigen::Vector2d semi_axes = Eigen::Vector2d::Constant(std::nan(""));  ///< 95 % [m], longest first
  double angle = 0;  ///< of the longest axis, from the horizontal axis to the vertical one [rad]
  Eigen::Vector2d movement = Eigen::Vector2d::Constant(std::nan(""));  ///< [m]
};

struct Layout {
  std::vector<Spot> spots;
  Scale x, y;
  double pixels_per_metre = 1, exaggeration = 1, drawing_height = 0;
  double symbols = 1;      ///< size of dots, triangles and rings: smaller where points crowd
  bool ellipses = false;   ///< there are any
  bool rings = false;      ///< worth drawing: some points carry the datum, others do not
  std::size_t hidden = 0;  ///< points that others stand for
};

/// A drawing grows with its size on the paper, not with the network: beyond so many points one stands for its cell.
constexpr std::size_t most_points = 600, most_sights = 1500;
constexpr double cell = 18;  // [px]

/// [px] of a semi-axis; a free instrument station may be known ten times worse than the markers.
constexpr double largest_station_ellipse = 60;

Spot spot_of(const NetworkPage::Point& point, const Projection& projection) {
  Spot spot{&point, projection.axes * point.position};
  spot.movement = projection.axes * point.movement;
  if (!point.covariance.allFinite()) return spot;
  const Eigen::Matrix2d s = projection.axes * point.covariance * projection.axes.transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(s);
  spot.semi_axes = {ellipse_95 * std::sqrt(std::max(0.0, eigen.eigenvalues()[1])),
                    ellipse_95 * std::sqrt(std::max(0.0, eigen.eigenvalues()[0]))};
  spot.angle = std::atan2(eigen.eigenvectors()(1, 1), eigen.eigenvectors()(0, 1));
  return spot;
}

/// Median over points of the distance to the nearest other point [m].
double usual_spacing(const std::vector<Spot>& spots) {
  std::vector<double> nearest;
  for (const Spot& a : spots) {
    double least = 1e300;
    for (const Spot& b : spots)
      if ((a.at - b.at).norm() > 0.05) least = std::min(least, (a.at - b.at).norm());
    if (least < 1e300) nearest.push_back(least);
  }
  return nearest.empty() ? 1 : upper_median(std::move(nearest));
}

/// Makes the usual ellipse as large as the distance to the next point allows, and the largest no larger than 90 px.
/// Markers set the size: nobody minds a free instrument station that is known worse.
double exaggeration_of(const std::vector<Spot>& spots, double pixels_per_metre, double spacing) {
  const bool any_marker =
      std::any_of(spots.begin(), spots.end(), [](const Spot& s) { return !s.point->station && s.semi_axes[0] > 0; });
  std::vector<double> sizes;
  double largest = 0, movement = 0;
  for (const Spot& s : spots) {
    if (s.semi_axes[0] > 0 && !(any_marker && s.point->station)) sizes.push_back(s.semi_axes[0]);
    if (s.movement.allFinite()) movement = std::max(movement, s.movement.norm());
  }
  if (!sizes.empty()) {
    std::sort(sizes.begin(), sizes.end());
    largest = std::max(sizes.back(), movement);
  }
  if (!(largest > 0)) return 1;
  const double usual = std::max(sizes[sizes.size() / 2], 0.1 * largest);
  const double wanted = std::min(std::clamp(0.45 * spacing, 8.0, 26.0) / usual, 90 / largest);
  return round_down(wanted / pixels_per_metre);
}

/// Rings say something if points carry the datum and other points of their kind do not.
bool tell_apart(const std::vector<Spot>& spots) {
  const auto count = [&](bool station, bool datum) {
    return std::count_if(spots.begin(), spots.end(),
                         [&](const Spot& s) { return s.point->station == station && s.point->datum == datum; });
  };
  const auto markers = count(false, true) + count(false, false);
  if (markers == 0) return count(true, true) > 0 && count(true, false) > 0;
  return count(false, false) > 0 && count(false, true) + count(true, true) > 0;
}

/// What something is to be said of stays, and of each cell the point that is known worst.
void thin_out(const NetworkPage& network, Layout& out) {
  if (out.spots.size() <= most_points) return;
  std::set<std::string> told;
  for (const auto& o : network.observations)
    if (o.flagged || o.removed) told.insert({o.from, o.to});
  std::vector<Spot> kept;
  std::map<std::pair<int, int>, Spot> worst;
  for (const Spot& s : out.spots) {
    if (s.point->moved || (told.size() < most_points && told.contains(s.point->id))) {
      kept.push_back(s);
      continue;
    }
    const std::pair at(static_cast<int>(out.x(s.at.x()) / cell), static_cast<int>(out.y(s.at.y()) / cell));
    const auto [there, is_new] = worst.try_emplace(at, s);
    if (!is_new && !(s.semi_axes[0] <= there->second.semi_axes[0])) there->second = s;
  }
  for (const auto& [at, s] : worst) kept.push_back(s);
  out.hidden = out.spots.size() - kept.size();
  out.spots = std::move(kept);
}

Layout layout(const NetworkPage& network, const Projection& projection) {
  Layout out;
  for (const auto& point : network.points)
    if (point.position.allFinite()) out.spots.push_back(spot_of(point, projection));
  if (out.spots.empty()) return out;
  Eigen::Vector2d low = out.spots.front().at, high = low;
  for (const Spot& s : out.spots) low = low.cwiseMin(s.at), high = high.cwiseMax(s.at);
  const Eigen::Vector2d span = (high - low).cwiseMax(1.0);
  out.pixels_per_metre = std::min((width - 2 * margin - 60) / span.x(), 520.0 / span.y());
  out.drawing_height = out.pixels_per_metre * span.y() + 2 * margin;
  const double used = out.pixels_per_metre * span.x(), start = 0.5 * (width - used);
  out.x = {low.x(), low.x() + span.x(), start, start + used};
  out.y = {low.y(), low.y() + span.y(), out.drawing_height - margin, margin};
  thin_out(network, out);
  const double spacing = usual_spacing(out.spots) * out.pixels_per_metre;
  out.symbols = std::clamp(spacing / 30, out.spots.size() < 100 ? 0.6 : 0.35, 1.0);
  out.rings = tell_apart(out.spots);
  out.ellipses = std::any_of(out.spots.begin(), out.spots.end(), [](const Spot& s) { return s.semi_axes[0] > 0; });
  out.exaggeration = exaggeration_of(out.spots, out.pixels_per_metre, spacing);
  return out;
}

void draw_sights(Markup& svg, const NetworkPage& network, const Layout& layout) {
  std::map<std::string, const Spot*> by_id;
  for (const Spot& s : layout.spots) by_id[s.point->id] = &s;
  std::set<std::pair<std::string, std::string>> drawn, suspect;
  std::string path, suspects;
  const auto line_to = [&](const NetworkPage::Observation& o) {
    const auto from = by_id.find(o.from), to = by_id.find(o.to);
    if (from == by_id.end() || to == by_id.end()) return std::string();
    const Eigen::Vector2d &a = from->second->at, &b = to->second->at;
    return "M" + px(layout.x(a.x())) + " " + px(layout.y(a.y())) + "L" + px(layout.x(b.x())) + " " +
           px(layout.y(b.y()));
  };
  for (const auto& o : network.observations)
    if ((o.flagged || o.removed) && suspect.emplace(o.from, o.to).second) suspects += line_to(o);
  for (const auto& o : network.observations)
    if (layout.hidden == 0 && drawn.size() < most_sights && !suspect.contains({o.from, o.to}) &&
        drawn.emplace(o.from, o.to).second)
      path += line_to(o);
  if (!path.empty()) svg.empty("path", {{"class", "sight"}, {"d", path}});
  if (!suspects.empty()) svg.empty("path", {{"class", "sight suspect"}, {"d", suspects}});
}

void draw_point(Markup& svg, const Layout& layout, const Spot& s) {
  const double x = layout.x(s.at.x()), y = layout.y(s.at.y());
  const double scale = layout.exaggeration * layout.pixels_per_metre;
  // The ellipse of a movement stands at the head of its arrow: the point has moved if it leaves the dot outside.
  const Eigen::Vector2d tip = s.movement.allFinite() ? Eigen::Vector2d(scale * s.movement) : Eigen::Vector2d(0, 0);
  if (std::isfinite(s.semi_axes[0]) && (!s.point->station || scale * s.semi_axes[0] < largest_station_ellipse))
    svg.empty("ellipse", {{"class", "ellipse"},
                          {"cx", "0"},
                          {"cy", "0"},
                          {"rx", px(scale * s.semi_axes[0])},
                          {"ry", px(scale * s.semi_axes[1])},
                          {"transform", "translate(" + px(x + tip.x()) + " " + px(y - tip.y()) + ") rotate(" +
                                            px(-s.angle * 180 / M_PI) + ")"}});
  arrow(svg, x, y, x + tip.x(), y - tip.y(), s.point->moved ? "moved" : "unmoved");
  const double k = layout.symbols;
  if (s.point->station)
    svg.empty("polygon", {{"class", "station"},
                          {"points", px(x) + "," + px(y - 7 * k) + " " + px(x + 6.5 * k) + "," + px(y + 5 * k) + " " +
                                         px(x - 6.5 * k) + "," + px(y + 5 * k)}});
  else
    svg.empty("circle", {{"class", "dot"}, {"cx", px(x)}, {"cy", px(y)}, {"r", px(3 * k)}});
  if (s.point->datum && layout.rings)
    svg.empty("circle", {{"class", "datum-ring"}, {"cx", px(x)}, {"cy", px(y)}, {"r", px(9 * k)}});
}

/// Two bars below: length in the drawing, and size of an ellipse.
void draw_scales(Markup& svg, const Layout& layout) {
  const double metres = round_down(140 / layout.pixels_per_metre);
  const double scale = layout.exaggeration * layout.pixels_per_metre;
  const double error = round_length_down(140 / scale);
  const double y = layout.drawing_height - 14;
  line(svg, 20, y, 20 + metres * layout.pixels_per_metre, y, "axis");
  label(svg, 28 + metres * layout.pixels_per_metre, y + 4, fixed(metres, metres < 1 ? 1 : 0) + "\u00A0m", "small",
        "start");
  if (!layout.ellipses) return;
  line(svg, 320, y, 320 + error * scale, y, "bar");
  label(svg, 328 + error * scale, y + 4, tolerance(error) + " for ellipses (×" + fixed(layout.exaggeration, 0) + ")",
        "small", "start");
}

/// One label for points that stand on the same place of the drawing, such as a vertical column in the plan.
void write_labels(Markup& svg, const Layout& layout, LabelPlacer& labels) {
  std::vector<bool> done(layout.spots.size(), false);
  for (std::size_t i = 0; i < layout.spots.size(); ++i) {
    if (done[i]) continue;
    int others = 0;
    for (std::size_t j = i + 1; j < layout.spots.size(); ++j) {
      if ((layout.spots[j].at - layout.spots[i].at).norm() * layout.pixels_per_metre > 4) continue;
      done[j] = true;
      ++others;
    }
    const std::string more = others > 0 ? " +" + std::to_string(others) : "";
    const Eigen::Vector2d& at = layout.spots[i].at;
    labels.place(svg, layout.x(at.x()), layout.y(at.y()), 12, layout.spots[i].point->id + more, "halo");
  }
}

void draw(Markup& html, const NetworkPage& network, const Projection& projection) {
  const Layout view = layout(network, projection);
  if (view.spots.empty()) return;
  Scope figure(html, "figure");
  {
    Scope svg =
        drawing(html, width, view.drawing_height, projection.name + " of " + network.shown + " with error ellipses");
    draw_sights(html, network, view);
    for (const Spot& s : view.spots) draw_point(html, view, s);
    draw_scales(html, view);
    LabelPlacer labels({4, 4, width - 4, view.drawing_height - 26}, 12);
    for (const Spot& s : view.spots) {
      const double x = view.x(s.at.x()), y = view.y(s.at.y());
      labels.block({x - 8, y - 8, x + 8, y + 8});
    }
    write_labels(html, view, labels);
  }
  const bool stations =
      std::any_of(network.points.begin(), network.points.end(), [](const auto& p) { return p.station; });
  const bool markers =
      std::any_of(network.points.begin(), network.points.end(), [](const auto& p) { return !p.station; });
  const bool datum = std::any_of(network.points.begin(), network.points.end(), [](const auto& p) { return p.datum; });
  const bool hidden = std::any_of(view.spots.begin(), view.spots.end(), [&](const Spot& s) {
    return s.point->station && view.exaggeration * view.pixels_per_metre * s.semi_axes[0] >= largest_station_ellipse;
  });
  const bool crowded = std::any_of(view.spots.begin(), view.spots.end(), [&](const Spot& a) {
    return std::any_of(view.spots.begin(), view.spots.end(),
                       [&](const Spot& b) { return &a != &b && (a.at - b.at).norm() * view.pixels_per_metre <= 4; });
  });
  html.element(
      "figcaption",
      projection.name + ": " + projection.horizontal + " to the right, " + projection.vertical + " up." +
          (view.ellipses ? " Ellipses: " + network.ellipses + ", drawn ×" + fixed(view.exaggeration, 0) + "." : "") +
          (stations ? " Triangles: instrument; dots: markers." : "") +
          (std::any_of(network.observations.begin(), network.observations.end(),
                       [](const auto& o) { return o.flagged || o.removed; })
               ? " Thick red: sights with a suspect or removed reading."
               : "") +
          (view.rings ? " Rings: " + network.rings + "."
           : datum    ? std::string(markers ? " All markers are " : " All are ") + network.rings + "."
                      : "") +
          (view.hidden > 0 ? " " + std::to_string(view.hidden) +
                                 " further points are not drawn: one stands for those beside it, the one that is known "
                                 "worst. Sights are drawn where a reading is suspect or removed only."
                           : "") +
          (hidden ? " Ellipses of instruments that are too large to draw are left out." : "") +
          (crowded ? " “A1 +9” stands for A1 and nine more points at the same place; labels that would "
                     "overlap are left out."
                   : ""));
}

}  // namespace

void write_network_drawings(Markup& html, const NetworkPage& network) {
  // The elevation looks along the horizontal axis with the smaller extent of the markers; the reference points of the
  // datum stand around the building and would turn the view.
  const auto is_marker = [](const NetworkPage::Point& p) { return !p.station && !p.datum; };
  const auto is_sighted = [](const NetworkPage::Point& p) { return !p.station; };
  const bool markers = std::count_if(network.points.begin(), network.points.end(), is_marker) > 2;
  const bool sighted = std::any_of(network.points.begin(), network.points.end(), is_sighted);
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = -low;
  for (const auto& p : network.points)
    if (p.position.allFinite() && (markers ? is_marker(p) : !sighted || is_sighted(p)))
      low = low.cwiseMin(p.position), high = high.cwiseMax(p.position);
  const bool along_x = high.x() - low.x() >= high.y() - low.y();
  Projection plan{"Plan", "x (east)", "y (north)", {}};
  plan.axes << 1, 0, 0, 0, 1, 0;
  Projection elevation{"Elevation", along_x ? "x (east)" : "y (north)", "height", {}};
  elevation.axes << (along_x ? 1 : 0), (along_x ? 0 : 1), 0, 0, 0, 1;
  draw(html, network, plan);
  draw(html, network, elevation);
}

}  // namespace plumbline::report

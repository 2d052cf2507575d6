// Elevation of the facade: every anchor at its place, its verdict as shape and colour, its deviation as an exaggerated
// arrow.
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "building/ifc/facade_frame.hpp"
#include "show/report/anchor_names.hpp"
#include "show/report/format.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// An anchor in the plane of the facade.
struct Spot {
  std::string id;
  int floor = 0;
  bool control = false;
  Eigen::Vector3d position = Eigen::Vector3d::Zero(), difference = Eigen::Vector3d::Zero();  ///< [m]; nan: not measured
  double number = 0;                                                                         ///< beside the name [m]
  ToleranceVerdict verdict = ToleranceVerdict::not_measured;
  std::string facade;            ///< empty: none that is known
  double along = 0, height = 0;  ///< [m]
};

/// A panel as a quadrangle.
struct Quad {
  std::string name;
  ToleranceVerdict verdict;
  std::vector<Eigen::Vector3d> corners;  ///< bottom left, bottom right, top right, top left
};

/// How one stands before a facade: to the right and up; where it bends it is unrolled.
struct Sight {
  Eigen::Vector3d right = Eigen::Vector3d::Zero(), up = Eigen::Vector3d::UnitZ();  ///< zero: as the anchors spread
  std::vector<std::pair<double, double>> unrolled;                                 ///< along `right`, and unrolled [m]

  double along(const Eigen::Vector3d& p) const {
    const double s = right.dot(p);
    if (unrolled.size() < 2) return s;
    std::size_t i = 1;
    while (i + 1 < unrolled.size() && unrolled[i].first < s) ++i;
    const auto& [from, length] = unrolled[i - 1];
    const auto& [to, end] = unrolled[i];
    return length + (end - length) / (to - from) * (s - from);
  }
};

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

enum class Behind { nothing, picture, heat };

/// What one drawing shows.
struct View {
  std::string question;
  std::string name;    ///< "model minus survey"
  std::string number;  ///< what stands beside the names
  std::vector<Spot> spots;
  std::vector<Quad> panels;
  Sight sight;
  Behind behind = Behind::nothing;
};

struct Elevation {
  std::vector<Spot> spots;
  Sight sight;
  Scale x, y;                    ///< [m] to px
  double width = 0, height = 0;  ///< of the drawing [px]
  double pixels_per_metre = 1;
  double exaggeration = 1;
  std::map<int, std::string> prefixes;  ///< of names, left out in the drawing

  Eigen::Vector2d drawn(const Eigen::Vector3d& point) const { return {x(sight.along(point)), y(sight.up.dot(point))}; }
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

Elevation layout(const AccuracyT& accuracy, const View& view) {
  Elevation e;
  for (const Spot& spot : view.spots)
    if (spot.position.allFinite()) e.spots.push_back(spot);
  if (e.spots.empty()) return e;
  e.sight = view.sight;
  if (e.sight.right.isZero()) e.sight.right = facade_direction(e.spots);
  e.prefixes = common_prefixes(accuracy);
  double left = 1e300, right = -1e300, low = 1e300, high = -1e300, largest = 0;
  const auto reach = [&](const Eigen::Vector3d& p) {
    left = std::min(left, e.sight.along(p)), right = std::max(right, e.sight.along(p));
    low = std::min(low, e.sight.up.dot(p)), high = std::max(high, e.sight.up.dot(p));
  };
  for (Spot& spot : e.spots) {
    spot.along = e.sight.along(spot.position), spot.height = e.sight.up.dot(spot.position);
    reach(spot.position);
    if (spot.difference.allFinite())
      largest = std::max(largest, std::hypot(e.sight.right.dot(spot.difference), e.sight.up.dot(spot.difference)));
  }
  for (const Quad& quad : view.panels)
    for (const Eigen::Vector3d& corner : quad.corners) reach(corner);
  const double span_x = std::max(right - left, 1.0), span_y = std::max(high - low, 1.0);
  // As wide as the names need: some 110 px from anchor to anchor, within what a page can show.
  const double margin_left = 72, margin_right = 150, margin = 70, spacing = smallest_spacing(e.spots);
  e.width = std::clamp(margin_left + margin_right + 110 * span_x / spacing, 1040.0, 2400.0);
  e.pixels_per_metre =
      std::min((e.width - margin_left - margin_right) / span_x, std::max(900.0, 60 * span_y / spacing) / span_y);
  const double used = e.pixels_per_metre * span_x;
  const double start = margin_left + 0.5 * (e.width - margin_left - margin_right - used);
  e.height = e.pixels_per_metre * span_y + 2 * margin;
  e.x = {left, left + span_x, start, start + used};
  e.y = {low, low + span_y, e.height - margin, margin};
  // No arrow longer than nine tenths of the way to the next anchor, nor than the margins are wide.
  const double longest = std::min(0.9 * spacing, 60 / e.pixels_per_metre);
  // Nor is less than a tenth of a millimetre, which nobody measures, drawn as long as what matters.
  e.exaggeration = round_down(longest / std::max(largest, 1e-4));
  return e;
}

void draw_panels(Markup& svg, const Elevation& e, const View& view) {
  for (const Quad& quad : view.panels) {
    std::string points;
    for (const Eigen::Vector3d& corner : quad.corners) {
      const Eigen::Vector2d at = e.drawn(corner);
      points += (points.empty() ? "" : " ") + px(at.x()) + "," + px(at.y());
    }
    svg.empty("polygon", {{"class", std::string("quad ") + verdict_class(quad.verdict)}, {"points", points}});
  }
}

/// Names of panels where their anchors leave room, with the sign of the verdict: the middle often holds a check anchor.
void name_panels(Markup& svg, const Elevation& e, const View& view, LabelPlacer& labels) {
  for (const Quad& quad : view.panels) {
    const char* sign = quad.verdict == ToleranceVerdict::pass        ? "● "
                       : quad.verdict == ToleranceVerdict::undecided ? "▲ "
                       : quad.verdict == ToleranceVerdict::fail      ? "■ "
                                                                     : "✕ ";
    const auto at = [&](double across, double up) {
      const Eigen::Vector3d low = quad.corners[0] + across * (quad.corners[1] - quad.corners[0]);
      const Eigen::Vector3d high = quad.corners[3] + across * (quad.corners[2] - quad.corners[3]);
      return e.drawn(low + up * (high - low));
    };
    bool placed = false;
    for (const double up : {0.9, 0.1, 0.7, 0.3, 0.6, 0.4, 0.5})
      for (const double across : {0.5, 0.3, 0.7}) {
        const Eigen::Vector2d p = at(across, up);
        placed = placed || labels.place_at(svg, p.x(), p.y(), "middle", sign + quad.name, "small halo");
      }
    if (placed) continue;
    const Eigen::Vector2d p = at(0.5, 0.9);
    label(svg, p.x(), p.y(), sign + quad.name, "small halo", "middle");
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

/// A round deviation [m] whose arrow is 20 to 50 px long.
double scale_deviation(const Elevation& e) { return round_down(50 / (e.exaggeration * e.pixels_per_metre)); }

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

/// True if something stands behind the anchors.
bool draw_elevation(Markup& html, const Elevation& e, const View& view, const ReportInput& input) {
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
    if (labels.place(html, x, y, 13, name + value, "halo mark")) continue;
    // A name that finds no free place stands over something else: covered is better than lost.
    if (!labels.place(html, x, y, 13, name, "halo mark"))
      label(html, x + 9, y + 4, name + value, "halo small", "start");
  }
  name_panels(html, e, view, labels);
  return behind;
}

/// What stands behind the anchors, in words.
std::string words_of_behind(Behind behind) {
  return behind == Behind::heat
             ? " Colours: the panels' measured surfaces out of the design (red) or behind it (blue), "
               "grey where nothing was measured."
             : " Behind them the facade without perspective; what no photograph shows, or photographs "
               "show differently, is black.";
}

/// Verdicts in the order of drawing: what is to be mended lies above what is in order.
constexpr ToleranceVerdict kDrawn[] = {ToleranceVerdict::pass, ToleranceVerdict::not_measured,
                                       ToleranceVerdict::undecided, ToleranceVerdict::fail};

std::string move_to(double x, double y) { return "M" + px(x) + " " + px(y); }

/// Thousands of anchors and panels as one shape for each verdict, without names: the tables and the view in space have
/// these.
/// True if something stands behind them.
bool draw_many(Markup& html, const Elevation& e, const View& view, const ReportInput& input) {
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

void write_elevation(Markup& html, const ReportInput& input, const View& view, bool many) {
  const Elevation e = layout(input.accuracy, view);
  if (e.spots.empty()) return;
  Scope figure(html, "figure");
  html.element("h3", view.question);
  const bool behind = many ? draw_many(html, e, view, input) : draw_elevation(html, e, view, input);
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

View model_view(const AccuracyT& accuracy) {
  View view{"Is the model right?", "model minus survey", "height deviation", {}, {}, {}};
  for (const auto& a : accuracy.anchors) {
    Spot spot;
    spot.id = a->id, spot.floor = a->floor, spot.control = a->use == AnchorUse::control;
    spot.position = {a->x, a->y, a->z};
    spot.difference.setConstant(std::nan("")), spot.number = std::nan("");
    if (const auto* d = a->survey.get())
      spot.difference = {d->dx, d->dy, d->dz}, spot.number = d->dz, spot.verdict = d->verdict;
    view.spots.push_back(std::move(spot));
  }
  return view;
}

/// Before a facade; unrolled where it bends by more than 5°.
Sight sight_of(const FacadeT& facade, const DeviationT& deviation) {
  Sight sight;
  const ifc::FacadeFrame frame = ifc::frame_facing(facade.out, ifc::FacadeSource::none, false);
  sight.right = frame.right, sight.up = frame.up;
  if (facade.bend < 0.087) return sight;
  std::vector<Eigen::Vector3d> places;
  for (const auto& anchor : deviation.anchors)
    if (anchor->facade && anchor->facade->facade == facade.name && anchor->design.allFinite())
      places.push_back(anchor->design);
  std::sort(places.begin(), places.end(),
            [&](const auto& a, const auto& b) { return sight.right.dot(a) < sight.right.dot(b); });
  for (const Eigen::Vector3d& place : places) {
    const double s = sight.right.dot(place);
    if (sight.unrolled.empty()) {
      sight.unrolled.emplace_back(s, s);
    } else if (s > sight.unrolled.back().first + 0.3) {
      const Eigen::Vector3d before = *std::find_if(places.begin(), places.end(), [&](const auto& p) {
        return sight.right.dot(p) >= sight.unrolled.back().first - 1e-9;
      });
      sight.unrolled.emplace_back(s, sight.unrolled.back().second + (place - before).head<2>().norm());
    }
  }
  return sight;
}

/// As-built minus design of a facade with its panels; out of its plane (the arrows then stand for that, outward drawn
/// upward), or in it. `facade` null: of the anchors that belong to none.
/// `floor`: of that floor alone.
View built_view(const DeviationT& deviation, const FacadeT* facade, bool out_of_plane,
                std::optional<int> floor = std::nullopt) {
  View view{
      out_of_plane ? "How far out of the facade's plane?" : "Are the anchors in place?",
      out_of_plane ? "as-built minus design out of the facade's plane, upward is outward" : "as-built minus design",
      out_of_plane ? "out of plane, outward positive," : "height deviation",
      {},
      {},
      {}};
  if (facade) {
    view.sight = sight_of(*facade, deviation);
    view.question =
        "Facade " + facade->name + ": " + (out_of_plane ? "how far out of its plane?" : "are the anchors in place?");
    if (out_of_plane && !facade->confirmed)
      view.name = "as-built minus design across the facade; which way is outward is not confirmed",
      view.number = "across the facade, without a sign,";
  }
  const std::string name = facade ? facade->name : "";
  const auto belongs = [&](const std::unique_ptr<FacadeFrameT>& frame) {
    return (frame ? frame->facade : std::string()) == name;
  };
  for (const auto& a : deviation.anchors) {
    if (!belongs(a->facade) || (floor && a->floor != *floor)) continue;
    Spot spot;
    spot.id = a->id, spot.floor = a->floor, spot.position = a->design, spot.difference = a->deviation;
    spot.number = a->deviation.z(), spot.verdict = a->verdict, spot.control = a->use == "control";
    if (out_of_plane && facade) {
      spot.number = a->deviation.dot(a->facade->out);
      spot.difference = spot.number * view.sight.up;
      if (!facade->confirmed) spot.number = std::abs(spot.number);
    }
    view.spots.push_back(std::move(spot));
  }
  for (const auto& panel : deviation.panels) {
    if (!belongs(panel->facade) || panel->corners.size() < 4 || (floor && panel->floor != *floor)) continue;
    Quad quad{panel->name, panel->verdict, std::vector<Eigen::Vector3d>(4, Eigen::Vector3d::Zero())};
    const char* order[] = {"bottom_left", "bottom_right", "top_right", "top_left"};
    for (const auto& corner : panel->corners)
      for (std::size_t i = 0; i < 4; ++i)
        if (corner->name == order[i]) quad.corners[i] = corner->design;
    view.panels.push_back(std::move(quad));
  }
  view.behind = out_of_plane ? Behind::heat : Behind::picture;
  return view;
}

/// The same spots by facade, for the comparison with the survey.
View only(const View& all, const FacadeT& facade, const DeviationT& deviation) {
  std::map<std::string, std::string> facade_of;
  for (const auto& a : deviation.anchors)
    if (a->facade) facade_of[a->id] = a->facade->facade;
  View view = all;
  view.sight = sight_of(facade, deviation), view.question = "Facade " + facade.name + ": is the model right?";
  std::erase_if(view.spots, [&](const Spot& spot) {
    const auto found = facade_of.find(spot.id);
    return found == facade_of.end() || found->second != facade.name;
  });
  return view;
}

}  // namespace

void write_floor_elevation(Markup& html, const ReportInput& input, const FacadeT* facade, int floor) {
  View view = built_view(*input.deviation, facade, false, floor);
  view.question = "Are the anchors in place?";
  write_elevation(html, input, view, false);
}

void write_facade(Markup& html, const ReportInput& input) {
  Scope part(html, "section", {{"id", "facade"}});
  html.element("h2", "Facade");
  write_legend(html);
  Scope views(html, "div", {{"class", "views"}});
  const View model = model_view(input.accuracy);
  if (!input.deviation || input.deviation->facades.empty()) {
    const bool of_many = input.deviation && many(*input.deviation);
    if (input.deviation) write_elevation(html, input, built_view(*input.deviation, nullptr, false), of_many);
    return write_elevation(html, input, model, of_many);
  }
  const DeviationT& deviation = *input.deviation;
  const bool of_many = many(deviation);
  for (const auto& facade : deviation.facades) {
    write_elevation(html, input, built_view(deviation, facade.get(), false), of_many);
    write_elevation(html, input, built_view(deviation, facade.get(), true), of_many);
    write_elevation(html, input, only(model, *facade, deviation), of_many);
  }
  write_elevation(html, input, built_view(deviation, nullptr, false), of_many);
}

}  // namespace plumbline::report

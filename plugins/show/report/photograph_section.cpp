// The photographs of the anchors that are not in order.
#include <algorithm>

#include "base/text/words.hpp"
#include "show/report/facade_backdrop.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {
namespace {

/// Edge of a drawing [px].
constexpr double kEdge = 240;

std::string points_of(const std::vector<Eigen::Vector2d>& places, double scale) {
  std::string text;
  for (const Eigen::Vector2d& at : places)
    text += (text.empty() ? "" : " ") + px(scale * at.x()) + "," + px(scale * at.y());
  return text;
}

void draw_cross(Markup& svg, const Eigen::Vector2d& at) {
  for (const auto& [colour, width] : {std::pair("#fff", "4"), {"#0072b2", "2"}})
    for (const bool level : {true, false}) {
      const Eigen::Vector2d arm = level ? Eigen::Vector2d(9, 0) : Eigen::Vector2d(0, 9);
      svg.empty("line", {{"x1", px(at.x() - arm.x())},
                         {"y1", px(at.y() - arm.y())},
                         {"x2", px(at.x() + arm.x())},
                         {"y2", px(at.y() + arm.y())},
                         {"stroke", colour},
                         {"stroke-width", width}});
    }
}

void draw_ring(Markup& svg, const Eigen::Vector2d& at) {
  for (const auto& [colour, width] : {std::pair("#fff", "4"), {"#d55e00", "2"}})
    svg.empty("circle", {{"cx", px(at.x())},
                         {"cy", px(at.y())},
                         {"r", "6"},
                         {"fill", "none"},
                         {"stroke", colour},
                         {"stroke-width", width}});
}

void draw_part(Markup& html, const AnchorPhotograph& part) {
  Scope figure(html, "figure", {{"class", "crop"}});
  {
    const double scale = kEdge / std::max(part.width, part.height);
    const Scope svg = drawing(html, scale * part.width, scale * part.height,
                              "Anchor " + verbatim(part.anchor) + " in " + verbatim(part.photograph));
    draw_jpeg(html, part.jpeg, 0, 0, scale * part.width, scale * part.height);
    html.empty(
        "polygon",
        {{"points", points_of(part.outline, scale)}, {"fill", "none"}, {"stroke", "#009e73"}, {"stroke-width", "2"}});
    if (part.as_built) draw_ring(html, scale * *part.as_built);
    if (part.design) draw_cross(html, scale * *part.design);
  }
  Scope caption(html, "figcaption");
  html.element("strong", verbatim(part.anchor));
  html.text(" ");
  verdict_badge(html, part.verdict);
  html.text(verbatim(" " + part.photograph + ", " + part.tag));
}

}  // namespace

void write_photographs(Markup& html, const AnchorPhotographs& photographs) {
  if (photographs.parts.empty() && photographs.not_shown.empty() && photographs.not_read.empty() &&
      photographs.not_cut.empty())
    return;
  Scope section(html, "section", {{"id", "photographs"}});
  html.element("h2", "Photographs of what is not in order");
  const bool projected = std::any_of(photographs.parts.begin(), photographs.parts.end(),
                                     [](const AnchorPhotograph& part) { return part.design.has_value(); });
  const std::string shown =
      "The photographs in which the marker of a failing or undecided anchor is largest, the worst anchor first. ";
  if (projected)
    html.element("p",
                 shown +
                     "Green: the marker as it was detected; orange ring: where its point was measured; blue cross: "
                     "where the design has it.");
  else if (!photographs.parts.empty())
    html.element("p",
                 shown +
                     "Green: the marker as it was detected. The poses of the photographs are in another frame than "
                     "the design: where the design has the point is not drawn.");
  {
    Scope grid(html, "div", {{"class", "crops"}});
    for (const AnchorPhotograph& part : photographs.parts) draw_part(html, part);
  }
  if (photographs.left_out > 0)
    html.element("p", "The photographs of " + count(static_cast<long>(photographs.left_out), "anchor", "anchors") +
                          " more are left out of this page.");
  if (!photographs.not_shown.empty())
    html.element("p", "No photograph at hand shows the marker of " + text::join(photographs.not_shown, 12) + ".");
  for (const auto& [path, reason] : photographs.not_read)
    html.element("p", verbatim(path) + " cannot be shown: " + verbatim(reason));
  if (!photographs.not_cut.empty()) {
    html.element("p", "Of these no part of a photograph could be cut out:");
    Scope list(html, "ul");
    for (const auto& [anchor, reason] : photographs.not_cut)
      html.element("li", "Anchor " + verbatim(anchor) + ": " + reason);
  }
}

}  // namespace plumbline::report

#include "show/report/surface_page.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>

#include "show/report/facade_backdrop.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/markup.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {
namespace {

constexpr double kDrawingWidth = 960, kPad = 12;  // [px]

/// Panels that lie in one plane, and what of them is drawn where.
struct ElevationOfSurfaces {
  std::vector<size_t> panels;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero(), right = origin, up = origin, out = origin;
  double low_u = 1e300, high_u = -1e300, low_v = 1e300, high_v = -1e300, scale = 1;
  double x(double u) const { return kPad + (u - low_u) * scale; }
  double y(double v) const { return kPad + (high_v - v) * scale; }
  double height() const { return 2 * kPad + (high_v - low_v) * scale; }
};

std::vector<ElevationOfSurfaces> surface_elevations(const SurfacesT& surfaces) {
  std::vector<ElevationOfSurfaces> all;
  for (size_t p = 0; p < surfaces.panels.size(); ++p) {
    const SurfaceFaceT& face = *surfaces.panels[p]->face;
    auto found = std::find_if(all.begin(), all.end(), [&](const ElevationOfSurfaces& one) {
      return one.out.dot(face.out) > 0.98 && std::abs(one.out.dot(face.origin - one.origin)) < 0.5;
    });
    if (found == all.end()) {
      all.push_back({});
      found = all.end() - 1;
      found->origin = face.origin, found->right = face.right, found->up = face.up, found->out = face.out;
    }
    found->panels.push_back(p);
    const double u = found->right.dot(face.origin - found->origin), v = found->up.dot(face.origin - found->origin);
    found->low_u = std::min(found->low_u, u - 0.5 * face.width),
    found->high_u = std::max(found->high_u, u + 0.5 * face.width);
    found->low_v = std::min(found->low_v, v - 0.5 * face.height),
    found->high_v = std::max(found->high_v, v + 0.5 * face.height);
  }
  for (auto& one : all)
    one.scale = std::min((kDrawingWidth - 2 * kPad) / std::max(1e-3, one.high_u - one.low_u),
                         1500 / std::max(1e-3, one.high_v - one.low_v));
  return all;
}

void draw_panel(Markup& svg, const ElevationOfSurfaces& at, const PanelSurfaceFiguresT& panel, double range) {
  const SurfaceFaceT& face = *panel.face;
  const double u = at.right.dot(face.origin - at.origin), v = at.up.dot(face.origin - at.origin);
  const double left = at.x(u - 0.5 * face.width), top = at.y(v + 0.5 * face.height);
  const double width = face.width * at.scale, height = face.height * at.scale;
  const bool measured = is_measured(panel);
  if (measured)
    for (int r = 0; r < kHeatCells; ++r)
      for (int c = 0; c < kHeatCells; ++c)
        svg.empty(
            "rect",
            {{"x", px(left + c * width / kHeatCells)},
             {"y", px(top + r * height / kHeatCells)},
             {"width", px(width / kHeatCells + 0.3)},
             {"height", px(height / kHeatCells + 0.3)},
             {"fill", heat_colour(surface_height(panel, (c + 0.5) * 2 / kHeatCells - 1, 1 - (r + 0.5) * 2 / kHeatCells),
                                  range)}});
  {
    Scope outline(svg, "rect",
                  {{"x", px(left)},
                   {"y", px(top)},
                   {"width", px(width)},
                   {"height", px(height)},
                   {"fill", measured ? "none" : "#cfcfcf"},
                   {"stroke", "#444"},
                   {"stroke-width", "1"}});
    svg.element("title", face.id + (measured ? ": " + signed_mm(panel.offset, 2) + " mm out of the design at its middle"
                                             : ": not measured, " + panel.not_measured));
  }
  if (width < 40 || height < 24) return;
  const auto words = [&](double down, const std::string& text, const char* size) {
    svg.element("text",
                {{"x", px(left + 0.5 * width)},
                 {"y", px(top + 0.5 * height + down)},
                 {"text-anchor", "middle"},
                 {"font-size", size},
                 {"fill", "#111"}},
                text);
  };
  words(-3, verbatim(face.id.substr(0, static_cast<size_t>(width / 7))), "12");
  words(11, measured ? signed_mm(panel.offset, 1) + " mm" : "not measured", "11");
}

void write_pictures(Markup& html, const std::vector<FacadePicture>& pictures) {
  for (const FacadePicture& picture : pictures) {
    const double width = picture.high_u - picture.low_u, height = picture.high_v - picture.low_v;
    const double scale = std::min(kDrawingWidth / std::max(1e-3, width), 1500 / std::max(1e-3, height));
    Scope figure(html, "figure");
    {
      const Scope svg = drawing(html, width * scale, height * scale, "The facade without perspective");
      draw_jpeg(html, picture.jpeg, 0, 0, width * scale, height * scale);
    }
    html.element("figcaption", "The facade without perspective, " + fixed(width, 2) + " m x " + fixed(height, 2) +
                                   " m. Black: no photograph shows it, or photographs show different things there.");
  }
}

void write_joint_row(Markup& html, const JointFiguresT& joint, bool with_reason) {
  const auto place = [&](int index) {
    return index >= 0 && static_cast<size_t>(index) < joint.places.size() ? joint.places[index].get() : nullptr;
  };
  const auto where = [&](const JointPlaceT* at) { return at ? signed_fixed(at->along, 2) : std::string(unknown); };
  const JointPlaceT *narrow = place(joint.narrowest), *wide = place(joint.widest), *step = place(joint.largest_step),
                    *shift = place(joint.largest_shift);
  if (step && !std::isfinite(step->step)) step = nullptr;  // one of the panels was not measured
  if (shift && !std::isfinite(shift->shift)) shift = nullptr;
  Scope row(html, "tr");
  html.element("th", {{"scope", "row"}}, verbatim(joint.first + " | " + joint.second));
  html.element("td", {{"class", "text"}}, joint.upright ? "up" : "across");
  html.element("td", mm(joint.nominal_width, 1));
  for (const JointPlaceT* at : {narrow, wide}) {
    html.element("td", at ? mm(at->width) + " ± " + mm(at->width_sigma) : std::string(unknown));
    html.element("td", where(at));
  }
  html.element("td", step ? mm_with_u(step->step, step->step_sigma) : std::string(unknown));
  html.element("td", where(step));
  html.element("td", shift ? mm_with_u(shift->shift, shift->shift_sigma) : std::string(unknown));
  html.element("td", where(shift));
  html.element("td", std::to_string(joint.places.size()) + " of " + std::to_string(joint.looked_at));
  if (with_reason) html.element("td", {{"class", "words"}}, joint.not_measured);
}

void write_joints(Markup& html, const SurfacesT& surfaces) {
  if (surfaces.joints.empty()) return;
  html.element("h2", "Joints");
  html.element(
      "p", {{"class", "note"}},
      "Widths and steps with their standard uncertainties in mm; 'at' is the way from the joint's middle in m, upwards "
      "or to the right. A step is positive where the second panel stands further out, a shift where the whole joint "
      "lies "
      "further to the right or up than in the design.");
  html.element("p", {{"class", "note"}}, kTemperature);
  if (!surfaces.joints_measured.empty()) html.element("p", {{"class", "note"}}, surfaces.joints_measured);
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  const bool with_reason = std::any_of(surfaces.joints.begin(), surfaces.joints.end(),
                                       [](const auto& joint) { return !joint->not_measured.empty(); });
  auto head = std::vector<Cell>{"Joint", left("Runs"),   "Design", "Narrowest",     "at", "Widest",
                                "at",    "Largest step", "at",     "Largest shift", "at", "Places"};
  if (with_reason) head.push_back(left("Why it is not measured"));
  table_head(html, head);
  Scope body(html, "tbody");
  for (const auto& joint : surfaces.joints) write_joint_row(html, *joint, with_reason);
}

/// What to know before any figure is believed.
void write_what_is_open(Markup& html, const SurfacesT& surfaces) {
  if (surfaces.warnings.empty() && surfaces.place_doubt.empty()) return;
  Scope box(html, "div", {{"class", "warnings"}});
  html.element("h2", "Before you rely on this");
  Scope list(html, "ul");
  if (!surfaces.place_doubt.empty()) html.element("li", surfaces.place_doubt);
  for (const std::string& warning : surfaces.warnings) html.element("li", warning);
}

}  // namespace

std::string render_surface_page(const SurfacesT& surfaces, const SurfaceJudgementT* judgement, const std::string& title,
                                const std::vector<FacadePicture>& pictures) {
  return render_page(title_spoken(title), [&](Markup& html) {
    Scope main(html, "main");
    html.element("h1", title_spoken(title));
    const auto measured = static_cast<long>(std::count_if(surfaces.panels.begin(), surfaces.panels.end(),
                                                          [](const auto& panel) { return is_measured(*panel); }));
    html.element(
        "p", std::to_string(measured) + " of " + count(static_cast<long>(surfaces.panels.size()), "panel", "panels") +
                 " measured; where they stand out of the design (red) or behind it (blue). Grey: not measured.");
    write_what_is_open(html, surfaces);
    const double range = heat_range(surfaces);
    if (measured > 0) draw_heat_bar(html, range);
    for (const ElevationOfSurfaces& at : surface_elevations(surfaces)) {
      const Scope svg = drawing(html, kDrawingWidth, at.height(),
                                "Elevation of " + std::to_string(at.panels.size()) + " panels as seen from outside");
      for (const size_t p : at.panels) draw_panel(html, at, *surfaces.panels[p], range);
    }
    if (judgement) write_surfaces(html, *judgement);  // what fails before what there is
    write_joints(html, surfaces);
    write_pictures(html, pictures);
  });
}

}  // namespace plumbline::report

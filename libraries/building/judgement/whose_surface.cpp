#include "building/judgement/whose_surface.hpp"

#include <fmt/core.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numeric>

namespace plumbline::judgement {
namespace {

/// Of the best plane, the place of the panel that is furthest from the design's face, outward above zero [m].
double furthest_from_design(const PanelSurfaceFiguresT& panel) {
  const double lean =
      std::abs(panel.tilt.x()) * 0.5 * panel.face->width + std::abs(panel.tilt.y()) * 0.5 * panel.face->height;
  return panel.offset < 0 ? panel.offset - lean : panel.offset + lean;
}

std::string doubt_of_place(const PanelSurfaceFiguresT& panel, double within) {
  const double furthest = furthest_from_design(panel);
  if (std::abs(furthest) <= within) return "";
  if (!std::isfinite(furthest)) return "how far it is from the design's face is not known";
  return fmt::format(
      "what was measured lies up to {:.1f} mm {} the design's face, and a panel's surface is taken for it within "
      "{:.1f} "
      "mm ('within' of surface.judge): it may be {}",
      1e3 * std::abs(furthest), furthest > 0 ? "before" : "behind", 1e3 * within,
      furthest > 0 ? "a net, a board or a scaffold before the panel" : "the wall where no panel hangs");
}

double radius_of(const SurfaceFaceT& face) { return 0.5 * std::hypot(face.width, face.height); }

/// Whether two rectangles of the design lie on each other, over half of the smaller one.
bool same_place(const SurfaceFaceT& a, const SurfaceFaceT& b, double within) {
  constexpr double alike = 0.99, share = 0.5;  // cosine of their normals; of the smaller area
  if (std::abs(a.out.dot(b.out)) < alike) return false;
  const Eigen::Vector3d way = b.origin - a.origin;
  if (std::abs(way.dot(a.out)) > within) return false;
  double area = 1;
  for (const auto& [axis, size] : {std::pair(a.right, a.width), std::pair(a.up, a.height)}) {
    const double half = 0.5 * (std::abs(axis.dot(b.right)) * b.width + std::abs(axis.dot(b.up)) * b.height);
    const double middle = way.dot(axis);
    area *= std::max(0.0, std::min(0.5 * size, middle + half) - std::max(-0.5 * size, middle - half));
  }
  return area > share * std::min(a.width * a.height, b.width * b.height);
}

/// Of each panel the first other one at its place; its own number: there is none. Panels are looked at along the x
/// axis, so that those far apart are never compared.
std::vector<size_t> others_at_their_place(const SurfacesT& surfaces, double within) {
  const auto& panels = surfaces.panels;
  std::vector<size_t> other(panels.size()), by_x(panels.size());
  std::iota(other.begin(), other.end(), size_t{0});
  std::iota(by_x.begin(), by_x.end(), size_t{0});
  const auto begins = [&](size_t p) { return panels[p]->face->origin.x() - radius_of(*panels[p]->face); };
  std::sort(by_x.begin(), by_x.end(), [&](size_t a, size_t b) { return begins(a) < begins(b); });
  for (size_t i = 0; i < by_x.size(); ++i) {
    const size_t a = by_x[i];
    const SurfaceFaceT& face = *panels[a]->face;
    const double ends = face.origin.x() + radius_of(face);
    for (size_t k = i + 1; k < by_x.size() && begins(by_x[k]) < ends; ++k) {
      const size_t b = by_x[k];
      if ((other[a] != a && other[b] != b) || !same_place(face, *panels[b]->face, within)) continue;
      if (other[a] == a) other[a] = b;
      if (other[b] == b) other[b] = a;
    }
  }
  return other;
}

}  // namespace

std::vector<std::string> doubts_of_panels(const SurfacesT& surfaces, double within) {
  const std::vector<size_t> other = others_at_their_place(surfaces, within);
  std::vector<std::string> doubts;
  for (size_t p = 0; p < surfaces.panels.size(); ++p) {
    const PanelSurfaceFiguresT& panel = *surfaces.panels[p];
    std::string doubt;
    if (panel.not_measured.empty()) doubt = surfaces.place_doubt;
    if (panel.not_measured.empty() && doubt.empty() && other[p] != p)
      doubt = "the design has " + surfaces.panels[other[p]]->face->id +
              " at the same place: nobody knows which of them was measured; take one of them out of the design, or out "
              "of its panels";
    if (panel.not_measured.empty() && doubt.empty()) doubt = doubt_of_place(panel, within);
    doubts.push_back(std::move(doubt));
  }
  return doubts;
}

}  // namespace plumbline::judgement

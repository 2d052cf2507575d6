#include "surface/dense/scan_strips.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace plumbline::surface {
namespace {

constexpr double kBorder = 0.02, kBin = 0.004;  // [m]
constexpr double kNear = 0.008;                 // what lies further off the surface is not on it [m]
constexpr int kNarrowest = 2, kWidest = 15;     // strips, in bins
constexpr int kMostStrips = 2;                  // in a panel; more are lines of the scanner's

int bins_of(double length) { return std::max(0, static_cast<int>((length - 2 * kBorder) / kBin)); }

/// Middles of runs of empty bins that do not touch the ends.
std::vector<double> strips_of(const std::vector<int>& counts) {
  constexpr double empty = 0.02, least = 20;  // share of the median; points in a bin
  if (counts.size() < 4 * kWidest) return {};
  std::vector<int> sorted = counts;
  std::nth_element(sorted.begin(), sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2), sorted.end());
  const double median = sorted[sorted.size() / 2];
  if (median < least) return {};
  std::vector<double> strips;
  for (size_t from = 0, to = 0; from < counts.size(); from = to) {
    to = from + 1;
    if (counts[from] > empty * median) continue;
    while (to < counts.size() && counts[to] <= empty * median) ++to;
    const int run = static_cast<int>(to - from);
    if (from > 0 && to < counts.size() && run >= kNarrowest && run <= kWidest)
      strips.push_back(kBin * 0.5 * (static_cast<double>(from + to) - static_cast<double>(counts.size())));
  }
  return strips.size() > kMostStrips ? std::vector<double>() : strips;
}

/// Joints of a direction whose panels were measured, and those of them that are closed over most of their length.
struct Closed {
  int looked_at = 0, closed = 0;
  bool most() const { return closed > 0 && 2 * closed >= looked_at; }
};
Closed closed_of(bool upright, const std::vector<Joint>& joints, const std::vector<MeasuredJoint>& found) {
  Closed result;
  for (size_t j = 0; j < joints.size(); ++j) {
    if (joints[j].upright != upright || found[j].stations_looked_at == 0) continue;
    ++result.looked_at;
    result.closed += !found[j].not_measured.empty() && 2 * found[j].closed >= found[j].stations_looked_at;
  }
  return result;
}

/// Where strips of most panels lie, and of how many.
std::pair<double, int> common_strip(const std::vector<EmptyStrips>& panels,
                                    std::vector<double> EmptyStrips::*direction) {
  constexpr double same = 0.01;  // [m]
  std::pair<double, int> best = {0, 0};
  for (const EmptyStrips& panel : panels)
    for (const double at : panel.*direction) {
      const auto count = std::count_if(panels.begin(), panels.end(), [&](const EmptyStrips& other) {
        const std::vector<double>& strips = other.*direction;
        return std::any_of(strips.begin(), strips.end(), [&](double one) { return std::abs(one - at) < same; });
      });
      if (count > best.second) best = {at, static_cast<int>(count)};
    }
  return best;
}

}  // namespace

EmptyStrips empty_strips(const PanelFace& face, const PanelSurface& surface, const std::vector<MeasuredTile>& tiles) {
  EmptyStrips strips;
  if (!surface.not_measured.empty()) return strips;
  std::vector<int> right(bins_of(face.width)), up(bins_of(face.height));
  const double half_width = 0.5 * kBin * static_cast<double>(right.size()),
               half_height = 0.5 * kBin * static_cast<double>(up.size());
  for (const MeasuredTile& tile : tiles)
    for (const MeasuredPoint& point : tile.points) {
      const Eigen::Vector3d local = face.plane.local(tile.at(point));
      if (!(std::abs(local.x()) < half_width) || !(std::abs(local.y()) < half_height)) continue;
      if (std::abs(local.z() - surface.base(local.x(), local.y()).dot(surface.form)) > kNear) continue;
      ++right[std::min(right.size() - 1, static_cast<size_t>((local.x() + half_width) / kBin))];
      ++up[std::min(up.size() - 1, static_cast<size_t>((local.y() + half_height) / kBin))];
    }
  strips.right = strips_of(right), strips.up = strips_of(up);
  return strips;
}

bool closed_joints(const std::vector<Joint>& joints, const std::vector<MeasuredJoint>& found) {
  return closed_of(true, joints, found).most() || closed_of(false, joints, found).most();
}

std::string beside_its_place(const std::vector<EmptyStrips>& strips, const std::vector<Joint>& joints,
                             const std::vector<MeasuredJoint>& found) {
  for (const bool upright : {true, false}) {
    const Closed closed = closed_of(upright, joints, found);
    const auto [at, panels] = common_strip(strips, upright ? &EmptyStrips::right : &EmptyStrips::up);
    if (!closed.most() || panels < 2 || 3 * panels < static_cast<int>(strips.size())) continue;
    const char* const side = upright ? (at > 0 ? "to the right of" : "to the left of") : (at > 0 ? "above" : "below");
    return fmt::format(
        "gaps like joints run through {} of {} panels, {:.2f} m {} their middles, where the design has none, and {} of "
        "{} joints there are closed: what was measured lies beside its place, or the panels are not those of the "
        "design",
        panels, strips.size(), std::abs(at), side, closed.closed, closed.looked_at);
  }
  return {};
}

}  // namespace plumbline::surface

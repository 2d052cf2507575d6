#include "build/loop/panel_order.hpp"

#include <algorithm>
#include <cmath>

namespace plumbline::loop {
namespace {

/// Along right, up and out of the panel that is asked for.
struct Extent {
  std::size_t index = 0;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e300), high = Eigen::Vector3d::Constant(-1e300);
};

Extent extent_of(std::size_t index, const std::vector<Eigen::Vector3d>& points, const Eigen::Matrix3d& axes) {
  Extent extent;
  extent.index = index;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d place = axes.transpose() * point;
    extent.low = extent.low.cwiseMin(place), extent.high = extent.high.cwiseMax(place);
  }
  return extent;
}

bool is_below(const Extent& one, const Extent& other) {
  constexpr double kOverlap = 0.02, kDepth = 0.3;  // [m]
  const double common = std::min(one.high.x(), other.high.x()) - std::max(one.low.x(), other.low.x());
  return other.low.y() - one.high.y() > -kOverlap &&
         common >= 0.5 * std::min(one.high.x() - one.low.x(), other.high.x() - other.low.x()) &&
         std::abs(0.5 * (one.low.z() + one.high.z() - other.low.z() - other.high.z())) < kDepth;
}

}  // namespace

std::vector<std::size_t> next_below(const Panel& panel, const std::vector<PanelPlace>& others) {
  const Extent own = extent_of(0, {panel.corners.begin(), panel.corners.end()}, panel.axes);
  std::vector<Extent> below;
  for (std::size_t i = 0; i < others.size(); ++i) {
    if (others[i].id == panel.id || others[i].points.empty()) continue;
    // Most are far aside, and need no box.
    const Eigen::Vector3d first = panel.axes.transpose() * (others[i].points.front() - panel.corners[0]);
    constexpr double kLargest = 30;  // panel or its box [m]
    if (std::abs(first.x()) > kLargest || std::abs(first.z()) > kLargest || first.y() > kLargest) continue;
    const Extent extent = extent_of(i, others[i].points, panel.axes);
    if (is_below(extent, own)) below.push_back(extent);
  }
  std::vector<std::size_t> next;
  for (const Extent& one : below)
    if (std::none_of(below.begin(), below.end(), [&](const Extent& other) {
          return other.index != one.index && other.high.y() > one.high.y() && is_below(one, other);
        }))
      next.push_back(one.index);
  return next;
}

}  // namespace plumbline::loop

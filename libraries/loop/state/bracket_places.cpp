#include "loop/state/bracket_places.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/median.hpp"
#include "loop/state/date.hpp"

namespace plumbline::loop {
namespace {

Eigen::Vector3d from_axes(const BracketSettingT& bracket, const Eigen::Vector3d& v) {
  return v.x() * bracket.axes[0] + v.y() * bracket.axes[1] + v.z() * bracket.axes[2];
}

}  // namespace

Eigen::Vector3d doubt_of(const BracketSettingT& bracket, double tolerance) {
  const bool is_known = (bracket.difference_sigma.array() > 0).all();
  return (4 * (is_known ? bracket.difference_sigma : Eigen::Vector3d(std::sqrt(2.0) * bracket.sigma)))
      .cwiseMax(tolerance);
}

Eigen::Vector3d along_axes(const BracketSettingT& bracket, const Eigen::Vector3d& v) {
  return {bracket.axes[0].dot(v), bracket.axes[1].dot(v), bracket.axes[2].dot(v)};
}

Eigen::Vector3d place_of(const LoopItemT& item, const BracketSettingT& bracket) {
  const bool asked = item.status == ItemStatus::executed || item.status == ItemStatus::relocalised;
  return asked ? Eigen::Vector3d(item.expected + from_axes(bracket, item.pending)) : item.expected;
}

std::string explanation(const LoopItemT& item, const BracketSettingT& bracket, double most) {
  const Eigen::Vector3d moved = along_axes(bracket, bracket.measured - item.expected);
  const auto is = [&](double times) { return (moved - times * item.pending).cwiseAbs().maxCoeff() <= most; };
  return is(0) ? "it was not moved" : is(-1) ? "it was set the other way" : is(2) ? "it was set twice" : "";
}

bool is_measured_anew(const LoopItemT& item, const BracketSettingT& bracket, const std::string& measured_at) {
  if (bracket.basis.empty() || item.basis.find(bracket.basis) != std::string::npos) return false;
  const bool waits = item.status == ItemStatus::executed || item.status == ItemStatus::relocalised;
  if (!waits || measured_at.empty()) return true;
  const std::optional<double> done = seconds_of(item.at), measured = seconds_of(measured_at);
  return done && measured && *done < *measured;
}

}  // namespace plumbline::loop

#include "building/judgement/mounting.hpp"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "building/ifc/selection_rule.hpp"

namespace plumbline::judgement {
namespace {

constexpr const char* kExample = "class=IfcMechanicalFastener: right=0.3mm, up=0.3mm, out=1mm";

}  // namespace

MountingRule parse_mounting(const std::string& text) {
  auto [selection, lengths, whole] = ifc::parse_lengths(text, kExample);
  MountingRule rule{std::move(selection), Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()),
                    std::move(whole)};
  for (const auto& [axis, length, part] : lengths) {
    const int k = axis == "right" ? 0 : axis == "up" ? 1 : axis == "out" ? 2 : -1;
    if (k < 0 || !(length >= 0 && length <= 0.1))
      throw std::runtime_error("mounting rule '" + text + "': found '" + part +
                               "', expected right, up or out with a standard deviation from 0 to 100 mm, such as '" +
                               kExample + "'");
    rule.sigma[k] = length;
  }
  return rule;
}

Eigen::Matrix3d Mounting::covariance(const ifc::ElementFacts& anchor, const std::vector<double>& of_plate,
                                     const Eigen::Quaterniond& frame_from_plate) const {
  Eigen::Vector3d chosen = Eigen::Vector3d::Constant(sigma);
  if (of_plate.size() == 3) chosen = Eigen::Vector3d(of_plate[0], of_plate[1], of_plate[2]);
  for (const MountingRule& rule : rules)
    if (rule.selection.matches(anchor)) chosen = rule.sigma.array().isNaN().select(chosen, rule.sigma);
  if (chosen.isZero(0)) return Eigen::Matrix3d::Zero();
  const Eigen::Matrix3d turn = frame_from_plate.normalized().toRotationMatrix();
  return turn * chosen.cwiseAbs2().asDiagonal() * turn.transpose();
}

std::set<std::size_t> Mounting::that_hold(const std::vector<std::size_t>& selecting) const {
  std::set<std::size_t> hold;
  for (int axis = 0; axis < 3; ++axis)
    for (auto rule = selecting.rbegin(); rule != selecting.rend(); ++rule)
      if (!std::isnan(rules[*rule].sigma[axis])) {
        hold.insert(*rule);
        break;
      }
  return hold;
}

std::string Mounting::words(std::size_t from_table) const {
  std::string text;
  if (sigma > 0) {
    text = fmt::format("{:.3g} mm on each axis of a plate", 1e3 * sigma);
  }
  const auto add = [&](const std::string& more) { text += (text.empty() ? "" : "; ") + more; };
  if (from_table > 0) add(std::to_string(from_table) + " plates by the plate table");
  for (const MountingRule& rule : rules) add(rule.text);
  return text;
}

}  // namespace plumbline::judgement

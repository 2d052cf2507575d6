#include "loop/fit/bracket_rules.hpp"

#include <algorithm>
#include <stdexcept>

#include "building/ifc/selection_rule.hpp"

namespace plumbline::loop {

BracketRule parse_bracket_rule(const std::string& text) {
  auto [selection, lengths, whole] =
      ifc::parse_lengths(text, "class=IfcMechanicalFastener: right=20mm, up=15mm, out=25mm, step_out=1mm");
  BracketRule rule{std::move(selection), {}};
  rule.type.name = whole;
  for (const auto& [name, length, part] : lengths) {
    if (!(length >= 0 && length <= 0.5))
      throw std::runtime_error("bracket rule '" + text + "': found '" + part +
                               "', expected a length from 0 to 0.5 m with its unit, such as 20mm");
    bool known = false;
    for (int k = 0; k < 3; ++k) {
      const std::string direction = kDirections[k];
      if (name == direction) rule.type.low[k] = -length, rule.type.high[k] = length, known = true;
      if (name == "step_" + direction) rule.type.step[k] = length, known = true;
    }
    if (!known)
      throw std::runtime_error("bracket rule '" + text + "': '" + name +
                               "' is not known; expected right, up, out, step_right, step_up or step_out");
  }
  for (int k = 0; k < 3; ++k)
    if (rule.type.step[k] > std::max(rule.type.high[k], -rule.type.low[k]))
      throw std::runtime_error("bracket rule '" + text + "': its step " + kDirections[k] +
                               " is longer than its range: it could not be set at all");
  return rule;
}

std::optional<BracketType> bracket_type_of(const std::vector<BracketRule>& rules, const ifc::ElementFacts& anchor) {
  for (auto rule = rules.rbegin(); rule != rules.rend(); ++rule)
    if (rule->selection.matches(anchor)) return rule->type;
  BracketType type;
  bool told = false;
  static constexpr const char* kNames[] = {"Right", "Up", "Out"};
  if (anchor.properties)
    for (const ifc::Property& property : *anchor.properties)
      for (int k = 0; k < 3 && property.set == "Pset_BracketRange"; ++k) {
        if (!(property.number >= 0 && property.number <= 0.5)) continue;
        if (property.name == kNames[k]) type.low[k] = -property.number, type.high[k] = property.number, told = true;
        if (property.name == std::string("Step") + kNames[k]) type.step[k] = property.number, told = true;
      }
  if (told) type.name = "design: Pset_BracketRange";
  if (told || rules.empty()) return type;
  return std::nullopt;
}

HookRule parse_hook_rule(const std::string& text) {
  auto [selection, word] = ifc::split_rule(text, "name~-R2$: slides_sideways");
  HookRule rule{std::move(selection), {true, true, true}};
  if (word == "slides_sideways") {
    rule.holds = {false, true, true};
  } else if (word == "slides_up") {
    rule.holds = {true, false, true};
  } else if (word == "slides") {
    rule.holds = {false, false, true};
  } else if (word != "fixed") {
    throw std::runtime_error("hook rule '" + text + "': found '" + word +
                             "', expected fixed, slides_sideways, slides_up or slides");
  }
  return rule;
}

std::array<bool, 3> usual_hook(const std::vector<Eigen::Vector3d>& brackets, std::size_t which,
                               const Eigen::Matrix3d& axes) {
  constexpr double kSameRow = 0.3;  // [m]
  double top = -1e300, left = 1e300;
  for (const Eigen::Vector3d& p : brackets) top = std::max(top, axes.col(1).dot(p));
  for (const Eigen::Vector3d& p : brackets)
    if (axes.col(1).dot(p) > top - kSameRow) left = std::min(left, axes.col(0).dot(p));
  if (axes.col(1).dot(brackets[which]) <= top - kSameRow) return {false, false, true};
  return {axes.col(0).dot(brackets[which]) <= left, true, true};
}

}  // namespace plumbline::loop

#include "loop/fit/bracket_rules.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <stdexcept>

#include "building/ifc/selection_rule.hpp"

namespace plumbline::loop {
namespace {

void check_steps(const BracketType& type, const std::string& where) {
  for (int k = 0; k < 3; ++k)
    if (type.step[k] > std::max(type.high[k], -type.low[k]))
      throw std::runtime_error(where + ": its step " + kDirections[k] +
                               " is longer than its range: it could not be set at all");
}

}  // namespace

BracketRule parse_bracket_rule(const std::string& text) {
  auto [selection, lengths, whole] =
      ifc::parse_lengths(text, "class=IfcMechanicalFastener: right=20mm, up=15mm, out=25mm, step_out=1mm");
  BracketRule rule{std::move(selection), {}, text};
  rule.type.name = whole;
  std::set<std::string> said;
  for (const auto& [name, length, part] : lengths) {
    if (!said.insert(name).second)
      throw std::runtime_error("bracket rule '" + text + "' says '" + name + "' twice: which of them counts?");
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
  check_steps(rule.type, "bracket rule '" + text + "'");
  return rule;
}

namespace {

/// Of the design's Pset_BracketRange. A name or a number that is not understood would leave what is assumed in its
/// place, and a bracket would be planned that cannot be set so.
BracketType type_of_design(const ifc::ElementFacts& anchor, const BracketType& assumed) {
  static const std::map<std::string, std::pair<int, bool>> kKnown = {{"Right", {0, false}}, {"Up", {1, false}},
                                                                     {"Out", {2, false}},   {"StepRight", {0, true}},
                                                                     {"StepUp", {1, true}}, {"StepOut", {2, true}}};
  BracketType type = assumed;
  const std::string where = "Pset_BracketRange of anchor " + (anchor.name.empty() ? anchor.guid : anchor.name);
  for (const ifc::Property& property : *anchor.properties) {
    if (property.set != "Pset_BracketRange") continue;
    const auto known = kKnown.find(property.name);
    if (known == kKnown.end())
      throw std::runtime_error(where + " has '" + property.name +
                               "'; expected Right, Up, Out, StepRight, StepUp or StepOut");
    if (!(property.number >= 0 && property.number <= 0.5))
      throw std::runtime_error(where + ": " + property.name + " is " +
                               (property.text.empty() ? std::to_string(property.number) : property.text) +
                               ", expected a length from 0 to 0.5 m (a length measure of the design counts in the "
                               "design's unit, a plain number in metres)");
    const auto [k, is_step] = known->second;
    type.name = "design: Pset_BracketRange";
    if (is_step)
      type.step[k] = property.number;
    else
      type.low[k] = -property.number, type.high[k] = property.number;
  }
  check_steps(type, where);
  return type;
}

}  // namespace

std::optional<BracketType> bracket_type_of(const std::vector<BracketRule>& rules, const ifc::ElementFacts& anchor) {
  for (auto rule = rules.rbegin(); rule != rules.rend(); ++rule)
    if (rule->selection.matches(anchor)) return rule->type;
  const BracketType assumed;
  const BracketType type = anchor.properties ? type_of_design(anchor, assumed) : assumed;
  if (type.name != assumed.name || rules.empty()) return type;
  return std::nullopt;
}

HookRule parse_hook_rule(const std::string& text) {
  auto [selection, word] = ifc::split_rule(text, "name~-R2$: slides_sideways");
  HookRule rule{std::move(selection), {true, true, true}, text};
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

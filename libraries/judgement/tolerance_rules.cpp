#include "judgement/tolerance_rules.hpp"

#include <cmath>
#include <stdexcept>

#include "ifc/selection_rule.hpp"

namespace plumbline::judgement {
namespace {

Axis axis_of(const std::string& name, const std::string& rule) {
  for (const Axis axis : kAxes)
    if (name == name_of(axis)) return axis;
  throw std::runtime_error("tolerance rule '" + rule + "': the axis '" + name +
                           "' is not known; expected horizontal, vertical, in_plane, out_of_plane, space or joint");
}

}  // namespace

const char* name_of(Axis axis) {
  switch (axis) {
    case Axis::horizontal:
      return "horizontal";
    case Axis::vertical:
      return "vertical";
    case Axis::in_plane:
      return "in_plane";
    case Axis::out_of_plane:
      return "out_of_plane";
    case Axis::space:
      return "space";
    case Axis::joint:
      return "joint";
  }
  return "";
}

ToleranceRule parse_rule(const std::string& text) {
  auto [selection, lengths, whole] = bim::parse_lengths(text, "class=IfcPlate: out_of_plane=3mm, vertical=5mm");
  ToleranceRule rule{std::move(selection), {}, std::move(whole)};
  for (const auto& [axis, length, part] : lengths) {
    if (!(length >= 0 && length <= 1))
      throw std::runtime_error("tolerance rule '" + text + "': found '" + part +
                               "', expected axis=length, a length from 0 to 1 m with its unit, such as 5mm or 0.005m");
    rule.tolerances[axis_of(axis, text)] = length;
  }
  return rule;
}

Tolerances tolerances_of(const ToleranceTable& table, const bim::ElementFacts& element) {
  Tolerances tolerances;
  for (const Axis axis : {Axis::horizontal, Axis::vertical}) tolerances[axis] = {table.tau, "default"};
  tolerances[Axis::joint] = {2 * table.tau, "default: twice the tolerance"};
  if (table.from_design && element.properties) {
    static const std::map<std::string, Axis> names = {{"HorizontalTolerance", Axis::horizontal},
                                                      {"VerticalTolerance", Axis::vertical},
                                                      {"OrthogonalTolerance", Axis::out_of_plane},
                                                      {"OverallTolerance", Axis::space}};
    for (const bim::Property& property : *element.properties) {
      const auto axis = names.find(property.name);
      if (property.set != "Pset_Tolerance" || axis == names.end()) continue;
      if (property.number > 0 && property.number <= 1)
        tolerances[axis->second] = {property.number, "design: Pset_Tolerance." + property.name};
    }
  }
  for (const ToleranceRule& rule : table.rules) {
    if (!rule.selection.matches(element)) continue;
    for (const auto& [axis, value] : rule.tolerances) {
      if (value > 0)
        tolerances[axis] = {value, rule.text};
      else
        tolerances.erase(axis);
    }
  }
  return tolerances;
}

}  // namespace plumbline::judgement

#include "judgement/tolerance_rules.hpp"

#include <charconv>
#include <cmath>
#include <stdexcept>

namespace plumbline::judgement {
namespace {

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
  return first == std::string::npos ? std::string() : text.substr(first, last - first + 1);
}

double length_of(const std::string& text, const std::string& rule) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string unit = trimmed(std::string(end, text.data() + text.size()));
  const double factor = unit == "mm" ? 1e-3 : unit == "m" ? 1 : 0;
  if (error != std::errc() || factor == 0 || !(number * factor >= 0) || number * factor > 1)
    throw std::runtime_error("tolerance rule '" + rule + "': found '" + text +
                             "', expected a length from 0 to 1 m with its unit, such as 5mm or 0.005m");
  return number * factor;
}

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
  // The last colon: names and expressions before it may hold others.
  const std::size_t colon = text.rfind(':');
  if (colon == std::string::npos)
    throw std::runtime_error("tolerance rule '" + text +
                             "': found no ':', expected 'selection: axis=length, …', such as 'class=IfcPlate: "
                             "out_of_plane=3mm'");
  ToleranceRule rule{bim::Selection(text.substr(0, colon)), {}, trimmed(text)};
  std::string rest = text.substr(colon + 1);
  for (bool more = true; more;) {
    const std::size_t comma = rest.find(',');
    const std::string part = trimmed(rest.substr(0, comma));
    more = comma != std::string::npos;
    if (more) rest = rest.substr(comma + 1);
    const std::size_t equals = part.find('=');
    if (equals == std::string::npos)
      throw std::runtime_error("tolerance rule '" + text + "': found '" + part + "', expected axis=length");
    rule.tolerances[axis_of(trimmed(part.substr(0, equals)), text)] = length_of(trimmed(part.substr(equals + 1)), text);
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

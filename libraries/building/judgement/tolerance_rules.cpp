#include "building/judgement/tolerance_rules.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/text/text.hpp"
#include "building/ifc/selection_rule.hpp"
#include "building/ifc/tolerance_source.hpp"
#include "building/judgement/tolerance_request.hpp"

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

bool judged_of_anchors(Axis axis) { return axis != Axis::joint; }
bool judged_of_panels(Axis axis) { return axis != Axis::space; }

namespace {

bool has_sign(Axis axis) { return axis == Axis::vertical || axis == Axis::out_of_plane || axis == Axis::joint; }

/// "+5/-2mm" or "-2/+5mm" [m]; nothing if it is no such thing.
std::optional<Tolerance> two_sides(std::string_view text) {
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos) return {};
  const std::string_view first = text::trim(text.substr(0, slash)), second = text::trim(text.substr(slash + 1));
  double factor = 0;
  const auto number = [&](std::string_view part, bool with_unit) {
    double value = ifc::Property::nan;
    if (part.empty() || (part[0] != '+' && part[0] != '-')) return value;
    const auto [end, error] = std::from_chars(part.data() + 1, part.data() + part.size(), value);
    const std::string_view unit = text::trim(part.substr(static_cast<std::size_t>(end - part.data())));
    if (with_unit) factor = unit == "mm" ? 1e-3 : unit == "m" ? 1 : 0;
    // "+0.5mm/-0.002m" is not read as if both were metres.
    const bool same_unit =
        with_unit || unit.empty() || (unit == "mm" && factor == 1e-3) || (unit == "m" && factor == 1);
    return error == std::errc() && same_unit ? value : ifc::Property::nan;
  };
  const double b = number(second, true), a = number(first, false);
  if (first.empty() || second.empty() || first[0] == second[0] || factor == 0 || !(a >= 0) || !(b >= 0)) return {};
  Tolerance tolerance;
  tolerance.value = factor * (first[0] == '+' ? a : b), tolerance.below = factor * (first[0] == '+' ? b : a);
  return tolerance;
}

/// Drops `what` from the beginning.
bool drop(std::string_view& text, std::string_view what) {
  if (!text.starts_with(what)) return false;
  text = text::trim(text.substr(what.size()));
  return true;
}

/// "10.5", "10,5" or "3/8"; nan for anything else. A comma with three digits behind may be one of thousands.
double number_in_text(std::string_view text) {
  std::string written(text);
  const std::size_t comma = written.find(',');
  if (comma != std::string::npos && (written.size() - comma == 4 || written.find('.') != std::string::npos))
    return ifc::Property::nan;
  if (comma != std::string::npos) written[comma] = '.';
  const auto number = [](std::string_view part) {
    double value = 0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc() && end == part.data() + part.size() ? value : ifc::Property::nan;
  };
  const std::size_t slash = written.find('/');
  if (slash == std::string::npos) return number(written);
  return number(std::string_view(written).substr(0, slash)) / number(std::string_view(written).substr(slash + 1));
}

/// How people write a tolerance into a model: "10 mm", "±10 mm", "+/- 13 mm", "10,5 mm", "1.0 cm", "3/8 in", "0.40\""
/// [m]; nan where it is no length with a unit.
double length_in_text(std::string_view text) {
  static constexpr std::pair<std::string_view, double> units[] = {{"mm", 1e-3},   {"cm", 1e-2},     {"m", 1},
                                                                  {"in", 0.0254}, {"inch", 0.0254}, {"\"", 0.0254}};
  text = text::trim(text);
  if (!drop(text, "±") && !drop(text, "+/-")) drop(text, "+-");
  const std::size_t end = text.find_first_not_of("0123456789.,/");
  if (end == std::string_view::npos || end == 0) return ifc::Property::nan;
  const std::string_view unit = text::trim(text.substr(end));
  for (const auto& [name, factor] : units)
    if (unit == name) return factor * number_in_text(text.substr(0, end));
  return ifc::Property::nan;
}

/// What a property of Pset_Tolerance says: a tolerance, or why it is none.
std::optional<Tolerance> read(const ifc::Property& property, Axis axis, std::string& reason) {
  Tolerance tolerance;
  if (property.measure == "IFCPROPERTYBOUNDEDVALUE") {
    tolerance.value = property.upper, tolerance.below = -property.lower;
    if (std::isnan(property.lower)) tolerance.below = Tolerance{}.below;
    if (std::abs(tolerance.value - tolerance.below) < 1e-12) tolerance.below = Tolerance{}.below;
    if (!(tolerance.value >= 0) || !(tolerance.lower() >= 0))
      reason = "its bounds are no lengths in the unit of the project on both sides of zero";
    if (!std::isnan(tolerance.below) && !has_sign(axis)) reason = "it has two sides, and this length has no sign";
  } else if (property.measure.starts_with("IFCPROPERTY") || property.measure.starts_with("IFCQUANTITY") ||
             property.measure == "IFCCOMPLEXPROPERTY") {
    reason = "it is an " + property.measure + ", expected a length";
  } else if (!std::isnan(property.number) &&
             (property.measure.empty() || property.measure.ends_with("LENGTHMEASURE"))) {
    tolerance.value = property.number;
  } else if (!std::isnan(property.number)) {
    reason = "it is an " + property.measure + ", a number without a unit; expected a length";
  } else {
    const auto sides = two_sides(property.text);
    const double plain = ifc::length_with_unit(property.text),
                 length = std::isfinite(plain) ? plain : length_in_text(property.text);
    if (sides && has_sign(axis))
      tolerance = *sides;
    else if (std::isfinite(length))
      tolerance.value = length;
    else
      reason = "it is a text that is not read as a length with its unit, such as 10 mm";
  }
  if (reason.empty() && !(tolerance.value > 0 || tolerance.lower() > 0)) reason = "it is not above zero";
  if (reason.empty() && !(tolerance.value <= 1 && tolerance.lower() <= 1)) reason = "it is more than a metre";
  if (!reason.empty()) return {};
  return tolerance;
}

/// The set's words about a tolerance, which ask for nothing.
bool is_description(const std::string& name) { return name == "ToleranceDescription" || name == "ToleranceBasis"; }

/// What the design asks for in vain: the property and the reason, with the axis that a rule may give instead.
using Open = std::map<std::pair<std::string, std::string>, Axis>;
/// What of the design is told as well: a property that nothing is taken from, with the axis.
using Told = std::map<std::string, Axis>;

/// A limit of zero on both sides says that the axis is not judged.
bool is_wider(const Tolerance& later, const Tolerance& earlier) {
  if (!(earlier.value > 0 || earlier.lower() > 0)) return false;
  if (!(later.value > 0 || later.lower() > 0)) return true;
  return later.value > earlier.value || later.lower() > earlier.lower();
}

/// The sets about tolerances of one element.
class DesignTolerances {
 public:
  DesignTolerances(const std::vector<ifc::Property>& properties, Tolerances& tolerances, Open& open, Told& wider)
      : tolerances_(tolerances), open_(open), wider_(wider) {
    for (const bool own : {true, false})
      for (const ifc::Property& property : properties)
        if (property.holder.empty() == own && ifc::is_like_tolerance_set(property.set) &&
            !is_description(property.name))
          add(property);
  }

 private:
  void add(const ifc::Property& property) {
    static const std::map<std::string, Axis> names = {{"HorizontalTolerance", Axis::horizontal},
                                                      {"VerticalTolerance", Axis::vertical},
                                                      {"OrthogonalTolerance", Axis::out_of_plane},
                                                      {"OverallTolerance", Axis::space}};
    const auto axis = names.find(property.name);
    if (!ifc::is_tolerance_set(property.set))
      refuse(property, "the set is called '" + property.set + "', expected Pset_Tolerance",
             axis == names.end() ? Axis::joint : axis->second);
    else if (axis == names.end())
      refuse(property, std::string(kNothingMeasuresIt), Axis::joint);  // of no anchor: no rule takes its place
    else if (property.holder.empty())
      take_own(property, axis->second);
    else if (!own_.contains(axis->second))
      take_inherited(property, axis->second);
  }

  void refuse(const ifc::Property& property, const std::string& reason, Axis axis) {
    open_.emplace(std::pair(name_of(property) + (property.text.empty() ? "" : " '" + property.text + "'"), reason),
                  axis);
  }

  void take_own(const ifc::Property& property, Axis axis) {
    std::string reason;
    auto tolerance = read(property, axis, reason);
    if (const auto first = own_.find(axis); first != own_.end()) {
      refuse(property, "another set gives it as '" + first->second + "', and nobody knows which is meant", axis);
      return;
    }
    own_[axis] = property.text;
    if (!tolerance) return refuse(property, reason, axis);
    tolerance->source = "design: " + name_of(property);
    tolerances_[axis] = *tolerance;
  }

  /// It narrows what holds else. That it is meant to allow more than that is not taken from another object's set: the
  /// narrower limit is the safe one. Beside that of a nearer holder a wider one is no question at all.
  void take_inherited(const ifc::Property& property, Axis axis) {
    std::string reason;
    auto tolerance = read(property, axis, reason);
    if (!tolerance) return refuse(property, reason, axis);
    const bool is_nearest = inherited_.insert(axis).second;
    const auto holds = tolerances_.find(axis);
    if (holds != tolerances_.end() && is_wider(*tolerance, holds->second)) {
      if (is_nearest) wider_.emplace(name_of(property), axis);
      return;
    }
    tolerance->source = "design: " + name_of(property);
    tolerances_[axis] = *tolerance;
  }

  static std::string name_of(const ifc::Property& property) {
    return property.set + "." + property.name + (property.holder.empty() ? "" : " of " + property.holder);
  }

  Tolerances& tolerances_;
  Open& open_;
  Told& wider_;
  std::map<Axis, std::string> own_;  // axes that the element itself is asked for, as written
  std::set<Axis> inherited_;         // axes that something that holds it is asked for
};

}  // namespace

ToleranceRule parse_rule(const std::string& text) {
  auto [selection, lengths, whole] = ifc::parse_lengths(text, "class=IfcPlate: out_of_plane=+5/-2mm, vertical=5mm");
  ToleranceRule rule{std::move(selection), {}, std::move(whole)};
  for (const auto& [name, length, part] : lengths) {
    const Axis axis = axis_of(name, text);
    Tolerance tolerance;
    tolerance.value = length;
    const auto sides = two_sides(text::trim(std::string_view(part).substr(std::min(part.size(), part.find('=') + 1))));
    if (sides && !has_sign(axis))
      throw std::runtime_error(
          "tolerance rule '" + text + "': found '" + part + "', but " + name +
          " is the length of a vector and has no sign; two sides are for vertical, out_of_plane and "
          "joint");
    if (sides) tolerance = *sides;
    if (sides && !(tolerance.value > 0 || tolerance.below > 0))
      throw std::runtime_error("tolerance rule '" + text + "': found '" + part +
                               "', which nothing that is measured can keep; " + name +
                               "=0mm says that it is not judged");
    if (!(tolerance.value >= 0 && tolerance.value <= 1 && tolerance.lower() <= 1))
      throw std::runtime_error("tolerance rule '" + text + "': found '" + part +
                               "', expected axis=length, a length from 0 to 1 m with its unit, such as 5mm, 0.005m or "
                               "+5/-2mm");
    rule.tolerances[axis] = tolerance;
  }
  return rule;
}

Tolerances tolerances_of(const ToleranceTable& table, const ifc::ElementFacts& element, ToleranceFindings* findings) {
  Tolerances tolerances;
  for (const Axis axis : {Axis::horizontal, Axis::vertical})
    tolerances[axis] = {table.tau, std::string(ifc::kDefaultTolerance)};
  tolerances[Axis::joint] = {2 * table.tau, std::string(ifc::kDefaultTolerance) + ": twice the tolerance"};
  Open open;
  Told wider;
  std::map<Axis, std::size_t> rule_of;  // the rule that holds
  if (table.from_design && element.properties) DesignTolerances(*element.properties, tolerances, open, wider);
  for (std::size_t i = 0; i < table.rules.size(); ++i) {
    const ToleranceRule& rule = table.rules[i];
    if (!rule.selection.matches(element)) continue;
    if (findings) findings->rules.push_back(i);
    for (const auto& [axis, tolerance] : rule.tolerances) {
      if (findings && rule_of.contains(axis)) findings->replaced.emplace_back(rule_of[axis], i);
      if (findings && rule_of.contains(axis) && is_wider(tolerance, table.rules[rule_of[axis]].tolerances.at(axis)))
        findings->widened[rule_of[axis]] = i;
      rule_of[axis] = i;
      if (tolerance.value > 0 || tolerance.lower() > 0)
        tolerances[axis] = {tolerance.value, rule.text, tolerance.below};
      else
        tolerances.erase(axis);
      if (axis != Axis::joint) std::erase_if(open, [&](const auto& entry) { return entry.second == axis; });
      std::erase_if(wider, [&](const auto& entry) { return entry.second == axis; });
    }
  }
  if (findings)
    for (const auto& [axis, rule] : rule_of) findings->in_force.push_back(rule);
  if (findings)
    for (const auto& [refusal, axis] : open) findings->refused.push_back({refusal.first, "design", refusal.second});
  if (findings)
    for (const auto& [property, axis] : wider) findings->wider.push_back(property);
  return tolerances;
}

}  // namespace plumbline::judgement

// Which tolerance an element is held against: per class, element and axis.
#pragma once

#include <cmath>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "building/ifc/selection.hpp"

namespace plumbline::judgement {

/// Axes of an anchor: horizontal, vertical, in_plane (of the facade), out_of_plane, space. Of a panel also joint.
enum class Axis { horizontal, vertical, in_plane, out_of_plane, space, joint };
inline constexpr Axis kAxes[] = {Axis::horizontal,   Axis::vertical, Axis::in_plane,
                                 Axis::out_of_plane, Axis::space,    Axis::joint};
const char* name_of(Axis axis);
/// Whether anchors (panels) are judged along it.
bool judged_of_anchors(Axis axis);
bool judged_of_panels(Axis axis);

struct Tolerance {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< [m] largest value; nan: this axis is not judged
  std::string source;
  /// [m] How far below zero; nan: as far as `value` above. Only where the axis has a sign: vertical, out_of_plane,
  /// joint.
  double below = std::numeric_limits<double>::quiet_NaN();
  double lower() const { return std::isnan(below) ? value : below; }
  /// The limit on the side on which a value lies [m].
  double limit_of(double length) const { return length < 0 ? lower() : value; }
  /// That on the side that it is nearer to, or beyond [m]: the one that decides.
  double nearer_limit(double length) const { return lower() + length < value - length ? lower() : value; }
};
using Tolerances = std::map<Axis, Tolerance>;

/// One line of the tolerance table: "class=IfcPlate & storey=Level 2: out_of_plane=+5/-2mm, vertical=5mm".
struct ToleranceRule {
  ifc::Selection selection;
  std::map<Axis, Tolerance> tolerances;  ///< value 0 and nothing below: this axis is not judged
  std::string text;
  bool of_table = false;  ///< a row of the project's table, which is for all of its buildings
  bool optional = false;  ///< such a row that says itself that a building may have nothing of it
};

/// Throws std::runtime_error that quotes the rule and says what is expected: an unknown axis, a length without unit (mm
/// or m), a length below zero or above a metre, two sides for a length that has no sign.
ToleranceRule parse_rule(const std::string& text);

struct ToleranceTable {
  double tau = 0.005;  ///< [m] horizontal and vertical deviation, where nothing else is said; the joints: twice that
  bool from_design = true;           ///< Pset_Tolerance of the element, where the design has it, goes before tau
  std::vector<ToleranceRule> rules;  ///< go before both; later rules before earlier ones
};

/// What was asked for one element beside the tolerances that hold.
struct ToleranceFindings {
  std::vector<std::size_t> rules;     ///< those that select it
  std::vector<std::size_t> in_force;  ///< those that give it a limit, or say that an axis is not judged
  std::vector<std::pair<std::size_t, std::size_t>> replaced;  ///< rules whose limit a later one, the second, replaces
  std::map<std::size_t, std::size_t>
      widened;                           ///< rules whose limit a later one, the second, replaces by a wider one or none
  std::vector<ifc::NotApplied> refused;  ///< what the design asks for and cannot be judged, with the reason
  std::vector<std::string> wider;        ///< properties of what holds it that are wider than what holds without them
};

/// A property of Pset_Tolerance that is no length (a number without unit, a text, a kind that nothing measures) is not
/// left out: it is refused with its reason, unless a rule gives that axis. So is one that two sets give differently,
/// and one of a set whose name is nearly that. Of what holds the element (assembly, storey, group) it narrows what
/// holds else; one that is wider is told, where no nearer one gives that axis and no rule does.
Tolerances tolerances_of(const ToleranceTable& table, const ifc::ElementFacts& element,
                         ToleranceFindings* findings = nullptr);

}  // namespace plumbline::judgement

// Which tolerance an element is held against: per class, element and axis.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <vector>

#include "ifc/selection.hpp"

namespace plumbline::judgement {

/// Axes of an anchor: horizontal, vertical, in_plane (of the facade), out_of_plane, space. Of a panel also joint.
enum class Axis { horizontal, vertical, in_plane, out_of_plane, space, joint };
inline constexpr Axis kAxes[] = {Axis::horizontal,   Axis::vertical, Axis::in_plane,
                                 Axis::out_of_plane, Axis::space,    Axis::joint};
const char* name_of(Axis axis);

struct Tolerance {
  double value = std::numeric_limits<double>::quiet_NaN();  ///< [m]; nan: this axis is not judged
  std::string source;
};
using Tolerances = std::map<Axis, Tolerance>;

/// One line of the tolerance table: "class=IfcPlate & storey=Level 2: out_of_plane=3mm, vertical=5mm".
struct ToleranceRule {
  bim::Selection selection;
  std::map<Axis, double> tolerances;  ///< [m]; 0: this axis is not judged
  std::string text;
};

/// Throws std::runtime_error that quotes the rule and says what is expected: an unknown axis, a length without unit (mm
/// or m), a length below zero or above a metre.
ToleranceRule parse_rule(const std::string& text);

struct ToleranceTable {
  double tau = 0.005;  ///< [m] horizontal and vertical deviation, where nothing else is said; the joints: twice that
  bool from_design = true;           ///< Pset_Tolerance of the element, where the design has it, goes before tau
  std::vector<ToleranceRule> rules;  ///< go before both; later rules before earlier ones
};

Tolerances tolerances_of(const ToleranceTable& table, const bim::ElementFacts& element);

}  // namespace plumbline::judgement

// Which bracket stands at an anchor, and which hook a panel has on it: rules over the design, in the language of
// tolerances.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "building/ifc/selection.hpp"
#include "loop/fit/facade.hpp"

namespace plumbline::loop {

/// "class=IfcMechanicalFastener: right=20mm, up=15mm, out=25mm, step_out=1mm": to both sides; what is not named is that
/// of BracketType; 0mm: not adjustable that way.
struct BracketRule {
  ifc::Selection selection;
  BracketType type;
  std::string text;
};

/// Throws std::runtime_error that quotes the rule and says what is expected.
BracketRule parse_bracket_rule(const std::string& text);

/// The last rule that selects the anchor; before that, the design's Pset_BracketRange (Right, Up, Out, StepRight,
/// StepUp, StepOut [m]). Without any rules the assumed type. nullopt: there are rules, and none selects it.
std::optional<BracketType> bracket_type_of(const std::vector<BracketRule>& rules, const ifc::ElementFacts& anchor);

/// "name~-R2$: fixed", or slides_sideways, slides_up, slides (held only out of plane).
struct HookRule {
  ifc::Selection selection;
  std::array<bool, 3> holds;
  std::string text;
};
HookRule parse_hook_rule(const std::string& text);

/// Hooks of a panel on its brackets, unless a rule says otherwise: of the uppermost (within 0.3 m) the leftmost is
/// fixed, the others slide sideways; those below hold it out of plane only.
std::array<bool, 3> usual_hook(const std::vector<Eigen::Vector3d>& brackets, std::size_t which,
                               const Eigen::Matrix3d& axes);

}  // namespace plumbline::loop

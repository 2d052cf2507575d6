// What holds panels at their bottom edge, as the user says it: the panel below by its stack joint or, in the lowest
// row, a starter sill. It holds out of the facade only; up, down and along the edge slides.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "building/ifc/selection.hpp"

namespace plumbline::judgement {

/// Standard deviations [m], out of the facade.
struct StackJoint {
  double sigma = 0;                                              ///< of a bottom edge against what carries it
  double sill_sigma = std::numeric_limits<double>::quiet_NaN();  ///< of a sill that nobody measured; nan: not said
  std::string source;
};

/// "class=IfcPlate: sigma=0.5mm, play=1mm, sill_sigma=2mm". play: as far as an edge can be to either side of the middle
/// of its joint, anywhere alike (its standard deviation is a root of three less). sigma or play is said.
struct HeldBelowRule {
  ifc::Selection selection;
  StackJoint joint;
  std::string text;
};

/// Throws std::runtime_error that quotes the rule and says what is expected.
HeldBelowRule parse_held_below(const std::string& text);

struct HeldBelow {
  std::vector<HeldBelowRule> rules;   ///< go before the design's Pset_StackJoint; later rules before earlier ones
  std::vector<ifc::Selection> sills;  ///< anchors that are measured places of a sill: no panel hangs on them

  bool is_sill(const ifc::ElementFacts& anchor) const;
  /// Nothing where neither a rule nor Pset_StackJoint (Sigma, Play, SillSigma) says that the panel is held. What of the
  /// set cannot be read is added to `refused`.
  std::optional<StackJoint> of(const ifc::ElementFacts& panel, std::vector<ifc::NotApplied>& refused) const;
};

}  // namespace plumbline::judgement

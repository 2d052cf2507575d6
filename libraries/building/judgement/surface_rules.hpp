// Limits of surfaces: which panel and joint is held against what.
#pragma once

#include <limits>
#include <string>
#include <vector>

#include "building/ifc/selection.hpp"

namespace plumbline::judgement {

/// What of a surface is held against a limit. Flatness: the largest gap under a straightedge of a length; bow: the
/// middle over the edges, across and up; twist: a corner over the plane; offset: the panel's corners out of the
/// design's face or behind it; step: one panel over its neighbour at a joint; joint: its width against the design's;
/// narrowest, widest: its width itself; shift: the joint beside where the design has it.
enum class SurfaceQuantity { flatness, bow, twist, offset, step, joint, narrowest, widest, shift };
const char* name_of(SurfaceQuantity quantity);
bool is_of_joints(SurfaceQuantity quantity);

struct SurfaceLimit {
  SurfaceQuantity quantity = SurfaceQuantity::flatness;
  double length = std::numeric_limits<double>::quiet_NaN();  ///< of the straightedge [m]
  /// Of the value [m]; bow, twist, offset, step, shift: about 0; joint: about the design's width.
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
};

/// Whether both limit the same quantity, of flatness under the same straightedge.
bool same_question(const SurfaceLimit& a, const SurfaceLimit& b);

/// One line: "class=IfcPlate & storey=Level 2: flatness(1m)=3mm, bow=4mm, step=2mm, joint=+4/-3mm, narrowest=8mm".
struct SurfaceRule {
  ifc::Selection selection;
  std::vector<SurfaceLimit> limits;
  std::string text;
};

/// Throws std::runtime_error that quotes the rule and the part and says what is expected: an unknown quantity, flatness
/// without the length of its straightedge, a length without unit (mm or m), below zero or above a metre, one quantity
/// twice (flatness(1m) and flatness(1000mm)), a narrowest above the widest.
SurfaceRule parse_surface_rule(const std::string& text);

}  // namespace plumbline::judgement

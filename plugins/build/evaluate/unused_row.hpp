// A row of a project's tolerance table that selects nothing in this building: for another one, or a slip of the pen.
#pragma once

#include <string>

#include "artifacts/design.hpp"
#include "building/judgement/tolerance_rules.hpp"

namespace plumbline::judgement {

/// Why such a row is not judged; empty: it is for what this building does not have. That is so where the row says
/// `optional`, and where every term is right by itself: some anchor or panel has it; it is a class of IFC; or its value
/// is one of theirs but for its figures (storey=Level 2). Any other value may be a slip of the pen, and the nearest one
/// that there is is offered. So may a class of which they have a kind that is called after it (IfcFastener,
/// IfcMechanicalFastener).
std::string why_unused(const ToleranceRule& row, const DesignT& design);

}  // namespace plumbline::judgement

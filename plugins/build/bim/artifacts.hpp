// Between the artifacts on the edges and the plain structs of the library.
#pragma once

#include "artifacts/design.hpp"
#include "artifacts/points.hpp"
#include "building/ifc/design.hpp"

namespace plumbline::ifc {

DesignT to_artifact(const Design& design);
Design from_artifact(const DesignT& artifact);
std::unique_ptr<JudgementRequestT> to_artifact(const NotApplied& request);

/// Anchors of a design as points of its frame: their names (GlobalIds where a name is missing or not unique), no
/// uncertainty.
PointsT anchor_points(const Design& design);

}  // namespace plumbline::ifc

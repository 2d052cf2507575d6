// Between the artifacts on the edges and the plain structs of the library.
#pragma once

#include "artifacts/accuracy.hpp"
#include "artifacts/design.hpp"
#include "artifacts/points.hpp"
#include "ifc/as_built.hpp"

namespace plumbline::bim {

DesignT to_artifact(const Design& design);
Design from_artifact(const DesignT& artifact);

/// Anchors of a design as points of its frame: their names (GlobalIds where a name is missing or not unique), no
/// uncertainty.
PointsT anchor_points(const Design& design);

/// Positions with covariance of those points that the accuracy evaluation lists as anchors, with their residuals
/// against the survey; floors and transfers of its comparison with the survey, on check anchors if there are any, else
/// on control anchors. Throws std::runtime_error if the covariance of the points has the wrong size.
AsBuilt as_built_from(const PointsT& model, const AccuracyT& accuracy);

}  // namespace plumbline::bim

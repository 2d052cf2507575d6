// Surfaces as uncertain as the misfit of the measurement's model says.
#pragma once

#include "artifacts/surfaces.hpp"

namespace plumbline::ifc {

/// Multiplies the covariance of all figures by `factor`. Whoever shows figures beside verdicts shows them so, by
/// SurfaceJudgement.covariance_factor.
void enlarge(SurfacesT& surfaces, double factor);

}  // namespace plumbline::ifc

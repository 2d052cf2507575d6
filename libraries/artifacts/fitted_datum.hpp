// Points that rest on others have their datum: what these were fitted to cannot be seen in them either. For plugins: it
// needs the generated code.
#pragma once

#include <cmath>
#include <memory>
#include <string>

#include "artifacts/points.hpp"

namespace plumbline {

/// Marks points whose frame was fitted to the design. Any other mark of theirs stays: it was there first.
inline void mark_fitted(PointsT& points, const std::string& origin, double datum_sigma) {
  if (points.fitted_to_design) return;
  points.fitted_to_design = std::make_unique<FittedDatumT>();
  points.fitted_to_design->origin = origin, points.fitted_to_design->datum_sigma = datum_sigma;
}

/// Points with the coordinates of the design: what is brought to these is fitted to it.
inline void mark_designed(PointsT& points) {
  mark_fitted(points, "brought to the coordinates of the design of its anchors", std::nan(""));
}

/// `points` were brought to the frame of `control`.
inline void take_datum(const PointsT& control, PointsT& points) {
  if (control.fitted_to_design)
    mark_fitted(points, control.fitted_to_design->origin, control.fitted_to_design->datum_sigma);
}

}  // namespace plumbline

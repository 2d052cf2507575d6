// Points known beforehand, from the artifact to what a network adjustment takes. For plugins: it needs the generated
// code.
#pragma once

#include "artifacts/points.hpp"
#include "geometry/packed_symmetric.hpp"
#include "survey/adjust/adjust_network.hpp"

namespace plumbline::survey {

/// Control points of an artifact. Without covariance their sigmas are taken; without these either they are without
/// error.
inline ControlPoints control_from_artifact(const PointsT& points) {
  ControlPoints control;
  const auto n = static_cast<Eigen::Index>(points.points.size());
  control.coordinates.resize(3 * n);
  Eigen::VectorXd sigmas(3 * n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const PointT& p = *points.points[i];
    control.ids.push_back(p.id);
    control.coordinates.segment<3>(3 * i) = p.position;
    sigmas.segment<3>(3 * i) = p.sigma;
  }
  if (!points.covariance.empty()) {
    control.covariance = unpack_symmetric(points.covariance, 3 * points.points.size(), "the control points");
  } else if (sigmas.allFinite() && (sigmas.array() > 0).all()) {
    control.covariance = sigmas.cwiseAbs2().asDiagonal();
  }
  return control;
}

}  // namespace plumbline::survey

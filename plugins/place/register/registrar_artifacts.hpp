// Between the artifacts of a pipeline and the structs of libraries/control/registration, for every registrar of this
// folder.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "artifacts/points.hpp"
#include "artifacts/transform.hpp"
#include "control/registration/robust_registration.hpp"

namespace plumbline::registration {

/// Points that both sides have, by id, without check points, in the order of `to`.
struct Matched {
  Correspondences points;
  std::vector<int> from, to;        ///< indices into the artifacts' points
  Eigen::MatrixXd from_covariance;  ///< of all source points; empty: not known
};

/// The full covariance of each side if it is there, else that of the sigmas. Throws std::runtime_error for an id that
/// stands twice, DegenerateRegistration for fewer than 3 points.
Matched match(const PointsT& from, const PointsT& to);

/// `scale_w`: test value of the scale, nan if none was estimated.
TransformT transform_artifact(const Matched& matched, const RobustRegistration& result, const std::string& estimator,
                              double scale_w);

/// All source points in the frame of the target, with the errors of those that took part acting twice, and the target's
/// roles where the source has none.
PointsT points_artifact(const PointsT& from, const PointsT& to, const Matched& matched,
                        const RobustRegistration& result);

}  // namespace plumbline::registration

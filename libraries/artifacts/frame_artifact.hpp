// Between geometry/frame_graph.hpp and the artifact of schemas/artifacts/transform.fbs.
// For plugins: it needs the generated code.
#pragma once

#include <string>

#include "artifacts/transform.hpp"
#include "geometry/frame_graph.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline {

/// Throws std::runtime_error if the covariance has neither 0, 21 nor 28 values.
inline FrameLink frame_link(const TransformT& transform, const std::string& to, const std::string& from) {
  FrameLink link{to, from, transform.origin, transform.to_from_from, 1, transform.plan_only, Matrix7::Zero()};
  if (std::isfinite(transform.scale)) link.scale = transform.scale;
  if (transform.covariance.empty()) return link;
  const std::size_t size = transform.covariance.size() == 21 ? 6 : 7;
  link.covariance.topLeftCorner(static_cast<Eigen::Index>(size), static_cast<Eigen::Index>(size)) =
      unpack_symmetric(transform.covariance, size, "the transform from " + from + " to " + to);
  return link;
}

/// The covariance is left out if it is zero.
inline TransformT transform_artifact(const FrameLink& link) {
  TransformT out;
  out.to_from_from = link.to_from_from;
  out.scale = link.scale;
  out.plan_only = link.plan_only;
  out.origin = link.origin;
  if (link.covariance.cwiseAbs().maxCoeff() > 0)
    out.covariance = pack_symmetric(link.covariance(6, 6) > 0 ? Eigen::MatrixXd(link.covariance)
                                                              : Eigen::MatrixXd(link.covariance.topLeftCorner<6, 6>()));
  return out;
}

}  // namespace plumbline

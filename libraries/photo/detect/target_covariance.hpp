// How well a target's centre is determined.
#pragma once

#include <Eigen/Core>

#include "photo/detect/target_model.hpp"

namespace plumbline::detect {

inline constexpr int kTargetLags = 2;  ///< over which noise may be correlated [px]

/// Covariance of the centre [px²], from the odd part of the residuals about it: the model is even there. Noise that is
/// correlated between pixels counts where it makes the centre worse.
Eigen::Matrix2d centre_covariance(const TargetFit& fit);

}  // namespace plumbline::detect

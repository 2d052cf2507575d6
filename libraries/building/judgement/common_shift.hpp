// Is everything shifted together? A datum that does not fit the design moves all anchors alike; nobody should mend five
// hundred of them.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <vector>

#include "artifacts/deviation.hpp"
#include "building/judgement/block_covariance.hpp"

namespace plumbline::judgement {

/// Robust rigid motion (small rotations) that `deviations` [m] at `positions` [m] have in common, by iteratively
/// reweighted least squares with Tukey's biweight (Holland and Welsch 1977, c = 4.685) about the component-wise median,
/// so that single blunders do not carry it. `covariance` (3n x 3n [m²], if it is known) adds what the measurement has
/// in common. Significant: Hotelling's test at 99.9 %, by what the anchors scatter in each direction, two thirds of the
/// anchors follow it, and it moves an anchor by at least half of `smallest_tolerance` [m]. If it is, `would_pass`
/// counts the anchors that pass with their deviations corrected; empty where none can pass: then nothing is said of it.
/// Null with fewer than four.
std::unique_ptr<CommonShiftT> common_shift(
    const std::vector<Eigen::Vector3d>& positions, const std::vector<Eigen::Vector3d>& deviations,
    const judgement::BlockCovariance& covariance, double smallest_tolerance,
    const std::function<int(const std::vector<Eigen::Vector3d>& corrected)>& would_pass);

}  // namespace plumbline::judgement

// What check points are off, and how well that is known: of the block, of their survey, and of what both share.
#pragma once

#include "photo/block/point_block.hpp"
#include "photo/bundle/cofactors.hpp"
#include "photo/bundle/problem.hpp"

namespace plumbline::block {

/// Fills PointBlockResult::check_covariance. `factor` f: what the cofactors are scaled by, the survey of the control
/// with them. Where check points and control are of one survey, its errors that both have cancel: the block's estimate
/// x of a check point follows the control c by Q_xc Σ_cc⁻¹, Q the cofactors, and of the survey l of the check point A =
/// Σ_lc Σ_cc⁻¹ follows it, too. Of x − l then f (Q_xx − Q_xc Aᵀ − A Q_cx + A Σ_cl) + (Σ_ll − A Σ_cl), and f Q_xx + Σ_ll
/// where they have nothing in common.
void fill_check_covariance(const BlockControl& control, const bundle::Layout& layout,
                           const bundle::Cofactors& cofactors, double factor, PointBlockResult& result);

/// The same of a known point `k` that took no part, as the others of `aside` did not [m²]; without what is shared where
/// the block's joint covariance is not there. `unit`: what PointBlockResult's covariances are scaled by.
Eigen::Matrix3d covariance_of_difference(const PointBlockResult& result, const BlockControl& control,
                                         const std::vector<std::size_t>& aside, std::size_t k, double unit);

}  // namespace plumbline::block

// The directions in which the scaled reduced system of a block is weakest, and how weak: whether all is determined, and
// if not, what.
#pragma once

#include <Eigen/Core>
#include <limits>

#include "photo/bundle/elimination.hpp"

namespace plumbline::bundle {

/// Smallest eigenvalue beside those of `motions` (orthonormal null vectors that the factor was completed along), with
/// its vector, by inverse iteration. Given up where no doubt is left that it is above `enough`: four steps raise the
/// part of a vector that belongs to a 10⁴ times smaller value by 10¹⁶.
double smallest_eigenvalue(const least_squares::SparseCholesky& factor, const Eigen::MatrixXd& motions,
                           Eigen::VectorXd& vector, double enough = std::numeric_limits<double>::infinity());

struct Spectrum {
  Eigen::VectorXd values;   ///< ascending
  Eigen::MatrixXd vectors;  ///< scaled unknowns
};
/// All eigenvalues below `limit` beside those of `motions`, and some above; of a small system all of them. Leaves the
/// elimination's own factor alone.
Spectrum smallest_eigenvalues(const Elimination& elimination, const Eigen::MatrixXd& motions, double limit);

}  // namespace plumbline::bundle

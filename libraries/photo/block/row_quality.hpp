// Quality of the rows of one observation of a block.
#pragma once

#include "least_squares/problem/schur.hpp"

namespace plumbline::block {

/// `square_root` is L of the rows' covariance L Lᵀ, `cofactor` their Q_vv after residual_cofactors(). MDBs are those of
/// a w-test of significance 0.1 % and power 80 %.
std::vector<least_squares::RowStatistics> row_quality(const Eigen::MatrixXd& square_root,
                                                      const least_squares::ObservationRows& rows,
                                                      const Eigen::MatrixXd& cofactor);

/// Their non-centrality, 4.13.
double minimal_non_centrality();

}  // namespace plumbline::block

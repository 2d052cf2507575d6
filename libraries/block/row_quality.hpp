// Quality of the rows of one observation of a block.
#pragma once

#include "adjustment/schur.hpp"

namespace plumbline::adjust {

/// `square_root` is L of the rows' covariance L Lᵀ, `cofactor` their Q_vv after residual_cofactors(). MDBs are those of
/// a w-test of significance 0.1 % and power 80 %.
std::vector<adjustment::RowStatistics> row_quality(const Eigen::MatrixXd& square_root,
                                                   const adjustment::ObservationRows& rows,
                                                   const Eigen::MatrixXd& cofactor);

/// Their non-centrality, 4.13.
double minimal_non_centrality();

}  // namespace plumbline::adjust

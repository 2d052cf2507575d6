#include "block/row_quality.hpp"

namespace plumbline::adjust {

double minimal_non_centrality() {
  static const double value = adjustment::non_centrality(0.001, 0.8);
  return value;
}

std::vector<adjustment::RowStatistics> row_quality(const Eigen::MatrixXd& square_root,
                                                   const adjustment::ObservationRows& rows,
                                                   const Eigen::MatrixXd& cofactor) {
  const Eigen::MatrixXd whitening = square_root.triangularView<Eigen::Lower>().solve(
      Eigen::MatrixXd::Identity(square_root.rows(), square_root.cols()));
  return adjustment::row_statistics(whitening, -rows.misclosure, cofactor, minimal_non_centrality());
}

}  // namespace plumbline::adjust

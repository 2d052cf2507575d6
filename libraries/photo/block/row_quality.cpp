#include "photo/block/row_quality.hpp"

namespace plumbline::block {

double minimal_non_centrality() {
  static const double value = least_squares::non_centrality(0.001, 0.8);
  return value;
}

std::vector<least_squares::RowStatistics> row_quality(const Eigen::MatrixXd& square_root,
                                                      const least_squares::ObservationRows& rows,
                                                      const Eigen::MatrixXd& cofactor) {
  const Eigen::MatrixXd whitening = square_root.triangularView<Eigen::Lower>().solve(
      Eigen::MatrixXd::Identity(square_root.rows(), square_root.cols()));
  return least_squares::row_statistics(whitening, -rows.misclosure, cofactor, minimal_non_centrality());
}

}  // namespace plumbline::block

#include "building/judgement/factor_in_place.hpp"

#include <Eigen/Cholesky>

namespace plumbline::judgement {

bool factor_in_place(Eigen::MatrixXd& symmetric) {
  return Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>(symmetric).info() == Eigen::Success;
}

void restore_lower(const Eigen::VectorXd& diagonal, Eigen::MatrixXd& symmetric) {
  symmetric.diagonal() = diagonal;
  for (Eigen::Index column = 0; column < symmetric.cols(); ++column)
    for (Eigen::Index row = column + 1; row < symmetric.rows(); ++row) symmetric(row, column) = symmetric(column, row);
}

}  // namespace plumbline::judgement

#include "building/judgement/factor_in_place.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "geometry/linear_algebra/lower_factor.hpp"

namespace plumbline::judgement {

bool factor_in_place(Eigen::MatrixXd& symmetric) {
  constexpr Eigen::Index many = 300;  // below it nothing is gained
  if (symmetric.rows() > many) return linear_algebra::lower_factor(symmetric.data(), symmetric.rows());
  return Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>(symmetric).info() == Eigen::Success;
}

void restore_lower(const Eigen::VectorXd& diagonal, Eigen::MatrixXd& symmetric) {
  constexpr Eigen::Index side = 64;  // of squares, so that both triangles are read and written along lines of the cache
  symmetric.diagonal() = diagonal;
  const Eigen::Index n = symmetric.rows();
  for (Eigen::Index left = 0; left < n; left += side)
    for (Eigen::Index top = left; top < n; top += side)
      for (Eigen::Index column = left; column < std::min(n, left + side); ++column)
        for (Eigen::Index row = std::max(top, column + 1); row < std::min(n, top + side); ++row)
          symmetric(row, column) = symmetric(column, row);
}

}  // namespace plumbline::judgement

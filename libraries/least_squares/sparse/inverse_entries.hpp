// Entries of the inverse outside of the factor's pattern, from those on it: for a block of a supernode C with the rows
// R below it, and any block b that is eliminated later, Z_bC = −Z_bR L_RC L_CC⁻¹ (Takahashi, Fagan & Chin 1973). What
// of Z_bR is not on the pattern either follows likewise. Of two points that are measured from the same or neighbouring
// places it takes a few small products, where a solve with the factor walks through all of it.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <utility>

#include "least_squares/sparse/selected_inverse.hpp"

namespace plumbline::least_squares {

class InverseEntries {
 public:
  /// Both are kept by reference; `inverse` is that of `factor`, not scaled.
  InverseEntries(const SparseCholesky& factor, const SelectedInverse& inverse) : factor_(factor), inverse_(inverse) {}

  /// size(a) × size(b), exact; nullopt if more blocks than `most` had to be found on the way: then a solve is cheaper.
  std::optional<Eigen::MatrixXd> block(int a, int b, int most = 4000);

 private:
  const Eigen::MatrixXd* find(int later, int earlier);
  const Eigen::MatrixXd& below(int block);

  const SparseCholesky& factor_;
  const SelectedInverse& inverse_;
  std::map<std::pair<int, int>, Eigen::MatrixXd> found_;  ///< later and earlier block
  std::map<int, Eigen::MatrixXd> below_;                  ///< −L_RC L_CC⁻¹, the columns of a block
  int left_ = 0;
};

}  // namespace plumbline::least_squares

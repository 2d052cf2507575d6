// The entries of the inverse where the factor has its own: cofactors of all unknowns and of all pairs that meet in an
// observation, at the cost of a few factorisations and in the memory of one factor. All of them are exact; what lies
// outside of the pattern is asked of SparseCholesky.
//
// Sources: Takahashi, Fagan & Chin (1973); Campbell & Davis (1995), Computing the sparse inverse subset: an inverse
// multifrontal approach. From the last supernode to the first, with its columns C and the rows R below them, whose Z_RR
// is known by then: Z_RC = −Z_RR L_RC L_CC⁻¹, Z_CC = L_CC⁻ᵀ L_CC⁻¹ − (L_RC L_CC⁻¹)ᵀ Z_RC.
#pragma once

#include <memory>
#include <span>

#include "least_squares/sparse/sparse_cholesky.hpp"

namespace plumbline::least_squares {

class SelectedInverse {
 public:
  /// Computed in the factor's own memory if that is given away.
  explicit SelectedInverse(SparseCholesky factor);

  /// Whether the pattern holds the pair: always if they are coupled or the same.
  bool has(int a, int b) const;
  bool has_all(std::span<const int> blocks) const;  ///< each pair of them
  /// size(a) × size(b). Throws std::out_of_range where has() is false.
  Eigen::MatrixXd block(int a, int b) const;
  /// Joint matrix of blocks that all meet each other, in the order given. Throws as block() does.
  Eigen::MatrixXd joint(std::span<const int> blocks) const;
  void joint(std::span<const int> blocks, Eigen::Ref<Eigen::MatrixXd> target) const;
  /// All of it, where the analysis is dense.
  Eigen::Map<const Eigen::MatrixXd> dense() const;
  /// diag(s) Z diag(s) in place.
  void scale(const Eigen::VectorXd& s);
  Eigen::VectorXd diagonal() const;

 private:
  struct Work;
  void invert(const Analysis::Supernode& s, Work& work);
  void gather(const Analysis::Supernode& s, Work& work) const;
  const double* find(int row, int column, std::ptrdiff_t& stride) const;

  std::shared_ptr<const Analysis> analysis_;
  std::vector<double> values_;
};

}  // namespace plumbline::least_squares

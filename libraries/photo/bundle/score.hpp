// Score tests (Rao 1948): what a larger model would explain beyond an adjusted one, from the adjusted one's factors.
//
// With N the normal matrix of the adjusted unknowns, B its coupling with the further ones, M their own matrix and g
// their right side −J₂ᵀ r at the minimum of the smaller model, one Gauss-Newton step of the larger one lowers the sum
// of squares by gᵀ S⁻¹ g, S = M − Bᵀ N⁻¹ B: chi-squared with as many degrees of freedom as there are further unknowns.
#pragma once

#include <cmath>
#include <vector>

#include "photo/bundle/elimination.hpp"

namespace plumbline::bundle {

class ScoreTest {
 public:
  /// `larger` is `problem` with more unknowns: values of cameras after those that were free, principal points of
  /// images, and with what is known of those. Both are evaluated at `state`. Precondition: `factors` of `problem`,
  /// built at `state` without damping and factorised, with constraints if the block is free (further unknowns change
  /// nothing of what no observation sees).
  ScoreTest(const Problem& problem, const Problem& larger, const State& state, const Elimination& factors);

  struct Explained {
    double decrease = std::nan("");  ///< of the sum of squares; nan if the unknowns are not determined
    Eigen::VectorXd step;            ///< in the unknowns that were asked for
    /// Trace of S: unknowns that scatter independently with σ² raise the expected decrease by σ² times as much.
    double information = std::nan("");
  };
  /// By the further unknowns of this kind of block alone, or of the one with this index.
  Explained by(Kind kind, int index = all) const;
  /// N⁻¹ B of them, unknowns of the smaller model × further ones: minus what its minimum moves by when one of these is
  /// not zero and nobody estimates it. Of a free block in the datum that completed its factors.
  Eigen::MatrixXd influence(Kind kind, int index = all) const;
  static constexpr int all = -1;

 private:
  void sort_unknowns();
  void add_observations(const State& state, int eliminated);
  void add_known(const State& state);
  using RowMajor =
      Eigen::Ref<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>, 0, Eigen::OuterStride<>>;
  void add(const std::vector<int>& columns, const RowMajor& jacobian, const Eigen::Ref<const Eigen::VectorXd>& residual,
           int eliminated);
  void reduce(const Elimination::Block& block);
  std::vector<int> chosen(Kind kind, int index) const;

  const Problem& larger_;
  const Elimination& factors_;
  const Layout small_, large_;
  std::vector<Ref> refs_;         ///< of the further unknowns
  std::vector<int> further_;      ///< by unknown of the larger model: which further one it is, or −1
  std::vector<int> block_, row_;  ///< of the others: their block in the smaller model, and their place in it
  Eigen::MatrixXd own_;           ///< of the eliminated block at work: 6 × further unknowns
  Eigen::MatrixXd kept_;          ///< kept unknowns × further ones
  Eigen::MatrixXd coupling_;      ///< B
  Eigen::MatrixXd matrix_;        ///< M
  Eigen::MatrixXd reduced_;       ///< Bᵀ N⁻¹ B, lower triangle
  Eigen::VectorXd right_;         ///< g
  std::vector<double> products_;  ///< of one further unknown with all that an observation touches
};

}  // namespace plumbline::bundle

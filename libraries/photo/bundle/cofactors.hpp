// Cofactors (covariances for σ0 = 1) of the unknowns of a block by selected inverse: of the kept unknowns where blocks
// meet, of the eliminated ones what is asked for; pairs of the kept ones that never meet by solves. Marginal:
// everything else is unknown too.
#pragma once

#include <functional>

#include "least_squares/sparse/selected_inverse.hpp"
#include "photo/bundle/datum.hpp"
#include "photo/bundle/elimination.hpp"
#include "photo/bundle/terms.hpp"

namespace plumbline::bundle {

class Cofactors {
 public:
  /// Precondition: elimination.factorise() succeeded, with its motions if `datum` is free. Cofactors belong to the
  /// datum: whatever completed the rank, S Q Sᵀ with S = I − G (CᵀG)⁻¹ Cᵀ is that of the wanted one (Baarda 1973).
  Cofactors(const Problem& problem, const Layout& layout, const State& state, const Elimination& elimination,
            const Datum& datum);

  /// Joint cofactor matrix of some blocks of unknowns (numbers of Layout), in the order given.
  Eigen::MatrixXd joint(const std::vector<int>& blocks) const;

  /// 6 × 6, 3 × 3 … of one block.
  Eigen::MatrixXd own(int block) const { return joint({block}); }

  /// Own blocks of all images, points and plates at once: faster than one by one. Indexed by block.
  std::vector<Eigen::MatrixXd> all_own() const;

  /// Calls `visit` with every observation that is not in problem.known: its rows (whitened, no loss), and Q_vv = I − J
  /// Q Jᵀ of the whitened residuals. In the order of the elimination.
  using Visit = std::function<void(const Elimination::TermRef&, const Rows&, const Eigen::Ref<const Eigen::MatrixXd>&)>;
  void visit_rows(const State& state, const Visit& visit) const;

  /// The same for problem.known[index].
  struct KnownQuality {
    KnownRows rows;
    Eigen::MatrixXd residual_cofactor;
  };
  KnownQuality known(const State& state, size_t index) const;

  /// Cofactors between all unknowns of `blocks` and some unknowns of other blocks.
  Eigen::MatrixXd cross(const std::vector<int>& blocks, const std::vector<int>& unknowns,
                        const std::vector<int>& blocks_of_unknowns) const;

 private:
  struct Local {
    Eigen::MatrixXd t;      ///< Y Q of the local kept unknowns
    Eigen::MatrixXd own;    ///< before the datum
    Eigen::MatrixXd cross;  ///< to the local kept unknowns: −L⁻ᵀ t; only in visit_rows()
    Eigen::MatrixXd kept;   ///< Q of the local kept unknowns, unless the inverse is dense
  };
  struct Reach;
  struct Touched;
  using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, Rows::max_rows, Rows::max_rows>;
  std::vector<Eigen::Index> positions(const std::vector<int>& unknowns, const std::vector<int>& blocks) const;
  Local local(const Elimination::Block& block) const;
  Square of_rows(const Rows& rows, int own_block, const Local* near, const int* local, Touched& touched) const;
  Eigen::MatrixXd own_before_datum(int block) const;
  Reach reach_of(int block) const;
  Eigen::MatrixXd by_inverse(const std::vector<Reach>& reaches, const std::vector<int>& kept) const;
  Eigen::MatrixXd by_solves(const std::vector<Reach>& reaches) const;
  void to_datum(int a, int b, Eigen::Ref<Eigen::MatrixXd> q) const;

  const Problem& problem_;
  const Layout& layout_;
  const Elimination& elimination_;
  least_squares::SelectedInverse kept_;  ///< of the reduced matrix, by kept blocks
  bool is_dense_ = false;
  mutable std::vector<Eigen::MatrixXd> own_;  ///< Local::own of eliminated blocks that visit_rows() has been at
  Eigen::MatrixXd g_, p_, m_;                 ///< G, P = (CᵀG)⁻¹ Cᵀ Q, M; empty without a free datum
};

}  // namespace plumbline::bundle

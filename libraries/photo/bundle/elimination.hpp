// Normal equations of a block with one class of unknowns eliminated: either the bodies (points, plates) or the images,
// whichever leaves less work; bodies that an observation ties to other bodies are kept. Observations are linearised one
// after the other, each once, and only L⁻¹ of an eliminated block's coupling is kept: memory is 3 × 6 numbers an
// observation, and what of the kept unknowns' matrix and its factor is not zero (least_squares/sparse_cholesky.hpp).
//
// With V the normal matrix of an eliminated block, V = L Lᵀ, W its coupling with kept unknowns and Y = L⁻¹ W, the
// reduced normal matrix is S = N − Σ Yᵀ Y. Source: Brown (1958); Förstner & Wrobel (2016), Photogrammetric Computer
// Vision, 15.3.
//
// The order of every sum follows from the problem alone, so any number of threads gives the same bits.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "least_squares/sparse/conjugate_gradients.hpp"
#include "least_squares/sparse/sparse_cholesky.hpp"
#include "photo/bundle/kernels.hpp"
#include "photo/bundle/problem.hpp"

namespace plumbline::bundle {

/// ρ(s) of the squared norm of an observation's whitened residuals, for observations marked robust.
struct Loss {
  enum class Kind { none, huber, cauchy, tukey } kind = Kind::none;
  double scale = 1;  ///< of the norm
  double value(double s) const;
  double slope(double s) const;
};

enum class Side { automatic, bodies, images };

/// How the reduced system is solved. Conjugate gradients take no factor, and give nothing but solutions.
enum class Reduced { factor, gradients };

struct Rows;
struct TagGradient;

class Elimination {
 public:
  /// Sorts observations and unknowns; `problem` and `layout` must outlive it.
  Elimination(const Problem& problem, const Layout& layout, Side side = Side::automatic, int threads = 1,
              Reduced reduced = Reduced::factor);

  /// Linearises at `state`, adds `damping` times the diagonal to it, eliminates. False if an observation cannot be
  /// computed there (undefined() says which).
  bool build(const State& state, double damping = 0, const Loss& loss = {});
  /// What build(), factorise() and a selected inverse of it take at their most, beside what was taken when this was
  /// made.
  std::size_t bytes() const;
  /// Factorises the reduced matrix, scaled to its diagonal; false if it has no Cholesky factor. Where `motions`
  /// (kept_count × d, scaled, orthonormal) are its null space, d unknowns are weighed that these move most and apart:
  /// solutions for right sides that no motion sees are those of N, and an inverse is a generalised one. With
  /// Reduced::gradients: prepares them, false if a kept block is open by itself; `motions` are not looked at.
  bool factorise(const Eigen::MatrixXd& motions);
  /// The kept block that is, or −1.
  int open_block() const { return gradients_.undetermined() < 0 ? -1 : kept_blocks_[gradients_.undetermined()]; }
  /// Steps of conjugate gradients since this was made.
  long gradient_steps() const { return gradient_steps_; }
  /// N⁻¹ right for all unknowns (Layout's order), n × d. Precondition: factorise() with Reduced::factor.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& right) const;
  /// −Jᵀ r at `state` for all unknowns and Σ ρ there, and nothing else; false if an observation cannot be computed
  /// there.
  bool gradient(const State& state, Eigen::VectorXd& right, double& cost, const Loss& loss = {}) const;
  /// Gauss-Newton step from the last build(). Precondition: factorise().
  Eigen::VectorXd step() const;
  /// N⁻¹ right with the same factors.
  Eigen::VectorXd step(const Eigen::VectorXd& right) const;

  double sum_of_squares() const { return cost_; }  ///< Σ ρ
  const std::string& undefined() const { return undefined_; }
  const Eigen::VectorXd& right() const { return right_; }        ///< −Jᵀ r, all unknowns
  const Eigen::VectorXd& diagonal() const { return diagonal_; }  ///< of N before the elimination and without damping
  int kept_count() const { return kept_count_; }
  bool eliminates_images() const { return side_ == Side::images; }

  // What is left of the elimination, for cofactors and rank decisions.
  struct Block {
    int block = 0, size = 0;
    std::vector<int> kept;   ///< kept blocks it is coupled with, ascending
    std::vector<int> local;  ///< first column of each in Y
    int columns = 0;         ///< of Y
    size_t y = 0;            ///< start in the storage
    int first_run = 0, run_count = 0;
    /// Smallest squared pivot of V scaled to a unit diagonal; below `singular` the block takes no part.
    double weakest = 1;
    static constexpr double singular = 1e-12;
    bool determined() const { return weakest >= singular; }
    Eigen::Matrix<double, 6, 6> factor;  ///< L in its top left corner
    Eigen::Matrix<double, 6, 1> half;    ///< L⁻¹ right
  };
  const std::vector<Block>& blocks() const { return blocks_; }
  const Run* runs(const Block& b) const { return runs_.data() + b.first_run; }
  const double* y_of(const Block& b) const { return y_.data() + b.y; }
  /// Y, size × columns; stored row by row, so that products of its blocks run along memory.
  auto y(const Block& b) const {
    return Eigen::Map<const Eigen::MatrixXd>(y_.data() + b.y, b.columns, b.size).transpose();
  }
  /// Index into blocks(), or −1.
  int eliminated(int block) const { return eliminated_[block]; }
  /// First row of a kept block in the reduced system, or −1.
  int kept_offset(int block) const { return kept_offset_[block]; }
  /// Scale of each kept unknown in the factorised matrix: 1/√diagonal.
  const Eigen::VectorXd& scale() const { return scale_; }
  /// S before its scaling, by kept blocks in their order.
  const least_squares::SymmetricBlocks& reduced() const { return normal_; }
  /// Of the scaled matrix; its blocks are the kept ones.
  const least_squares::SparseCholesky& factor() const { return factor_; }
  const std::vector<int>& kept_blocks() const { return kept_blocks_; }
  /// Number of a kept block among the kept ones, or −1.
  int kept_index(int block) const { return kept_index_[block]; }

  struct TermRef {
    enum class Kind : int { point, tag, distance, known } kind;
    int index;
    std::array<int, 6> local;  ///< columns in Y of its kept parts, in the order of its parts
  };
  const std::vector<TermRef>& terms(int eliminated) const { return terms_[eliminated]; }
  const std::vector<TermRef>& loose_terms() const { return loose_; }

 private:
  struct Sums;
  void choose_side(Side side);
  void sort_unknowns();
  void sort_terms();
  void blocks_of(const TermRef& term, std::vector<int>& all) const;
  void lay_out_y();
  void couple_kept();
  void allocate();
  bool linearise(const State& state, const Loss& loss, int first, int last, double damping, Sums& sums);
  bool add_loose(const State& state, const Loss& loss);
  void add_products(const Block& block, const TermRef& term, const Rows& rows, double* w, double* v, double* g,
                    Sums& sums) const;
  void eliminate(Block& block, double damping, const Eigen::Matrix<double, 6, 6>& v,
                 const Eigen::Matrix<double, 6, 1>& right);
  void subtract(size_t first, size_t step);
  std::string name(const TermRef& term) const;
  using Half = Eigen::Matrix<double, 6, 1>;
  Eigen::VectorXd substitute_back(const Eigen::VectorXd& reduced, const std::vector<Half>& halves) const;
  void prepare_known();
  void subtract_gradient(const ImageTag& term, const TagGradient& of_tag, double weight, Eigen::VectorXd& right) const;
  Eigen::VectorXd gradient_of_known(const State& state, size_t index, double& cost) const;

  const Problem& problem_;
  const Layout& layout_;
  Side side_ = Side::bodies;
  int threads_ = 1;
  int kept_count_ = 0;
  std::vector<int> eliminated_, kept_offset_, kept_index_, kept_blocks_;
  std::vector<bool> tied_;  ///< bodies that an observation ties to others
  std::vector<Block> blocks_;
  std::vector<std::vector<TermRef>> terms_;
  std::vector<TermRef> loose_;
  /// What of a linear term is the same at every state.
  struct Linear {
    Eigen::MatrixXd whitening, jacobian, normal;  ///< W, J, Jᵀ J
    std::vector<int> columns;                     ///< unknowns, see Layout
    std::vector<int> at;                          ///< their rows in their blocks
    bool diagonal = false;                        ///< JᵀJ is
    /// Columns that are neighbours in one kept block.
    struct Part {
      int kept, first, count;
    };
    std::vector<Part> parts;
  };
  void add_known(const Linear& known);
  std::vector<Linear> known_;                  ///< in the order of the problem
  std::vector<std::vector<Coupled>> coupled_;  ///< by kept block
  std::vector<double> y_;
  std::vector<Run> runs_;
  static constexpr int max_chunks = 8;  ///< of eliminated blocks that are summed up apart
  size_t y_count_ = 0;
  bool is_allocated_ = false;
  /// Of the reduced matrix; and of what kept blocks have in common in observations of eliminated ones.
  least_squares::Pattern pattern_{{}}, direct_pattern_{{}};
  least_squares::SymmetricBlocks normal_, direct_;
  Eigen::VectorXd right_, diagonal_, reduced_right_, scale_;
  Reduced how_ = Reduced::factor;
  least_squares::SparseCholesky factor_;  ///< or:
  least_squares::ConjugateGradients gradients_;
  mutable long gradient_steps_ = 0;
  double cost_ = 0;
  std::string undefined_;
};

}  // namespace plumbline::bundle

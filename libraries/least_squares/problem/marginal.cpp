#include "least_squares/problem/marginal.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/linear_algebra/decompositions.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::least_squares {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Blocks that are left out say nothing.
void silence(Linearisation& lin, const std::vector<char>& left_out) {
  for (std::size_t b = 0; b < lin.blocks.size(); ++b) {
    const Linearisation::Block& block = lin.blocks[b];
    if (!left_out[b]) continue;
    lin.residuals.segment(block.row, block.rows).setZero();
    std::fill_n(lin.jacobian.begin() + block.jacobian_begin, block.rows * block.column_count, 0.0);
  }
  lin.sum_of_squares = lin.residuals.squaredNorm();
}

/// Frees the components for as long as it lives, and puts values and what was held back.
class Freed {
 public:
  Freed(Problem& problem, const std::vector<Component>& components) : problem_(problem) {
    for (const ParameterBlock& p : problem.parameters) values_.push_back(p.value), constant_.push_back(p.constant);
    for (const auto& [block, component] : components)
      if (auto& constant = problem.parameters[block].constant; !constant.empty()) constant[component] = false;
  }
  Freed(const Freed&) = delete;
  Freed& operator=(const Freed&) = delete;
  ~Freed() {
    for (std::size_t b = 0; b < values_.size(); ++b)
      problem_.parameters[b].value = std::move(values_[b]), problem_.parameters[b].constant = std::move(constant_[b]);
  }

 private:
  Problem& problem_;
  std::vector<std::vector<double>> values_;
  std::vector<std::vector<bool>> constant_;
};

/// The rest's system; f in the numbers of the solution, with zeros where those are of c.
class Rest {
 public:
  Rest(Problem& problem, const Solution& solution, const std::vector<char>& left_out,
       const std::vector<Component>& components)
      : problem_(problem),
        left_out_(left_out),
        components_(components),
        all_(problem),
        lin_(prepare_linearisation(problem, all_)),
        normal_(solution.normal),
        place_(static_cast<std::size_t>(all_.count()), -1) {
    for (std::size_t k = 0; k < components.size(); ++k) {
      place_[static_cast<std::size_t>(all_(components[k].block, components[k].component))] = -2 - static_cast<int>(k);
      const int unknown = solution.unknowns(components[k].block, components[k].component);
      if (unknown >= 0) pinned_.push_back(unknown);
    }
    std::sort(pinned_.begin(), pinned_.end());
    for (int u = 0; u < all_.count(); ++u)
      if (place_[u] == -1) place_[u] = solution.unknowns(all_.block_of(u), all_.component_of(u));
    if (std::find(left_out.begin(), left_out.end(), 1) == left_out.end()) {
      factor_ = solution.factor;
      return;
    }
    Linearisation rest = solution.linearisation;
    silence(rest, left_out);
    normal_.assemble(rest);
  }

  bool linearise() {
    if (!least_squares::linearise(problem_, all_, true, lin_)) return false;
    silence(lin_, left_out_);
    return true;
  }

  bool factorise() {
    if (factor_) return true;
    const auto own = std::make_shared<SparseFactor>();
    factor_ = own;
    return own->factorise(normal_, 0, pinned_);
  }

  /// S and N_ff^-1 N_fc, at the linearisation at hand.
  void reduce() {
    const auto k = static_cast<Index>(components_.size());
    MatrixXd n_fc = MatrixXd::Zero(normal_.size(), k), n_cc = MatrixXd::Zero(k, k);
    for (const Linearisation::Block& block : lin_.blocks) {
      const auto jacobian = lin_.jacobian_of(block);
      const int* columns = lin_.columns.data() + block.column_begin;
      for (int c = 0; c < block.column_count; ++c) {
        const int own = place_[columns[c]];
        if (own >= -1) continue;
        for (int f = 0; f < block.column_count; ++f) {
          const int other = place_[columns[f]];
          const double product = jacobian.col(c).dot(jacobian.col(f));
          (other >= 0 ? n_fc(other, -2 - own) : n_cc(-2 - other, -2 - own)) += product;
        }
      }
    }
    follow_ = solve(n_fc);
    MatrixXd s = n_cc - n_fc.transpose() * follow_;
    scale_ = n_cc.diagonal().cwiseMax(std::numeric_limits<double>::min()).cwiseSqrt().cwiseInverse();
    s = scale_.asDiagonal() * (0.5 * (s + s.transpose())).eval() * scale_.asDiagonal();
    eigen_ = linear_algebra::SymmetricEigen(s);
  }

  int defect() const {
    constexpr double kOpen = 1e-9;  // as SolverOptions::rank_tolerance
    return static_cast<int>((eigen_.eigenvalues().array() < kOpen).count());
  }
  MatrixXd null_space() const { return scale_.asDiagonal() * eigen_.eigenvectors().leftCols(defect()); }
  MatrixXd cofactors() const {
    const Index d = defect(), k = scale_.size() - d;
    const MatrixXd v = scale_.asDiagonal() * eigen_.eigenvectors().rightCols(k);
    return v * eigen_.eigenvalues().tail(k).cwiseInverse().asDiagonal() * v.transpose();
  }

  /// Takes a step with the factor at hand; by how many standard deviations of the observations it leads on.
  double step() {
    VectorXd g_f = VectorXd::Zero(normal_.size()), g_c = VectorXd::Zero(scale_.size());
    for (const Linearisation::Block& block : lin_.blocks) {
      const auto jacobian = lin_.jacobian_of(block);
      for (int c = 0; c < block.column_count; ++c) {
        const int own =
            place_[static_cast<std::size_t>(lin_.columns[static_cast<std::size_t>(block.column_begin + c)])];
        (own >= 0 ? g_f[own] : g_c[-2 - own]) += jacobian.col(c).dot(lin_.residuals.segment(block.row, block.rows));
      }
    }
    const VectorXd d_c = cofactors() * (follow_.transpose() * g_f - g_c), d_f = -solve(g_f) - follow_ * d_c;
    VectorXd step(all_.count());
    for (int u = 0; u < all_.count(); ++u) {
      const int at = place_[u];
      step[u] = at >= 0 ? d_f[at] : d_c[-2 - at];
    }
    apply_step(problem_, all_, step);
    return std::sqrt(std::max(0.0, -g_f.dot(d_f) - g_c.dot(d_c)));
  }

  double sum_of_squares() const { return lin_.sum_of_squares; }
  int degrees_of_freedom() const {
    int rows = lin_.rows - all_.count() + defect();
    for (std::size_t b = 0; b < left_out_.size(); ++b) rows -= left_out_[b] ? lin_.blocks[b].rows : 0;
    return rows;
  }

 private:
  /// N_ff^-1 x.
  MatrixXd solve(const MatrixXd& x) const {
    VectorXd inverse = normal_.scale().cwiseInverse();
    for (const int p : pinned_) inverse[p] = 0;
    return inverse.asDiagonal() * factor_->solve(inverse.asDiagonal() * x);
  }

  Problem& problem_;
  const std::vector<char>& left_out_;
  const std::vector<Component>& components_;
  UnknownIndex all_;
  Linearisation lin_;
  NormalEquations normal_;
  std::shared_ptr<const SparseFactor> factor_;
  std::vector<int> place_;   ///< of each of all_: unknown of the solution, or -2 - number of the component
  std::vector<int> pinned_;  ///< unknowns of the solution that are of c
  MatrixXd follow_;          ///< N_ff^-1 N_fc
  VectorXd scale_;
  linear_algebra::SymmetricEigen eigen_;  ///< of S, scaled
};

}  // namespace

std::optional<Marginal> marginal_of(Problem& problem, const Solution& solution, const std::vector<char>& left_out,
                                    const std::vector<Component>& components) {
  constexpr int kMost = 20;                          // steps
  constexpr double kStill = 1e-6, kRounding = 1e-2;  // standard deviations of the observations
  if (components.empty() || solution.datum.defect() > 0) return std::nullopt;
  const Freed freed(problem, components);
  Rest rest(problem, solution, left_out, components);
  if (!rest.factorise() || !rest.linearise()) return std::nullopt;
  rest.reduce();
  double before = std::numeric_limits<double>::infinity();
  for (int k = 0;; ++k) {
    stop_point();
    const double length = rest.step();
    if (!std::isfinite(length) || !rest.linearise()) return std::nullopt;
    if (length < kStill || (length < kRounding && length > 0.5 * before)) break;
    if (k == kMost || length > before) return std::nullopt;
    before = length;
  }
  Marginal result;
  result.values.resize(static_cast<Index>(components.size()));
  for (std::size_t k = 0; k < components.size(); ++k)
    result.values[static_cast<Index>(k)] =
        problem.parameters[components[k].block].value[static_cast<std::size_t>(components[k].component)];
  result.cofactors = rest.cofactors();
  result.null_space = rest.null_space();
  result.sum_of_squares = rest.sum_of_squares();
  result.degrees_of_freedom = rest.degrees_of_freedom();
  return result;
}

}  // namespace plumbline::least_squares

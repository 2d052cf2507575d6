// The same block, minimised by Ceres. Before every evaluation Ceres calls back, and its values become a State: so the
// cost functions are those of terms.hpp, and nothing is written twice.
#include <ceres/cost_function.h>
#include <ceres/covariance.h>
#include <ceres/evaluation_callback.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <memory>
#include <stdexcept>

#include "photo/bundle/adjust.hpp"
#include "photo/bundle/ceres_covariance.hpp"
#include "plumbline/rigid_transform.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::bundle {
namespace {

/// Quaternion (w, x, y, z) and position, stepped as Layout says. Cost functions give derivatives in the step itself, so
/// the derivative of the step is the unit matrix as far as Ceres has to know.
class PlacementManifold : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* step, double* result) const override {
    const Eigen::Quaterniond q = (quaternion_from_rotation_vector(Eigen::Map<const Eigen::Vector3d>(step + 3)) *
                                  Eigen::Quaterniond(x[0], x[1], x[2], x[3]))
                                     .normalized();
    result[0] = q.w(), result[1] = q.x(), result[2] = q.y(), result[3] = q.z();
    for (int i = 0; i < 3; ++i) result[4 + i] = x[4 + i] + step[i];
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> j(jacobian);
    j.setZero();
    j.topRows<6>().setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* difference) const override {
    const Eigen::Quaterniond q =
        Eigen::Quaterniond(y[0], y[1], y[2], y[3]) * Eigen::Quaterniond(x[0], x[1], x[2], x[3]).conjugate();
    for (int i = 0; i < 3; ++i) difference[i] = y[4 + i] - x[4 + i];
    Eigen::Map<Eigen::Vector3d>(difference + 3) = 2 * (q.w() < 0 ? -1 : 1) * q.vec();
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> j(jacobian);
    j.setZero();
    j.leftCols<6>().setIdentity();
    return true;
  }
};

/// Ceres' values and the State they stand for.
class Values : public ceres::EvaluationCallback {
 public:
  Values(const Problem& problem, const Layout& layout, const State& start)
      : problem_(problem), layout_(layout), state(start) {
    size_t size = 0;
    for (int b = 0; b < layout.block_count(); ++b) size += static_cast<size_t>(ambient(b));
    // Ceres orders parameters by their addresses: one array keeps that order, and with it the last bits, ours.
    array_.resize(size);
    places_.resize(layout.block_count());
    double* next = array_.data();
    for (int b = 0; b < layout.block_count(); ++b) {
      places_[b] = next;
      next += ambient(b);
      exchange(b, true);
    }
  }
  int ambient(int block) const {
    const Kind kind = layout_.ref(block).kind;
    const int size = layout_.size(block);
    return size == 6 && (kind == Kind::image || kind == Kind::plate || kind == Kind::mount) ? 7 : size;
  }
  double* place(int block) const { return places_[block]; }
  void PrepareForEvaluation(bool, bool new_point) override {
    if (new_point) read();
  }
  void read() {
    for (int b = 0; b < layout_.block_count(); ++b) exchange(b, false);
  }
  const Problem& problem() const { return problem_; }
  const Layout& layout() const { return layout_; }

 private:
  void exchange(int block, bool store) {
    if (layout_.size(block) == 0) return;
    double* x = place(block);
    const Ref ref = layout_.ref(block);
    const size_t i = static_cast<size_t>(ref.index);
    const auto copy = [&](double& value, double& there) { store ? there = value : value = there; };
    if (ref.kind == Kind::image || ref.kind == Kind::plate || ref.kind == Kind::mount) {
      Placement& p = ref.kind == Kind::image   ? state.images[i]
                     : ref.kind == Kind::mount ? state.mounts[i]
                                               : state.plates[i];
      if (store) {
        x[0] = p.rotation.w(), x[1] = p.rotation.x(), x[2] = p.rotation.y(), x[3] = p.rotation.z();
        for (int c = 0; c < 3; ++c) x[4 + c] = p.position(c);
      } else {
        p.set(Eigen::Quaterniond(x[0], x[1], x[2], x[3]), Eigen::Vector3d(x[4], x[5], x[6]));
      }
    } else if (ref.kind == Kind::point) {
      for (int c = 0; c < 3; ++c) copy(state.points[i](c), x[c]);
    } else if (ref.kind == Kind::camera) {
      for (int v : layout_.free_values(ref.index)) copy(state.interiors[i][v], *x++);
    } else if (ref.kind == Kind::shift || ref.kind == Kind::bend) {
      Eigen::Vector2d& pair = ref.kind == Kind::shift ? state.shifts[i] : state.bends[i];
      for (int c = 0; c < 2; ++c) copy(pair(c), x[c]);
    } else if (ref.kind == Kind::form) {
      const int first = problem_.plates[i].form_begin;
      for (int c = 0; c < layout_.size(block); ++c) copy(state.forms[i][first + c], x[c]);
    } else {
      copy(ref.kind == Kind::scale ? state.scales[i] : state.insets[i], *x);
    }
  }

  const Problem& problem_;
  const Layout& layout_;
  std::vector<double> array_;
  std::vector<double*> places_;

 public:
  State state;
};

template <typename Term>
class TermCost : public ceres::CostFunction {
 public:
  TermCost(const Values& values, const Term& term, int rows, std::vector<int> blocks)
      : values_(values), term_(term), blocks_(std::move(blocks)) {
    set_num_residuals(rows);
    for (int b : blocks_) mutable_parameter_block_sizes()->push_back(values.ambient(b));
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    Rows rows;
    if (!evaluate(values_.problem(), values_.layout(), values_.state, term_, jacobians != nullptr, rows)) return false;
    std::copy(rows.residual.begin(), rows.residual.begin() + rows.rows, residuals);
    for (size_t k = 0; jacobians && k < blocks_.size(); ++k) {
      if (!jacobians[k]) continue;
      const int width = parameter_block_sizes()[k];
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> j(jacobians[k], rows.rows,
                                                                                           width);
      j.setZero();
      j.leftCols(rows.part[k].size) = rows.jacobian(static_cast<int>(k));
    }
    return true;
  }

 private:
  const Values& values_;
  const Term& term_;
  std::vector<int> blocks_;
};

class KnownCost : public ceres::CostFunction {
 public:
  KnownCost(const Values& values, const Known& term, const KnownRows& rows) : values_(values), term_(term) {
    set_num_residuals(static_cast<int>(rows.residual.size()));
    for (int b : rows.blocks) mutable_parameter_block_sizes()->push_back(values.ambient(b));
  }
  bool Evaluate(double const* const*, double* residuals, double** jacobians) const override {
    const KnownRows rows = evaluate(values_.problem(), values_.layout(), values_.state, term_);
    Eigen::Map<Eigen::VectorXd>(residuals, rows.residual.size()) = rows.residual;
    for (size_t k = 0; jacobians && k < rows.blocks.size(); ++k) {
      if (!jacobians[k]) continue;
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> j(
          jacobians[k], rows.residual.size(), parameter_block_sizes()[k]);
      j.setZero();
      const int first = values_.layout().offset(rows.blocks[k]), size = values_.layout().size(rows.blocks[k]);
      for (size_t c = 0; c < rows.columns.size(); ++c)
        if (rows.columns[c] >= first && rows.columns[c] < first + size)
          j.col(rows.columns[c] - first) = rows.jacobian.col(static_cast<Eigen::Index>(c));
    }
    return true;
  }

 private:
  const Values& values_;
  const Known& term_;
};

std::unique_ptr<ceres::LossFunction> loss_of(const Loss& loss) {
  switch (loss.kind) {
    case Loss::Kind::huber:
      return std::make_unique<ceres::HuberLoss>(loss.scale);
    case Loss::Kind::cauchy:
      return std::make_unique<ceres::CauchyLoss>(loss.scale);
    case Loss::Kind::tukey:
      return std::make_unique<ceres::TukeyLoss>(loss.scale);
    case Loss::Kind::none:
      break;
  }
  return nullptr;
}

template <typename Term>
void add_terms(const std::vector<Term>& terms, const Values& values, ceres::LossFunction* loss,
               ceres::Problem& problem) {
  Rows rows;
  for (const Term& term : terms) {
    if (!evaluate(values.problem(), values.layout(), values.state, term, true, rows))
      throw std::runtime_error(
          "an observation cannot be computed from the approximate values: its point lies behind the camera or outside "
          "the camera model");
    std::vector<int> blocks;
    std::vector<double*> places;
    for (int k = 0; k < rows.parts; ++k) {
      blocks.push_back(rows.part[k].block);
      places.push_back(values.place(blocks.back()));
    }
    bool robust = false;
    if constexpr (!std::is_same_v<Term, Distance>) robust = term.robust;
    problem.AddResidualBlock(new TermCost<Term>(values, term, rows.rows, blocks), robust ? loss : nullptr, places);
  }
}

constexpr int largest_dense = 3000;  ///< reduced unknowns that Ceres takes as one dense matrix even if they are sparse

class StopIfAsked : public ceres::IterationCallback {
 public:
  ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
    return StopScope::is_asked_for() ? ceres::SOLVER_ABORT : ceres::SOLVER_CONTINUE;
  }
};

/// The block as a problem of Ceres at `state`.
class CeresBlock {
 public:
  CeresBlock(const Problem& problem, const State& state, const MinimiseOptions& options)
      : layout_(problem),
        order_(problem, layout_, options.side, 1, options.reduced),
        values_(problem, layout_, state),
        loss_(loss_of(options.loss)),
        block_(own_nothing(values_)) {
    for (int b = 0; b < layout_.block_count(); ++b) {
      if (layout_.size(b) == 0) continue;
      if (values_.ambient(b) != layout_.size(b))
        block_.AddParameterBlock(values_.place(b), 7, new PlacementManifold);
      else
        block_.AddParameterBlock(values_.place(b), layout_.size(b));
    }
    add_terms(problem.image_points, values_, loss_.get(), block_);
    add_terms(problem.image_tags, values_, loss_.get(), block_);
    add_terms(problem.distances, values_, nullptr, block_);
    for (const Known& term : problem.known) {
      const KnownRows rows = evaluate(problem, layout_, values_.state, term);
      std::vector<double*> places;
      for (int b : rows.blocks) places.push_back(values_.place(b));
      if (!places.empty()) block_.AddResidualBlock(new KnownCost(values_, term, rows), nullptr, places);
    }
  }

  ceres::Solver::Summary solve(const MinimiseOptions& options) {
    ceres::Solver::Options solver;
    solver.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (int b = 0; b < layout_.block_count(); ++b)
      if (layout_.size(b) > 0)
        solver.linear_solver_ordering->AddElementToGroup(values_.place(b), order_.eliminated(b) >= 0 ? 0 : 1);
    if (options.reduced == Reduced::gradients) {
      solver.linear_solver_type = ceres::ITERATIVE_SCHUR;
      solver.preconditioner_type = ceres::SCHUR_JACOBI;
    } else {
      const bool is_small = order_.kept_count() <= largest_dense || order_.factor().analysis().is_dense();
      solver.linear_solver_type = is_small ? ceres::DENSE_SCHUR : ceres::SPARSE_SCHUR;
    }
    solver.num_threads = 1;
    solver.logging_type = ceres::SILENT;
    solver.max_num_iterations = options.max_iterations;
    solver.function_tolerance = options.function_tolerance;
    solver.gradient_tolerance = 1e-14;
    solver.parameter_tolerance = options.step_tolerance;
    StopIfAsked stop;
    solver.callbacks.push_back(&stop);
    ceres::Solver::Summary found;
    ceres::Solve(solver, &block_, &found);
    stop_point();
    values_.read();
    return found;
  }

  std::vector<Eigen::MatrixXd> covariances(const std::vector<int>& blocks) {
    ceres::Covariance::Options options;
    options.algorithm_type = ceres::SPARSE_QR;
    options.num_threads = 1;
    ceres::Covariance covariance(options);
    std::vector<std::pair<const double*, const double*>> pairs;
    for (int b : blocks) pairs.emplace_back(values_.place(b), values_.place(b));
    if (!covariance.Compute(pairs, &block_)) throw std::runtime_error("Ceres finds the block rank deficient");
    std::vector<Eigen::MatrixXd> found;
    for (int b : blocks) {
      found.emplace_back(layout_.size(b), layout_.size(b));
      covariance.GetCovarianceBlockInTangentSpace(values_.place(b), values_.place(b), found.back().data());
    }
    return found;
  }

  const State& state() const { return values_.state; }

 private:
  static ceres::Problem::Options own_nothing(Values& values) {
    ceres::Problem::Options options;
    options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    options.evaluation_callback = &values;
    return options;
  }

  const Layout layout_;
  const Elimination order_;
  Values values_;
  std::unique_ptr<ceres::LossFunction> loss_;
  ceres::Problem block_;
};

}  // namespace

MinimiseSummary minimise_ceres(const Problem& problem, State& state, const MinimiseOptions& options) {
  CeresBlock block(problem, state, options);
  const ceres::Solver::Summary found = block.solve(options);
  state = block.state();
  return {found.termination_type == ceres::CONVERGENCE, static_cast<int>(found.iterations.size()),
          2 * found.initial_cost, 2 * found.final_cost, found.message};
}

std::vector<Eigen::MatrixXd> covariances_by_ceres(const Problem& problem, const State& state,
                                                  const std::vector<int>& blocks) {
  return CeresBlock(problem, state, {}).covariances(blocks);
}

}  // namespace plumbline::bundle

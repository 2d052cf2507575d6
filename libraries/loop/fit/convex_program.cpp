#include "loop/fit/convex_program.hpp"

#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include "plumbline/stop.hpp"

namespace plumbline::loop {
namespace {

constexpr double kIpoptInfinity = 1e19;  // Ipopt's nlp_upper_bound_inf

/// The program as Ipopt asks for it. Everything is constant but the gradient and the values of the rows.
class Program : public Ipopt::TNLP {
 public:
  Program(const ConvexProgram& program, ConvexOptimum& optimum) : program_(program), optimum_(optimum) {
    for (int k = 0; k < program.quadratic.outerSize(); ++k)
      for (Eigen::SparseMatrix<double>::InnerIterator it(program.quadratic, k); it; ++it)
        if (it.row() >= it.col()) lower_triangle_.emplace_back(it.row(), it.col(), it.value());
  }

  bool get_nlp_info(Ipopt::Index& n, Ipopt::Index& m, Ipopt::Index& jacobian, Ipopt::Index& hessian,
                    IndexStyleEnum& style) override {
    n = static_cast<Ipopt::Index>(program_.linear.size()), m = static_cast<Ipopt::Index>(program_.rows.rows());
    jacobian = static_cast<Ipopt::Index>(program_.rows.nonZeros());
    hessian = static_cast<Ipopt::Index>(lower_triangle_.size());
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Ipopt::Index n, Ipopt::Number* x_low, Ipopt::Number* x_high, Ipopt::Index m, Ipopt::Number* low,
                       Ipopt::Number* high) override {
    const auto copy = [](const Eigen::VectorXd& from, Ipopt::Index count, Ipopt::Number* to) {
      for (Ipopt::Index i = 0; i < count; ++i) to[i] = std::clamp(from[i], -kIpoptInfinity, kIpoptInfinity);
    };
    copy(program_.x_low, n, x_low), copy(program_.x_high, n, x_high);
    copy(program_.low, m, low), copy(program_.high, m, high);
    return true;
  }

  bool get_starting_point(Ipopt::Index n, bool, Ipopt::Number* x, bool, Ipopt::Number*, Ipopt::Number*, Ipopt::Index,
                          bool, Ipopt::Number*) override {
    std::fill_n(x, n, 0.0);
    return true;
  }

  bool eval_f(Ipopt::Index n, const Ipopt::Number* x, bool, Ipopt::Number& value) override {
    const Eigen::Map<const Eigen::VectorXd> at(x, n);
    value = at.dot(0.5 * (program_.quadratic * at) + program_.linear) + program_.constant;
    return true;
  }
  bool eval_grad_f(Ipopt::Index n, const Ipopt::Number* x, bool, Ipopt::Number* gradient) override {
    Eigen::Map<Eigen::VectorXd>(gradient, n) =
        program_.quadratic * Eigen::Map<const Eigen::VectorXd>(x, n) + program_.linear;
    return true;
  }
  bool eval_g(Ipopt::Index n, const Ipopt::Number* x, bool, Ipopt::Index m, Ipopt::Number* values) override {
    Eigen::Map<Eigen::VectorXd>(values, m) = program_.rows * Eigen::Map<const Eigen::VectorXd>(x, n);
    return true;
  }
  bool eval_jac_g(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Index, Ipopt::Index, Ipopt::Index* row,
                  Ipopt::Index* column, Ipopt::Number* values) override {
    int i = 0;
    for (int k = 0; k < program_.rows.outerSize(); ++k)
      for (Eigen::SparseMatrix<double, Eigen::RowMajor>::InnerIterator it(program_.rows, k); it; ++it, ++i) {
        if (values)
          values[i] = it.value();
        else
          row[i] = static_cast<Ipopt::Index>(it.row()), column[i] = static_cast<Ipopt::Index>(it.col());
      }
    return true;
  }
  bool eval_h(Ipopt::Index, const Ipopt::Number*, bool, Ipopt::Number factor, Ipopt::Index, const Ipopt::Number*, bool,
              Ipopt::Index, Ipopt::Index* row, Ipopt::Index* column, Ipopt::Number* values) override {
    for (std::size_t i = 0; i < lower_triangle_.size(); ++i) {
      if (values)
        values[i] = factor * lower_triangle_[i].value();
      else
        row[i] = lower_triangle_[i].row(), column[i] = lower_triangle_[i].col();
    }
    return true;
  }

  bool intermediate_callback(Ipopt::AlgorithmMode, Ipopt::Index iteration, Ipopt::Number, Ipopt::Number, Ipopt::Number,
                             Ipopt::Number, Ipopt::Number, Ipopt::Number, Ipopt::Number, Ipopt::Number, Ipopt::Index,
                             const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    optimum_.iterations = iteration;
    return !StopScope::is_asked_for();
  }

  void finalize_solution(Ipopt::SolverReturn, Ipopt::Index n, const Ipopt::Number* x, const Ipopt::Number* z_low,
                         const Ipopt::Number* z_high, Ipopt::Index m, const Ipopt::Number*, const Ipopt::Number* lambda,
                         Ipopt::Number value, const Ipopt::IpoptData*, Ipopt::IpoptCalculatedQuantities*) override {
    optimum_.x = Eigen::Map<const Eigen::VectorXd>(x, n), optimum_.y = Eigen::Map<const Eigen::VectorXd>(lambda, m);
    optimum_.z = Eigen::Map<const Eigen::VectorXd>(z_high, n) - Eigen::Map<const Eigen::VectorXd>(z_low, n);
    optimum_.value = value;
  }

 private:
  const ConvexProgram& program_;
  ConvexOptimum& optimum_;
  std::vector<Eigen::Triplet<double>> lower_triangle_;
};

/// `predictor_corrector`: Mehrotra's steps, which nothing holds back: fewest of them, but on some programs they go
/// round and round.
Ipopt::ApplicationReturnStatus solve(const ConvexProgram& program, bool predictor_corrector, ConvexOptimum& optimum) {
  const Ipopt::SmartPtr<Ipopt::TNLP> nlp = new Program(program, optimum);
  const Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = new Ipopt::IpoptApplication(false);
  ipopt->Options()->SetIntegerValue("print_level", 0);
  ipopt->Options()->SetStringValue("sb", "yes");
  ipopt->Options()->SetStringValue("option_file_name", "");  // an ipopt.opt of the folder it runs in is nobody's wish
  ipopt->Options()->SetStringValue("hessian_constant", "yes");
  ipopt->Options()->SetStringValue("jac_c_constant", "yes");
  ipopt->Options()->SetStringValue("jac_d_constant", "yes");
  ipopt->Options()->SetStringValue("mehrotra_algorithm", predictor_corrector ? "yes" : "no");
  ipopt->Options()->SetStringValue("fixed_variable_treatment", "make_constraint");  // keeps their multipliers
  ipopt->Options()->SetNumericValue("bound_relax_factor", 0);
  // Excess is nothing or little at the optimum, and its price is high: from Ipopt's own start (10, 10, 0.2) it takes a
  // good third more iterations.
  ipopt->Options()->SetNumericValue("bound_mult_init_val", 100);
  ipopt->Options()->SetNumericValue("bound_push", 0.1);
  ipopt->Options()->SetNumericValue("bound_frac", 0.01);
  // Approximate minimum degree orders these programs better than what MUMPS would choose, and what their steps are off
  // by is refined only where it is too much.
  ipopt->Options()->SetIntegerValue("mumps_pivot_order", 0);
  ipopt->Options()->SetIntegerValue("min_refinement_steps", 0);
  ipopt->Options()->SetNumericValue("tol", 1e-9);
  ipopt->Options()->SetIntegerValue("max_iter", predictor_corrector ? 100 : 1000);
  if (ipopt->Initialize("") != Ipopt::Solve_Succeeded) throw std::runtime_error("Ipopt does not start");
  return ipopt->OptimizeTNLP(nlp);
}

}  // namespace

ConvexOptimum minimise(const ConvexProgram& program) {
  ConvexOptimum optimum;
  Ipopt::ApplicationReturnStatus status = Ipopt::Internal_Error;
  for (const bool predictor_corrector : {true, false}) {
    optimum = {};
    status = solve(program, predictor_corrector, optimum);
    stop_point();
    if (status == Ipopt::Solve_Succeeded || status == Ipopt::Solved_To_Acceptable_Level) return optimum;
  }
  throw std::runtime_error("Ipopt found no optimum of " + std::to_string(program.linear.size()) + " unknowns and " +
                           std::to_string(program.rows.rows()) + " rows; its status is " + std::to_string(status));
}

OptimalityGap optimality_gap(const ConvexProgram& program, const ConvexOptimum& optimum) {
  OptimalityGap gap;
  const Eigen::VectorXd values = program.rows * optimum.x;
  const Eigen::VectorXd gradient =
      program.quadratic * optimum.x + program.linear + program.rows.transpose() * optimum.y + optimum.z;
  gap.stationarity = gradient.cwiseAbs().maxCoeff();
  const auto look = [&](const Eigen::VectorXd& at, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                        const Eigen::VectorXd& multiplier) {
    for (Eigen::Index i = 0; i < at.size(); ++i) {
      gap.feasibility = std::max({gap.feasibility, low[i] - at[i], at[i] - high[i]});
      if (low[i] == high[i]) continue;  // any multiplier will do for an equation
      const double up = std::max(0.0, multiplier[i]), down = std::max(0.0, -multiplier[i]);
      if (std::isfinite(high[i]))
        gap.complementarity = std::max(gap.complementarity, up * std::abs(high[i] - at[i]));
      else
        gap.sign = std::max(gap.sign, up);
      if (std::isfinite(low[i]))
        gap.complementarity = std::max(gap.complementarity, down * std::abs(at[i] - low[i]));
      else
        gap.sign = std::max(gap.sign, down);
    }
  };
  look(values, program.low, program.high, optimum.y);
  look(optimum.x, program.x_low, program.x_high, optimum.z);
  return gap;
}

}  // namespace plumbline::loop

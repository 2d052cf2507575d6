// Convex quadratic programs, solved by Ipopt (Waechter and Biegler 2006; Debian's coinor-libipopt, EPL).
#pragma once

#include <Eigen/Core>
#include <Eigen/SparseCore>

namespace plumbline::loop {

/// minimise 1/2 x'Qx + c'x + constant subject to low <= A x <= high, x_low <= x <= x_high. Q symmetric (both triangles) and
/// positive semidefinite; infinities: no limit; low == high: an equation.
struct ConvexProgram {
  Eigen::SparseMatrix<double> quadratic;  ///< Q
  Eigen::VectorXd linear;                 ///< c
  Eigen::SparseMatrix<double, Eigen::RowMajor> rows;
  Eigen::VectorXd low, high, x_low, x_high;
  double constant = 0;
};

struct ConvexOptimum {
  Eigen::VectorXd x;
  /// Multipliers with Qx + c + A'y + z = 0: positive where an upper limit holds, negative where a lower one does.
  Eigen::VectorXd y, z;
  double value = 0;
  int iterations = 0;
};

/// Throws std::runtime_error with Ipopt's status if there is no optimum, and plumbline::Stopped if nobody waits for it
/// any more.
ConvexOptimum minimise(const ConvexProgram& program);

/// Largest violation of the optimality conditions (Karush, Kuhn and Tucker), each in its own unit.
struct OptimalityGap {
  double stationarity = 0, feasibility = 0, complementarity = 0, sign = 0;
};
OptimalityGap optimality_gap(const ConvexProgram& program, const ConvexOptimum& optimum);

}  // namespace plumbline::loop

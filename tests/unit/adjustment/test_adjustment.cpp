// The least-squares core on small problems whose answers are known by other means: dense formulas, published values,
// symmetry.
#include <Eigen/Dense>
#include <cmath>

#include "least_squares/problem/reliability.hpp"
#include "least_squares/problem/solver.hpp"
#include "test_support.hpp"

namespace plumbline::least_squares {
namespace {

/// v = A x - l for one scalar block of parameters.
class LinearResidual : public ResidualBlock {
 public:
  LinearResidual(Eigen::MatrixXd a, Eigen::VectorXd l) : a_(std::move(a)), l_(std::move(l)) {}
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
    const Eigen::Map<const Eigen::VectorXd> x(values[0], a_.cols());
    Eigen::Map<Eigen::VectorXd>(residuals, a_.rows()) = a_ * x - l_;
    if (jacobians[0])
      Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(jacobians[0], a_.rows(), a_.cols()) = a_;
    return true;
  }

 private:
  Eigen::MatrixXd a_;
  Eigen::VectorXd l_;
};

/// Distance between two plane points.
class DistanceResidual : public ResidualBlock {
 public:
  explicit DistanceResidual(double distance) : distance_(distance) {}
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
    const Eigen::Vector2d d = Eigen::Vector2d(values[1]) - Eigen::Vector2d(values[0]);
    const double s = d.norm();
    if (s < 1e-9) return false;
    residuals[0] = s - distance_;
    for (int k = 0; k < 2; ++k) {
      if (jacobians[0]) jacobians[0][k] = -d[k] / s;
      if (jacobians[1]) jacobians[1][k] = d[k] / s;
    }
    return true;
  }

 private:
  double distance_;
};

/// v = exp(k t) - l: Gauss-Newton overshoots from a poor start.
class ExponentialResidual : public ResidualBlock {
 public:
  ExponentialResidual(double t, double l) : t_(t), l_(l) {}
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
    residuals[0] = std::exp(values[0][0] * t_) - l_;
    if (jacobians[0]) jacobians[0][0] = t_ * std::exp(values[0][0] * t_);
    return true;
  }

 private:
  double t_, l_;
};

/// v = A x - l of several scalars, each a block of parameters.
class ChainResidual : public ResidualBlock {
 public:
  ChainResidual(Eigen::MatrixXd a, Eigen::VectorXd l) : a_(std::move(a)), l_(std::move(l)) {}
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
    for (Eigen::Index r = 0; r < a_.rows(); ++r) {
      residuals[r] = -l_[r];
      for (Eigen::Index k = 0; k < a_.cols(); ++k) {
        residuals[r] += a_(r, k) * values[k][0];
        if (jacobians[k]) jacobians[k][r] = a_(r, k);
      }
    }
    return true;
  }

 private:
  Eigen::MatrixXd a_;
  Eigen::VectorXd l_;
};

Problem linear_problem(const Eigen::MatrixXd& a, const Eigen::VectorXd& l, const Eigen::MatrixXd& covariance) {
  Problem problem;
  problem.parameters.push_back({"x", std::vector<double>(a.cols(), 0.0), {}});
  auto block = std::make_unique<LinearResidual>(a, l);
  block->set_covariance(covariance);
  block->parameters = {0};
  problem.residuals.push_back(std::move(block));
  return problem;
}

/// Four points of a plane trilateration network, all six distances, a small misfit in one; defect 3.
Problem trilateration(double misfit = 0.004) {
  Problem problem;
  const double points[4][2] = {{0, 0}, {100, 0}, {100, 80}, {0, 80}};
  for (const auto& p : points)
    problem.parameters.push_back({"P" + std::to_string(problem.parameters.size()), {p[0] + 0.01 * p[1], p[1]}, {}});
  for (int i = 0; i < 4; ++i)
    for (int j = i + 1; j < 4; ++j) {
      const double exact = std::hypot(points[j][0] - points[i][0], points[j][1] - points[i][1]);
      auto block = std::make_unique<DistanceResidual>(exact + (i == 1 && j == 3 ? misfit : 0.0));
      block->set_sigmas(Eigen::VectorXd::Constant(1, 0.002));
      block->parameters = {i, j};
      problem.residuals.push_back(std::move(block));
    }
  return problem;
}

std::vector<int> all_unknowns(int count) {
  std::vector<int> result(count);
  for (int i = 0; i < count; ++i) result[i] = i;
  return result;
}

TEST(Adjustment, LinearModelWithFullCovarianceEqualsTheDenseFormula) {
  Eigen::MatrixXd a(6, 2);
  a << 1, 0, 1, 1, 1, 2, 1, 3, 1, 4, 1, 5;
  Eigen::VectorXd l(6);
  l << 1.1, 2.9, 5.2, 7.1, 8.8, 11.3;
  Eigen::MatrixXd c = 0.04 * Eigen::MatrixXd::Identity(6, 6);
  for (int i = 0; i + 1 < 6; ++i) c(i, i + 1) = c(i + 1, i) = 0.015;
  Problem problem = linear_problem(a, l, c);
  const Solution s = solve(problem, {});
  const Eigen::MatrixXd p = c.inverse();
  const Eigen::MatrixXd q = (a.transpose() * p * a).inverse();
  const Eigen::VectorXd x = q * a.transpose() * p * l, v = a * x - l;
  ASSERT_TRUE(s.converged);
  EXPECT_NEAR(problem.parameters[0].value[0], x[0], 1e-12);
  EXPECT_NEAR(problem.parameters[0].value[1], x[1], 1e-12);
  EXPECT_LT((cofactor_matrix(s) - q).norm(), 1e-14);
  EXPECT_NEAR(s.sum_of_squares(), v.dot(p * v), 1e-10);

  const Reliability rel = compute_reliability(problem, s, Cofactors(s), {});
  const Eigen::MatrixXd qvv = c - a * q * a.transpose(), pqp = p * qvv * p;
  for (int i = 0; i < 6; ++i) {
    EXPECT_NEAR(rel.rows[i].redundancy_number, (qvv * p)(i, i), 1e-12);
    EXPECT_NEAR(rel.rows[i].w, (p * v)[i] / std::sqrt(pqp(i, i)), 1e-10);
    EXPECT_NEAR(rel.rows[i].mdb, 4.1319 / std::sqrt(pqp(i, i)), 1e-4);
    EXPECT_NEAR(rel.rows[i].residual, v[i], 1e-12);
  }
  EXPECT_NEAR(rel.sum_of_redundancy_numbers, 4, 1e-12);
  EXPECT_EQ(rel.blocks[0].rank, 4);  // the residuals of the only block have the rank of the whole redundancy
}

TEST(Adjustment, FreeNetworkEqualsThePseudoInverse) {
  Problem problem = trilateration();
  SolverOptions options;
  options.datum_unknowns = all_unknowns(8);
  const Solution s = solve(problem, options);
  ASSERT_TRUE(s.converged);
  EXPECT_EQ(s.datum.defect(), 3);
  EXPECT_EQ(s.degrees_of_freedom(), 1);
  // Dense: N+ of the unscaled normal matrix is the cofactor matrix of total trace minimum (Mittermayer 1972). The
  // constraints are those of the initial values, so the comparison starts at the solution.
  const Solution again = solve(problem, options);
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(6, 8);
  for (const auto& block : again.linearisation.blocks)
    for (int k = 0; k < block.column_count; ++k)
      a(block.row, again.linearisation.columns[block.column_begin + k]) = again.linearisation.jacobian_of(block)(0, k);
  const Eigen::MatrixXd n = a.transpose() * a;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
  decomposition.setThreshold(1e-10);
  decomposition.compute(n);
  const Eigen::MatrixXd pseudo = decomposition.pseudoInverse();
  EXPECT_LT((cofactor_matrix(again) - pseudo).cwiseAbs().maxCoeff(), 1e-9 * pseudo.cwiseAbs().maxCoeff());
  const Reliability rel = compute_reliability(problem, again, Cofactors(pseudo), {});
  for (size_t b = 0; b < rel.blocks.size(); ++b) {  // a block of one row is tested as the row is
    EXPECT_EQ(rel.blocks[b].rank, 1);
    EXPECT_NEAR(rel.blocks[b].statistic, rel.rows[b].w * rel.rows[b].w, 1e-9);
  }
}

TEST(Adjustment, InnerConstraintsStayRelativeToTheInitialValues) {
  Problem problem = trilateration(0.5);
  std::vector<double> before;
  for (const auto& p : problem.parameters) before.insert(before.end(), p.value.begin(), p.value.end());
  SolverOptions options;
  options.datum_unknowns = all_unknowns(8);
  const Solution s = solve(problem, options);
  double east = 0, north = 0, turn = 0;
  for (int i = 0; i < 4; ++i) {
    const auto& now = problem.parameters[i].value;
    const double de = now[0] - before[2 * i], dn = now[1] - before[2 * i + 1];
    east += de;
    north += dn;
    turn += before[2 * i + 1] * de - before[2 * i] * dn;
  }
  EXPECT_GT(s.iterations(), 2);
  EXPECT_NEAR(east, 0, 1e-10);
  EXPECT_NEAR(north, 0, 1e-10);
  EXPECT_NEAR(turn, 0, 1e-7);
}

TEST(Adjustment, STransformationLeadsToTheCofactorsOfTheOtherDatum) {
  SolverOptions all, two;
  all.datum_unknowns = all_unknowns(8);
  two.datum_unknowns = {0, 1, 2, 3};
  Problem first = trilateration();
  solve(first, all);
  const Solution a = solve(first, all), b = solve(first, two);
  const Eigen::MatrixXd moved = s_transform(cofactor_matrix(a), a.datum.null_space(), two.datum_unknowns);
  EXPECT_LT((moved - cofactor_matrix(b)).cwiseAbs().maxCoeff(), 1e-9 * moved.cwiseAbs().maxCoeff());
}

TEST(Adjustment, MissingDatumNamesTheOpenDirections) {
  Problem problem = trilateration();
  try {
    solve(problem, {});
    FAIL() << "a free network without datum was accepted";
  } catch (const RankDefect& defect) {
    EXPECT_EQ(defect.directions.cols(), 3);
  }
  SolverOptions one_point;
  one_point.datum_unknowns = {0, 1};
  try {
    solve(problem, one_point);
    FAIL() << "one point cannot hold a rotation";
  } catch (const RankDefect& defect) {
    // P0 is held: only the rotation about it is left, or directions that contain it.
    EXPECT_GE(defect.directions.cols(), 1);
  }
}

TEST(Adjustment, UnobservedUnknownIsADefect) {
  Problem problem = trilateration();
  problem.parameters.push_back({"lonely", {1.0}, {}});
  SolverOptions options;
  options.datum_unknowns = all_unknowns(8);
  try {
    solve(problem, options);
    FAIL() << "an unknown without observation was accepted";
  } catch (const RankDefect& defect) {
    ASSERT_EQ(defect.directions.cols(), 1);
    EXPECT_NEAR(std::abs(defect.directions(8, 0)), 1, 1e-6);
    EXPECT_LT(defect.directions.topRows(8).cwiseAbs().maxCoeff(), 1e-6);
  }
}

Problem growth() {
  Problem problem;
  problem.parameters.push_back({"k", {-3.0}, {}});
  for (int t = 1; t <= 5; ++t) {
    auto block = std::make_unique<ExponentialResidual>(t, std::exp(0.7 * t));
    block->set_sigmas(Eigen::VectorXd::Constant(1, 0.1));
    block->parameters = {0};
    problem.residuals.push_back(std::move(block));
  }
  return problem;
}

/// The limit is one of steps that are taken: those that were tried with too little damping do not use it up.
TEST(Adjustment, RefusedStepsAreNoIterations) {
  Problem problem = growth();
  const int taken = solve(problem, {}).iterations();
  problem = growth();
  SolverOptions options;
  options.max_iterations = taken + 1;  // and one that finds that there is nothing left
  EXPECT_TRUE(solve(problem, options).converged);
  problem = growth();
  options.max_iterations = taken / 2;
  const Solution half = solve(problem, options);
  EXPECT_FALSE(half.converged);
  EXPECT_EQ(half.iterations(), taken / 2);
}

TEST(Adjustment, NeverAcceptsARisingSumOfSquares) {
  Problem problem = growth();
  const Solution s = solve(problem, {});
  for (size_t k = 1; k < s.sums_of_squares.size(); ++k) EXPECT_LE(s.sums_of_squares[k], s.sums_of_squares[k - 1]);
  EXPECT_TRUE(s.converged);
  EXPECT_NEAR(problem.parameters[0].value[0], 0.7, 1e-9);
}

/// v = f(b, x) - y of one observation, with derivatives of the formula.
class CurveResidual : public ResidualBlock {
 public:
  using Curve = double (*)(const double* b, double x, double* by_b);
  CurveResidual(Curve curve, double x, double y) : curve_(curve), x_(x), y_(y) { set_sigmas(Eigen::VectorXd::Ones(1)); }
  bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
    double unused[4];
    residuals[0] = curve_(values[0], x_, jacobians[0] ? jacobians[0] : unused) - y_;
    return std::isfinite(residuals[0]);
  }

 private:
  Curve curve_;
  double x_, y_;
};

double rising(const double* b, double x, double* d) {  // Misra1a, BoxBOD
  const double e = std::exp(-b[1] * x);
  d[0] = 1 - e, d[1] = b[0] * x * e;
  return b[0] * (1 - e);
}
double rational(const double* b, double x, double* d) {  // MGH09
  const double top = x * x + x * b[1], bottom = x * x + x * b[2] + b[3];
  d[0] = top / bottom, d[1] = b[0] * x / bottom;
  d[3] = -b[0] * top / (bottom * bottom), d[2] = x * d[3];
  return b[0] * top / bottom;
}

/// Certified values of NIST's Statistical Reference Datasets for nonlinear regression: Misra1a from its farther start,
/// the two of high difficulty from the nearer one (from the farther, BoxBOD ends on a plateau, and MGH09 is refused as
/// undetermined).
TEST(Adjustment, NistNonlinearRegressions) {
  struct Dataset {
    const char* name;
    CurveResidual::Curve curve;
    std::vector<double> x, y, start, certified, sigmas;
    double sum_of_squares;
  };
  const std::vector<Dataset> all = {
      {"Misra1a",
       rising,
       {77.6, 114.9, 141.1, 190.8, 239.9, 289.0, 332.8, 378.4, 434.8, 477.3, 536.8, 593.1, 689.1, 760.0},
       {10.07, 14.73, 17.94, 23.93, 29.61, 35.18, 40.02, 44.82, 50.76, 55.05, 61.01, 66.40, 75.47, 81.78},
       {500, 1e-4},
       {2.3894212918e+02, 5.5015643181e-04},
       {2.7070075241e+00, 7.2668688436e-06},
       1.2455138894e-01},
      {"BoxBOD",
       rising,
       {1, 2, 3, 5, 7, 10},
       {109, 149, 149, 191, 213, 224},
       {100, 0.75},
       {2.1380940889e+02, 5.4723748542e-01},
       {1.2354515176e+01, 1.0455993237e-01},
       1.1680088766e+03},
      {"MGH09",
       rational,
       {4, 2, 1, 0.5, 0.25, 0.167, 0.125, 0.1, 0.0833, 0.0714, 0.0625},
       {0.1957, 0.1947, 0.1735, 0.16, 0.0844, 0.0627, 0.0456, 0.0342, 0.0323, 0.0235, 0.0246},
       {0.25, 0.39, 0.415, 0.39},
       {1.9280693458e-01, 1.9128232873e-01, 1.2305650693e-01, 1.3606233068e-01},
       {1.1435312227e-02, 1.9633220911e-01, 8.0842031232e-02, 9.0025542308e-02},
       3.0750560385e-04}};
  for (const Dataset& data : all) {
    SCOPED_TRACE(data.name);
    Problem problem;
    problem.parameters.push_back({"b", data.start, {}});
    for (size_t i = 0; i < data.x.size(); ++i) {
      problem.residuals.push_back(std::make_unique<CurveResidual>(data.curve, data.x[i], data.y[i]));
      problem.residuals.back()->parameters = {0};
    }
    SolverOptions options;
    options.max_iterations = 1000;
    options.step_tolerance = 1e-10 * std::sqrt(data.sum_of_squares);
    const Solution s = solve(problem, options);
    EXPECT_TRUE(s.converged);
    EXPECT_NEAR(s.sum_of_squares(), data.sum_of_squares, 1e-9 * data.sum_of_squares);
    const Eigen::MatrixXd cofactors = cofactor_matrix(s);
    for (size_t k = 0; k < data.start.size(); ++k) {
      EXPECT_NEAR(problem.parameters[0].value[k], data.certified[k], 1e-7 * data.certified[k]);
      const auto at = static_cast<Eigen::Index>(k);
      EXPECT_NEAR(std::sqrt(cofactors(at, at) * s.sum_of_squares() / s.degrees_of_freedom()), data.sigmas[k],
                  1e-6 * data.sigmas[k]);
    }
    for (size_t k = 1; k < s.sums_of_squares.size(); ++k) EXPECT_LE(s.sums_of_squares[k], s.sums_of_squares[k - 1]);
  }
}

TEST(Adjustment, ConstantComponentsAreNoUnknowns) {
  Problem problem = trilateration();
  problem.parameters[0].constant = {true, true};
  problem.parameters[1].constant = {false, true};
  const Solution s = solve(problem, {});
  EXPECT_EQ(s.unknowns.count(), 5);
  EXPECT_EQ(s.datum.defect(), 0);
  EXPECT_EQ(problem.parameters[0].value[0], 0.0);
  EXPECT_EQ(problem.parameters[1].value[1], 0.0);
  const Reliability rel = compute_reliability(problem, s, Cofactors(s), {});
  EXPECT_NEAR(rel.sum_of_redundancy_numbers, 1, 1e-9);
}

/// A chain of `n` unknowns, each a block of its own; as many as make a sparse system.
Problem chain(int n) {
  Problem problem;
  for (int i = 0; i < n; ++i) problem.parameters.push_back({"x" + std::to_string(i), {0.0}, {}});
  for (int i = 0; i + 2 < n; ++i) {
    Eigen::MatrixXd a(2, 3);
    a << -1, 1, 0, -1, 0, 1.5;
    auto block = std::make_unique<ChainResidual>(a, Eigen::Vector2d(1, 2));
    block->set_sigmas(Eigen::Vector2d(0.1 + 0.01 * i, 0.2));
    block->parameters = {i, i + 1, i + 2};
    problem.residuals.push_back(std::move(block));
  }
  return problem;
}

TEST(Adjustment, SparseInverseEqualsTheDenseInverse) {
  // Long enough for several batches of right sides, with pins and a shift.
  const int n = 161;
  Problem problem = chain(n);
  const UnknownIndex unknowns(problem);
  Linearisation lin = prepare_linearisation(problem, unknowns);
  ASSERT_TRUE(linearise(problem, unknowns, true, lin));
  NormalEquations normal(lin, unknowns);
  normal.assemble(lin);
  ASSERT_FALSE(normal.analysis()->is_dense());
  SparseFactor factor;
  ASSERT_TRUE(factor.factorise(normal, 1e-3, {4, 17}));
  Eigen::MatrixXd dense = normal.multiply_scaled(Eigen::MatrixXd::Identity(n, n));
  EXPECT_LT((dense.diagonal().array() - 1).abs().maxCoeff(), 1e-14);
  for (int p : {4, 17}) {
    dense.row(p).setZero();
    dense.col(p).setZero();
    dense(p, p) = 1;
  }
  dense.diagonal().array() += 1e-3;
  EXPECT_LT((factor.inverse() * dense - Eigen::MatrixXd::Identity(n, n)).cwiseAbs().maxCoeff(), 1e-9);
  const Eigen::MatrixXd b = Eigen::MatrixXd::Random(n, 11);
  EXPECT_LT((dense * factor.solve(b) - b).cwiseAbs().maxCoeff(), 1e-9);
}

/// Everything that is asked of cofactors is the same whether they are whole or not, in a free network too.
TEST(Adjustment, CofactorsOnDemandAreThoseOfTheWhole) {
  for (const bool free : {true, false}) {
    Problem problem = free ? trilateration() : chain(161);
    SolverOptions options;
    if (free) {
      // As often as makes it sparse: squares side by side, the corner of each tied to the next by distances.
      problem = Problem{};
      const int squares = 30;
      const auto add_distance = [&](int from, int to) {
        const auto &a = problem.parameters[from].value, &b = problem.parameters[to].value;
        auto block =
            std::make_unique<DistanceResidual>(std::hypot(a[0] - b[0], a[1] - b[1]) + 1e-4 * ((from + to) % 3));
        block->set_sigmas(Eigen::VectorXd::Constant(1, 0.001 * (1 + (from + to) % 4)));
        block->parameters = {from, to};
        problem.residuals.push_back(std::move(block));
      };
      for (int i = 0; i <= squares; ++i)
        for (int k = 0; k < 2; ++k) {
          problem.parameters.push_back({"P", {10.0 * i + 0.3 * k, 10.0 * k + 0.2 * (i % 3)}, {}});
          const int last = static_cast<int>(problem.parameters.size()) - 1;
          for (int before = std::max(0, last - 3 - k); before < last; ++before) add_distance(before, last);
        }
      for (int u = 0; u < 20; ++u) options.datum_unknowns.push_back(u);
    } else {
      for (int at : {0, 160}) {
        auto block = std::make_unique<LinearResidual>(Eigen::MatrixXd::Ones(1, 1), Eigen::VectorXd::Ones(1));
        block->set_sigmas(Eigen::VectorXd::Constant(1, 0.1));
        block->parameters = {at};
        problem.residuals.push_back(std::move(block));
      }
    }
    const Solution s = solve(problem, options);
    ASSERT_EQ(s.datum.defect(), free ? 3 : 0);
    const Cofactors whole(s), sparse(s, 10);
    ASSERT_TRUE(whole.is_whole());
    ASSERT_FALSE(sparse.is_whole());
    const Eigen::MatrixXd& q = whole.whole();
    const int n = sparse.size();
    const double size = q.cwiseAbs().maxCoeff();
    const std::vector<int> met = {3, 2, 4}, apart = {n - 1, 0, n / 2};
    EXPECT_TRUE(sparse.has(met));
    EXPECT_FALSE(sparse.has(apart));
    for (const auto& unknowns : {met, apart})
      EXPECT_LT((sparse.joint(unknowns) - whole.joint(unknowns)).cwiseAbs().maxCoeff(), 1e-11 * size);
    EXPECT_NEAR(sparse(n - 1, 1), q(n - 1, 1), 1e-11 * size);
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, -1, 2);
    EXPECT_LT((sparse.times(x) - q * x).cwiseAbs().maxCoeff(), 1e-10 * (q * x).cwiseAbs().maxCoeff());
    std::vector<Functional> functionals;
    for (int k = 0; k < 130; ++k) functionals.push_back({{k % n, 1.0}, {(7 * k + 3) % n, -0.5}});
    const Eigen::VectorXd a = whole.variances(functionals), b = sparse.variances(functionals);
    EXPECT_LT((a - b).cwiseAbs().maxCoeff(), 1e-11 * size);
    Cofactors scaled = sparse;
    scaled.multiply(4);
    EXPECT_DOUBLE_EQ(scaled(2, 3), 4 * sparse(2, 3));
    EXPECT_THROW(scaled.whole(), std::logic_error);
    ReliabilityOptions with_groups;
    with_groups.groups.resize(n);
    for (int u = 0; u < n; ++u) with_groups.groups[u] = {u};
    const Reliability ra = compute_reliability(problem, s, whole, with_groups),
                      rb = compute_reliability(problem, s, sparse, with_groups);
    for (size_t r = 0; r < ra.rows.size(); ++r) {
      EXPECT_NEAR(ra.rows[r].redundancy_number, rb.rows[r].redundancy_number, 1e-9);
      EXPECT_NEAR(ra.rows[r].w, rb.rows[r].w, 1e-6 * (1 + std::abs(ra.rows[r].w)));
      if (!std::isfinite(ra.rows[r].mdb)) continue;
      EXPECT_LE(rb.rows[r].external_effect, ra.rows[r].external_effect * (1 + 1e-6)) << "of its own points only";
    }
    EXPECT_NEAR(ra.sum_of_redundancy_numbers, s.degrees_of_freedom(), 1e-7);
    EXPECT_NEAR(rb.sum_of_redundancy_numbers, s.degrees_of_freedom(), 1e-7);
  }
}

TEST(Adjustment, CriticalValuesOfTheField) {
  EXPECT_NEAR(non_centrality(0.001, 0.8), 4.132, 1e-3);
  EXPECT_NEAR(non_centrality(0.05, 0.8), 2.802, 1e-3);
  EXPECT_NEAR(non_centrality(0.01, 0.8), 3.418, 1e-3);
  EXPECT_NEAR(confidence_factor(0.95, 1), 1.960, 1e-3);
  EXPECT_NEAR(confidence_factor(0.95, 2), 2.448, 1e-3);
  EXPECT_NEAR(confidence_factor(0.95, 3), 2.796, 1e-3);
  EXPECT_NEAR(global_test(50, 47, 0.05).lower, 29.96, 5e-3);
  EXPECT_NEAR(global_test(50, 47, 0.05).upper, 67.82, 5e-3);
  EXPECT_EQ(global_test(10, 47, 0.05).verdict, GlobalTest::Verdict::low);
  EXPECT_EQ(global_test(90, 47, 0.05).verdict, GlobalTest::Verdict::high);
  EXPECT_NEAR(tau_critical(0.05, 10), std::sqrt(10.0) * 2.262157 / std::sqrt(9 + 2.262157 * 2.262157), 1e-5);
}

/// Of a covariance that is rotated and has three different axes, its axes and not their complements come back.
TEST(Adjustment, AxesOfTheErrorEllipsoidPointAlongTheErrors) {
  const Eigen::Matrix3d turn =
      (Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()) * Eigen::AngleAxisd(-1.1, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  const Eigen::Vector3d sigma(5, 2, 0.5);  // along the columns of `turn`
  const Eigen::Matrix3d covariance = turn * sigma.cwiseAbs2().asDiagonal() * turn.transpose();
  const ErrorEllipsoid ellipsoid = error_ellipsoid(covariance);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(ellipsoid.semi_axes[k], sigma[k], 1e-12) << k;
    EXPECT_NEAR(std::abs(ellipsoid.axes.col(k).dot(turn.col(k))), 1, 1e-12) << k;
    // Along its axis the standard deviation is the semi-axis: from the covariance itself.
    EXPECT_NEAR(std::sqrt(ellipsoid.axes.col(k).dot(covariance * ellipsoid.axes.col(k))), ellipsoid.semi_axes[k],
                1e-12);
  }
}

/// A refused step leaves nothing behind: values, residuals and their sum are those of before. A slope of the wrong sign
/// makes every step rise.
TEST(Adjustment, ARefusedStepLeavesEverythingAsItWas) {
  class WrongSlope : public ResidualBlock {
   public:
    bool evaluate(const double* const* values, double* residuals, double* const* jacobians) const override {
      residuals[0] = values[0][0] - 5, residuals[1] = 2 * values[0][0] - 11;
      if (jacobians[0]) jacobians[0][0] = -1, jacobians[0][1] = -2;
      return true;
    }
  };
  Problem problem;
  problem.parameters.push_back({"x", {3.0}, {}});
  auto block = std::make_unique<WrongSlope>();
  block->set_sigmas(Eigen::Vector2d(0.5, 0.5));
  block->parameters = {0};
  problem.residuals.push_back(std::move(block));
  const Solution s = solve(problem, {});
  EXPECT_FALSE(s.converged);
  EXPECT_EQ(s.sums_of_squares.size(), 1u) << "none was taken";
  EXPECT_EQ(problem.parameters[0].value[0], 3.0);
  ASSERT_EQ(s.linearisation.residuals.size(), 2);
  EXPECT_NEAR(s.linearisation.residuals(0), -4, 1e-12) << "whitened: (3 - 5) / 0.5";
  EXPECT_NEAR(s.linearisation.residuals(1), -10, 1e-12);
  EXPECT_NEAR(s.sum_of_squares(), 116, 1e-12);
}

TEST(Adjustment, SigmasAndCovariancesAreChecked) {
  LinearResidual block(Eigen::MatrixXd::Ones(2, 1), Eigen::Vector2d(1, 2));
  EXPECT_THROW(block.set_sigmas(Eigen::Vector2d(1, 0)), std::invalid_argument);
  EXPECT_THROW(block.set_sigmas(Eigen::Vector2d(1, NAN)), std::invalid_argument);
  Eigen::Matrix2d c;
  c << 1, 2, 2, 1;
  EXPECT_THROW(block.set_covariance(c), std::invalid_argument);
  c << 1, 0.2, 0.1, 1;
  EXPECT_THROW(block.set_covariance(c), std::invalid_argument);
  EXPECT_THROW(block.set_covariance(1e-6 * c), std::invalid_argument) << "in metres as in millimetres";
}

}  // namespace
}  // namespace plumbline::least_squares

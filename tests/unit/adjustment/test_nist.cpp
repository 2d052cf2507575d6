// Published nonlinear regressions.
#include "least_squares/problem/reliability.hpp"
#include "least_squares/problem/solver.hpp"
#include "test_support.hpp"

namespace plumbline::least_squares {
namespace test_nist {

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

}  // namespace test_nist
}  // namespace plumbline::least_squares

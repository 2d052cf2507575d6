// Repeated simulated networks: the covariance the adjustment reports is the one its errors have, and a blunder is found
// as often as its minimal detectable size says. 100 networks here; PLUMBLINE_LONG=1 runs 1000.
#include <Eigen/Dense>
#include <cstdlib>

#include "geometry/statistics.hpp"
#include "simulated_network.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_monte_carlo {

int trials() { return std::getenv("PLUMBLINE_LONG") ? 1000 : 100; }

TEST(MonteCarlo, CovarianceCoversTheErrors) {
  AdjustOptions options;
  options.curvature = Switch::off;
  double heights = 0, sum_of_squares = 0;
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  int degrees = 0;
  const int n = trials();
  for (int trial = 0; trial < n; ++trial) {
    const auto network = test::simulate({}, 1000 + static_cast<std::uint64_t>(trial));
    // Approximations are the truth, so the inner constraints refer errors to it.
    const NetworkResult r = adjust_network(network.survey, options);
    const ResultPoint& a = r.point("M03");
    const ResultPoint& b = r.point("M21");
    const Eigen::Vector3d error = b.position - a.position - (network.truth[9] - network.truth[3]);
    const Eigen::Matrix3d covariance = r.relative_covariance(a, b);
    squares += error.cwiseAbs2().cwiseQuotient(covariance.diagonal());
    heights += error.dot(covariance.ldlt().solve(error));
    sum_of_squares += r.sum_of_squares;
    degrees += r.degrees_of_freedom;
  }
  // Sums of independent chi-squared variables: bounds of 0.1 % each side.
  for (int k = 0; k < 3; ++k) {
    EXPECT_GT(squares[k], chi_squared_quantile(0.001, n));
    EXPECT_LT(squares[k], chi_squared_quantile(0.999, n));
  }
  EXPECT_GT(heights, chi_squared_quantile(0.001, 3 * n));
  EXPECT_LT(heights, chi_squared_quantile(0.999, 3 * n));
  EXPECT_GT(sum_of_squares, chi_squared_quantile(0.001, degrees));
  EXPECT_LT(sum_of_squares, chi_squared_quantile(0.999, degrees));
}

/// All markers at once and one by one, in the datum of the markers: every block of the full covariance is what the
/// errors have, correlations included.
TEST(MonteCarlo, FullCovarianceOfAllMarkersCoversTheErrors) {
  constexpr int kMarkers = 12;
  AdjustOptions options;
  options.curvature = Switch::off;
  options.datum = DatumMode::inner;
  const int n = trials();
  double joint = 0;
  int rank = 0;
  std::vector<double> each(kMarkers);
  Eigen::MatrixXd empirical = Eigen::MatrixXd::Zero(3 * kMarkers, 3 * kMarkers), reported = empirical;
  for (int trial = 0; trial < n; ++trial) {
    const auto network = test::simulate({}, 9000 + static_cast<std::uint64_t>(trial));
    options.datum_points.clear();
    for (int m = 0; m < kMarkers; ++m) options.datum_points.push_back(network.survey.points[m].id);
    const NetworkResult r = adjust_network(network.survey, options);
    Eigen::VectorXd error(3 * kMarkers);
    Eigen::MatrixXd covariance(3 * kMarkers, 3 * kMarkers);
    for (int i = 0; i < kMarkers; ++i) {
      const ResultPoint& p = r.point(options.datum_points[i]);
      error.segment<3>(3 * i) = p.position - network.truth[i];
      for (int k = 0; k < kMarkers; ++k)
        covariance.block<3, 3>(3 * i, 3 * k) = r.covariance(p, r.point(options.datum_points[k]));
      each[i] +=
          error.segment<3>(3 * i).dot(covariance.block<3, 3>(3 * i, 3 * i).ldlt().solve(error.segment<3>(3 * i)));
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(covariance);
    for (int k = 0; k < 3 * kMarkers; ++k) {
      if (eigen.eigenvalues()[k] < 1e-9 * eigen.eigenvalues()[3 * kMarkers - 1]) continue;
      joint += std::pow(eigen.eigenvectors().col(k).dot(error), 2) / eigen.eigenvalues()[k];
      ++rank;
    }
    empirical += error * error.transpose() / n;
    reported += covariance / n;
  }
  EXPECT_EQ(rank, n * (3 * kMarkers - 4));
  EXPECT_GT(joint, chi_squared_quantile(0.001, rank));
  EXPECT_LT(joint, chi_squared_quantile(0.999, rank));
  for (int i = 0; i < kMarkers; ++i) {
    EXPECT_GT(each[i], chi_squared_quantile(0.0005, 3 * n)) << i;
    EXPECT_LT(each[i], chi_squared_quantile(0.9995, 3 * n)) << i;
  }
  // Variance of any difference of two coordinates: relative standard deviation sqrt(2 / n); 630 of them, 5 sigma.
  const double tolerance = 5 * std::sqrt(2.0 / n);
  for (int i = 0; i < 3 * kMarkers; ++i)
    for (int k = 0; k < i; ++k) {
      const double found = empirical(i, i) + empirical(k, k) - 2 * empirical(i, k);
      const double said = reported(i, i) + reported(k, k) - 2 * reported(i, k);
      EXPECT_NEAR(found / said, 1, tolerance) << i << " " << k;
    }
}

TEST(MonteCarlo, BlundersAreFoundAsOftenAsTheirMdbSays) {
  constexpr double kBlunder = 0.005;
  constexpr size_t kRow = 20;  // a slope distance
  AdjustOptions options;
  options.curvature = Switch::off;
  int found = 0;
  double expected = 0;
  const int n = trials();
  for (int trial = 0; trial < n; ++trial) {
    auto network = test::simulate({}, 5000 + static_cast<std::uint64_t>(trial));
    network.survey.observations[kRow].value += kBlunder;
    const NetworkResult r = adjust_network(network.survey, options);
    const auto& s = r.rows[kRow].statistics;
    found += std::abs(s.w) > r.critical_w;
    // A blunder of size mdb shifts w by delta0.
    const double shift = least_squares::non_centrality(options.alpha0, options.power) * kBlunder / s.mdb;
    expected += 1 - normal_probability(r.critical_w - shift) + normal_probability(-r.critical_w - shift);
  }
  const double p = expected / n, sigma = std::sqrt(n * p * (1 - p));
  EXPECT_NEAR(found, expected, 3.3 * sigma + 0.5);
}

}  // namespace test_monte_carlo
}  // namespace plumbline::survey

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "geometry/random.hpp"
#include "loop/gate/inside_probability.hpp"

namespace plumbline::loop {
namespace test_inside_probability {

double by_sampling(const Eigen::VectorXd& mean, const Eigen::MatrixXd& root, const Eigen::VectorXd& low,
                   const Eigen::VectorXd& high, int samples, std::uint64_t seed) {
  Random random(seed, "sampling");
  int inside = 0;
  for (int s = 0; s < samples; ++s) {
    Eigen::VectorXd z(root.cols());
    for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = random.normal();
    const Eigen::VectorXd v = mean + root * z;
    inside += (v.array() >= low.array()).all() && (v.array() <= high.array()).all();
  }
  return static_cast<double>(inside) / samples;
}

struct Case {
  Eigen::VectorXd mean, low, high;
  Eigen::MatrixXd root;  ///< covariance = root root'
};

/// Up to 24 values of up to 12 variables: singular as those of a panel are.
Case random_case(std::uint64_t seed) {
  Random random(seed, "case");
  const auto values = static_cast<Eigen::Index>(2 + random.uniform() * 23);
  const auto variables = std::min(values, static_cast<Eigen::Index>(1 + random.uniform() * 12));
  Case c;
  c.root.resize(values, variables), c.mean.resize(values);
  for (Eigen::Index i = 0; i < values; ++i) {
    for (Eigen::Index j = 0; j < variables; ++j) c.root(i, j) = random.normal();
    c.root.row(i) /= c.root.row(i).norm();
    c.mean[i] = random.normal(0.8);
  }
  c.high = Eigen::VectorXd::Constant(values, random.uniform(1.2, 4.0)), c.low = -c.high;
  return c;
}

TEST(InsideProbability, AgreesWithBruteForceForSingularCovariances) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Case c = random_case(seed);
    const double sampled = by_sampling(c.mean, c.root, c.low, c.high, 200000, seed);
    // Four standard deviations of the sampling and 0.003 of the lattice.
    EXPECT_NEAR(inside_probability(c.mean, c.root * c.root.transpose(), c.low, c.high), sampled,
                4 * std::sqrt(sampled * (1 - sampled) / 200000) + 0.003)
        << "seed " << seed << ", " << c.root.rows() << " values of " << c.root.cols() << " variables";
  }
}

TEST(InsideProbability, OfIndependentValuesIsTheProduct) {
  const Eigen::Vector3d mean(0.3, -1, 0.2), high(1, 2, 1.5);
  const Eigen::Vector3d s(0.5, 1.2, 0.9);
  double product = 1;
  for (int i = 0; i < 3; ++i)
    product *= normal_below((high[i] - mean[i]) / s[i]) - normal_below((-high[i] - mean[i]) / s[i]);
  EXPECT_NEAR(inside_probability(mean, s.cwiseProduct(s).asDiagonal(), -high, high), product, 1e-6);
}

TEST(InsideProbability, OfTwoCopiesIsThatOfOne) {
  const Eigen::Vector2d mean(0.4, 0.4), high(1, 1);
  EXPECT_NEAR(inside_probability(mean, Eigen::Matrix2d::Ones(), -high, high), normal_below(0.6) - normal_below(-1.4),
              1e-6);
}

TEST(InsideProbability, WithoutVarianceIsZeroOrOne) {
  const Eigen::Vector2d mean(0.4, -0.4), high(1, 1);
  EXPECT_EQ(inside_probability(mean, Eigen::Matrix2d::Zero(), -high, high), 1);
  EXPECT_EQ(inside_probability(2 * mean / 0.4, Eigen::Matrix2d::Zero(), -high, high), 0);
}

TEST(InsideProbability, IsNanWithoutNumbers) {
  const Eigen::Vector2d mean(0.4, std::nan("")), high(1, 1);
  EXPECT_TRUE(std::isnan(inside_probability(mean, Eigen::Matrix2d::Identity(), -high, high)));
}

TEST(InsideProbability, TheQuantileInvertsPhi) {
  for (const double p : {1e-12, 1e-4, 0.02, 0.3, 0.5, 0.77, 0.98, 1 - 1e-9})
    EXPECT_NEAR(normal_below(normal_quantile(p)), p, 1e-14);
}

}  // namespace test_inside_probability
}  // namespace plumbline::loop

// Registration against known transforms, and its covariances against the errors that it makes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <cmath>

#include "control/registration/rigid_registration.hpp"

namespace plumbline::registration {
namespace test_rigid_registration {

using testing::HasSubstr;

class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  double uniform() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return (static_cast<double>((z ^ (z >> 31)) >> 11) + 0.5) * 0x1.0p-53;
  }
  double normal() {
    const double u = uniform(), v = uniform();
    return std::sqrt(-2 * std::log(u)) * std::cos(2 * M_PI * v);
  }
  Eigen::VectorXd normals(Eigen::Index n) {
    Eigen::VectorXd v(n);
    for (Eigen::Index i = 0; i < n; ++i) v[i] = normal();
    return v;
  }

 private:
  std::uint64_t state_;
};

const RigidTransform motion{quaternion_from_rotation_vector({0.4, -0.2, 1.1}), {12.0, -7.0, 3.5}};

/// Two columns of a facade, 6 m apart, `rows` points each.
Eigen::Matrix3Xd facade(int rows) {
  Eigen::Matrix3Xd p(3, 2 * rows);
  for (int i = 0; i < 2 * rows; ++i) p.col(i) << 6.0 * (i % 2), 0.1 * std::sin(3.0 * i), 1.7 * (i / 2);
  return p;
}

Correspondences exact(const Eigen::Matrix3Xd& points, const RigidTransform& t, double scale = 1) {
  Correspondences c;
  for (Eigen::Index i = 0; i < points.cols(); ++i) c.ids.push_back("P" + std::to_string(i));
  c.source = points;
  c.target = ((scale * t.rotation.toRotationMatrix()) * points).colwise() + t.translation;
  return c;
}

/// A covariance with correlations between all coordinates.
Eigen::MatrixXd correlated(Eigen::Index n, double sigma, std::uint64_t seed) {
  Random random(seed);
  Eigen::MatrixXd m(n, n);
  for (Eigen::Index i = 0; i < n; ++i) m.col(i) = random.normals(n);
  return sigma * sigma * (m * m.transpose() / static_cast<double>(n) + 0.3 * Eigen::MatrixXd::Identity(n, n));
}

Eigen::Matrix3Xd noisy(const Eigen::Matrix3Xd& p, const Eigen::MatrixXd& covariance, Random& random) {
  const Eigen::VectorXd e = covariance.llt().matrixL() * random.normals(covariance.rows());
  return p + Eigen::Map<const Eigen::Matrix3Xd>(e.data(), 3, p.cols());
}

/// Error of an estimate in the tangent that its covariance is meant in.
Eigen::VectorXd error_of(const Registration& found, const RigidTransform& truth, double scale = 1) {
  Eigen::VectorXd e(found.unknowns);
  const Eigen::AngleAxisd turn(found.to_from_from.rotation * truth.rotation.conjugate());
  e.head<3>() = turn.angle() * turn.axis();
  e.segment<3>(3) = found.to_from_from.translation - truth.translation;
  if (found.unknowns == 7) e[6] = found.scale - scale;
  return e;
}

std::string failure_of(const Correspondences& c, const Options& options = {}) {
  try {
    register_points(c, options);
  } catch (const DegenerateRegistration& error) {
    return error.what();
  }
  return "";
}

TEST(Registration, RecoversMotionAndScale) {
  for (const auto weighting : {Weighting::equal, Weighting::scalar, Weighting::covariance})
    for (const bool with_scale : {false, true}) {
      Correspondences c = exact(facade(4), motion, with_scale ? 1.002 : 1.0);
      c.source_covariance = correlated(24, 0.001, 3);
      c.target_covariance = correlated(24, 0.002, 4);
      const Registration found = register_points(c, {.weighting = weighting, .estimate_scale = with_scale});
      EXPECT_LT(error_of(found, motion, with_scale ? 1.002 : 1.0).norm(), 1e-11);
      EXPECT_LT(found.residuals.cwiseAbs().maxCoeff(), 1e-12);
    }
}

TEST(Registration, WithEqualWeightsIsTheSameAsWithEqualCovariances) {
  Random random(5);
  Correspondences c = exact(facade(4), motion);
  c.target = noisy(c.target, 1e-6 * Eigen::MatrixXd::Identity(24, 24), random);
  const Registration closed = register_points(c, {});
  c.target_covariance = 1e-6 * Eigen::MatrixXd::Identity(24, 24);
  const Registration iterated = register_points(c, {.weighting = Weighting::covariance});
  const Registration scalar = register_points(c, {.weighting = Weighting::scalar});
  EXPECT_LT((closed.residuals - iterated.residuals).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((closed.residuals - scalar.residuals).cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_LT((closed.covariance / (closed.sigma0 * closed.sigma0) - iterated.covariance / 1e-6).cwiseAbs().maxCoeff(),
            1e-6);
}

TEST(Registration, LeavesResidualsThatSumToZeroWithEqualWeights) {
  Random random(6);
  Correspondences c = exact(facade(5), motion);
  c.target = noisy(c.target, 1e-6 * Eigen::MatrixXd::Identity(30, 30), random);
  EXPECT_LT(register_points(c, {}).residuals.rowwise().sum().norm(), 1e-12);
}

TEST(Registration, ResidualCovarianceIsBiasedAsPrintedAndUnbiasedWithItsDegreesOfFreedom) {
  Random random(7);
  const int trials = 400, n = 6;
  double printed = 0, corrected = 0;
  for (int k = 0; k < trials; ++k) {
    Correspondences c = exact(facade(n / 2), motion);
    c.target = noisy(c.target, 1e-6 * Eigen::MatrixXd::Identity(3 * n, 3 * n), random);
    const Registration found = register_points(c, {});
    printed += found.residual_covariance.trace() / 3e-6 / trials;
    corrected += found.residual_covariance_unbiased.trace() / 3e-6 / trials;
  }
  EXPECT_NEAR(printed, (3.0 * n - 6) / (3.0 * (n - 1)), 0.04);  // 0.80
  EXPECT_NEAR(corrected, 1.0, 0.05);
}

TEST(Registration, CovariancesCoverTheErrorsOfTransformAndMovedPoints) {
  for (const auto weighting : {Weighting::equal, Weighting::covariance}) {
    Random random(8);
    const int trials = 150;
    double transform = 0, points = 0, sigma0 = 0;
    // Six of eight points take part; the covariance of the source correlates all.
    const Eigen::Matrix3Xd all = facade(4);
    const Correspondences truth = exact(all, motion);
    const std::vector<int> fitted = {0, 1, 3, 4, 6, 7};
    const Eigen::MatrixXd source_covariance = correlated(24, 0.001, 11), target_covariance = correlated(18, 0.001, 12);
    for (int k = 0; k < trials; ++k) {
      const Eigen::Matrix3Xd measured = noisy(all, source_covariance, random);
      Correspondences c;
      c.source.resize(3, 6), c.target.resize(3, 6), c.source_covariance.resize(18, 18);
      for (int i = 0; i < 6; ++i) {
        c.ids.push_back(truth.ids[fitted[i]]);
        c.source.col(i) = measured.col(fitted[i]);
        c.target.col(i) = truth.target.col(fitted[i]);
        for (int j = 0; j < 6; ++j)
          c.source_covariance.block<3, 3>(3 * i, 3 * j) = source_covariance.block<3, 3>(3 * fitted[i], 3 * fitted[j]);
      }
      c.target_covariance = target_covariance;
      c.target = noisy(c.target, target_covariance, random);
      const Registration found = register_points(c, {.weighting = weighting});
      const Eigen::VectorXd e = error_of(found, motion);
      transform += e.dot(found.covariance.ldlt().solve(e)) / (6.0 * trials);
      const MovedPoints moved = move_points(found, measured, source_covariance, fitted, target_covariance);
      const Eigen::Matrix3Xd difference = moved.positions - truth.target;
      const Eigen::Map<const Eigen::VectorXd> d(difference.data(), 24);
      points += d.dot(moved.covariance.ldlt().solve(d)) / (24.0 * trials);
      sigma0 += found.sigma0 * found.sigma0 / trials;
    }
    EXPECT_NEAR(transform, 1, 0.2);
    EXPECT_NEAR(points, 1, 0.1);
    if (weighting == Weighting::covariance) {
      EXPECT_NEAR(sigma0, 1, 0.15);
    }
  }
}

/// The same network in another datum: C' = (I + A L) C (I + A L)'. What a transform takes out says nothing about
/// points.
TEST(Registration, TheDatumThatTheSourceIsStatedInChangesNothing) {
  for (const auto weighting : {Weighting::scalar, Weighting::covariance})
    for (const int unknowns : {6, 7}) {
      Random random(15);
      Correspondences c = exact(facade(4), motion);
      c.source_covariance = correlated(24, 0.001, 3);
      c.target_covariance = correlated(24, 0.002, 4);
      c.target = noisy(c.target, c.target_covariance, random);
      Eigen::MatrixXd a(24, unknowns), l(unknowns, 24);
      for (int i = 0; i < 8; ++i) {
        a.block<3, 3>(3 * i, 0) = Eigen::Matrix3d::Identity();
        a.block<3, 3>(3 * i, 3) = -skew(c.source.col(i));
        if (unknowns == 7) a.block<3, 1>(3 * i, 6) = c.source.col(i);
      }
      for (Eigen::Index k = 0; k < l.size(); ++k) l(k) = 0.3 * random.normal();
      const Eigen::MatrixXd other = Eigen::MatrixXd::Identity(24, 24) + a * l;
      Correspondences d = c;
      d.source_covariance = other * c.source_covariance * other.transpose();
      const Options options{.weighting = weighting, .estimate_scale = unknowns == 7};
      const Registration one = register_points(c, options), two = register_points(d, options);
      EXPECT_LT((one.residuals - two.residuals).cwiseAbs().maxCoeff(), 1e-11);
      EXPECT_NEAR(one.sigma0, two.sigma0, 1e-6);
      const std::vector<int> all = {0, 1, 2, 3, 4, 5, 6, 7};
      const Eigen::MatrixXd of_one =
          move_points(one, c.source, c.source_covariance, all, c.target_covariance).covariance;
      const Eigen::MatrixXd of_two =
          move_points(two, d.source, d.source_covariance, all, d.target_covariance).covariance;
      EXPECT_LT((of_one - of_two).norm(), 1e-6 * of_one.norm());
      // No other influence G with G A = I gives points of a smaller variance: not that of equal weights, which is one.
      if (weighting == Weighting::covariance) {
        const Registration equal = register_points(c, {.estimate_scale = unknowns == 7});
        EXPECT_LT(of_one.trace(),
                  move_points(equal, c.source, c.source_covariance, all, c.target_covariance).covariance.trace());
      }
    }
}

TEST(Registration, TakesTheSingularCovarianceOfAFreeNetwork) {
  // Inner constraints leave a covariance without the six directions of a motion; the target is without error.
  Correspondences c = exact(facade(3), motion);
  Eigen::MatrixXd g(18, 6);
  for (int i = 0; i < 6; ++i) {
    g.block<3, 3>(3 * i, 0) = Eigen::Matrix3d::Identity();
    g.block<3, 3>(3 * i, 3) = -skew(c.source.col(i));
  }
  const Eigen::MatrixXd projector =
      Eigen::MatrixXd::Identity(18, 18) - g * (g.transpose() * g).ldlt().solve(g.transpose());
  c.source_covariance = 1e-6 * projector;
  c.target += 0.001 * Eigen::Matrix3Xd(c.source).cwiseAbs().unaryExpr([](double v) { return std::sin(17 * v); });
  const Registration found = register_points(c, {.weighting = Weighting::covariance});
  const Registration closed = register_points({c.ids, c.source, c.target, {}, {}}, {});
  EXPECT_LT((found.residuals - closed.residuals).cwiseAbs().maxCoeff(), 1e-9);  // isotropic: the same fit
  EXPECT_EQ(found.degrees_of_freedom, 12);
}

TEST(Registration, IsEquivariantUnderAMotionOfTheTarget) {
  Random random(9);
  Correspondences c = exact(facade(4), {});
  c.target = noisy(c.target, correlated(24, 0.001, 2), random);
  c.target_covariance = 1e-6 * Eigen::MatrixXd::Identity(24, 24);
  c.source_covariance = correlated(24, 0.001, 6);
  const Options options{.weighting = Weighting::covariance, .estimate_scale = true};
  const Registration plain = register_points(c, options);
  const Registration again = register_points(c, options);
  EXPECT_EQ(plain.residuals, again.residuals);
  Correspondences moved = c;
  const RigidTransform far{motion.rotation, {512'345.0, 5'412'678.0, 431.0}};
  moved.target = (far.rotation.toRotationMatrix() * c.target).colwise() + far.translation;
  const Registration there = register_points(moved, options);
  EXPECT_LT((there.residuals - far.rotation.toRotationMatrix() * plain.residuals).cwiseAbs().maxCoeff(), 1e-8);
  EXPECT_NEAR(there.scale, plain.scale, 1e-9);
}

TEST(Registration, NamesTheLineThatPointsLieOn) {
  Eigen::Matrix3Xd column(3, 5);
  for (int i = 0; i < 5; ++i) column.col(i) << 1, 2, 2.0 * i;
  EXPECT_THAT(failure_of(exact(column, motion)),
              testing::AllOf(HasSubstr("lie on a line"), HasSubstr("P0"), HasSubstr("P4")));
  column.row(1) += 0.004 * Eigen::RowVectorXd::Random(5);  // a column is never quite straight
  EXPECT_THAT(failure_of(exact(column, motion)), HasSubstr("rotation about the line through"));
}

TEST(Registration, RefusesTooFewCoincidentAndErrorFreePoints) {
  EXPECT_THAT(failure_of(exact(facade(1), motion)), HasSubstr("at least 3 points"));
  EXPECT_THAT(failure_of(exact(Eigen::Matrix3Xd::Ones(3, 4), motion)), HasSubstr("lie on a line"));
  Correspondences c = exact(facade(3), motion);
  c.source_covariance = Eigen::MatrixXd::Zero(18, 18);
  EXPECT_THAT(failure_of(c, {.weighting = Weighting::covariance}), HasSubstr("singular"));
}

}  // namespace test_rigid_registration
}  // namespace plumbline::registration

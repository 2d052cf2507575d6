// Check points against what block and survey state of them.
#include <gmock/gmock.h>

#include <Eigen/Cholesky>

#include "geometry/random.hpp"
#include "photo/block/check_points.hpp"

namespace plumbline::block {
namespace test_check_points {

using testing::HasSubstr;

/// Five points of 3 mm each, and a shift of 5 mm that they have in common.
Eigen::MatrixXd covariance() {
  Eigen::MatrixXd c = 9e-6 * Eigen::MatrixXd::Identity(15, 15);
  for (int i = 0; i < 15; ++i)
    for (int j = i % 3; j < 15; j += 3) c(i, j) += 25e-6;
  return c;
}

const std::vector<std::string> names{"A", "B", "C", "D", "E"};

Eigen::VectorXd drawn(std::uint64_t seed) {
  Random random(seed);
  Eigen::VectorXd white(15);
  for (double& value : white) value = random.normal();
  return Eigen::MatrixXd(covariance().llt().matrixL()) * white;
}

TEST(CheckPoints, ThatAreAsStatedHoldButOnceInATwoThousand) {
  int fell = 0;
  double nees = 0, freedom = 0;
  for (std::uint64_t k = 0; k < 4000; ++k) {
    const CheckJudgement found = judge_check_points(names, drawn(k), covariance());
    fell += !found.holds;
    nees += found.nees, freedom += found.freedom;
  }
  EXPECT_LE(fell, 18) << "two tests of 0.1 %";
  EXPECT_NEAR(nees / freedom, 1, 0.02);
}

TEST(CheckPoints, OneThatIsOffIsNamedWithWhatItIsOffBy) {
  Eigen::VectorXd d = drawn(3);
  d(6) += 0.05;
  const CheckJudgement found = judge_check_points(names, d, covariance());
  EXPECT_FALSE(found.holds);
  ASSERT_EQ(found.words.size(), 1u);
  EXPECT_THAT(found.words[0], HasSubstr("check point C contradicts the block: it is off by "));
  EXPECT_THAT(found.words[0], HasSubstr("standard deviations of block and survey are 5.8, 5.8, 5.8 mm"));
  EXPECT_EQ(found.freedom, 12) << "the others are judged without it";
}

/// Each within its limit, but all of them too far off for a covariance that is stated twice too small.
TEST(CheckPoints, AllTogetherTellACovarianceThatIsTooSmall) {
  int told = 0;
  for (std::uint64_t k = 0; k < 20; ++k) told += !judge_check_points(names, drawn(k), covariance() / 9).holds;
  EXPECT_EQ(told, 20);
  Eigen::VectorXd white(15);  // 1.75 sigma in each independent error: nothing by itself
  for (int i = 0; i < 15; ++i) white(i) = i % 2 ? 1.75 : -1.75;
  const CheckJudgement found =
      judge_check_points(names, Eigen::MatrixXd(covariance().llt().matrixL()) * white, covariance());
  ASSERT_EQ(found.words.size(), 1u);
  EXPECT_THAT(found.words[0], HasSubstr("the check points together are off by more than"));
}

/// One that is left beside another that contradicts was judged by itself, at the level of both.
TEST(CheckPoints, OneAloneIsNotJudgedAgainTogether) {
  const Eigen::MatrixXd covariance = 1e-6 * Eigen::MatrixXd::Identity(6, 6);
  Eigen::VectorXd off = Eigen::VectorXd::Zero(6);
  off(0) = 0.05, off(5) = 1e-3 * std::sqrt(17.0);  // between the limits of one point and of two: 16.3 and 17.7
  const auto found = judge_check_points({"A", "B"}, off, covariance, true);
  ASSERT_EQ(found.words.size(), 1U) << found.words.back();
  EXPECT_FALSE(found.points[1].contradicts);
}

/// What the points have in common is one error, not five.
TEST(CheckPoints, ACommonShiftCountsOnce) {
  const Eigen::VectorXd shift = Eigen::VectorXd::Constant(15, 0.01);
  EXPECT_TRUE(judge_check_points(names, shift, covariance()).holds);
  EXPECT_FALSE(judge_check_points(names, shift, covariance().diagonal().asDiagonal()).holds);
  EXPECT_TRUE(judge_check_points(names, shift, covariance().diagonal().asDiagonal(), false).holds)
      << "where it is not known, all together are not tested";
}

TEST(CheckPoints, OfCoordinatesThatAreExactAnyDifferenceContradicts) {
  Eigen::MatrixXd none = Eigen::MatrixXd::Zero(3, 3);
  EXPECT_TRUE(judge_check_points({"A"}, Eigen::Vector3d::Zero(), none).holds);
  EXPECT_FALSE(judge_check_points({"A"}, Eigen::Vector3d(1e-3, 0, 0), none).holds);
}

}  // namespace test_check_points
}  // namespace plumbline::block

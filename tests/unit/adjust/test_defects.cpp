#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "geometry/similarity.hpp"
#include "least_squares/problem/defects.hpp"
#include "plumbline/rigid_transform.hpp"

namespace test_defects {

using namespace plumbline;
using least_squares::NamedPoint;

std::vector<NamedPoint> square() { return {{"A", {0, 0, 0}}, {"B", {4, 0, 0}}, {"C", {4, 0, 4}}, {"D", {0, 0, 4}}}; }

TEST(Defects, PlanarMotionsAreNamed) {
  const auto points = square();
  const Eigen::Vector3d centre = least_squares::centre_of(points);
  Eigen::MatrixXd subspace = Eigen::MatrixXd::Zero(7, 2);
  subspace(2, 0) = 1;  // translation along z
  subspace(6, 1) = 1;  // scale
  EXPECT_THAT(least_squares::describe_motions(subspace, centre, 3, points),
              testing::ElementsAre("translation along z", "scale"));
}

TEST(Defects, RotationAboutALineOffTheCentre) {
  const auto points = square();
  const Eigen::Vector3d centre = least_squares::centre_of(points), axis = Eigen::Vector3d::UnitX();
  Eigen::MatrixXd motion = Eigen::MatrixXd::Zero(7, 1);
  motion.block<3, 1>(3, 0) = axis;
  motion.topRows<3>() = axis.cross(centre - points[0].position);  // A and B stay where they are
  EXPECT_THAT(least_squares::describe_motions(motion, centre, 3, points),
              testing::ElementsAre("rotation about the line through A and B"));
}

TEST(Defects, DatumOfThreePointsIsComplete) {
  const auto points = square();
  const std::vector<NamedPoint> fixed(points.begin(), points.begin() + 3);
  const Eigen::MatrixXd motions = least_squares::motion_basis(fixed, least_squares::centre_of(points));
  const auto analysis = least_squares::analyse_datum(1e6 * motions.transpose() * motions, points, fixed, true, 30);
  EXPECT_TRUE(analysis.undetermined.empty());
  EXPECT_TRUE(analysis.weak.empty());
  EXPECT_GT(analysis.weakest_sigma, 0.0005);
  EXPECT_LT(analysis.weakest_sigma, 0.005);
}

TEST(Datum, SimilarityIsRecovered) {
  const SimilarityMotion truth{quaternion_from_rotation_vector({0.4, -2.0, 1.0}), {10, -20, 30}, 1.25};
  std::vector<Eigen::Vector3d> from, to;
  for (int i = 0; i < 6; ++i) {
    from.emplace_back(std::sin(i), std::cos(2.0 * i), 0.3 * i);
    to.push_back(truth * from.back());
  }
  const auto motion = fit_similarity(from, to, true);
  EXPECT_NEAR(motion.scale, 1.25, 1e-12);
  EXPECT_LT((motion.translation - truth.translation).norm(), 1e-12);
  EXPECT_LT(motion.rotation.angularDistance(truth.rotation), 1e-7);
}

}  // namespace test_defects

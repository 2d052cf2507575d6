// Blankenbach and Willert (2009), eight slope distances with two blunders, as in F. Krumm's collection: the plain
// result, the order in which data snooping finds the blunders, and the clean result.
#include "survey/adjust/adjust_network.hpp"
#include "survey/files/krumm.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_blunders {

const char* const kFile = "survey/BlankenbachWillert3D_Distance_fix.dat";

SurveyObservations resection() { return read_krumm(test::read_file(test::data_file(kFile)), "Blankenbach.dat"); }

TEST(BlankenbachWillert, PlainLeastSquares) {
  PLUMBLINE_REQUIRE_DATA(kFile);
  const NetworkResult r = adjust_network(resection(), {});
  EXPECT_LT((r.point("MS").position - Eigen::Vector3d(-2.304237, 24.310094, 9.524782)).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_EQ(r.degrees_of_freedom, 5);
  EXPECT_NEAR(r.sum_of_redundancy_numbers, 5, 1e-6);
}

TEST(BlankenbachWillert, SnoopingFindsBothBlundersInOrder) {
  PLUMBLINE_REQUIRE_DATA(kFile);
  AdjustOptions options;
  options.remove_blunders = true;
  options.largest_removed_share = 0.3;
  const NetworkResult r = adjust_network(resection(), options);
  ASSERT_EQ(r.snooping.size(), 2u);
  EXPECT_EQ(r.rows[r.snooping[0].row].to, "51");
  EXPECT_EQ(r.rows[r.snooping[1].row].to, "103");
  EXPECT_LT((r.point("MS").position - Eigen::Vector3d(-2.507747, 24.320218, 9.775316)).cwiseAbs().maxCoeff(), 1e-6);
  EXPECT_EQ(r.degrees_of_freedom, 3);
}

TEST(BlankenbachWillert, RobustStartComesToTheSameEnd) {
  PLUMBLINE_REQUIRE_DATA(kFile);
  AdjustOptions options;
  options.remove_blunders = true;
  options.robust_start = true;
  options.largest_removed_share = 0.3;
  const NetworkResult r = adjust_network(resection(), options);
  EXPECT_LT((r.point("MS").position - Eigen::Vector3d(-2.507747, 24.320218, 9.775316)).cwiseAbs().maxCoeff(), 1e-6);
}

}  // namespace test_blunders
}  // namespace plumbline::survey

// Networks of GNU Gama's test suite against the results Gama stores beside them. Coordinates agree to 5e-7 m (Gama
// keeps the result of its last linearisation), standard deviations to 1e-3 (relative), sigma0 to 2e-5. In Gama's files
// pvv = m0^2 sum (v / sigma)^2.
#include <cmath>

#include "gama_result.hpp"
#include "survey/adjust/adjust_network.hpp"
#include "survey/files/gama.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_gama_networks {

/// E, N of the axes of the file.
Eigen::Matrix2d axes_of(const std::string& axes) {
  const auto direction = [](char c) {
    return c == 'e'   ? Eigen::Vector2d(1, 0)
           : c == 'n' ? Eigen::Vector2d(0, 1)
           : c == 'w' ? Eigen::Vector2d(-1, 0)
                      : Eigen::Vector2d(0, -1);
  };
  Eigen::Matrix2d m;
  m << direction(axes[0]), direction(axes[1]);
  return m;
}

class GamaNetwork : public testing::TestWithParam<const char*> {};

TEST_P(GamaNetwork, AgreesWithTheStoredResult) {
  const std::string base = std::string("survey/gama/") + GetParam();
  PLUMBLINE_REQUIRE_DATA(base + ".gkf");
  const SurveyObservations survey =
      read_gama_xml(test::read_file(test::data_file(base + ".gkf")), std::string(GetParam()) + ".gkf");
  EXPECT_TRUE(survey.skipped.empty());
  const NetworkResult result = adjust_network(survey, {});
  const GamaResult gama = read_result(test::data_file(base + ".xml"));

  EXPECT_EQ(result.degrees_of_freedom, gama.degrees_of_freedom);
  EXPECT_EQ(result.defect, gama.defect);
  EXPECT_NEAR(result.sum_of_redundancy_numbers, result.degrees_of_freedom, 1e-6);
  const double sigma0 = gama.a_posteriori / gama.a_priori;
  EXPECT_NEAR(result.sigma0, sigma0, 2e-5 * sigma0 + 1e-9);
  EXPECT_NEAR(result.sum_of_squares, gama.sum_of_squares / (gama.a_priori * gama.a_priori),
              4e-5 * gama.sum_of_squares / (gama.a_priori * gama.a_priori) + 1e-12);

  const Eigen::Matrix2d axes = axes_of(survey.info.axes_xy);
  for (const auto& [id, expected] : gama.points) {
    const ResultPoint& p = result.point(id);
    if (!std::isnan(expected.x)) {
      const Eigen::Vector2d plan = axes.transpose() * p.position.head<2>();
      EXPECT_NEAR(plan.x(), expected.x, 5e-7) << id;
      EXPECT_NEAR(plan.y(), expected.y, 5e-7) << id;
    }
    if (!std::isnan(expected.z)) {
      EXPECT_NEAR(p.position.z(), expected.z, 5e-7) << id;
    }
  }
  // Standard deviations, and all covariances relative to them.
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  turn.topLeftCorner<2, 2>() = axes;
  // Where axes and angles differ in handedness Gama turns y round inside, and prints the covariances of that.
  if (survey.info.axes_inconsistent) turn.col(1) *= -1;
  for (size_t i = 0; i < gama.order.size(); ++i)
    for (size_t j = 0; j < gama.order.size(); ++j) {
      const auto& [a, axis_a] = gama.order[i];
      const auto& [b, axis_b] = gama.order[j];
      const Eigen::Matrix3d c = turn.transpose() * result.covariance(result.point(a), result.point(b)) * turn;
      const double ours = c(axis_a - 'x', axis_b - 'x') * 1e6;
      const auto k = static_cast<Eigen::Index>(i), l = static_cast<Eigen::Index>(j);
      const double scale = std::sqrt(gama.covariance(k, k) * gama.covariance(l, l));
      EXPECT_NEAR(ours, gama.covariance(k, l), 2e-3 * scale) << a << axis_a << " " << b << axis_b;
    }
}

INSTANTIATE_TEST_SUITE_P(Survey, GamaNetwork,
                         testing::Values("2020-barta-phase_0-1TK", "2020-barta-phase_1-2TK", "local_3d", "from-to-dh",
                                         "Baumann23_3_4_fix"),
                         [](const auto& network) {
                           std::string name = network.param;
                           for (char& c : name)
                             if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
                           return name;
                         });

TEST(GamaNetworks, FromToHeightsAreExact) {
  PLUMBLINE_REQUIRE_DATA("survey/gama/from-to-dh.gkf");
  const SurveyObservations survey =
      read_gama_xml(test::read_file(test::data_file("survey/gama/from-to-dh.gkf")), "from-to-dh.gkf");
  const NetworkResult result = adjust_network(survey, {});
  EXPECT_LT((result.point("Z").position - Eigen::Vector3d(400, 300, 160)).norm(), 1e-9);
  EXPECT_LT(result.sum_of_squares, 1e-15);
}

}  // namespace test_gama_networks
}  // namespace plumbline::survey

// A real GSI-16 network, 22 set-ups in two faces, as a free network with all points in the datum. The numbers are
// regression values for exactly these standard deviations of the means.
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "survey/adjust/adjust_network.hpp"
#include "survey/files/gsi.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_network_22 {

const char* const kFile = "survey/gsi/network_22_setups.GSI";
constexpr double kCc = std::numbers::pi / 200 * 1e-4;

AdjustOptions options_with(double direction_centring, double zenith_centring) {
  AdjustOptions options;
  options.profile.direction_sigma = options.profile.zenith_sigma = 5 * kCc;
  options.profile.distance_constant = 1e-3;
  options.profile.target_centring = direction_centring;
  options.profile.height_centring = zenith_centring;
  options.profile.distance_centring = 0;
  options.profile.sigmas_of_mean = true;
  options.datum = DatumMode::inner;
  options.curvature = Switch::off;
  return options;
}

NetworkResult adjust(const AdjustOptions& options) {
  return adjust_network(read_gsi(test::read_file(test::data_file(kFile)), "network_22_setups.GSI"), options);
}

const ResultRow& worst(const NetworkResult& r) {
  return *std::max_element(r.rows.begin(), r.rows.end(), [](const ResultRow& a, const ResultRow& b) {
    return std::abs(a.statistics.w) < std::abs(b.statistics.w);
  });
}

TEST(Network22, WithoutCentring) {
  PLUMBLINE_REQUIRE_DATA(kFile);
  const NetworkResult r = adjust(options_with(0, 0));
  EXPECT_EQ(r.observations, 300);
  EXPECT_EQ(r.unknowns, 88);
  EXPECT_EQ(r.defect, 4);
  EXPECT_EQ(r.degrees_of_freedom, 216);
  EXPECT_NEAR(r.sum_of_squares, 1549.674, 0.01);
  EXPECT_NEAR(r.sigma0, 2.67851, 1e-4);
  EXPECT_NEAR(r.sum_of_redundancy_numbers, 216, 1e-6);
  EXPECT_NEAR(std::abs(worst(r).statistics.w), 15.48, 0.01);
  EXPECT_EQ(worst(r).kind, "zenith_angle");
  EXPECT_EQ(worst(r).from + " " + worst(r).to, "BP04 BP03");
}

TEST(Network22, WithCentring) {
  PLUMBLINE_REQUIRE_DATA(kFile);
  // Means with these standard deviations as a file states them: hypot(5 cc, 1.4 mm / h) and hypot(5 cc, 0.7 mm / s).
  SurveyObservations survey = read_gsi(test::read_file(test::data_file(kFile)), "network_22_setups.GSI");
  std::vector<Observation> means;
  std::map<std::tuple<int, std::string>, double> slopes;
  for (const MeanObservation& mean : mean_observations(survey).observations) {
    means.push_back(mean.observation);
    means.back().face = 0;
    if (mean.observation.kind == ObservationKind::slope_distance)
      slopes[{mean.observation.set_up, mean.observation.to}] = mean.observation.value;
  }
  std::map<std::tuple<int, std::string>, double> sines;
  for (const Observation& o : means)
    if (o.kind == ObservationKind::zenith_angle) sines[{o.set_up, o.to}] = std::sin(o.value);
  for (Observation& o : means) {
    const double s = slopes.at({o.set_up, o.to}), h = s * sines.at({o.set_up, o.to});
    o.sigma = o.kind == ObservationKind::direction      ? std::hypot(5 * kCc, 1.4e-3 / h)
              : o.kind == ObservationKind::zenith_angle ? std::hypot(5 * kCc, 0.7e-3 / s)
                                                        : 1e-3;
  }
  survey.observations = means;
  const NetworkResult r = adjust_network(survey, options_with(0, 0));
  EXPECT_NEAR(r.sum_of_squares, 216.429, 0.01);
  EXPECT_NEAR(r.sigma0, 1.00099, 1e-4);
  EXPECT_NEAR(r.sum_of_redundancy_numbers, 216, 1e-6);
  EXPECT_NEAR(std::abs(worst(r).statistics.w), 4.83, 0.01);
  EXPECT_EQ(worst(r).from + " " + worst(r).to, "BP04 BP02");
  // With the targets displaced by as much, which reaches zenith angles of steep sights too, a little less is left.
  const NetworkResult displaced = adjust(options_with(1.4e-3, 0.7e-3));
  EXPECT_NEAR(displaced.sum_of_squares, 214.9, 0.1);
}

// Half the differences of the faces times the sine of the zenith angle, their medians computed from the file's words by
// hand.
TEST(Network22, CollimationOfTheSetUps) {
  PLUMBLINE_REQUIRE_DATA(kFile);
  const NetworkResult r = adjust(options_with(0, 0));
  const auto collimation = [&](const char* id) {
    const auto found = std::find_if(r.set_ups.begin(), r.set_ups.end(), [&](const auto& s) { return s.id == id; });
    return found->collimation.value * 200e3 / std::numbers::pi;  // [mgon]
  };
  EXPECT_NEAR(collimation("BP04"), -1.297, 0.006);
  EXPECT_NEAR(collimation("K1"), 0.112, 0.006);
}

}  // namespace test_network_22
}  // namespace plumbline::survey

// What every node of the role `survey_adjuster` must do: recover the truth without noise, not care where the frame is,
// give the same bits twice, know its own uncertainty, and say clearly what is wrong with a network that cannot be
// adjusted.
#include <Eigen/Dense>

#include "artifacts/points.hpp"
#include "artifacts/survey_artifact.hpp"
#include "artifacts/survey_network.hpp"
#include "artifacts/survey_observations.hpp"
#include "geometry/geodesy/map_projection.hpp"
#include "node_harness.hpp"
#include "parameter_effects.hpp"
#include "simulated_network.hpp"
#include "stopping.hpp"

namespace plumbline {
namespace survey_adjuster_tests {

using survey::test::SimulatedNetwork;
using survey::test::SimulationSettings;

class SurveyAdjuster : public testing::TestWithParam<std::string> {
 protected:
  static PointsT control_of(const SimulatedNetwork& n, const std::vector<size_t>& which, double sigma) {
    PointsT points;
    for (size_t i : which) {
      auto p = std::make_unique<PointT>();
      p->id = n.survey.points[i].id;
      p->position = n.truth[i];
      p->sigma.setConstant(sigma);
      points.points.push_back(std::move(p));
    }
    return points;
  }

  static PointsT adjust(const SimulatedNetwork& n, const PointsT* control = nullptr,
                        std::vector<uint8_t>* bytes = nullptr) {
    test::NodeHarness node(GetParam());
    node.input<SurveyObservations>("observations", survey::to_artifact(n.survey));
    if (control) node.input<Points>("control", *control);
    node.run();
    if (bytes) *bytes = node.output_bytes("points");
    return node.output<Points>("points");
  }

  static Eigen::Vector3d position(const PointsT& points, const std::string& id) {
    for (const auto& p : points.points)
      if (p->id == id) return p->position;
    throw std::runtime_error("no point " + id);
  }
};

TEST_P(SurveyAdjuster, RecoversTheTruthWithoutNoise) {
  SimulationSettings settings;
  settings.noise = 0;
  const auto n = survey::test::simulate(settings, 1);
  const PointsT control = control_of(n, {0, 3, 8}, 0.001);
  const PointsT found = adjust(n, &control);
  // Earth curvature is part of a node's model but not of this simulation: 0.02 mm at these distances.
  for (size_t i = 0; i < n.truth.size(); ++i)
    EXPECT_LT((position(found, n.survey.points[i].id) - n.truth[i]).norm(), 1e-4) << n.survey.points[i].id;
}

TEST_P(SurveyAdjuster, MovesWithItsFrame) {
  auto n = survey::test::simulate({}, 2);
  const PointsT here = adjust(n, nullptr);
  const Eigen::Vector3d shift(1000, -2000, 50);
  for (auto& p : n.survey.points) p.coordinates += shift;
  const PointsT there = adjust(n, nullptr);
  for (const auto& p : here.points) {
    EXPECT_LT((position(there, p->id) - shift - p->position).norm(), 1e-7) << p->id;
  }
}

TEST_P(SurveyAdjuster, GivesTheSameBitsTwice) {
  const auto n = survey::test::simulate({}, 3);
  std::vector<uint8_t> first, second;
  adjust(n, nullptr, &first);
  adjust(n, nullptr, &second);
  EXPECT_EQ(first, second);
}

TEST_P(SurveyAdjuster, CovarianceCoversTheErrors) {
  double statistic = 0;
  constexpr int kTrials = 40;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto n = survey::test::simulate({}, 100 + static_cast<std::uint64_t>(trial));
    const PointsT found = adjust(n);
    const auto count = static_cast<int>(found.points.size());
    const Eigen::MatrixXd full = survey::unpack_lower(found.covariance, 3 * count);
    // Height difference of two markers: independent of the datum.
    const int a = 1, b = 10;
    ASSERT_EQ(found.points[a]->id, n.survey.points[a].id);
    const double error =
        found.points[b]->position.z() - found.points[a]->position.z() - n.truth[b].z() + n.truth[a].z();
    const double variance = full(3 * a + 2, 3 * a + 2) + full(3 * b + 2, 3 * b + 2) - 2 * full(3 * a + 2, 3 * b + 2);
    statistic += error * error / variance;
  }
  EXPECT_GT(statistic, 16.9);  // chi-squared with 40 degrees of freedom, 0.05 % at each side
  EXPECT_LT(statistic, 76.1);
}

TEST_P(SurveyAdjuster, NamesWhatADegenerateNetworkLacks) {
  auto n = survey::test::simulate({}, 4);
  n.survey.observations.clear();
  try {
    adjust(n);
    FAIL() << "a network without observations was accepted";
  } catch (const test::NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("no observations"), std::string::npos) << error.what();
  }
  n = survey::test::simulate({}, 4);
  std::erase_if(n.survey.observations, [](const survey::Observation& o) {
    return o.to == "M12" && (o.kind != survey::ObservationKind::direction || o.set_up != 0);
  });
  try {
    adjust(n);
    FAIL() << "a point seen by one direction only was accepted";
  } catch (const test::NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("M12"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("rank defect"), std::string::npos) << error.what();
  }
}

TEST_P(SurveyAdjuster, EveryParameterHasItsEffect) {
  // Two readings are wrong, one of them hardly; without sigmas the instrument's profile counts.
  SimulationSettings settings;
  auto given = survey::test::simulate(settings, 5);
  settings.sigmas = false;
  auto by_profile = survey::test::simulate(settings, 5);
  for (auto* n : {&given, &by_profile}) {
    n->survey.observations[20].value += 0.02;
    n->survey.observations[50].value += 0.006;
  }
  const PointsT control = control_of(given, {0, 3, 8}, 0.002);
  const auto with = [&](const SimulatedNetwork& n, bool known, const std::map<std::string, std::string>& values) {
    return [&n, &control, known, values] {
      test::NodeHarness node(GetParam());
      node.input<SurveyObservations>("observations", survey::to_artifact(n.survey));
      if (known) node.input<Points>("control", control);
      for (const auto& [name, value] : values)
        if (node.has_parameter(name, value)) node.set(name, value);
      return node;
    };
  };
  // Points that were keyed in as known; an instrument over a mark; a network on a map.
  auto keyed = given;
  for (const size_t i : {0, 3, 8}) keyed.survey.points[i].known = {true, true, true};
  auto marked = by_profile;
  marked.survey.points[12].known = marked.survey.points[0].known = {true, true, true};
  auto with_vector = given;  // of the earth, between two markers
  const geodesy::MapProjection map("EPSG:25832");
  const auto of_the_earth = [&](const Eigen::Vector3d& p) {
    return map.geocentric(map.inverse(p.head<2>()), p.z() + 47.5);
  };
  survey::VectorGroup vector;
  vector.vectors = {{given.survey.points[0].id, given.survey.points[11].id, 0, 0}};
  vector.values = of_the_earth(given.truth[11]) - of_the_earth(given.truth[0]);
  vector.covariance = 1e-6 * Eigen::Matrix3d::Identity();
  vector.is_geocentric = true;
  with_vector.survey.vectors.push_back(vector);
  EXPECT_EQ(test::parameters_at_fault({with(given, false, {}), with(keyed, false, {}),
                                       with(marked, false, {{"profile", "total_station_1arcsec"}}),
                                       with(given, false, {{"map", "EPSG:25832"}}), with(given, true, {}),
                                       with(with_vector, true, {{"map", "EPSG:25832"}, {"geoid_height", "47.5"}}),
                                       with(by_profile, true, {}), with(given, true, {{"remove_blunders", "true"}}),
                                       with(given, true, {{"datum", "weighted"}, {"curvature", "on"}}),
                                       with(given, true, {{"covariance", "neighbours"}})}),
            "");
}

TEST_P(SurveyAdjuster, StopsWhereverItAsks) {
  const auto n = survey::test::simulate({}, 6);
  EXPECT_EQ(test::stopping_at_fault([&] {
              test::NodeHarness node(GetParam());
              node.input<SurveyObservations>("observations", survey::to_artifact(n.survey));
              return node;
            }),
            "");
}

INSTANTIATE_TEST_SUITE_P(Conformance, SurveyAdjuster, testing::ValuesIn(test::kinds_of_role("survey_adjuster")),
                         test::test_name);

}  // namespace survey_adjuster_tests
}  // namespace plumbline

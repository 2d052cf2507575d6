// Two epochs with a point that was moved by a known amount.
#include "adjust_network.hpp"
#include "compare_epochs.hpp"
#include "simulated_network.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace {

Epoch epoch(const SurveyObservations& survey) {
  AdjustOptions options;
  options.curvature = Switch::off;
  const NetworkResult r = adjust_network(survey, options);
  Epoch e;
  for (const ResultPoint& p : r.points) e.ids.push_back(p.id);
  e.coordinates.resize(static_cast<Eigen::Index>(3 * e.ids.size()));
  for (size_t i = 0; i < e.ids.size(); ++i)
    e.coordinates.segment<3>(static_cast<Eigen::Index>(3 * i)) = r.points[i].position;
  e.covariance = r.full_covariance();
  return e;
}

/// Without stations: they stand elsewhere in every epoch.
Epoch markers(const Epoch& all) {
  Epoch e;
  std::vector<Eigen::Index> rows;
  for (size_t i = 0; i < all.ids.size(); ++i) {
    if (all.ids[i][0] != 'M') continue;
    e.ids.push_back(all.ids[i]);
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(static_cast<Eigen::Index>(3 * i) + c);
  }
  e.coordinates = all.coordinates(rows);
  e.covariance = all.covariance(rows, rows);
  return e;
}

TEST(CompareEpochs, SameNetworkMeasuredTwiceIsCongruent) {
  const Comparison c =
      compare_epochs(markers(epoch(test::simulate({}, 21).survey)), markers(epoch(test::simulate({}, 22).survey)), {});
  EXPECT_TRUE(c.congruent) << c.statistic << " " << c.critical;
  EXPECT_EQ(c.rank, 3 * 12 - 4);
  EXPECT_TRUE(c.excluded.empty());
}

TEST(CompareEpochs, FindsTheMovedMarkerAndItsMovement) {
  const auto first = test::simulate({}, 31);
  auto second = test::simulate({}, 32);
  // M12 has sunk by 6 mm: its zenith angles and distances are those of the lower point.
  const Eigen::Vector3d sunk(0, 0, -0.006);
  for (Observation& o : second.survey.observations) {
    if (o.to != "M12") continue;
    const Eigen::Vector3d& station = second.truth[static_cast<size_t>(12 + o.set_up)];
    const Eigen::Vector3d before = second.truth[6] - station, after = before + sunk;
    if (o.kind == ObservationKind::slope_distance) o.value += after.norm() - before.norm();
    if (o.kind == ObservationKind::zenith_angle)
      o.value += std::atan2(after.head<2>().norm(), after.z()) - std::atan2(before.head<2>().norm(), before.z());
  }
  const Comparison c = compare_epochs(markers(epoch(first.survey)), markers(epoch(second.survey)), {});
  EXPECT_FALSE(c.congruent);
  ASSERT_EQ(c.excluded, std::vector<std::string>{"M12"});
  for (const Movement& m : c.movements) {
    EXPECT_EQ(m.moved, m.id == "M12") << m.id;
    if (m.id == "M12") {
      EXPECT_NEAR(m.movement.z(), -0.006, 3 * m.sigma.z());
    }
  }
}

TEST(CompareEpochs, RefusesWhatCannotBeCompared) {
  Epoch e = markers(epoch(test::simulate({}, 41).survey)), other = e;
  for (std::string& id : other.ids) id += "x";
  EXPECT_THROW(compare_epochs(e, other, {}), std::runtime_error);
  other = e;
  other.covariance.resize(0, 0);
  EXPECT_THROW(compare_epochs(e, other, {}), std::runtime_error);
}

}  // namespace
}  // namespace plumbline::survey

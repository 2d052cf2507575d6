#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <numbers>
#include <set>

#include "survey/model/instrument_profile.hpp"
#include "survey_plan.hpp"

namespace plumbline::simulate {
namespace test_survey_plan {

constexpr double kPi = std::numbers::pi;

TEST(StationPlan, KeepsTheRulesForEveryBuildingOfTable1) {
  for (int floors = 1; floors <= 5; ++floors) {
    for (int columns = 3; columns <= 4; ++columns) {
      for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        const Building b = make_building({.floors = floors, .columns = columns}, seed);
        const auto broken = broken_station_rules(b, plan_set_ups(b, {}, seed));
        EXPECT_TRUE(broken.empty()) << floors << " floors, " << columns << " columns: " << broken.front();
      }
    }
  }
}

/// Section 6.4: no shallow sights. The rule allows 60 degrees; the plan for the buildings of Table 1 stays below 45.
TEST(StationPlan, SightsMeetTheFacadeSteeply) {
  double flattest = 0;
  for (int floors = 1; floors <= 5; ++floors) {
    const Building b = make_building({.floors = floors, .columns = 4}, 3);
    for (const PlannedSetUp& s : plan_set_ups(b, {}, 3).set_ups)
      for (const std::size_t a : s.anchors) {
        const Eigen::Vector3d sight = s.axis - b.anchors[a].built;
        flattest = std::max(flattest, std::acos(-sight.y() / sight.norm()) * 180 / kPi);
      }
  }
  EXPECT_LT(flattest, 45);
  EXPECT_GT(flattest, 20) << "the angle is computed wrongly";
}

/// Section 6.4: adjacent floors share markers, so that heights pass from one to the next.
TEST(StationPlan, AdjacentFloorsShareTwoRowsOfMarkers) {
  const Building b = make_building({.floors = 5}, 1);
  const StationPlan plan = plan_set_ups(b, {}, 1);
  for (int floor = 1; floor < 5; ++floor) {
    std::set<std::string> from_below, from_above, shared;
    for (const PlannedSetUp& s : plan.set_ups)
      for (const std::size_t a : s.anchors)
        if (s.floor == floor || s.floor == floor + 1)
          (s.floor == floor ? from_below : from_above).insert(b.anchors[a].id);
    std::set_intersection(from_below.begin(), from_below.end(), from_above.begin(), from_above.end(),
                          std::inserter(shared, shared.end()));
    EXPECT_EQ(shared.size(), 11u) << "two rows of four and three check anchors of floor " << floor;
  }
}

TEST(StationPlan, SaysWhichRuleIsBroken) {
  const Building b = make_building({.floors = 2}, 1);
  const StationPlan whole = plan_set_ups(b, {}, 1);
  const auto first_broken = [&](const StationPlan& plan) {
    const auto broken = broken_station_rules(b, plan);
    return broken.empty() ? std::string("none") : broken.front();
  };
  StationPlan plan = whole;
  plan.set_ups.pop_back();  // the upper floor has one set-up left
  EXPECT_NE(first_broken(plan).find("is seen from 1 set-ups, not two"), std::string::npos);
  plan = whole;
  for (auto& s : plan.set_ups) {
    if (s.floor == 2) std::erase_if(s.anchors, [&](std::size_t a) { return b.anchors[a].floor == 1; });
  }
  EXPECT_NE(first_broken(plan).find("share 0 rows"), std::string::npos);
  plan = whole;
  plan.set_ups[0].axis.y() = -0.5;
  EXPECT_NE(first_broken(plan).find("off the facade's normal"), std::string::npos);
  plan = whole;
  for (auto& s : plan.set_ups) s.ground_points.resize(2);
  EXPECT_NE(first_broken(plan).find("2 control points"), std::string::npos);
}

/// The mean of all readings of one target from one set-up, both faces reduced.
struct Mean {
  double direction_x = 0, direction_y = 0, zenith = 0, distance = 0;
  int n = 0;
};
std::map<std::pair<int, std::string>, Mean> means_of(const survey::SurveyObservations& observations) {
  std::map<std::pair<int, std::string>, Mean> means;
  for (const auto& o : observations.observations) {
    Mean& m = means[{o.set_up, o.to}];
    if (o.kind == survey::ObservationKind::direction) {
      const double reduced = o.face == 1 ? o.value : o.value - kPi;
      m.direction_x += std::cos(reduced), m.direction_y += std::sin(reduced);
      ++m.n;
    } else if (o.kind == survey::ObservationKind::zenith_angle) {
      m.zenith += o.face == 1 ? o.value : 2 * kPi - o.value;
    } else {
      m.distance += o.value;
    }
  }
  return means;
}

TEST(Observations, WithoutNoiseAreTheGeometry) {
  const Building b = make_building({.floors = 2}, 4);
  const SurveyOptions options{.noise_scale = 0};
  const StationPlan plan = plan_set_ups(b, options, 4);
  const auto observations = observe(b, plan, options, 4);
  std::map<std::string, Eigen::Vector3d> targets;
  for (const Anchor& a : b.anchors) targets[a.id] = a.built;
  for (const GroundPoint& g : plan.ground_points) targets[g.id] = g.truth + Eigen::Vector3d(0, 0, g.target_height);
  for (const auto& [key, m] : means_of(observations)) {
    const PlannedSetUp& s = plan.set_ups[key.first];
    const double direction = std::atan2(m.direction_y, m.direction_x) + s.orientation, zenith = m.zenith / m.n,
                 distance = m.distance / m.n;
    const Eigen::Vector3d found =
        s.axis + distance * Eigen::Vector3d(std::sin(zenith) * std::sin(direction),
                                            std::sin(zenith) * std::cos(direction), std::cos(zenith));
    EXPECT_LT((found - targets.at(key.second)).norm(), 1e-9) << key.second;
    EXPECT_EQ(m.n, 4);  // two sets of two faces
  }
}

TEST(Observations, ScatterAsTheInstrumentProfileSays) {
  const Building b = make_building({.floors = 3}, 1);
  double direction = 0, zenith = 0, distance = 0;
  int n = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    const SurveyOptions options;
    const StationPlan plan = plan_set_ups(b, options, 7);
    const auto truth = means_of(observe(b, plan, {.noise_scale = 0}, seed));
    const survey::InstrumentProfile instrument = survey::built_in_profile(options.instrument);
    for (const auto& [key, m] : means_of(observe(b, plan, options, seed))) {
      const Mean& t = truth.at(key);
      const double s = t.distance / t.n, h = s * std::sin(t.zenith / t.n), sets = options.sets;
      const double c = instrument.target_centring;
      const double turn = (t.direction_x * m.direction_y - t.direction_y * m.direction_x) / (m.n * m.n);
      direction += std::pow(turn, 2) / (std::pow(instrument.direction_sigma, 2) / sets + c * c / (h * h));
      zenith +=
          std::pow((m.zenith - t.zenith) / m.n, 2) / (std::pow(instrument.zenith_sigma, 2) / sets + c * c / (s * s));
      const double ab = instrument.distance_constant + 1e-6 * instrument.distance_ppm * s;
      distance += std::pow((m.distance - t.distance) / m.n, 2) / (ab * ab / sets + c * c);
      ++n;
    }
  }
  const double margin = 4 * std::sqrt(2.0 / n);
  EXPECT_NEAR(direction / n, 1, margin);
  EXPECT_NEAR(zenith / n, 1, margin);
  EXPECT_NEAR(distance / n, 1, margin);
}

TEST(Observations, FacesDifferByCollimationAndIndex) {
  const Building b = make_building({.floors = 1}, 1);
  const StationPlan plan = plan_set_ups(b, {}, 1);
  for (const auto& o : observe(b, plan, {}, 1).observations) {
    if (o.kind != survey::ObservationKind::zenith_angle) continue;
    EXPECT_EQ(o.value > kPi, o.face == 2);
  }
}

TEST(Instrument, UnknownNameListsTheKnown) {
  const Building b = make_building({.floors = 1}, 1);
  const StationPlan plan = plan_set_ups(b, {}, 1);
  try {
    observe(b, plan, {.instrument = "ics60"}, 1);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("ics50_assumed"), std::string::npos);
  }
}

}  // namespace test_survey_plan
}  // namespace plumbline::simulate

// Layouts that keep the rules and layouts that break one each.
#include <algorithm>

#include "geometry/statistics.hpp"
#include "simulated_network.hpp"
#include "survey/plan/plan_survey.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace test_plan_survey {

/// Floors of 3 m with two rows of markers 2 m apart in four columns, facing south.
std::vector<PlannedMarker> facade(int floors) {
  std::vector<PlannedMarker> markers;
  for (int f = 1; f <= floors; ++f)
    for (int c = 1; c <= 4; ++c)
      for (int r = 0; r < 2; ++r)
        markers.push_back({"A" + std::to_string(f) + std::to_string(c) + std::to_string(r),
                           {2.0 * c, 0.1 * (c % 2), 4.0 * (f - 1) + 1 + 2.0 * r},
                           {0, -1, 0},
                           f,
                           c});
  return markers;
}

PlanOptions with_profile(const std::string& name) {
  PlanOptions options;
  options.profile = built_in_profile(name);
  return options;
}

const PlannedRule& rule(const PlanResult& r, const std::string& name) {
  for (const PlannedRule& rule : r.rules)
    if (rule.name == name) return rule;
  throw std::out_of_range(name);
}

TEST(PlanSurvey, TwoGroundSetUpsBeforeThreeFloorsHold) {
  const PlanResult r =
      plan_survey(facade(3), {{"S1", {0, -15, 1.6}}, {"S2", {9, -16, 1.6}}}, with_profile("total_station_1arcsec"));
  for (const PlannedRule& rule : r.rules) EXPECT_TRUE(rule.holds) << rule.name << ": " << rule.text;
  EXPECT_TRUE(r.remedies.empty());
  ASSERT_EQ(r.transfers.size(), 2u * (1 + 4)) << "floor means and four columns";
  ASSERT_EQ(r.drifts.size(), 3u);
  EXPECT_NEAR(r.drifts[0].sigma, 0, 1e-7) << "the lowest floor carries the datum";
  EXPECT_GT(r.transfers[0].sigma, 0);
  EXPECT_LT(r.transfers[0].sigma, 0.001);
  for (const PlannedTransfer& t : r.transfers) {
    if (t.column > 0) {
      EXPECT_GT(t.sigma, r.transfers[0].sigma) << "one column is known less well than the floors";
    }
  }
  EXPECT_EQ(r.predicted.defect, 4);
}

TEST(PlanSurvey, OneSetUpIsNotEnoughAndTheRemedyIsASetUp) {
  const PlanResult r = plan_survey(facade(2), {{"S1", {5, -15, 1.6}}}, with_profile("ics50_assumed"));
  EXPECT_FALSE(rule(r, "set-ups per marker").holds);
  EXPECT_EQ(rule(r, "set-ups per marker").points.size(), 16u);
  ASSERT_FALSE(r.remedies.empty());
  EXPECT_NE(r.remedies[0].text.find("add a set-up near"), std::string::npos) << r.remedies[0].text;
  EXPECT_EQ(r.remedies[0].added.size(), 16u);
  EXPECT_EQ(r.remedies[0].sightings, 16 + kSetUpCost);
}

TEST(PlanSurvey, ShallowIncidenceDoesNotCount) {
  const PlanResult r = plan_survey(facade(1), {{"S1", {0, -15, 1.6}}, {"S2", {9, -16, 1.6}}, {"far", {60, -3, 1.6}}},
                                   with_profile("ics50_assumed"));
  for (const PlannedSight& s : r.sights) EXPECT_NE(s.set_up, "far");
}

TEST(PlanSurvey, FloorsMustShareMarkersAndHaveAColumn) {
  auto markers = facade(2);
  for (auto& m : markers)
    if (m.floor == 2) m.column += 4;
  // Each set-up stands so near that it sees its own floor only.
  PlanOptions options = with_profile("ics50_assumed");
  options.steepest_sight = 0.2;
  const PlanResult r = plan_survey(
      markers, {{"S1", {3, -11, 2}}, {"S2", {7, -11, 2}}, {"S3", {3, -11, 6}}, {"S4", {7, -11, 6}}}, options);
  EXPECT_FALSE(rule(r, "shared markers, floors 1 and 2").holds);
  EXPECT_FALSE(rule(r, "vertical marker column").holds);
  EXPECT_FALSE(rule(r, "determined").holds);
  EXPECT_FALSE(r.adjustable);
}

/// The plan with a remedy carried out.
std::vector<PlannedSetUp> with(std::vector<PlannedSetUp> set_ups, const PlanRemedy& remedy) {
  for (const PlannedSight& sight : remedy.added)
    for (PlannedSetUp& s : set_ups)
      if (s.id == sight.set_up) s.sees.push_back(sight.marker);
  return set_ups;
}

std::vector<std::string> markers_on(const std::vector<int>& floors) {
  std::vector<std::string> ids;
  for (int f : floors)
    for (const PlannedMarker& m : facade(3))
      if (m.floor == f) ids.push_back(m.id);
  return ids;
}

TEST(PlanSurvey, AMarkerSeenOnceIsMendedByOneSight) {
  auto second = markers_on({1, 2, 3});
  second.erase(second.begin() + 5);
  const std::vector<PlannedSetUp> set_ups = {{"S1", {0, -15, 1.6}, markers_on({1, 2, 3})},
                                             {"S2", {9, -16, 1.6}, second}};
  const PlanOptions options = with_profile("total_station_1arcsec");
  const PlanResult r = plan_survey(facade(3), set_ups, options);
  EXPECT_EQ(rule(r, "set-ups per marker").points, std::vector<std::string>{"A131"});
  ASSERT_EQ(r.remedies.size(), 1u);
  EXPECT_EQ(r.remedies[0].rule, "set-ups per marker");
  EXPECT_EQ(r.remedies[0].text, "sight A131 also from S2");
  EXPECT_EQ(r.remedies[0].sightings, 1);
  for (const PlannedRule& rule : plan_survey(facade(3), with(set_ups, r.remedies[0]), options).rules)
    EXPECT_TRUE(rule.holds) << rule.name;
}

TEST(PlanSurvey, FloorsAreJoinedByTheFewestSights) {
  // S3 and S4 see the upper floors only; nothing joins floors 1 and 2 but one marker of S3.
  auto upper = markers_on({2, 3});
  upper.push_back("A121");
  const std::vector<PlannedSetUp> set_ups = {{"S1", {0, -15, 1.6}, markers_on({1})},
                                             {"S2", {9, -16, 1.6}, markers_on({1})},
                                             {"S3", {0, -16, 5}, upper},
                                             {"S4", {9, -15, 5}, markers_on({2, 3})}};
  const PlanOptions options = with_profile("total_station_1arcsec");
  const PlanResult r = plan_survey(facade(3), set_ups, options);
  EXPECT_FALSE(rule(r, "shared markers, floors 1 and 2").holds);
  EXPECT_TRUE(rule(r, "shared markers, floors 2 and 3").holds);
  const auto remedy = std::find_if(r.remedies.begin(), r.remedies.end(),
                                   [](const auto& x) { return x.rule == "shared markers, floors 1 and 2"; });
  ASSERT_NE(remedy, r.remedies.end());
  EXPECT_EQ(remedy->sightings, 1) << remedy->text;
  EXPECT_TRUE(rule(plan_survey(facade(3), with(set_ups, *remedy), options), "shared markers, floors 1 and 2").holds);
}

TEST(PlanSurvey, ANetworkInTwoPartsIsMendedBySingleSights) {
  const std::vector<PlannedSetUp> set_ups = {{"S1", {0, -15, 1.6}, markers_on({1})},
                                             {"S2", {9, -16, 1.6}, markers_on({1})},
                                             {"S3", {0, -16, 5}, markers_on({2, 3})},
                                             {"S4", {9, -15, 5}, markers_on({2, 3})}};
  const PlanOptions options = with_profile("total_station_1arcsec");
  const PlanResult r = plan_survey(facade(3), set_ups, options);
  EXPECT_FALSE(rule(r, "determined").holds);
  const auto remedy =
      std::find_if(r.remedies.begin(), r.remedies.end(), [](const auto& x) { return x.rule == "determined"; });
  ASSERT_NE(remedy, r.remedies.end());
  EXPECT_EQ(remedy->sightings, 2) << remedy->text;
  EXPECT_TRUE(rule(plan_survey(facade(3), with(set_ups, *remedy), options), "determined").holds);
}

TEST(PlanSurvey, EveryRemedyOfAWeakTransferMendsIt) {
  // Two common markers carry the height from floor to floor.
  auto low = markers_on({1}), high = markers_on({2});
  low.insert(low.end(), {"A210", "A240"});
  high.insert(high.end(), {"A110", "A140"});
  const std::vector<PlannedSetUp> set_ups = {{"S1", {0, -12, 1.6}, low}, {"S2", {9, -13, 5.6}, high}};
  PlanOptions options = with_profile("total_station_5arcsec");
  const std::string name = "height transfer, floor 1 to 2";
  const PlanResult before = plan_survey(facade(2), set_ups, options);
  ASSERT_FALSE(before.transfers.empty());
  options.tolerance = 5 * 0.8 * before.transfers[0].sigma;
  const PlanResult r = plan_survey(facade(2), set_ups, options);
  ASSERT_FALSE(rule(r, name).holds);
  int sights = 0, sets = 0, new_set_ups = 0;
  for (const PlanRemedy& remedy : r.remedies) {
    if (remedy.rule != name) continue;
    auto mended = with(set_ups, remedy);
    PlanOptions more = options;
    if (remedy.added.empty()) {
      ASSERT_EQ(remedy.text.find("measure "), 0u) << remedy.text;
      more.sets = remedy.text[8] - '0';
      ++sets;
    } else if (remedy.added[0].set_up == "new") {
      ++new_set_ups;
      continue;  // its place stands in the text only
    } else {
      ++sights;
    }
    EXPECT_TRUE(rule(plan_survey(facade(2), mended, more), name).holds) << remedy.text;
  }
  EXPECT_EQ(sights, 1);
  EXPECT_EQ(sets, 1);
  EXPECT_EQ(new_set_ups, 1);
  for (size_t i = 1; i < r.remedies.size(); ++i) EXPECT_LE(r.remedies[i - 1].sightings, r.remedies[i].sightings);
}

TEST(PlanSurvey, SightsOutsideTheLimitsAreNamedAndDoNotCount) {
  const PlanResult r = plan_survey(facade(1),
                                   {{"S1", {0, -15, 1.6}, markers_on({1})},
                                    {"S2", {9, -16, 1.6}, markers_on({1})},
                                    {"oblique", {40, -3, 1.6}, {"A110", "A111"}}},
                                   with_profile("ics50_assumed"));
  EXPECT_FALSE(rule(r, "range and incidence").holds);
  EXPECT_EQ(rule(r, "range and incidence").points, (std::vector<std::string>{"A110", "A111"}));
  for (const PlannedSight& s : r.sights) EXPECT_NE(s.set_up, "oblique");
}

TEST(PlanSurvey, GridRules) {
  auto markers = facade(2);
  markers.back().position.x() += 3;
  markers.erase(markers.begin(), markers.begin() + 3);
  const PlanResult r =
      plan_survey(markers, {{"S1", {0, -15, 1.6}}, {"S2", {9, -16, 1.6}}}, with_profile("ics50_assumed"));
  EXPECT_EQ(rule(r, "marker spacing").points, (std::vector<std::string>{"A241"}));
  EXPECT_FALSE(rule(r, "markers per floor").holds);
}

/// What the plan predicts is what happens: the planned sights are simulated with the noise of the profile and adjusted.
TEST(PlanSurvey, PredictionHoldsInSimulation) {
  const auto markers = facade(3);
  const std::vector<PlannedSetUp> set_ups = {{"S1", {0, -15, 1.6}}, {"S2", {9, -16, 1.6}}};
  const PlanOptions options = with_profile("ics50_assumed");
  const PlanResult plan = plan_survey(markers, set_ups, options);
  const SurveyObservations exact = planned_readings(markers, set_ups, options);
  const AdjustOptions adjustment = planned_adjustment(markers, set_ups, options);
  constexpr int kTrials = 300;
  std::vector<double> drifts(plan.drifts.size()), transfers(plan.transfers.size());
  test::Normal normal(20240601);
  for (int trial = 0; trial < kTrials; ++trial) {
    SurveyObservations noisy = exact;
    for (Observation& o : noisy.observations) o.value += o.sigma * normal();
    const NetworkResult r = adjust_network(noisy, adjustment);
    const auto mean_error = [&](int floor, int column) {
      double sum = 0;
      int n = 0;
      for (const PlannedMarker& m : markers) {
        if (m.floor != floor || (column > 0 && m.column != column)) continue;
        sum += r.point(m.id).position.z() - m.position.z();
        ++n;
      }
      return sum / n;
    };
    double drift = 0;
    for (size_t k = 0; k < plan.drifts.size(); ++k) {
      drift += mean_error(plan.drifts[k].floor, 0);
      if (k > 0) drifts[k] += std::pow(drift / plan.drifts[k].sigma, 2);
    }
    for (size_t k = 0; k < plan.transfers.size(); ++k) {
      const PlannedTransfer& t = plan.transfers[k];
      transfers[k] += std::pow((mean_error(t.to_floor, t.column) - mean_error(t.from_floor, t.column)) / t.sigma, 2);
    }
  }
  // Twelve sums that are chi-squared with 300 degrees of freedom; 0.1 % on each side of each.
  const double low = chi_squared_quantile(0.001, kTrials), high = chi_squared_quantile(0.999, kTrials);
  for (size_t k = 1; k < drifts.size(); ++k) {
    EXPECT_GT(drifts[k], low) << "D(" << k + 1 << ")";
    EXPECT_LT(drifts[k], high) << "D(" << k + 1 << ")";
  }
  for (size_t k = 0; k < transfers.size(); ++k) {
    EXPECT_GT(transfers[k], low) << "transfer " << k;
    EXPECT_LT(transfers[k], high) << "transfer " << k;
  }
}

TEST(PlanSurvey, EmptyPlansAreErrors) {
  EXPECT_THROW(plan_survey({}, {{"S1", {0, 0, 0}}}, with_profile("ics50_assumed")), std::runtime_error);
  EXPECT_THROW(plan_survey(facade(1), {}, with_profile("ics50_assumed")), std::runtime_error);
  EXPECT_THROW(plan_survey(facade(1), {{"S1", {0, -15, 1.6}, {"nobody"}}}, with_profile("ics50_assumed")),
               std::runtime_error);
  EXPECT_THROW(plan_survey(facade(1), {{"A110", {0, -15, 1.6}}}, with_profile("ics50_assumed")), std::runtime_error);
}

}  // namespace test_plan_survey
}  // namespace plumbline::survey

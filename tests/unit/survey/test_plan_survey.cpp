// Layouts that keep the rules and layouts that break one each.
#include "plan_survey.hpp"
#include "test_support.hpp"

namespace plumbline::survey {
namespace {

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
  ASSERT_EQ(r.transfer_sigma.size(), 2u);
  ASSERT_EQ(r.drift_sigma.size(), 3u);
  EXPECT_GT(r.transfer_sigma[0], 0);
  EXPECT_LT(r.transfer_sigma[0], 0.001);
  EXPECT_EQ(r.predicted.defect, 4);
}

TEST(PlanSurvey, OneSetUpIsNotEnoughAndTheRemedyIsASetUp) {
  const PlanResult r = plan_survey(facade(2), {{"S1", {5, -15, 1.6}}}, with_profile("ics50_assumed"));
  EXPECT_FALSE(rule(r, "set-ups per marker").holds);
  EXPECT_EQ(rule(r, "set-ups per marker").points.size(), 16u);
  ASSERT_FALSE(r.remedies.empty());
  EXPECT_NE(r.remedies[0].find("add a set-up near"), std::string::npos) << r.remedies[0];
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

TEST(PlanSurvey, WeakTransferAsksForSetsOrASetUp) {
  PlanOptions options = with_profile("total_station_5arcsec");
  options.tolerance = 0.0004;
  const PlanResult r = plan_survey(facade(2), {{"S1", {0, -15, 1.6}}, {"S2", {9, -16, 1.6}}}, options);
  EXPECT_FALSE(rule(r, "height transfer, floor 1 to 2").holds);
  ASSERT_FALSE(r.remedies.empty());
  EXPECT_NE(r.remedies.back().find("height transfer"), std::string::npos);
}

TEST(PlanSurvey, EmptyPlansAreErrors) {
  EXPECT_THROW(plan_survey({}, {{"S1", {0, 0, 0}}}, with_profile("ics50_assumed")), std::runtime_error);
  EXPECT_THROW(plan_survey(facade(1), {}, with_profile("ics50_assumed")), std::runtime_error);
}

}  // namespace
}  // namespace plumbline::survey

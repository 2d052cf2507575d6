// Pages about a plan, two epochs and control points: what they say first, and that they survive what is missing.
#include <gtest/gtest.h>

#include <cmath>

#include "show/report/sections.hpp"

namespace plumbline::report {
namespace test_survey_sections {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

std::unique_ptr<PointMovementT> movement(const std::string& id, double dz, bool moved) {
  auto p = std::make_unique<PointMovementT>();
  p->id = id;
  p->position = {1.0 * static_cast<double>(id.size()), 2, 3};
  p->movement = {0, 0, dz};
  p->sigma.setConstant(0.0005);
  p->statistic = 12, p->moved = moved, p->stable = !moved, p->detectable_height = 0.002;
  p->ellipsoid = std::make_unique<NetworkEllipsoidT>();
  p->ellipsoid->id = id;
  p->ellipsoid->semi_axes = {0.0005, 0.0005, 0.0005};
  p->ellipsoid->first_axis = {1, 0, 0}, p->ellipsoid->second_axis = {0, 1, 0};
  return p;
}

SurveyComparisonT comparison_with(bool moved) {
  SurveyComparisonT c;
  c.points.push_back(movement("A", 0.0001, false));
  c.points.push_back(movement("<b>", 0.0002, false));
  c.points.push_back(movement("M12", -0.002, moved));
  c.statistic = moved ? 88.8 : 3.3, c.critical = 11.1, c.rank = 5, c.congruent = !moved;
  c.alpha = 0.05, c.alpha0 = 0.001, c.power = 0.8, c.critical_point = 16.3, c.free_motions = 4;
  if (moved) {
    auto e = std::make_unique<PointExclusionT>();
    e->id = "M12", e->statistic = 1.5, e->critical = 6, e->alternatives = {"A"};
    c.excluded.push_back(std::move(e));
  }
  return c;
}

template <typename Write>
std::string page(Write write) {
  return render_page("t", [&](Markup& html) { write(html); });
}

TEST(SurveySections, EpochsNameWhatMoved) {
  const auto html = page([](Markup& m) { write_epochs(m, comparison_with(true)); });
  EXPECT_TRUE(contains(html, "1\u00A0point has moved: M12."));
  EXPECT_TRUE(contains(html, "class=\"verdict fail\""));
  EXPECT_TRUE(contains(html, "moved shaft"));
  EXPECT_TRUE(contains(html, "&lt;b&gt;"));
  EXPECT_FALSE(contains(html, "<b>"));
  const auto still = page([](Markup& m) { write_epochs(m, comparison_with(false)); });
  EXPECT_TRUE(contains(still, "No point has moved significantly."));
  EXPECT_FALSE(contains(still, "How they were found"));
}

TEST(SurveySections, ControlWarnsOnlyWhenItMust) {
  const auto warning = [](const SurveyComparisonT& c) {
    return contains(page([&](Markup& m) { write_control_warning(m, c); }), "class=\"warnings\"");
  };
  EXPECT_TRUE(warning(comparison_with(true)));
  EXPECT_FALSE(warning(comparison_with(false)));
  SurveyComparisonT untested;
  untested.remark = "there are no control points to check";
  EXPECT_FALSE(warning(untested));
  EXPECT_TRUE(contains(page([&](Markup& m) { write_control_check(m, untested); }), "Not tested: there are no control"));
}

TEST(SurveySections, PlanTellsRulesAndRemedies) {
  SurveyPlanT plan;
  auto rule = std::make_unique<PlanRuleT>();
  rule->name = "set-ups per marker", rule->text = "seen from fewer than 2: <A>";
  plan.rules.push_back(std::move(rule));
  auto remedy = std::make_unique<PlanRemedyT>();
  remedy->rule = "set-ups per marker", remedy->text = "sight A also from S2", remedy->sightings = 1;
  plan.remedies.push_back(std::move(remedy));
  auto point = std::make_unique<PointT>();
  point->id = "A", point->position = {1, 2, 3}, point->sigma.setConstant(std::nan(""));
  plan.points.push_back(std::move(point));
  const auto html = page([&](Markup& m) { write_plan(m, plan); });
  EXPECT_TRUE(contains(html, "1\u00A0rule is broken."));
  EXPECT_TRUE(contains(html, "✗ violated"));
  EXPECT_TRUE(contains(html, "sight A also from S2"));
  EXPECT_TRUE(contains(html, "seen from fewer than 2: &lt;A&gt;"));
  EXPECT_FALSE(contains(html, "nan"));
}

TEST(SurveySections, AnEmptyPlanIsStillAPage) {
  EXPECT_NO_THROW(page([](Markup& m) { write_plan(m, {}); }));
  EXPECT_NO_THROW(page([](Markup& m) { write_epochs(m, {}); }));
  EXPECT_NO_THROW(page([](Markup& m) { write_control_check(m, {}); }));
}

}  // namespace test_survey_sections
}  // namespace plumbline::report

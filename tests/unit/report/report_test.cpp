// The report says what the evaluation found, holds no request to the outside, and survives hostile and incomplete
// input.
#include "report/report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "example.hpp"

namespace plumbline::report {
namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(Report, SaysTheVerdictFirst) {
  const std::string html = render_report(test::example());
  const auto verdict = html.find("class=\"verdict undecided\"");
  ASSERT_NE(verdict, std::string::npos);
  EXPECT_LT(verdict, html.find("<table"));
  EXPECT_TRUE(contains(html, "Undecided: 1 of 15 check anchors is too close to ±5\u00A0mm to call."));
  for (const char* id :
       {"numbers", "floors", "passrate", "facade", "transfer", "anchors", "method", "network", "provenance"})
    EXPECT_TRUE(contains(html, std::string("id=\"") + id + "\"")) << id;
}

TEST(Report, RequestsNothingFromOutside) {
  const std::string html = render_report(test::example());
  for (const char* forbidden : {"http://", "https://", "src=", "@import", "url(", "<link", "<iframe", "<img"})
    EXPECT_FALSE(contains(html, forbidden)) << forbidden;
}

TEST(Report, HasTheSameBytesEveryTime) { EXPECT_EQ(render_report(test::example()), render_report(test::example())); }

TEST(Report, EscapesEverythingThatComesFromFiles) {
  ReportInput input = test::example();
  const std::string attack = "\"><script>alert('x')</script>";
  input.title = input.subtitle = attack;
  for (auto& a : input.accuracy.anchors) a->id = attack, a->note = attack;
  for (auto& c : input.accuracy.comparisons) c->worst_anchor = c->evidence_note = attack;
  input.accuracy.warnings = {attack};
  input.accuracy.correlation_note = attack;
  input.accuracy.design->worst_anchor = attack;
  for (auto& p : input.network->points) p.id = attack;
  for (auto& o : input.network->observations) o.from = o.to = o.kind = o.source = attack;
  for (auto& g : input.network->groups) g.name = attack;
  input.network->findings = {{attack, attack}};
  input.network->datum = input.network->steps[0].action = attack;
  input.provenance = {{attack, attack}};
  input.files = {{attack, attack, 1}};
  const std::string html = render_report(input);
  EXPECT_FALSE(contains(html, "<script>alert"));
  EXPECT_TRUE(contains(html, "&lt;script&gt;alert"));
}

TEST(Report, ElementsAreBalancedAndNumbersAreFinite) {
  const std::string html = render_report(test::example());
  const std::regex tag("<(/?)([a-z0-9]+)([^>]*)>");
  std::vector<std::string> open;
  const std::string body = html.substr(html.find("<body"), html.find("<script>") - html.find("<body"));
  for (std::sregex_iterator it(body.begin(), body.end(), tag), end; it != end; ++it) {
    const std::string name = (*it)[2], rest = (*it)[3];
    if (!rest.empty() && rest.back() == '/') continue;
    if ((*it)[1] == "") {
      open.push_back(name);
      continue;
    }
    ASSERT_FALSE(open.empty());
    EXPECT_EQ(open.back(), name);
    open.pop_back();
  }
  EXPECT_EQ(open, std::vector<std::string>{"body"});
  EXPECT_FALSE(std::regex_search(body, std::regex("[^a-z]-?(nan|inf)[^a-z]")));
}

TEST(Report, WorksForOneFloor) {
  const std::string html = render_report(test::example(1));
  EXPECT_TRUE(contains(html, "No two adjacent floors"));
}

TEST(Report, WithoutCheckAnchorsThereIsNoVerdict) {
  ReportInput input = test::example();
  std::erase_if(input.accuracy.comparisons, [](const auto& c) { return c->use == AnchorUse::check; });
  input.network.reset();
  const std::string html = render_report(input);
  EXPECT_TRUE(contains(html, "No verdict: no check anchor was evaluated."));
  EXPECT_TRUE(contains(html, "These are control anchors."));
  EXPECT_FALSE(contains(html, "id=\"network\""));
}

TEST(Report, SurvivesAnEmptyEvaluation) {
  ReportInput input;
  input.accuracy.tau = 0.005;
  input.network.emplace();
  EXPECT_TRUE(contains(render_report(input), "No verdict"));
}

TEST(Report, SurvivesUnknownUncertainty) {
  ReportInput input = test::example();
  const double nan = std::nan("");
  for (auto& c : input.accuracy.comparisons) {
    for (auto& f : c->floors) f->u_mean_dz = f->u_drift = f->u_relative_drift = nan;
    c->slope->u_per_floor = c->slope->lower = c->slope->upper = nan;
    c->predicted_rmse_z = nan;
    c->consistency_3d.reset();
    c->consistency_z.reset();
  }
  for (auto& p : input.network->points) p.covariance.setConstant(nan);
  EXPECT_FALSE(contains(render_report(input), "\"nan"));
}

}  // namespace
}  // namespace plumbline::report

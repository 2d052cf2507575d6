// Surfaces on the page: what fails first, what nobody can judge with its reason.
#include <gtest/gtest.h>

#include <limits>

#include "example.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {
namespace test_surface_section {

std::unique_ptr<SurfaceVerdictT> verdict(const std::string& panel, double value, ToleranceVerdict is) {
  auto v = std::make_unique<SurfaceVerdictT>();
  v->panel = panel, v->quantity = "flatness", v->length = 1, v->rule = "*: flatness(1m)=3mm";
  v->value = value, v->sigma = 2e-4, v->upper = 0.003, v->lower = -std::numeric_limits<double>::infinity();
  v->probability = 0.4, v->verdict = is;
  return v;
}

SurfaceJudgementT judgement() {
  SurfaceJudgementT result;
  result.verdicts.push_back(verdict("Flat", 0.001, ToleranceVerdict::pass));
  result.verdicts.push_back(verdict("Nearly", 0.0029, ToleranceVerdict::undecided));
  result.verdicts.push_back(
      verdict("<Glass>", std::numeric_limits<double>::quiet_NaN(), ToleranceVerdict::not_measured));
  result.verdicts.back()->not_judged = "its points contradict each other";
  result.verdicts.push_back(verdict("Bent", 0.0052, ToleranceVerdict::fail));
  result.requests.push_back(std::make_unique<JudgementRequestT>());
  result.requests[0]->asked = "*: step=2mm", result.requests[0]->not_judged = "step: no joint was looked at";
  result.passed = result.undecided = result.failed = result.not_judged = 1;
  return result;
}

TEST(SurfaceSection, WhatFailsStandsFirstAndWhatIsNotJudgedHasItsReason) {
  Markup html;
  write_surfaces(html, judgement());
  const std::string page = html.str();
  for (const char* part : {"1 pass, 1 undecided, 1 fail, 1 not judged", "flatness(1m)", "5.20", "at most 3.0",
                           "its points contradict each other", "Asked for and not judged",
                           "*: step=2mm: step: no joint was looked at", "&lt;Glass&gt;"})
    EXPECT_NE(page.find(part), std::string::npos) << part << page;
  EXPECT_LT(page.find("Bent"), page.find("&lt;Glass&gt;"));
  EXPECT_LT(page.find("&lt;Glass&gt;"), page.find("Nearly"));
  EXPECT_LT(page.find("Nearly"), page.find("Flat<"));
}

TEST(SurfaceSection, StandsOnTheReportIfThereAreSurfaces) {
  ReportInput input = test::example(2);
  EXPECT_EQ(render_report(input).find("Verdicts on surfaces and joints"), std::string::npos);
  input.deviation->surfaces = std::make_unique<SurfaceJudgementT>(judgement());
  EXPECT_NE(render_report(input).find("Verdicts on surfaces and joints"), std::string::npos);
}

}  // namespace test_surface_section
}  // namespace plumbline::report

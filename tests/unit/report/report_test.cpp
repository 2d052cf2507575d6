// The report says what the evaluation found, holds no request to the outside, and survives hostile and incomplete
// input.
#include "report/report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <regex>

#include "example.hpp"
#include "report/format.hpp"
#include "report/script_data.hpp"
#include "test_support.hpp"

namespace plumbline::report {
namespace {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

/// A script that does not parse does nothing at all: no folding, no sorting, no slider, no view.
TEST(Report, ItsScriptsAreJavaScript) {
  if (std::system("node --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "node is not installed";
  const std::string html = render_report(test::example());
  const plumbline::test::TemporaryFolder folder;
  int scripts = 0;
  for (std::size_t at = 0; (at = html.find("<script>", at)) != std::string::npos; ++scripts) {
    at += 8;
    const auto file = folder.path() / ("script" + std::to_string(scripts) + ".js");
    std::ofstream(file) << html.substr(at, html.find("</script>", at) - at);
    EXPECT_EQ(std::system(("node --check " + file.string()).c_str()), 0);
  }
  EXPECT_GE(scripts, 1);
}

TEST(Report, CarriesItsLibraryAndWhereThePanelsCameToLie) {
  const ReportInput input = test::example();
  const std::string html = render_report(input);
  EXPECT_TRUE(contains(html, "<script type=\"text/plain\" id=\"three-js\">eN"));  // a zlib stream in base64
  EXPECT_FALSE(contains(html, "src="));
  ASSERT_FALSE(input.deviation->panels.empty());
  for (const auto& corner : input.deviation->panels[0]->corners)
    if (corner->movement.allFinite()) {
      EXPECT_TRUE(contains(html, script_vector(1e3 * corner->movement, 3))) << corner->name;
    }
}

/// A column a camera, with as many digits as its standard deviation has.
TEST(Report, ParametersOfTwoCamerasHaveTheDigitsOfTheirStandardDeviations) {
  ReportInput input = test::example();
  input.block.emplace();
  input.block->statistics = std::make_unique<StatisticsT>();
  const auto add = [&](const char* name, double value, double sigma) {
    auto parameter = std::make_unique<InteriorParameterT>();
    parameter->name = name, parameter->value = value, parameter->sigma = sigma, parameter->estimated = sigma > 0;
    input.block->interior_orientation.push_back(std::move(parameter));
  };
  add("fx of crane", 3082.2971, 0.0361), add("p1 of crane", 0.00021234, 2.04e-6), add("k3 of crane", 0, 0);
  add("fx of ground", 3082.3581, 0.0921), add("p1 of ground", 0.00020391, 5.0e-6), add("k3 of ground", 0, 0);
  const std::string html = render_report(input);
  for (const char* part :
       {">crane</th>", ">ground</th>", "3082.297 ± 0.036", "0.0002123 ± 0.0000020", "0.00000 (held)"})
    EXPECT_TRUE(contains(html, part)) << part;
  EXPECT_FALSE(contains(html, "± 0.00000<"));
}

TEST(Report, SaysFirstWhetherOneCanInstallAndWhatToMend) {
  const ReportInput input = test::example();
  const std::string html = render_report(input);
  const auto verdict = html.find("class=\"verdict fail\" id=\"install\"");
  ASSERT_NE(verdict, std::string::npos);
  EXPECT_LT(verdict, html.find("<table"));
  EXPECT_TRUE(contains(html, "Not ready: "));
  // The first row of the first table is the anchor with the largest share of its tolerance.
  double worst = 0;
  std::string id;
  for (const auto& anchor : input.deviation->anchors)
    for (const auto& axis : anchor->axes)
      if (axis->axis == anchor->decided_by && anchor->verdict == ToleranceVerdict::fail &&
          std::abs(axis->value) > worst)
        worst = std::abs(axis->value), id = anchor->id;
  const std::string first = html.substr(html.find("<tbody>", html.find("Where not, and what to do")), 200);
  EXPECT_TRUE(contains(first, "Anchor " + id)) << first;
  EXPECT_TRUE(contains(html, "Undecided: 1 of 15 check anchors is too close to ±5\u00A0mm to call."));
  for (const char* id_of : {"view", "quality", "panels", "numbers", "floors", "passrate", "facade", "transfer",
                            "anchors", "method", "network", "provenance"})
    EXPECT_TRUE(contains(html, std::string("id=\"") + id_of + "\"")) << id_of;
}

TEST(Report, LengthsWithoutDirectionHaveNoSign) {
  const ReportInput input = test::example();
  const std::string html = render_report(input);
  for (const char* words : {"horizontal +", "in plane +", "in space +"}) EXPECT_FALSE(contains(html, words)) << words;
  for (const auto& anchor : input.deviation->anchors)
    for (const auto& axis : anchor->axes) {
      const std::string with_sign = mm_with_u(axis->value, axis->u, 1);
      if (axis->axis != "horizontal" || !with_sign.starts_with('+')) continue;
      EXPECT_TRUE(contains(html, "<td>" + with_sign.substr(1) + "</td>")) << anchor->id << " " << with_sign;
    }
}

TEST(Report, ShimsSayWhichWayAndStayBesideTheirAnchor) {
  ReportInput input = test::example();
  auto& panel = *input.deviation->panels.at(0);
  panel.verdict = ToleranceVerdict::fail, panel.decided_by = "warp", panel.missing.clear();
  const double shims[] = {0.0009, -0.0026, 0.0002, -0.0062};
  std::string names[4];
  for (std::size_t i = 0; i < 4; ++i) names[i] = panel.fixings.at(i)->anchor, panel.fixings[i]->shim = shims[i];
  const std::string html = render_report(input);
  EXPECT_TRUE(contains(html, "Shim outward " + names[0] + "\u00A00.9\u00A0mm; set inward " + names[1] + "\u00A02.6, " +
                                 names[3] + "\u00A06.2\u00A0mm."));
  EXPECT_TRUE(contains(html, "<span class=\"whole\">" + names[1] + " \u22122.6,</span>"));
  EXPECT_TRUE(contains(html, "<span class=\"whole\">" + names[3] + " \u22126.2</span>"));
}

TEST(Report, PrintBreaksNoNumber) {
  const std::string html = render_report(test::example());
  const std::string print = html.substr(html.find("@media print"), html.find("</style>") - html.find("@media print"));
  EXPECT_TRUE(contains(print, "td:not(.text):not(.words){white-space:nowrap}"));
  EXPECT_FALSE(contains(print, "overflow-wrap:anywhere"));
}

TEST(Report, LosesNoNameInTheFacade) {
  const ReportInput input = test::example();
  const std::string html = render_report(input);
  const std::string facade =
      html.substr(html.find("id=\"facade\""), html.find("id=\"panels\"") - html.find("id=\"facade\""));
  for (const auto& anchor : input.deviation->anchors) {
    const std::string name = anchor->id.substr(4);  // without "F01-"
    std::size_t times = 0;
    for (std::size_t at = 0; (at = facade.find(">" + name, at)) != std::string::npos; ++at) ++times;
    EXPECT_GE(times, 3u) << anchor->id;  // three drawings
  }
}

TEST(Report, WithoutDesignItIsAboutMeasuring) {
  ReportInput input = test::example();
  input.deviation.reset();
  const std::string html = render_report(input);
  EXPECT_FALSE(contains(html, "id=\"install\""));
  EXPECT_FALSE(contains(html, "id=\"judged\""));
  EXPECT_TRUE(contains(html, "class=\"verdict undecided\""));
}

TEST(Report, WarnsOfTheCauseBeforeItsConsequences) {
  ReportInput input = test::example();
  input.deviation->common_shift->significant = true;
  input.deviation->common_shift->words = "All are shifted.";
  input.deviation->warnings = {"consequence", "All are shifted."};
  const std::string html = render_report(input);
  EXPECT_LT(html.find("<li>All are shifted.</li>"), html.find("<li>consequence</li>"));
}

TEST(Report, FoldsNothingAwayWithoutScript) {
  const std::string html = render_report(test::example());
  const std::string own = html.substr(0, html.find("id=\"network\""));
  EXPECT_FALSE(contains(own, "<details>"));
  EXPECT_TRUE(contains(own, "<details open=\"open\" class=\"fold\">"));
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
  for (auto& a : input.deviation->anchors) a->id = a->guid = a->note = a->class_ = a->found_by = attack + a->id;
  for (auto& p : input.deviation->panels) {
    p->name = p->reason = attack;
    for (auto& fixing : p->fixings) fixing->anchor = attack + fixing->anchor;
  }
  input.deviation->warnings = {attack};
  for (auto& p : input.network->points) p.id = attack;
  for (auto& o : input.network->observations) o.from = o.to = o.kind = o.source = attack;
  for (auto& g : input.network->groups) g.name = attack;
  input.network->findings = {{attack, attack}};
  input.network->datum = input.network->steps[0].action = attack;
  input.provenance = {{attack, attack}};
  input.files = {{attack, attack, 1, attack}};
  const std::string html = render_report(input);
  EXPECT_FALSE(contains(html, "<script>alert"));
  EXPECT_TRUE(contains(html, "&lt;script&gt;alert"));
}

TEST(Report, ElementsAreBalancedAndNumbersAreFinite) {
  const std::string html = render_report(test::example());
  const std::regex tag("<(/?)([a-z0-9]+)([^>]*)>");
  std::vector<std::string> open;
  std::string body = html.substr(html.find("<body"), html.rfind("<script>") - html.find("<body"));
  for (std::size_t data; (data = body.find("<script type=")) != std::string::npos;)
    body.erase(data, body.find("</script>", data) + 9 - data);
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

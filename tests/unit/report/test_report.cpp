// The report says what the evaluation found, holds no request to the outside, and survives hostile and incomplete
// input.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <regex>

#include "../bim/doubt.hpp"
#include "building/ifc/facade_artifact.hpp"
#include "building/judgement/deviation.hpp"
#include "example.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/report.hpp"
#include "show/report/script_data.hpp"
#include "test_support.hpp"

namespace plumbline::report {
namespace test_report {

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

/// Runs the slider of a page as a browser does (a value that is not on the range is moved onto it) and says, a line
/// each, the badges that were replaced and the words: on load, then with the slider at `tolerances` [mm].
std::string slider_says(const std::string& html, const std::string& tolerances) {
  const plumbline::test::TemporaryFolder folder;
  const auto page = folder.path() / "page.html", script = folder.path() / "browser.js", out = folder.path() / "out.txt";
  std::ofstream(page) << html;
  std::ofstream(script) << R"js(
const html = require("fs").readFileSync(process.argv[2], "utf8"), badges = {};
const attr = name => html.match(new RegExp('id="tau-input"[^>]*? ' + name + '="([^"]*)"'))[1];
const onRange = v => {
  const low = Number(attr("min")), high = Number(attr("max")), step = attr("step");
  v = Math.min(high, Math.max(low, v));
  return String(step === "any" ? v : low + Number(step) * Math.round((v - low) / Number(step)));
};
const input = { value: onRange(Number(attr("value"))), addEventListener(name, f) { this[name] = f; } }, output = {};
const cells = JSON.parse(html.match(/id="judged">([\s\S]*?)<\/script>/)[1]).anchors.map((_, i) =>
  ({ dataset: { anchor: String(i) }, replaceChildren(b) { badges[i] = b.w; } }));
const nodes = { judged: { textContent: html.match(/id="judged">([\s\S]*?)<\/script>/)[1] }, canvas: { getContext: () => null },
  badges: { children: [0, 1, 2, 3].map(w => ({ cloneNode: () => ({ w }) })) },
  spoken: (found => found && { textContent: found[1] })(html.match(/id="spoken">([\s\S]*?)<\/script>/)),
  "tau-slider": { querySelector: s => s === "input" ? input : output } };
global.document = { getElementById: id => nodes[id] || null, querySelectorAll: s => s === "td[data-anchor]" ? cells : [] };
const from = html.indexOf('"use strict";', html.lastIndexOf("getElementById(\"judged\")") - 200);
const rule = html.match(/const verdictAt = [\s\S]*?\n};/)[0], words = html.match(/const spoken = [\s\S]*?(?=\n\(\(\) => \{)/)[0];
new Function(words + "\n" + rule + html.slice(from, html.indexOf("</script>", from)))();
const tell = () => console.log(JSON.stringify(badges) + " " + output.textContent);
tell();
for (const mm of process.argv.slice(3)) { input.value = onRange(Number(mm)); input.input(); tell(); }
)js";
  const std::string command = "node " + script.string() + " " + page.string() + " " + tolerances + " > " + out.string();
  EXPECT_EQ(std::system(command.c_str()), 0);
  return plumbline::test::read_file(out);
}

/// What the program judged stands in the page until somebody moves the slider, whatever the tolerance is.
TEST(Report, ThePageKeepsItsVerdictsUntilTheSliderIsMoved) {
  if (std::system("node --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "node is not installed";
  for (const double tau : {0.0005, 0.00254, 0.005, 0.030}) {
    ReportInput input = test::example();
    input.deviation->tau = tau;
    const std::string said = slider_says(render_report(input), "");
    EXPECT_TRUE(contains(said, "{} ")) << tau << ": " << said;
    EXPECT_TRUE(contains(said, "(in force)")) << tau << ": " << said;
  }
}

/// The slider speaks as the page does: decimal comma and inches.
TEST(Report, TheSliderSpeaksAsThePageDoes) {
  if (std::system("node --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "node is not installed";
  const ReportInput input = test::example();
  {
    const Speaking speaking({Language::german, Units::millimetres});
    const std::string said = slider_says(render_report(input), "7.5");
    EXPECT_TRUE(contains(said, "±5\u00A0mm (gilt): Anker ")) << said;
    EXPECT_TRUE(contains(said, "±7,5\u00A0mm: Anker ")) << said;
    EXPECT_TRUE(contains(said, "außerhalb") && contains(said, "; Paneele ") && !contains(said, "undecided")) << said;
  }
  const Speaking speaking({Language::english, Units::inches});
  const std::string said = slider_says(render_report(input), "6.35");
  EXPECT_TRUE(contains(said, "±0.1969\u00A0in (in force): anchors ")) << said;
  EXPECT_TRUE(contains(said, "±0.250\u00A0in: anchors ")) << said;
}

/// What is refused stays undecided at any tolerance; with doubts nothing passes or fails.
TEST(Report, TheSliderDecidesNothingThatMoreThanNumbersHoldsDown) {
  if (std::system("node --version > /dev/null 2>&1") != 0) GTEST_SKIP() << "node is not installed";
  ReportInput input = test::example();
  auto& refused = *input.deviation->anchors.at(0);
  refused.verdict = ToleranceVerdict::undecided, refused.tau_pass = std::numeric_limits<double>::infinity();
  const std::string said = slider_says(render_report(input), "19.9 5");
  EXPECT_TRUE(contains(said, "{\"0\":2,\"1\":1,")) << said;
  for (auto& anchor : input.deviation->anchors) {
    if (anchor->verdict == ToleranceVerdict::not_measured) continue;
    anchor->verdict = ToleranceVerdict::undecided;
    anchor->tau_pass = std::numeric_limits<double>::infinity(), anchor->tau_fail = 0;
  }
  for (auto& panel : input.deviation->panels)
    panel->verdict = ToleranceVerdict::undecided, panel->tau_pass = std::numeric_limits<double>::infinity(),
    panel->tau_fail = 0;
  input.deviation->doubts.push_back(std::make_unique<MeasurementDoubtT>(plumbline::test::doubt("contradicts itself")));
  const std::string doubted = slider_says(render_report(input), "1 19.9");
  EXPECT_FALSE(contains(doubted, "\u00A0pass") || contains(doubted, "\u00A0fail")) << doubted;
}

/// "Decided once u is below X": with X the verdict is one, and a larger uncertainty than the one it has is no advice.
TEST(Report, SaysWhichUncertaintyWouldDecide) {
  const auto advice = [](const Eigen::Vector3d& deviation, double u, const std::string& rule) {
    ReportInput input = test::example();
    judgement::ToleranceTable table;
    if (!rule.empty()) table.rules = {judgement::parse_rule(rule)};
    const ifc::FacadeFrame frame = ifc::frame_facing({0, -1, 0}, ifc::FacadeSource::rule, true);
    auto judged = std::make_unique<AnchorDeviationT>();
    judgement::judge_anchor(deviation, u * u * Eigen::Matrix3d::Identity(), frame, judgement::tolerances_of(table, {}),
                            {}, *judged);
    EXPECT_EQ(judged->verdict, ToleranceVerdict::undecided);
    judged->id = "Q1", judged->facade = ifc::to_artifact(frame), judged->floor = 1;
    judged->design = {0, 0, 0}, judged->as_built = deviation, judged->target_offset.setZero();
    input.deviation->panels.clear(), input.deviation->anchors.clear();
    input.deviation->anchors.push_back(std::move(judged));
    const std::string html = render_report(input);
    const std::size_t at = html.find("<tbody>", html.find("Where not, and what to do"));
    return html.substr(at, html.find("</tr>", at) - at);
  };
  // Two axes, each within by more than its share, both at once not: u has to come down, not up.
  const std::string both = advice({0, 0, 0}, 2.1e-3, "");
  std::smatch found;
  ASSERT_TRUE(std::regex_search(both, found, std::regex("decided once u is below ([0-9.]+)"))) << both;
  EXPECT_LT(std::stod(found[1]), 2.1);
  EXPECT_GT(std::stod(found[1]), 1.5);
  // Near the lower of two sides: 1 mm from −2 mm, not 6 mm from the upper.
  const std::string low = advice({0, 0, -1e-3}, 0.8e-3, "*: vertical=+5/-2mm, horizontal=0mm");
  ASSERT_TRUE(std::regex_search(low, found, std::regex("decided once u is below ([0-9.]+)"))) << low;
  EXPECT_NEAR(std::stod(found[1]), 1 / 1.645, 0.02);
  const std::string limit = advice({0, 0, -2e-3}, 0.8e-3, "*: vertical=+5/-2mm, horizontal=0mm");
  EXPECT_FALSE(contains(limit, "decided once")) << limit;
}

/// Numbers across a facade of which nobody knows the outside have no sign, and nothing claims one.
TEST(Report, ClaimsNoOutwardWhereTheFacadeIsNotConfirmed) {
  ReportInput input = test::example();
  const auto elevation = [&] {
    const std::string html = render_report(input);
    const std::size_t at = html.find("how far out of its plane?");
    return html.substr(at, html.find("</figure>", at) - at);
  };
  EXPECT_TRUE(contains(elevation(), "outward positive"));
  for (auto& facade : input.deviation->facades) facade->confirmed = false, facade->note = "guessed";
  for (auto& anchor : input.deviation->anchors) anchor->facade->confirmed = false;
  EXPECT_FALSE(contains(elevation(), "outward positive")) << elevation();
  EXPECT_TRUE(contains(elevation(), "without a sign"));
  // The tables of anchors and panels, and the work list.
  auto& anchor = *input.deviation->anchors.at(0);
  for (auto& axis : anchor.axes)
    if (axis->axis == "out_of_plane") axis->value = 0.0123, axis->u = 4e-4, axis->tolerance = 0.005;
  anchor.verdict = ToleranceVerdict::fail, anchor.decided_by = "out_of_plane";
  auto& panel = *input.deviation->panels.at(0);
  panel.facade->confirmed = false, panel.out_of_plane->value = 0.0117, panel.out_of_plane->u = 4e-4;
  const std::string html = render_report(input);
  EXPECT_TRUE(contains(html, "12.3") && contains(html, "11.7"));
  EXPECT_FALSE(contains(html, "+12.3")) << "an anchor's";
  EXPECT_FALSE(contains(html, "+11.7")) << "a panel's";
}

/// What the design asks for and nobody judges is not mended by measuring again.
TEST(Report, DoesNotSendAnybodyToMeasureWhatIsNotJudged) {
  ReportInput input = test::example();
  auto& anchor = *input.deviation->anchors.at(0);
  anchor.verdict = ToleranceVerdict::undecided, anchor.decided_by = "not_judged", anchor.note = "not judged: a: b";
  const std::string html = render_report(input);
  const std::size_t at = html.find("Anchor " + anchor.id + "</th>");
  ASSERT_NE(at, std::string::npos);
  const std::string row = html.substr(at, html.find("</tr>", at) - at);
  EXPECT_FALSE(contains(row, "Measure it")) << row;
  EXPECT_TRUE(contains(row, "not judged: a: b")) << row;
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
  const auto add = [&](const char* name, const char* camera, double value, double sigma) {
    auto parameter = std::make_unique<InteriorParameterT>();
    parameter->name = name, parameter->camera = camera, parameter->value = value, parameter->sigma = sigma,
    parameter->estimated = sigma > 0;
    input.block->interior_orientation.push_back(std::move(parameter));
  };
  add("fx", "crane", 3082.2971, 0.0361), add("p1", "crane", 0.00021234, 2.04e-6), add("k3", "crane", 0, 0);
  add("fx", "ground", 3082.3581, 0.0921), add("p1", "ground", 0.00020391, 5.0e-6), add("k3", "ground", 0, 0);
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

/// Rows that the search goes by say where they belong.
TEST(Report, EveryAnchorAndPanelCanBeSoughtByFacadeFloorAndVerdict) {
  const ReportInput input = test::example();
  const std::string html = render_report(input);
  EXPECT_TRUE(contains(html, "id=\"filter\" hidden=\"hidden\"")) << "without scripts there is no search";
  const std::string anchors = html.substr(html.find("id=\"anchors\"")),
                    panels = html.substr(html.find("id=\"panels\""));
  const auto row = [](int floor, const auto& element, const char* verdict, const std::string& name) {
    return "<tr data-floor=\"" + std::to_string(floor) + "\" data-facade=\"" +
           (element.facade ? element.facade->facade : "") + "\" data-verdict=\"" + verdict + "\"><th scope=\"row\">" +
           name;
  };
  const char* words[] = {"not measured", "pass", "undecided", "fail"};
  for (const auto& a : input.deviation->anchors) {
    EXPECT_TRUE(contains(anchors, row(a->floor, *a, words[static_cast<int>(a->verdict)], a->id))) << a->id;
  }
  for (const auto& p : input.deviation->panels) {
    EXPECT_TRUE(contains(panels, row(p->floor, *p, words[static_cast<int>(p->verdict)], p->name))) << p->name;
  }
}

/// Of thousands, drawings are shapes and lists have an end; every anchor keeps its row.
TEST(Report, OfThousandsThePageStaysReadable) {
  ReportInput input = test::example();
  const auto one = input.deviation->anchors.at(0).get();
  one->verdict = ToleranceVerdict::fail;
  const std::size_t more = 1200;
  for (std::size_t i = 0; i < more; ++i) {
    auto copy = std::make_unique<AnchorDeviationT>(*one);
    copy->id = "G99-" + std::to_string(i), copy->design.x() += 0.5 * static_cast<double>(i % 60);
    copy->design.z() += static_cast<double>(i / 60);
    input.deviation->anchors.push_back(std::move(copy));
  }
  const std::string html = render_report(input);
  const auto times = [&](const std::string& text, const std::string& part) {
    std::size_t n = 0;
    for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; ++at) ++n;
    return n;
  };
  const std::string drawn =
      html.substr(html.find("id=\"facade\""), html.find("id=\"panels\"") - html.find("id=\"facade\""));
  EXPECT_FALSE(contains(drawn, "G99-"));
  EXPECT_LT(drawn.size(), 300'000u);
  EXPECT_EQ(times(html.substr(html.find("id=\"anchors\"")), "<th scope=\"row\">G99-"), more);
  EXPECT_LE(times(html.substr(0, html.find("id=\"view\"")), "<tr data-floor"), 308u);
  EXPECT_TRUE(contains(html, "below and stake_out.csv hold all"));
  EXPECT_TRUE(contains(html, "Every number of every anchor stands in metrics.csv and stake_out.csv"));
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

}  // namespace test_report
}  // namespace plumbline::report

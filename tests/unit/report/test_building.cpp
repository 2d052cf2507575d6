// What of a building the page and the sheets show beside verdicts: changes since the campaign before, floors and axes,
// what stands around the anchors, one sheet for each facade and floor.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "example.hpp"
#include "geometry/statistics.hpp"
#include "show/report/facade_drawing.hpp"
#include "show/report/report.hpp"
#include "show/report/sections.hpp"
#include "show/report/sheets_page.hpp"
#include "show/report/summary.hpp"

namespace plumbline::report {
namespace test_building {

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

int count_of(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++n;
  return n;
}

/// Anchors stand at x = 2, 4, 6, 8; A runs along the facade, 1 to 4 across it.
std::vector<ifc::GridAxis> grid_of_example() {
  std::vector<ifc::GridAxis> grid = {{"A", "u", {0, 0, 0}, {1, 0, 0}}, {"B", "u", {0, 9, 0}, {1, 0, 0}}};
  for (int i = 1; i <= 4; ++i) grid.push_back({std::to_string(i), "v", {2.0 * i, -5, 0}, {0, 1, 0}});
  return grid;
}

std::unique_ptr<AsBuiltChangeT> change(const AnchorDeviationT& anchor, ToleranceVerdict before, ChangeKind kind) {
  auto out = std::make_unique<AsBuiltChangeT>();
  out->kind = "anchor", out->id = anchor.id, out->floor = anchor.floor, out->before = before;
  out->after = anchor.verdict, out->change = kind;
  out->movement.setConstant(NAN);
  return out;
}

TEST(Building, ThePageSaysFirstWhatIsToBeLookedAtSinceTheCampaignBefore) {
  ReportInput input = test::example();
  const auto& anchors = input.deviation->anchors;
  AsBuiltChangesT changes;
  changes.compared = true, changes.before = "May <2026>", changes.measured_twice = 3;
  changes.changes.push_back(change(*anchors[0], ToleranceVerdict::fail, ChangeKind::mended));
  changes.changes.push_back(change(*anchors[1], ToleranceVerdict::pass, ChangeKind::opened_again));
  changes.changes.push_back(change(*anchors[2], ToleranceVerdict::pass, ChangeKind::in_order));
  changes.changes.push_back(change(*anchors[3], ToleranceVerdict::pass, ChangeKind::in_order));
  changes.changes[3]->moved = true, changes.changes[3]->movement = {0.004, 0, 0}, changes.changes[3]->u = 0.0005;
  input.changes = changes;
  const std::string html = render_report(input);
  EXPECT_TRUE(contains(html, "Since May &lt;2026&gt;: 1 mended, 1 opened again, 1 anchor has moved."));
  const std::string part = html.substr(html.find("<section id=\"changes\""));
  const std::string rows = part.substr(0, part.find("</section>"));
  const auto at = [&](std::size_t i) { return rows.find("Anchor " + anchors[i]->id + "<"); };
  EXPECT_LT(at(1), at(3));
  EXPECT_LT(at(3), at(0));
  EXPECT_EQ(at(2), std::string::npos) << "in order, where it was";
  EXPECT_TRUE(contains(rows, "moved 4.0 ± 0.5"));
  const std::string summary = summary_text(input.accuracy, &*input.deviation, &*input.changes);
  EXPECT_TRUE(contains(summary, "Since May <2026>: 1 mended, 1 opened again, 1 anchor has moved.\n")) << summary;
  input.changes->compared = false;
  EXPECT_FALSE(contains(render_report(input), "id=\"changes\"")) << "no campaign before";
}

TEST(Building, FloorsAndAxesHaveTheirMeansAndPlacesTheirNames) {
  ReportInput input = test::example();
  input.grid = grid_of_example();
  const std::string html = render_report(input);
  const std::string places = html.substr(html.find("<section id=\"places\""));
  const std::string table = places.substr(0, places.find("</section>"));
  for (const char* name : {">Floor 1<", ">Axis 1<", ">Axis 4<"}) EXPECT_TRUE(contains(table, name)) << name;
  EXPECT_FALSE(contains(table, ">Axis A<")) << "it runs along the facade";
  EXPECT_LT(table.find(">Axis 1<"), table.find(">Axis 4<"));
  EXPECT_TRUE(contains(html, " at A/")) << "the list of what to do says where";
  EXPECT_TRUE(contains(html, ">Grid</th>"));
  const std::string plain = render_report(test::example());
  EXPECT_FALSE(contains(plain, ">Grid</th>"));
  EXPECT_TRUE(contains(plain, ">Floor 1<"));
}

TEST(Building, TheViewInSpaceHasTheBuildingItsGridAndNorth) {
  DesignT design;
  const auto add = [&](double size, bool anchor) {
    auto element = std::make_unique<DesignElementT>();
    element->is_anchor = anchor;
    element->placement = {Eigen::Quaterniond::Identity(), {10, 0, 0}};
    element->box_low.setZero(), element->box_high = Eigen::Vector3d(size, 2, 3);
    design.elements.push_back(std::move(element));
  };
  add(5, true), add(4, false), add(8, false);
  design.elements.push_back(std::make_unique<DesignElementT>());
  design.elements.back()->box_low.setConstant(NAN);
  design.true_north = 0.5;
  const BuildingLines lines = building_lines(design, 1);
  ASSERT_EQ(lines.edges.size(), 12u) << "the largest alone; neither anchors nor what has no shape";
  double length = 0, farthest = 0;
  std::set<std::vector<double>> different;
  for (const auto& [from, to] : lines.edges) {
    length += (to - from).norm(), farthest = std::max(farthest, to.x());
    different.insert({from.x(), from.y(), from.z(), to.x(), to.y(), to.z()});
  }
  EXPECT_NEAR(length, 4 * (8 + 2 + 3), 1e-12);
  EXPECT_NEAR(farthest, 18, 1e-12);
  EXPECT_EQ(different.size(), 12u);
  ReportInput input = test::example();
  EXPECT_FALSE(contains(render_report(input), "id=\"around-input\""));
  input.grid = grid_of_example(), input.building = lines;
  const std::string html = render_report(input);
  EXPECT_TRUE(contains(html, "\"north\":0.500000"));
  EXPECT_TRUE(contains(html, "\"grid\":[[\"A\",["));
  EXPECT_TRUE(contains(html, "id=\"around-input\""));
}

/// Every anchor and every panel on one sheet and no other, also those of no known floor or facade.
TEST(Building, SheetsHoldEverythingOnce) {
  ReportInput input = test::example();
  input.title = "Tower \"A\"; </style>", input.grid = grid_of_example();
  input.deviation->anchors[0]->floor = 0;
  input.deviation->anchors[1]->facade = nullptr;
  const std::string html = render_sheets(input);
  std::set<std::pair<std::string, int>> wanted;
  for (const auto& anchor : input.deviation->anchors) {
    EXPECT_EQ(count_of(html, "<th scope=\"row\">Anchor " + anchor->id + "</th>"), 1) << anchor->id;
    wanted.insert({anchor->facade ? anchor->facade->facade : "", anchor->floor});
  }
  for (const auto& panel : input.deviation->panels)
    EXPECT_EQ(count_of(html, "<th scope=\"row\">Panel " + panel->name + "</th>"), 1) << panel->name;
  EXPECT_GE(count_of(html, "<section class=\"sheet\">"), static_cast<int>(wanted.size()));
  const int sheets = count_of(html, "<section class=\"sheet\">");
  EXPECT_TRUE(contains(html, "; sheet " + std::to_string(sheets) + " of " + std::to_string(sheets) + "<"));
  EXPECT_TRUE(contains(html, "unknown floor"));
  EXPECT_TRUE(contains(html, "No facade that is known"));
  EXPECT_TRUE(contains(html, "@top-left{content:\"Tower \\22 A\\22 \\3b  \\3c \\2f style\\3e "))
      << "nothing of the title ends the style";
}

/// Who carries the sheet does not see the page.
TEST(Building, SheetsSayWhatWasNotJudgedAndWhyAllIsLessCertain) {
  ReportInput input = test::example();
  input.deviation->requests.push_back(std::make_unique<JudgementRequestT>());
  input.deviation->requests.back()->asked = "class=IfcMechanicalFastenr: vertical=1mm";
  input.deviation->requests.back()->not_judged = "selects nothing";
  input.deviation->misfits.push_back(std::make_unique<MeasurementDoubtT>());
  input.deviation->misfits.back()->grade = DoubtGrade::misfit;
  input.deviation->misfits.back()->reason = "the residuals are large", input.deviation->misfits.back()->factor = 1.34;
  const std::string html = render_sheets(input);
  const int sheets = count_of(html, "<section class=\"sheet\">");
  EXPECT_EQ(count_of(html, "Not judged: class=IfcMechanicalFastenr: vertical=1mm: selects nothing."), sheets);
  EXPECT_EQ(count_of(html, "are 1.34 times as large for it."), sheets);
}

/// 30 mm at a limit of 4 mm was "too close to call" where nobody knows which way the facade faces.
TEST(Building, WhatIsUndecidedForItsFacadeIsNotTooCloseToCall) {
  ReportInput input = test::example();
  DeviationT& deviation = *input.deviation;
  deviation.verdict = ToleranceVerdict::undecided, deviation.requests.clear(), deviation.not_judged = 0;
  deviation.undecided = 2, deviation.not_measured = 0;
  const auto heading = [&] {
    int n = 0;
    for (const auto& anchor : deviation.anchors) {
      anchor->verdict = n < 2 ? ToleranceVerdict::undecided : ToleranceVerdict::pass;
      anchor->pass_probability = n++ == 0 ? std::numeric_limits<double>::quiet_NaN() : 0.6;
      anchor->facade = std::make_unique<FacadeFrameT>();
      anchor->facade->right.setZero(), anchor->facade->up.setZero(), anchor->facade->out.setZero();
    }
    const std::string html = render_report(input);
    const std::size_t at = html.find("Not decided: ");
    return at == std::string::npos ? std::string() : html.substr(at, html.find('<', at) - at);
  };
  EXPECT_EQ(heading(), "Not decided: 1\u00A0anchor whose facade is not confirmed, 1\u00A0anchor too close to call.");
}

/// A floor of 25 anchors is 30 m wide: on one strip across a sheet its names were 0.7 mm high.
TEST(Building, AWideFloorIsDrawnInStretchesOfOneScale) {
  FacadeView view;
  view.sight.right = Eigen::Vector3d::UnitX();
  for (int i = 0; i < 25; ++i) {
    Spot spot;
    spot.id = "F01-C" + std::to_string(i), spot.floor = 1, spot.position = {1.2 * i, 0, 1};
    spot.difference = {1e-3 * i, 0, 0}, spot.verdict = ToleranceVerdict::pass;
    view.spots.push_back(spot);
    const Eigen::Vector3d p = spot.position, x(1.16, 0, 0), z(0, 0, 2.96);
    if (i < 24) view.panels.push_back({"P" + std::to_string(i), ToleranceVerdict::pass, {p, p + x, p + x + z, p + z}});
  }
  const Elevation whole = elevation_of({}, view);
  const auto stretches = stretches_of(whole);
  EXPECT_EQ(stretches.size(), 3u);
  Markup drawings;
  std::set<std::string> names;
  for (const Elevation& e : stretches) {
    EXPECT_LT(e.width, 1400) << "names of 13 px on 182 mm";
    EXPECT_DOUBLE_EQ(e.exaggeration, stretches[0].exaggeration);
    EXPECT_NEAR(e.pixels_per_metre, stretches[0].pixels_per_metre, 1e-9);
    for (const Spot& spot : e.spots) EXPECT_TRUE(names.insert(spot.id).second) << spot.id << " twice";
    draw_elevation(drawings, e, view, test::example());
  }
  EXPECT_EQ(names.size(), view.spots.size());
  const std::string drawn = drawings.str();
  EXPECT_EQ(count_of(drawn, "<polygon class=\"quad "), 24) << "every panel in one stretch";
  for (int i = 0; i < 24; ++i) EXPECT_EQ(count_of(drawn, "\u25cf P" + std::to_string(i) + "<"), 1) << i;
  EXPECT_EQ(stretches_of(elevation_of({}, built_view(*test::example().deviation, nullptr, false))).size(), 1u);
}

/// Ten thousand rows are 600 sheets of paper that nobody reads: of each table the first 200, and the page says so.
TEST(Building, ThousandsOfRowsAreNotPrinted) {
  ReportInput input = test::example();
  EXPECT_FALSE(contains(render_report(input), "<main class=\"many\">"));
  EXPECT_FALSE(contains(render_report(input), "add(\"waiting\")"));
  while (!many(*input.deviation))
    input.deviation->panels.push_back(std::make_unique<PanelDeviationT>(*input.deviation->panels[0]));
  const std::string html = render_report(input);
  EXPECT_TRUE(contains(html, "<main class=\"many\">"));
  // On a screen the others are not even laid out: said before the tables, taken back by the page's script.
  EXPECT_LT(html.find("classList.add(\"waiting\")"), html.find("<tr data-floor"));
  EXPECT_TRUE(contains(html, ".waiting tr[data-floor]:nth-child(n+201){display:none}"));
  EXPECT_TRUE(contains(html, "classList.remove(\"waiting\")"));
  EXPECT_TRUE(contains(html, "sheets.html has all, a sheet for each facade and floor"));
}

}  // namespace test_building
}  // namespace plumbline::report

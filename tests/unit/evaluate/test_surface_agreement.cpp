// A facade whose anchors and panels all pass, and surfaces that do not: every output withholds "ready to install", and
// says so with the same verdict.
#include <gtest/gtest.h>

#include "../bim/measured.hpp"
#include "../bim/small_building.hpp"
#include "artifacts/surfaces.hpp"
#include "build/evaluate/metrics.hpp"
#include "building/ifc/as_built_ifc.hpp"
#include "building/ifc/bcf.hpp"
#include "building/judgement/surfaces.hpp"
#include "building/judgement/worst_first.hpp"
#include "show/report/report.hpp"
#include "show/report/summary.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_surface_agreement {

bool says(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

struct SurfaceCase {
  std::string bytes = plumbline::test::small_building("IFC4", plumbline::test::kThirdAnchor);
  ifc::Design design = ifc::read_design(step::File(bytes, "t.ifc"), {});
  std::string panel;
  DeviationT deviation;
  SurfaceJudgementT surfaces;

  explicit SurfaceCase(const std::vector<MeasurementDoubtT>& doubts = {}) {
    std::map<std::string, Eigen::Vector3d> deviations;
    for (const ifc::Element& element : design.elements) {
      if (element.is_anchor) deviations[element.guid] = Eigen::Vector3d(1e-4, 1e-4, 1e-4);
      if (element.name == "Panel 1") panel = element.guid;
    }
    deviation = plumbline::test::judged(design, deviations, Eigen::Vector3d::Constant(1e-4), {0, -1, 0}, {}, doubts);
  }
  void add(ToleranceVerdict verdict, const std::string& not_judged = "", const std::string& second = "") {
    auto v = std::make_unique<SurfaceVerdictT>();
    v->panel = "Panel 1", v->guid = second.empty() ? panel : "", v->second = second;
    v->quantity = second.empty() ? "flatness" : "step", v->rule = "*: flatness(1m)=3mm, step=2mm";
    if (second.empty()) v->length = 1;
    v->value = 0.0042, v->sigma = 2e-4, v->upper = 0.003, v->lower = -0.003, v->probability = 0.5;
    v->verdict = verdict, v->not_judged = not_judged;
    ++(verdict == ToleranceVerdict::pass   ? surfaces.passed
       : verdict == ToleranceVerdict::fail ? surfaces.failed
       : not_judged.empty()                ? surfaces.undecided
                                           : surfaces.not_judged);
    surfaces.verdicts.push_back(std::move(v));
  }
  void ask(const std::string& not_judged) {
    surfaces.requests.push_back(std::make_unique<JudgementRequestT>());
    surfaces.requests.back()->asked = "*: flatness(1m)=3mm, step=2mm", surfaces.requests.back()->by = "rule";
    surfaces.requests.back()->not_judged = not_judged;
  }
  /// All outputs, one after the other.
  std::map<std::string, std::string> outputs() {
    judgement::take_surfaces(std::move(surfaces), deviation);
    const AccuracyT accuracy = evaluate_accuracy(test::small_building(), {});
    std::map<std::string, std::string> out;
    const step::File file(bytes, "t.ifc");
    ifc::AsBuiltIfcOptions options;
    options.surface_judgement = deviation.surfaces.get();
    out["ifc"] = ifc::enriched(file, ifc::write_as_built(file, design, deviation, accuracy, options));
    ifc::BcfOptions bcf;
    bcf.project_guid = design.project_guid, bcf.surface_judgement = deviation.surfaces.get();
    out["bcf"] =
        ifc::write_bcf(deviation, judgement::worst_first(deviation), judgement::worst_panels_first(deviation), bcf);
    out["junit"] = junit_xml(accuracy, &deviation);
    report::ReportInput input;
    input.deviation = deviation;
    out["page"] = report::render_report(input);
    out["summary"] = report::summary_text(accuracy, &deviation);
    return out;
  }
};

TEST(SurfaceAgreement, WithoutThemTheFacadeIsReady) {
  SurfaceCase facade;
  ASSERT_EQ(facade.deviation.verdict, ToleranceVerdict::pass) << "else this file tests nothing";
  facade.add(ToleranceVerdict::pass);
  facade.ask("");
  const auto out = facade.outputs();
  EXPECT_EQ(facade.deviation.verdict, ToleranceVerdict::pass);
  EXPECT_TRUE(says(out.at("page"), "Ready to install: all ")) << out.at("summary");
  EXPECT_TRUE(says(out.at("page"), "1\u00A0surface or joint are within")) << "surfaces are among what passes";
  EXPECT_TRUE(says(out.at("summary"), "Installation: pass.")) << out.at("summary");
  EXPECT_TRUE(says(out.at("junit"), "<testsuite name=\"surfaces\" tests=\"1\" failures=\"0\""));
}

TEST(SurfaceAgreement, OneThatFailsWithholdsItEverywhere) {
  SurfaceCase facade;
  facade.add(ToleranceVerdict::pass), facade.add(ToleranceVerdict::fail), facade.ask("");
  const auto out = facade.outputs();
  EXPECT_EQ(facade.deviation.verdict, ToleranceVerdict::fail);
  EXPECT_FALSE(says(out.at("page"), "Ready to install"));
  EXPECT_TRUE(says(out.at("page"), "Not ready: 1\u00A0surface or joint is out of tolerance."));
  EXPECT_TRUE(says(out.at("page"), "Surface Panel 1")) << "and in the list of what to do";
  EXPECT_TRUE(says(out.at("summary"), "Installation: FAIL.")) << out.at("summary");
  EXPECT_TRUE(says(out.at("summary"), "Panel 1              FAIL       flatness(1m) 4.20 +- 0.20 mm"))
      << out.at("summary");
  EXPECT_TRUE(says(out.at("junit"), "name=\"Panel 1, flatness(1m)\"><failure type=\"fail\"")) << out.at("junit");
  EXPECT_TRUE(says(out.at("ifc"), "'SurfacesFailed',$,IFCINTEGER(1)")) << "in ASB_Judgement";
  const auto floor = std::find_if(facade.deviation.floors.begin(), facade.deviation.floors.end(),
                                  [](const auto& f) { return f->surfaces_failed == 1; });
  ASSERT_NE(floor, facade.deviation.floors.end());
  EXPECT_EQ((*floor)->verdict, ToleranceVerdict::fail);
}

/// One thing is, several are: whatever kinds they are of.
TEST(SurfaceAgreement, OneIsAndSeveralAreOutOfTolerance) {
  const auto verb = [](int anchors, int panels, int surfaces) {
    SurfaceCase facade;
    for (int i = 0; i < surfaces; ++i) facade.add(ToleranceVerdict::fail);
    facade.ask("");
    judgement::take_surfaces(std::move(facade.surfaces), facade.deviation);
    DeviationT& d = facade.deviation;
    d.verdict = ToleranceVerdict::fail, d.failed = anchors;
    for (auto& panel : d.panels) panel->verdict = ToleranceVerdict::pass;
    for (int i = 0; i < panels; ++i) d.panels.at(static_cast<std::size_t>(i))->verdict = ToleranceVerdict::fail;
    report::ReportInput input;
    input.deviation = d;
    const std::string page = report::render_report(input);
    const std::size_t begin = page.find("Not ready: "), end = page.find(" out of tolerance.", begin);
    return page.substr(page.rfind(' ', end - 1) + 1, end - page.rfind(' ', end - 1) - 1);
  };
  EXPECT_EQ(verb(1, 0, 0), "is");
  EXPECT_EQ(verb(0, 1, 0), "is");
  EXPECT_EQ(verb(0, 0, 1), "is");
  EXPECT_EQ(verb(2, 0, 0), "are");
  EXPECT_EQ(verb(2, 1, 0), "are");
  EXPECT_EQ(verb(2, 0, 1), "are");
  EXPECT_EQ(verb(0, 1, 1), "are");
}

/// A curtain wall's panel without anchors hangs in a storey all the same.
TEST(SurfaceAgreement, APanelWithoutAnchorsCountsOnTheFloorOfItsStorey) {
  const auto floors = [](const std::string& storey) {
    SurfaceCase facade;
    facade.add(ToleranceVerdict::fail);
    facade.surfaces.verdicts[0]->guid = "of no anchor";
    PanelStoreys storeys;
    const auto row = std::find_if(facade.deviation.floors.begin(), facade.deviation.floors.end(),
                                  [](const auto& floor) { return !floor->storey_guid.empty(); });
    storeys.storey_of["of no anchor"] = storey.empty() ? (*row)->storey_guid : storey;
    storeys.names[(*row)->storey_guid] = "Level 2", storeys.names["roof"] = "Roof";
    take_surfaces(std::move(facade.surfaces), facade.deviation, storeys);
    int failed = 0;
    for (const auto& floor : facade.deviation.floors) failed += floor->surfaces_failed;
    return std::to_string(failed) + " " + (facade.deviation.warnings.empty() ? "" : facade.deviation.warnings.back());
  };
  EXPECT_EQ(floors("").substr(0, 2), "1 ");
  EXPECT_EQ(floors("").find("count in no floor"), std::string::npos) << floors("");
  EXPECT_NE(floors("roof").find("0 1 verdicts of surfaces and joints that do not pass are of storey Roof"),
            std::string::npos)
      << floors("roof");
  EXPECT_NE(floors("unknown").find("nobody says which floor"), std::string::npos) << floors("unknown");
}

TEST(SurfaceAgreement, OneThatIsNotJudgedOrTooCloseWithholdsItToo) {
  SurfaceCase facade;
  facade.add(ToleranceVerdict::not_measured, "no point was measured on it");
  facade.ask("flatness(1m): 1 of 1 are not judged: Panel 1 (no point was measured on it)");
  const auto out = facade.outputs();
  EXPECT_EQ(facade.deviation.verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(facade.deviation.not_judged, 1);
  EXPECT_TRUE(says(out.at("page"), "Not decided: 1\u00A0thing that was asked for was not judged."));
  EXPECT_TRUE(says(out.at("summary"), "NOT JUDGED: surfaces, *: flatness(1m)=3mm")) << out.at("summary");
  EXPECT_TRUE(says(out.at("junit"), "<testsuite name=\"asked_for\" tests=\"1\" failures=\"1\""));
  EXPECT_TRUE(says(out.at("ifc"), "no point was measured on it"));
  SurfaceCase close;
  close.add(ToleranceVerdict::undecided), close.ask("");
  EXPECT_TRUE(says(close.outputs().at("page"), "Not decided: 1\u00A0surface or joint too close to call."));
}

TEST(SurfaceAgreement, OneOnNoFloorThatIsKnownIsToldBesideTheFloors) {
  SurfaceCase facade;
  facade.panel = "a panel without anchors", facade.add(ToleranceVerdict::fail), facade.ask("");
  const auto out = facade.outputs();
  EXPECT_EQ(facade.deviation.verdict, ToleranceVerdict::fail);
  EXPECT_TRUE(says(out.at("page"), "1 verdicts of surfaces and joints that do not pass count in no floor"));
}

TEST(SurfaceAgreement, ADoubtfulMeasurementShowsNoSurfaceToBeInOrderOrOutOfIt) {
  SurfaceCase facade({test::doubt("group tags contradicts the rest", MeasurementPart::image_block)});
  facade.add(ToleranceVerdict::pass), facade.add(ToleranceVerdict::fail);
  const auto out = facade.outputs();
  EXPECT_EQ(facade.deviation.verdict, ToleranceVerdict::undecided);
  EXPECT_EQ(facade.deviation.surfaces->undecided, 2);
  EXPECT_TRUE(std::isnan(facade.deviation.surfaces->verdicts[0]->probability));
  EXPECT_FALSE(says(out.at("page"), "Ready to install"));
}

}  // namespace test_surface_agreement
}  // namespace plumbline::judgement

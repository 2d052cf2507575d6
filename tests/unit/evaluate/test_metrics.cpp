// metrics.json and metrics.csv: valid after the schema, complete, and harmless with odd ids and unknown numbers.
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "../bim/facing.hpp"
#include "build/evaluate/metrics.hpp"
#include "building/judgement/deviation.hpp"
#include "building/judgement/facade_order.hpp"
#include "record.hpp"
#include "small_building.hpp"
#include "test_support.hpp"

namespace plumbline::judgement {
namespace test_metrics {

using nlohmann::json;
using test::mm;

std::string schema_errors(const json& document) {
  const json text = json::parse(
      plumbline::test::read_file(std::string(plumbline::test::source_dir()) + "/schemas/metrics.schema.json"));
  valijson::Schema schema;
  valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema);
  valijson::ValidationResults results;
  valijson::Validator().validate(schema, valijson::adapters::NlohmannJsonAdapter(document), &results);
  std::string errors;
  valijson::ValidationResults::Error error;
  while (results.popError(error)) {
    for (const std::string& part : error.context) errors += part;
    errors += ": " + error.description + "\n";
  }
  return errors;
}

Inputs everything() {
  Inputs inputs = test::small_building();
  test::add_anchor(inputs, "K, \"left\"", 1, 3, AnchorUse::control, {0, 0, 1 * mm});
  test::set_sigmas(inputs, 0.3 * mm, 0.4 * mm);
  inputs.truth = inputs.survey;
  inputs.anchors.push_back({"missing", 2, 3, 1, AnchorUse::check});
  return inputs;
}

TEST(MetricsJson, IsValidAfterItsSchema) {
  Options options;
  options.drift_on_control = true;
  EXPECT_EQ(schema_errors(json::parse(metrics_json(evaluate_accuracy(everything(), options)))), "");
  EXPECT_EQ(schema_errors(json::parse(metrics_json(evaluate_accuracy(test::small_building(), {})))), "");
  Inputs bare = test::small_building(AnchorUse::control);
  bare.model.covariance = {};
  bare.model.positions[0].z() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(schema_errors(json::parse(metrics_json(evaluate_accuracy(bare, {})))), "");
}

/// The small building's anchors on a facade, with a panel on four of them.
DeviationT built() {
  const Inputs measured = test::small_building();
  judgement::DeviationInputs inputs;
  inputs.model = measured.model;
  for (std::size_t i = 0; i < measured.anchors.size(); ++i) {
    judgement::AnchorCase anchor;
    anchor.id = measured.anchors[i].id, anchor.floor = measured.anchors[i].floor, anchor.use = "check";
    anchor.element.guid = "g" + anchor.id;
    anchor.design = measured.survey.positions[i] + Eigen::Vector3d(0, 0, 3.0 * anchor.floor);
    inputs.model.positions[i] += Eigen::Vector3d(0, 0, 3.0 * anchor.floor);
    anchor.tolerances = judgement::tolerances_of({}, {});
    inputs.anchors.push_back(anchor);
  }
  judgement::PanelCase panel;
  panel.guid = "guid", panel.name = "P", panel.anchors = {0, 1, 2, 3};
  panel.low = {2, -0.1, 3}, panel.high = {4, 0, 6}, panel.tolerances = judgement::tolerances_of({}, {});
  inputs.panels.push_back(panel);
  judgement::AnchorCase stranger;
  stranger.id = "=evil", stranger.note = "not in the plate table";
  stranger.design = {9, 0, 3};
  inputs.anchors.push_back(stranger);
  plumbline::test::face(inputs, {0, -1, 0});
  return judgement::judge_deviations(inputs, {});
}

TEST(MetricsJson, AdjustmentRegistrationAndDeviationAreValidToo) {
  AccuracyT accuracy = evaluate_accuracy(everything(), {});
  accuracy.adjustment = std::make_unique<AdjustmentSummaryT>();
  accuracy.adjustment->datum = "free", accuracy.adjustment->weighting = "covariance";
  accuracy.adjustment->statistics = std::make_unique<StatisticsT>();
  accuracy.registration = std::make_unique<RegistrationSummaryT>();
  accuracy.registration->statistics = std::make_unique<StatisticsT>();
  accuracy.registration->residual_covariance = {1e-6, 0, 0, 1e-6, 0, 1e-6};
  const DeviationT deviation = built();
  const json document = json::parse(metrics_json(accuracy, &deviation));
  EXPECT_EQ(schema_errors(document), "");
  EXPECT_EQ(document["panels"].size(), 1u);
  EXPECT_EQ(document["deviation"]["anchors"].size(), 7u);
  EXPECT_TRUE(document["adjustment"]["lambda"].is_null());
}

TEST(MetricsFiles, NoNameBecomesAFormulaOrMarkup) {
  const DeviationT deviation = built();
  const AccuracyT accuracy = evaluate_accuracy(everything(), {});
  EXPECT_NE(metrics_csv(accuracy, &deviation).find("\n'=evil,"), std::string::npos);
  EXPECT_NE(stake_out_csv(deviation).find("'=evil;9.0000;0.0000;3.0000;;;;not_measured"), std::string::npos);
  AccuracyT odd = evaluate_accuracy(everything(), {});
  odd.anchors[0]->id = "a\"<b>&\xff";
  EXPECT_NE(junit_xml(odd).find("name=\"a&quot;&lt;b&gt;&amp;\uFFFD\""), std::string::npos);
}

TEST(Junit, ADoubtIsAnEntryOfItsOwnAndAnchorsSayWhy) {
  DeviationT deviation = built();
  const AccuracyT accuracy = evaluate_accuracy(everything(), {});
  EXPECT_EQ(junit_xml(accuracy, &deviation).find("testsuite name=\"measurement\""), std::string::npos);
  deviation.doubts.push_back(std::make_unique<MeasurementDoubtT>(test::doubt("station 3 contradicts itself")));
  deviation.anchors[4]->verdict = ToleranceVerdict::undecided;
  deviation.anchors[4]->note = "not decided: the survey: station 3 contradicts itself";
  const std::string xml = junit_xml(accuracy, &deviation);
  EXPECT_NE(xml.find("<testsuite name=\"measurement\" tests=\"1\" failures=\"1\""), std::string::npos) << xml;
  EXPECT_NE(xml.find("not to be trusted, the survey: station 3 contradicts itself"), std::string::npos) << xml;
  const std::size_t at = xml.find("name=\"" + deviation.anchors[4]->id + "\"");
  ASSERT_NE(at, std::string::npos);
  EXPECT_NE(xml.substr(at, xml.find("</testcase>", at) - at).find("not decided: the survey"), std::string::npos) << xml;
}

TEST(StakeOut, HoldsDesignAndCorrectionWorstFirst) {
  DeviationT deviation = built();
  deviation.anchors[4]->verdict = ToleranceVerdict::fail;  // F3C1, 4 mm too high
  const std::string table = stake_out_csv(deviation);
  EXPECT_EQ(table.substr(0, table.find('\n')), "F3C1;2.0000;0.0000;9.0000;0.0000;0.0000;-0.0040;fail");
}

/// Once those that fail stood by name, and the crew began with another anchor than the page.
TEST(StakeOut, BeginsWithTheAnchorThatThePageBeginsWith) {
  DeviationT deviation = built();
  const auto fail_by = [&](size_t i, double value) {
    AnchorDeviationT& anchor = *deviation.anchors[i];
    anchor.verdict = ToleranceVerdict::fail, anchor.decided_by = "vertical";
    for (const auto& axis : anchor.axes)
      if (axis->axis == "vertical") axis->value = value, axis->tolerance = 0.005;
  };
  fail_by(0, 0.0065), fail_by(4, -0.0081);
  const std::string table = stake_out_csv(deviation);
  EXPECT_EQ(table.substr(0, table.find(';')), "F3C1");
}

/// Worst first over all facades sent the crew round the building for one anchor after another.
TEST(StakeOut, OfSeveralFacadesGoesByFacade) {
  DeviationT deviation = built();
  for (const char* name : {"North (0°)", "South"}) {
    deviation.facades.push_back(std::make_unique<FacadeT>());
    deviation.facades.back()->name = name, deviation.facades.back()->out.setZero();
    deviation.facades.back()->centre.setZero();
  }
  for (std::size_t i = 0; i < deviation.anchors.size(); ++i) {
    auto& facade = deviation.anchors[i]->facade;
    facade = std::make_unique<FacadeFrameT>();
    facade->facade = i < 3 ? "North (0°)" : "South";
  }
  deviation.anchors[4]->verdict = ToleranceVerdict::fail;
  const std::string table = stake_out_csv(deviation);
  std::string order;
  for (std::size_t at = table.find('\n'); at != std::string::npos; at = table.find('\n', at + 1))
    order += table.substr(0, at).ends_with(";NORTH_0") ? 'N' : table.substr(0, at).ends_with(";SOUTH") ? 'S' : '?';
  EXPECT_EQ(order, "NNN" + std::string(deviation.anchors.size() - 3, 'S')) << table;
  const std::size_t first = table.find(";SOUTH");
  EXPECT_NE(table.substr(0, first).find("F3C1;2.0000;0.0000;9.0000;0.0000;0.0000;-0.0040;fail"), std::string::npos)
      << table;
}

/// What every instrument and CAD program takes, and no two alike.
TEST(StakeOut, CodesOfFacadesAreShortAndTheirOwn) {
  DeviationT deviation;
  for (const char* name : {"A (180°)", "A 180", "Süd"}) {
    deviation.facades.push_back(std::make_unique<FacadeT>());
    deviation.facades.back()->name = name;
  }
  const auto codes = facade_codes(deviation);
  EXPECT_EQ(codes.at("A (180°)"), "A_180");
  EXPECT_EQ(codes.at("A 180"), "A_180_2");
  EXPECT_EQ(codes.at("Süd"), "S_D");
  deviation.facades.resize(1);
  EXPECT_TRUE(facade_codes(deviation).empty()) << "nothing needs it";
}

/// All files of one building with everything in it: what is in them is recomputed in parts, and held here as a whole.
TEST(MetricsFiles, AreTheRecordedOnes) {
  Options options;
  options.drift_on_control = true;
  AccuracyT accuracy = evaluate_accuracy(everything(), options);
  accuracy.adjustment = std::make_unique<AdjustmentSummaryT>();
  accuracy.adjustment->datum = "control", accuracy.adjustment->weighting = "lambda", accuracy.adjustment->lambda = 1e4;
  accuracy.adjustment->statistics = std::make_unique<StatisticsT>();
  StatisticsT& statistics = *accuracy.adjustment->statistics;
  statistics.observations = 120, statistics.unknowns = 40, statistics.degrees_of_freedom = 80;
  statistics.sigma0 = 1.25;
  accuracy.registration = std::make_unique<RegistrationSummaryT>();
  accuracy.registration->statistics = std::make_unique<StatisticsT>(statistics);
  accuracy.registration->down_weighted = 2,
  accuracy.registration->residual_covariance = {1e-6, 2e-7, 3e-7, 4e-6, 5e-7, 9e-6};
  accuracy.registration->residual_covariance_unbiased = {2e-6, 3e-7, 4e-7, 5e-6, 6e-7, 8e-6};
  const DeviationT deviation = built();
  const auto expect = [](const std::string& name, const std::string& text) {
    plumbline::test::expect_recorded("unit/evaluate/recorded/" + name + ".txt", plumbline::test::with_few_digits(text));
  };
  expect("metrics_json", json::parse(metrics_json(accuracy, &deviation)).dump(1, ' '));
  expect("metrics_csv", metrics_csv(accuracy, &deviation));
  expect("junit", junit_xml(accuracy, &deviation));
  expect("stake_out", stake_out_csv(deviation));
}

TEST(MetricsFiles, AnAxisWithoutToleranceIsNotCalledNotMeasured) {
  DeviationT deviation = built();
  JudgedAxisT& axis = *deviation.anchors[4]->axes.back();
  axis.value = 0.001, axis.tolerance = std::nan(""), axis.verdict = ToleranceVerdict::not_measured;
  const AccuracyT accuracy = evaluate_accuracy(everything(), {});
  const json document = json::parse(metrics_json(accuracy, &deviation));
  EXPECT_EQ(schema_errors(document), "");
  EXPECT_EQ(document["deviation"]["anchors"][4]["axes"].back()["verdict"], "not_judged");
  EXPECT_NE(metrics_csv(accuracy, &deviation).find(",not_judged,"), std::string::npos);
}

/// The instrument stands in the survey: positions and corrections are in its frame, heights unscaled.
TEST(StakeOut, IsInTheFrameOfTheSurvey) {
  DeviationT deviation = built();
  deviation.anchors[4]->verdict = ToleranceVerdict::fail;
  deviation.anchors[4]->deviation = {0.002, 0, 0.004};
  FrameLink building_from_survey;  // the survey is turned by 90 degrees and starts at (1000, 2000, 100)
  building_from_survey.to_from_from.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(-M_PI / 2, Eigen::Vector3d::UnitZ()));
  building_from_survey.to_from_from.translation =
      -(building_from_survey.to_from_from.rotation * Eigen::Vector3d(1000, 2000, 100));
  building_from_survey.plan_only = true;
  const std::string table = stake_out_csv(deviation, building_from_survey);
  EXPECT_EQ(table.substr(0, table.find('\n')), "F3C1;1000.0000;2002.0000;109.0000;0.0000;-0.0020;-0.0040;fail");
}

TEST(MetricsJson, SchemaNamesEveryEquationOfThePaper) {
  const std::string schema =
      plumbline::test::read_file(std::string(plumbline::test::source_dir()) + "/schemas/metrics.schema.json");
  for (int equation = 1; equation <= 14; ++equation)
    EXPECT_NE(schema.find("(" + std::to_string(equation) + ")"), std::string::npos) << equation;
}

TEST(MetricsJson, SchemaRefusesWhatItShould) {
  json document = json::parse(metrics_json(evaluate_accuracy(everything(), {})));
  document["comparisons"][0]["rmse_z"] = "2 mm";
  EXPECT_NE(schema_errors(document), "");
  document = json::parse(metrics_json(evaluate_accuracy(everything(), {})));
  document["anchors"][0].erase("use");
  EXPECT_NE(schema_errors(document), "");
  document = json::parse(metrics_json(evaluate_accuracy(everything(), {})));
  document["surprise"] = 1;
  EXPECT_NE(schema_errors(document), "");
}

TEST(MetricsJson, HoldsTheNumbersInMetresAndNullForUnknown) {
  const json document = json::parse(metrics_json(evaluate_accuracy(everything(), {})));
  EXPECT_EQ(document["verdict"]["overall"], "undecided");
  EXPECT_EQ(document["verdict"]["not_measured"], 1);
  EXPECT_NEAR(document["comparisons"][0]["floors"][2]["drift"].get<double>(), 4 * mm, 1e-12);
  EXPECT_TRUE(document["comparisons"][1]["floors"][0]["drift"].is_null());
  EXPECT_EQ(document["anchors"][7]["verdict"], "not_measured");
  EXPECT_TRUE(document["anchors"][7]["survey"].is_null());
}

TEST(MetricsJson, OverallVerdict) {
  Inputs inputs = test::small_building();
  EXPECT_EQ(overall_verdict(evaluate_accuracy(inputs, {})), "pass");  // 4 mm, u 0.5 mm: 4.82 mm
  Options close;
  close.tau = 0.0045;
  EXPECT_EQ(overall_verdict(evaluate_accuracy(inputs, close)), "undecided");
  Options narrow;
  narrow.tau = 0.002;
  EXPECT_EQ(overall_verdict(evaluate_accuracy(inputs, narrow)), "fail");
  EXPECT_EQ(overall_verdict(evaluate_accuracy(test::small_building(AnchorUse::control), {})), "no_evidence");
}

TEST(MetricsCsv, HasOneRowAnAnchorInMillimetres) {
  const std::string csv = metrics_csv(evaluate_accuracy(everything(), {}));
  std::vector<std::string> lines;
  std::istringstream stream(csv);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 9u);
  EXPECT_EQ(lines[0].substr(0, 45), "anchor,floor,column,row,use,x_m,y_m,z_m,surve");
  EXPECT_EQ(lines[5].substr(0, 90),
            "F3C1,3,1,1,check,2.000000,0.000000,0.004000,0.0000,0.0000,4.0000,0.5000,4.0000,pass,0.9772");
  EXPECT_EQ(lines[7].substr(0, 13), "\"K, \"\"left\"\"\"");
  EXPECT_EQ(lines[8].substr(lines[8].size() - 14), "no model point");
  const auto commas = std::count(lines[0].begin(), lines[0].end(), ',');
  const DeviationT deviation = built();
  for (std::istringstream rows(metrics_csv(evaluate_accuracy(everything(), {}), &deviation));
       std::getline(rows, lines[0]);)
    EXPECT_GE(std::count(lines[0].begin(), lines[0].end(), ','), commas) << lines[0];
  EXPECT_EQ(std::count(lines[5].begin(), lines[5].end(), ','), commas);
  EXPECT_EQ(std::count(lines[8].begin(), lines[8].end(), ','), commas);
}

}  // namespace test_metrics
}  // namespace plumbline::judgement

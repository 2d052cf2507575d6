// Every property of the as-built sets: none that nobody looks at, each the figure that its name says. All figures of
// the input differ, so that one in another's place shows.
#include <fmt/core.h>

#include <algorithm>
#include <map>

#include "building/ifc/as_built_ifc.hpp"
#include "building/ifc/ifc_model.hpp"
#include "measured.hpp"
#include "small_building.hpp"
#include "test_support.hpp"

namespace plumbline::ifc {
namespace test_as_built_sets {

using Properties = std::map<std::string, std::string>;

std::string shown(const step::Value& value) {
  if (value.is_number()) return fmt::format("{:.9g}", value.number);
  std::string text = value.kind == step::Kind::typed || value.kind == step::Kind::list ? "" : value.text;
  for (const step::Value& item : value.items) text += (text.empty() ? "" : " ") + shown(item);
  return text;
}

/// Of each object and set the properties as text: a value, a list, "lower to upper" or "defining: defined".
std::map<std::string, Properties> sets_of(const step::File& file) {
  const Model model(file);
  std::map<std::string, Properties> found;
  for (const Entity& relation : model.all("IFCRELDEFINESBYPROPERTIES")) {
    const Entity set = model.entity(relation.reference("RelatingPropertyDefinition"));
    const std::string object = file.arguments(*file.find(relation.references("RelatedObjects").at(0))).at(2).text;
    for (const std::uint64_t id : set.references("HasProperties")) {
      const auto arguments = file.arguments(*file.find(id));
      const std::string type = file.type_name(*file.find(id));
      std::string& text = found[object + "/" + set.text("Name")][arguments.at(0).text];
      if (type == "IFCPROPERTYBOUNDEDVALUE")
        text = shown(arguments.at(3)) + " to " + shown(arguments.at(2));
      else if (type == "IFCPROPERTYTABLEVALUE")
        text = shown(arguments.at(2)) + ": " + shown(arguments.at(3));
      else
        text = shown(arguments.at(2));
    }
  }
  return found;
}

std::unique_ptr<JudgedLengthT> length(double value) {
  auto judged = std::make_unique<JudgedLengthT>();
  judged->value = value;
  return judged;
}

void make_different(PanelDeviationT& panel) {
  panel.fixings.clear();
  for (const double m : {0.001, 0.004}) {
    auto fixing = std::make_unique<PanelFixingT>();
    fixing->anchor = "A", fixing->guid = fmt::format("G{}", 1000 * m);
    fixing->shim = m, fixing->sideways = m + 0.001, fixing->upward = m + 0.002;
    panel.fixings.push_back(std::move(fixing));
  }
  panel.missing = {"F9"};
  panel.shift = {0.021, 0.022, 0.023}, panel.rotation = {0.0011, 0.0012, 0.0013};
  panel.out_of_plane = length(0.031), panel.sideways = length(0.032), panel.vertical = length(0.033);
  panel.tilt = length(0.034), panel.warp = length(0.035), panel.misfit = length(0.036), panel.corner = length(0.037);
  panel.corners.clear();
  for (const double m : {0.041, static_cast<double>(NAN)}) {
    auto corner = std::make_unique<PanelCornerT>();
    corner->name = m > 0 ? "bottom_left" : "top_left", corner->movement = {m, m + 0.001, m + 0.002};
    panel.corners.push_back(std::move(corner));
  }
  panel.joints.clear();
  for (const double m : {0.051, 0.053}) {
    auto joint = std::make_unique<PanelJointT>();
    joint->panel = fmt::format("N{}", 1000 * m), joint->narrowest = m, joint->widest = m + 0.001;
    panel.joints.push_back(std::move(joint));
  }
  panel.verdict = ToleranceVerdict::undecided, panel.decided_by = "misfit", panel.reason = "for this";
}

void make_different(FloorDeviationT& floor, int first) {
  floor.passed = first, floor.undecided = first + 1, floor.failed = first + 2, floor.not_measured = first + 3;
  floor.panels_passed = first + 4, floor.panels_undecided = first + 5, floor.panels_failed = first + 6;
  floor.verdict = ToleranceVerdict::undecided, floor.pass_together = 0.01 * first;
}

void make_different(AccuracyT& accuracy) {
  AccuracyComparisonT& all = *accuracy.comparisons[0];
  FloorAccuracyT& floor = *all.floors[0];
  floor.anchors = 61, floor.mean_dz = 0.062, floor.drift = 0.063, floor.rmse_z = 0.064, floor.max_abs_dz = 0.065;
  floor.drift_verdict = ToleranceVerdict::fail;
  floor.pass_rates[0]->rate = 0.5, floor.pass_rates[1]->rate = 0.75;
  HeightTransferT& transfer = *all.transfers[0];
  transfer.anchors = 71, transfer.error = 0.072, transfer.difference = -0.073, transfer.u = 0.074;
  transfer.verdict = ToleranceVerdict::undecided;
  all.transfers[1]->column = 2, all.transfers[1]->difference = 0.075;
  ColumnDriftT& column = *all.columns[0];
  column.lowest_floor = 3, column.highest_floor = 8, column.drift = 0.081, column.u_drift = 0.082;
  column.relative_drift = 0.083, column.u_relative_drift = 0.084;
  column.drift_verdict = ToleranceVerdict::fail, column.relative_verdict = ToleranceVerdict::undecided;
  for (auto& anchor : accuracy.anchors) {
    AnchorDifferenceT& survey = *anchor->survey;
    survey.dx = 0.091, survey.dy = 0.092, survey.dz = -0.093, survey.distance = 0.094, survey.u_dz = 0.095;
    survey.verdict = ToleranceVerdict::fail, survey.conformance_probability = 0.25, anchor->column = 7;
  }
}

/// Worked out from the figures that are set below, not taken from the writer: millimetres, and square roots of sums
/// of squares.
const std::map<std::string, Properties> expected = {
    {"F1-C1/ASB_AnchorDeviation",
     {{"AsBuiltPosition", "10001 21998 600.5"},
      {"DecidedBy", "horizontal"},
      {"DesignPosition", "10000 22000 600"},
      {"Deviation3D", "2.291288"},
      {"DeviationHorizontal", "2.236068"},
      {"DeviationInPlane", "2.061553"},
      {"DeviationOutOfPlane", "1"},
      {"DeviationX", "1"},
      {"DeviationY", "-2"},
      {"DeviationZ", "0.5"},
      {"Facade", "A (90°)"},
      {"Frame", "project"},
      {"MatchedBy", "its tag"},
      {"Note", "a note"},
      {"OutwardConfirmed", "T"},
      {"OutwardFrom", "rule"},
      {"PassProbability", "1"},
      {"ReferencePointRule", "placement"},
      {"SurveyName", "plate 1"},
      {"TargetOffset", "200 300 400"},
      {"ToleranceXY", "-5 to 5"},
      {"ToleranceZ", "-5 to 5"},
      {"Verdict", "PASS"}}},
    {"F1-C1/ASB_ModelVsSurvey",
     {{"Column", "7"},
      {"ConformanceProbability", "0.25"},
      {"DeltaX", "91"},
      {"DeltaY", "92"},
      {"DeltaZ", "-93"},
      {"Distance3D", "94"},
      {"Role", "CONTROL"},
      {"StdDeltaZ", "95"},
      {"Tolerance", "-5 to 5"},
      {"Verdict", "FAIL"}}},
    {"F1-C1/ASB_Provenance",
     {{"ImageCount", "12"},
      {"InputSha256", "a 1 b 2"},
      {"Method", "how"},
      {"ObservationTime", "2026-05-12T10:00:00"},
      {"ReadingCount", "805"},
      {"ReadingsLeftOut", "35"},
      {"UnusedSha256", "c 3"}}},
    {"F1-C1/ASB_Uncertainty",
     {{"CovarianceUpper_mm2", "0.04 0.01 0.02 0.09 0.03 0.16"},
      {"Coverage95", "1.16865"},
      {"StdX", "0.2"},
      {"StdY", "0.3"},
      {"StdZ", "0.4"},
      {"UncertaintyBasis", "covariance of the adjustment"}}},
    {"Level 1 to Level 2/ASB_InterFloor",
     {{"Columns", "2"},
      {"DesignHeight", "3500"},
      {"Difference", "-73"},
      {"DifferencePerColumn", "75"},
      {"E_transfer", "72"},
      {"LowerStorey", "Level 1"},
      {"MeasuredHeight", "3508.5"},
      {"SharedMarkers", "71"},
      {"Sigma", "74"},
      {"UpperStorey", "Level 2"},
      {"Verdict", "UNDECIDED"}}},
    {"Level 1/ASB_FloorStatistics",
     {{"AnchorsFailed", "12"},
      {"AnchorsNotMeasured", "13"},
      {"AnchorsPassed", "10"},
      {"AnchorsUndecided", "11"},
      {"AnchorsUsed", "check"},
      {"Drift", "63"},
      {"DriftVerdict", "FAIL"},
      {"Evidence", "T"},
      {"MaxAbsDeltaZ", "65"},
      {"MeanDeltaZ", "62"},
      {"N", "61"},
      {"PanelsFailed", "16"},
      {"PanelsPassed", "14"},
      {"PanelsUndecided", "15"},
      {"PassRate", "2 2.5: 0.5 0.75"},
      {"PassTogether", "0.1"},
      {"RMSE_Z", "64"},
      {"Verdict", "UNDECIDED"}}},
    {"Marker column 1/ASB_ColumnDrift",
     {{"AnchorsUsed", "check"},
      {"Column", "1"},
      {"Drift", "81"},
      {"DriftVerdict", "FAIL"},
      {"HighestFloor", "8"},
      {"LowestFloor", "3"},
      {"RelativeDrift", "83"},
      {"RelativeVerdict", "UNDECIDED"},
      {"StdDrift", "82"},
      {"StdRelativeDrift", "84"}}},
    {"Panel 1/ASB_PanelFit",
     {{"AnchorGUIDs", "G1 G4"},
      {"Corner", "37"},
      {"CornerMovement", "41 42 43"},
      {"Corners", "bottom_left"},
      {"DecidedBy", "Misfit"},
      {"FitRotationX", "0.0011"},
      {"FitRotationY", "0.0012"},
      {"FitRotationZ", "0.0013"},
      {"FitX", "21"},
      {"FitY", "22"},
      {"FitZ", "23"},
      {"JointNarrowest", "51 53"},
      {"JointTo", "N51 N53"},
      {"JointWidest", "52 54"},
      {"Misfit", "36"},
      {"MissingAnchors", "F9"},
      {"OutOfPlane", "31"},
      {"Reason", "for this"},
      {"ShimPerAnchor", "1 4"},
      {"Sideways", "32"},
      {"SidewaysPerAnchor", "2 5"},
      {"Tilt", "34"},
      {"UpwardPerAnchor", "3 6"},
      {"Verdict", "UNDECIDED"},
      {"Vertical", "33"},
      {"Warp", "35"}}},
    {"Small/ASB_Judgement",
     {{"AnchorsFailed", "103"},
      {"AnchorsNotMeasured", "104"},
      {"AnchorsPassed", "101"},
      {"AnchorsUndecided", "102"},
      {"Risk", "0.0625"},
      {"Temperature",
       "The model knows no temperature: 10 K make the 3.5 m of height between these anchors 0.3 mm longer or shorter, "
       "and their 2.0 m of width 0.2 mm (concrete, 1e-5 a kelvin by EN 1991-1-5); the smallest tolerance is 5.0 mm; "
       "the median standard deviation of a height is 0.10 mm"},
      {"Verdict", "UNDECIDED"}}},
};

TEST(AsBuiltSets, EveryPropertyIsTheFigureOfItsName) {
  const std::string before = test::small_building("IFC4");
  const step::File file(before, "t.ifc");
  const Design design = read_design(file, {});
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const Element& element : design.elements)
    if (element.is_anchor && element.name != "F2-C2")
      deviations[element.guid] = Eigen::Vector3d(0.001, -0.002, element.storey == "Level 1" ? 0.0005 : 0.009);
  DeviationT deviation = test::judged(design, deviations, {0.0002, 0.0003, 0.0001}, {1, 0, 0});
  make_different(*deviation.panels.at(0));
  for (auto& floor : deviation.floors) make_different(*floor, 10 * floor->floor);
  deviation.passed = 101, deviation.undecided = 102, deviation.failed = 103, deviation.not_measured = 104;
  deviation.risk = 0.0625, deviation.verdict = ToleranceVerdict::undecided;
  AccuracyT accuracy = test::residuals(deviation, -0.0015);
  make_different(accuracy);
  AnchorDeviationT& anchor = *deviation.anchors.at(0);
  anchor.target_offset = {0.2, 0.3, 0.4}, anchor.id = "plate 1", anchor.note = "a note", anchor.found_by = "its tag";
  anchor.covariance = {4e-8, 1e-8, 2e-8, 1e-8, 9e-8, 3e-8, 2e-8, 3e-8, 16e-8};
  for (auto& axis : anchor.axes) axis->source = "a rule for " + axis->axis;
  for (auto& row : accuracy.anchors)
    if (row->use == AnchorUse::control) row->id = "plate 1";
  AsBuiltIfcOptions options;
  options.provenance = {{"Method", "how"}, {"ObservationTime", "2026-05-12T10:00:00"}};
  options.input_hashes = {"a 1", "b 2"}, options.unused_hashes = {"c 3"}, options.image_count = 12;
  options.reading_count = 805, options.readings_left_out = 35;
  const AsBuiltIfc result = write_as_built(file, design, deviation, accuracy, options);
  auto found = sets_of(step::File(enriched(file, result), "t.ifc"));
  for (const auto& [set, properties] : expected) EXPECT_EQ(found[set], properties) << set;
  EXPECT_EQ(found["F1-C2/ASB_ModelVsSurvey"]["Role"], "CHECK");
  EXPECT_EQ(found["F2-C2/ASB_AnchorDeviation"]["Verdict"], "NOTMEASURED");
  for (const auto& [set, properties] : found) {  // of one kind the first is looked at
    const std::string kind = set.substr(set.find('/'));
    EXPECT_TRUE(std::any_of(expected.begin(), expected.end(), [&](const auto& e) { return e.first.ends_with(kind); }))
        << kind;
  }
}

}  // namespace test_as_built_sets
}  // namespace plumbline::ifc

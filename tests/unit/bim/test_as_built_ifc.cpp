// The as-built IFC: the design's bytes untouched, additions valid against the EXPRESS schema, values as given.
#include <algorithm>
#include <map>
#include <set>

#include "artifacts/surface_judgement.hpp"
#include "artifacts/surfaces.hpp"
#include "building/ifc/as_built_ifc.hpp"
#include "building/ifc/check.hpp"
#include "building/ifc/ifc_appender.hpp"
#include "building/ifc/ifc_model.hpp"
#include "express_schema.hpp"
#include "measured.hpp"
#include "small_building.hpp"
#include "test_support.hpp"

namespace plumbline::ifc {
namespace test_as_built_ifc {

/// Three of four anchors measured.
DeviationT measurements(const Design& design) {
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const Element& element : design.elements)
    if (element.is_anchor && element.name != "F2-C2")
      deviations[element.guid] = Eigen::Vector3d(0.001, -0.002, element.storey == "Level 1" ? 0.0005 : 0.009);
  return test::judged(design, deviations, {0.0002, 0.0003, 0.0001}, {1, 0, 0});
}

struct Enriched : AsBuiltIfc {
  std::string bytes;
};

Enriched enrich(const std::string& bytes, AsBuiltIfcOptions options = {}) {
  const step::File file(bytes, "t.ifc");
  const Design design = read_design(file, {});
  options.provenance = {{"Method", "photogrammetry with survey control"},
                        {"ObservationTime", "2026-05-12T10:00:00"},
                        {"SoftwareVersion", "Plumbline 0.1.0"}};
  options.input_hashes = {"survey/a.gsi 60303ae2"};
  const DeviationT deviation = measurements(design);
  Enriched result{write_as_built(file, design, deviation, test::residuals(deviation, -0.0015), options), ""};
  result.bytes = enriched(file, result);
  return result;
}

/// Property sets of the objects, as "name of object/set/property" → the value argument.
std::map<std::string, step::Value> properties_of(const step::File& file) {
  const Model model(file);
  std::map<std::string, step::Value> found;
  for (const std::uint32_t index : file.of_type("IFCRELDEFINESBYPROPERTIES")) {
    const auto relation = file.arguments(file.instances()[index]);
    const Entity set = model.entity(relation.at(5).id);
    for (const step::Value& object : relation.at(4).items)
      for (const std::uint64_t id : set.references("HasProperties")) {
        const auto property = file.arguments(*file.find(id));
        found[file.arguments(*file.find(object.id)).at(2).text + "/" + set.text("Name") + "/" + property.at(0).text] =
            property.at(2);
      }
  }
  return found;
}

double number(const std::map<std::string, step::Value>& found, const std::string& key) {
  if (!found.contains(key)) throw std::runtime_error("no property " + key);
  return found.at(key).items.at(0).number;
}

class AsBuiltFile : public testing::TestWithParam<Schema> {
 protected:
  std::string design_bytes() const { return test::small_building(schema_name(GetParam())); }
};

TEST_P(AsBuiltFile, KeepsTheDesignsBytesAndIsStable) {
  const std::string before = design_bytes();
  const Enriched after = enrich(before);
  const std::size_t end = before.rfind("ENDSEC;");
  EXPECT_EQ(after.bytes.substr(0, end), before.substr(0, end));
  EXPECT_EQ(after.bytes.substr(after.bytes.size() - (before.size() - end)), before.substr(end));
  EXPECT_EQ(enrich(before).bytes, after.bytes);
  EXPECT_EQ(after.bytes.find("\n\n"), std::string::npos);
  EXPECT_EQ(std::count(after.bytes.begin(), after.bytes.end(), '\n'),
            std::count(after.bytes.begin(), after.bytes.end(), '\r'));
  EXPECT_TRUE(after.warnings.empty()) << after.warnings[0];
}

/// Who finds a value or a solid in the model is led to the report; an epoch has a reference of its own.
TEST_P(AsBuiltFile, WhatIsAddedIsTiedToTheReport) {
  AsBuiltIfcOptions options;
  options.epoch = "2026-05";
  const step::File file(enrich(design_bytes(), options).bytes, "e.ifc");
  const Model model(file);
  const auto relations = model.all("IFCRELASSOCIATESDOCUMENT");
  ASSERT_EQ(relations.size(), 1u);
  const auto arguments = file.arguments(*file.find(relations[0].id()));
  const auto document = file.arguments(*file.find(arguments.at(5).id));
  EXPECT_EQ(document.at(0).text, "report.html");
  EXPECT_EQ(document.at(2).text, "As-built survey 2026-05");
  std::set<std::uint64_t> related;
  for (const step::Value& object : arguments.at(4).items) related.insert(object.id);
  EXPECT_TRUE(related.contains(model.all("IFCPROJECT").at(0).id()));
  const auto proxies = model.all("IFCBUILDINGELEMENTPROXY");
  EXPECT_FALSE(proxies.empty());
  for (const Entity& proxy : proxies) EXPECT_TRUE(related.contains(proxy.id())) << proxy.text("Name");
  options.document.clear();
  EXPECT_EQ(enrich(design_bytes(), options).bytes.find("IFCDOCUMENTREFERENCE"), std::string::npos);
}

TEST_P(AsBuiltFile, IsValidAgainstTheExpressSchema) {
  const std::string path = std::string("ifc/express/") + schema_name(GetParam()) + ".exp";
  PLUMBLINE_REQUIRE_DATA(path);
  const test::ExpressSchema schema(test::read_file(test::data_file(path)));
  const step::File file(enrich(design_bytes()).bytes, "t.ifc");
  std::set<std::string> guids;
  for (const step::Instance& instance : file.instances()) {
    for (const std::string& wrong : schema.check(file, instance)) ADD_FAILURE() << wrong;
    if (schema.is_a(file.type_name(instance), "IFCROOT")) {
      EXPECT_TRUE(guids.insert(file.arguments(instance).at(0).text).second) << "GlobalId twice: #" << instance.id;
    }
  }
}

TEST_P(AsBuiltFile, BreaksNoRule) {
  AsBuiltIfcOptions second;
  second.epoch = "2026-06";
  const std::string once = enrich(design_bytes()).bytes, twice = enrich(once, second).bytes;
  for (const std::string& bytes : {once, twice})
    for (const Violation& violation : check_ifc(step::File(bytes, "t.ifc")))
      ADD_FAILURE() << violation.rule << " #" << violation.instance << " " << violation.words;
}

TEST_P(AsBuiltFile, ObeysTheContainmentRules) {
  const step::File file(enrich(design_bytes()).bytes, "t.ifc");
  std::map<std::uint64_t, int> contained;
  for (const std::uint32_t index : file.of_type("IFCRELCONTAINEDINSPATIALSTRUCTURE")) {
    const auto relation = file.arguments(file.instances()[index]);
    for (const step::Value& item : relation.at(4).items) ++contained[item.id];
  }
  for (const auto& [id, times] : contained) EXPECT_EQ(times, 1) << "#" << id << " is contained more than once";
  for (const std::uint32_t index : file.of_type("IFCRELAGGREGATES")) {
    const auto relation = file.arguments(file.instances()[index]);
    for (const step::Value& part : relation.at(5).items) EXPECT_FALSE(contained.contains(part.id)) << "#" << part.id;
  }
  const auto& annotations = file.of_type("IFCANNOTATION");
  EXPECT_EQ(annotations.size(), 3u);
  for (const std::uint32_t index : annotations) EXPECT_EQ(contained[file.instances()[index].id], 1);
  for (const std::uint32_t index : file.of_type("IFCPROPERTYSET")) {
    const std::string name = file.arguments(file.instances()[index]).at(2).text;
    if (name.starts_with("ASB_")) {
      EXPECT_LE(name.size(), 40u);
    }
    const bool standard = name == "Pset_Tolerance" || name == "Pset_Uncertainty";
    // Names that start with Pset are reserved; these two exist since IFC4X3.
    EXPECT_TRUE(name.starts_with("ASB_") || (standard && GetParam() == Schema::ifc4x3)) << name;
  }
}

TEST_P(AsBuiltFile, CarriesTheValuesInTheUnitOfTheProject) {
  const step::File file(enrich(design_bytes()).bytes, "t.ifc");
  const auto found = properties_of(file);
  const auto text = [&](const std::string& key) { return found.at(key).items.at(0).items.at(0).text; };
  EXPECT_EQ(number(found, "F1-C1/ASB_AnchorDeviation/DeviationX"), 1);
  EXPECT_EQ(number(found, "F1-C1/ASB_AnchorDeviation/DeviationY"), -2);
  EXPECT_EQ(number(found, "F2-C1/ASB_AnchorDeviation/DeviationZ"), 9);
  EXPECT_NEAR(number(found, "F2-C1/ASB_AnchorDeviation/Deviation3D"), std::sqrt(86.0), 1e-6);
  EXPECT_EQ(number(found, "F2-C1/ASB_AnchorDeviation/DeviationOutOfPlane"), 1);
  EXPECT_EQ(found.at("F2-C1/ASB_AnchorDeviation/AsBuiltPosition").items.at(2).items.at(0).number, 4109);
  EXPECT_EQ(found.at("F2-C1/ASB_AnchorDeviation/DesignPosition").items.at(0).items.at(0).number, 10000);
  EXPECT_EQ(text("F2-C1/ASB_AnchorDeviation/Verdict"), "FAIL");
  EXPECT_EQ(text("F1-C2/ASB_AnchorDeviation/Verdict"), "PASS");
  EXPECT_EQ(text("F2-C2/ASB_AnchorDeviation/Verdict"), "NOTMEASURED");
  EXPECT_FALSE(found.contains("F2-C2/ASB_AnchorDeviation/DeviationX"));
  EXPECT_FALSE(found.contains("F2-C2/ASB_Provenance/Method"));
  EXPECT_EQ(found.at("F1-C1/ASB_AnchorDeviation/ToleranceZ").items.at(0).number, 5);
  EXPECT_FALSE(found.contains("F1-C1/Pset_Tolerance/VerticalTolerance")) << "a default is nobody's wish";
  EXPECT_EQ(number(found, "F1-C1/ASB_ModelVsSurvey/DeltaZ"), -1.5);
  EXPECT_NEAR(number(found, "F1-C1/ASB_ModelVsSurvey/Distance3D"), std::sqrt(2.30), 1e-6);
  EXPECT_EQ(text("F1-C1/ASB_ModelVsSurvey/Role"), "CONTROL");
  EXPECT_EQ(text("F1-C2/ASB_ModelVsSurvey/Role"), "CHECK");
  EXPECT_EQ(text("Panel 1/ASB_PanelFit/Verdict"), "FAIL");
  EXPECT_EQ(found.at("F1-C1/ASB_Provenance/InputSha256").items.at(0).items.at(0).text, "survey/a.gsi 60303ae2");
  EXPECT_EQ(number(found, "F1-C1/ASB_Uncertainty/StdY"), 0.3);
  EXPECT_EQ(found.at("F1-C1/ASB_Uncertainty/CovarianceUpper_mm2").items.at(3).items.at(0).number, 0.09);
  EXPECT_EQ(found.at("F1-C1/ASB_Provenance/SoftwareVersion").items.at(0).text, "Plumbline 0.1.0");
  EXPECT_EQ(number(found, "Level 2/ASB_FloorStatistics/Drift"), -3);
  EXPECT_EQ(number(found, "Level 1/ASB_FloorStatistics/N"), 1);
  EXPECT_EQ(found.at("Level 1/ASB_FloorStatistics/PassRate").items.at(1).items.at(0).number, 2.5);
  EXPECT_EQ(number(found, "Level 1 to Level 2/ASB_InterFloor/E_transfer"), 0.4);
  EXPECT_EQ(number(found, "Level 1 to Level 2/ASB_InterFloor/DesignHeight"), 3500);
  EXPECT_EQ(number(found, "Level 1 to Level 2/ASB_InterFloor/MeasuredHeight"), 3508.5);
  EXPECT_EQ(number(found, "Panel 1/ASB_PanelFit/FitZ"), 9);
  EXPECT_EQ(found.at("Panel 1/ASB_PanelFit/AnchorGUIDs").items.at(0).items.at(0).text, "21vctVUKr0kugbFTf53O9L");
}

/// Both sides of a tolerance are written, and what a rule asks for with one number stands in the standard's set; what
/// the next epoch reads back is what was asked for.
TEST_P(AsBuiltFile, CarriesTolerancesWithBothTheirSides) {
  const std::string before = design_bytes();
  const step::File design_file(before, "t.ifc");
  const Design design = read_design(design_file, {});
  std::map<std::string, Eigen::Vector3d> deviations;
  for (const Element& element : design.elements)
    if (element.is_anchor) deviations[element.guid] = Eigen::Vector3d(0.0005, 0, 0.0015);
  const auto enriched_by = [&](const std::vector<std::string>& rules) {
    judgement::ToleranceTable table;
    for (const std::string& rule : rules) table.rules.push_back(judgement::parse_rule(rule));
    const DeviationT deviation = test::judged(design, deviations, Eigen::Vector3d::Constant(2e-4), {1, 0, 0}, table);
    const AsBuiltIfc result = write_as_built(design_file, design, deviation, test::residuals(deviation, 0), {});
    return enriched(design_file, result);
  };
  const std::string bytes = enriched_by({"*: vertical=+0/-5mm, horizontal=4mm, out_of_plane=-2/+3mm"});
  const auto found = properties_of(step::File(bytes, "t.ifc"));
  const step::File file(bytes, "t.ifc");
  const auto bounds = [&](const std::string& name) {
    for (const std::uint32_t index : file.of_type("IFCPROPERTYBOUNDEDVALUE")) {
      const auto p = file.arguments(file.instances()[index]);
      if (p.at(0).text == name) return std::pair{p.at(3).items.at(0).number, p.at(2).items.at(0).number};
    }
    return std::pair{static_cast<double>(NAN), static_cast<double>(NAN)};
  };
  EXPECT_EQ(bounds("ToleranceZ"), (std::pair{-5.0, 0.0})) << "the value lies above, where nothing is left";
  EXPECT_EQ(bounds("ToleranceOutOfPlane"), (std::pair{-2.0, 3.0}));
  EXPECT_EQ(bounds("ToleranceXY"), (std::pair{-4.0, 4.0}));
  EXPECT_EQ(found.contains("F1-C1/Pset_Tolerance/HorizontalTolerance"), GetParam() == Schema::ifc4x3);
  EXPECT_FALSE(found.contains("F1-C1/Pset_Tolerance/VerticalTolerance")) << "one number would lose a side";
  for (const Violation& violation : check_ifc(file)) ADD_FAILURE() << violation.rule << " " << violation.words;
}

TEST_P(AsBuiltFile, SaysWhatDecidesAPanelThatIsNotJudged) {
  const std::string before = design_bytes();
  const step::File file(before, "t.ifc");
  const Design design = read_design(file, {});
  for (const auto& [by, word] : {std::pair{"facade", "Facade"}, {"not_judged", "NotJudged"}}) {
    DeviationT deviation = measurements(design);
    for (auto& panel : deviation.panels) panel->decided_by = by, panel->facade->confirmed = false;
    const AsBuiltIfc result = write_as_built(file, design, deviation, test::residuals(deviation, 0), {});
    const auto found = properties_of(step::File(enriched(file, result), "t.ifc"));
    EXPECT_EQ(found.at("Panel 1/ASB_PanelFit/DecidedBy").items.at(0).text, word);
  }
}

/// The panel of the design as it was measured, a joint to one that is not in it, and a verdict that fails.
struct MeasuredSurfaces {
  SurfacesT surfaces;
  SurfaceJudgementT judgement;
  explicit MeasuredSurfaces(const std::string& guid) {
    for (const char* name : {"Panel 1", "Panel 2"}) {
      auto panel = std::make_unique<PanelSurfaceFiguresT>();
      panel->face = std::make_unique<SurfaceFaceT>();
      panel->face->id = name, panel->face->guid = std::string(name) == "Panel 1" ? guid : "not in this design";
      panel->points = 480, panel->coverage = 0.9, panel->offset = 0.0035, panel->tilt = {0.001, -0.002};
      panel->form = {0.001, 0.002, 0.0003}, panel->form_sigma = {1e-4, 2e-4, 5e-5};
      panel->covariance = {4e-8, 0, 1e-8, 0, 0, 1e-8};
      auto gap = std::make_unique<SurfaceGapT>();
      gap->length = 1, gap->gap = 0.0042, gap->sigma = 3e-4, gap->positions = 4;
      panel->flatness.push_back(std::move(gap));
      surfaces.panels.push_back(std::move(panel));
    }
    auto joint = std::make_unique<JointFiguresT>();
    joint->first = "Panel 1", joint->second = "Panel 2";
    surfaces.joints.push_back(std::move(joint));
    auto verdict = std::make_unique<SurfaceVerdictT>();
    verdict->quantity = "flatness", verdict->panel = "Panel 1", verdict->guid = guid, verdict->length = 1;
    verdict->probability = 0.00003, verdict->verdict = ToleranceVerdict::fail, verdict->rule = "*: flatness(1m)=3mm";
    judgement.verdicts.push_back(std::move(verdict));
  }
};

TEST_P(AsBuiltFile, JointsOfPanelsThatShareANameAreWritten) {
  const std::string before = design_bytes();
  std::string guid, other;
  for (const Element& element : read_design(step::File(before, "t.ifc"), {}).elements)
    (element.name == "Panel 1" ? guid : other) = element.guid;
  MeasuredSurfaces measured(guid);
  measured.surfaces.panels[1]->face->id = "Panel 1", measured.surfaces.panels[1]->face->guid = other;
  JointFiguresT& joint = *measured.surfaces.joints[0];
  joint.second = "Panel 1", joint.first_panel = 0, joint.second_panel = 1;
  joint.nominal_width = 0.012;
  measured.judgement.verdicts.push_back(std::make_unique<SurfaceVerdictT>(*measured.judgement.verdicts[0]));
  SurfaceVerdictT& verdict = *measured.judgement.verdicts[1];
  verdict.quantity = "joint", verdict.second = "Panel 1", verdict.length = std::nan(""), verdict.item = 0;
  AsBuiltIfcOptions options;
  options.surfaces = &measured.surfaces, options.surface_judgement = &measured.judgement;
  const Enriched after = enrich(before, options);
  const step::File file(after.bytes, "t.ifc");
  const auto found = properties_of(file);
  EXPECT_NEAR(number(found, "Panel 1/ASB_Joint_Panel 1_Panel 1/NominalWidth"), 12, 1e-9);
  EXPECT_EQ(found.at("Panel 1/ASB_Joint_Panel 1_Panel 1/Verdict").items.at(0).items.at(0).text, "FAIL");
  EXPECT_TRUE(after.warnings.empty()) << after.warnings[0];
}

/// Verdicts that were given larger standard deviations for a misfit stand beside these, not beside smaller ones.
TEST_P(AsBuiltFile, SurfacesHaveTheUncertaintiesThatTheyWereJudgedWith) {
  const std::string before = design_bytes();
  std::string guid, other;
  for (const Element& element : read_design(step::File(before, "t.ifc"), {}).elements)
    (element.name == "Panel 1" ? guid : other) = element.guid;
  MeasuredSurfaces measured(guid);
  measured.surfaces.panels[1]->face->guid = other;
  JointFiguresT& joint = *measured.surfaces.joints[0];
  auto place = std::make_unique<JointPlaceT>();
  place->width = 0.012, place->width_sigma = 1e-4, place->step = 0.001, place->step_sigma = 2e-4;
  joint.places.push_back(std::move(place));
  joint.narrowest = joint.widest = joint.largest_step = 0;
  measured.judgement.covariance_factor = 9;
  AsBuiltIfcOptions options;
  options.surfaces = &measured.surfaces, options.surface_judgement = &measured.judgement;
  const Enriched after = enrich(before, options);
  const step::File file(after.bytes, "t.ifc");
  const auto found = properties_of(file);
  const std::string surface = "Panel 1/ASB_PanelSurface/", along = "Panel 1/ASB_Joint_Panel 1_Panel 2/";
  EXPECT_NEAR(number(found, surface + "Offset"), 3.5, 1e-9);
  EXPECT_NEAR(number(found, surface + "OffsetUncertainty"), 3 * 0.2, 1e-9);
  EXPECT_NEAR(number(found, surface + "TiltUpUncertainty"), 3 * 1e-4, 1e-9);
  EXPECT_NEAR(number(found, surface + "BowUpUncertainty"), 3 * 0.2, 1e-9);
  EXPECT_NEAR(found.at(surface + "GapUncertainties").items.at(0).items.at(0).number, 3 * 0.3, 1e-9);
  EXPECT_NEAR(number(found, along + "NarrowestUncertainty"), 3 * 0.1, 1e-9);
  EXPECT_NEAR(number(found, along + "WidestUncertainty"), 3 * 0.1, 1e-9);
  EXPECT_NEAR(number(found, along + "LargestStepUncertainty"), 3 * 0.2, 1e-9);
}

TEST_P(AsBuiltFile, SurfacesOfPanelsWithTheirVerdicts) {
  const std::string before = design_bytes();
  std::string guid;
  for (const Element& element : read_design(step::File(before, "t.ifc"), {}).elements)
    if (element.name == "Panel 1") guid = element.guid;
  const MeasuredSurfaces measured(guid);
  AsBuiltIfcOptions options;
  options.surfaces = &measured.surfaces, options.surface_judgement = &measured.judgement;
  const Enriched after = enrich(before, options);
  const step::File file(after.bytes, "t.ifc");
  const auto found = properties_of(file);
  EXPECT_NEAR(number(found, "Panel 1/ASB_PanelSurface/Offset"), 3.5, 1e-9);
  EXPECT_NEAR(number(found, "Panel 1/ASB_PanelSurface/OffsetUncertainty"), 0.2, 1e-9);
  EXPECT_NEAR(number(found, "Panel 1/ASB_PanelSurface/BowUp"), 2, 1e-9);
  EXPECT_NEAR(number(found, "Panel 1/ASB_PanelSurface/BowUpUncertainty"), 0.2, 1e-9);
  EXPECT_EQ(number(found, "Panel 1/ASB_PanelSurface/Points"), 480);
  EXPECT_EQ(found.at("Panel 1/ASB_PanelSurface/Verdict").items.at(0).items.at(0).text, "FAIL");
  EXPECT_EQ(found.at("Panel 1/ASB_PanelSurface/Quantities").items.at(0).items.at(0).text, "flatness(1m)");
  ASSERT_EQ(after.warnings.size(), 2U);
  EXPECT_EQ(after.warnings[0], "1 panels with measured surfaces are not in this design");
  EXPECT_NE(after.warnings[1].find("1 joints are not written"), std::string::npos);
  for (const Violation& violation : check_ifc(file))
    ADD_FAILURE() << violation.rule << " #" << violation.instance << " " << violation.words;
}

/// It was told as "already holds the as-built … start from the design file", which it was.
TEST_P(AsBuiltFile, TwoElementsOfOneGlobalIdAreToldAsThat) {
  const step::File file(design_bytes(), "t.ifc");
  const Model model(file);
  Appender appender(model, model.all("IFCPROJECT").at(0).text("GlobalId"), 0.001, 0);
  const auto add = [&] {
    appender.add_root("IFCPROPERTYSET", "guid1/ASB_AnchorDeviation", "ASB_AnchorDeviation", "", {"()"});
  };
  add();
  try {
    add();
    FAIL() << "written twice under one key";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("t.ifc: two elements have one GlobalId (guid1)"), std::string::npos)
        << error.what();
  }
}

TEST_P(AsBuiltFile, SurveyPointsStandWhereTheAnchorsWereMeasured) {
  const step::File file(enrich(design_bytes()).bytes, "t.ifc");
  const Model model(file);
  // #37, Level 1, stands at (10, 20, 0.1) and is turned by 90°: the measured (10.001, 21.998, 0.6005) lies at (1.998,
  // −0.001, 0.5005).
  const auto annotation = file.arguments(file.instances()[file.of_type("IFCANNOTATION")[0]]);
  const Entity placement = model.entity(annotation.at(5).id);
  EXPECT_EQ(placement.reference("PlacementRelTo"), 35u);
  const Entity point = model.entity(model.entity(placement.reference("RelativePlacement")).reference("Location"));
  EXPECT_EQ(point.numbers("Coordinates"), (std::vector<double>{1998, -1, 500.5}));
}

TEST_P(AsBuiltFile, SolidsStandAtTheAnchorsAndAreTiedToThem) {
  const step::File file(enrich(design_bytes()).bytes, "t.ifc");
  const Model model(file);
  const auto proxies = model.all("IFCBUILDINGELEMENTPROXY");
  ASSERT_EQ(proxies.size(), 4u);  // three anchors and a panel
  std::map<std::uint64_t, std::uint64_t> element_of;
  for (const std::uint32_t index : file.of_type("IFCRELASSIGNSTOPRODUCT")) {
    const auto relation = file.arguments(file.instances()[index]);
    element_of[relation.at(4).items.at(0).id] = relation.at(6).id;
  }
  EXPECT_EQ(model.entity(element_of.at(proxies[0].id())).text("Name"), "F1-C1");
  EXPECT_EQ(model.entity(element_of.at(proxies[3].id())).text("Name"), "Panel 1");
  EXPECT_EQ(file.of_type("IFCSTYLEDITEM").size(), 4u);
  EXPECT_EQ(file.of_type("IFCSURFACESTYLE").size(), 3u);  // pass and fail of anchors, fail of a panel
  // Read back as a design: the marker's middle is where the anchor was measured, 1 mm, -2 mm, 0.5 mm off.
  const Design after = read_design(file, {});
  for (const Element& element : after.elements) {
    if (element.name != "As-built " + after.elements[0].guid) continue;
    EXPECT_NEAR((element.position - after.elements[0].position - Eigen::Vector3d(0.001, -0.002, 0.0005)).norm(), 0,
                1e-6);
  }
}

TEST_P(AsBuiltFile, EpochsStandSideBySideAndRepetitionsAreRefused) {
  AsBuiltIfcOptions first, second;
  first.epoch = "2026-05";
  second.epoch = "2026-06";
  const std::string once = enrich(design_bytes(), first).bytes;
  const std::string twice = enrich(once, second).bytes;
  const step::File file(twice, "t.ifc");
  const Model model(file);
  EXPECT_EQ(file.of_type("IFCANNOTATION").size(), 6u);
  int applications = 0;
  for (const Entity& application : model.all("IFCAPPLICATION"))
    applications += application.text("ApplicationIdentifier") == "plumbline-as-built";
  EXPECT_EQ(applications, 1);
  // UniquePropertySetNames: no object has two sets of one name. IfcPropertyEnumeration: the name is unique.
  std::set<std::pair<std::uint64_t, std::string>> sets;
  for (const Entity& relation : model.all("IFCRELDEFINESBYPROPERTIES"))
    for (const std::uint64_t object : relation.references("RelatedObjects")) {
      const std::string name = model.entity(relation.reference("RelatingPropertyDefinition")).text("Name");
      EXPECT_TRUE(sets.insert({object, name}).second) << name;
    }
  std::set<std::string> enumerations;
  for (const Entity& enumeration : model.all("IFCPROPERTYENUMERATION"))
    EXPECT_TRUE(enumerations.insert(enumeration.text("Name")).second);
  EXPECT_EQ(properties_of(file).at("F1-C1/ASB_AnchorDeviation_2026-06/Epoch").items.at(0).text, "2026-06");
  try {
    enrich(once, first);
    FAIL() << "the same epoch was written twice";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("start from the design file, or give another 'epoch'"), std::string::npos)
        << error.what();
  }
}

TEST_P(AsBuiltFile, SolidsOfAnEarlierEpochAreNoAnchors) {
  AsBuiltIfcOptions options;
  options.epoch = "2026-05";
  AnchorRule by_name;
  by_name.pattern = "F[0-9]-C[0-9]";
  by_name.classes.emplace_back("IfcBuildingElementProxy");
  const auto anchors = [&](const std::string& bytes) {
    std::vector<std::string> names;
    for (const Element& element : read_design(step::File(bytes, "t.ifc"), by_name).elements)
      if (element.is_anchor) names.push_back(element.name);
    return names;
  };
  EXPECT_EQ(anchors(enrich(design_bytes(), options).bytes), anchors(design_bytes()));
}

TEST_P(AsBuiltFile, AdditionsCarryTheirOwnDate) {
  AsBuiltIfcOptions options;
  options.timestamp = 1778580000;
  const step::File file(enrich(design_bytes(), options).bytes, "t.ifc");
  const Model model(file);
  const auto histories = model.all("IFCOWNERHISTORY");
  EXPECT_EQ(histories.back().number("CreationDate"), 1778580000);
  EXPECT_EQ(histories.front().number("CreationDate"), 1700000000);
}

INSTANTIATE_TEST_SUITE_P(Schemas, AsBuiltFile, testing::Values(Schema::ifc2x3, Schema::ifc4, Schema::ifc4x3),
                         [](const auto& test) { return schema_name(test.param); });

TEST(AsBuiltUnits, FeetStayFeet) {
  const std::string feet = test::small_building(
      "IFC4", "#500=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);",
      "#11=IFCCONVERSIONBASEDUNIT(#14,.LENGTHUNIT.,'FOOT',#17);#17=IFCMEASUREWITHUNIT(IFCRATIOMEASURE(0.3048),#500);");
  const step::File file(enrich(feet).bytes, "t.ifc");
  EXPECT_NEAR(number(properties_of(file), "F1-C1/ASB_AnchorDeviation/DeviationX"), 0.001 / 0.3048, 1e-9);
}

TEST(AsBuiltFloors, WithoutStoreysOnlyTheFloorStatisticsAreMissing) {
  std::string bytes = test::small_building("IFC4");
  for (const char* line : {"#36=IFCBUILDINGSTOREY", "#37=IFCBUILDINGSTOREY", "#40=", "#200=", "#201="}) {
    const std::size_t at = bytes.find(line);
    bytes.erase(at, bytes.find('\n', at) + 1 - at);
  }
  const Enriched result = enrich(bytes);
  const step::File file(result.bytes, "t.ifc");
  EXPECT_EQ(file.of_type("IFCANNOTATION").size(), 3u);  // in the building
  EXPECT_EQ(properties_of(file).count("F1-C1/ASB_AnchorDeviation/Verdict"), 1u);
  EXPECT_EQ(result.bytes.find("ASB_FloorStatistics"), std::string::npos);
}

TEST(AsBuiltIfc, NothingItAddsBecomesTheTargetOfAReferenceToNothing) {
  std::string bytes = test::small_building("IFC4");
  bytes.insert(bytes.rfind("ENDSEC;"),
               "#230=IFCGROUP('0000000000000000000001',$,'cut out',$,$);\n"
               "#231=IFCRELASSIGNSTOGROUP('0000000000000000000002',$,$,$,(#233,#250),$,#230);\n");
  const Enriched result = enrich(bytes);
  const step::File after(result.bytes, "after.ifc");
  EXPECT_GT(result.instances_added, 100u);
  for (const std::uint64_t cut_out : {233u, 250u}) EXPECT_FALSE(after.find(cut_out)) << cut_out;
}

/// Found by the fuzzer: a time stamp that no whole number of seconds can hold.
TEST(AsBuiltIfc, ADateBeyondTheCalendarIsNotTheLatest) {
  std::string bytes = test::small_building("IFC4");
  bytes.insert(bytes.rfind("ENDSEC;"),
               "#230=IFCOWNERHISTORY(#3,#4,$,.NOCHANGE.,1.E300,$,$,-1.E300);\n"
               "#231=IFCOWNERHISTORY(#3,#4,$,.NOCHANGE.,$,$,$,253402300800);\n");
  const step::File file(enrich(bytes).bytes, "t.ifc");
  const Model model(file);
  EXPECT_EQ(model.all("IFCOWNERHISTORY").back().number("CreationDate"), 1700000000);
}

TEST(AsBuiltRealFiles, AreEnrichedAndValid) {
  for (const char* name :
       {"510--curtainWall.ifc", "Ifc4_SampleHouse.ifc", "TallBuilding.ifc", "tested_sample_project_2x3.ifc"}) {
    PLUMBLINE_REQUIRE_DATA(std::string("ifc/") + name);
    const step::File file = step::File::read(test::data_file(std::string("ifc/") + name).string());
    // No real file at hand has fasteners: windows and plates stand in.
    const Design design = read_design(file, {{"IfcPlate", "IfcWindow"}, "", {}, {}, {}});
    std::map<std::string, Eigen::Vector3d> deviations;
    for (const Element& element : design.elements)
      if (element.is_anchor) deviations[element.guid] = Eigen::Vector3d(0.001, 0.002, 0.003);
    const DeviationT deviation =
        test::judged(design, deviations, Eigen::Vector3d::Constant(3e-4), Eigen::Vector3d::Constant(std::nan("")));
    EXPECT_EQ(deviation.passed, static_cast<int>(deviations.size())) << name;
    const AsBuiltIfc result = write_as_built(file, design, deviation, test::residuals(deviation, 0.001), {});
    const std::string bytes = enriched(file, result);
    EXPECT_EQ(bytes.substr(0, file.data_end()), file.bytes().substr(0, file.data_end())) << name;
    EXPECT_TRUE(bytes.ends_with(file.bytes().substr(file.data_end()))) << name;
    const step::File after(bytes, name);
    for (const Violation& violation : check_ifc(after, file.largest_id() + 1))
      ADD_FAILURE() << name << " " << violation.rule << " #" << violation.instance << " " << violation.words;
    const std::string express = std::string("ifc/express/") + design.schema + ".exp";
    const test::ExpressSchema schema(test::read_file(test::data_file(express)));
    for (const step::Instance& instance : after.instances())
      if (instance.id > file.largest_id())
        for (const std::string& wrong : schema.check(after, instance)) ADD_FAILURE() << name << " " << wrong;
  }
}

}  // namespace test_as_built_ifc
}  // namespace plumbline::ifc

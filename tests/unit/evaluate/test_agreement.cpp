// One judgement: all outputs say the same of every anchor, panel and floor, in random campaigns. PLUMBLINE_LONG=1 runs
// 500.
#include <gtest/gtest.h>

#include <cstdlib>

#include "agreement.hpp"
#include "artifacts.hpp"
#include "build/evaluate/design_input.hpp"
#include "build/evaluate/metrics.hpp"
#include "building/ifc/as_built_ifc.hpp"
#include "building/ifc/bcf.hpp"
#include "building/ifc/ifc_guid.hpp"
#include "building/ifc/match_elements.hpp"
#include "building/judgement/worst_first.hpp"
#include "show/report/deviation_workbook.hpp"
#include "show/report/summary.hpp"

namespace plumbline::judgement {
namespace test_agreement {

using test::mm;
using test::Normal;

std::string guid_of(const std::string& key) { return ifc::derived_ifc_guid("0YvctVUKr0kugbFTf53O9L", key); }

/// A facade of floors and columns with an anchor at every crossing and a panel in every field between.
std::string facade_ifc(int floors, int columns, const std::string& schema) {
  const std::string tail = schema == "IFC2X3" ? ");" : ",$);", fastener = schema == "IFC2X3" ? "$,$);" : "$,$,$);";
  std::string out =
      "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('f.ifc','2024-01-01T00:00:00',(''),(''),'','','"
      "');\n"
      "FILE_SCHEMA(('" +
      schema + "'));\nENDSEC;\nDATA;\n";
  const auto line = [&](const std::string& text) { out += text + "\n"; };
  line("#1=IFCPERSON($,'Doe',$,$,$,$,$,$);");
  line("#2=IFCORGANIZATION($,'Office',$,$,$);");
  line("#3=IFCPERSONANDORGANIZATION(#1,#2,$);");
  line("#4=IFCAPPLICATION(#2,'1','Modeller','MOD');");
  line("#5=IFCOWNERHISTORY(#3,#4,$,.ADDED.,1700000000,$,$,1700000000);");
  line("#11=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);");
  line("#12=IFCSIUNIT(*,.PLANEANGLEUNIT.,$,.RADIAN.);");
  line("#13=IFCUNITASSIGNMENT((#11,#12));");
  line("#20=IFCCARTESIANPOINT((0.,0.,0.));");
  line("#21=IFCAXIS2PLACEMENT3D(#20,$,$);");
  line("#22=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-05,#21,$);");
  line("#23=IFCPROJECT('0YvctVUKr0kugbFTf53O9L',#5,'P',$,$,$,$,(#22),#13);");
  line("#24=IFCLOCALPLACEMENT($,#21);");
  line("#25=IFCBUILDING('" + guid_of("building") + "',#5,'B',$,$,#24,$,$,.ELEMENT.,$,$,$);");
  line("#26=IFCDIRECTION((0.,0.,1.));");
  line("#27=IFCCARTESIANPOINT((0.,0.));");
  line("#28=IFCAXIS2PLACEMENT2D(#27,$);");
  line("#29=IFCRECTANGLEPROFILEDEF(.AREA.,$,#28,1.98,0.02);");
  line("#30=IFCEXTRUDEDAREASOLID(#29,#21,#26,2.98);");
  line("#31=IFCSHAPEREPRESENTATION(#22,'Body','SweptSolid',(#30));");
  line("#32=IFCPRODUCTDEFINITIONSHAPE($,$,(#31));");
  line("#33=IFCRELAGGREGATES('" + guid_of("r") + "',#5,$,$,#23,(#25));");
  int id = 100;
  std::string storeys;
  for (int floor = 1; floor <= floors; ++floor) {
    const int storey = id++;
    line("#" + std::to_string(storey) + "=IFCBUILDINGSTOREY('" + guid_of("storey" + std::to_string(floor)) +
         "',#5,'Level " + std::to_string(floor) + "',$,$,#24,$,$,.ELEMENT.," + std::to_string(3 * floor) + ".);");
    storeys += (storeys.empty() ? "#" : ",#") + std::to_string(storey);
    std::string contained;
    for (int column = 0; column < columns; ++column) {
      const std::string name = "F" + std::to_string(floor) + "C" + std::to_string(column);
      const int point = id, axes = id + 1, placement = id + 2, element = id + 3;
      id += 4;
      line("#" + std::to_string(point) + "=IFCCARTESIANPOINT((" + std::to_string(2 * column) + ".,0.," +
           std::to_string(3 * floor) + ".));");
      line("#" + std::to_string(axes) + "=IFCAXIS2PLACEMENT3D(#" + std::to_string(point) + ",$,$);");
      line("#" + std::to_string(placement) + "=IFCLOCALPLACEMENT(#24,#" + std::to_string(axes) + ");");
      line("#" + std::to_string(element) + "=IFCMECHANICALFASTENER('" + guid_of(name) + "',#5,'" + name + "',$,$,#" +
           std::to_string(placement) + ",$,'T" + name + "'," + fastener);
      contained += (contained.empty() ? "#" : ",#") + std::to_string(element);
      if (floor == floors || column + 1 == columns) continue;
      const std::string panel = "P" + name;
      line("#" + std::to_string(id) + "=IFCCARTESIANPOINT((" + std::to_string(2 * column + 1) + ".,-0.05," +
           std::to_string(3 * floor) + ".01));");
      line("#" + std::to_string(id + 1) + "=IFCAXIS2PLACEMENT3D(#" + std::to_string(id) + ",$,$);");
      line("#" + std::to_string(id + 2) + "=IFCLOCALPLACEMENT(#24,#" + std::to_string(id + 1) + ");");
      line("#" + std::to_string(id + 3) + "=IFCPLATE('" + guid_of(panel) + "',#5,'" + panel + "',$,$,#" +
           std::to_string(id + 2) + ",#32,$" + tail);
      contained += ",#" + std::to_string(id + 3);
      id += 4;
    }
    line("#" + std::to_string(id++) + "=IFCRELCONTAINEDINSPATIALSTRUCTURE('" + guid_of("c" + std::to_string(floor)) +
         "',#5,$,$,(" + contained + "),#" + std::to_string(storey) + ");");
  }
  line("#" + std::to_string(id) + "=IFCRELAGGREGATES('" + guid_of("s") + "',#5,$,$,#25,(" + storeys + "));");
  return out + "ENDSEC;\nEND-ISO-10303-21;\n";
}

Campaign random_campaign(std::uint64_t seed) {
  Normal normal(seed);
  const auto die = [&](int sides) { return static_cast<int>(std::abs(normal()) * 1000) % sides; };
  Campaign c;
  const int floors = 2 + die(3), columns = 2 + die(4);
  c.bytes = facade_ifc(floors, columns, die(2) ? "IFC4" : die(2) ? "IFC2X3" : "IFC4X3");
  c.design = ifc::read_design(step::File(c.bytes, "f.ifc"), {});
  Inputs inputs;
  PlatesT plates;
  std::vector<std::string> ids;
  const double sigma = die(6) ? (0.1 + 0.3 * die(8)) * mm : 0;  // sometimes nobody knows the uncertainty
  const double built = (1 + die(5)) * mm;
  for (const ifc::Element& element : c.design.elements) {
    if (!element.is_anchor || die(12) == 0) continue;  // some are not in the plate table
    const std::string id = die(2) ? element.name : element.tag;
    const int floor = element.name[1] - '0';
    ids.push_back(id);
    auto plate = std::make_unique<PlateT>();
    plate->nominal_rotation.setIdentity();  // no azimuth
    plate->anchor = id, plate->floor = floor, plate->column = 1, plate->role = die(2) ? "check" : "control";
    inputs.anchors.push_back({id, floor, 1, 1, plate->role == "check" ? AnchorUse::check : AnchorUse::control});
    plates.plates.push_back(std::move(plate));
    const Eigen::Vector3d place = element.position + Eigen::Vector3d(normal(), normal(), normal()) * built;
    inputs.survey.ids.push_back(id), inputs.survey.positions.push_back(place);
    if (die(10) == 0) continue;  // some were not measured
    inputs.model.ids.push_back(id);
    inputs.model.positions.push_back(place + Eigen::Vector3d(normal(), normal(), normal()) * 0.5 * mm);
  }
  inputs.model.covariance = sigma > 0 ? test::isotropic(inputs.model.ids.size(), sigma) : Eigen::MatrixXd();
  inputs.survey.covariance = test::isotropic(inputs.survey.ids.size(), 0.5 * mm);
  std::vector<std::string> warnings;
  ElementMatchesT matches;
  for (const ifc::MatchedElement& match : ifc::match_elements(c.design, ids, {}, warnings)) {
    auto entry = std::make_unique<ElementMatchT>();
    entry->anchor = match.anchor, entry->found_by = match.found_by, entry->note = match.note;
    entry->guid = match.element ? match.element->guid : "";
    entry->position = match.reference, entry->target_offset.setZero();
    matches.matches.push_back(std::move(entry));
  }
  judgement::ToleranceTable table;
  if (die(2))
    table.rules = {judgement::parse_rule("name~C1$: vertical=3mm, out_of_plane=4mm"),
                   judgement::parse_rule("class=IfcPlate: joint=6mm")};
  auto cases = deviation_inputs(ifc::to_artifact(c.design), matches, plates, table, 0.3);
  cases.model = inputs.model;
  c.deviation = judgement::judge_deviations(cases, {});
  c.accuracy = evaluate_accuracy(inputs, {});
  return c;
}

TEST(Agreement, AllOutputsSayTheSameOfEveryAnchorPanelAndFloor) {
  const int trials = std::getenv("PLUMBLINE_LONG") ? 500 : 25;
  std::array<int, 4> seen{};
  for (int trial = 1; trial <= trials; ++trial) {
    SCOPED_TRACE("seed " + std::to_string(trial));
    expect_agreement(random_campaign(static_cast<std::uint64_t>(trial)), trial % 2 ? "" : "2026-05", seen);
  }
  for (const int n : seen) EXPECT_GT(n, 0);  // every verdict occurred
}

/// Why all of it is less certain, and what a floor has in common, stood on the page and in the summary alone.
TEST(Agreement, MisfitsAndShiftsAreInEveryOutput) {
  Campaign c = random_campaign(7);
  auto misfit = std::make_unique<MeasurementDoubtT>();
  misfit->part = MeasurementPart::image_block, misfit->grade = DoubtGrade::misfit, misfit->factor = 1.34;
  misfit->reason = "the images have principal points of their own, 1.7 px apart";
  misfit->about = "principal_points/one principal point";
  c.deviation.misfits.push_back(std::move(misfit));
  auto shift = std::make_unique<GroupShiftT>();
  shift->kind = "floor", shift->name = "Floor 1", shift->floor = 1, shift->significant = true;
  shift->shift.setZero(), shift->u.setZero(), shift->spread.setZero();
  shift->words =
      "Floor 1 hangs 12.0 mm ± 0.9 mm low (4 of its 4 anchors share it): one cause to look for, before single anchors "
      "are reset.";
  shift->finding = "Floor 1 hangs 12.0 mm ± 0.9 mm low";
  for (std::size_t i = 0; i < c.deviation.anchors.size(); ++i)
    if (c.deviation.anchors[i]->floor == 1) shift->members.push_back(static_cast<int>(i));
  c.deviation.group_shifts.insert(c.deviation.group_shifts.begin(), std::move(shift));
  c.deviation.warnings.push_back(c.deviation.group_shifts[0]->words);
  AnchorDeviationT* first = nullptr;
  for (auto& anchor : c.deviation.anchors)
    if (!first && anchor->floor == 1 && anchor->deviation.allFinite() && anchor->guid.size() == 22)
      first = anchor.get();
  ASSERT_NE(first, nullptr);
  first->verdict = ToleranceVerdict::fail;
  const step::File design(c.bytes, "f.ifc");
  const std::string enriched =
      ifc::enriched(design, ifc::write_as_built(design, c.design, c.deviation, c.accuracy, {}));
  ifc::BcfOptions options;
  options.project_guid = "0YvctVUKr0kugbFTf53O9L";
  const std::string bcf = ifc::write_bcf(c.deviation, judgement::worst_first(c.deviation),
                                         judgement::worst_panels_first(c.deviation), options),
                    junit = junit_xml(c.accuracy, &c.deviation),
                    summary = report::summary_text(c.accuracy, &c.deviation);
  for (const std::string* text : {&bcf, &junit, &summary, &enriched})
    for (const char* words : {"principal points of their own", "Floor 1 hangs 12.0 mm"})
      EXPECT_NE(text->find(words), std::string::npos) << words << "\n" << *text;
  EXPECT_NE(bcf.find("<Title>Measurement less certain: the image block</Title>"), std::string::npos);
  EXPECT_NE(bcf.find("LESS CERTAIN</Labels>"), std::string::npos);
  const auto topic_of_misfit = [](const std::string& file) {
    const std::string before = file.substr(0, file.find("<Title>Measurement less certain"));
    return before.substr(before.rfind("<Topic "), 100);
  };
  c.deviation.misfits.back()->factor = 1.41;
  c.deviation.misfits.back()->reason = "the images have principal points of their own, 1.8 px apart";
  EXPECT_EQ(topic_of_misfit(ifc::write_bcf(c.deviation, judgement::worst_first(c.deviation),
                                           judgement::worst_panels_first(c.deviation), options)),
            topic_of_misfit(bcf))
      << "another campaign's figures are no other topic";
  const std::size_t topic = bcf.find("<Title>Floor 1 hangs 12.0 mm ± 0.9 mm low</Title>");
  EXPECT_NE(bcf.substr(topic, 400).find("<Labels>Floor 1</Labels>"), std::string::npos) << bcf.substr(topic, 400);
  EXPECT_LT(topic, bcf.find("<Title>Anchor ")) << "the one cause, before single anchors";
  EXPECT_NE(bcf.find("It has this in common with others: Floor 1 hangs 12.0 mm ± 0.9 mm low; look for that one cause"),
            std::string::npos);
  const std::size_t list = summary.find("\n  ");  // of what fails
  EXPECT_LT(summary.find("Floor 1 hangs"), list) << summary;
  EXPECT_EQ(summary.find("Note: Floor 1 hangs"), std::string::npos) << "once is enough";
  const auto sheets = report::deviation_sheets(c.deviation, report::Language::english);
  bool there = false;
  for (const auto& row : sheets.back().rows)
    if (const auto* text = std::get_if<std::string>(&row.front())) there = there || text->starts_with("Less certain, ");
  EXPECT_TRUE(there) << "the workbook";
}

}  // namespace test_agreement
}  // namespace plumbline::judgement

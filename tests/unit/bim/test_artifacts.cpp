// Between artifacts and plain structs nothing is lost or mixed up.
#include <gtest/gtest.h>

#include <cmath>
#include <tuple>

#include "artifacts.hpp"
#include "building/step/step.hpp"
#include "small_building.hpp"

namespace plumbline::ifc {
namespace test_artifacts {

TEST(BimArtifacts, DesignsSurviveTheRoundTrip) {
  const step::File file(test::small_building("IFC4"), "small.ifc");
  Design design = read_design(file, {});
  design.warnings = {"w"};
  design.map_conversion = MapConversion{1, 2, 3, 0.5, 0.25, 0.001, true, "EPSG:1", 1};
  design.elements[0].item_positions = {{1, 2, 3}};
  design.elements[0].anchor_guids = {"g"};
  design.elements[0].properties = {{"S", "P", "3.", 0.003}};
  design.skipped = {"IfcBeam"};
  flatbuffers::FlatBufferBuilder builder;
  const DesignT artifact = to_artifact(design);
  builder.Finish(plumbline::Design::Pack(builder, &artifact));
  DesignT unpacked;
  flatbuffers::GetRoot<plumbline::Design>(builder.GetBufferPointer())->UnPackTo(&unpacked);
  const Design back = from_artifact(unpacked);
  ASSERT_EQ(back.elements.size(), design.elements.size());
  for (std::size_t i = 0; i < design.elements.size(); ++i) {
    const Element &a = design.elements[i], &b = back.elements[i];
    EXPECT_EQ(std::tie(a.guid, a.name, a.tag, a.object_type, a.ifc_class, a.storey, a.storey_guid, a.parent_guid,
                       a.instance, a.anchor_guids),
              std::tie(b.guid, b.name, b.tag, b.object_type, b.ifc_class, b.storey, b.storey_guid, b.parent_guid,
                       b.instance, b.anchor_guids));
    EXPECT_EQ(std::tie(a.rule, a.is_anchor, a.is_panel, a.has_box),
              std::tie(b.rule, b.is_anchor, b.is_panel, b.has_box));
    EXPECT_EQ(a.position, b.position);
    EXPECT_EQ(a.box_high, b.box_high);
    EXPECT_EQ(a.item_positions, b.item_positions);
    EXPECT_EQ(a.project_from_element.rotation.coeffs(), b.project_from_element.rotation.coeffs());
  }
  EXPECT_EQ(back.elements[0].properties.at(0).number, 0.003);
  EXPECT_EQ(back.skipped, design.skipped);
  EXPECT_EQ(back.storeys[1].name, "Level 2");
  EXPECT_EQ(artifact.storeys[1]->floor, 2);
  EXPECT_EQ(back.map_conversion->crs_name, "EPSG:1");
  EXPECT_EQ(back.map_conversion->scale, 0.001);
}

/// A value of its own in every field, so that an exchanged or forgotten one shows.
Design with_all_that_there_is() {
  Design design;
  design.file_name = "a.ifc", design.schema = "IFC4X3_ADD2", design.project_guid = "b", design.project_name = "c";
  design.length_unit = 0.3048, design.length_unit_name = "FOOT";
  design.storeys = {{"d", "Level 1", 1.25, 1.5, 7}, {"e", "Level 2", 4.25, 4.5, 8}};
  const auto frame = [](double from, FacadeSource source, const char* name) {
    FacadeFrame made;
    made.right = {from, 1, 2}, made.up = {from, 3, 4}, made.out = {from, 5, 6};
    made.source = source, made.facade = name, made.note = std::string("note of ") + name;
    return made;
  };
  for (const auto rule : {ReferencePointRule::placement, ReferencePointRule::axis_middle,
                          ReferencePointRule::bounding_box_centre, ReferencePointRule::parts_centre}) {
    Element e;
    const std::string number = std::to_string(static_cast<int>(rule));
    e.guid = "guid" + number, e.name = "name", e.tag = "tag", e.object_type = "object", e.type_name = "type";
    e.ifc_class = "IfcPlate", e.storey = "Level 2", e.storey_guid = "e", e.parent_guid = "parent";
    e.position = {1, 2, 3}, e.rule = rule;
    e.is_anchor = rule == ReferencePointRule::placement, e.is_panel = rule == ReferencePointRule::axis_middle;
    e.project_from_element = {Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {4, 5, 6}};
    e.has_box = rule != ReferencePointRule::parts_centre;
    if (e.has_box) e.box_low = {-1, -2, -3}, e.box_high = {7, 8, 9};
    e.filled = {1, 0.5}, e.rectangles = {0.25, 0.75}, e.sag = {0.001, 0.002, 0.003, 0.004},
    e.item_positions = {{1, 2, 3}, {4, 5, 6}};
    e.anchor_guids = {"h", "i"}, e.host_guid = "host", e.instance = 4711;
    if (e.is_anchor || e.is_panel) e.facade = frame(e.is_anchor ? 10 : 20, FacadeSource::wall, "South");
    e.facade.confirmed = e.is_panel;
    e.properties = {{"Set", "Name", "3.", 0.003, "IFCLENGTHMEASURE", 0.001, 0.005}, {"Set", "Other", "yes", 1}};
    design.elements.push_back(e);
  }
  design.facades = {{"South", {0, -1, 0}, {1, 2, 3}, 0.1, 3, 4, FacadeSource::guess, false, "doubtful"}};
  design.map_conversion = MapConversion{1, 2, 3, 0.5, 0.25, 0.001, true, "EPSG:1", 0.3048};
  design.site_origin = {11, 12, 13}, design.true_north = 0.3;
  design.grid = {{"A", "u", {1, 2, 0}, {0, 1, 0}}, {"4", "v", {3, 4, 0}, {1, 0, 0}}};
  design.skipped = {"IfcBeam"}, design.warnings = {"w"}, design.not_applied = {{"asked", "by", "reason"}};
  return design;
}

void expect_equal(const Element& a, const Element& b) {
  EXPECT_EQ(std::tie(a.guid, a.name, a.tag, a.object_type, a.type_name, a.ifc_class, a.storey, a.storey_guid,
                     a.parent_guid, a.host_guid, a.anchor_guids, a.sag, a.filled, a.rectangles, a.instance, a.rule),
            std::tie(b.guid, b.name, b.tag, b.object_type, b.type_name, b.ifc_class, b.storey, b.storey_guid,
                     b.parent_guid, b.host_guid, b.anchor_guids, b.sag, b.filled, b.rectangles, b.instance, b.rule));
  EXPECT_EQ(std::tie(a.is_anchor, a.is_panel, a.has_box), std::tie(b.is_anchor, b.is_panel, b.has_box));
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.item_positions, b.item_positions);
  EXPECT_EQ(a.box_low, b.box_low);
  EXPECT_EQ(a.box_high, b.box_high);
  EXPECT_EQ(a.project_from_element.rotation.coeffs(), b.project_from_element.rotation.coeffs());
  EXPECT_EQ(a.project_from_element.translation, b.project_from_element.translation);
  EXPECT_EQ(a.facade.known(), b.facade.known());
  if (a.facade.known()) {
    EXPECT_EQ(a.facade.right, b.facade.right);
    EXPECT_EQ(a.facade.up, b.facade.up);
    EXPECT_EQ(a.facade.out, b.facade.out);
    EXPECT_EQ(std::tie(a.facade.source, a.facade.confirmed, a.facade.facade, a.facade.note),
              std::tie(b.facade.source, b.facade.confirmed, b.facade.facade, b.facade.note));
  }
  ASSERT_EQ(a.properties.size(), b.properties.size());
  for (std::size_t i = 0; i < a.properties.size(); ++i) {
    const Property &p = a.properties[i], &q = b.properties[i];
    EXPECT_EQ(std::tie(p.set, p.name, p.text, p.number, p.measure),
              std::tie(q.set, q.name, q.text, q.number, q.measure));
    const auto bounds_of = [](const Property& of) {
      return std::isnan(of.lower) && std::isnan(of.upper) ? std::pair(0.0, 0.0) : std::pair(of.lower, of.upper);
    };
    EXPECT_EQ(bounds_of(p), bounds_of(q)) << "no bounds stay none";
  }
}

TEST(BimArtifacts, EveryFieldOfADesignComesBackAsItWas) {
  const Design design = with_all_that_there_is(), back = from_artifact(to_artifact(design));
  EXPECT_EQ(std::tie(back.file_name, back.schema, back.project_guid, back.project_name, back.length_unit,
                     back.length_unit_name, back.true_north, back.skipped, back.warnings),
            std::tie(design.file_name, design.schema, design.project_guid, design.project_name, design.length_unit,
                     design.length_unit_name, design.true_north, design.skipped, design.warnings));
  EXPECT_EQ(back.site_origin, design.site_origin);
  ASSERT_EQ(back.storeys.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const Storey &a = design.storeys[i], &b = back.storeys[i];
    EXPECT_EQ(std::tie(a.guid, a.name, a.elevation, a.placement_height, a.instance),
              std::tie(b.guid, b.name, b.elevation, b.placement_height, b.instance));
  }
  ASSERT_EQ(back.elements.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) expect_equal(design.elements[i], back.elements[i]);
  const Facade &a = design.facades[0], &b = back.facades.at(0);
  EXPECT_EQ(std::tie(a.name, a.bend, a.anchors, a.panels, a.source, a.confirmed, a.note),
            std::tie(b.name, b.bend, b.anchors, b.panels, b.source, b.confirmed, b.note));
  EXPECT_EQ(a.out, b.out);
  EXPECT_EQ(a.centre, b.centre);
  EXPECT_TRUE(*back.map_conversion == *design.map_conversion);
  EXPECT_EQ(
      std::tie(back.map_conversion->scale_given, back.map_conversion->crs_name, back.map_conversion->map_unit),
      std::tie(design.map_conversion->scale_given, design.map_conversion->crs_name, design.map_conversion->map_unit));
  ASSERT_EQ(back.grid.size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(std::tie(design.grid[i].tag, design.grid[i].family), std::tie(back.grid[i].tag, back.grid[i].family));
    EXPECT_EQ(design.grid[i].point, back.grid[i].point);
    EXPECT_EQ(design.grid[i].direction, back.grid[i].direction);
  }
  const NotApplied& request = back.not_applied.at(0);
  EXPECT_EQ(std::tie(request.asked, request.by, request.reason), std::make_tuple("asked", "by", "reason"));
}

/// Right and up of a building are those of its facade only if it has one, and that one does not bend.
TEST(BimArtifacts, ABuildingHasAFacadesDirectionOnlyIfItHasOneThatIsStraight) {
  Design design = with_all_that_there_is();
  EXPECT_TRUE(to_artifact(design).facade_normal.array().isNaN().all()) << "it bends";
  design.facades[0].bend = 0.0009;
  EXPECT_EQ(to_artifact(design).facade_normal, design.facades[0].out);
  design.facades.push_back(design.facades[0]);
  EXPECT_TRUE(to_artifact(design).facade_normal.array().isNaN().all()) << "two of them";
}

TEST(BimArtifacts, AnchorPointsAreNamedUniquely) {
  const step::File file(test::small_building("IFC4"), "small.ifc");
  Design design = read_design(file, {});
  EXPECT_EQ(anchor_points(design).points[0]->id, "F1-C1");
  for (Element& element : design.elements)
    if (element.is_anchor) element.name = "bolt";
  EXPECT_EQ(anchor_points(design).points[0]->id, "11vctVUKr0kugbFTf53O9L");
}

}  // namespace test_artifacts
}  // namespace plumbline::ifc

// Between artifacts and plain structs nothing is lost or mixed up.
#include <gtest/gtest.h>

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

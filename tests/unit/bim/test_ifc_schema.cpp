// Our table of attribute positions and element classes against the EXPRESS text of the schemas.
#include "building/ifc/ifc_schema.hpp"
#include "express_schema.hpp"
#include "test_support.hpp"

namespace plumbline::ifc {
namespace test_ifc_schema {

step::File file_of(const std::string& schema) {
  return step::File("ISO-10303-21;HEADER;FILE_SCHEMA((" + schema + "));ENDSEC;DATA;ENDSEC;END-ISO-10303-21;", "t.ifc");
}

class IfcSchema : public testing::TestWithParam<Schema> {};

TEST_P(IfcSchema, TablesAgreeWithTheExpressText) {
  const std::string path = std::string("ifc/express/") + schema_name(GetParam()) + ".exp";
  PLUMBLINE_REQUIRE_DATA(path);
  const test::ExpressSchema schema(test::read_file(test::data_file(path)));
  const unsigned bit = static_cast<unsigned>(GetParam());

  std::size_t elements = 0;
  for (const auto& [name, entity] : schema.entities()) {
    const bool expected = schema.is_a(name, "IFCELEMENT");
    EXPECT_EQ(element_class_name(GetParam(), name), expected ? entity.name : "") << name;
    elements += expected;
  }
  EXPECT_GT(elements, 50u);

  for (const EntityLayout& layout : entity_layouts()) {
    const std::string keyword(layout.keyword);
    if (!(layout.schemas & bit)) continue;
    ASSERT_TRUE(schema.entities().contains(keyword)) << keyword;
    const auto attributes = schema.all_attributes(keyword);
    std::istringstream names{std::string(layout.attributes)};
    std::string name;
    for (std::size_t i = 0; names >> name; ++i) {
      ASSERT_LT(i, attributes.size()) << keyword << " " << name;
      EXPECT_EQ(attributes[i].name, name) << keyword;
      EXPECT_EQ(attribute_position(layout, name), i) << keyword;
    }
  }
  // What the table leaves out of a schema, the schema must not have.
  for (const EntityLayout& layout : entity_layouts())
    if (!find_layout(GetParam(), layout.keyword)) {
      EXPECT_FALSE(schema.entities().contains(std::string(layout.keyword))) << layout.keyword;
    }
}

INSTANTIATE_TEST_SUITE_P(Schemas, IfcSchema, testing::Values(Schema::ifc2x3, Schema::ifc4, Schema::ifc4x3),
                         [](const auto& test) { return schema_name(test.param); });

TEST(IfcSchemaName, IsReadFromTheHeader) {
  EXPECT_EQ(schema_of(file_of("'IFC2X3'")), Schema::ifc2x3);
  EXPECT_EQ(schema_of(file_of("'ifc4'")), Schema::ifc4);
  EXPECT_EQ(schema_of(file_of("'IFC4X3_ADD2'")), Schema::ifc4x3);
  EXPECT_THROW(schema_of(file_of("'AP214'")), step::Error);
  EXPECT_THROW(schema_of(file_of("")), step::Error);
}

TEST(IfcSchemaName, ElementsGetTheirProperCase) {
  EXPECT_EQ(element_class_name(Schema::ifc4, "IFCMECHANICALFASTENER"), "IfcMechanicalFastener");
  EXPECT_EQ(element_class_name(Schema::ifc2x3, "IFCFURNITURE"), "");
  EXPECT_EQ(element_class_name(Schema::ifc4, "IFCSPACE"), "");
}

}  // namespace test_ifc_schema
}  // namespace plumbline::ifc

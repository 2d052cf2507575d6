// Damaged and hostile designs: named, at a bounded cost, and never a place that nobody meant.
#include <algorithm>

#include "building/ifc/design.hpp"
#include "design_reading.hpp"
#include "design_variants.hpp"
#include "small_building.hpp"
#include "test_support.hpp"

namespace plumbline::ifc {
namespace test_design_damage {

using test::small_building;
using test::with_anchor;

/// The error, or what the design says of what it could not read.
std::string said_of(const std::string& bytes) {
  std::string text;
  try {
    const Design design = read(bytes);
    for (const std::string& skipped : design.skipped) text += skipped + "\n";
    for (const std::string& warning : design.warnings) text += warning + "\n";
  } catch (const step::Error& error) {
    text = error.what();
  }
  return text.empty() ? "no error" : text;
}

TEST(Damage, IsNamedAndNeverCrashes) {
  const std::string whole = small_building("IFC4");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string bytes = whole;
    for (std::size_t at = 0; (at = bytes.find(from, at)) != std::string::npos; at += to.size())
      bytes.replace(at, from.size(), to);
    EXPECT_NE(bytes, whole) << from;
    return said_of(bytes);
  };
  EXPECT_NE(changed("IFCBUILDINGSTOREY(", "IFCPOST(").find("has no IfcBuildingStorey"), std::string::npos);
  EXPECT_NE(changed("IFCPROJECT(", "IFCPOST(").find("has no IfcProject"), std::string::npos);
  EXPECT_NE(changed("#28=IFCLOCALPLACEMENT($,", "#28=IFCLOCALPLACEMENT(#35,").find("is a cycle"), std::string::npos);
  EXPECT_NE(changed("#28=IFCLOCALPLACEMENT($,#27", "#28=IFCLOCALPLACEMENT($,#9999")
                .find("refers to #9999, which is not in the file"),
            std::string::npos);
  EXPECT_NE(changed("((0.,1.,0.))", "((0.,0.,0.))").find("a direction with a length"), std::string::npos);
  EXPECT_NE(changed("'Level 1',$,$,#35", "'Level 1',$,$,5.")
                .find("t.ifc:36:1: #37 IFCBUILDINGSTOREY: found a real as ObjectPlacement, expected a reference"),
            std::string::npos)
      << changed("'Level 1',$,$,#35", "'Level 1',$,$,5.");
  EXPECT_NE(changed("('IFC4')", "('AP214')").find("expected IFC2X3, IFC4 or IFC4X3"), std::string::npos);
}

TEST(Damage, OneElementThatCannotBePlacedCostsOnlyItself) {
  std::string bytes = small_building("IFC4");
  bytes.replace(bytes.find("'F1-C2'"), 7, "#5");
  bytes.replace(bytes.find("#122=IFCLOCALPLACEMENT(#34,#121"), 31, "#122=IFCLOCALPLACEMENT(#34,#999");
  const Design design = read(bytes);
  EXPECT_EQ(design.elements.size(), 4u);
  ASSERT_EQ(design.skipped.size(), 2u);
  EXPECT_NE(design.skipped[1].find("IfcMechanicalFastener 'F2-C1' (#123)"), std::string::npos) << design.skipped[1];
  EXPECT_NE(design.skipped[1].find("refers to #999, which is not in the file"), std::string::npos) << design.skipped[1];
  EXPECT_NE(design.warnings.back().find("2 elements cannot be placed and were left out"), std::string::npos);
}

TEST(Damage, AnElementCutShortIsNotPutAtTheOrigin) {
  const Design design = read(small_building("IFC4", "#500=IFCMECHANICALFASTENER('0evctVUKr0kugbFTf53O9L',$,'CUT');"));
  for (const Element& element : design.elements) EXPECT_NE(element.name, "CUT");
  ASSERT_EQ(design.skipped.size(), 1u);
  EXPECT_NE(design.skipped[0].find("IfcMechanicalFastener 'CUT' (#500)"), std::string::npos) << design.skipped[0];
  EXPECT_NE(design.skipped[0].find("found 3 arguments, expected at least 7"), std::string::npos) << design.skipped[0];
}

/// `levels` shape maps, each of which shows the one before it twice; the last has a bolt.
std::string nested_maps(int levels) {
  std::string out;
  for (int i = 0; i < levels; ++i) {
    const std::string own = std::to_string(1000 + 4 * i), map = std::to_string(1001 + 4 * i),
                      item = std::to_string(1002 + 4 * i);
    const std::string items =
        i == 0 ? "#53" : "#" + std::to_string(1002 + 4 * (i - 1)) + ",#" + std::to_string(1002 + 4 * (i - 1));
    out += "#" + own + "=IFCSHAPEREPRESENTATION(#22,'Body','MappedRepresentation',(" + items + "));\n";
    out += "#" + map + "=IFCREPRESENTATIONMAP(#21,#" + own + ");\n";
    out += "#" + item + "=IFCMAPPEDITEM(#" + map + ",#990);\n";
  }
  return out + "#990=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#20,1.,$);";
}

TEST(Damage, AnAnchorWithNeitherPlacementNorShapeIsNowhere) {
  const std::string unplaced = "#500=IFCMECHANICALFASTENER('0aaaaaaaaaaaaaaaaaaaaa',#5,'LOST',$,$,$,$,$,$,$,$);";
  const Design design = read(test::small_building("IFC4", unplaced));
  ASSERT_EQ(design.skipped.size(), 1u);
  EXPECT_NE(design.skipped[0].find("'LOST' (#500): it has neither a placement nor a shape"), std::string::npos);
  EXPECT_TRUE(std::none_of(design.elements.begin(), design.elements.end(),
                           [](const Element& element) { return element.name == "LOST"; }));
  // An assembly without both is nowhere either, but its parts are somewhere, and nothing is judged by it.
  const std::string assembly = "#500=IFCELEMENTASSEMBLY('0aaaaaaaaaaaaaaaaaaaaa',#5,'WHOLE',$,$,$,$,$,$,$);";
  EXPECT_TRUE(read(test::small_building("IFC4", assembly)).skipped.empty());
}

TEST(HostileShapes, NestedMappedItemsStopAtTheirBudget) {
  std::string extra = nested_maps(40) + "#520=IFCMAPPEDITEM(#" + std::to_string(1001 + 4 * 39) + ",#990);";
  const Design design = read(with_anchor(extra));
  EXPECT_FALSE(named(design, "Odd").has_box);
  EXPECT_NE(design.warnings.at(0).find("repeats nested items"), std::string::npos) << design.warnings.at(0);
  EXPECT_TRUE(named(design, "Panel 1").has_box);  // the others keep their shapes
}

TEST(HostileShapes, DoubledBooleansAndProfilesStopAtTheirBudget) {
  std::string unions = "#1000=IFCBOOLEANRESULT(.UNION.,#53,#53);",
              profiles = "#2000=IFCCOMPOSITEPROFILEDEF(.AREA.,$,(#50,#50),$);";
  for (int i = 1; i < 60; ++i) {
    unions += "#" + std::to_string(1000 + i) + "=IFCBOOLEANRESULT(.UNION.,#" + std::to_string(999 + i) + ",#" +
              std::to_string(999 + i) + ");";
    profiles += "#" + std::to_string(2000 + i) + "=IFCCOMPOSITEPROFILEDEF(.AREA.,$,(#" + std::to_string(1999 + i) +
                ",#" + std::to_string(1999 + i) + "),$);";
  }
  EXPECT_FALSE(named(read(with_anchor(unions, "#1059")), "Odd").has_box);
  EXPECT_FALSE(named(read(with_anchor(profiles + "#520=IFCEXTRUDEDAREASOLID(#2059,$,#24,100.);")), "Odd").has_box);
}

TEST(Damage, EveryChangedByteIsReadOrNamed) {
  // Not random: each byte in turn becomes a character that means something.
  const std::string whole = small_building("IFC4");
  int accepted = 0, refused = 0;
  for (std::size_t at = whole.find("DATA;"); at < whole.size(); ++at) {
    std::string damaged = whole;
    damaged[at] = "$#(9'.,"[at % 7];
    (said_of(damaged) == "no error" ? accepted : refused)++;
  }
  EXPECT_GT(accepted, 100);
  EXPECT_GT(refused, 100);
}

}  // namespace test_design_damage
}  // namespace plumbline::ifc

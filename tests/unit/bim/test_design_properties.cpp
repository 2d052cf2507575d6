// What a design says of its anchors in property sets: units, bounds, whose property goes first.
#include <cmath>
#include <map>

#include "building/ifc/design.hpp"
#include "design_reading.hpp"
#include "small_building.hpp"
#include "test_support.hpp"

namespace plumbline::ifc {
namespace test_design_properties {

using test::small_building;

TEST(Properties, OfAnchorsAndTheirTypesAreRead) {
  const Design design =
      read(small_building("IFC4",
                          "#500=IFCPROPERTYSET('0evctVUKr0kugbFTf53O9L',#5,'Pset_Tolerance',$,(#501,#502));"
                          "#501=IFCPROPERTYSINGLEVALUE('VerticalTolerance',$,IFCPOSITIVELENGTHMEASURE(3.),$);"
                          "#502=IFCPROPERTYSINGLEVALUE('Mark',$,IFCLABEL('M7'),$);"
                          "#503=IFCRELDEFINESBYPROPERTIES('1evctVUKr0kugbFTf53O9L',#5,$,$,(#103),#500);"));
  const Element& anchor = named(design, "F1-C1");
  ASSERT_EQ(anchor.properties.size(), 2u);
  EXPECT_NEAR(anchor.properties[0].number, 0.003, 1e-15);  // the file is in millimetres
  EXPECT_EQ(anchor.properties[1].text, "M7");
  AnchorRule rule;
  rule.selections = {"Pset_Tolerance.Mark=M7"}, rule.classes.clear();
  const Design selected = read(small_building("IFC4"), rule);
  EXPECT_FALSE(named(selected, "F1-C1").is_anchor);
}

/// What the anchor F1-C1 (#103) has of Pset_Tolerance, by name. The file is in millimetres.
std::map<std::string, Property> tolerances_in(const std::string& extra) {
  std::map<std::string, Property> found;
  const Design design = read(small_building("IFC4", extra));
  for (const Property& property : named(design, "F1-C1").properties)
    EXPECT_TRUE(found.emplace(property.name, property).second) << property.name << " stands twice";
  return found;
}

const std::string kSetOfAnchor =
    "#500=IFCPROPERTYSET('0evctVUKr0kugbFTf53O9L',#5,'Pset_Tolerance',$,(#501));"
    "#503=IFCRELDEFINESBYPROPERTIES('1evctVUKr0kugbFTf53O9L',#5,$,$,(#103),#500);";

TEST(Properties, AUnitOfTheirOwnGoesBeforeThatOfTheProject) {
  const std::string centimetre = "#510=IFCSIUNIT(*,.LENGTHUNIT.,.CENTI.,.METRE.);";
  auto found = tolerances_in(centimetre + kSetOfAnchor +
                             "#501=IFCPROPERTYSINGLEVALUE('VerticalTolerance',$,IFCPOSITIVELENGTHMEASURE(0.3),#510);");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_NEAR(found.at("VerticalTolerance").number, 0.003, 1e-15);
  found = tolerances_in(centimetre + kSetOfAnchor +
                        "#501=IFCPROPERTYBOUNDEDVALUE('OrthogonalTolerance',$,IFCLENGTHMEASURE(0.5),IFCLENGTHMEASURE("
                        "-0.2),#510,$);");
  EXPECT_NEAR(found.at("OrthogonalTolerance").upper, 0.005, 1e-15);
  EXPECT_NEAR(found.at("OrthogonalTolerance").lower, -0.002, 1e-15);
  // The unit of one property is not that of the next.
  found = tolerances_in(centimetre +
                        "#500=IFCPROPERTYSET('0evctVUKr0kugbFTf53O9L',#5,'Pset_Tolerance',$,(#501,#502));"
                        "#503=IFCRELDEFINESBYPROPERTIES('1evctVUKr0kugbFTf53O9L',#5,$,$,(#103),#500);"
                        "#501=IFCPROPERTYSINGLEVALUE('VerticalTolerance',$,IFCPOSITIVELENGTHMEASURE(0.3),#510);"
                        "#502=IFCPROPERTYSINGLEVALUE('HorizontalTolerance',$,IFCPOSITIVELENGTHMEASURE(3.),$);");
  EXPECT_NEAR(found.at("HorizontalTolerance").number, 0.003, 1e-15);
}

TEST(Properties, BoundsWithoutAUnitAreNoLengths) {
  const auto found = tolerances_in(
      kSetOfAnchor + "#501=IFCPROPERTYBOUNDEDVALUE('OrthogonalTolerance',$,IFCREAL(5.),IFCREAL(-2.),$,$);");
  const Property& bounded = found.at("OrthogonalTolerance");
  EXPECT_EQ(bounded.measure, "IFCPROPERTYBOUNDEDVALUE");
  EXPECT_TRUE(std::isnan(bounded.upper) && std::isnan(bounded.lower)) << bounded.lower << " to " << bounded.upper;
  EXPECT_EQ(bounded.text, "-2 to 5") << "what was found is said";
}

TEST(Properties, AValueOfNothingIsNone) {
  for (const char* nothing : {"IFCPOSITIVELENGTHMEASURE()", "()", "$"})
    EXPECT_TRUE(
        tolerances_in(kSetOfAnchor + "#501=IFCPROPERTYSINGLEVALUE('VerticalTolerance',$," + nothing + ",$);").empty())
        << nothing;
}

TEST(Properties, WhatIsNoSingleValueIsKeptByItsKind) {
  const auto found = tolerances_in(kSetOfAnchor +
                                   "#501=IFCCOMPLEXPROPERTY('OrthogonalTolerance',$,'limits',(#502));"
                                   "#502=IFCPROPERTYSINGLEVALUE('Upper',$,IFCPOSITIVELENGTHMEASURE(5.),$);");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.at("OrthogonalTolerance").measure, "IFCCOMPLEXPROPERTY");
  EXPECT_TRUE(std::isnan(found.at("OrthogonalTolerance").number));
}

/// Tolerances of what holds the anchor F1-C1: of a group, of its storey, of quantities; and two sets that differ.
TEST(Properties, TolerancesOfWhatHoldsAnAnchorGoWithIt) {
  const auto properties = [](const std::string& extra) {
    return named(read(small_building("IFC4", extra)), "F1-C1").properties;
  };
  const std::string one = "#501=IFCPROPERTYSINGLEVALUE('VerticalTolerance',$,IFCPOSITIVELENGTHMEASURE(1.),$);",
                    set = "#500=IFCPROPERTYSET('0evctVUKr0kugbFTf53O9L',#5,'Pset_Tolerance',$,(#501));" + one;
  const auto in_group = properties(set +
                                   "#510=IFCGROUP('3evctVUKr0kugbFTf53O9L',#5,'tight',$,$);"
                                   "#511=IFCRELASSIGNSTOGROUP('2evctVUKr0kugbFTf53O9L',#5,$,$,(#103),$,#510);"
                                   "#503=IFCRELDEFINESBYPROPERTIES('1evctVUKr0kugbFTf53O9L',#5,$,$,(#510),#500);");
  ASSERT_EQ(in_group.size(), 1u);
  EXPECT_EQ(in_group[0].holder, "IfcGroup 'tight'");
  EXPECT_NEAR(in_group[0].number, 0.001, 1e-15);
  const auto in_assembly = properties(set +
                                      "#510=IFCELEMENTASSEMBLY('3evctVUKr0kugbFTf53O9L',#5,'A1',$,$,$,$,$,$,$);"
                                      "#511=IFCRELAGGREGATES('2evctVUKr0kugbFTf53O9L',#5,$,$,#510,(#103));"
                                      "#503=IFCRELDEFINESBYPROPERTIES('1evctVUKr0kugbFTf53O9L',#5,$,$,(#510),#500);");
  ASSERT_EQ(in_assembly.size(), 1u);
  EXPECT_EQ(in_assembly[0].holder, "IfcElementAssembly 'A1'");
  const auto quantities = properties(
      "#500=IFCELEMENTQUANTITY('0evctVUKr0kugbFTf53O9L',#5,'Pset_Tolerance',$,$,(#501));"
      "#501=IFCQUANTITYLENGTH('VerticalTolerance',$,$,1.,$);"
      "#503=IFCRELDEFINESBYPROPERTIES('1evctVUKr0kugbFTf53O9L',#5,$,$,(#103),#500);");
  ASSERT_EQ(quantities.size(), 1u);
  EXPECT_EQ(quantities[0].measure, "IFCQUANTITYLENGTH");
  const std::string second =
      "#520=IFCPROPERTYSET('4evctVUKr0kugbFTf53O9L',#5,'Pset_Tolerance',$,(#521));"
      "#522=IFCRELDEFINESBYPROPERTIES('5evctVUKr0kugbFTf53O9L',#5,$,$,(#103),#520);"
      "#521=IFCPROPERTYSINGLEVALUE('VerticalTolerance',$,IFCPOSITIVELENGTHMEASURE(";
  const std::string first = set + "#503=IFCRELDEFINESBYPROPERTIES('1evctVUKr0kugbFTf53O9L',#5,$,$,(#103),#500);";
  EXPECT_EQ(properties(first + second + "1.),$);").size(), 1u) << "twice the same is once";
  EXPECT_EQ(properties(first + second + "3.),$);").size(), 2u) << "the judgement says that they differ";
  const auto about = tolerances_in(kSetOfAnchor +
                                   "#501=IFCPROPERTYBOUNDEDVALUE('VerticalTolerance',$,IFCLENGTHMEASURE(10.),"
                                   "IFCLENGTHMEASURE(-4.),$,IFCLENGTHMEASURE(3.));");
  EXPECT_EQ(about.at("VerticalTolerance").measure, "IFCPROPERTYBOUNDEDVALUE with a set point");
  EXPECT_EQ(about.at("VerticalTolerance").text, "-4 to 10 about 3");
}

TEST(Properties, ASetOfSetsIsRead) {
  const auto found = tolerances_in(
      "#500=IFCPROPERTYSET('0evctVUKr0kugbFTf53O9L',#5,'Pset_Tolerance',$,(#501));"
      "#501=IFCPROPERTYSINGLEVALUE('VerticalTolerance',$,IFCPOSITIVELENGTHMEASURE(3.),$);"
      "#504=IFCPROPERTYSET('2evctVUKr0kugbFTf53O9L',#5,'Pset_Tolerance',$,(#505));"
      "#505=IFCPROPERTYSINGLEVALUE('HorizontalTolerance',$,IFCPOSITIVELENGTHMEASURE(4.),$);"
      "#503=IFCRELDEFINESBYPROPERTIES('1evctVUKr0kugbFTf53O9L',#5,$,$,(#103"
      "),IFCPROPERTYSETDEFINITIONSET((#500,#504)));");
  ASSERT_EQ(found.size(), 2u);
  EXPECT_NEAR(found.at("HorizontalTolerance").number, 0.004, 1e-15);
}

/// However the name of the set is written, what the object has goes before what its type has.
TEST(Properties, OfTheObjectGoBeforeThoseOfItsType) {
  for (const char* of_type : {"Pset_Tolerance", "Pset_tolerance", "PSET_TOLERANCE"}) {
    const auto found = tolerances_in(
        kSetOfAnchor + "#501=IFCPROPERTYSINGLEVALUE('VerticalTolerance',$,IFCPOSITIVELENGTHMEASURE(3.),$);" +
        "#504=IFCPROPERTYSET('2evctVUKr0kugbFTf53O9L',#5,'" + of_type + "',$,(#505,#506));" +
        "#505=IFCPROPERTYSINGLEVALUE('VerticalTolerance',$,IFCPOSITIVELENGTHMEASURE(8.),$);"
        "#506=IFCPROPERTYSINGLEVALUE('HorizontalTolerance',$,IFCPOSITIVELENGTHMEASURE(8.),$);"
        "#507=IFCMECHANICALFASTENERTYPE('3evctVUKr0kugbFTf53O9L',#5,'T',$,$,(#504),$,$,$,.ANCHORBOLT.,$,$);"
        "#508=IFCRELDEFINESBYTYPE('0fvctVUKr0kugbFTf53O9L',#5,$,$,(#103),#507);");
    ASSERT_EQ(found.size(), 2u) << of_type;
    EXPECT_NEAR(found.at("VerticalTolerance").number, 0.003, 1e-15) << of_type;
    EXPECT_NEAR(found.at("HorizontalTolerance").number, 0.008, 1e-15) << "of the type alone";
  }
}

}  // namespace test_design_properties
}  // namespace plumbline::ifc

// bim.check: each rule on a file that breaks it, and on nothing else.
#include <gtest/gtest.h>

#include "building/ifc/check.hpp"
#include "small_building.hpp"

namespace plumbline::ifc {
namespace test_check {

std::string rules_broken(const std::string& extra, std::uint64_t first = 500) {
  std::string text;
  for (const Violation& violation : check_ifc(step::File(test::small_building("IFC4", extra), "t.ifc"), first))
    text += violation.rule + "\n";
  return text;
}

TEST(CheckIfc, ASoundFileBreaksNothing) { EXPECT_EQ(rules_broken("", 0), ""); }

TEST(CheckIfc, EveryRuleIsFoundBroken) {
  const std::string set =
      "#500=IFCPROPERTYSET('0evctVUKr0kugbFTf53O9L',#5,'S',$,(#501));#501=IFCPROPERTYSINGLEVALUE('P',$,$,$);";
  const std::pair<const char*, std::string> cases[] = {
      {"PJS001 one project", "#500=IFCPROJECT('0evctVUKr0kugbFTf53O9L',#5,'Two',$,$,$,$,(#22),#13);"},
      {"IfcPropertyEnumeration.UR1",
       "#500=IFCPROPERTYENUMERATION('E',(IFCLABEL('A')),$);#501=IFCPROPERTYENUMERATION('E',(IFCLABEL('A')),$);"},
      {"references", "#500=IFCGROUP('0evctVUKr0kugbFTf53O9L',#999,'G',$,$);"},
      {"PJS003 GlobalId", "#500=IFCGROUP('9evctVUKr0kugbFTf53O9L',#5,'G',$,$);"},
      {"IfcRoot.UR1", "#500=IFCGROUP('0YvctVUKr0kugbFTf53O9L',#5,'G',$,$);"},
      {"UniquePropertySetNames", set + "#502=IFCPROPERTYSET('1evctVUKr0kugbFTf53O9L',#5,'S',$,(#501));"
                                       "#503=IFCRELDEFINESBYPROPERTIES('2evctVUKr0kugbFTf53O9L',#5,$,$,(#103),#500);"
                                       "#504=IFCRELDEFINESBYPROPERTIES('3evctVUKr0kugbFTf53O9L',#5,$,$,(#103),#502);"},
      {"IfcRelDefines.RelatedObjects",
       set + "#503=IFCRELDEFINESBYPROPERTIES('2evctVUKr0kugbFTf53O9L',#5,$,$,(),#500);"},
      {"IfcPropertySet.ExistsName",
       "#500=IFCPROPERTYSET('0evctVUKr0kugbFTf53O9L',#5,$,$,(#501));#501=IFCPROPERTYSINGLEVALUE('P',$,$,$);"},
      {"PSE001 reserved names",
       "#500=IFCPROPERTYSET('0evctVUKr0kugbFTf53O9L',#5,'Pset_ASB',$,(#501));#501=IFCPROPERTYSINGLEVALUE('P',$,$,$);"},
      {"UniquePropertyNames",
       "#500=IFCPROPERTYSET('0evctVUKr0kugbFTf53O9L',#5,'S',$,(#501,#502));#501=IFCPROPERTYSINGLEVALUE('P',$,$,$);#502="
       "IFCPROPERTYSINGLEVALUE('P',$,$,$);"},
      {"IfcPropertyListValue.WR31", "#500=IFCPROPERTYLISTVALUE('L',$,(IFCLABEL('A'),IFCREAL(1.)),$);"},
      {"IfcPropertyEnumeratedValue.WR21",
       "#500=IFCPROPERTYENUMERATION('E',(IFCLABEL('A')),$);#501=IFCPROPERTYENUMERATEDVALUE('V',$,(IFCLABEL('B')),#500)"
       ";"},
      {"IfcPropertyTableValue.WR21",
       "#500=IFCPROPERTYTABLEVALUE('T',$,(IFCREAL(1.)),(IFCREAL(1.),IFCREAL(2.)),$,$,$,$);"},
      {"IfcPropertyBoundedValue", "#500=IFCPROPERTYBOUNDEDVALUE('B',$,IFCREAL(1.),IFCREAL(2.),$,$);"},
      {"IfcOwnerHistory.CorrectChangeAction", "#500=IFCOWNERHISTORY(#3,#4,$,.ADDED.,$,$,$,1700000000);"},
      {"IfcPerson.IdentifiablePerson", "#500=IFCPERSON($,$,$,$,$,$,$,$);"},
      {"SPS001 containment", "#500=IFCRELCONTAINEDINSPATIALSTRUCTURE('0evctVUKr0kugbFTf53O9L',#5,$,$,(#228),#103);"},
      {"IfcElement.ContainedInStructure",
       "#500=IFCRELCONTAINEDINSPATIALSTRUCTURE('0evctVUKr0kugbFTf53O9L',#5,$,$,(#103),#36);"},
      {"SPS007 parts are not contained", "#500=IFCRELAGGREGATES('0evctVUKr0kugbFTf53O9L',#5,$,$,#220,(#103));"},
      {"SPS002 products are contained", "#500=IFCANNOTATION('0evctVUKr0kugbFTf53O9L',#5,'A',$,$,$,$);"},
      {"OJP001 relative placement",
       "#500=IFCANNOTATION('0evctVUKr0kugbFTf53O9L',#5,'A',$,$,#501,$);#501=IFCLOCALPLACEMENT(#28,#21);"
       "#502=IFCRELCONTAINEDINSPATIALSTRUCTURE('1evctVUKr0kugbFTf53O9L',#5,$,$,(#500),#36);"},
      {"IfcLocalPlacement", "#500=IFCLOCALPLACEMENT(#501,#21);#501=IFCLOCALPLACEMENT(#500,#21);"},
      {"IfcDirection.MagnitudeGreaterZero", "#500=IFCDIRECTION((0.,0.,0.));"},
      {"IfcAxis2Placement3D.AxisAndRefDirProvision", "#500=IFCAXIS2PLACEMENT3D(#20,#24,$);"},
      {"IfcShapeRepresentation.CorrectItemsForType", "#500=IFCSHAPEREPRESENTATION(#22,'Body','SweptSolid',(#20));"},
      {"IfcPositiveLengthMeasure.WR1", "#500=IFCEXTRUDEDAREASOLID(#50,#52,#24,0.);"},
      {"IfcRepresentationItem.StyledByItem", "#500=IFCSTYLEDITEM(#53,(),$);#501=IFCSTYLEDITEM(#53,(),$);"},
      {"IfcRelAssigns.NoSelfReference",
       "#500=IFCGROUP('0evctVUKr0kugbFTf53O9L',#5,'G',$,$);#501=IFCRELASSIGNSTOGROUP('1evctVUKr0kugbFTf53O9L',#5,$,$,(#"
       "500),$,#500);"},
      {"Part 21 syntax", "#500=IFCDIRECTION((0.,0.,@));"},
  };
  for (const auto& [rule, extra] : cases)
    EXPECT_NE(("\n" + rules_broken(extra)).find(std::string("\n") + rule + "\n"), std::string::npos)
        << rule << " not in:\n"
        << rules_broken(extra);
}

/// A rule that always fires finds the broken file as well.
TEST(CheckIfc, SoundTwinsOfTheBrokenPropertiesBreakNothing) {
  for (const std::string sound :
       {"#500=IFCPROPERTYENUMERATION('E',(IFCLABEL('A'),IFCLABEL('B')),$);"
        "#501=IFCPROPERTYENUMERATEDVALUE('V',$,(IFCLABEL('B')),#500);",
        "#500=IFCPROPERTYENUMERATION('E',(IFCLABEL('A'),IFCLABEL('B'),IFCLABEL('C')),$);"
        "#501=IFCPROPERTYENUMERATEDVALUE('V',$,(IFCLABEL('C'),IFCLABEL('A')),#500);",
        "#500=IFCPROPERTYLISTVALUE('L',$,(IFCLABEL('A'),IFCLABEL('B')),$);",
        "#500=IFCPROPERTYTABLEVALUE('T',$,(IFCREAL(1.),IFCREAL(2.)),(IFCREAL(1.),IFCREAL(2.)),$,$,$,$);",
        "#500=IFCPROPERTYBOUNDEDVALUE('B',$,IFCREAL(2.),IFCREAL(1.),$,$);"})
    EXPECT_EQ(rules_broken(sound), "") << sound;
  // One of two values outside of the enumeration is one violation.
  EXPECT_EQ(rules_broken("#500=IFCPROPERTYENUMERATION('E',(IFCLABEL('A'),IFCLABEL('B')),$);"
                         "#501=IFCPROPERTYENUMERATEDVALUE('V',$,(IFCLABEL('B'),IFCLABEL('X')),#500);"),
            "IfcPropertyEnumeratedValue.WR21\n");
}

TEST(CheckIfc, WhatWasThereBeforeIsNotOurs) {
  EXPECT_EQ(rules_broken("#500=IFCDIRECTION((0.,0.,0.));", 501), "");
  const std::string twice =
      "#500=IFCAPPLICATION(#2,'1','A','TWICE');#501=IFCAPPLICATION(#2,'1','B','TWICE');"
      "#502=IFCGROUP('0evctVUKr0kugbFTf53O9L',#5,'G',$,$);#503=IFCGROUP('0evctVUKr0kugbFTf53O9L',#5,'H',$,$);";
  EXPECT_EQ(rules_broken(twice, 504), "");
  // An addition that repeats what the design has is one of ours.
  EXPECT_EQ(rules_broken(twice, 503), "IfcRoot.UR1\n");
  EXPECT_EQ(rules_broken(twice, 501), "IfcApplication.UR1\nIfcRoot.UR1\n");
}

}  // namespace test_check
}  // namespace plumbline::ifc

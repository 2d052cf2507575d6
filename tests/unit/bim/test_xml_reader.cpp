// ifcXML turned into STEP: both arrangements worked out by hand, mistakes named with line and element, and files of
// others, one of which exists as STEP too.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <map>
#include <set>

#include "building/step/step.hpp"
#include "building/step/xml_reader.hpp"
#include "building/step/zip_writer.hpp"
#include "express_schema.hpp"
#include "test_support.hpp"

namespace plumbline::step {
namespace test_xml_reader {

std::string ifc4(const std::string& content) {
  return "<?xml version=\"1.0\"?>\n<ifcXML xmlns=\"http://www.buildingsmart-tech.org/ifcXML/IFC4/Add2\" "
         "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\n" +
         content + "</ifcXML>\n";
}

std::string ifc2x3(const std::string& content) {
  return "<ex:iso_10303_28 xmlns:ex=\"urn:iso.org:standard:10303:part(28):version(2):xmlschema:common\" "
         "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\">\n<ex:iso_10303_28_header><ex:name>N</ex:name>"
         "</ex:iso_10303_28_header>\n<uos xmlns=\"http://www.iai-tech.org/ifcXML/IFC2x3/FINAL\">\n" +
         content + "</uos></ex:iso_10303_28>\n";
}

/// The instances of the STEP file, without its header.
std::string data_of(const std::string& xml) {
  const std::string text = step_of_xml(xml, "t.ifcxml").text;
  const std::size_t begin = text.find("DATA;\n") + 6;
  return text.substr(begin, text.rfind("ENDSEC;") - begin);
}

std::string message_of(const std::string& xml) {
  try {
    step_of_xml(xml, "t.ifcxml");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(XmlReader, TheArrangementOfIfc4) {
  EXPECT_EQ(data_of(ifc4("<IfcProject id='p' GlobalId='0abc' Name='Stra&#223;e &amp; Co'>\n"
                         "<UnitsInContext><Units><IfcSIUnit UnitType='lengthunit' Prefix='milli' Name='metre'/>"
                         "</Units></UnitsInContext>\n"
                         "<IsDecomposedBy><IfcRelAggregates><RelatedObjects><IfcSite id='s' RefLatitude='47 22 30'>"
                         "<ObjectPlacement xsi:type='IfcLocalPlacement'><RelativePlacement><IfcAxis2Placement3D>"
                         "<Location Coordinates='1 -2.5 3e2'/></IfcAxis2Placement3D></RelativePlacement>"
                         "</ObjectPlacement></IfcSite></RelatedObjects></IfcRelAggregates></IsDecomposedBy>\n"
                         "</IfcProject>\n"
                         "<IfcRelDefinesByProperties><RelatedObjects><IfcSite ref='s' xsi:nil='true'/></RelatedObjects>"
                         "<RelatingPropertyDefinition><IfcPropertySet Name='A'><HasProperties>"
                         "<IfcPropertySingleValue Name='L'><NominalValue><IfcLengthMeasure-wrapper>5"
                         "</IfcLengthMeasure-wrapper></NominalValue></IfcPropertySingleValue></HasProperties>"
                         "</IfcPropertySet></RelatingPropertyDefinition></IfcRelDefinesByProperties>\n"
                         "<IfcCartesianPointList3D CoordList='0 0 0 1 0 0.5'/>\n")),
            "#1=IFCPROJECT('0abc',$,'Stra\\X2\\00DF\\X0\\e & Co',$,$,$,$,$,#2);\n"
            "#2=IFCUNITASSIGNMENT((#3));\n"
            "#3=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);\n"
            "#4=IFCRELAGGREGATES($,$,$,$,#1,(#5));\n"
            "#5=IFCSITE($,$,$,$,$,#6,$,$,$,(47,22,30),$,$,$,$);\n"
            "#6=IFCLOCALPLACEMENT($,#7);\n"
            "#7=IFCAXIS2PLACEMENT3D(#8,$,$);\n"
            "#8=IFCCARTESIANPOINT((1.,-2.5,3.E2));\n"
            "#9=IFCRELDEFINESBYPROPERTIES($,$,$,$,(#5),#10);\n"
            "#10=IFCPROPERTYSET($,$,'A',$,(#11));\n"
            "#11=IFCPROPERTYSINGLEVALUE('L',$,IFCLENGTHMEASURE(5.),$);\n"
            "#12=IFCCARTESIANPOINTLIST3D(((0.,0.,0.),(1.,0.,0.5)));\n");
}

TEST(XmlReader, TheArrangementOfIfc2x3) {
  EXPECT_EQ(
      data_of(ifc2x3("<IfcDirection id='i2'><DirectionRatios ex:cType='list'><ex:double-wrapper pos='1'>1"
                     "</ex:double-wrapper><ex:double-wrapper pos='0'>0.</ex:double-wrapper></DirectionRatios>"
                     "</IfcDirection>\n"
                     "<IfcAxis2Placement2D id='i3'><Location><IfcCartesianPoint ref='i9' xsi:nil='true'/></Location>"
                     "<RefDirection><IfcDirection ref='i2' xsi:nil='true'/></RefDirection></IfcAxis2Placement2D>\n"
                     "<IfcCartesianPoint id='i9'><Coordinates ex:cType='list'><IfcLengthMeasure pos='0'>1.5"
                     "</IfcLengthMeasure><IfcLengthMeasure pos='1'>0.</IfcLengthMeasure></Coordinates>"
                     "</IfcCartesianPoint>\n"
                     "<IfcPropertySingleValue id='i4'><Name>On</Name><NominalValue><ifcboolean-wrapper>true"
                     "</ifcboolean-wrapper></NominalValue></IfcPropertySingleValue>\n"
                     "<IfcSite id='i5'><GlobalId>1x</GlobalId><CompositionType>element</CompositionType>"
                     "<RefElevation>NAN(SNAN)</RefElevation></IfcSite>\n")),
      "#1=IFCDIRECTION((0.,1.));\n"
      "#2=IFCAXIS2PLACEMENT2D(#3,#1);\n"
      "#3=IFCCARTESIANPOINT((1.5,0.));\n"
      "#4=IFCPROPERTYSINGLEVALUE('On',$,IFCBOOLEAN(.T.),$);\n"
      "#5=IFCSITE('1x',$,$,$,$,$,$,$,.ELEMENT.,$,$,$,$,$);\n");
}

TEST(XmlReader, ACommentOrCdataPartsNoValue) {
  const auto length = [](const std::string& value) {
    return data_of(ifc4("<IfcPropertySingleValue Name='L'><NominalValue><IfcLengthMeasure-wrapper>" + value +
                        "</IfcLengthMeasure-wrapper></NominalValue></IfcPropertySingleValue>"));
  };
  EXPECT_EQ(length("12<!-- c -->34"), length("1234"));
  EXPECT_EQ(length("<![CDATA[12]]>34"), length("1234"));
  EXPECT_NE(length("12"), length("1234"));
}

TEST(XmlReader, NamesLineAndElementOfAMistake) {
  const auto expect = [](const std::string& xml, const std::string& said) {
    EXPECT_NE(message_of(xml).find(said), std::string::npos) << message_of(xml) << "\nlacks " << said;
  };
  expect(ifc4("<IfcWall id='w'\n Colour='red'/>"),
         "t.ifcxml:3:2: IfcWall 'w': found 'Colour', which IfcWall of IFC4 does not have, expected one of GlobalId");
  expect(ifc4("<IfcProject/>\n<IfcFoo/>"), "t.ifcxml:4:2: IfcFoo: found this element, expected an entity of IFC4");
  expect(ifc4("<IfcRelAggregates><RelatingObject ref='x' xsi:nil='true'/></IfcRelAggregates>"),
         "t.ifcxml:3:20: RelatingObject: found a reference to 'x'");
  expect(ifc4("<IfcSite id='a'/><IfcSite id='a'/>"), "IfcSite 'a': found its id a second time, first at t.ifcxml:3:2");
  expect(ifc4("<IfcSite RefElevation='high'/>"), "found 'high' as RefElevation, expected a number");
  expect(ifc4("<IfcSite RefElevation='1,5'/>"), "expected a number");
  expect(ifc4("<IfcCartesianPointList3D CoordList='0 0 0 1'/>"), "as many as lists of that kind have");
  expect(ifc4("<IfcRelAggregates><RelatingObject Name='x'/></IfcRelAggregates>"),
         "IfcObjectDefinition is abstract, expected xsi:type");
  expect(ifc4("<IfcPropertySingleValue><NominalValue>5</NominalValue></IfcPropertySingleValue>"),
         "NominalValue: found '5' without its type");
  expect(ifc4("<IfcRelAggregates><RelatingObject xsi:type='IfcSitte' id='s'/></IfcRelAggregates>"),
         "RelatingObject 's': found xsi:type='IfcSitte', expected an entity or a type of IFC4");
  expect(ifc4("<IfcWall xsi:type='IfcHouse'/>"), "IfcWall: found xsi:type='IfcHouse'");
  expect(ifc4("<IfcCartesianPoint Coordinates='0 NaN 1'/>"), "found '0 NaN 1' as Coordinates");
  expect(ifc4("<IfcSite RefElevation='nanometre'/>"), "found 'nanometre' as RefElevation, expected a number");
  const auto points = [](const std::string& list) {
    return ifc4("<IfcCartesianPointList3D><CoordList>" + list + "</CoordList></IfcCartesianPointList3D>");
  };
  const std::string value = "<IfcLengthMeasure>1</IfcLengthMeasure>";
  expect(points(value + value + value), "found a single value in CoordList, a list of lists");
  expect(points("<ex:double-wrapper>1</ex:double-wrapper><ex:double-wrapper>2</ex:double-wrapper>"),
         "found a single value in CoordList, a list of lists");
  expect(points("<Seq>1 2</Seq>"), "found '1 2' as CoordList");
  expect(points("<Seq>" + value + value + "</Seq>"), "found 2 items as CoordList, expected 3 of them");
  expect(ifc2x3("<IfcCartesianPoint><Coordinates><IfcLengthMeasure>0</IfcLengthMeasure><IfcLengthMeasure>NAN"
                "</IfcLengthMeasure></Coordinates></IfcCartesianPoint>"),
         "found 'NAN' in the list Coordinates, expected a value for each item");
  expect(ifc4("<IfcPropertyEnumeratedValue><EnumerationValues><Nothing>5</Nothing></EnumerationValues>"
              "</IfcPropertyEnumeratedValue>"),
         "found this element in EnumerationValues, expected an entity or a value of IFC4");
  expect(ifc4("<IfcRelAggregates><RelatedObjects><Nothing>5</Nothing></RelatedObjects></IfcRelAggregates>"),
         "found this element in RelatedObjects, expected an entity or a value of IFC4");
  expect("<html><body/></html>", "html: found this element, expected ifcXML");
  expect("<ifcXML xmlns='http://example.org/IFC2x2'/>", "expected IFC2x3, IFC4 or IFC4x3");
  expect(ifc4("<IfcWall>"), "found XML that is damaged");
  std::string deep;
  for (int i = 0; i < 50000; ++i) deep += "<IfcWall><IsDecomposedBy><IfcRelAggregates><RelatedObjects>";
  expect(ifc4(deep), "damaged");
  for (int i = 0; i < 50000; ++i) deep += "</RelatedObjects></IfcRelAggregates></IsDecomposedBy></IfcWall>";
  expect(ifc4(deep), "found elements nested too deep");
}

TEST(XmlReader, AFileIsReadLikeStepAndSaysWhereItsXmlIs) {
  const File file(ifc4("<IfcProject/>\n<IfcSite/>\n"), "t.ifcxml");
  EXPECT_TRUE(file.was_xml());
  EXPECT_EQ(file.schemas(), std::vector<std::string>{"IFC4"});
  EXPECT_EQ(file.where(file.find(2)->begin), "t.ifcxml:4");
  ZipWriter zip;
  zip.add("a.ifcxml", ifc4("<IfcProject/>\n"));
  EXPECT_EQ(File(zip.finish(), "t.ifczip").instances().size(), 1u);
  // UTF-16, as some exporters write it.
  std::string wide = "\xFF\xFE";
  for (const char c : ifc4("<IfcProject/>\n")) wide += c, wide += '\0';
  EXPECT_EQ(File(wide, "t.ifcxml").instances().size(), 1u);
}

TEST(XmlReader, EveryChangedByteIsReadOrNamed) {
  const std::string sound = ifc4(
      "<IfcProject id='p' Name='N'><UnitsInContext><Units><IfcSIUnit UnitType='lengthunit' Name='metre'/></Units>"
      "</UnitsInContext><IsDecomposedBy><IfcRelAggregates><RelatedObjects><IfcSite id='s' RefLatitude='47 22 30'/>"
      "</RelatedObjects></IfcRelAggregates></IsDecomposedBy></IfcProject><IfcPropertySingleValue Name='L'>"
      "<NominalValue><IfcLengthMeasure-wrapper>5</IfcLengthMeasure-wrapper></NominalValue></IfcPropertySingleValue>");
  int read = 0, named = 0;
  for (std::size_t at = 0; at < sound.size(); at += 2)
    for (const char with : {'<', 'x', '\''}) {
      std::string changed = sound;
      changed[at] = with;
      try {
        read += File(changed, "t.ifcxml").instances().size() > 0;
      } catch (const Error& error) {
        named += std::string(error.what()).starts_with("t.ifcxml");
      }
    }
  EXPECT_GT(read, 100);
  EXPECT_GT(named, 500);
}

/// What an instance says, with what it refers to in its place: the same in any numbering.
std::string meaning_of(const File& file, std::uint64_t id, std::map<std::uint64_t, std::string>& known) {
  if (const auto found = known.find(id); found != known.end()) return found->second;
  const std::function<std::string(const Value&)> of = [&](const Value& value) -> std::string {
    if (value.kind == Kind::reference)
      return std::to_string(std::hash<std::string>{}(meaning_of(file, value.id, known)));
    if (value.is_number()) return std::to_string(std::llround(1e6 * value.number));
    std::string text = std::to_string(static_cast<int>(value.kind)) + value.text + "(";
    std::vector<std::string> items;
    for (const Value& item : value.items) items.push_back(of(item));
    // Sets have no order: those of references may come in any.
    if (!value.items.empty() && value.items[0].kind == Kind::reference) std::sort(items.begin(), items.end());
    for (const std::string& item : items) text += item + ",";
    return text + ")";
  };
  const Instance instance = *file.find(id);
  std::string text = file.type_name(instance) + ":";
  for (const Value& argument : file.arguments(instance)) text += of(argument) + ";";
  return known[id] = text;
}

std::map<std::string, int> meanings_of(const File& file) {
  std::map<std::uint64_t, std::string> known;
  std::map<std::string, int> counts;
  for (const Instance& instance : file.instances()) ++counts[meaning_of(file, instance.id, known)];
  return counts;
}

TEST(XmlReader, SaysWhatTheStepFileOfTheSameModelSays) {
  PLUMBLINE_REQUIRE_DATA("ifc/xml");
  const std::filesystem::path folder = test::data_file("ifc/xml");
  const File xml = File::read((folder / "4walls1floorSite.ifcxml").string()),
             step = File::read((folder / "4walls1floorSite.ifczip").string());
  const auto of_xml = meanings_of(xml), of_step = meanings_of(step);
  int alike = 0, only_xml = 0, only_step = 0;
  std::string first;
  for (const auto& [meaning, count] : of_step) {
    const auto found = of_xml.find(meaning);
    const int same = found == of_xml.end() ? 0 : std::min(count, found->second);
    alike += same, only_step += count - same;
    if (same < count && first.empty()) first = meaning;
  }
  for (const auto& [meaning, count] : of_xml)
    if (const auto found = of_step.find(meaning); found == of_step.end()) only_xml += count;
  EXPECT_EQ(only_step, 0) << first;
  EXPECT_EQ(only_xml, 0);
  EXPECT_GT(alike, 500);
}

TEST(XmlReader, FilesOfOthersAreReadByTheirSchema) {
  PLUMBLINE_REQUIRE_DATA("ifc/xml");
  PLUMBLINE_REQUIRE_DATA("ifc/express");
  const std::filesystem::path folder = test::data_file("ifc/xml"), express = test::data_file("ifc/express");
  const std::map<std::string, std::size_t> files = {
      // with their instances
      {"4walls1floorSite.ifcxml", 579},    {"Dimensions.ifcxml", 21},
      {"IkeaKitchenCabinets.ifcXML", 156}, {"ImplicitPropertyTyping.ifcxml", 39},
      {"InvalidNan.ifcxml", 468},          {"QuantityTest.ifcxml", 7},
      {"IfcDerivedUnit.ifcxml", 7},        {"MyFirstIfcFile.ifcxml", 3456},
      {"HelloWallXml.ifczip", 163},        {"Small.ifcxml", 256}};
  std::map<std::string, test::ExpressSchema> schemas;
  for (const auto& [name, instances] : files) {
    const File file = File::read((folder / name).string());
    EXPECT_EQ(file.instances().size(), instances) << name;
    const std::string schema = file.schemas().at(0);
    if (!schemas.contains(schema)) {
      std::ifstream stream(express / (schema + ".exp"));
      schemas.emplace(schema, std::string(std::istreambuf_iterator<char>(stream), {}));
    }
    // What a file leaves out that the schema requires is its own mistake; everything else would be the reader's.
    for (const Instance& instance : file.instances()) {
      if (instance.index >= 1000) break;
      for (const std::string& what : schemas.at(schema).check(file, instance))
        EXPECT_NE(what.find("$ for a required attribute"), std::string::npos) << name << ": " << what;
    }
  }
  try {
    File::read((folder / "RefWithContent.ifcXML").string());
    ADD_FAILURE() << "it refers to nothing";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("IfcSIUnit: found a reference to 'id02'"), std::string::npos)
        << error.what();
  }
}

}  // namespace test_xml_reader
}  // namespace plumbline::step

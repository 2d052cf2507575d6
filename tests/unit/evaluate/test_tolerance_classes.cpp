// A project's tolerance classes as a table: each row is a rule that names its line, and what is wrong is refused with
// it.
#include <gtest/gtest.h>

#include <filesystem>
#include <stdexcept>

#include "base/text/whole_file.hpp"
#include "building/judgement/tolerance_classes.hpp"
#include "test_support.hpp"

namespace plumbline::judgement {
namespace test_tolerance_classes {

constexpr double mm = 1e-3;

std::string refusal_of(const std::string& csv) {
  try {
    parse_tolerance_classes(csv, "t.csv");
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(ToleranceClasses, EveryRowIsARuleThatNamesItsLine) {
  const std::string csv =
      "# numbers of the contract\n"
      "class,select,vertical_mm,horizontal_mm,out_of_plane_mm,joint_mm,note\n"
      "A,class=IfcMechanicalFastener,3,0,+5/-2,,bolted\n"
      "B,\"class=IfcPlate & storey=Level 2\",,,,4.5,\n";
  const auto rules = parse_tolerance_classes(csv, "tolerances.csv");
  ASSERT_EQ(rules.size(), 2u);
  EXPECT_EQ(
      rules[0].text,
      "tolerances.csv:3, class A: class=IfcMechanicalFastener: horizontal=0mm, vertical=3mm, out_of_plane=+5/-2mm");
  EXPECT_EQ(rules[0].tolerances.at(Axis::vertical).value, 3 * mm);
  EXPECT_EQ(rules[0].tolerances.at(Axis::horizontal).value, 0) << "0: not judged";
  EXPECT_EQ(rules[0].tolerances.at(Axis::out_of_plane).below, 2 * mm);
  EXPECT_EQ(rules[1].tolerances.size(), 1u) << "an empty cell says nothing";
  ifc::ElementFacts element;
  element.ifc_class = "IfcPlate", element.storey = "Level 2";
  const ToleranceTable table{5 * mm, true, rules};
  EXPECT_EQ(tolerances_of(table, element).at(Axis::joint).value, 4.5 * mm);
  EXPECT_TRUE(tolerances_of(table, element).at(Axis::joint).source.starts_with("tolerances.csv:4, class B: "));
  EXPECT_TRUE(parse_tolerance_classes("", "none.csv").empty());
}

/// As a German spreadsheet writes it, and in metres.
TEST(ToleranceClasses, DecimalCommasGermanNamesAndMetresAreRead) {
  const auto rules = parse_tolerance_classes(
      "Klasse;Auswahl;Vertikal [mm];Aus_Ebene [mm];Fuge_m\nA;*;2,5;+4,5/-0;0,004\nB;name=X;3,5;;0,005\n", "t.csv");
  ASSERT_EQ(rules.size(), 2u);
  EXPECT_EQ(rules[0].tolerances.at(Axis::vertical).value, 2.5 * mm);
  EXPECT_NEAR(rules[0].tolerances.at(Axis::out_of_plane).value, 4.5 * mm, 1e-12);
  EXPECT_EQ(rules[0].tolerances.at(Axis::out_of_plane).below, 0);
  EXPECT_NEAR(rules[0].tolerances.at(Axis::joint).value, 4 * mm, 1e-12);
}

TEST(ToleranceClasses, WhatIsWrongIsToldAllAtOnceWithLineAndColumn) {
  const std::string head = "class,select,vertical_mm,horizontal_mm\n";
  const std::string told =
      refusal_of(head + "A,*,abc,3\nB,,3,\nC,*,,\nD,x=y,3,\nE,*,3,+2/-1\nF,*,-3,\n,*,3,\nH,*,5000,\n");
  for (const char* part :
       {"t.csv:2: column 'vertical_mm' is 'abc', expected a length in mm", "t.csv:3: column 'select' is empty",
        "t.csv:4: found no tolerance", "t.csv:5: ", "t.csv:6: tolerance rule '*: horizontal=+2/-1mm, ",
        "t.csv:7: column 'vertical_mm' is '-3'", "t.csv:8: column 'class' is empty", "t.csv:9: "})
    EXPECT_NE(told.find(part), std::string::npos) << part << "\n" << told;
  for (const auto& [csv, part] : std::vector<std::pair<std::string, std::string>>{
           {"class,select,flatness_mm\nA,*,3\n", "t.csv:1: unknown column 'flatness_mm'"},
           {"class,select,optional,vertical_mm\nA,*,perhaps,3\n", "t.csv:2: column 'optional' is 'perhaps'"},
           {"class,select,vertical\nA,*,3\n", "t.csv:1: column 'vertical' has no unit"},
           {"class,select,vertical_in\nA,*,3\n", "mm or m"},
           {"class,vertical_mm\nA,3\n", "found no column 'select'"},
           {"class,select,vertical_mm,vertical_m\nA,*,3,1\n", "stands here twice"},
           {head, "found a header and no row"},
           {"3,4\n", "found no header line"}})
    EXPECT_NE(refusal_of(csv).find(part), std::string::npos) << csv << refusal_of(csv);
}

/// The examples of the documentation are tables, and say of themselves that their numbers are to be checked.
TEST(ToleranceClasses, TheExamplesAreRead) {
  for (const char* name : {"tolerances_din_18202_example.csv", "tolerances_en_13670_example.csv"}) {
    const std::string csv =
        text::read_whole(std::filesystem::path(plumbline::test::source_dir()) / "docs/examples" / name);
    EXPECT_GE(parse_tolerance_classes(csv, name).size(), 2u) << name;
    EXPECT_NE(csv.find("check every number"), std::string::npos) << name;
  }
}

}  // namespace test_tolerance_classes
}  // namespace plumbline::judgement

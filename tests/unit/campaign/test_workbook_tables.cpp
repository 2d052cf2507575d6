// Tables in Excel's own files: as Excel writes them (shared strings, formats), as libraries do, and what is refused.
#include <gtest/gtest.h>

#include "building/judgement/tolerance_classes.hpp"
#include "building/step/zip_writer.hpp"
#include "campaign_folder.hpp"
#include "propose_campaign.hpp"
#include "recognise_tables.hpp"
#include "test_support.hpp"
#include "unused_files.hpp"
#include "workbook_tables.hpp"

namespace plumbline::campaign {
namespace test_workbook_tables {

namespace fs = std::filesystem;
using Sheets = std::vector<std::pair<std::string, std::string>>;  // attributes of <sheet>, rows

std::string workbook(const Sheets& sheets, const std::string& strings = "", const std::string& styles = "") {
  const std::string head = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";
  std::string listed, relations;
  step::ZipWriter zip;
  for (std::size_t i = 0; i < sheets.size(); ++i) {
    const std::string id = std::to_string(i + 1);
    listed += "<sheet " + sheets[i].first + " sheetId=\"" + id + "\" r:id=\"rId" + id + "\"/>";
    relations += "<Relationship Id=\"rId" + id + "\" Type=\"worksheet\" Target=\"worksheets/sheet" + id + ".xml\"/>";
    zip.add("xl/worksheets/sheet" + id + ".xml",
            head + "<worksheet><sheetData>" + sheets[i].second + "</sheetData></worksheet>");
  }
  zip.add("xl/workbook.xml", head + "<workbook xmlns:r=\"r\"><sheets>" + listed + "</sheets></workbook>");
  zip.add("xl/_rels/workbook.xml.rels", head + "<Relationships>" + relations + "</Relationships>");
  if (!strings.empty()) zip.add("xl/sharedStrings.xml", head + "<sst>" + strings + "</sst>");
  if (!styles.empty()) zip.add("xl/styles.xml", head + "<styleSheet>" + styles + "</styleSheet>");
  return zip.finish();
}

std::string refusal_of(const std::string& bytes) {
  try {
    sheets_of(bytes, "T.xlsx");
  } catch (const CampaignError& error) {
    return error.what();
  }
  return "";
}

std::string text_cell(const std::string& place, const std::string& text) {
  return "<c r=\"" + place + "\" t=\"inlineStr\"><is><t>" + text + "</t></is></c>";
}

TEST(Workbook, HoldsNumbersAndTextsAsTheFileHasThem) {
  const std::string rows =
      "<row r=\"2\"><c r=\"A2\" t=\"s\"><v>0</v></c><c r=\"C2\" t=\"s\"><v>1</v></c></row>"
      "<row r=\"4\"><c r=\"A4\" s=\"1\"><v>7</v></c><c r=\"B4\"><v>5412345.6780000003</v></c>"
      "<c r=\"C4\"><f>B4/2</f><v>5.0000000000000001E-4</v></c></row>";
  const auto sheets = sheets_of(
      workbook({{"name=\"Punkte\"", rows}, {"name=\"alt\" state=\"hidden\"", rows}},
               "<si><t>Punkt, Nr</t></si><si><r><t>H</t></r><r><t "
               "xml:space=\"preserve\">öhe</t></r><rPh><t>x</t></rPh></si>",
               "<numFmts><numFmt numFmtId=\"164\" formatCode=\"0000\"/></numFmts><cellXfs><xf numFmtId=\"0\"/><xf "
               "numFmtId=\"164\"/></cellXfs>"),
      "T.xlsx");
  ASSERT_EQ(sheets.size(), 1u) << "what is hidden is no part of the table";
  EXPECT_EQ(sheets[0].name, "Punkte");
  EXPECT_EQ(sheets[0].csv, "\n\"Punkt, Nr\",,Höhe\n\n0007,5412345.678,0.0005\n");
}

TEST(Workbook, RefusesWhatHasNoValue) {
  const auto cell = [](const std::string& xml) { return workbook({{"name=\"A\"", "<row r=\"1\">" + xml + "</row>"}}); };
  EXPECT_NE(refusal_of("PK\x03\x04 cut").find("T.xlsx: this ZIP archive is cut off"), std::string::npos);
  EXPECT_NE(refusal_of("\xD0\xCF\x11\xE0").find("this is no Excel workbook; is it protected by a password"),
            std::string::npos);
  EXPECT_NE(refusal_of(cell("<c r=\"B1\"><f>A1+1</f></c>")).find("a formula whose value the file does not have"),
            std::string::npos);
  EXPECT_NE(refusal_of(cell("<c r=\"B1\" t=\"s\"><v>3</v></c>")).find("names a text that the workbook does not have"),
            std::string::npos);
  EXPECT_NE(refusal_of(cell("<c r=\"B2\"><v>3</v></c>")).find("has the cell 'B2' in its row 1"), std::string::npos);
}

/// A remark that is #N/A, and the rows that a program has formatted to the end of the sheet, are no mistakes.
TEST(Workbook, ErrorsAreTextsAndRowsWithoutCellsAreNone) {
  const auto sheets = sheets_of(workbook({{"name=\"A\"",
                                           "<row r=\"1\"><c r=\"A1\" t=\"e\"><v>#N/A</v></c></row>"
                                           "<row r=\"2\"><c r=\"A2\" s=\"1\"/></row><row r=\"1048576\"/>"}}),
                                "T.xlsx");
  ASSERT_EQ(sheets.size(), 1u);
  EXPECT_EQ(sheets[0].csv, "\"#N/A\"\n") << "in quotes, because a line of # is a remark";
}

/// A folder with Excel's own tables needed two exports before its first report.
TEST(Workbook, IsProposedAndReadAsTheTableItHolds) {
  const std::string plates =
      "<row r=\"1\">" + text_cell("A1", "Projekt Turm") + "</row><row r=\"3\">" + text_cell("A3", "Anker") +
      text_cell("B3", "Rolle") + text_cell("C3", "Geschoss") + text_cell("D3", "Tag-Familie") +
      text_cell("E3", "Tag-Nr") + text_cell("F3", "Tag-Größe [mm]") + text_cell("G3", "tag_x_mm") +
      text_cell("H3", "tag_y_mm") + text_cell("I3", "tag_z_mm") + text_cell("J3", "Azimut [deg]") +
      "</row><row r=\"4\">" + text_cell("A4", "F01") + text_cell("B4", "Passpunkt") + "<c r=\"C4\"><v>1</v></c>" +
      text_cell("D4", "tag36h11") +
      "<c r=\"E4\"><v>0</v></c><c r=\"F4\"><v>200.5</v></c><c r=\"G4\"><v>0</v></c><c r=\"H4\"><v>200</v></c>"
      "<c r=\"I4\"><v>0</v></c><c r=\"J4\"><v>180</v></c></row>";
  const std::string points =
      "<row r=\"1\">" + text_cell("A1", "Punkt") + text_cell("B1", "Rechtswert") + text_cell("C1", "Hochwert") +
      text_cell("D1", "Höhe") + "</row><row r=\"2\">" + text_cell("A2", "G1") +
      "<c r=\"B2\"><v>512345.678</v></c><c r=\"C2\"><v>5412345.125</v></c><c r=\"D2\"><v>3.1</v></c></row>";
  test::TemporaryFolder folder;
  const fs::path file = folder.path() / "Tabellen.xlsx";
  const auto write = [&](const Sheets& sheets) { std::ofstream(file, std::ios::binary) << workbook(sheets); };
  write({{"name=\"Schilder\"", plates}, {"name=\"Festpunkte\"", points}});
  const Proposal p = propose_campaign(folder.path(), {"Tabellen.xlsx"});
  for (const char* line : {"\nplates: Tabellen.xlsx   #", "\ncontrol: Tabellen.xlsx   #"})
    EXPECT_NE(p.yaml.find(line), std::string::npos) << line << "\n" << p.yaml;
  std::vector<std::string> warnings;
  const auto entries =
      parse_plates(table_text(file, is_table_of_plates, "a table of plates"), file, CampaignUse::site, &warnings);
  ASSERT_EQ(entries.size(), 1u);
  EXPECT_EQ(entries[0].tag_size, 0.2005);
  const auto known = parse_control(table_text(file, has_columns_of_points, "a table of known points"), file);
  ASSERT_EQ(known.size(), 1u);
  EXPECT_EQ(known[0].position, Eigen::Vector3d(512345.678, 5412345.125, 3.1));
  // Named for its plates alone: the sheet of known points has no use, which nobody may overlook.
  CampaignDescription description;
  description.plates = "Tabellen.xlsx";
  const std::vector<UnusedFile> unused = unused_files(description, folder.path(), {"Tabellen.xlsx"});
  EXPECT_EQ(forgotten_control(unused), std::vector<std::string>{"Tabellen.xlsx, sheet 'Festpunkte'"});
  description.unused = {"Tabellen.xlsx#Festpunkte"};
  EXPECT_TRUE(forgotten_control(unused_files(description, folder.path(), {"Tabellen.xlsx"})).empty());
  description.unused.clear();
  // A sheet of panels has a number and a height, too, and is no table of known points.
  const std::string panels = "<row r=\"1\">" + text_cell("A1", "Nr") + text_cell("B1", "Breite") +
                             text_cell("C1", "Höhe") + "</row><row r=\"2\">" + text_cell("A2", "P1") +
                             "<c r=\"B2\"><v>1.2</v></c><c r=\"C2\"><v>3.1</v></c></row>";
  write({{"name=\"Platten\"", panels}});
  EXPECT_TRUE(forgotten_control(unused_files({}, folder.path(), {"Tabellen.xlsx"})).empty());
  write({{"name=\"Platten\"", panels}, {"name=\"Festpunkte\"", points}});
  EXPECT_EQ(parse_control(control_text(file), file).size(), 1u);
  description.control = "Tabellen.xlsx";
  EXPECT_TRUE(unused_files(description, folder.path(), {"Tabellen.xlsx"}).empty());
  write({{"name=\"neu\"", points}, {"name=\"alt\"", points}});
  EXPECT_THROW(table_text(file, has_columns_of_points, "a table of known points"), CampaignError) << "which of them?";
}

TEST(Workbook, HoldsToleranceClassesOnTheSheetThatHasTheirColumns) {
  const std::string classes = "<row r=\"1\">" + text_cell("A1", "Klasse") + text_cell("B1", "Auswahl") +
                              text_cell("C1", "vertikal_mm") + text_cell("D1", "aus_Ebene_mm") + "</row><row r=\"2\">" +
                              text_cell("A2", "A") + text_cell("B2", "class=IfcPlate") + "<c r=\"C2\"><v>3.5</v></c>" +
                              text_cell("D2", "+5/-2") + "</row>";
  test::TemporaryFolder folder;
  const fs::path file = folder.path() / "Klassen.xlsx";
  std::ofstream(file, std::ios::binary) << workbook(
      {{"name=\"Deckblatt\"", "<row r=\"1\">" + text_cell("A1", "Projekt Turm") + "</row>"},
       {"name=\"Klassen\"", classes}});
  const auto rules = judgement::parse_tolerance_classes(
      table_text(file, judgement::is_table_of_tolerances, "a table of tolerance classes"), "Klassen.xlsx");
  ASSERT_EQ(rules.size(), 1u);
  EXPECT_TRUE(rules[0].text.starts_with("Klassen.xlsx:2, class A: class=IfcPlate: ")) << rules[0].text;
  EXPECT_EQ(rules[0].tolerances.size(), 2u);
}

/// Somebody types two lengths, "5/2", and Excel makes a day of them, which is 45 metres where a number is wanted.
TEST(Workbook, ADayIsNoNumber) {
  const auto sheets = sheets_of(
      workbook(
          {{"name=\"Klassen\"",
            "<row r=\"1\"><c r=\"A1\" s=\"1\"><v>45327</v></c><c r=\"B1\" s=\"2\"><v>45327.5</v></c>"
            "<c r=\"C1\" s=\"3\"><v>45327</v></c><c r=\"D1\"><v>45327</v></c></row>"}},
          "",
          "<numFmts><numFmt numFmtId=\"164\" formatCode=\"dd/mm/yyyy\"/><numFmt numFmtId=\"165\" "
          "formatCode=\"[Red]0.000&quot; day&quot;\"/></numFmts><cellXfs><xf numFmtId=\"0\"/><xf numFmtId=\"14\"/><xf "
          "numFmtId=\"164\"/><xf numFmtId=\"165\"/></cellXfs>"),
      "T.xlsx");
  ASSERT_EQ(sheets.size(), 1u);
  EXPECT_EQ(sheets[0].csv, "2024-02-05,2024-02-05,45327,45327\n");
}

}  // namespace test_workbook_tables
}  // namespace plumbline::campaign

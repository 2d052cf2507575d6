#include "show/report/workbook.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <set>
#include <stdexcept>

#include "base/text/xml_text.hpp"
#include "building/step/zip_writer.hpp"

namespace plumbline::report {
namespace {

const std::string kHead = "<?xml version=\"1.0\" encoding=\"UTF-8\" standalone=\"yes\"?>\n";
const std::string kMain = "xmlns=\"http://schemas.openxmlformats.org/spreadsheetml/2006/main\"";
const std::string kOffice = "http://schemas.openxmlformats.org/officeDocument/2006/relationships";
const std::string kPackage = "http://schemas.openxmlformats.org/package/2006/";
constexpr std::size_t kMostRows = 1048576;
constexpr int kMostDecimals = 4;

/// A, B, …, Z, AA, …
std::string column_name(std::size_t column) {
  std::string name;
  for (std::size_t rest = column + 1; rest > 0; rest = (rest - 1) / 26)
    name.insert(name.begin(), static_cast<char>('A' + (rest - 1) % 26));
  return name;
}

std::string number_text(double value) {
  char text[64];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// XML holds no control characters, whatever is done to them.
std::string printable(const std::string& text) {
  std::string out;
  for (const char c : text) out += static_cast<unsigned char>(c) < 0x20 && c != '\t' && c != '\n' ? ' ' : c;
  return text::xml_escaped(out);
}

std::string cell_xml(const SheetCell& cell, const std::string& place, int style) {
  if (const double* number = std::get_if<double>(&cell)) {
    if (!std::isfinite(*number)) return "";
    return "<c r=\"" + place + "\" s=\"" + std::to_string(style) + "\"><v>" + number_text(*number) + "</v></c>";
  }
  const std::string& words = std::get<std::string>(cell);
  if (words.empty()) return "";
  return "<c r=\"" + place + "\" t=\"inlineStr\"" + (style < 0 ? " s=\"5\"" : "") + "><is><t xml:space=\"preserve\">" +
         printable(words) + "</t></is></c>";
}

void check(const Sheet& sheet) {
  if (sheet.name.empty() || sheet.name.size() > 31 || sheet.name.find_first_of("[]:*?/\\") != std::string::npos)
    throw std::invalid_argument("a sheet cannot be called '" + sheet.name + "'");
  if (sheet.decimals.size() != sheet.heads.size())
    throw std::invalid_argument("sheet '" + sheet.name + "': each column needs its decimals");
  if (sheet.rows.size() + 1 > kMostRows)
    throw std::invalid_argument("sheet '" + sheet.name + "' has " + std::to_string(sheet.rows.size()) +
                                " rows, and one holds " + std::to_string(kMostRows - 1));
  for (const auto& row : sheet.rows)
    if (row.size() != sheet.heads.size())
      throw std::invalid_argument("sheet '" + sheet.name + "': a row has " + std::to_string(row.size()) +
                                  " cells under a head of " + std::to_string(sheet.heads.size()));
}

/// As wide as what stands there, within reason.
int width_of(const Sheet& sheet, std::size_t column) {
  std::size_t most = sheet.heads[column].size();
  for (const auto& row : sheet.rows)
    if (const auto* words = std::get_if<std::string>(&row[column])) most = std::max(most, words->size());
  return static_cast<int>(std::clamp<std::size_t>(most + 2, 8, 60));
}

std::string sheet_xml(const Sheet& sheet, bool first) {
  check(sheet);
  const std::string last = column_name(sheet.heads.size() - 1) + std::to_string(sheet.rows.size() + 1);
  std::string xml = kHead + "<worksheet " + kMain + "><dimension ref=\"A1:" + last + "\"/><sheetViews><sheetView " +
                    (first ? "tabSelected=\"1\" " : "") +
                    "workbookViewId=\"0\"><pane ySplit=\"1\" topLeftCell=\"A2\" activePane=\"bottomLeft\" "
                    "state=\"frozen\"/></sheetView></sheetViews><cols>";
  for (std::size_t c = 0; c < sheet.heads.size(); ++c)
    xml += "<col min=\"" + std::to_string(c + 1) + "\" max=\"" + std::to_string(c + 1) + "\" width=\"" +
           std::to_string(width_of(sheet, c)) + "\" customWidth=\"1\"/>";
  xml += "</cols><sheetData><row r=\"1\">";
  for (std::size_t c = 0; c < sheet.heads.size(); ++c) xml += cell_xml(sheet.heads[c], column_name(c) + "1", -1);
  xml += "</row>";
  for (std::size_t r = 0; r < sheet.rows.size(); ++r) {
    const std::string number = std::to_string(r + 2);
    xml += "<row r=\"" + number + "\">";
    for (std::size_t c = 0; c < sheet.heads.size(); ++c)
      xml += cell_xml(sheet.rows[r][c], column_name(c) + number, std::clamp(sheet.decimals[c], 0, kMostDecimals));
    xml += "</row>";
  }
  return xml + "</sheetData><autoFilter ref=\"A1:" + last + "\"/></worksheet>\n";
}

/// Styles 0 to 4: numbers with so many decimals; 5: the head.
std::string styles_xml() {
  std::string formats, cells;
  for (int d = 0; d <= kMostDecimals; ++d) {
    formats += "<numFmt numFmtId=\"" + std::to_string(164 + d) + "\" formatCode=\"0" +
               (d > 0 ? "." + std::string(static_cast<std::size_t>(d), '0') : "") + "\"/>";
    cells += "<xf numFmtId=\"" + std::to_string(164 + d) +
             "\" fontId=\"0\" fillId=\"0\" borderId=\"0\" xfId=\"0\" applyNumberFormat=\"1\"/>";
  }
  cells += "<xf numFmtId=\"0\" fontId=\"1\" fillId=\"0\" borderId=\"0\" xfId=\"0\" applyFont=\"1\"/>";
  return kHead + "<styleSheet " + kMain + "><numFmts count=\"5\">" + formats +
         "</numFmts><fonts count=\"2\"><font><sz val=\"11\"/><name val=\"Calibri\"/></font><font><b/><sz "
         "val=\"11\"/><name val=\"Calibri\"/></font></fonts><fills count=\"2\"><fill><patternFill "
         "patternType=\"none\"/></fill><fill><patternFill patternType=\"gray125\"/></fill></fills><borders "
         "count=\"1\"><border><left/><right/><top/><bottom/><diagonal/></border></borders><cellStyleXfs "
         "count=\"1\"><xf numFmtId=\"0\" fontId=\"0\" fillId=\"0\" borderId=\"0\"/></cellStyleXfs><cellXfs "
         "count=\"6\">" +
         cells +
         "</cellXfs><cellStyles count=\"1\"><cellStyle name=\"Normal\" xfId=\"0\" builtinId=\"0\"/></cellStyles>"
         "</styleSheet>\n";
}

}  // namespace

std::string write_workbook(const std::vector<Sheet>& sheets) {
  const std::string relation = "<Relationship Id=\"rId";
  std::string types, list, relations, names;
  std::set<std::string> taken;
  step::ZipWriter zip;
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < sheets.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    parts.push_back(sheet_xml(sheets[i], i == 0));
    if (!taken.insert(sheets[i].name).second)
      throw std::invalid_argument("two sheets are called '" + sheets[i].name + "'");
    types += "<Override PartName=\"/xl/worksheets/sheet" + number +
             ".xml\" ContentType=\"application/vnd.openxmlformats-officedocument.spreadsheetml.worksheet+xml\"/>";
    list += "<sheet name=\"" + printable(sheets[i].name) + "\" sheetId=\"" + number + "\" r:id=\"rId" + number + "\"/>";
    relations +=
        relation + number + "\" Type=\"" + kOffice + "/worksheet\" Target=\"worksheets/sheet" + number + ".xml\"/>";
    const std::string last = column_name(sheets[i].heads.size() - 1);
    names += "<definedName name=\"_xlnm._FilterDatabase\" localSheetId=\"" + std::to_string(i) + "\" hidden=\"1\">'" +
             printable(sheets[i].name) + "'!$A$1:$" + last + "$" + std::to_string(sheets[i].rows.size() + 1) +
             "</definedName>";
  }
  zip.add("[Content_Types].xml",
          kHead + "<Types xmlns=\"" + kPackage +
              "content-types\"><Default Extension=\"rels\" "
              "ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/><Default Extension=\"xml\" "
              "ContentType=\"application/xml\"/><Override PartName=\"/xl/workbook.xml\" "
              "ContentType=\"application/vnd.openxmlformats-officedocument.spreadsheetml.sheet.main+xml\"/><Override "
              "PartName=\"/xl/styles.xml\" "
              "ContentType=\"application/vnd.openxmlformats-officedocument.spreadsheetml.styles+xml\"/>" +
              types + "</Types>\n");
  zip.add("_rels/.rels", kHead + "<Relationships xmlns=\"" + kPackage + "relationships\">" + relation + "1\" Type=\"" +
                             kOffice + "/officeDocument\" Target=\"xl/workbook.xml\"/></Relationships>\n");
  zip.add("xl/workbook.xml", kHead + "<workbook " + kMain + " xmlns:r=\"" + kOffice + "\"><sheets>" + list +
                                 "</sheets><definedNames>" + names + "</definedNames></workbook>\n");
  zip.add("xl/_rels/workbook.xml.rels", kHead + "<Relationships xmlns=\"" + kPackage + "relationships\">" + relations +
                                            relation + std::to_string(sheets.size() + 1) + "\" Type=\"" + kOffice +
                                            "/styles\" Target=\"styles.xml\"/></Relationships>\n");
  zip.add("xl/styles.xml", styles_xml());
  for (std::size_t i = 0; i < parts.size(); ++i)
    zip.add("xl/worksheets/sheet" + std::to_string(i + 1) + ".xml", parts[i]);
  return zip.finish();
}

}  // namespace plumbline::report

#include "workbook_tables.hpp"

#include <charconv>
#include <cmath>
#include <cstring>
#include <ctime>
#include <map>
#include <optional>
#include <pugixml.hpp>
#include <set>
#include <string_view>

#include "base/text/csv_table.hpp"
#include "base/text/text.hpp"
#include "base/text/whole_file.hpp"
#include "building/step/zip_reader.hpp"
#include "campaign_folder.hpp"
#include "recognise_tables.hpp"

namespace plumbline::campaign {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostColumns = 256, kMostRows = 100000;

/// Some programs write <x:row> for <row>.
std::string_view local_name(const char* name) {
  const char* colon = std::strchr(name, ':');
  return colon ? colon + 1 : name;
}

std::vector<pugi::xml_node> children(const pugi::xml_node& node, std::string_view name) {
  std::vector<pugi::xml_node> found;
  for (const pugi::xml_node& child : node.children())
    if (local_name(child.name()) == name) found.push_back(child);
  return found;
}

pugi::xml_node child(const pugi::xml_node& node, std::string_view name) {
  const auto found = children(node, name);
  return found.empty() ? pugi::xml_node() : found.front();
}

/// Of an attribute whatever its prefix is: r:id.
std::string attribute(const pugi::xml_node& node, std::string_view name) {
  for (const pugi::xml_attribute& a : node.attributes())
    if (local_name(a.name()) == name) return a.value();
  return "";
}

/// Of <si> and <is>: its text, in one part or in several with formats of their own; not how it is spoken (<rPh>).
std::string rich_text(const pugi::xml_node& node) {
  std::string text;
  for (const pugi::xml_node& part : node.children()) {
    if (local_name(part.name()) == "t") text += part.text().get();
    if (local_name(part.name()) == "r") text += child(part, "t").text().get();
  }
  return text;
}

/// Column and row of "AB12", both from 0.
std::optional<std::pair<std::size_t, std::size_t>> place_of(std::string_view reference) {
  std::size_t column = 0, i = 0;
  for (; i < reference.size() && reference[i] >= 'A' && reference[i] <= 'Z' && i < 3; ++i)
    column = 26 * column + static_cast<std::size_t>(reference[i] - 'A' + 1);
  const auto row = text::parse_integer(reference.substr(i));
  if (i == 0 || !row || *row < 1) return std::nullopt;
  return std::pair{column - 1, static_cast<std::size_t>(*row - 1)};
}

/// Days and years in it, outside of what is written as it stands ("..." and \\x), of blanks as
/// wide as a letter (_x), of what fills (*x) and of colours ([Red]).
bool is_format_of_dates(const std::string& code) {
  if (code == "Standard") return false;  // "General" in German
  bool quoted = false, bracketed = false;
  for (std::size_t i = 0; i < code.size(); ++i) {
    if (!quoted && (code[i] == '\\' || code[i] == '_' || code[i] == '*')) {
      ++i;
    } else if (code[i] == '"') {
      quoted = !quoted;
    } else if (!quoted && (code[i] == '[' || code[i] == ']')) {
      bracketed = code[i] == '[';
    } else if (!quoted && !bracketed && std::strchr("dDyY", code[i])) {
      return true;
    }
  }
  return false;
}

/// The day that a spreadsheet counts from the end of 1899, as it does since March 1900.
std::string date_text(double days) {
  const std::time_t seconds = (static_cast<std::time_t>(std::floor(days)) - 25569) * 86400;
  std::tm day{};
  char text[32];
  gmtime_r(&seconds, &day);
  return std::string(text, std::strftime(text, sizeof text, "%Y-%m-%d", &day));
}

class Workbook {
 public:
  Workbook(const std::string& bytes, const fs::path& file) : bytes_(bytes), file_(file) {
    if (!step::is_zip(bytes)) refuse("this is no Excel workbook; is it protected by a password, or an older .xls?");
    read_strings();
    read_formats();
  }

  std::vector<WorkbookSheet> sheets() const {
    pugi::xml_document book, relations;
    load("xl/workbook.xml", book, true), load("xl/_rels/workbook.xml.rels", relations, true);
    std::map<std::string, std::string> targets;
    for (const pugi::xml_node& relation : children(relations.document_element(), "Relationship"))
      targets[relation.attribute("Id").value()] = relation.attribute("Target").value();
    std::vector<WorkbookSheet> found;
    for (const pugi::xml_node& sheet : children(child(book.document_element(), "sheets"), "sheet")) {
      const std::string state = sheet.attribute("state").value(), target = targets[attribute(sheet, "id")];
      if (state == "hidden" || state == "veryHidden" || target.find("worksheets/") == std::string::npos) continue;
      const std::string name = sheet.attribute("name").value();
      pugi::xml_document content;
      load(target.starts_with('/') ? target.substr(1) : "xl/" + target, content, true);
      found.push_back({name, csv_of(child(content.document_element(), "sheetData"), name)});
    }
    return found;
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw CampaignError(file_, 0, what + "; save the sheet as CSV beside it");
  }

  bool load(const std::string& name, pugi::xml_document& document, bool needed) const {
    std::optional<std::string> xml;
    try {
      xml = step::unzip_file(bytes_, name);
    } catch (const std::runtime_error& error) {
      refuse(error.what());
    }
    if (!xml && needed) refuse("this is no whole Excel workbook: it lacks " + name);
    if (!xml) return false;
    if (!document.load_buffer(xml->data(), xml->size(), pugi::parse_default | pugi::parse_ws_pcdata_single))
      refuse("this workbook is damaged: " + name + " is no XML");
    return true;
  }

  void read_strings() {
    pugi::xml_document document;
    if (!load("xl/sharedStrings.xml", document, false)) return;
    for (const pugi::xml_node& item : children(document.document_element(), "si")) strings_.push_back(rich_text(item));
  }

  /// Of each style whose format is zeros alone ("0000"), how many: so are names of points written that begin with
  /// zeros.
  void read_formats() {
    pugi::xml_document document;
    if (!load("xl/styles.xml", document, false)) return;
    std::map<std::string, std::size_t> zeros;
    std::set<std::string> dates;
    for (const pugi::xml_node& format : children(child(document.document_element(), "numFmts"), "numFmt")) {
      const std::string code = format.attribute("formatCode").value(), id = format.attribute("numFmtId").value();
      if (code.size() > 1 && code.find_first_not_of('0') == std::string::npos) zeros[id] = code.size();
      if (is_format_of_dates(code)) dates.insert(id);
    }
    for (const pugi::xml_node& style : children(child(document.document_element(), "cellXfs"), "xf")) {
      const std::string id = style.attribute("numFmtId").value();
      const auto number = text::parse_integer(id);
      digits_.push_back(zeros[id]);
      dates_.push_back(dates.contains(id) || (number && ((*number >= 14 && *number <= 17) || *number == 22)));
    }
  }

  std::string csv_of(const pugi::xml_node& data, const std::string& sheet) const {
    std::string csv;
    std::size_t written = 0, next_row = 0;
    bool any = false;
    for (const pugi::xml_node& row : children(data, "row")) {
      const auto number = text::parse_integer(row.attribute("r").value());
      const std::size_t at = number && *number > 0 ? static_cast<std::size_t>(*number - 1) : next_row;
      const std::string line = line_of(row, sheet, at);
      next_row = at + 1;
      if (line.empty()) continue;  // formatted, or the last row that there is
      if (at < written || at >= kMostRows)
        refuse("sheet '" + sheet + "' has its row " + std::to_string(at + 1) + " out of order or beyond " +
               std::to_string(kMostRows));
      csv.append(at - written, '\n');
      any = any || line.find_first_not_of(',') != std::string::npos;
      csv += line + '\n';
      written = at + 1;
    }
    return any ? csv : "";
  }

  std::string line_of(const pugi::xml_node& row, const std::string& sheet, std::size_t at) const {
    std::vector<std::string> cells;
    std::size_t next = 0;
    for (const pugi::xml_node& cell : children(row, "c")) {
      const std::string reference = cell.attribute("r").value();
      const auto place = place_of(reference);
      const std::size_t column = place ? place->first : next;
      if (!reference.empty() && (!place || place->second != at || column < next))
        refuse("sheet '" + sheet + "' has the cell '" + reference + "' in its row " + std::to_string(at + 1));
      next = column + 1;
      const std::string text = value_of(cell, "cell " + (reference.empty() ? "?" : reference) + " of '" + sheet + "'");
      if (text.empty()) continue;
      if (column >= kMostColumns) refuse("sheet '" + sheet + "' has more than 256 columns");
      cells.resize(std::max(cells.size(), column + 1));
      cells[column] = text::csv_field(text);
    }
    std::string line;
    for (std::size_t i = 0; i < cells.size(); ++i) line += (i ? "," : "") + cells[i];
    return line;
  }

  std::string value_of(const pugi::xml_node& cell, const std::string& place) const {
    const std::string type = cell.attribute("t").value();
    const std::string value = child(cell, "v").text().get();
    if (type == "e") return value;  // "#N/A": whoever takes the column says so, with row and column
    if (child(cell, "f") && value.empty() && type != "str")
      refuse(place + " holds a formula whose value the file does not have: open it in Excel and save it");
    if (type == "inlineStr") return rich_text(child(cell, "is"));
    if (type == "s") {
      const auto index = text::parse_integer(value);
      if (!index || *index < 0 || static_cast<std::size_t>(*index) >= strings_.size())
        refuse(place + " names a text that the workbook does not have");
      return strings_[static_cast<std::size_t>(*index)];
    }
    if (type == "str" || type == "d" || type == "b" || value.empty()) return value;
    return number_text(value, cell, place);
  }

  /// Without an exponent, which would look like a number that a spreadsheet has shortened.
  std::string number_text(const std::string& value, const pugi::xml_node& cell, const std::string& place) const {
    double number = 0;
    const char* end = value.data() + value.size();
    const auto read = std::from_chars(value.data(), end, number);
    if (read.ec != std::errc() || read.ptr != end) refuse(place + " holds '" + value + "', which is no number");
    const auto style = text::parse_integer(cell.attribute("s").value());
    const bool known = style && *style >= 0 && static_cast<std::size_t>(*style) < digits_.size();
    // Excel takes "5/2" and "1-3" for days, and shows them so; the number behind is nobody's length.
    if (known && dates_[static_cast<std::size_t>(*style)] && number > 60 && number < 2958466) return date_text(number);
    char shown[400];
    std::string text(shown, std::to_chars(shown, shown + sizeof shown, number, std::chars_format::fixed).ptr);
    const std::size_t digits = known ? digits_[static_cast<std::size_t>(*style)] : 0;
    if (text.size() < digits && text.find_first_not_of("0123456789") == std::string::npos)
      text.insert(0, digits - text.size(), '0');
    return text;
  }

  const std::string& bytes_;
  fs::path file_;
  std::vector<std::string> strings_;
  std::vector<std::size_t> digits_;  // of each style; 0: as the number is
  std::vector<bool> dates_;          // of each style: its numbers are days
};

std::string names_of(const std::vector<WorkbookSheet>& sheets) {
  std::string names;
  for (const WorkbookSheet& sheet : sheets) names += (names.empty() ? "'" : ", '") + sheet.name + "'";
  return names;
}

}  // namespace

bool is_workbook(const fs::path& path) {
  const std::string ending = text::to_lower(path.extension().string());
  return ending == ".xlsx" || ending == ".xlsm";
}

std::vector<WorkbookSheet> sheets_of(const std::string& bytes, const fs::path& file) {
  return Workbook(bytes, file).sheets();
}

std::string table_text(const fs::path& file, const std::function<bool(const std::string&)>& is_it,
                       const std::string& what) {
  const std::string bytes = text::read_whole(file);
  if (!is_workbook(file)) return bytes;
  std::vector<WorkbookSheet> sheets = sheets_of(bytes, file), known;
  std::erase_if(sheets, [](const WorkbookSheet& sheet) { return sheet.csv.empty(); });
  for (const WorkbookSheet& sheet : sheets)
    if (is_it(sheet.csv)) known.push_back(sheet);
  if (known.empty() && sheets.size() == 1) known = sheets;
  if (sheets.empty()) throw CampaignError(file, 0, "no sheet of this workbook holds anything, expected " + what);
  if (known.empty()) throw CampaignError(file, 0, "none of the sheets " + names_of(sheets) + " is " + what);
  if (known.size() > 1)
    throw CampaignError(file, 0,
                        "the sheets " + names_of(known) + " could all be " + what +
                            "; leave the right one there, or "
                            "hide the others");
  return known.front().csv;
}

std::string control_text(const fs::path& file) {
  std::set<std::string> known;  // plates have heights, too, but no places, and nobody calls them control
  if (is_workbook(file))
    for (const WorkbookSheet& sheet : sheets_of(text::read_whole(file), file))
      if (has_columns_of_places(sheet.csv) || (is_called_control(sheet.name) && has_columns_of_points(sheet.csv)))
        known.insert(sheet.csv);
  const auto is_control = [&](const std::string& csv) {
    return is_workbook(file) && !known.empty() ? known.contains(csv) : has_columns_of_points(csv);
  };
  return table_text(file, is_control, "a table of known points");
}

}  // namespace plumbline::campaign

#include "building/ifc/mapping_table.hpp"

#include <algorithm>
#include <map>
#include <stdexcept>

#include "base/text/csv_table.hpp"

namespace plumbline::ifc {

std::vector<MappingRow> parse_mapping(const std::string& csv, const std::string& shown) {
  constexpr std::size_t most = 10;
  std::vector<MappingRow> rows;
  if (csv.empty()) return rows;
  const std::map<std::string, std::string> known = {
      {"point", "point"},  {"name", "point"},       {"anchor", "point"},      {"element", "element"},
      {"guid", "element"}, {"globalid", "element"}, {"global_id", "element"}, {"tag", "element"}};
  const text::CsvTable table = text::read_csv(csv, known);
  const auto column = [&](const char* name) {
    for (std::size_t i = 0; i < table.header.size(); ++i)
      if (table.header[i].name == name) return i;
    throw std::runtime_error(shown + ":" + std::to_string(std::max(1, table.header_line)) + ": found no column '" +
                             name + "', expected a header with 'point' and 'element' (" + table.dialect() + ")");
  };
  const std::size_t point = column("point"), element = column("element");
  std::vector<int> incomplete;
  for (const text::CsvRow& row : table.rows) {
    if (row.cells.size() <= std::max(point, element) || row.cells[point].text.empty() ||
        row.cells[element].text.empty())
      incomplete.push_back(row.line);
    else
      rows.push_back({row.cells[point].text, row.cells[element].text, row.line});
  }
  std::string wrong;
  for (std::size_t i = 0; i < std::min(incomplete.size(), most); ++i)
    wrong += (i ? "\n" : "") + shown + ":" + std::to_string(incomplete[i]) +
             ": found an incomplete row, expected a point and its element";
  if (incomplete.size() > most)
    wrong += "\n" + shown + ": and " + std::to_string(incomplete.size() - most) + " more rows of the kind";
  if (!wrong.empty()) throw std::runtime_error(wrong);
  return rows;
}

}  // namespace plumbline::ifc

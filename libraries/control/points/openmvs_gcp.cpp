#include "control/points/openmvs_gcp.hpp"

#include <cmath>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include "base/text/csv_table.hpp"

namespace plumbline::control {
namespace {

constexpr const char* kOpenMvsColumns =
    "gcp_label, image_file_name, x, y, x_map, y_map, elev and perhaps x_map_acc, y_map_acc, elev_acc";

const std::map<std::string, std::string>& names() {
  static const std::map<std::string, std::string> known = [] {
    std::map<std::string, std::string> list;
    for (const char* name :
         {"gcp_label", "image_file_name", "x", "y", "x_map", "y_map", "elev", "x_map_acc", "y_map_acc", "elev_acc"})
      list[name] = name;
    return list;
  }();
  return known;
}

class Table {
 public:
  Table(const std::string& text, std::string file) : file_(std::move(file)), table_(text::read_csv(text, names())) {
    for (std::size_t i = 0; i < table_.header.size(); ++i)
      if (!columns_.emplace(table_.header[i].name, i).second)
        throw std::runtime_error(file_ + ": two columns are '" + table_.header[i].name + "', expected one");
    if (!table_.doubtful.empty())
      fail(table_.doubtful.front(), std::string("found a mark in front: ") + text::kDoubtfulRow);
  }
  const std::vector<text::CsvRow>& rows() const { return table_.rows; }
  [[noreturn]] void fail(const text::CsvRow& row, const std::string& what) const {
    throw std::runtime_error(file_ + ":" + std::to_string(row.line) + ": " + what);
  }
  bool has(const std::string& name) const { return columns_.count(name) > 0; }
  std::string text(const text::CsvRow& row, const std::string& name) const {
    const auto column = columns_.find(name);
    if (column == columns_.end())
      throw std::runtime_error(file_ + ": the column '" + name + "' is missing, expected " + kOpenMvsColumns);
    if (column->second >= row.cells.size()) fail(row, "the cell '" + name + "' is missing");
    return row.cells[column->second].text;
  }
  double number(const text::CsvRow& row, const std::string& name) const {
    const std::string cell = text(row, name);
    const auto value = text::parse_number(cell, table_.decimal);
    if (!value) fail(row, "'" + name + "' is '" + cell + "', expected a number");
    return *value;
  }
  /// Standard deviation; nan where there is no column, nothing in its cell, or zero.
  double accuracy(const text::CsvRow& row, const std::string& name) const {
    if (!has(name) || text(row, name).empty()) return std::nan("");
    const double value = number(row, name);
    if (value < 0) fail(row, "'" + name + "' is negative");
    return value > 0 ? value : std::nan("");
  }

 private:
  std::string file_;
  text::CsvTable table_;
  std::map<std::string, std::size_t> columns_;
};

}  // namespace

bool looks_like_openmvs_gcp(const std::string& text) {
  std::set<std::string> found;
  for (const auto& cell : text::read_csv(text.substr(0, 4096), names()).header) found.insert(cell.name);
  return found.count("gcp_label") > 0 && found.count("image_file_name") > 0 && found.count("x_map") > 0;
}

std::vector<GcpRow> parse_openmvs_gcp(const std::string& text, const std::string& file) {
  const Table table(text, file);
  std::vector<GcpRow> rows;
  std::map<std::string, std::pair<Eigen::Vector3d, int>> places;
  std::set<std::pair<std::string, std::string>> seen;
  for (const auto& row : table.rows()) {
    GcpRow r;
    r.point = table.text(row, "gcp_label"), r.image = table.text(row, "image_file_name");
    if (r.point.empty() || r.image.empty()) table.fail(row, "gcp_label or image_file_name is empty");
    r.pixel = {table.number(row, "x"), table.number(row, "y")};
    r.position = {table.number(row, "x_map"), table.number(row, "y_map"), table.number(row, "elev")};
    r.sigma = {table.accuracy(row, "x_map_acc"), table.accuracy(row, "y_map_acc"), table.accuracy(row, "elev_acc")};
    if (!r.sigma.allFinite()) r.sigma.setConstant(std::nan(""));
    const auto [at, is_new] = places.try_emplace(r.point, r.position, row.line);
    if (!is_new && (at->second.first - r.position).norm() > 1e-4)
      table.fail(row, "point " + r.point + " has other coordinates here than in line " +
                          std::to_string(at->second.second) + "; one of the rows is of another point");
    if (!seen.insert({r.point, r.image}).second)
      table.fail(row, "point " + r.point + " is measured in " + r.image + " a second time; keep one of the rows");
    rows.push_back(r);
  }
  if (rows.empty())
    throw std::runtime_error(file + ": there is no row of a point, expected " + std::string(kOpenMvsColumns));
  return rows;
}

}  // namespace plumbline::control

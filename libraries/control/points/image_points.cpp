#include "control/points/image_points.hpp"

#include <fmt/core.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <map>
#include <optional>
#include <stdexcept>

#include "base/text/csv_table.hpp"
#include "base/text/one_document.hpp"
#include "control/points/gcp_list.hpp"

namespace plumbline::control {
namespace {

std::vector<ImagePoint> from_json(const std::string& text, const std::string& file) {
  std::vector<ImagePoint> points;
  try {
    const YAML::Node root = text::load_one_document(text);
    for (const auto& image : root["images"])
      for (const auto& tag : image["tags"]) {
        ImagePoint p{image["path"].as<std::string>(), tag["id"].as<std::string>(), Eigen::Vector2d::Zero(), 0};
        // The centre of a square in perspective is where its diagonals meet.
        Eigen::Vector3d c[4];
        for (size_t k = 0; k < 4; ++k) c[k] = {tag["corners"][k][0].as<double>(), tag["corners"][k][1].as<double>(), 1};
        p.pixel = c[0].cross(c[2]).cross(c[1].cross(c[3])).hnormalized();
        points.push_back(p);
      }
  } catch (const YAML::Exception& error) {
    throw std::runtime_error(file + ": not an observations.json of a detector (line " +
                             std::to_string(error.mark.line + 1) + ": " + error.msg + ")");
  }
  return points;
}

/// A table image, point, x, y, sigma by its header, or by the number of its columns.
class MeasuredTable {
 public:
  MeasuredTable(const std::string& text, const std::string& file) : file_(file), table_(text::read_csv(text, names())) {
    if (table_.rows.empty())
      throw std::runtime_error(file + ": found no table; expected a CSV table with the columns " + kExpected);
    if (!table_.doubtful.empty())
      fail(table_.doubtful.front(),
           "found a row that begins with '" + table_.doubtful.front().cells[0].text + "': " + text::kDoubtfulRow);
    for (size_t i = 0; i < table_.header.size(); ++i) {
      const text::CsvHeaderCell& cell = table_.header[i];
      if (!cell.unit.empty() && cell.unit != "px" && (cell.name == "x" || cell.name == "y" || cell.name == "sigma"))
        throw std::runtime_error(file + ": the column '" + cell.name + "' is in '" + cell.unit +
                                 "', expected px: convert it");
      const bool known = names().count(cell.name) > 0;
      if (!columns_.emplace(known ? names().at(cell.name) : cell.name, i).second && known)
        throw std::runtime_error(file + ": two columns are '" + cell.name + "'; expected one");
    }
    if (table_.header.empty()) take_order();
  }
  std::vector<ImagePoint> points() const {
    std::vector<ImagePoint> all;
    for (const auto& row : table_.rows) {
      all.push_back({text(row, "image"),
                     text(row, "point"),
                     {number(row, "x"), number(row, "y")},
                     columns_.count("sigma") > 0 ? number(row, "sigma") : 0});
      if (all.back().sigma < 0) fail(row, "point '" + all.back().point + "' has a negative standard deviation");
    }
    return all;
  }

 private:
  static constexpr const char* kExpected = "image, point, x, y and optionally sigma";
  static const std::map<std::string, std::string>& names() {
    static const std::map<std::string, std::string> known = {
        {"image", "image"}, {"photo", "image"}, {"path", "image"},  {"file", "image"}, {"point", "point"},
        {"name", "point"},  {"id", "point"},    {"label", "point"}, {"x", "x"},        {"y", "y"},
        {"column", "x"},    {"row", "y"},       {"u", "x"},         {"v", "y"},        {"sigma", "sigma"}};
    return known;
  }
  [[noreturn]] void fail(const text::CsvRow& row, const std::string& what) const {
    throw std::runtime_error(file_ + ":" + std::to_string(row.line) + ": " + what);
  }
  void take_order() {
    const text::CsvRow& first = table_.rows.front();
    size_t count = first.cells.size();
    while (count > 0 && first.cells[count - 1].text.empty()) --count;
    const char* order[] = {"image", "point", "x", "y", "sigma"};
    bool fits = count == 4 || count == 5;
    for (size_t i = 2; fits && i < count; ++i) fits = table_.number(first.cells[i]).has_value();
    if (!fits)
      fail(first,
           "found " + std::to_string(count) + " columns and no header; expected one with the columns " + kExpected);
    for (size_t i = 0; i < count; ++i) columns_[order[i]] = i;
  }
  const std::string& text(const text::CsvRow& row, const std::string& name) const {
    const auto found = columns_.find(name);
    if (found == columns_.end())
      throw std::runtime_error(file_ + ": the column '" + name + "' is missing; expected " + kExpected);
    if (found->second >= row.cells.size()) fail(row, "the cell '" + name + "' is missing");
    return row.cells[found->second].text;
  }
  double number(const text::CsvRow& row, const std::string& name) const {
    const std::string& cell = text(row, name);
    const auto value = text::parse_number(cell, table_.decimal);
    if (!value) fail(row, "'" + name + "' is '" + cell + "', expected a number");
    return *value;
  }

  std::string file_;
  text::CsvTable table_;
  std::map<std::string, size_t> columns_;
};

}  // namespace

std::vector<ImagePoint> parse_image_points(const std::string& text, const std::string& file, bool corner_origin) {
  std::vector<ImagePoint> points;
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '{') return from_json(text, file);
  if (const auto lines = gcp_lines(text, file))
    for (const auto& g : *lines) points.push_back({g.image, g.name, g.pixel, 0});
  else
    points = MeasuredTable(text, file).points();
  if (corner_origin)
    for (auto& p : points) p.pixel -= Eigen::Vector2d(0.5, 0.5);
  return points;
}

std::string gcp_list(const std::vector<ControlPoint>& control, const std::vector<ImagePoint>& measured,
                     const std::string& projection) {
  std::map<std::string, const ControlPoint*> by_name;
  for (const auto& p : control) by_name[p.name] = &p;
  std::string text = projection + "\n";
  for (const auto& m : measured) {
    const auto p = by_name.find(m.point);
    if (p == by_name.end()) continue;
    const std::string line = fmt::format("{:.6f} {:.6f} {:.6f} {:.4f} {:.4f} ", p->second->position.x(),
                                         p->second->position.y(), p->second->position.z(), m.pixel.x(), m.pixel.y());
    text += line + m.image + " " + m.point + "\n";
  }
  return text;
}

}  // namespace plumbline::control

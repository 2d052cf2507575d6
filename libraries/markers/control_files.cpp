#include "markers/control_files.hpp"

#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>

#include <cmath>
#include <cstdio>
#include <map>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>

#include "text/csv_table.hpp"

namespace plumbline::markers {
namespace {

/// A line of gcp_list.txt: x y z column row image [name].
struct GcpLine {
  Eigen::Vector3d position;
  Eigen::Vector2d pixel;
  std::string image, name;
};

/// The lines after the projection; nothing if the text is no gcp_list.
std::optional<std::vector<GcpLine>> gcp_lines(const std::string& text, const std::string& file) {
  std::istringstream stream(text);
  std::string line;
  if (!std::getline(stream, line)) return std::nullopt;
  std::string first = line.substr(0, line.find_first_of("\r"));
  const bool projection =
      first.rfind("EPSG:", 0) == 0 || first.rfind("+proj", 0) == 0 || first.rfind("WGS84", 0) == 0 || first == "LOCAL";
  if (!projection) return std::nullopt;
  if (first.find("longlat") != std::string::npos || first == "EPSG:4326" || first == "WGS84")
    throw std::runtime_error(file + ": the points are in degrees (" + first +
                             "); transform them to a projected system in metres first");
  std::vector<GcpLine> lines;
  std::map<std::string, std::string> names;
  for (int number = 2; std::getline(stream, line); ++number) {
    if (line.find_first_not_of(" \t\r") == std::string::npos || line[0] == '#') continue;
    GcpLine g;
    std::istringstream words(line);
    if (!(words >> g.position.x() >> g.position.y() >> g.position.z() >> g.pixel.x() >> g.pixel.y() >> g.image))
      throw std::runtime_error(file + ":" + std::to_string(number) + ": expected x y z column row image [name]");
    if (!(words >> g.name)) {  // points without a name are told apart by their coordinates
      std::ostringstream key;
      key.precision(12);
      key << g.position.transpose();
      g.name = names.emplace(key.str(), "gcp" + std::to_string(names.size() + 1)).first->second;
    }
    lines.push_back(g);
  }
  if (lines.empty()) throw std::runtime_error(file + ": there is no point under the projection");
  return lines;
}

class Table {
 public:
  Table(const std::string& text, const std::string& file, const std::map<std::string, std::string>& names,
        const char* expected)
      : file_(file), table_(formats::read_csv(text, names)) {
    if (table_.header.empty() || table_.rows.empty())
      throw std::runtime_error(file + ": found no table; expected a CSV table with the columns " + expected);
    for (size_t i = 0; i < table_.header.size(); ++i) {
      std::string name = table_.header[i].name;
      double unit = table_.header[i].unit == "mm" ? 1e-3 : 1;
      if (name.ends_with("_mm"))
        name.resize(name.size() - 3), unit = 1e-3;
      else if (name.ends_with("_m"))
        name.resize(name.size() - 2);
      else if (name.ends_with("_px"))
        name.resize(name.size() - 3);
      const auto known = names.find(name);
      columns_[known == names.end() ? name : known->second] = {i, unit};
    }
    expected_ = expected;
  }
  const std::vector<formats::CsvRow>& rows() const { return table_.rows; }
  bool has(const std::string& name) const { return columns_.count(name) > 0; }
  std::string text(const formats::CsvRow& row, const std::string& name) const {
    const auto found = columns_.find(name);
    if (found == columns_.end())
      throw std::runtime_error(file_ + ": the column '" + name + "' is missing; expected " + expected_);
    if (found->second.first >= row.cells.size())
      throw std::runtime_error(file_ + ":" + std::to_string(row.line) + ": the cell '" + name + "' is missing");
    return row.cells[found->second.first].text;
  }
  double number(const formats::CsvRow& row, const std::string& name) const {
    const std::string cell = text(row, name);
    const auto& [index, unit] = columns_.at(name);
    const auto value = table_.number(row.cells[index]);
    if (!value)
      throw std::runtime_error(file_ + ":" + std::to_string(row.line) + ": '" + name + "' is '" + cell +
                               "', expected a number");
    return unit * *value;
  }

 private:
  std::string file_, expected_;
  formats::CsvTable table_;
  std::map<std::string, std::pair<size_t, double>> columns_;
};

std::vector<ImagePoint> from_json(const std::string& text, const std::string& file) {
  std::vector<ImagePoint> points;
  try {
    const YAML::Node root = YAML::Load(text);
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

}  // namespace

std::vector<ControlPoint> parse_control(const std::string& text, const std::string& file) {
  std::vector<ControlPoint> points;
  const double nan = std::nan("");
  if (const auto lines = gcp_lines(text, file)) {
    std::set<std::string> seen;
    for (const auto& g : *lines)
      if (seen.insert(g.name).second) points.push_back({g.name, g.position, {nan, nan, nan}, false});
    return points;
  }
  static const std::map<std::string, std::string> names = {{"name", "name"},
                                                           {"id", "name"},
                                                           {"point", "name"},
                                                           {"label", "name"},
                                                           {"x", "x"},
                                                           {"y", "y"},
                                                           {"z", "z"},
                                                           {"east", "x"},
                                                           {"easting", "x"},
                                                           {"north", "y"},
                                                           {"northing", "y"},
                                                           {"height", "z"},
                                                           {"elevation", "z"},
                                                           {"altitude", "z"},
                                                           {"e", "x"},
                                                           {"n", "y"},
                                                           {"h", "z"},
                                                           {"sigma", "sigma"},
                                                           {"accuracy", "sigma"},
                                                           {"sigma_x", "sigma_x"},
                                                           {"sigma_y", "sigma_y"},
                                                           {"sigma_z", "sigma_z"},
                                                           {"sx", "sigma_x"},
                                                           {"sy", "sigma_y"},
                                                           {"sz", "sigma_z"},
                                                           {"role", "role"},
                                                           {"x_m", "x_m"},
                                                           {"y_m", "y_m"},
                                                           {"z_m", "z_m"},
                                                           {"east_m", "east_m"},
                                                           {"north_m", "north_m"},
                                                           {"height_m", "height_m"}};
  const Table table(text, file, names, "name, x, y, z and optionally sigma (or sigma_x, sigma_y, sigma_z) and role");
  std::set<std::string> seen;
  for (const auto& row : table.rows()) {
    ControlPoint p{table.text(row, "name"),
                   {table.number(row, "x"), table.number(row, "y"), table.number(row, "z")},
                   {nan, nan, nan},
                   false};
    if (table.has("sigma")) p.sigma.setConstant(table.number(row, "sigma"));
    const char* axes[] = {"sigma_x", "sigma_y", "sigma_z"};
    for (int k = 0; k < 3; ++k)
      if (table.has(axes[k])) p.sigma(k) = table.number(row, axes[k]);
    if (table.has("role")) p.check = table.text(row, "role") == "check";
    if (!seen.insert(p.name).second)
      throw std::runtime_error(file + ":" + std::to_string(row.line) + ": point '" + p.name + "' stands in it twice");
    points.push_back(p);
  }
  return points;
}

std::vector<ImagePoint> parse_image_points(const std::string& text, const std::string& file, bool corner_origin) {
  std::vector<ImagePoint> points;
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '{') return from_json(text, file);
  if (const auto lines = gcp_lines(text, file)) {
    for (const auto& g : *lines) points.push_back({g.image, g.name, g.pixel, 0});
  } else {
    static const std::map<std::string, std::string> names = {
        {"image", "image"}, {"photo", "image"}, {"path", "image"},
        {"file", "image"},  {"point", "point"}, {"name", "point"},
        {"id", "point"},    {"label", "point"}, {"x", "x"},
        {"y", "y"},         {"column", "x"},    {"row", "y"},
        {"u", "x"},         {"v", "y"},         {"sigma", "sigma"},
        {"x_px", "x_px"},   {"y_px", "y_px"},   {"sigma_px", "sigma_px"}};
    const Table table(text, file, names, "image, point, x, y and optionally sigma");
    for (const auto& row : table.rows())
      points.push_back({table.text(row, "image"),
                        table.text(row, "point"),
                        {table.number(row, "x"), table.number(row, "y")},
                        table.has("sigma") ? table.number(row, "sigma") : 0});
  }
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
    char line[256];
    std::snprintf(line, sizeof line, "%.6f %.6f %.6f %.4f %.4f ", p->second->position.x(), p->second->position.y(),
                  p->second->position.z(), m.pixel.x(), m.pixel.y());
    text += line + m.image + " " + m.point + "\n";
  }
  return text;
}

}  // namespace plumbline::markers

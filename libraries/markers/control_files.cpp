#include "markers/control_files.hpp"

#include <yaml-cpp/yaml.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <stdexcept>

#include "markers/gcp_list.hpp"
#include "text/csv_table.hpp"

namespace plumbline::markers {
namespace {

class Table {
 public:
  /// `orders`: what the columns of a table without a header are, by their number.
  Table(const std::string& text, const std::string& file, const std::map<std::string, std::string>& names,
        const char* expected, const std::vector<std::vector<std::string>>& orders)
      : file_(file), table_(formats::read_csv(text, names)) {
    if (table_.rows.empty())
      throw std::runtime_error(file + ": found no table; expected a CSV table with the columns " + expected);
    if (!table_.doubtful.empty())
      throw std::runtime_error(file + ":" + std::to_string(table_.doubtful.front().line) +
                               ": found a row that begins with '" + table_.doubtful.front().cells[0].text +
                               "': " + formats::kDoubtfulRow);
    for (size_t i = 0; i < table_.header.size(); ++i) {
      const std::string& name = table_.header[i].name;
      const auto known = names.find(name);
      const std::string& what = known == names.end() ? name : known->second;
      if (!columns_.emplace(what, std::pair{i, factor_of(table_.header[i])}).second && known != names.end())
        throw std::runtime_error(file + ": two columns are '" + what + "'; expected one");
    }
    if (table_.header.empty()) take_order(orders, expected);
    expected_ = expected;
    for (const auto& cell : table_.header)
      if (names.find(cell.name) == names.end() && !is_value(cell.name, names)) unread_.push_back(cell.written);
  }
  /// A column that was not understood and looks like an accuracy must not be dropped: another one would be assumed.
  void refuse_unread_accuracies() const {
    for (const std::string& name : unread_)
      for (const char* start : {"sig", "std", "sd", "s_", "acc", "prec", "rms", "err", "unc", "cov", "var"})
        if (name.rfind(start, 0) == 0)
          throw std::runtime_error(file_ + ": the column '" + name +
                                   "' looks like an accuracy and is none of those known; "
                                   "expected " +
                                   expected_);
  }
  /// Geodesists of German-speaking countries count Y to the east; nearly everybody else X.
  void refuse_german_axes() const {
    bool german = false, axes = false;
    for (const auto& cell : table_.header) {
      axes = axes || cell.written == "x" || cell.written == "y";
      for (const char* start : {"punkt", "hoehe", "h\xC3\xB6he"}) german = german || cell.written.rfind(start, 0) == 0;
    }
    if (german && axes)
      throw std::runtime_error(
          file_ + ":" + std::to_string(table_.header_line) +
          ": found X and Y under German names, where Y is mostly the east; expected columns E and N");
  }
  bool has_header() const { return !table_.header.empty(); }
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
  double factor_of(const formats::CsvHeaderCell& cell) const {
    static const std::map<std::string, double> known = {{"", 1}, {"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"px", 1}};
    const auto found = known.find(cell.unit);
    if (found == known.end())
      throw std::runtime_error(file_ + ": the column '" + cell.name + "' is in '" + cell.unit +
                               "', expected m, cm, mm or px: convert it");
    return found->second;
  }

  /// Columns by their place, where the first row shows that there is no header: it holds numbers.
  void take_order(const std::vector<std::vector<std::string>>& orders, const char* expected) {
    const formats::CsvRow& first = table_.rows.front();
    size_t count = first.cells.size();
    while (count > 0 && first.cells[count - 1].text.empty()) --count;  // "7;1.0;2.0;3.0;"
    const auto is_name = [](const std::string& name) { return name == "name" || name == "image" || name == "point"; };
    for (const auto& order : orders) {
      bool fits = order.size() == count;
      for (size_t i = 0; fits && i < count; ++i) fits = is_name(order[i]) || table_.number(first.cells[i]);
      if (!fits) continue;
      for (size_t i = 0; i < count; ++i) columns_[order[i]] = {i, 1};
      return;
    }
    throw std::runtime_error(file_ + ":" + std::to_string(first.line) + ": found " + std::to_string(count) +
                             " columns and no header; expected one with the columns " + expected);
  }

  static bool is_value(const std::string& name, const std::map<std::string, std::string>& names) {
    return std::any_of(names.begin(), names.end(), [&](const auto& known) { return known.second == name; });
  }

  std::string file_, expected_;
  std::vector<std::string> unread_;
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

namespace {

/// What the columns of control may be called: by axis or by its name in the survey, standard deviations likewise.
/// Also in German, French, Spanish and Italian.
std::map<std::string, std::string> control_columns() {
  std::map<std::string, std::string> names = {
      {"sigma", "sigma"}, {"accuracy", "sigma"}, {"sd", "sigma"}, {"std", "sigma"}};
  for (const char* name :
       {"name",      "id",       "point",   "label",      "ptid",   "pt",      "nr",          "no",
        "number",    "point_id", "pointid", "point_name", "punkt",  "punktnr", "punktnummer", "punktname",
        "matricule", "numero",   "nom",     "punto",      "nombre", "nome"})
    names[name] = "name";
  names["role"] = "role";
  const std::map<std::string, std::vector<std::string>> axes = {
      {"x", {"x", "e", "east", "easting", "rechtswert", "ost", "ostwert", "est", "este"}},
      {"y", {"y", "n", "north", "northing", "hochwert", "nord", "nordwert", "norte"}},
      {"z",
       {"z", "h", "height", "elevation", "elev", "el", "altitude", "alt", "up", "hoehe", "h\xC3\xB6he", "cota", "quota",
        "altura"}}};
  for (const auto& [axis, called] : axes)
    for (const std::string& name : called) {
      names[name] = axis;
      for (const char* sigma : {"sigma", "s", "sd", "std", "stdev", "stddev", "accuracy"}) {
        names[std::string(sigma) + "_" + name] = "sigma_" + axis;
        names[std::string(sigma) + name] = "sigma_" + axis;
      }
    }
  return names;
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
  static const std::map<std::string, std::string> names = control_columns();
  const Table table(text, file, names, "name, x, y, z and optionally sigma (or sigma_x, sigma_y, sigma_z) and role",
                    {{"name", "x", "y", "z"},
                     {"name", "x", "y", "z", "sigma"},
                     {"name", "x", "y", "z", "sigma_x", "sigma_y", "sigma_z"}});
  table.refuse_unread_accuracies();
  table.refuse_german_axes();
  constexpr double kHighest = 20000;  // [m]
  std::set<std::string> seen;
  for (const auto& row : table.rows()) {
    if (!table.has_header() && std::abs(table.number(row, "z")) > kHighest)
      throw std::runtime_error(
          file + ":" + std::to_string(row.line) + ": found the height " + table.text(row, "z") +
          " in a table without a header; expected metres: another column may be in front (a zone), "
          "or these are geocentric coordinates. Name the columns");
    ControlPoint p{table.text(row, "name"),
                   {table.number(row, "x"), table.number(row, "y"), table.number(row, "z")},
                   {nan, nan, nan},
                   false};
    if (p.name.empty())
      throw std::runtime_error(file + ":" + std::to_string(row.line) + ": found no name, expected that of a point");
    if (table.has("sigma")) p.sigma.setConstant(table.number(row, "sigma"));
    const char* axes[] = {"sigma_x", "sigma_y", "sigma_z"};
    for (int k = 0; k < 3; ++k)
      if (table.has(axes[k])) p.sigma(k) = table.number(row, axes[k]);
    if (table.has("role")) {
      const std::string role = formats::to_lower(table.text(row, "role"));
      p.check = role == "check";
      if (!role.empty() && role != "check" && role != "control")
        throw std::runtime_error(file + ":" + std::to_string(row.line) + ": 'role' is '" + role +
                                 "', expected control or check");
    }
    const int given = table.has("sigma_x") + table.has("sigma_y") + table.has("sigma_z");
    if (given != 0 && given != 3 && !table.has("sigma"))
      throw std::runtime_error(file +
                               ": standard deviations are given for some of x, y and z only; expected sigma, or "
                               "sigma_x, sigma_y and sigma_z");
    if (p.sigma.minCoeff() < 0)
      throw std::runtime_error(file + ":" + std::to_string(row.line) + ": point '" + p.name +
                               "' has a negative standard deviation");
    if (!seen.insert(p.name).second)
      throw std::runtime_error(file + ":" + std::to_string(row.line) + ": point '" + p.name + "' stands in it twice");
    points.push_back(p);
  }
  return points;
}

bool says_which_is_east(const std::string& text, const std::string& file) {
  if (gcp_lines(text, file)) return true;
  static const std::map<std::string, std::string> names = control_columns();
  const formats::CsvTable table = formats::read_csv(text, names);
  return std::any_of(table.header.begin(), table.header.end(), [](const auto& cell) {
    return (cell.name == "x" || cell.name == "y") && cell.written != "x" && cell.written != "y";
  });
}

std::vector<ImagePoint> parse_image_points(const std::string& text, const std::string& file, bool corner_origin) {
  std::vector<ImagePoint> points;
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first != std::string::npos && text[first] == '{') return from_json(text, file);
  if (const auto lines = gcp_lines(text, file)) {
    for (const auto& g : *lines) points.push_back({g.image, g.name, g.pixel, 0});
  } else {
    static const std::map<std::string, std::string> names = {
        {"image", "image"}, {"photo", "image"}, {"path", "image"},  {"file", "image"}, {"point", "point"},
        {"name", "point"},  {"id", "point"},    {"label", "point"}, {"x", "x"},        {"y", "y"},
        {"column", "x"},    {"row", "y"},       {"u", "x"},         {"v", "y"},        {"sigma", "sigma"}};
    const Table table(text, file, names, "image, point, x, y and optionally sigma",
                      {{"image", "point", "x", "y"}, {"image", "point", "x", "y", "sigma"}});
    for (const auto& row : table.rows()) {
      points.push_back({table.text(row, "image"),
                        table.text(row, "point"),
                        {table.number(row, "x"), table.number(row, "y")},
                        table.has("sigma") ? table.number(row, "sigma") : 0});
      if (points.back().sigma < 0)
        throw std::runtime_error(file + ":" + std::to_string(row.line) + ": point '" + points.back().point +
                                 "' has a negative standard deviation");
    }
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

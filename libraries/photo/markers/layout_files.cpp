#include "photo/markers/layout_files.hpp"

#include <yaml-cpp/yaml.h>

#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "base/text/csv_table.hpp"
#include "base/text/one_document.hpp"

namespace plumbline::markers {
namespace {

[[noreturn]] void refuse(const std::string& file, const std::string& what) {
  throw std::runtime_error(file + ": " + what +
                           ". A layout is WPILib's field JSON, our tags.json, an ArUco marker map, or a CSV table with "
                           "the columns tag_id, x_m, y_m, z_m and a rotation (qw, qx, qy, qz or facing_azimuth_deg)");
}

double number_of(const YAML::Node& node, const std::string& file, const std::string& what) {
  try {
    const double value = node.as<double>();
    if (std::isfinite(value)) return value;
  } catch (const YAML::Exception&) {
  }
  refuse(file, what + " is missing or no number");
}

int tag_id(double value, const std::string& file, const std::string& where) {
  if (!(value >= 0 && value < 1e9) || value != std::floor(value))
    refuse(file, where + "the id of a tag is a whole number, not negative");
  return static_cast<int>(value);
}

Eigen::Vector3d vector_of(const YAML::Node& list, const std::string& file, const std::string& what) {
  if (!list || !list.IsSequence() || list.size() != 3) refuse(file, what + " does not have three coordinates");
  return {number_of(list[0], file, what), number_of(list[1], file, what), number_of(list[2], file, what)};
}

/// WPILib: x out of the face, y to the left of it as one looks along x, z up.
Eigen::Quaterniond from_wpilib(const Eigen::Quaterniond& world_from_face) {
  const Eigen::Matrix3d r = world_from_face.normalized().toRotationMatrix();
  Eigen::Matrix3d tag;
  tag << r.col(1), r.col(2), r.col(0);
  return Eigen::Quaterniond(tag);
}

LayoutTag wpilib_tag(const YAML::Node& entry, const std::string& file) {
  LayoutTag tag;
  tag.id = tag_id(number_of(entry["ID"], file, "ID of a tag"), file, "");
  const std::string of = " of tag " + std::to_string(tag.id);
  const YAML::Node at = entry["pose"]["translation"], q = entry["pose"]["rotation"]["quaternion"];
  if (!at || !q) refuse(file, "tag " + std::to_string(tag.id) + " has no pose with translation and quaternion");
  tag.world_from_tag.translation = {number_of(at["x"], file, "x" + of), number_of(at["y"], file, "y" + of),
                                    number_of(at["z"], file, "z" + of)};
  const Eigen::Quaterniond rotation(number_of(q["W"], file, "W" + of), number_of(q["X"], file, "X" + of),
                                    number_of(q["Y"], file, "Y" + of), number_of(q["Z"], file, "Z" + of));
  if (!(rotation.norm() > 0.5)) refuse(file, "the quaternion" + of + " is not a rotation");
  tag.world_from_tag.rotation = from_wpilib(rotation);
  return tag;
}

LayoutTag our_tag(const YAML::Node& entry, const std::string& file) {
  LayoutTag tag;
  tag.id = tag_id(number_of(entry["id"], file, "id of a tag"), file, "");
  const std::string of = " of tag " + std::to_string(tag.id);
  if (entry["family"]) tag.family = entry["family"].as<std::string>("");
  if (entry["size"]) tag.size = number_of(entry["size"], file, "size" + of);
  tag.world_from_tag.translation = vector_of(entry["centre"], file, "centre" + of);
  const YAML::Node q = entry["rotation"];
  if (!q || q.size() != 4) refuse(file, "rotation" + of + " is no quaternion");
  tag.world_from_tag.rotation = Eigen::Quaterniond(number_of(q[0], file, "rotation"), number_of(q[1], file, "rotation"),
                                                   number_of(q[2], file, "rotation"), number_of(q[3], file, "rotation"))
                                    .normalized();
  return tag;
}

/// Four corners, clockwise from the top left.
LayoutTag map_tag(const YAML::Node& entry, double unit, const std::string& file) {
  LayoutTag tag;
  tag.id = tag_id(number_of(entry["id"], file, "id of a marker"), file, "");
  const YAML::Node list = entry["corners"];
  if (!list || list.size() != 4) refuse(file, "marker " + std::to_string(tag.id) + " does not have four corners");
  std::array<Eigen::Vector3d, 4> c;
  for (size_t i = 0; i < 4; ++i) c[i] = unit * vector_of(list[i], file, "a corner of marker " + std::to_string(tag.id));
  const Eigen::Vector3d x = (c[1] - c[0] + c[2] - c[3]).normalized();
  Eigen::Vector3d y = c[0] - c[3] + c[1] - c[2];
  tag.size = 0.25 * ((c[1] - c[0]).norm() + (c[2] - c[1]).norm() + (c[3] - c[2]).norm() + (c[0] - c[3]).norm());
  y = (y - y.dot(x) * x).normalized();
  Eigen::Matrix3d r;
  r << x, y, x.cross(y);
  tag.world_from_tag = {Eigen::Quaterniond(r), 0.25 * (c[0] + c[1] + c[2] + c[3])};
  return tag;
}

std::vector<LayoutTag> parse_tree(const std::string& text, const std::string& file) {
  std::string body = text;
  if (body.rfind("%YAML", 0) == 0) body.erase(0, std::min(body.find('\n'), body.size()));
  YAML::Node root;
  try {
    root = text::load_one_document(body);
  } catch (const YAML::Exception& error) {
    refuse(file, "neither JSON nor YAML (line " + std::to_string(error.mark.line + 1) + ": " + error.msg + ")");
  }
  std::vector<LayoutTag> tags;
  if (!root.IsMap()) refuse(file, "holds no keys");
  if (const YAML::Node markers = root["aruco_bc_markers"]) {
    const double unit = root["aruco_bc_mInfoType"] && root["aruco_bc_mInfoType"].as<int>(1) == 0 ? std::nan("") : 1.0;
    if (!(unit > 0)) refuse(file, "the marker map is in pixels, not in metres");
    for (const auto& entry : markers) tags.push_back(map_tag(entry, unit, file));
  } else if (const YAML::Node field = root["field-tags"] ? root["field-tags"] : root["tags"]) {
    for (const auto& entry : field) tags.push_back(entry["ID"] ? wpilib_tag(entry, file) : our_tag(entry, file));
  } else {
    refuse(file, "there is neither 'tags' nor 'aruco_bc_markers' in it");
  }
  return tags;
}

const std::map<std::string, std::string>& csv_names() {
  static const std::map<std::string, std::string> names = [] {
    std::map<std::string, std::string> m = {{"id", "tag_id"},         {"tag", "tag_id"},
                                            {"marker", "tag_id"},     {"size", "tag_size"},
                                            {"family", "tag_family"}, {"azimuth", "facing_azimuth"}};
    for (const char* base : {"tag_id", "tag_family", "tag_size", "x", "y", "z", "tag_x", "tag_y", "tag_z", "qw", "qx",
                             "qy", "qz", "facing_azimuth"})
      for (const char* unit : {"", "_m", "_mm", "_cm", "_in", "_ft", "_deg", "_gon", "_rad"})
        m[std::string(base) + unit] = std::string(base) + unit;
    return m;
  }();
  return names;
}

class CsvLayout {
 public:
  CsvLayout(const std::string& text, const std::string& file) : file_(file), table_(text::read_csv(text, csv_names())) {
    if (table_.header.empty()) refuse(file, "found no header line");
    for (size_t i = 0; i < table_.header.size(); ++i) {
      std::string name = table_.header[i].name, unit = table_.header[i].unit;
      for (const char* suffix : {"m", "mm", "cm", "in", "ft", "deg", "gon", "rad"}) {
        const std::string ending = std::string("_") + suffix;
        if (name.size() > ending.size() && name.ends_with(ending))
          name.resize(name.size() - ending.size()), unit = suffix;
      }
      column_[name] = {i, unit};
      check_unit(name, unit);
    }
    for (const char* name : {"tag_id", "x", "y", "z"})
      if (!column_.count(name)) refuse(file, std::string("the column '") + name + "' is missing");
    rotated_ = column_.count("qw") && column_.count("qx") && column_.count("qy") && column_.count("qz");
    if (!rotated_ && !column_.count("facing_azimuth")) refuse(file, "no column tells how the tags are turned");
  }

  std::vector<LayoutTag> tags() const {
    std::vector<LayoutTag> result;
    for (const auto& row : table_.rows) {
      LayoutTag tag;
      tag.id = tag_id(value(row, "tag_id", 0), file_, "line " + std::to_string(row.line) + ": ");
      if (column_.count("tag_family")) tag.family = cell(row, "tag_family");
      tag.size = value(row, "tag_size", 0);
      Eigen::Quaterniond q;
      if (rotated_) {
        q = Eigen::Quaterniond(value(row, "qw", 0), value(row, "qx", 0), value(row, "qy", 0), value(row, "qz", 0));
        if (!(q.norm() > 0.5)) refuse(file_, "line " + std::to_string(row.line) + ": qw, qx, qy, qz are no rotation");
        q.normalize();
      } else {
        const double azimuth = value(row, "facing_azimuth", 0);
        Eigen::Matrix3d r;
        const Eigen::Vector3d normal(std::sin(azimuth), std::cos(azimuth), 0), up(0, 0, 1);
        r << up.cross(normal), up, normal;
        q = Eigen::Quaterniond(r);
      }
      const Eigen::Vector3d offset(value(row, "tag_x", 0), value(row, "tag_y", 0), value(row, "tag_z", 0));
      tag.world_from_tag = {q,
                            Eigen::Vector3d(value(row, "x", 0), value(row, "y", 0), value(row, "z", 0)) + q * offset};
      result.push_back(tag);
    }
    return result;
  }

 private:
  struct Column {
    size_t index = 0;
    std::string unit;
  };
  std::string cell(const text::CsvRow& row, const std::string& name) const {
    const auto found = column_.find(name);
    return found == column_.end() || found->second.index >= row.cells.size() ? "" : row.cells[found->second.index].text;
  }
  /// In metres or radians.
  double value(const text::CsvRow& row, const std::string& name, double fallback) const {
    const auto found = column_.find(name);
    if (found == column_.end()) return fallback;
    const std::string where = "line " + std::to_string(row.line) + ": column '" + name + "'";
    if (found->second.index >= row.cells.size()) refuse(file_, where + " is missing");
    const auto number = table_.number(row.cells[found->second.index]);
    if (!number) refuse(file_, where + " holds '" + row.cells[found->second.index].text + "', expected a number");
    const std::string& unit = found->second.unit;
    if (const auto length = lengths().find(unit); length != lengths().end()) return length->second * *number;
    if (unit == "gon") return *number * std::numbers::pi / 200;
    if (unit == "deg" || (unit.empty() && name == "facing_azimuth")) return *number * std::numbers::pi / 180;
    return *number;
  }
  /// In metres; feet are international ones.
  static const std::map<std::string, double>& lengths() {
    static const std::map<std::string, double> units = {
        {"m", 1}, {"mm", 1e-3}, {"cm", 1e-2}, {"in", 0.0254}, {"ft", 0.3048}};
    return units;
  }
  /// A number whose unit nobody knows would be taken as it stands.
  void check_unit(const std::string& name, const std::string& unit) const {
    static const std::set<std::string> of_length = {"x", "y", "z", "tag_x", "tag_y", "tag_z", "tag_size"};
    const bool length = of_length.count(name) != 0, angle = name == "facing_azimuth";
    if (unit.empty() || (!length && !angle)) return;
    if (length ? lengths().count(unit) != 0 : unit == "deg" || unit == "gon" || unit == "rad") return;
    refuse(file_, "column '" + name + "' is in '" + unit + "', expected " +
                      (length ? "m, mm, cm, in or ft" : "deg, gon or rad"));
  }

  std::string file_;
  text::CsvTable table_;
  std::map<std::string, Column> column_;
  bool rotated_ = false;
};

}  // namespace

std::vector<LayoutTag> parse_layout(const std::string& text, const std::string& file) {
  const size_t first = text.find_first_not_of(" \t\r\n\xef\xbb\xbf");
  if (first == std::string::npos) refuse(file, "the file is empty");
  const bool tree = text[first] == '{' || text[first] == '%' || text.find("aruco_bc_markers") != std::string::npos;
  const std::vector<LayoutTag> tags = tree ? parse_tree(text.substr(first), file) : CsvLayout(text, file).tags();
  if (tags.empty()) refuse(file, "there is no tag in it");
  std::set<std::pair<std::string, int>> seen;
  for (const LayoutTag& tag : tags) {
    if (!seen.insert({tag.family, tag.id}).second)
      refuse(file, "tag " + std::to_string(tag.id) + " stands in it twice; every id may be there once");
    if (tag.size < 0) refuse(file, "tag " + std::to_string(tag.id) + " has a negative size");
  }
  return tags;
}

}  // namespace plumbline::markers

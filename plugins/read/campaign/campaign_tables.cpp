// The two tables of a campaign: plates and control points.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <sstream>
#include <string_view>
#include <tuple>

#include "base/text/csv_table.hpp"
#include "campaign_folder.hpp"
#include "campaign_yaml.hpp"
#include "control/points/control_files.hpp"

namespace plumbline::campaign {
namespace {

using text::CsvCell;
using text::CsvRow;
using text::CsvTable;

/// What a column holds.
enum class Quantity { text, whole, length, angle, pixels };

struct ColumnRule {
  const char* name;
  Quantity quantity;
  bool required;
};

const char* example_of(Quantity quantity) {
  return quantity == Quantity::length   ? "_m or _mm"
         : quantity == Quantity::angle  ? "_deg, _gon or _rad"
         : quantity == Quantity::pixels ? "_px"
                                        : "";
}

/// A row that begins with '#' and looks like data may be a name or commented out: nobody guesses which.
void refuse_doubtful(const CsvTable& table, const std::filesystem::path& shown) {
  if (table.doubtful.empty()) return;
  throw CampaignError(shown, table.doubtful.front().line,
                      std::string("found a row that begins with '") + table.doubtful.front().cells[0].text +
                          "': " + text::kDoubtfulRow);
}

/// Reads cells by column name; every error names file, line and column.
class Table {
 public:
  /// With `warnings`, columns that the table does not have are left out, and said there.
  Table(const std::string& csv, const std::filesystem::path& shown, std::vector<ColumnRule> rules,
        std::vector<std::string>* warnings = nullptr)
      : shown_(shown), rules_(std::move(rules)) {
    std::map<std::string, std::string> known = plate_column_names();
    std::erase_if(known, [&](const auto& entry) {
      return std::none_of(rules_.begin(), rules_.end(), [&](const auto& rule) { return entry.second == rule.name; });
    });
    for (const ColumnRule& rule : rules_) known[rule.name] = rule.name;
    // What is left out has to be said.
    table_ = text::read_csv(csv, known, warnings ? text::TitleRows::passed_over : text::TitleRows::refused);
    if (table_.titles > 0)
      warnings->push_back(shown_.filename().string() + ": " + text::titles_left_out(table_.titles));
    if (table_.header.empty()) {
      throw CampaignError(shown, 1, "found no header line, expected the columns " + names());
    }
    check_header(warnings);
    refuse_doubtful(table_, shown);
    if (table_.rows.empty()) throw CampaignError(shown, table_.header_line, "found a header and no row under it");
  }

  const std::vector<CsvRow>& rows() const { return table_.rows; }
  bool has(const char* name) const { return column_.count(name) > 0; }
  [[noreturn]] void fail(const CsvRow& row, const std::string& what) const {
    throw CampaignError(shown_, row.line, what);
  }

  std::string text(const CsvRow& row, const char* name) const {
    const CsvCell* cell = find(row, name);
    if (!cell) return "";
    if (cell->text.empty() && rule_of(name).required) fail(row, std::string("column '") + name + "' is empty");
    return cell->text;
  }
  int whole(const CsvRow& row, const char* name) const {
    const CsvCell* cell = find(row, name);
    if (!cell || (cell->text.empty() && !rule_of(name).required)) return 0;
    const auto value = text::parse_integer(cell->text);
    if (value && *value < 0 && std::string_view(name) == "floor")
      refuse(row, name, *cell, "a number from 0 on: floors are counted from the lowest, basements too");
    if (!value || *value < 0 || *value > 1000000) refuse(row, name, *cell, "a whole number from 0 to 1000000");
    return static_cast<int>(*value);
  }
  /// In m or rad.
  double number(const CsvRow& row, const char* name) const {
    const CsvCell* cell = find(row, name);
    if (!cell) return 0;
    const auto value = table_.number(*cell);
    if (!value) refuse(row, name, *cell, "a number");
    return *value * factor_.at(name);
  }

 private:
  std::string names() const {
    std::string all;
    for (const ColumnRule& rule : rules_) {
      all += (all.empty() ? "" : ", ") + std::string(rule.name);
      if (*example_of(rule.quantity))
        all += std::string("_") + (rule.quantity == Quantity::angle    ? "deg"
                                   : rule.quantity == Quantity::pixels ? "px"
                                                                       : "m");
    }
    return all;
  }
  const ColumnRule& rule_of(const std::string& name) const {
    return *std::find_if(rules_.begin(), rules_.end(), [&](const ColumnRule& r) { return name == r.name; });
  }

  bool is_empty_column(std::size_t i) const {
    return table_.header[i].name.empty() && std::all_of(table_.rows.begin(), table_.rows.end(), [&](const CsvRow& row) {
             return i >= row.cells.size() || row.cells[i].text.empty();
           });
  }

  /// A note of the user's own; a name that is nearly one of the table's was meant to be that.
  void leave_out(const std::string& name, std::vector<std::string>* warnings) const {
    std::vector<std::string> known;
    for (const ColumnRule& rule : rules_)
      if (!column_.count(rule.name)) known.push_back(rule.name);
    const std::string near = name.size() > 3 ? near_name(name, known) : "";
    if (!warnings || !near.empty())
      throw CampaignError(shown_, table_.header_line,
                          "unknown column '" + name + "'" +
                              (near.empty() ? "; known are " + names() : ", did you mean '" + near + "'?"));
    warnings->push_back(shown_.filename().string() + ":" + std::to_string(table_.header_line) +
                        (name.empty() ? ": a column without a name" : ": the column '" + name + "'") +
                        " is none of this table's, and is left out");
  }

  void check_header(std::vector<std::string>* warnings) {
    for (std::size_t i = 0; i < table_.header.size(); ++i) {
      const std::string &name = table_.header[i].name, &unit = table_.header[i].unit;
      const auto rule = std::find_if(rules_.begin(), rules_.end(), [&](const ColumnRule& r) { return name == r.name; });
      if (rule == rules_.end()) {
        if (!is_empty_column(i)) leave_out(name, warnings);  // spreadsheets end lines with delimiters
        continue;
      }
      if (!column_.emplace(name, i).second) {
        throw CampaignError(shown_, table_.header_line, "the column '" + name + "' stands here a second time");
      }
      factor_[name] = factor(*rule, unit);
    }
    for (const ColumnRule& rule : rules_) {
      if (rule.required && !column_.count(rule.name)) {
        throw CampaignError(shown_, table_.header_line, std::string("the column '") + rule.name + "' is missing");
      }
    }
  }

  double factor(const ColumnRule& rule, const std::string& unit) const {
    static const std::map<std::string, double> lengths = {{"m", 1}, {"mm", 1e-3}};
    static const std::map<std::string, double> angles = {
        {"deg", std::numbers::pi / 180}, {"gon", std::numbers::pi / 200}, {"rad", 1}};
    static const std::map<std::string, double> pixels = {{"px", 1}};
    if (rule.quantity == Quantity::text || rule.quantity == Quantity::whole) return 1;
    const auto& units = rule.quantity == Quantity::length   ? lengths
                        : rule.quantity == Quantity::pixels ? pixels
                                                            : angles;
    const auto found = units.find(unit);
    if (found != units.end()) return found->second;
    throw CampaignError(shown_, table_.header_line,
                        std::string("column '") + rule.name + "' " +
                            (unit.empty() ? "has no unit" : "is in '" + unit + "'") + ", expected its name to end in " +
                            example_of(rule.quantity));
  }

  const CsvCell* find(const CsvRow& row, const char* name) const {
    const auto column = column_.find(name);
    if (column == column_.end()) return nullptr;
    if (column->second >= row.cells.size()) {
      fail(row, "found " + std::to_string(row.cells.size()) + " cells, expected " +
                    std::to_string(table_.header.size()) + "; '" + name + "' is missing");
    }
    return &row.cells[column->second];
  }
  [[noreturn]] void refuse(const CsvRow& row, const char* name, const CsvCell& cell, const char* expected) const {
    fail(row, "column '" + std::string(name) + "' holds '" + cell.text + "', expected " + expected);
  }

  std::filesystem::path shown_;
  std::vector<ColumnRule> rules_;
  CsvTable table_;
  std::map<std::string, std::size_t> column_;
  std::map<std::string, double> factor_;
};

constexpr double kAssumedSigma = 1e-3;  // [m], of control without standard deviations; said in a warning

/// "control" or "check"; German surveyors hold a model by Passpunkte and judge it by Kontrollpunkte.
std::string role_of(const std::string& text) {
  const std::string word = text::to_lower(text);
  return word == "passpunkt" ? "control" : word == "kontrollpunkt" ? "check" : word;
}

}  // namespace

std::vector<PlateEntry> parse_plates(const std::string& csv, const std::filesystem::path& shown, CampaignUse use,
                                     std::vector<std::string>* warnings) {
  const bool needed = use != CampaignUse::photographs, tagged = use != CampaignUse::measured;
  const bool site = needed && tagged, roles = site && use != CampaignUse::alone;
  const Table table(csv, shown,
                    {{"anchor", Quantity::text, true},
                     {"role", Quantity::text, roles},
                     {"floor", Quantity::whole, needed},
                     {"column", Quantity::whole, false},
                     {"row", Quantity::whole, false},
                     {"tag_family", Quantity::text, tagged},
                     {"tag_id", Quantity::whole, tagged},
                     {"tag_size", Quantity::length, site},
                     {"tag_x", Quantity::length, site},
                     {"tag_y", Quantity::length, site},
                     {"tag_z", Quantity::length, site},
                     {"facing_azimuth", Quantity::angle, site},
                     {"mounting_x", Quantity::length, false},
                     {"mounting_y", Quantity::length, false},
                     {"mounting_z", Quantity::length, false},
                     {"batch", Quantity::text, false}},
                    warnings);
  std::vector<PlateEntry> plates;
  std::set<std::string> anchors;
  std::set<std::pair<std::string, int>> tags;
  const auto read = [&](const CsvRow& row) {
    PlateEntry p;
    p.anchor = table.text(row, "anchor");
    p.role = role_of(table.text(row, "role"));
    if (p.role.empty() && !roles) p.role = "control";
    p.floor = needed || table.has("floor") ? table.whole(row, "floor") : 1;
    p.column = table.whole(row, "column");
    p.row = table.whole(row, "row");
    p.tag_family = table.text(row, "tag_family");
    p.tag_id = table.whole(row, "tag_id");
    p.tag_size = site || table.has("tag_size") ? table.number(row, "tag_size") : std::nan("");
    p.tag_centre_in_plate = {table.number(row, "tag_x"), table.number(row, "tag_y"), table.number(row, "tag_z")};
    // Without one nothing is said of where it faces: north would be a lie.
    p.facing_azimuth = tagged || table.has("facing_azimuth") ? table.number(row, "facing_azimuth") : std::nan("");
    p.batch = table.text(row, "batch");
    const bool mounted[] = {table.has("mounting_x"), table.has("mounting_y"), table.has("mounting_z")};
    if (mounted[0] || mounted[1] || mounted[2]) {
      if (!(mounted[0] && mounted[1] && mounted[2]))
        table.fail(row, "found some of the columns mounting_x, mounting_y and mounting_z, expected all three or none");
      p.mounting_sigma = {table.number(row, "mounting_x"), table.number(row, "mounting_y"),
                          table.number(row, "mounting_z")};
      if (!(p.mounting_sigma.minCoeff() >= 0 && p.mounting_sigma.maxCoeff() <= 0.1))
        table.fail(row, "a standard deviation of the mounting is not from 0 to 100 mm");
    }
    if (p.role != "control" && p.role != "check") {
      table.fail(row, "column 'role' holds '" + p.role + "', expected control or check");
    }
    if (!(p.tag_size > 0) && !std::isnan(p.tag_size)) table.fail(row, "the tag size must be positive");
    if (!anchors.insert(p.anchor).second) table.fail(row, "anchor '" + p.anchor + "' has a plate already");
    if (!p.tag_family.empty() && !tags.insert({p.tag_family, p.tag_id}).second) {
      table.fail(row, "tag " + std::to_string(p.tag_id) + " of " + p.tag_family + " hangs at another anchor already");
    }
    plates.push_back(std::move(p));
  };
  Problems problems;
  for (const CsvRow& row : table.rows()) problems.attempt([&] { read(row); });
  problems.raise();
  std::sort(plates.begin(), plates.end(), [](const auto& a, const auto& b) { return a.anchor < b.anchor; });
  return plates;
}

std::vector<ControlPoint> parse_control(const std::string& csv, const std::filesystem::path& shown,
                                        std::vector<std::string>* warnings) {
  control::ControlTable table;
  try {
    table = control::parse_control(csv, shown.string());
  } catch (const std::runtime_error& error) {
    throw CampaignError(error.what());
  }
  if (!table.has_sigmas)
    table.warnings.push_back(
        "no standard deviations: 1 mm in E, N and H is assumed; say better with sigma_e_mm, sigma_n_mm, sigma_h_mm");
  Problems problems;
  const auto hold = [&](ControlPoint& p) {
    // Which points are withheld is said of anchors, not here: a 'check' that nobody heeds would be taken for evidence.
    if (p.check)
      throw CampaignError(shown, 0,
                          "'" + p.name +
                              "' has the role 'check', which a table of control does not heed: points are withheld by "
                              "their row in plates.csv (anchor,role,tag_family,tag_id)");
    if (!table.has_sigmas) p.sigma.setConstant(kAssumedSigma);
    for (int k = 0; k < 3; ++k)
      if (!std::isnan(p.position(k)) && !(p.sigma(k) > 0))
        throw CampaignError(shown, 0, "'" + p.name + "' lacks a standard deviation above zero for E, N or H");
  };
  for (ControlPoint& p : table.points) problems.attempt([&] { hold(p); });
  problems.raise();
  if (warnings) {
    *warnings = table.warnings;
    if (!table.axes.empty()) warnings->push_back(table.axes);
    warnings->insert(warnings->end(), table.notes.begin(), table.notes.end());
  }
  return table.points;
}

std::vector<TrueCamera> parse_true_cameras(const std::string& csv, const std::filesystem::path& shown) {
  std::istringstream lines(csv);
  std::string line;
  if (!std::getline(lines, line) || line != "image,w,x,y,z,tx_m,ty_m,tz_m")
    throw std::runtime_error(shown.string() + ":1: found '" + line + "', expected image,w,x,y,z,tx_m,ty_m,tz_m");
  std::vector<TrueCamera> cameras;
  for (int number = 2; std::getline(lines, line); ++number) {
    TrueCamera camera;
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream cells(line);
    Eigen::Quaterniond& q = camera.camera_from_building.rotation;
    Eigen::Vector3d& t = camera.camera_from_building.translation;
    if (!(cells >> camera.image >> q.w() >> q.x() >> q.y() >> q.z() >> t.x() >> t.y() >> t.z()))
      throw std::runtime_error(shown.string() + ":" + std::to_string(number) +
                               ": expected the name of an image and seven numbers");
    const double length = q.norm();
    if (!(std::abs(length - 1) < 1e-3) || !t.allFinite())
      throw std::runtime_error(shown.string() + ":" + std::to_string(number) +
                               (t.allFinite()
                                    ? ": the rotation of '" + camera.image + "' is a quaternion w,x,y,z of length " +
                                          std::to_string(length) + ", expected 1"
                                    : ": the translation of '" + camera.image + "' is not finite"));
    q.normalize();
    cameras.push_back(camera);
  }
  return cameras;
}

std::vector<TrueAnchor> parse_true_anchors(const std::string& csv, const std::filesystem::path& shown) {
  const Table table(csv, shown,
                    {{"anchor", Quantity::text, true},
                     {"role", Quantity::text, true},
                     {"floor", Quantity::whole, false},
                     {"column", Quantity::whole, false},
                     {"row", Quantity::whole, false},
                     {"design_x", Quantity::length, false},
                     {"design_y", Quantity::length, false},
                     {"design_z", Quantity::length, false},
                     {"x", Quantity::length, true},
                     {"y", Quantity::length, true},
                     {"z", Quantity::length, true},
                     {"rotation_w", Quantity::text, false},
                     {"rotation_x", Quantity::text, false},
                     {"rotation_y", Quantity::text, false},
                     {"rotation_z", Quantity::text, false}});
  std::vector<TrueAnchor> anchors;
  for (const CsvRow& row : table.rows()) {
    anchors.push_back({table.text(row, "anchor"),
                       table.text(row, "role"),
                       {table.number(row, "x"), table.number(row, "y"), table.number(row, "z")}});
  }
  return anchors;
}

std::vector<ObservedTag> parse_observations(const std::string& csv, const std::filesystem::path& shown,
                                            const std::function<const BrownCamera&(const std::string&)>& camera_of) {
  static constexpr std::array<const char*, 8> coordinates = {"x0", "y0", "x1", "y1", "x2", "y2", "x3", "y3"};
  std::vector<ColumnRule> rules = {{"image", Quantity::text, true},
                                   {"family", Quantity::text, true},
                                   {"tag_id", Quantity::whole, true},
                                   {"sigma", Quantity::pixels, true}};
  for (const char* name : coordinates) rules.push_back({name, Quantity::pixels, true});
  const Table table(csv, shown, rules);
  std::vector<ObservedTag> tags;
  std::set<std::tuple<std::string, std::string, int>> seen;
  for (const CsvRow& row : table.rows()) {
    ObservedTag tag;
    tag.image = table.text(row, "image"), tag.family = table.text(row, "family"), tag.id = table.whole(row, "tag_id");
    tag.sigma = table.number(row, "sigma");
    for (std::size_t k = 0; k < 8; ++k)
      tag.corners[k / 2][static_cast<Eigen::Index>(k % 2)] = table.number(row, coordinates[k]);
    const BrownCamera* camera = nullptr;
    try {
      camera = &camera_of(tag.image);
    } catch (const std::runtime_error& error) {
      table.fail(row, "image '" + tag.image + "' " + error.what());
    }
    for (const Eigen::Vector2d& corner : tag.corners)
      if (!(corner.x() > -0.5 && corner.x() < camera->width - 0.5 && corner.y() > -0.5 &&
            corner.y() < camera->height - 0.5))
        table.fail(row, "a corner lies outside of the camera's " + std::to_string(camera->width) + " x " +
                            std::to_string(camera->height) + " pixels");
    if (!(tag.sigma > 0)) table.fail(row, "'sigma' is not above zero");
    if (!seen.insert({tag.image, tag.family, tag.id}).second)
      table.fail(row, "tag " + std::to_string(tag.id) + " stands here a second time in image '" + tag.image + "'");
    tags.push_back(tag);
  }
  std::stable_sort(tags.begin(), tags.end(), [](const ObservedTag& a, const ObservedTag& b) {
    return std::tie(a.image, a.family, a.id) < std::tie(b.image, b.family, b.id);
  });
  return tags;
}

}  // namespace plumbline::campaign

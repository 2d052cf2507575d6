#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "base/text/text.hpp"
#include "survey/files/field_books.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

/// Cells of "500197, "2000", 1, 3.20, ... ;", without quotes.
std::vector<std::string> cells_of(std::string_view line) {
  line = text::trim(line);
  if (line.ends_with(';')) line.remove_suffix(1);
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  for (std::string& cell : cells) cell = std::string(text::trim(cell));
  return cells;
}

class IdxReader {
 public:
  IdxReader(std::string_view bytes, const std::string& file)
      : decoded_(text::decode_text(bytes)), builder_(file, "idx") {}
  SurveyObservations read();

 private:
  enum class Table { none, points, slope, other };
  void read_line(std::string_view text);
  void begin_table(std::string_view text);
  void read_units(std::string_view key, std::string_view value);
  void read_point();
  void read_slope();
  std::string text(const char* column) const;
  double number(const char* column);
  double angle(const char* column);

  text::DecodedText decoded_;
  SurveyBuilder builder_;
  int line_ = 0;
  Table table_ = Table::none;
  std::map<std::string, std::size_t> columns_;
  std::vector<std::string> cells_;
  bool gon_ = false, degrees_ = false, in_set_up_ = false;
  double metres_ = 1, instrument_height_ = kNotGiven;
  std::string station_;
  std::size_t rows_ = 0;
};

std::string IdxReader::text(const char* column) const {
  const auto at = columns_.find(column);
  return at == columns_.end() || at->second >= cells_.size() ? std::string() : cells_[at->second];
}

double IdxReader::number(const char* column) {
  const std::string cell = text(column);
  if (cell.empty()) return kNotGiven;
  if (const auto value = text::parse_number(cell)) return *value;
  builder_.skip(line_, 1, cell, std::string("a number in column ") + column);
  return kNotGiven;
}

double IdxReader::angle(const char* column) {
  const double value = number(column);
  if (std::isnan(value)) return kNotGiven;
  if (std::abs(value) < 1000) {
    if (gon_) return gon_to_rad(value);
    if (degrees_) return degrees_to_rad(value);
    if (const auto packed = packed_degrees_to_rad(value)) return *packed;
  }
  builder_.skip(line_, 1, text(column), gon_ ? "an angle in gon" : "an angle D.MMSS");
  return kNotGiven;
}

void IdxReader::read_units(std::string_view key, std::string_view value) {
  const std::string unit = text::to_lower(value);
  if (key == "ANGULAR") {
    gon_ = unit.starts_with("gon") || unit.starts_with("grad");
    degrees_ = unit.starts_with("dec") || unit.starts_with("deg");
    builder_.survey.info.angles_in_degrees = !gon_;
    if (!gon_ && !degrees_ && unit != "dms") builder_.skip(line_, 1, value, "the angular unit DMS, GON or DEC");
  } else if (key == "LINEAR") {
    const bool metric = unit == "m" || unit.starts_with("met");
    if (!metric && unit.find('f') == std::string::npos) builder_.skip(line_, 1, value, "the linear unit METER or FEET");
    metres_ = metric ? 1.0 : unit.find("us") != std::string::npos ? kUsSurveyFoot : kFoot;
  }
}

// "SLOPE(TgtNo, TgtID, CfgNo, Hz, Vz, SDist, RefHt, ...)": the table names its columns.
void IdxReader::begin_table(std::string_view text) {
  const std::size_t open = text.find('(');
  const std::string_view name = text::trim(text.substr(0, open));
  table_ = name == "POINTS" ? Table::points : name == "SLOPE" ? Table::slope : Table::other;
  columns_.clear();
  const std::size_t close = text.find(')', open);
  std::size_t index = 0;
  for (const auto column :
       text::split(text.substr(open + 1, close == std::string_view::npos ? close : close - open - 1), ','))
    columns_[text::to_lower(text::trim(column))] = index++;
  if (table_ == Table::other)
    builder_.warn("line " + std::to_string(line_) + ": the table " + std::string(name) + " is not read");
}

void IdxReader::read_point() {
  const std::string id = text("pointid");
  if (id.empty()) return builder_.skip(line_, 1, cells_.front(), "a point with its name in column PointID");
  // What the instrument computed for a measured point is approximate at best.
  const Eigen::Vector3d at = Eigen::Vector3d(number("east"), number("north"), number("elevation")) * metres_;
  if (at.array().isNaN().all() || text("class") == "MEAS") return;
  builder_.give_coordinates(id, at, builder_.at(line_, 1));
  if (text("class") != "FIX" && text("class") != "CTRL") return;
  // Programs write a height of zero where there is none.
  if (at.z() == 0)
    builder_.warn("line " + std::to_string(line_) + ": the known point " + text::quoted(id) +
                  " has the height 0, which is taken as not known");
  builder_.know_coordinates(id, {at.x(), at.y(), at.z() == 0 ? kNotGiven : at.z()}, builder_.at(line_, 1));
}

void IdxReader::read_slope() {
  ++rows_;
  Sighting sighting;
  sighting.to = text("tgtid");
  sighting.source = builder_.at(line_, 1);
  if (sighting.to.empty()) return builder_.skip(line_, 1, "a sighting", "the target's name in column TgtID");
  sighting.direction = angle("hz");
  sighting.zenith_angle = angle("vz");
  sighting.slope_distance = metres_ * number("sdist");
  sighting.target_height = metres_ * number("refht");
  if (sighting.slope_distance < 0 || sighting.slope_distance > 1e5) {
    builder_.skip(line_, 1, text("sdist"), "a distance between 0 and 100 km");
    sighting.slope_distance = kNotGiven;
  }
  if (!builder_.add(sighting)) builder_.skip(line_, 1, sighting.to, "at least one measured value");
}

void IdxReader::read_line(std::string_view text) {
  if (text.starts_with("END ")) {
    if (in_set_up_ && text == "END SETUP" && !station_.empty())
      builder_.start_set_up(station_, instrument_height_, builder_.at(line_, 1));
    if (text == "END SETUP") in_set_up_ = false;
    table_ = Table::none;
    return;
  }
  // Tables may stand within tables: "THEMINFO(PointNo, PointID, Attribute, Value)" among the points.
  const auto is_name = [](char c) { return (c >= 'A' && c <= 'Z') || c == '_'; };
  const std::size_t open = text.find('(');
  const bool names_columns = open != std::string_view::npos && open > 0 && text.ends_with(')') &&
                             std::all_of(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(open), is_name);
  if (table_ != Table::none && !names_columns) {
    cells_ = cells_of(text);
    if (table_ == Table::points) read_point();
    if (table_ == Table::slope) read_slope();
    return;
  }
  if (text == "SETUP") {
    in_set_up_ = true;
    station_.clear();
    instrument_height_ = kNotGiven;
    return;
  }
  const std::size_t blank = std::min(text.find_first_of(" \t"), text.size());
  const std::string_view key = text.substr(0, blank);
  if (key.find('(') != std::string_view::npos || (text.find('(') != std::string_view::npos && text.ends_with(')')))
    return begin_table(text);
  std::string_view value = text::trim(text.substr(blank));
  if (value.ends_with(';')) value = text::trim(value.substr(0, value.size() - 1));
  if (value.size() >= 2 && value.front() == '"' && value.back() == '"') value = value.substr(1, value.size() - 2);
  read_units(key, value);
  if (key == "NAME") builder_.survey.info.title = std::string(value);
  if (key == "OPERATOR") builder_.survey.info.operator_name = std::string(value);
  if (!in_set_up_) return;
  if (key == "STN_ID") station_ = std::string(value);
  if (key != "INST_HT") return;
  if (const auto height = text::parse_number(value))
    instrument_height_ = *height * metres_;
  else
    builder_.skip(line_, 1, value, "an instrument height");
}

SurveyObservations IdxReader::read() {
  for (const text::Line& line : text::split_lines(decoded_.text)) {
    line_ = line.number;
    const std::string_view text = text::trim(line.text);
    if (!text.empty()) read_line(text);
  }
  return builder_.finish(std::to_string(rows_) + " rows of SLOPE tables",
                         rows_ == 0 ? understood_formats() : "a SLOPE table with sightings");
}

}  // namespace

SurveyObservations read_idx(std::string_view bytes, const std::string& file) { return IdxReader(bytes, file).read(); }

}  // namespace plumbline::survey

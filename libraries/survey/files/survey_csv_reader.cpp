#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "base/text/csv_table.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/survey_csv.hpp"
#include "survey/files/survey_csv_columns.hpp"
#include "survey/files/survey_csv_kinds.hpp"
#include "survey/files/survey_csv_sightings.hpp"
#include "survey/files/survey_csv_units.hpp"

namespace plumbline::survey {
namespace {

const char* const kTables =
    "a table of points (id, E, N, H), of sightings (station, target, and hz, v or sd), or of records as "
    "write_survey_csv writes them, with names in its first row or in the option 'columns'";

class TableReader {
 public:
  TableReader(std::string_view bytes, const std::string& file, const SurveyCsvOptions& options)
      : table_(text::read_csv(bytes, survey_column_names())),
        builder_(file, "csv"),
        columns_(table_, options, builder_),
        columns_given_(!options.columns.empty()) {
    if (table_.decoded.encoding != text::Encoding::utf8)
      builder_.warn(std::string("text encoding taken as ") + text::name_of(table_.decoded.encoding));
    for (const text::CsvRow& row : table_.doubtful)
      builder_.skip(row.line, 1, row.cells[0].text,
                    std::string("a row without a comment mark in front: ") + text::kDoubtfulRow);
  }

  SurveyObservations read();
  SurveyObservations read_set_up_coordinates();

 private:
  void refuse_other_tables() const;
  void refuse_other_columns() const;
  void tell_unit_of_angles();
  void read_point();
  void read_sighting();
  void read_record();
  void read_observation_record();
  void read_local_coordinate(const std::string& point);
  void select_set_up();
  void add_coordinates(const std::string& id, const Eigen::Vector3d& at, const Eigen::Matrix3d& covariance,
                       bool is_control);
  SourcePosition original_position() const;
  std::string required(const std::string& column);
  std::string found_nothing() const {
    return std::to_string(table_.rows.size()) + " rows of text (" + table_.dialect() + ")";
  }

  text::CsvTable table_;
  SurveyBuilder builder_;
  SurveyColumns columns_;
  std::map<std::string, int> set_ups_;  // name in the file -> index
  const bool columns_given_;
  std::size_t failed_rows_ = 0, other_places_ = 0;
  const text::CsvRow* first_failed_ = nullptr;
  int other_place_line_ = 0;  // of the first point that has been elsewhere before
};

std::string TableReader::required(const std::string& column) {
  std::string value = columns_.text(column);
  if (value.empty()) columns_.fail(column, "a value in column " + column);
  return value;
}

SurveyObservations TableReader::read() {
  const bool records = columns_.has("record");
  const bool sightings = columns_.has("target") && (columns_.has("station") || columns_.has("set_up")) &&
                         (columns_.has("direction") || columns_.has("zenith") || columns_.has("slope_distance") ||
                          columns_.has("horizontal_distance") || columns_.has("height_difference"));
  if (columns_.has("latitude") && columns_.has("longitude") && !columns_.has("e"))
    throw SurveyReadError(builder_.at(table_.header_line, 1), "latitudes and longitudes",
                          "coordinates of a plane in metres (E, N): project them before");
  const bool points = columns_.has("id") && ((columns_.has("e") && columns_.has("n")) || columns_.has("h"));
  if (!records && !sightings && !points)
    throw SurveyReadError(builder_.at(table_.header_line, 1), found_nothing(),
                          std::string(kTables) + ", or " + understood_formats());
  if (!records) columns_.refuse_thousands();
  if (sightings && !records) check_sightings(table_, columns_, builder_);
  if (sightings && !records && !columns_.untold().empty()) tell_unit_of_angles();
  if (sightings && !records && !columns_.untold_lengths().empty())
    builder_.warn("the table names no unit for " + columns_.untold_lengths().front() + " and other lengths: " +
                  columns_.length_unit() + " is taken; a unit in the header, such as 'sd [ft]', says it");
  for (const text::CsvRow& row : table_.rows) {
    columns_.select(row);
    records ? read_record() : sightings ? read_sighting() : read_point();
    if (!columns_.failed()) continue;
    if (failed_rows_++ == 0) first_failed_ = &row;
  }
  if (!records && !sightings) refuse_other_tables(), refuse_other_columns();
  return builder_.finish(found_nothing(), std::string(kTables) + ", or " + understood_formats());
}

// Gon or degrees is a point in another place, or at another height: taken for granted it would never be missed.
void TableReader::tell_unit_of_angles() {
  std::vector<UntoldSighting> sightings;
  const auto value = [&](const char* column) {
    const std::string text = columns_.text(column);
    return text::parse_number(text, table_.decimal).value_or(kNotGiven);
  };
  for (const text::CsvRow& row : table_.rows) {
    columns_.select(row);
    UntoldSighting s;
    s.station = columns_.text("station").empty() ? columns_.text("set_up") : columns_.text("station");
    s.target = columns_.text("target");
    s.direction = value("direction"), s.zenith = value("zenith");
    for (const std::string& name : columns_.untold())
      if (written_dms(columns_.text(name)))
        return columns_.set_angle_unit("dms");  // 45-30-00: degrees, minutes and seconds say so themselves
    // In one unit of length all three: a ratio.
    const double ih = value("instrument_height"), th = value("target_height"), slope = value("slope_distance");
    const double difference = (std::isnan(ih) ? 0 : ih) - (std::isnan(th) ? 0 : th);
    s.rise = difference == 0 ? 0 : difference / slope;
    s.heights = !std::isnan(s.rise) && std::abs(s.rise) < 1;
    sightings.push_back(std::move(s));
  }
  std::string names;
  for (const std::string& name : columns_.untold()) names += (names.empty() ? "" : ", ") + name;
  const auto told = tell_angle_unit(sightings);
  const bool grad = columns_.says_grad();
  if (!told)
    throw SurveyReadError(builder_.at(table_.header_line, 1),
                          grad ? "angles in 'Grad', a degree in German and a gon in French (" + names + ")"
                               : "angles without a unit (" + names + ")",
                          "a unit in the header, such as 'hz [gon]', or the option angle_unit: gon, deg, dms; no two "
                          "faces and no reciprocal zenith angles tell it");
  builder_.warn((grad ? "'Grad' of " + names + " is a degree in German and a gon in French: "
                      : "the table names no unit for " + names + ": ") +
                told->unit + " is taken, because " + told->reason);
  columns_.set_angle_unit(told->unit);
}

void TableReader::add_coordinates(const std::string& id, const Eigen::Vector3d& at, const Eigen::Matrix3d& covariance,
                                  bool is_control) {
  CoordinateGroup group;
  std::vector<int> axes;
  for (int axis = 0; axis < 3; ++axis)
    if (!std::isnan(at[axis]) && !std::isnan(covariance(axis, axis))) axes.push_back(axis);
  if (axes.empty()) return;
  const auto n = static_cast<Eigen::Index>(axes.size());
  group.values.resize(n);
  group.covariance.resize(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const int axis = axes[i];
    group.components.push_back({id, axis});
    group.values[i] = at[axis];
    for (Eigen::Index j = 0; j < n; ++j) group.covariance(i, j) = covariance(axis, axes[j]);
  }
  group.is_control = is_control;
  group.source = original_position();
  builder_.survey.coordinates.push_back(std::move(group));
}

// Any text with commas looks like a table of points if one is content with a few of its rows.
void TableReader::refuse_other_tables() const {
  const std::string how = ", or name the columns with the option 'columns', or " + understood_formats();
  const std::size_t rows = table_.rows.size();
  if (table_.header.empty() && !columns_given_ && failed_rows_ > std::max<std::size_t>(2, rows / 10))
    throw SurveyReadError(builder_.at(first_failed_->line, 1),
                          std::to_string(failed_rows_) + " of " + std::to_string(rows) +
                              " rows that are no points (here " +
                              text::quoted(first_failed_->cells.empty() ? "" : first_failed_->cells[0].text) + ")",
                          "a name and coordinates in every row of a table that has no header" + how);
  if (other_places_ > 3 && 3 * other_places_ > rows)
    throw SurveyReadError(builder_.at(other_place_line_, 1),
                          std::to_string(other_places_) + " of " + std::to_string(rows) +
                              " rows with a name that a row before has at another place",
                          "one row for each point: these may be no points, or another column has their names" + how);
}

int decimals_of(const std::string& text) {
  const std::size_t point = text.find_first_of(".,");
  return point == std::string::npos ? 0 : static_cast<int>(text.size() - point) - 1;
}

// A table that has no names, a zone in front of the easting, degrees: read as name, E, N, H each gives numbers that are
// wrong and look right.
void TableReader::refuse_other_columns() const {
  constexpr double kHighest = 20000;  // [m]
  const std::string how = ": say with the option 'columns' which column is which";
  const bool guessed = table_.header.empty() && !columns_given_;
  std::size_t points = 0, high = 0, numbers = 0, degrees = 0;
  const Point* first_high = nullptr;
  for (const Point& p : builder_.survey.points) {
    ++points;
    if (std::abs(p.coordinates.z()) > kHighest && high++ == 0) first_high = &p;
    const auto number = table_.number({p.id, 0});
    numbers += number && decimals_of(p.id) > 0 && (std::abs(*number) > 1000 || decimals_of(p.id) > 2);
  }
  for (const text::CsvRow& row : table_.rows) {
    if (!guessed || row.cells.size() < 3) continue;
    const auto a = table_.number(row.cells[1]), b = table_.number(row.cells[2]);
    const bool small =
        a && b && std::max(std::abs(*a), std::abs(*b)) <= 180 && std::min(std::abs(*a), std::abs(*b)) <= 90;
    const bool plan = row.cells.size() < 4 || !table_.number(row.cells[3]);
    degrees += small && plan && std::min(decimals_of(row.cells[1].text), decimals_of(row.cells[2].text)) > 5;
  }
  if (first_high && 2 * high > points)
    throw SurveyReadError(first_high->source,
                          "a height of " + text::format_fixed(first_high->coordinates.z(), 3) + " m",
                          "heights: another column may hold them, behind a zone or in millimetres, or these are "
                          "geocentric coordinates" +
                              how);
  if (guessed && points > 0 && numbers == points)
    throw SurveyReadError(builder_.survey.points.front().source,
                          "numbers where the names should be (" + text::quoted(builder_.survey.points.front().id) + ")",
                          "a name and coordinates in every row of a table that has no header" + how);
  if (guessed && points > 0 && degrees == table_.rows.size())
    throw SurveyReadError(builder_.survey.points.front().source, "what may be latitudes and longitudes",
                          "coordinates of a plane in metres (E, N); if they are" + how);
}

void TableReader::read_point() {
  constexpr double kSamePlace = 0.5, kFarthest = 1e8;  // [m]
  const std::string id = required("id");
  const Eigen::Vector3d at = columns_.coordinates();
  if ((at.array().abs() > kFarthest).any()) columns_.fail("e", "coordinates below 100 000 km");
  const Eigen::Matrix3d covariance = columns_.covariance();
  if (columns_.failed()) return;
  if (at.array().isNaN().all()) return columns_.fail("e", "coordinates of the point");
  const Eigen::Vector3d known = builder_.point(id, columns_.position()).coordinates;
  if ((at - known).head<2>().norm() > kSamePlace && other_places_++ == 0) other_place_line_ = columns_.row().line;
  builder_.give_coordinates(id, at, columns_.position());
  Point& point = builder_.point(id, columns_.position());
  if (point.code.empty()) point.code = columns_.text("code");
  if (point.description.empty()) point.description = columns_.text("description");
  add_coordinates(id, at, covariance, true);
}

// A row belongs to the set-up its column names; without one, rows of one station are one set-up.
void TableReader::select_set_up() {
  const std::string own = columns_.text("set_up"), station = columns_.text("station");
  const std::string& key = own.empty() ? station : own;
  const auto known = set_ups_.find(key);
  if (known != set_ups_.end()) return builder_.select_set_up(known->second);
  set_ups_[key] =
      builder_.start_set_up(station.empty() ? own : station, columns_.length("instrument_height"), columns_.position());
}

void TableReader::read_sighting() {
  Sighting sighting;
  sighting.to = required("target");
  if (columns_.text("set_up").empty()) required("station");
  sighting.direction = columns_.angle("direction");
  sighting.zenith_angle = columns_.angle("zenith");
  sighting.slope_distance = columns_.length("slope_distance");
  sighting.horizontal_distance = columns_.length("horizontal_distance");
  sighting.height_difference = columns_.length("height_difference");
  sighting.target_height = columns_.length("target_height");
  sighting.face = columns_.integer("face", 0);
  sighting.source = columns_.position();
  const double instrument_height = columns_.length("instrument_height");
  if (sighting.face != 0 && sighting.face != 1 && sighting.face != 2) columns_.fail("face", "face 1 or 2");
  for (const char* column : {"slope_distance", "horizontal_distance"})
    if (columns_.length(column) < 0) columns_.fail(column, "a distance that is not negative");
  if (columns_.failed()) return;
  select_set_up();
  const SetUp& set_up = builder_.survey.set_ups[builder_.current_set_up()];
  if (!std::isnan(instrument_height) && instrument_height != set_up.instrument_height)
    sighting.instrument_height = instrument_height;
  if (!builder_.add(sighting)) columns_.fail("direction", "at least one measured value");
}

// Records keep where their value stood in the file it was first read from.
SourcePosition TableReader::original_position() const {
  const std::string file = columns_.text("source_file");
  if (file.empty()) return columns_.position();
  const auto number = [&](const char* column) {
    return static_cast<int>(text::parse_integer(columns_.text(column)).value_or(0) & 0x7fffffff);
  };
  return {file, number("source_line"), number("source_column")};
}

void TableReader::read_record() {
  const std::string record = columns_.text("record");
  if (record == "observation") return read_observation_record();
  const std::string id = required("id");
  if (columns_.failed()) return;
  if (record == "point") {
    const Eigen::Vector3d at = columns_.coordinates();
    const auto roles = roles_of(columns_.text("role"));
    if (!roles) columns_.fail("role", "three letters of f, c, x, - for free, constrained, fixed, unused");
    if (columns_.failed()) return;
    builder_.give_coordinates(id, at, original_position());
    Point& point = builder_.point(id, original_position());
    point.roles = *roles;
    point.code = columns_.text("code");
    point.description = columns_.text("description");
  } else if (record == "control" || record == "coordinates") {
    const Eigen::Vector3d at = columns_.coordinates();
    const Eigen::Matrix3d covariance = columns_.covariance();
    if (columns_.failed()) return;
    builder_.point(id, columns_.position());
    add_coordinates(id, at, covariance, record == "control");
  } else if (record == "set_up") {
    const double height = columns_.length("instrument_height");
    const std::string station = required("station");
    if (columns_.failed()) return;
    if (set_ups_.contains(id)) return columns_.fail("id", "a set-up that is not there already");
    set_ups_[id] = builder_.start_set_up(station, height, original_position());
    builder_.survey.set_ups.back().id = id;
  } else if (record == "local") {
    read_local_coordinate(id);
  } else {
    columns_.fail("record", "point, control, coordinates, set_up, observation or local");
  }
}

void TableReader::read_observation_record() {
  Observation o;
  const auto kind = kind_of(columns_.text("kind"));
  if (!kind) columns_.fail("kind", "direction, zenith_angle, slope_distance or another kind of observation");
  const std::string unit = columns_.text("unit");
  const bool angle = kind && is_angle(*kind);
  const double one = SurveyColumns::in_si(1.0, unit);
  if (std::isnan(one) || unit == "dms") columns_.fail("unit", angle ? "gon, deg or rad" : "m or mm");
  if (columns_.text("value").empty()) columns_.fail("value", "the observation's value");
  o.value = SurveyColumns::in_si(columns_.number("value"), unit);
  o.sigma = SurveyColumns::in_si(columns_.number("sigma"), unit);
  o.from = required("station");
  o.to = required("target");
  o.second_to = columns_.text("second_to");
  o.pointing = columns_.integer("pointing", -1);
  o.levelling_length = columns_.length("levelling_length");
  o.instrument_height = columns_.length("instrument_height");
  o.target_height = columns_.length("target_height");
  o.second_target_height = columns_.length("second_target_height");
  o.face = columns_.integer("face", 0);
  o.set_number = columns_.integer("set", 0);
  o.source = original_position();
  const std::string set_up = columns_.text("set_up");
  if (!set_up.empty()) {
    const auto known = set_ups_.find(set_up);
    if (known == set_ups_.end())
      columns_.fail("set_up", "the id of a set_up record further up");
    else
      o.set_up = known->second;
  }
  if (o.face < 0 || o.face > 2) columns_.fail("face", "face 0, 1 or 2");
  if (o.sigma <= 0) columns_.fail("sigma", "a standard deviation above zero");
  if (columns_.failed()) return;
  o.kind = *kind;
  if (const std::string done = columns_.text("corrections"); !done.empty())
    for (const auto part : text::split(done, '|')) o.corrections.emplace_back(part);
  builder_.add(std::move(o));
}

void TableReader::read_local_coordinate(const std::string& point) {
  LocalCoordinate local;
  local.point = point;
  local.position = columns_.coordinates();
  local.covariance = columns_.covariance();
  local.target_height = columns_.length("target_height");
  local.source = original_position();
  if (columns_.text("set_up").empty()) required("station");
  if (columns_.failed()) return;
  if (local.position.array().isNaN().any()) return columns_.fail("e", "x, y and z of the point");
  select_set_up();
  local.set_up = builder_.current_set_up();
  builder_.point(point, local.source);
  builder_.survey.local_coordinates.push_back(std::move(local));
}

SurveyObservations TableReader::read_set_up_coordinates() {
  const char* expected = "a table with the columns set_up (or station), point, x, y, z";
  const std::string id = columns_.has("target") ? "target" : "id";
  if (!(columns_.has("set_up") || columns_.has("station")) || !columns_.has(id) || !columns_.has("e") ||
      !columns_.has("n") || !columns_.has("h"))
    throw SurveyReadError(builder_.at(table_.header_line, 1), found_nothing(), expected);
  builder_.survey.info.format = "setup-coordinates-csv";
  for (const text::CsvRow& row : table_.rows) {
    columns_.select(row);
    const std::string point = required(id);
    if (!columns_.failed()) read_local_coordinate(point);
  }
  return builder_.finish(found_nothing(), expected);
}

}  // namespace

SurveyObservations read_survey_csv(std::string_view bytes, const std::string& file, const SurveyCsvOptions& options) {
  return TableReader(bytes, file, options).read();
}

SurveyObservations read_setup_coordinates(std::string_view bytes, const std::string& file,
                                          const SurveyCsvOptions& options) {
  return TableReader(bytes, file, options).read_set_up_coordinates();
}

bool has_setup_coordinates_header(std::string_view bytes) {
  const text::CsvTable table = text::read_csv(bytes.substr(0, 4096), survey_column_names());
  bool set_up = false, point = false, x = false, measured = false;
  for (const text::CsvHeaderCell& cell : table.header) {
    set_up = set_up || cell.name == "set_up" || cell.name == "station";
    point = point || cell.name == "id" || cell.name == "target";
    x = x || cell.name == "x" || cell.name == "e";
    measured = measured || cell.name == "direction" || cell.name == "zenith" || cell.name == "record";
  }
  return set_up && point && x && !measured;
}

}  // namespace plumbline::survey

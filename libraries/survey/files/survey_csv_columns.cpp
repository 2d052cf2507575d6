#include "survey/files/survey_csv_columns.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "control/points/point_columns.hpp"
#include "survey/files/survey_csv_units.hpp"

namespace plumbline::survey {
namespace {

using text::equal_ignoring_case;

bool is_angle_unit(std::string_view unit) {
  for (const char* known : {"gon", "grad", "grads", "deg", "degree", "degrees", "dms", "rad"})
    if (unit == known) return true;
  return false;
}

bool is_angle_column(std::string_view name) { return name == "direction" || name == "zenith" || name == "azimuth"; }

constexpr double kRounded = 0.011;  // [m]: what is rounded more is no coordinate or distance

/// What the last digit of a number with an exponent counts, 0 without one: 1e4 of "5,41E+06".
double resolution(const std::string& number) {
  const std::size_t exponent = number.find_first_of("eE");
  if (exponent == std::string::npos) return 0;
  const auto power = text::parse_integer(std::string_view(number).substr(exponent + 1));
  const std::size_t point = number.find_first_of(".,");
  const auto decimals = point < exponent ? static_cast<double>(exponent - point - 1) : 0.0;
  return power ? std::pow(10.0, static_cast<double>(*power) - decimals) : 0;
}

bool is_length_column(std::string_view name) {
  for (const char* known : {"e", "n", "h", "x", "y", "slope_distance", "horizontal_distance", "height_difference",
                            "instrument_height", "target_height", "second_target_height", "levelling_length"})
    if (name == known) return true;
  return name.starts_with("sigma_");
}

/// What a table of points holds and a table of sightings or records does not share: there sd is a slope distance, and
/// sigma that of a reading.
bool is_table_of_points(const std::vector<text::CsvHeaderCell>& header) {
  return std::none_of(header.begin(), header.end(), [](const auto& cell) {
    for (const char* other : {"target", "station", "set_up", "record", "kind", "direction", "zenith"})
      if (cell.name == other) return true;
    return false;
  });
}

/// What a header cell is by the names of control, and its unit; empty for other columns.
std::pair<std::string, std::string> control_column(const text::CsvHeaderCell& cell) {
  const auto& names = control::point_column_names();
  if (const auto known = names.find(cell.written); known != names.end()) return {known->second, cell.unit};
  const std::size_t bar = cell.written.rfind('_');
  if (bar == std::string::npos || std::isnan(control::metres_in(cell.written.substr(bar + 1)))) return {};
  const auto known = names.find(cell.written.substr(0, bar));
  return known == names.end() ? std::pair<std::string, std::string>()
                              : std::pair{known->second, cell.written.substr(bar + 1)};
}

}  // namespace

const std::map<std::string, std::string>& survey_column_names() {
  static const std::map<std::string, std::string> names = [] {
    std::map<std::string, std::string> all;
    const auto add = [&all](const std::string& column, std::initializer_list<const char*> synonyms) {
      all[column] = column;
      for (const char* synonym : synonyms) all[synonym] = column;
    };
    add("id", {"point",         "pt",       "name",       "nr",     "no",          "number",    "point_id",
               "pointid",       "point_no", "point_name", "punkt",  "punktnummer", "punktnr",   "punkt_nr",
               "punktname",     "punktid",  "pkt",        "pnr",    "p",           "matricule", "numero",
               "num\xC3\xA9ro", "nom",      "punto",      "nombre", "nome"});
    add("e", {"east", "easting", "ost", "ostwert", "rechtswert", "rechts", "est", "este"});
    add("n", {"north", "northing", "nord", "nordwert", "hochwert", "hoch", "norte"});
    add("h", {"z", "height", "elevation", "elev", "el", "hoehe", "h\xC3\xB6he", "altitude", "alt", "cota", "quota",
              "altura"});
    add("latitude", {"lat", "breite"});
    add("longitude", {"lon", "long", "lng", "laenge", "l\xC3\xA4nge"});
    add("x", {});
    add("y", {});
    add("code", {"c", "feature"});
    add("description", {"desc", "d", "remark", "bemerkung", "note"});
    add("station", {"stn", "from", "standpunkt", "stand", "stationname", "station_name"});
    add("target", {"to", "ziel", "zielpunkt", "target_id"});
    add("set_up", {"setup", "setup_id", "set_up_id", "aufstellung"});
    add("direction", {"hz", "horizontal_angle", "horizontal_direction", "ha", "richtung"});
    add("zenith", {"v", "zenith_angle", "vertical_angle", "va", "ze", "zenitwinkel", "zenitdistanz", "zenithdistanz"});
    add("azimuth", {"az"});
    add("slope_distance",
        {"sd", "s", "slope_dist", "schraegstrecke", "schr\xC3\xA4gstrecke", "schraegdistanz", "schr\xC3\xA4gdistanz",
         "distance_inclinee", "distance_inclin\xC3\xA9\x65", "distancia_inclinada", "distanza_inclinata"});
    add("horizontal_distance", {"hd", "horizontal_dist", "horizontalstrecke", "horizontaldistanz",
                                "distance_horizontale", "distancia_horizontal", "distanza_orizzontale"});
    add("height_difference", {"dh"});
    add("instrument_height", {"ih", "hi", "i_h", "instrumentenhoehe", "instrumentenh\xC3\xB6he", "hauteur_instrument",
                              "altura_instrumento", "altezza_strumento"});
    add("target_height",
        {"th", "ht", "hr", "reflector_height", "prism_height", "zielhoehe", "zielh\xC3\xB6he", "reflektorhoehe",
         "reflektorh\xC3\xB6he", "prismenhoehe", "prismenh\xC3\xB6he", "stabhoehe", "stabh\xC3\xB6he", "pole_height",
         "rod_height", "hauteur_prisme", "altura_prisma", "altezza_prisma"});
    add("face", {"lage"});
    add("set", {"satz", "round"});
    add("pointing", {});
    for (const char* own : {"record", "second_to", "kind", "value", "unit", "sigma", "second_target_height",
                            "levelling_length", "role", "corrections", "source_file", "source_line", "source_column"})
      add(own, {});
    add("sigma_e", {"sigma_x", "sigmax", "s_e", "sd_e", "std_e", "sigma_east"});
    add("sigma_n", {"sigma_y", "sigmay", "s_n", "sd_n", "std_n", "sigma_north"});
    add("sigma_h", {"sigma_z", "sigmaz", "s_h", "sd_h", "std_h", "sigma_height"});
    for (const auto& [own, local] : {std::pair{"cov_ee", "cov_xx"},
                                     {"cov_en", "cov_xy"},
                                     {"cov_eh", "cov_xz"},
                                     {"cov_nn", "cov_yy"},
                                     {"cov_nh", "cov_yz"},
                                     {"cov_hh", "cov_zz"}})
      add(own, {local});
    return all;
  }();
  return names;
}

SurveyColumns::SurveyColumns(const text::CsvTable& table, const SurveyCsvOptions& options, SurveyBuilder& builder)
    : table_(table), options_(options), builder_(builder) {
  if (!options.columns.empty()) {
    take_order(options.columns);
  } else if (!table.header.empty()) {
    take_header();
  } else {
    take_order("PENZD");
    builder_.warn(
        "the table has no header: columns are taken as point, E, N, H, description; say so with the option "
        "'columns' if their order is another (" +
        table.dialect() + ")");
  }
  if (!has("e") && !has("n") && has("x") && has("y")) take_axes();
}

// Geodesists of German-speaking countries count X to the north and Y to the east, nearly everybody else the other way
// round. Coordinates in the frame of a set-up have their own definition.
void SurveyColumns::take_axes() {
  const bool own_frame = has("set_up") || has("station");
  const auto typical = [&](const char* column) {
    const auto at = columns_.find(column);
    return at == columns_.end() ? 0.0 : control::typical_value(table_, at->second.index, in_si(1.0, at->second.unit));
  };
  const control::PlanAxes axes =
      own_frame ? control::PlanAxes{}
                : control::axes_of_xy(table_.header, columns_.at("y").index < columns_.at("x").index, typical("x"),
                                      typical("y"), typical("h"));
  if (!axes.refusal.empty()) refuse_axes(axes.refusal);
  if (!own_frame)
    builder_.warn(std::string("columns X and Y are taken as ") +
                  (axes.y_is_east ? "Y = east and X = north" : "X = east and Y = north") + " (" + axes.reason +
                  "); if that is wrong, name them E and N");
  columns_["e"] = columns_[axes.y_is_east ? "y" : "x"];
  columns_["n"] = columns_[axes.y_is_east ? "x" : "y"];
  if (!axes.y_is_east) return;
  // Standard deviations that were named after X and Y were taken as east and north.
  for (const auto& [one, other] : {std::pair{"sigma_e", "sigma_n"}, {"cov_ee", "cov_nn"}, {"cov_eh", "cov_nh"}}) {
    const bool first = has(one) && named_after_xy(one), second = has(other) && named_after_xy(other);
    if (!first && !second) continue;
    const auto a = first ? columns_.extract(one) : std::map<std::string, Column>::node_type();
    const auto b = second ? columns_.extract(other) : std::map<std::string, Column>::node_type();
    if (a) columns_[other] = a.mapped();
    if (b) columns_[one] = b.mapped();
  }
}

bool SurveyColumns::named_after_xy(const std::string& column) const {
  const std::size_t index = columns_.at(column).index;
  if (index >= table_.header.size()) return false;
  const std::string& written = table_.header[index].written;
  const std::string named = control_column(table_.header[index]).first;
  return named == "sigma_x" || named == "sigma_y" ||
         (written.starts_with("cov_") && written.find_first_of("xy") != std::string::npos);
}

void SurveyColumns::refuse_axes(const std::string& found) const {
  throw SurveyReadError(builder_.at(table_.header_line, 1), found,
                        "columns that say which is which: E and N, or Rechtswert and Hochwert");
}

void SurveyColumns::place(const std::string& name, std::size_t index, const std::string& unit) {
  if (columns_.contains(name)) {
    builder_.warn("the table has two columns '" + name + "'; the first one counts");
    return;
  }
  if (name.starts_with("cov_")) {
    if (!unit.empty() && unit != "m2" && unit != "mm2")
      throw SurveyReadError(builder_.at(table_.header_line, 1), "the unit " + text::quoted(unit) + " of column " + name,
                            "m2 or mm2");
    columns_[name] = {index, unit.empty() ? "m2" : unit};
    return;
  }
  const bool angle = is_angle_column(name);
  if (!angle && !is_length_column(name) && !(name == "sigma" && of_points_)) {
    columns_[name] = {index, ""};
    return;
  }
  // "Grad" is a degree in German and a gon in French: the readings tell, as where nobody says a unit.
  if (angle && (unit.empty() || unit == "grad") && options_.angle_unit.empty()) {
    columns_[name] = {index, ""};
    untold_.push_back(name);
    says_grad_ = says_grad_ || unit == "grad";
    return;
  }
  const std::string used = unit.empty() ? (angle ? options_.angle_unit : length_unit()) : unit;
  if (std::isnan(in_si(1.0, used)) || is_angle_unit(used) != angle)
    throw SurveyReadError(builder_.at(unit.empty() ? 0 : table_.header_line, unit.empty() ? 0 : 1),
                          "the unit " + text::quoted(used) + " of column " + name,
                          angle ? "gon, deg, dms or rad" : "m, cm, mm, ft or usft");
  if (!angle) (unit.empty() ? lengths_untold_ : lengths_told_).push_back(name);
  columns_[name] = {index, used};
}

void SurveyColumns::take_order(const std::string& order) {
  const auto& names = survey_column_names();
  const bool letters = order.find_first_of(",; _") == std::string::npos;
  std::vector<std::string> wanted;
  if (letters) {
    for (const char c : order) wanted.emplace_back(1, c);
  } else {
    for (const auto part : text::split(order, order.find(';') != std::string::npos ? ';' : ','))
      wanted.emplace_back(text::trim(part));
  }
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    if (wanted[i] == "-" || wanted[i].empty()) continue;
    const auto known = names.find(text::to_lower(wanted[i]));
    if (known == names.end())
      throw SurveyReadError(builder_.at(0), "the column " + text::quoted(wanted[i]) + " in the option columns",
                            "letters as in PENZD or names such as station, target, hz, v, sd, id, E, N, H, code");
    place(known->second, i, "");
  }
}

// A column that nobody understands may be a height: left out in silence it would spoil every reading.
void SurveyColumns::take_header() {
  const auto& names = survey_column_names();
  constexpr int kNamed = 6;
  std::string ignored;
  int count = 0;
  of_points_ = is_table_of_points(table_.header);
  for (std::size_t i = 0; i < table_.header.size(); ++i) {
    const text::CsvHeaderCell& cell = table_.header[i];
    if (cell.name.empty()) continue;
    if (const auto [column, unit] = control_column(cell); of_points_ && column.starts_with("sigma")) {
      // As if X were the east; take_axes() exchanges them where it is not.
      place(column == "sigma_x" ? "sigma_e" : column == "sigma_y" ? "sigma_n" : column, i, unit);
      continue;
    }
    const auto is_it = [&](const auto& entry) { return entry.second == cell.name; };
    if (std::any_of(names.begin(), names.end(), is_it))
      place(cell.name, i, cell.unit);
    else if (of_points_ && control::looks_like_an_accuracy(cell.written))
      throw SurveyReadError(builder_.at(table_.header_line, 1),
                            "the column " + text::quoted(cell.written) + ", which looks like an accuracy",
                            "sigma, or sigma_e, sigma_n and sigma_h: dropped, another accuracy would be assumed");
    else if (++count <= kNamed)
      ignored += (ignored.empty() ? "" : ", ") + text::quoted(cell.name);
  }
  if (count > kNamed) ignored += " and " + std::to_string(count - kNamed) + " more";
  if (count > 0)
    builder_.warn("columns that are not known are left out: " + ignored +
                  "; if one is needed, rename it (e.g. target_height, instrument_height, sd)");
}

std::vector<std::string> SurveyColumns::names() const {
  std::vector<std::string> all;
  for (const auto& [name, column] : columns_) all.push_back(name);
  std::sort(all.begin(), all.end(),
            [&](const auto& a, const auto& b) { return columns_.at(a).index < columns_.at(b).index; });
  return all;
}

std::string SurveyColumns::written(const std::string& column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end() || found->second.index >= table_.header.size()) return column;
  return table_.header[found->second.index].written;
}

const text::CsvCell* SurveyColumns::cell(const std::string& column) const {
  const auto found = columns_.find(column);
  if (found == columns_.end() || found->second.index >= row_->cells.size()) return nullptr;
  const text::CsvCell& cell = row_->cells[found->second.index];
  return cell.text.empty() ? nullptr : &cell;
}

std::string SurveyColumns::text(const std::string& column) const {
  const text::CsvCell* found = cell(column);
  return found ? found->text : std::string();
}

void SurveyColumns::fail(const std::string& column, const std::string& expected) {
  failed_ = true;
  const text::CsvCell* found = cell(column);
  builder_.skip(row_->line, found ? found->column : 1, found ? found->text : "a row without a value for " + column,
                expected);
}

double SurveyColumns::number(const std::string& column) {
  const text::CsvCell* found = cell(column);
  if (!found) return kNotGiven;
  const auto value = table_.number(*found);
  if (value) return *value;
  fail(column, "a number in column " + column + " (" + table_.dialect() + ")");
  return kNotGiven;
}

void SurveyColumns::refuse_thousands() const {
  std::vector<std::size_t> places;
  for (const char* name : {"e", "n", "h", "slope_distance", "horizontal_distance"})
    if (const auto at = columns_.find(name); at != columns_.end()) places.push_back(at->second.index);
  const text::Thousands found = text::thousands_of(table_, places);
  if (found.example.empty()) return;
  const std::string read = std::string("'") + table_.decimal + "'";
  if (found.integers)
    throw SurveyReadError(builder_.at(table_.header_line, 1),
                          "numbers such as " + text::quoted(found.example) + " beside whole ones, so that " + read +
                              " may separate decimals or thousands",
                          "decimals in all of them, or no separator of thousands");
  builder_.warn("numbers such as " + text::quoted(found.example) + " are read with " + read +
                " as the decimal separator, not as thousands: nothing in the table tells");
}

int SurveyColumns::integer(const std::string& column, int otherwise) {
  const text::CsvCell* found = cell(column);
  if (!found) return otherwise;
  const auto value = text::parse_integer(found->text);
  if (value && *value >= -1 && *value <= 1'000'000'000) return static_cast<int>(*value);
  fail(column, "a whole number in column " + column);
  return otherwise;
}

double SurveyColumns::in_si(double value, const std::string& unit) {
  for (const char* one : {"m", "meter", "metre", "meters", "metres", "rad", "m2"})
    if (unit == one) return value;
  if (unit == "mm") return value / 1e3;
  if (unit == "mm2") return value / 1e6;
  if (unit == "cm") return value / 1e2;
  if (unit == "ft") return value * kFoot;
  if (unit == "usft") return value * kUsSurveyFoot;
  if (unit == "gon" || unit == "grad" || unit == "grads") return gon_to_rad(value);
  if (unit == "deg" || unit == "degree" || unit == "degrees") return degrees_to_rad(value);
  if (unit == "dms") return packed_degrees_to_rad(value).value_or(kNotGiven);
  return kNotGiven;
}

double SurveyColumns::measured(const std::string& column, bool is_angle) {
  if (const text::CsvCell* found = is_angle ? cell(column) : nullptr)
    if (const auto written = written_dms(found->text)) return *written;
  const double value = number(column);
  if (std::isnan(value)) return kNotGiven;
  const double si = in_si(value, columns_.at(column).unit);
  if (!is_angle && in_si(resolution(cell(column)->text), columns_.at(column).unit) > kRounded) {
    fail(column, "all digits: a spreadsheet rounded this value when it wrote it with an exponent");
    return kNotGiven;
  }
  if (!std::isnan(si)) return si;
  fail(column, is_angle ? "minutes and seconds below 60 in D.MMSS" : "a length");
  return kNotGiven;
}

void SurveyColumns::set_angle_unit(const std::string& unit) {
  for (const std::string& name : untold_) columns_.at(name).unit = unit;
  untold_.clear();
}

double SurveyColumns::length(const std::string& column) { return measured(column, false); }
double SurveyColumns::angle(const std::string& column) { return measured(column, true); }

Eigen::Vector3d SurveyColumns::coordinates() {
  for (const char* column : {"e", "n", "h"})
    if (control::is_shortened(text(column)))
      fail(column,
           "all digits: a spreadsheet has shortened this number; give its column a number format with decimals");
  return {length("e"), length("n"), length("h")};
}

Eigen::Matrix3d SurveyColumns::covariance() {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Constant(kNotGiven);
  const char* axes = "enh";
  const auto any_of = [&](const char* a, const char* b, const char* c) {
    return !text(a).empty() || !text(b).empty() || !text(c).empty();
  };
  const bool full = any_of("cov_ee", "cov_nn", "cov_hh");
  const bool common = of_points_ && (!text("sigma").empty() || !text("sigma_plan").empty());
  if (!full && !common && !any_of("sigma_e", "sigma_n", "sigma_h")) return matrix;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      if (full) {
        const std::string column = std::string("cov_") + axes[i] + axes[j];
        double value = number(column);
        if (std::isnan(value)) value = i == j ? kNotGiven : 0.0;
        matrix(i, j) = matrix(j, i) = has(column) ? in_si(value, columns_.at(column).unit) : value;
      } else if (i != j) {
        matrix(i, j) = matrix(j, i) = 0.0;
      } else {
        std::string column = std::string("sigma_") + axes[i];
        if (common && text(column).empty()) column = i < 2 && !text("sigma_plan").empty() ? "sigma_plan" : "sigma";
        const double sigma = length(column);
        if (sigma <= 0) fail(column, "standard deviations above zero");
        matrix(i, i) = sigma * sigma;
      }
    }
  }
  if (failed_) return matrix;
  // An axis without a coordinate has no variance either; the given ones must be positive definite among themselves.
  Eigen::Matrix3d checked = matrix;
  for (int i = 0; i < 3; ++i) {
    if (!std::isnan(matrix(i, i))) continue;
    checked.row(i).setZero();
    checked.col(i).setZero();
    checked(i, i) = 1.0;
  }
  const double scale = checked.diagonal().maxCoeff();
  const bool usable = checked.array().isFinite().all() && checked.diagonal().minCoeff() > 0 && scale < 1e12;
  if (!usable || Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(checked).eigenvalues()[0] <= 0)
    fail(full ? "cov_ee" : "sigma_e", "standard deviations that can be, or a positive definite covariance");
  return matrix;
}

}  // namespace plumbline::survey

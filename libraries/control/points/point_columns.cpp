#include "control/points/point_columns.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "geometry/median.hpp"

namespace plumbline::control {
namespace {

using Names = std::map<std::string, std::string>;

void add(Names& all, const std::string& column, std::initializer_list<const char*> synonyms) {
  all[column] = column;
  for (const char* synonym : synonyms) all[synonym] = column;
}

/// "sigma_east", "sE", "x_acc": what a standard deviation of the axis may be called.
void add_sigmas(Names& all, const std::string& column, const std::vector<std::string>& axis) {
  all[column] = column;
  for (const std::string& name : axis)
    for (const char* word : {"sigma", "s", "sd", "std", "stdev", "stddev", "std_dev", "accuracy", "acc", "precision",
                             "\xCF\x83", "genauigkeit", "m"}) {
      const std::string prefix = word;
      if (prefix != "m") all[prefix + "_" + name] = column;
      if (prefix != "m" || name.size() == 1) all[prefix + name] = column;
      if (prefix != "s" && prefix != "m") all[name + "_" + prefix] = column;
    }
}

/// Names that only a German table gives its columns.
bool is_german(const std::string& written) {
  for (const char* start : {"punkt", "pkt", "pnr", "hoehe", "h\xC3\xB6he", "bemerkung", "hochwert", "rechtswert"})
    if (written.starts_with(start)) return true;
  return false;
}

}  // namespace

const std::map<std::string, std::string>& point_column_names() {
  static const Names names = [] {
    Names all;
    const std::vector<std::string> e = {"e",          "east",   "easting", "ost", "ostwert",
                                        "rechtswert", "rechts", "est",     "este"},
                                   n = {"n", "north", "northing", "nord", "nordwert", "hochwert", "hoch", "norte"},
                                   h = {"h",        "z",   "height", "elevation",   "elev", "el",    "up",
                                        "altitude", "alt", "hoehe",  "h\xC3\xB6he", "cota", "quota", "altura"};
    add_sigmas(all, "sigma_e", e);
    add_sigmas(all, "sigma_n", n);
    add_sigmas(all, "sigma_h", h);
    add_sigmas(all, "sigma_x", {"x", "x_map"});
    add_sigmas(all, "sigma_y", {"y", "y_map"});
    add_sigmas(all, "sigma", {"xyz", "x_y_z", "enh", "e_n_h"});
    add_sigmas(all, "sigma_plan", {"xy", "x_y", "en", "e_n"});
    for (const std::string& name : e) all[name] = "e";
    for (const std::string& name : n) all[name] = "n";
    for (const std::string& name : h) all[name] = "h";
    add(all, "id", {"point",         "pt",       "name",        "nr",         "no",
                    "number",        "label",    "point_id",    "pointid",    "point_no",
                    "ptid",          "pt_id",    "pointname",   "point_name", "punkt",
                    "punktnr",       "punkt_nr", "punktnummer", "punktname",  "punktid",
                    "pkt",           "pnr",      "p",           "matricule",  "numero",
                    "num\xC3\xA9ro", "nom",      "punto",       "nombre",     "nome",
                    "gcp",           "gcp_label"});
    add(all, "x", {"x_map", "coord_x"});
    add(all, "y", {"y_map", "coord_y"});
    add(all, "sigma",
        {"accuracy", "acc", "sd", "std", "stdev", "stddev", "std_dev", "precision", "\xCF\x83", "genauigkeit",
         "standardabweichung", "standard_deviation"});
    add(all, "latitude", {"lat", "breite"});
    add(all, "longitude", {"lon", "long", "lng", "laenge", "l\xC3\xA4nge"});
    add(all, "role", {"rolle"});
    add(all, "code", {"c", "feature"});
    add(all, "description", {"desc", "d", "remark", "bemerkung", "note"});
    for (const auto& [own, local] : {std::pair{"cov_ee", "cov_xx"},
                                     {"cov_en", "cov_xy"},
                                     {"cov_eh", "cov_xz"},
                                     {"cov_nn", "cov_yy"},
                                     {"cov_nh", "cov_yz"},
                                     {"cov_hh", "cov_zz"}})
      add(all, own, {local});
    return all;
  }();
  return names;
}

bool looks_like_an_accuracy(const std::string& written) {
  for (const char* start : {"sig",
                            "std",
                            "sd",
                            "s_",
                            "acc",
                            "prec",
                            "pr\xC3\xA9"
                            "c",
                            "rms",
                            "hrms",
                            "vrms",
                            "err",
                            "unc",
                            "cov",
                            "var",
                            "genau",
                            "standardabw",
                            "standard_dev",
                            "mittl",
                            "ecart",
                            "\xC3\xA9"
                            "cart",
                            "emq",
                            "\xCF\x83"})
    if (written.starts_with(start)) return true;
  for (const char* end :
       {"_acc", "_accuracy", "_sigma", "_std", "_stdev", "_sd", "_rms", "_error", "_err", "_precision"})
    if (written.ends_with(end)) return true;
  return false;
}

double metres_in(const std::string& unit) {
  static const std::map<std::string, double> known = {
      {"", 1},       {"m", 1},     {"meter", 1}, {"meters", 1},  {"metre", 1},
      {"metres", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"ft", 0.3048}, {"usft", 1200.0 / 3937.0}};
  const auto found = known.find(unit);
  return found == known.end() ? kNotGiven : found->second;
}

bool is_shortened(std::string_view number) {
  const std::size_t e = number.find_first_of("eE");
  if (e == std::string_view::npos || e == 0) return false;
  const auto exponent =
      text::parse_integer(number.substr(e + 1).starts_with('+') ? number.substr(e + 2) : number.substr(e + 1));
  if (!exponent) return false;
  const std::string_view mantissa = number.substr(0, e);
  const std::size_t point = mantissa.find_first_of(".,");
  const auto decimals = point == std::string_view::npos ? 0 : static_cast<long long>(mantissa.size() - point) - 1;
  return *exponent - decimals >= 0 && *exponent > 0;
}

bool is_northing_beside(double north, double east) {
  const auto in = [](double value, double from, double to) { return value >= from && value <= to; };
  if (in(north, 3.5e6, 9.9e6) && std::abs(east) < 1.3e6) return true;
  if (in(north, 3.5e6, 9.9e6) && in(east, 1.1e7, 6.1e7)) return true;
  const double in_zone = std::fmod(east, 1e6);
  if (in(north, 5.2e6, 6.2e6) && in(east, 1e6, 5e6) && in(in_zone, 3.0e5, 7.0e5)) return true;
  return in(north, 1.07e6, 1.3e6) && in(east, 2.48e6, 2.84e6);
}

PlanAxes axes_of_xy(const std::vector<text::CsvHeaderCell>& header, bool y_stands_first, double x, double y,
                    double height) {
  const double radius = std::sqrt(x * x + y * y + height * height);
  if (std::abs(height) > 2e4 && radius > 6.34e6 && radius < 6.4e6)
    return {false, "their distance from the centre of the earth shows geocentric coordinates", ""};
  const bool german = std::any_of(header.begin(), header.end(), [](const auto& c) { return is_german(c.written); });
  const bool with_z = std::any_of(header.begin(), header.end(), [](const auto& c) { return c.written == "z"; });
  const bool x_north = is_northing_beside(x, y), y_north = is_northing_beside(y, x);
  const std::string values = fmt::format("values near X = {:.0f} m, Y = {:.0f} m", x, y);
  const std::string named = german ? "the other columns have German names" : "";
  const bool says_y_east = german && (y_stands_first || !with_z);
  const std::string order = y_stands_first ? "Y stands in front of X" : "X stands in front of Y";
  if (x_north) {
    if (!german && !y_stands_first)
      return {true, "",
              std::string(values) + ", as X has them where it is the northing, beside English names and " + order};
    return {true, values, ""};
  }
  if (y_north) {
    if (says_y_east)
      return {false, "", std::string(values) + ", as Y has them where it is the northing, though " + named};
    return {false, values, ""};
  }
  if (says_y_east) return {true, named, ""};
  if (german) return {false, "", "X, Y and Z among German names, where X may be the north or the east"};
  if (y_stands_first) return {false, "", "Y in front of X, so that either may be the east"};
  return {false, "nothing speaks against it", ""};
}

double typical_value(const text::CsvTable& table, std::size_t column, double unit) {
  std::vector<double> values;
  for (const text::CsvRow& row : table.rows)
    if (column < row.cells.size())
      if (const auto value = table.number(row.cells[column])) values.push_back(*value * unit);
  return values.empty() ? kNotGiven : upper_median(std::move(values));
}

}  // namespace plumbline::control

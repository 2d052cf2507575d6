// What columns of tables of points mean: their names in five languages, their units, and which of X and Y is east.
#pragma once

#include <limits>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "base/text/csv_table.hpp"

namespace plumbline::control {

inline constexpr double kNotGiven = std::numeric_limits<double>::quiet_NaN();

/// What a normalised header cell may be called -> id, e, n, h, x, y, latitude, longitude, sigma (of every axis),
/// sigma_plan (of E and of N), sigma_e, sigma_n, sigma_h, cov_ee … cov_hh, role, code or description.
const std::map<std::string, std::string>& point_column_names();

/// Whether a header cell that is none of these speaks of an accuracy: dropped, another one would be assumed.
bool looks_like_an_accuracy(const std::string& written);

/// Metres in one of a unit of length ("", "m", "cm", "mm", "ft", "usft", also spelled out); nan for anything else.
double metres_in(const std::string& unit);

/// Whether a number was shortened on its way, as a spreadsheet shows 5412345.678 as 5.41E+06: in the notation with an
/// exponent, and its last digit stands for a metre or more.
bool is_shortened(std::string_view number);

/// Whether coordinates that are typical of a table [m] are northing and easting: a distance from the equator beside an
/// offset from a meridian (UTM, Lambert, Gauss-Krueger without zone), Gauss-Krueger or UTM with the number of the zone
/// in front of the easting, the Swiss LV95.
bool is_northing_beside(double north, double east);

/// Which of the columns X and Y is east, and why.
struct PlanAxes {
  bool y_is_east = false;
  std::string reason;
  std::string refusal;  ///< what contradicts itself; empty if the answer holds
};

/// From the names of the other columns, the order of X and Y and the typical values [m] of X, Y and height. Geodesists
/// of German-speaking countries count X to the north and Y to the east, nearly everybody else the other way round.
PlanAxes axes_of_xy(const std::vector<text::CsvHeaderCell>& header, bool y_stands_first, double x, double y,
                    double height);

/// The median of the numbers in a column, times `unit`; nan without one.
double typical_value(const text::CsvTable& table, std::size_t column, double unit);

}  // namespace plumbline::control

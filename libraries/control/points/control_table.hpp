// A table of known points: one dialect wherever control is given.
//
// With a header, columns go by their names (control/point_columns.hpp) in any order and unit. Without one every row is
// a name, E, N, H and perhaps one or three standard deviations, or a number and a name before them; text behind the
// numbers is a description. Every column is used, named among the notes, or refused.
#pragma once

#include <string>
#include <vector>

#include "control/points/control_point.hpp"

namespace plumbline::control {

enum class Axes {
  as_named,  ///< by names and values, see axes_of_xy()
  x_east,
  x_north
};

struct ControlOptions {
  Axes axes = Axes::as_named;
  bool has_second_names = false;  ///< points go by a number or by a name: both columns are wanted
};

struct ControlTable {
  std::vector<ControlPoint> points;
  std::vector<std::string> notes;     ///< what was not used
  std::string axes;                   ///< how the axes of the plan were taken where no column says it; else empty
  std::vector<std::string> warnings;  ///< what was assumed and should be looked at
  bool has_sigmas = false;            ///< whether any standard deviation is given
  bool sigmas_say_unit = false;       ///< whether the unit of one is said
};

/// Points of a table. Throws std::runtime_error that names file and line: for a column that looks like an accuracy and
/// is unknown, for a unit that is unknown, for a name that occurs twice, for a number that a spreadsheet has shortened,
/// for a row that may be a comment, for axes that contradict themselves (columns E and N say which is which), and for a
/// table without a header whose numbers may be something else.
ControlTable parse_control_table(const std::string& text, const std::string& file, const ControlOptions& options = {});

}  // namespace plumbline::control

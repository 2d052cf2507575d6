// A project's tolerance classes as a table: what a standard or a contract asks for, in numbers that somebody checked.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "building/judgement/tolerance_rules.hpp"

namespace plumbline::judgement {

/// Whether it has columns for what is selected and for a tolerance.
bool is_table_of_tolerances(std::string_view csv);

/// Rules of a table of tolerance classes, in its order; none of an empty text. Columns, by English or German names:
/// class, select (which elements, in the language of ifc::Selection), and tolerances with the unit in the name,
/// vertical_mm, horizontal_mm, in_plane_mm, out_of_plane_mm, space_mm, joint_mm (or _m): a length, two sides such as
/// "+5/-2" where the length has a sign, 0 for not judged, empty for not said; note is for people, and optional
/// ("yes") says that a building may have nothing of it. Each rule's text
/// names the row: "tolerances.csv:4, class A: class=IfcPlate: vertical=3mm". `shown` names the file. Throws
/// std::runtime_error with a line for everything that is wrong (the first 25): file, line, column, what was found and
/// what is expected.
std::vector<ToleranceRule> parse_tolerance_classes(std::string_view csv, const std::string& shown);

}  // namespace plumbline::judgement

// What a table in a site's folder is for, told by the names of its columns and by its own name. Whether its rows can be
// read is another question: a table with a mistake in it is no less a table of plates or of known points.
#pragma once

#include <string>

namespace plumbline::campaign {

/// A plates.csv: columns for an anchor and a tag's number.
bool is_table_of_plates(const std::string& text);

/// An observations.csv: tags that another program has measured.
bool is_table_of_tags(const std::string& text);

/// Columns for a name and for E and N, or X and Y; titles may stand above them.
bool has_columns_of_places(const std::string& text);
/// The same, or for H alone.
bool has_columns_of_points(const std::string& text);

/// A table of names: points and the elements of the design that they are on.
bool is_table_of_names(const std::string& text);

/// Columns for a station, a target and a direction, a zenith angle or a slope distance: readings of a total station,
/// also where a unit is missing or a cell is wrong.
bool has_columns_of_sightings(const std::string& text);

/// `name` of a file says that it holds known points: "control.csv", "Festpunkte Nord.csv".
bool is_called_control(const std::string& name);

/// Whether `file` is what a site gives known points as: a table (.csv, .txt) with columns of points, or a .csv under
/// such a name, whatever is wrong with its header.
bool looks_like_control(const std::string& text, const std::string& file);

}  // namespace plumbline::campaign

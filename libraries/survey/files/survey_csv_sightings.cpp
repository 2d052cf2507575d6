#include "survey/files/survey_csv_sightings.hpp"

#include <algorithm>
#include <map>
#include <set>
#include <string>

namespace plumbline::survey {
namespace {

[[noreturn]] void refuse(const text::CsvTable& table, const SurveyBuilder& builder, const std::string& found,
                         const std::string& expected) {
  throw SurveyReadError(builder.at(table.header_line, 1), found, expected);
}

/// A height of what, an azimuth in place of what: a table of sightings has no place for these, and may need them.
void refuse_doubtful_names(const text::CsvTable& table, const SurveyColumns& columns, const SurveyBuilder& builder) {
  const bool rises = columns.has("zenith") || columns.has("height_difference");
  const bool coordinates = columns.has("e") && columns.has("n");
  if (columns.has("h") && !coordinates && !(columns.has("target_height") && rises))
    refuse(table, builder,
           "the column " + text::quoted(columns.written("h")) +
               " in a table of sightings, which may be a target height" + (rises ? "" : " or a zenith angle"),
           std::string("a name that says which: target_height") + (rises ? "" : ", or zenith") +
               "; a height of the point itself is no reading: leave it out");
  if (columns.has("azimuth") && !columns.has("direction"))
    refuse(table, builder, "the column " + text::quoted(columns.written("azimuth")) + " in a table of sightings",
           "directions of the circle (hz): those that are oriented already are directions, too");
}

/// In a table of sightings these words are readings or heights, and do not say which.
void refuse_readings_of_no_name(const text::CsvTable& table, const SurveyColumns& columns,
                                const SurveyBuilder& builder) {
  static const std::map<std::string, std::string> kWords = {
      {"strecke", "distance"},     {"distanz", "distance"},       {"entfernung", "distance"}, {"distance", "distance"},
      {"dist", "distance"},        {"distancia", "distance"},     {"distanza", "distance"},   {"winkel", "angle"},
      {"angle", "angle"},          {"angulo", "angle"},           {"\xC3\xA1ngulo", "angle"}, {"angolo", "angle"},
      {"vertikalwinkel", "angle"}, {"horizontalwinkel", "angle"}, {"hauteur", "height"},      {"altezza", "height"}};
  const bool distance = columns.has("slope_distance") || columns.has("horizontal_distance");
  const bool angles = columns.has("direction") && columns.has("zenith");
  for (const text::CsvHeaderCell& cell : table.header) {
    const auto word = kWords.find(cell.name);
    if (word == kWords.end()) continue;
    const std::string& what = word->second;
    if (what == "distance" ? distance : what == "angle" ? angles : columns.has("target_height")) continue;
    refuse(table, builder, "the column " + text::quoted(cell.written) + " in a table of sightings",
           what == "distance" ? "a name that says which: slope_distance (Schr\xC3\xA4gstrecke) or horizontal_distance "
                                "(Horizontalstrecke)"
           : what == "angle"  ? "a name that says which: hz (Richtung) or v (Zenitwinkel)"
                              : "a name that says which: target_height or instrument_height");
  }
}

void name_unused(const SurveyColumns& columns, SurveyBuilder& builder) {
  static const std::set<std::string> kUsed = {
      "station", "target", "set_up", "direction", "zenith", "slope_distance", "horizontal_distance",
      "height_difference", "instrument_height", "target_height", "face",
      // No number of a reading: sets are counted by the rows, names and remarks change nothing.
      "id", "code", "description", "set", "pointing", "source_file", "source_line", "source_column"};
  std::string unused;
  bool accuracy = false;
  for (const std::string& name : columns.names()) {
    if (kUsed.contains(name)) continue;
    unused += (unused.empty() ? "" : ", ") + text::quoted(columns.written(name));
    accuracy = accuracy || name.starts_with("sigma") || name.starts_with("cov_");
  }
  if (unused.empty()) return;
  builder.warn("columns that a table of sightings does not use are left out: " + unused +
               (accuracy ? "; how accurate readings are is that of the instrument's profile" : ""));
}

bool rises_with_heights(const SurveyColumns& columns) {
  for (const char* reading : {"zenith", "slope_distance", "height_difference"})
    if (!columns.text(reading).empty()) return true;
  return false;
}

/// An empty cell means 0 m, or "as above"; which of the two makes 1.5 m. The height of an instrument is its set-up's,
/// so that its first row is enough, whatever that reads, unless other rows of it have another one.
void refuse_gaps(const text::CsvTable& table, SurveyColumns& columns, SurveyBuilder& builder, const std::string& column,
                 bool first_of_set_up) {
  struct SetUpHeights {
    bool in_first_row = false;
    std::set<std::string> written;
  };
  if (!columns.has(column)) return;
  std::map<std::string, SetUpHeights> set_ups;
  const text::CsvRow* first = nullptr;
  std::string of;
  std::size_t gaps = 0, filled = 0;
  for (const text::CsvRow& row : table.rows) {
    columns.select(row);
    const std::string own = columns.text("set_up"), station = own.empty() ? columns.text("station") : own;
    const std::string height = columns.text(column);
    const auto [at, is_new] = set_ups.try_emplace(station);
    SetUpHeights& set_up = at->second;
    if (is_new) set_up.in_first_row = !height.empty();
    if (!height.empty()) ++filled, set_up.written.insert(height);
    if (!height.empty() || !rises_with_heights(columns)) continue;
    if (first_of_set_up && set_up.in_first_row && set_up.written.size() == 1) continue;
    if (gaps++ == 0) first = &row, of = first_of_set_up ? station : columns.text("target");
  }
  if (gaps == 0) return;
  if (filled == 0)
    return builder.warn("the column " + text::quoted(columns.written(column)) +
                        " is empty in all rows: heights of 0 m " + "are assumed; fill it where they were not");
  throw SurveyReadError(builder.at(first->line, 1),
                        "no " + text::quoted(columns.written(column)) + (first_of_set_up ? " at " : " of ") +
                            text::quoted(of) + (gaps > 1 ? " and " + std::to_string(gaps - 1) + " more" : "") +
                            " in a column that has it in " + std::to_string(filled) + " of " +
                            std::to_string(table.rows.size()) + " rows",
                        first_of_set_up ? "the instrument height in the first row of each set-up, 0 where there is none"
                                        : "the target height in every row, 0 where there is none");
}

}  // namespace

void check_sightings(const text::CsvTable& table, SurveyColumns& columns, SurveyBuilder& builder) {
  refuse_doubtful_names(table, columns, builder);
  refuse_readings_of_no_name(table, columns, builder);
  name_unused(columns, builder);
  refuse_gaps(table, columns, builder, "target_height", false);
  refuse_gaps(table, columns, builder, "instrument_height", true);
}

}  // namespace plumbline::survey

#include "recognise_tables.hpp"

#include <algorithm>
#include <filesystem>
#include <initializer_list>

#include "base/text/csv_table.hpp"
#include "base/text/text.hpp"
#include "campaign_folder.hpp"
#include "control/points/point_columns.hpp"
#include "survey/files/survey_csv_columns.hpp"

namespace plumbline::campaign {
namespace {

bool has_columns(const text::CsvTable& table, std::initializer_list<const char*> names) {
  return std::all_of(names.begin(), names.end(), [&](const char* name) {
    return std::any_of(table.header.begin(), table.header.end(), [&](const auto& cell) { return cell.name == name; });
  });
}

}  // namespace

bool is_table_of_plates(const std::string& text) {
  return has_columns(text::read_csv(text, plate_column_names(), text::TitleRows::passed_over), {"anchor", "tag_id"});
}

bool is_table_of_tags(const std::string& text) {
  return text.find("tag_id") < 1024 &&
         has_columns(text::read_csv(text, {{"image", "image"}, {"tag_id", "tag_id"}}), {"image", "tag_id"});
}

bool has_columns_of_places(const std::string& text) {
  const text::CsvTable table = text::read_csv(text, control::point_column_names(), text::TitleRows::passed_over);
  return has_columns(table, {"id", "e", "n"}) || has_columns(table, {"id", "x", "y"});
}

bool has_columns_of_points(const std::string& text) {
  const text::CsvTable table = text::read_csv(text, control::point_column_names(), text::TitleRows::passed_over);
  return has_columns(table, {"id", "e", "n"}) || has_columns(table, {"id", "x", "y"}) ||
         has_columns(table, {"id", "h"});
}

bool is_table_of_names(const std::string& text) {
  return has_columns(text::read_csv(text, {{"point", "point"},
                                           {"name", "point"},
                                           {"anchor", "point"},
                                           {"element", "element"},
                                           {"guid", "element"},
                                           {"globalid", "element"},
                                           {"global_id", "element"},
                                           {"tag", "element"}}),
                     {"point", "element"});
}

bool has_columns_of_sightings(const std::string& text) {
  const text::CsvTable table = text::read_csv(text, survey::survey_column_names());
  return has_columns(table, {"station", "target", "direction"}) ||
         has_columns(table, {"station", "target", "zenith"}) ||
         has_columns(table, {"station", "target", "slope_distance"});
}

bool is_called_control(const std::string& name) {
  const std::string stem = text::to_lower(std::filesystem::path(name).stem().string());
  const auto words = {"control", "festpunkt", "passpunkt", "fixpunkt", "anschlusspunkt", "known_points", "gcp"};
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return stem.find(w) != std::string::npos; });
}

bool looks_like_control(const std::string& text, const std::string& file) {
  const std::string ending = text::to_lower(std::filesystem::path(file).extension().string());
  if (ending != ".csv" && ending != ".txt") return false;
  return has_columns_of_points(text) || (ending == ".csv" && is_called_control(file) && !text.empty());
}

}  // namespace plumbline::campaign

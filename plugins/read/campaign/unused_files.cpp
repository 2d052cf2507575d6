#include "unused_files.hpp"

#include <algorithm>
#include <fstream>

#include "base/text/whole_file.hpp"
#include "photo/images/photograph_header.hpp"
#include "plumbline/folder_files.hpp"
#include "recognise_tables.hpp"
#include "survey/files/survey_builder.hpp"
#include "survey/files/survey_format.hpp"
#include "workbook_tables.hpp"

namespace plumbline::campaign {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kBeginning = 16384;           // what detect_survey_format() looks at [bytes]
constexpr std::uintmax_t kLargestTable = 20 << 20;  // a table that is read whole to see whether it holds readings

std::string beginning_of(const fs::path& path, std::size_t bytes) {
  std::ifstream stream(path, std::ios::binary);
  std::string text(bytes, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(bytes));
  text.resize(stream.gcount());
  return text;
}

bool holds_known_points(const fs::path& path, const std::string& name) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size == 0 || size > kLargestTable) return false;
  const std::string bytes = beginning_of(path, size);
  if (!is_workbook(path)) return looks_like_control(bytes, name);
  try {
    const std::vector<WorkbookSheet> sheets = sheets_of(bytes, name);
    // "Nr, Breite, Höhe" is a sheet of panels: heights alone are known points where the name says so.
    return std::any_of(sheets.begin(), sheets.end(), [&](const auto& sheet) {
      const bool called = is_called_control(name) || is_called_control(sheet.name);
      return called ? has_columns_of_points(sheet.csv) : has_columns_of_places(sheet.csv);
    });
  } catch (const std::runtime_error&) {  // a workbook of something else may be protected
    return is_called_control(name);
  }
}

/// Sheets of known points that lie beside the table which a workbook is named for.
std::vector<std::string> sheets_of_known_points(const fs::path& path) {
  std::vector<std::string> names;
  try {
    for (const WorkbookSheet& sheet : sheets_of(text::read_whole(path), path))
      if (has_columns_of_places(sheet.csv) && !is_table_of_plates(sheet.csv) && !is_table_of_tags(sheet.csv))
        names.push_back(sheet.name);
  } catch (const std::runtime_error&) {  // who reads it says so
  }
  return names;
}

/// With `control_too`, because no other table is named for it.
std::string looks_like(const fs::path& root, const std::string& path, bool control_too) {
  if (is_system_file(path)) return "";
  if (is_photograph_name(path)) return "photograph";
  if (holds_readings(root / path, path)) return "survey";
  return control_too && holds_known_points(root / path, path) ? "control" : "";
}

std::string names_of(const std::vector<std::string>& names) {
  constexpr std::size_t most = 8;
  std::string text;
  for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i ? ", " : "") + names[i];
  return names.size() > most ? text + " and " + std::to_string(names.size() - most) + " more" : text;
}

std::string plural(std::size_t n, const std::string& one) {
  return std::to_string(n) + " " + one + (n == 1 ? "" : "s");
}

}  // namespace

bool holds_readings(const fs::path& path, const std::string& name) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(path, error);
  if (error || size == 0) return false;
  const auto format = survey::detect_survey_format(beginning_of(path, kBeginning), name);
  if (!format) return false;
  const bool table = *format == survey::SurveyFormat::csv || *format == survey::SurveyFormat::setup_coordinates;
  if (size > kLargestTable) return !table;
  try {
    const survey::SurveyObservations found = survey::read_survey(beginning_of(path, size), name);
    if (!found.observations.empty()) return true;
    return table ? has_columns_of_sightings(beginning_of(path, kBeginning)) : !found.skipped.empty();
  } catch (const std::runtime_error&) {
    return !table || has_columns_of_sightings(beginning_of(path, kBeginning));
  }
}

std::vector<std::string> patterns_for(const std::vector<std::string>& names) {
  std::map<std::string, std::vector<std::string>> groups;
  for (const std::string& name : names) {
    const fs::path path = name;
    groups[(path.parent_path() / ("*" + path.extension().string())).generic_string()].push_back(name);
  }
  std::vector<std::string> patterns;
  for (const auto& [pattern, members] : groups) patterns.push_back(members.size() > 1 ? pattern : members.front());
  return patterns;
}

std::map<std::string, std::string> uses_of(const CampaignDescription& d, const std::vector<std::string>& files) {
  std::map<std::string, std::string> uses;
  const auto add = [&](const std::string& path, const char* use) {
    if (!path.empty()) uses.emplace(path, use);
  };
  if (std::find(files.begin(), files.end(), "campaign.yaml") != files.end()) add("campaign.yaml", "campaign");
  for (const std::string& path : d.images) add(path, "photograph");
  add(d.observations, "observations");
  for (const CameraOfImages& camera : d.cameras) add(camera.file, "camera");
  add(d.plates, "plates");
  for (const std::string& path : d.survey) add(path, "survey");
  add(d.control, "control");
  add(d.design, "design");
  add(d.mapping, "mapping");
  add(d.tolerances, "tolerances");
  return uses;
}

std::vector<UnusedFile> unused_files(const CampaignDescription& description, const fs::path& root,
                                     std::vector<std::string> files) {
  const auto uses = uses_of(description, files);
  const bool is_left_out = description.control_left_out && description.control.empty();
  std::sort(files.begin(), files.end());
  std::vector<UnusedFile> unused;
  for (const std::string& path : files) {
    const auto& aside = description.unused;
    const bool used = uses.count(path) > 0, is_set_aside = std::find(aside.begin(), aside.end(), path) != aside.end();
    if (used && is_workbook(path) && is_left_out)
      for (const std::string& sheet : sheets_of_known_points(root / path))
        unused.push_back({path, sheet, "control",
                          is_set_aside || std::find(aside.begin(), aside.end(), path + "#" + sheet) != aside.end()});
    if (used) continue;
    unused.push_back({path, "", looks_like(root, path, is_left_out), is_set_aside});
  }
  return unused;
}

std::vector<std::string> forgotten_control(const std::vector<UnusedFile>& unused) {
  std::vector<std::string> names;
  for (const UnusedFile& file : unused)
    if (!file.set_aside && file.looks_like == "control") names.push_back(file.name());
  return names;
}

std::string words_of_forgotten_control(const std::vector<std::string>& names) {
  const bool one = names.size() == 1;
  return names_of(names) + (one ? " looks like a table of known points" : " look like tables of known points") +
         ", and nothing names " + (one ? "it" : "them") +
         ": unless the survey's files have known points, none holds the result. Name the one that carries the datum "
         "under 'control', or leave " +
         (one ? "it" : "them") + " out by 'unused' (a sheet: Tables.xlsx#Sheet, or hide it)";
}

void refuse_forgotten(const std::vector<UnusedFile>& unused, const CampaignDescription& description,
                      const fs::path& root, CampaignUse use, bool understood) {
  const bool wants_photographs = use != CampaignUse::survey && use != CampaignUse::measured &&
                                 description.observations.empty() && (understood || !description.images.empty());
  const bool wants_readings = understood || !description.survey.empty();
  std::vector<std::string> photographs, readings;
  for (const UnusedFile& file : unused) {
    if (file.set_aside) continue;
    if (file.looks_like == "photograph" && wants_photographs) photographs.push_back(file.path);
    if (file.looks_like == "survey" && wants_readings) readings.push_back(file.path);
  }
  if (photographs.empty() && readings.empty()) return;
  std::string text, all;
  if (!photographs.empty()) text += plural(photographs.size(), "photograph") + " (" + names_of(photographs) + ")";
  if (!readings.empty())
    text += (text.empty() ? "" : " and ") + plural(readings.size(), "survey file") + " (" + names_of(readings) + ")";
  for (const auto* names : {&photographs, &readings})
    for (const std::string& pattern : patterns_for(*names))
      all += (all.empty() ? "" : ", ") +
             (pattern.find_first_of("*,[]{}#&!|>'\"%@` ") == std::string::npos ? pattern : "\"" + pattern + "\"");
  const std::string keys = photographs.empty() ? "'survey'" : readings.empty() ? "'images'" : "'images' and 'survey'";
  throw CampaignError(root / "campaign.yaml", 0,
                      "the folder holds " + text + " that nothing names, so they would take no part. Name them under " +
                          keys + " to use them, or leave them out by the line  unused: [" + all + "]");
}

}  // namespace plumbline::campaign

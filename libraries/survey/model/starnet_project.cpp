#include "survey/model/starnet_project.hpp"

#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "base/text/text.hpp"

namespace plumbline::survey {

namespace {

constexpr double kArcsecond = std::numbers::pi / 180 / 3600;

struct Value {
  std::string text;
  int line = 0;
};
using Section = std::map<std::string, Value>;

[[noreturn]] void fail(const std::string& origin, int line, const std::string& what) {
  throw std::runtime_error(origin + ":" + std::to_string(line) + ": " + what);
}

double number(const Section& section, const std::string& key, const std::string& origin, int line) {
  const auto at = section.find(key);
  if (at == section.end()) fail(origin, line, "the instrument has no " + key);
  const auto value = text::parse_number(at->second.text);
  if (!value || *value < 0 || !std::isfinite(*value))
    fail(origin, at->second.line, key + " is '" + at->second.text + "', expected a number of zero or more");
  return *value;
}

InstrumentProfile profile_of(const Section& s, const std::string& name, const std::string& origin, int line) {
  const auto get = [&](const char* key) { return number(s, key, origin, line); };
  InstrumentProfile p;
  p.name = name;
  p.direction_sigma = get("direction_std_err") * kArcsecond;
  p.zenith_sigma = get("zenith_std_err") * kArcsecond;
  p.angle_sigma = get("angle_std_err") * kArcsecond;
  p.azimuth_sigma = get("azimuth_std_err") * kArcsecond;
  p.distance_constant = get("distance_std_err");
  p.distance_ppm = get("edm_ppm");
  p.instrument_centring = get("instrument_centering_error");
  p.target_centring = get("target_centering_error");
  p.height_centring = std::numbers::sqrt2 * get("vertical_centering_error");  // of each end
  if (p.direction_sigma <= 0 || p.zenith_sigma <= 0 || p.distance_constant <= 0)
    fail(origin, line, "standard errors of directions, zenith angles and distances of '" + name + "' must be positive");
  return p;
}

struct Document {
  Section adjustment, instrument;
  std::vector<std::pair<std::string, Section>> library;
  std::vector<std::string> files;
  int instrument_line = 0;
};

/// "3 "day one.dat"": the first bit of the number says whether the file is switched on.
void add_file(const std::string& line, Document& document) {
  const auto open = line.find('"'), close = line.rfind('"');
  const auto flags = text::parse_number(text::trim(line.substr(0, open)));
  if (open == std::string::npos || close <= open || !flags) return;
  if (static_cast<int>(*flags) % 2 == 1) document.files.push_back(line.substr(open + 1, close - open - 1));
}

Document read(const std::string& content) {
  Document document;
  std::string section;
  for (const text::Line& line : text::split_lines(content)) {
    const std::string words(text::trim(line.text));
    if (words.empty() || words.front() == '#') continue;
    if (words.front() == '[' && words.back() == ']') {
      section = words.substr(1, words.size() - 2);
      if (section == "Instrument") document.instrument_line = line.number;
      continue;
    }
    if (section == "DataFileList") add_file(words, document);
    const auto blank = words.find_first_of(" \t");
    if (blank == std::string::npos) continue;
    const std::string key = words.substr(0, blank);
    const Value value{std::string(text::trim(words.substr(blank))), line.number};
    if (section == "Adjustment") document.adjustment[key] = value;
    if (section == "Instrument") document.instrument[key] = value;
    if (section == "InstrumentLibrary" && key == "instrument_name") document.library.push_back({value.text, {}});
    if (section == "InstrumentLibrary" && !document.library.empty()) document.library.back().second[key] = value;
  }
  return document;
}

std::vector<std::string> settings_of(const Section& adjustment) {
  const auto is = [&](const char* key) {
    const auto at = adjustment.find(key);
    return at == adjustment.end() ? std::string() : at->second.text;
  };
  const auto number_of = [&](const char* key) { return text::parse_number(is(key)).value_or(0); };
  std::vector<std::string> all;
  if (!is("coordinate_order").empty())
    all.push_back("coordinates " + is("coordinate_order") + ", angles " + is("angle_station_order") +
                  " (.ORDER in the data files)");
  if (is("local_or_grid_adjustment") == "1")
    all.push_back("the map " + is("coordinate_system_name") + " (map=EPSG:CODE)");
  else if (number_of("scale_factor") != 1)
    all.push_back("a scale factor " + is("scale_factor"));
  std::ostringstream refraction;
  refraction << 2 * number_of("index_of_refraction");
  if (!is("index_of_refraction").empty())
    all.push_back("coefficient of refraction " + is("index_of_refraction") +
                  " (refraction_coefficient=" + refraction.str() + ", which is that of (1 - k) s^2/2R)");
  if (number_of("geoid_height") != 0) all.push_back("geoid height " + is("geoid_height") + " (geoid_height)");
  if (number_of("vert_defl_north") != 0 || number_of("vert_defl_east") != 0)
    all.push_back("deflection of the vertical " + is("vert_defl_north") + ", " + is("vert_defl_east") +
                  " (deflection)");
  if (is("geoid_modeling") == "1" || is("vert_defl_modeling") == "1") all.push_back("a geoid model (geoid_grid)");
  return all;
}

}  // namespace

bool is_starnet_project(const std::string& text) { return text::trim(text).starts_with("*STAR*NET"); }

StarNetProject parse_starnet_project(const std::string& text, const std::string& origin) {
  const Document document = read(text);
  const auto units = document.adjustment.find("linear_units");
  if (units == document.adjustment.end()) fail(origin, 1, "no linear_units in [Adjustment]: is it a whole project?");
  if (text::to_lower(units->second.text) != "meters")
    fail(origin, units->second.line,
         "linear_units are '" + units->second.text + "': projects in metres are read only, write a profile_file");
  if (document.instrument.empty()) fail(origin, 1, "no section [Instrument]");
  StarNetProject project;
  project.instrument = profile_of(document.instrument, "of " + origin, origin, document.instrument_line);
  if (document.instrument.contains("level_std_err")) {  // of a metre of line, growing with the root
    const auto type = document.instrument.find("level_section_type");
    if (type == document.instrument.end() || type->second.text != "LENGTH")
      fail(origin, document.instrument_line, "levelling weighted otherwise than by LENGTH is not read");
    project.instrument.height_difference_per_sqrt_km =
        std::sqrt(1000.0) * number(document.instrument, "level_std_err", origin, document.instrument_line);
  }
  for (const auto& [name, section] : document.library) {
    InstrumentProfile& own = project.library[name];
    own = profile_of(section, name, origin, section.at("instrument_name").line);
    own.height_difference_per_sqrt_km = project.instrument.height_difference_per_sqrt_km;
  }
  project.files = document.files;
  project.settings = settings_of(document.adjustment);
  return project;
}

}  // namespace plumbline::survey

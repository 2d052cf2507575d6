#include "control/points/gcp_list.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "base/text/text.hpp"
#include "control/points/projection_unit.hpp"
#include "geometry/geodesy/map_projection.hpp"

namespace plumbline::control {
namespace {

constexpr const char* expected = "expected x y z column row image [name]";

[[noreturn]] void fail(const std::string& file, int line, const std::string& what) {
  throw std::runtime_error(file + ":" + std::to_string(line) + ": " + what);
}

/// The first line of a gcp_list.txt. OpenDroneMap takes EPSG codes, PROJ strings and "WGS84 UTM 16N".
bool is_projection(const std::string& line) {
  const std::string text = text::to_lower(line);
  for (const char* start : {"epsg:", "+proj", "+init", "wgs84", "nad83", "local"})
    if (text.rfind(start, 0) == 0) return text.find(',') == std::string::npos;
  return false;
}

/// Whether the line begins a projection as WKT, of version 1 or 2.
bool is_wkt(const std::string& line) {
  const std::string text = text::to_lower(line.substr(0, line.find_first_of("[(")));
  for (const char* name : {"projcs", "projcrs", "projectedcrs", "geogcs", "geogcrs", "geodcrs", "geoccs", "compd_cs",
                           "compoundcrs", "boundcrs", "local_cs", "engcrs"})
    if (text::trim(text) == name && text.size() < line.size()) return true;
  return false;
}

bool is_image_file(const std::string& word) {
  const std::string text = text::to_lower(word);
  for (const char* end : {".jpg", ".jpeg", ".png", ".tif", ".tiff", ".dng", ".webp", ".bmp"})
    if (text.ends_with(end)) return true;
  return false;
}

/// The cells between tabs where the first six are there, else the words between blanks and tabs.
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  for (const std::string_view cell : text::split(line, '\t')) cells.emplace_back(text::trim(cell));
  if (cells.size() >= 6 && std::none_of(cells.begin(), cells.begin() + 6, [](const auto& c) { return c.empty(); }))
    return cells;
  cells.clear();
  for (const std::string_view word : text::split_blanks(line)) cells.emplace_back(word);
  return cells;
}

GcpLine parse_line(const std::string& line, const std::string& file, int number) {
  constexpr double furthest = 1e9;  // [m] or [px]
  const std::vector<std::string> cells = cells_of(line);
  double values[5];
  for (size_t i = 0; i < 5; ++i) {
    const auto value = i < cells.size() ? text::parse_number(cells[i]) : std::nullopt;
    if (!value || cells.size() < 6) fail(file, number, "found " + text::quoted(line, 80) + ", " + expected);
    if (!(std::abs(*value) < furthest))
      fail(file, number, "found the value " + cells[i] + ", expected metres and pixels, below 1e9; correct it");
    values[i] = *value;
  }
  for (size_t i = 6; i < cells.size(); ++i)
    if (is_image_file(cells[i]))
      fail(file, number,
           "found '" + cells[i] + "' after the image '" + cells[5] + "', " + expected +
               ". If the image's name holds a blank, put tabs between all columns");
  return {{values[0], values[1], values[2]}, {values[3], values[4]}, cells[5], cells.size() > 6 ? cells[6] : ""};
}

void require_metres(const std::string& projection, const std::string& file, int line) {
  const std::string unit = other_unit_than_metres(projection);
  if (!unit.empty())
    fail(file, line,
         "found the projection '" + projection + "': the points are in " + unit +
             ", expected metres; transform them to a projected system in metres first (such as EPSG:32632), and write "
             "that in this line");
}

/// A projection as PROJ reads it: "WGS84 UTM 16N", OpenDroneMap's own, by its code; a string with the word that makes
/// it a map.
std::string as_proj_reads_it(const std::string& projection) {
  const std::string text = text::to_lower(projection);
  int zone = 0;
  char half = 0;
  if (std::sscanf(text.c_str(), "wgs84 utm %2d%c", &zone, &half) == 2 && zone >= 1 && zone <= 60 &&
      (half == 'n' || half == 's'))
    return fmt::format("EPSG:{}", (half == 'n' ? 32600 : 32700) + zone);
  return text.starts_with('+') && text.find("+type=") == std::string::npos ? projection + " +type=crs" : projection;
}

/// The map that the projection names; null where PROJ does not know it ("LOCAL").
std::unique_ptr<geodesy::MapProjection> map_of(const std::string& projection) {
  try {
    return std::make_unique<geodesy::MapProjection>(as_proj_reads_it(projection));
  } catch (const std::runtime_error&) {
    return nullptr;
  }
}

/// How much longer than on the ellipsoid the map draws `step` (100 m) from a place.
double length_factor(const geodesy::MapProjection& map, const Eigen::Vector2d& at, const Eigen::Vector2d& step) {
  const Eigen::Vector3d from = map.geocentric(map.inverse(at), 0), to = map.geocentric(map.inverse(at + step), 0);
  return step.norm() / (to - from).norm();
}

/// Heights are metres on every map. Where plan is not, photographs make heights of what is between both: on Mercator's
/// map (EPSG:3857) of 49° all are 1.5 times as high. Maps of surveys are within 0.4 % (Lambert 93 at its border).
void require_true_lengths(const std::string& projection, const std::vector<GcpLine>& lines, const std::string& file) {
  constexpr double kMost = 0.01;
  const auto map = map_of(projection);
  if (!map || lines.empty()) return;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  for (const GcpLine& line : lines) middle += line.position.head<2>() / static_cast<double>(lines.size());
  const std::string advice =
      "; check that the columns are east, north, height of this projection, or transform the points to one of true "
      "lengths (such as UTM, EPSG:32632) and write that in its line";
  for (const Eigen::Vector2d& step : {Eigen::Vector2d(100, 0), Eigen::Vector2d(0, 100)}) {
    double factor = std::numeric_limits<double>::infinity();
    try {
      factor = length_factor(*map, middle, step);
    } catch (const std::runtime_error&) {  // the map does not reach there
    }
    if (!(factor < std::numeric_limits<double>::infinity()))
      throw std::runtime_error(file + ": the map '" + map->name() + "' has no place at " +
                               fmt::format("{:.0f}, {:.0f}", middle.x(), middle.y()) + advice);
    if (std::abs(factor - 1) > kMost)
      throw std::runtime_error(file + ": the map '" + map->name() + "' draws lengths at the points " +
                               fmt::format("{:.3f}", factor) + " times as long as they are, and heights as they are" +
                               advice);
  }
}

}  // namespace

std::optional<std::vector<GcpLine>> gcp_lines(const std::string& text, const std::string& file) {
  const std::string decoded = text::decode_text(text).text;
  std::vector<GcpLine> lines;
  std::map<std::string, std::string> names;
  std::map<std::string, std::pair<Eigen::Vector3d, int>> positions;
  std::string projection;
  bool begun = false;
  for (const text::Line& at : text::split_lines(decoded)) {
    const std::string line(text::trim(at.text));
    if (line.empty() || line[0] == '#') continue;
    if (!begun) {
      if (is_wkt(line))
        fail(file, at.number,
             "found a projection as WKT ('" + line.substr(0, line.find_first_of("[(")) +
                 "'), which is not read; write its EPSG code in one line instead, such as EPSG:32632, or its PROJ "
                 "string");
      if (!is_projection(line)) return std::nullopt;
      require_metres(line, file, at.number);
      begun = true, projection = line;
      continue;
    }
    GcpLine g = parse_line(std::string(at.text), file, at.number);
    if (g.name.empty()) {
      std::ostringstream key;
      key.precision(12);
      key << g.position.transpose();
      g.name = names.emplace(key.str(), "gcp" + std::to_string(names.size() + 1)).first->second;
    }
    const auto [first, is_new] = positions.try_emplace(g.name, g.position, at.number);
    if (!is_new && (first->second.first - g.position).norm() > 1e-4)
      fail(file, at.number,
           "point " + g.name + " has other coordinates here than in line " + std::to_string(first->second.second) +
               "; one of the lines is of another point");
    lines.push_back(g);
  }
  if (!begun) return std::nullopt;
  if (lines.empty()) throw std::runtime_error(file + ": there is no point under the projection");
  require_true_lengths(projection, lines, file);
  return lines;
}

}  // namespace plumbline::control

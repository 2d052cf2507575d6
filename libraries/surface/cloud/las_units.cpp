// What a LAS file says of its unit: GeoTIFF keys (OGC 19-008, ProjLinearUnits 3076 and VerticalUnits 4099 with EPSG
// codes of units) or WKT (OGC 01-009, 18-010), before the points or, in LAS 1.4, behind them.
#include <algorithm>
#include <charconv>
#include <string_view>

#include "surface/cloud/cloud_stream.hpp"

namespace plumbline::cloud {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kFoot = 0.3048, kSurveyFoot = 1200.0 / 3937;

double unit_of_epsg(std::uint16_t code) {
  switch (code) {
    case 9001:
      return 1;
    case 9002:
      return kFoot;
    case 9003:
      return kSurveyFoot;
    default:
      return kNan;
  }
}

struct Units {
  double plan = kNan, height = kNan;
  bool degrees = false;
  std::string system;  ///< by its number
};

void take_geo_keys(const std::vector<char>& content, Units& units) {
  for (size_t at = 8; at + 8 <= content.size(); at += 8) {
    const auto key = number_at<std::uint16_t>(content.data() + at),
               value = number_at<std::uint16_t>(content.data() + at + 6);
    if (key == 1024 && value == 2) units.degrees = true;  // GTModelType: geographic
    if (key == 3072 && value > 0 && value < 32767) units.system = "EPSG:" + std::to_string(value);
    if (key == 3076) units.plan = unit_of_epsg(value);
    if (key == 4099) units.height = unit_of_epsg(value);
  }
}

/// WORD["text",number,WORD[...]] as a tree.
struct Wkt {
  std::string_view word;
  std::vector<std::string_view> values;
  std::vector<Wkt> parts;
};

/// Reads one node from `at` on and leaves `at` behind it. What is no WKT gives a node without a word.
Wkt read_wkt(std::string_view text, size_t& at, int depth) {
  constexpr int deepest = 40;
  constexpr std::string_view blanks = " \t\r\n,";
  Wkt node;
  const size_t start = std::min(text.find_first_not_of(blanks, at), text.size());
  at = std::min(text.find_first_of("[(", start), text.size());
  if (at == text.size() || depth > deepest) return node;
  node.word = text.substr(start, std::min(text.find_first_of(" \t\r\n[(", start), at) - start);
  ++at;
  while ((at = text.find_first_not_of(blanks, at)) < text.size() && text[at] != ']' && text[at] != ')') {
    if (text[at] == '"') {
      const size_t end = std::min(text.find('"', at + 1), text.size());
      node.values.push_back(text.substr(at + 1, end - at - 1));
      at = end + 1;
      continue;
    }
    const size_t end = std::min(text.find_first_of(",[]()\"", at), text.size());
    if (end < text.size() && (text[end] == '[' || text[end] == '(')) {
      node.parts.push_back(read_wkt(text, at, depth + 1));
      if (node.parts.back().word.empty()) at = text.size();
    } else {
      node.values.push_back(text.substr(at, end - at));
      at = end == at ? at + 1 : end;
    }
  }
  at = std::min(at, text.size()) + (at < text.size() ? 1 : 0);
  return node;
}

bool is_one_of(std::string_view word, std::initializer_list<std::string_view> words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

/// The unit of a system's own axes. Those of its ellipsoid, its datum and its projection's parameters stand deeper.
double own_length(const Wkt& system) {
  double length = kNan;
  for (const Wkt& part : system.parts) {
    if (!is_one_of(part.word, {"UNIT", "LENGTHUNIT"}) || part.values.size() < 2) continue;
    double factor = 0;
    std::from_chars(part.values[1].data(), part.values[1].data() + part.values[1].size(), factor);
    if (factor > 0) length = factor;
  }
  for (const Wkt& part : system.parts)
    if (part.word == "AXIS" && !std::isfinite(length)) length = own_length(part);
  return length;
}

bool has_cartesian_axes(const Wkt& system) {
  return std::any_of(system.parts.begin(), system.parts.end(), [](const Wkt& part) {
    return part.word == "CS" && !part.values.empty() && part.values[0].starts_with("CARTESIAN");
  });
}

void take_system(const Wkt& system, Units& units) {
  if (is_one_of(system.word, {"COMPD_CS", "COMPOUNDCRS", "BOUNDCRS", "SOURCECRS"}))
    for (const Wkt& part : system.parts) take_system(part, units);
  else if (is_one_of(system.word, {"GEOGCS", "GEOGCRS", "GEOGRAPHICCRS"}))
    units.degrees = true;
  else if (is_one_of(system.word, {"GEODCRS", "GEODETICCRS"}) && !has_cartesian_axes(system))
    units.degrees = true;
  else if (is_one_of(system.word, {"PROJCS", "PROJCRS", "PROJECTEDCRS", "LOCAL_CS", "ENGCRS", "ENGINEERINGCRS",
                                   "GEOCCS", "GEODCRS", "GEODETICCRS"}))
    units.plan = own_length(system);
  else if (is_one_of(system.word, {"VERT_CS", "VERTCRS", "VERTICALCRS"}))
    units.height = own_length(system);
}

void take_wkt(const std::vector<char>& content, Units& units) {
  std::string text(content.begin(), content.end());
  for (char& c : text) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  size_t at = 0;
  take_system(read_wkt(text, at, 0), units);
}

/// Takes the content that follows a record's head, if it is of a coordinate system.
void take_record(CloudStream& stream, const char* user, std::uint16_t id, std::uint64_t length, Units& units) {
  if (!std::string_view(user, 16).starts_with("LASF_Projection") || (id != 34735 && id != 2112)) return;
  constexpr std::uint64_t longest = 1 << 20;
  std::vector<char> content(std::min(length, longest));
  stream.read(content.data(), content.size(), "the coordinate system");
  if (id == 34735)
    take_geo_keys(content, units);
  else
    take_wkt(content, units);
}

/// Of LAS 1.4: records behind the points.
void take_extended(CloudStream& stream, const LasRecords& records, Units& units) {
  std::uint64_t at = records.extended_at;
  for (std::uint32_t record = 0; record < records.extended; ++record) {
    char head[60];
    if (at < records.points_at || at > stream.size() || stream.size() - at < sizeof head)
      stream.fail_at_byte(235, std::to_string(records.extended) +
                                   " records behind the points are announced, from byte " +
                                   std::to_string(records.extended_at) + " on; there is room for " +
                                   std::to_string(record) + "; the file was cut short");
    stream.seek(at);
    stream.read(head, sizeof head, "the records behind the points");
    const auto length = number_at<std::uint64_t>(head + 20);
    if (length > stream.left())
      stream.fail_at_byte(at + 20, "a record of " + std::to_string(length) + " bytes behind the points, the file has " +
                                       std::to_string(stream.left()) + " left; it was cut short");
    take_record(stream, head + 2, number_at<std::uint16_t>(head + 18), length, units);
    at += sizeof head + length;
  }
}

}  // namespace

void take_las_unit(CloudStream& stream, const LasRecords& records, CloudSummary& summary) {
  Units units;
  std::uint64_t at = records.header_size;
  const std::uint64_t points_at = records.points_at;
  for (std::uint32_t record = 0; record < records.count; ++record) {
    char head[54];
    if (at + sizeof head > points_at)
      stream.fail_at_byte(100, std::to_string(records.count) +
                                   " records before the points are announced; there is room for " +
                                   std::to_string(record));
    stream.seek(at);
    stream.read(head, sizeof head, "the records before the points");
    const auto id = number_at<std::uint16_t>(head + 18), length = number_at<std::uint16_t>(head + 20);
    if (at + sizeof head + length > points_at)
      stream.fail_at_byte(at + 20, "a record of " + std::to_string(length) + " bytes reaches into the points");
    take_record(stream, head + 2, id, length, units);
    at += sizeof head + length;
  }
  take_extended(stream, records, units);
  if (units.degrees)
    stream.fail_at_byte(
        records.header_size,
        "coordinates in longitude and latitude; expected lengths: bring the file into a projected or local system");
  if (std::isfinite(units.plan) && std::isfinite(units.height) && std::abs(units.height / units.plan - 1) > 1e-9)
    stream.fail_at_byte(records.header_size, "plan and height have different units: one is " +
                                                 std::to_string(units.plan) + " m, the other " +
                                                 std::to_string(units.height) + " m; bring both to metres");
  summary.unit = units.plan, summary.unit_of_heights = units.height;
  if (!std::isfinite(units.plan)) summary.without_unit_of = units.system;
}

}  // namespace plumbline::cloud

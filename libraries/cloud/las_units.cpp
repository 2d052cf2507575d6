// What a LAS file says of its unit: GeoTIFF keys (OGC 19-008, ProjLinearUnits 3076 and VerticalUnits 4099 with EPSG
// codes of units) or WKT (OGC 01-009, 18-010).
#include <charconv>
#include <string_view>

#include "cloud/cloud_stream.hpp"

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
};

void take_geo_keys(const std::vector<char>& content, Units& units) {
  for (size_t at = 8; at + 8 <= content.size(); at += 8) {
    const auto key = number_at<std::uint16_t>(content.data() + at),
               value = number_at<std::uint16_t>(content.data() + at + 6);
    if (key == 1024 && value == 2) units.degrees = true;  // GTModelType: geographic
    if (key == 3076) units.plan = unit_of_epsg(value);
    if (key == 4099) units.height = unit_of_epsg(value);
  }
}

/// All lengths of UNIT["name",factor] and LENGTHUNIT["name",factor], in order; angles are none.
std::vector<double> lengths_of(std::string_view wkt) {
  std::vector<double> lengths;
  for (size_t at = wkt.find("UNIT["); at != std::string_view::npos; at = wkt.find("UNIT[", at + 5)) {
    if (at >= 5 && wkt.substr(at - 5, 5) == "ANGLE") continue;
    if (at >= 5 && wkt.substr(at - 5, 5) == "SCALE") continue;
    const size_t comma = wkt.find(',', at);
    if (comma == std::string_view::npos) break;
    double factor = 0;
    std::from_chars(wkt.data() + comma + 1, wkt.data() + wkt.size(), factor);
    const bool angle = factor > 0.017 && factor < 0.0175;  // degree and gon (0.0157) in radians
    const bool gon = factor > 0.0157 && factor < 0.01571;
    if (factor > 0 && !angle && !gon) lengths.push_back(factor);
  }
  return lengths;
}

void take_wkt(std::string_view wkt, Units& units) {
  const std::vector<double> lengths = lengths_of(wkt);
  const bool projected =
      wkt.find("PROJC") != std::string_view::npos || wkt.find("LOCAL_CS") != std::string_view::npos ||
      wkt.find("ENGCRS") != std::string_view::npos || wkt.find("ENGINEERINGCRS") != std::string_view::npos;
  if (!projected && wkt.find("GEOG") != std::string_view::npos) units.degrees = true;
  if (lengths.empty()) return;
  units.plan = lengths.front();
  const bool vertical = wkt.find("VERT") != std::string_view::npos;
  if (vertical && lengths.size() > 1) units.height = lengths.back();
}

}  // namespace

double las_unit(CloudStream& stream, std::uint64_t header_size, std::uint32_t records, std::uint64_t points_at) {
  Units units;
  std::uint64_t at = header_size;
  for (std::uint32_t record = 0; record < records; ++record) {
    char head[54];
    if (at + sizeof head > points_at)
      stream.fail_at_byte(100, std::to_string(records) +
                                   " records before the points are announced; there is room for " +
                                   std::to_string(record));
    stream.seek(at);
    stream.read(head, sizeof head, "the records before the points");
    const auto id = number_at<std::uint16_t>(head + 18), length = number_at<std::uint16_t>(head + 20);
    if (at + sizeof head + length > points_at)
      stream.fail_at_byte(at + 20, "a record of " + std::to_string(length) + " bytes reaches into the points");
    if (std::string_view(head + 2).starts_with("LASF_Projection") && (id == 34735 || id == 2112)) {
      std::vector<char> content(length);
      stream.read(content.data(), length, "the coordinate system");
      if (id == 34735)
        take_geo_keys(content, units);
      else
        take_wkt({content.data(), content.size()}, units);
    }
    at += sizeof head + length;
  }
  if (units.degrees)
    stream.fail_at_byte(
        header_size,
        "coordinates in longitude and latitude; expected lengths: bring the file into a projected or local system");
  if (std::isfinite(units.plan) && std::isfinite(units.height) && std::abs(units.height / units.plan - 1) > 1e-9)
    stream.fail_at_byte(header_size, "plan and height have different units: one is " + std::to_string(units.plan) +
                                         " m, the other " + std::to_string(units.height) + " m; bring both to metres");
  return units.plan;
}

}  // namespace plumbline::cloud

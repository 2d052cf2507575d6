#include "survey/files/survey_csv_units.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "geometry/median.hpp"
#include "survey/files/survey_csv_columns.hpp"

namespace plumbline::survey {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::array<const char*, 4> kUnits = {"gon", "deg", "dms", "rad"};

/// Closures [rad] of one unit, absolute.
struct Closures {
  std::vector<double> faces, reciprocal;
};

double off(double angle, double from) { return std::abs(std::remainder(angle - from, 2 * kPi)); }

/// Misclosures of all pairs of sightings in `unit`; an angle that the unit does not have (61 minutes) closes nowhere.
Closures closures_of(const std::vector<UntoldSighting>& sightings, const std::string& unit) {
  Closures result;
  std::map<std::pair<std::string, std::string>, std::vector<const UntoldSighting*>> by_sight;
  for (const UntoldSighting& s : sightings) by_sight[{s.station, s.target}].push_back(&s);
  const auto si = [&](double value) { return SurveyColumns::in_si(value, unit); };
  const auto impossible = [&](const UntoldSighting* s) { return std::isnan(si(s->zenith)) && !std::isnan(s->zenith); };
  for (const auto& [sight, readings] : by_sight) {
    for (std::size_t i = 1; i < readings.size(); ++i) {
      if (impossible(readings[i]) || impossible(readings[i - 1])) result.faces.push_back(kPi);
      const double here = si(readings[i]->zenith), before = si(readings[i - 1]->zenith);
      // In two faces in one of the units: a zenith angle beyond half a circle and one below.
      if (!((here > kPi) != (before > kPi)) || std::isnan(here + before)) continue;
      result.faces.push_back(off(here + before, 0));
      const double turned = si(readings[i]->direction) - si(readings[i - 1]->direction);
      if (!std::isnan(turned)) result.faces.push_back(off(turned, kPi));
    }
    const auto back = by_sight.find({sight.second, sight.first});
    if (back == by_sight.end() || !(sight < back->first)) continue;
    for (const UntoldSighting* a : readings)
      for (const UntoldSighting* b : back->second)
        if (impossible(a) || impossible(b))
          result.reciprocal.push_back(kPi);
        else if (a->heights && b->heights && !std::isnan(a->zenith + b->zenith))
          result.reciprocal.push_back(off(si(a->zenith) + si(b->zenith) + a->rise + b->rise, kPi));
  }
  return result;
}

/// Whether all angles are the same in both units, as those of whole degrees are in degrees and in D.MMSS.
bool mean_the_same(const std::vector<UntoldSighting>& sightings, const char* a, const char* b) {
  constexpr double kAlike = 1e-12;  // [rad]; what a unit does not have is not a number, and like nothing
  return std::all_of(sightings.begin(), sightings.end(), [&](const UntoldSighting& s) {
    for (const double angle : {s.direction, s.zenith})
      if (!std::isnan(angle) && !(off(SurveyColumns::in_si(angle, a), SurveyColumns::in_si(angle, b)) < kAlike))
        return false;
    return true;
  });
}

/// The unit in which `misclosures` (one list a unit) close, if it is one alone, or the others say the same.
std::optional<std::size_t> closing(std::array<std::vector<double>, kUnits.size()>& misclosures, double tolerance,
                                   const std::vector<UntoldSighting>& sightings) {
  constexpr double kDistinct = 4;  // times better than any other
  std::array<double, kUnits.size()> size;
  for (std::size_t u = 0; u < kUnits.size(); ++u) size[u] = misclosures[u].empty() ? kPi : upper_median(misclosures[u]);
  const auto best = static_cast<std::size_t>(std::min_element(size.begin(), size.end()) - size.begin());
  if (size[best] > tolerance) return std::nullopt;
  for (std::size_t u = 0; u < kUnits.size(); ++u)
    if (u != best && size[u] <= std::max(tolerance, kDistinct * size[best]) &&
        !mean_the_same(sightings, kUnits[u], kUnits[best]))
      return std::nullopt;
  return best;
}

}  // namespace

std::optional<double> written_dms(std::string_view text) {
  std::string plain;  // the signs of degrees, minutes and seconds, whatever they are written with, as '-'
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if ((c >= '0' && c <= '9') || c == '.')
      plain += c;
    else if (c != ' ' && !plain.empty() && plain.back() != '-')
      plain += c == '-' || c == ':' || c == '\'' || c == '"' || static_cast<unsigned char>(c) >= 0x80 ? '-' : 'x';
  }
  while (!plain.empty() && plain.back() == '-') plain.pop_back();
  const auto parts = text::split(plain, '-');
  if (parts.size() != 3) return std::nullopt;
  const auto d = text::parse_number(parts[0]), m = text::parse_number(parts[1]), s = text::parse_number(parts[2]);
  if (!d || !m || !s || *d > 400 || *m >= 60 || *s >= 60 || parts[0].find('.') != std::string_view::npos)
    return std::nullopt;
  return degrees_to_rad(*d + *m / 60 + *s / 3600);
}

std::optional<AngleUnit> tell_angle_unit(const std::vector<UntoldSighting>& sightings) {
  constexpr double kFaces = 1.5e-3, kReciprocal = 1.5e-3;  // [rad]: 0.1 gon of collimation, index, refraction
  std::size_t beyond = 0;
  double largest = 0;
  for (const UntoldSighting& s : sightings)
    for (const double angle : {s.direction, s.zenith})
      if (!std::isnan(angle)) beyond += angle >= 360, largest = std::max(largest, std::abs(angle));
  if (largest > 400) return std::nullopt;
  if (beyond > 0) return AngleUnit{"gon", std::to_string(beyond) + " angles are between 360 and 400"};
  std::array<std::vector<double>, kUnits.size()> faces, reciprocal;
  for (std::size_t u = 0; u < kUnits.size(); ++u) {
    Closures c = closures_of(sightings, kUnits[u]);
    faces[u] = std::move(c.faces), reciprocal[u] = std::move(c.reciprocal);
  }
  if (const auto unit = closing(faces, kFaces, sightings))
    return AngleUnit{kUnits[*unit],
                     "the two faces of " + std::to_string(faces[*unit].size()) + " readings close in it"};
  if (const auto unit = closing(reciprocal, kReciprocal, sightings))
    return AngleUnit{kUnits[*unit],
                     std::to_string(reciprocal[*unit].size()) + " reciprocal pairs of zenith angles close in it"};
  return std::nullopt;
}

}  // namespace plumbline::survey

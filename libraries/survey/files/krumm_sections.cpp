#include "survey/files/krumm_sections.hpp"

#include <array>
#include <vector>

#include "base/text/text.hpp"
#include "survey/files/survey_builder.hpp"

namespace plumbline::survey {
namespace {

struct Named {
  std::string_view name;
  KrummContent content;
  ObservationKind kind;
  bool from_horizon = false;
};

using C = KrummContent;
using K = ObservationKind;

constexpr std::array<Named, 33> kSections = {{
    {"coordinates", C::coordinates, K::direction},
    {"datum", C::datum, K::direction},
    {"sigma0", C::sigma0, K::direction},
    {"spatialdistances", C::observations, K::slope_distance},
    {"horizontaldistances", C::observations, K::horizontal_distance},
    {"distances", C::observations, K::horizontal_distance},
    {"distanzen", C::observations, K::horizontal_distance},
    {"correlateddistances", C::correlated_distances, K::horizontal_distance},
    {"directions", C::observations, K::direction},
    {"direction", C::observations, K::direction},
    {"richtungen", C::observations, K::direction},
    {"angles", C::observations, K::angle},
    {"winkel", C::observations, K::angle},
    {"azimuth", C::observations, K::azimuth},
    {"azimuths", C::observations, K::azimuth},
    {"gridbearings", C::observations, K::azimuth},
    {"zenithangles", C::observations, K::zenith_angle},
    {"verticalangles", C::observations, K::zenith_angle, true},
    {"levelledheightdifferences", C::levelling, K::height_difference},
    {"heightdifferences", C::observations, K::height_difference},
    {"trigonometricheightdifferences", C::observations, K::height_difference},
    {"3dbaseline", C::baselines, K::direction},
    {"3dbasislinie", C::baselines, K::direction},
    {"restrictions", C::restrictions, K::direction},
    {"project", C::title, K::direction},
    {"source", C::source, K::direction},
    {"quelle", C::source, K::direction},
    {"graphics", C::passed_over, K::direction},
    {"approximateorientation", C::passed_over, K::direction},
    {"approximatescale", C::unknown_scale, K::direction},
    {"approximateadditiveconstant", C::unknown_scale, K::direction},
    {"ellipsoid", C::ellipsoid, K::direction},
    {"positionangles", C::refused, K::direction},
}};

// "xA" -> "A"; empty if the text is no coordinate of the axis.
std::string_view point_of(std::string_view text, char axis) {
  return text.size() > 1 && text::to_lower(text.substr(0, 1))[0] == axis ? text.substr(1) : std::string_view();
}

// A and B of "(xA-xB)^2", A and nothing of "xA^2". Names may hold '-': of the places to cut, the one where the axis
// follows.
bool read_term(std::string_view term, char axis, std::string_view& from, std::string_view& to) {
  if (!term.ends_with("^2")) return false;
  term.remove_suffix(2);
  to = {};
  if (!term.starts_with('(') || !term.ends_with(')')) {
    from = point_of(term, axis);
    return !from.empty();
  }
  term = term.substr(1, term.size() - 2);
  for (std::size_t cut = term.find('-'); cut != std::string_view::npos; cut = term.find('-', cut + 1)) {
    from = point_of(term.substr(0, cut), axis);
    to = point_of(term.substr(cut + 1), axis);
    if (!from.empty() && !to.empty()) return true;
  }
  return false;
}

}  // namespace

std::optional<KrummSection> krumm_section(std::string_view text) {
  const std::string lower = text::to_lower(text);
  const auto parts = text::split(lower, ',');
  const std::string_view name = text::trim(parts[0]);
  for (const Named& known : kSections) {
    if (known.name != name) continue;
    KrummSection section{known.content, known.kind, false, false, known.from_horizon};
    for (std::size_t i = 1; i < parts.size(); ++i) {
      const std::string_view unit = text::trim(parts[i]);
      if (unit == "dms") section.dms = true;
      if (unit == "s") section.sigma_seconds = true;
      if (known.content != C::coordinates || unit == "s") continue;
      section.geodetic = true;
      if (unit != "bdms" && unit != "ldms") section.content = C::refused;
    }
    return section;
  }
  return std::nullopt;
}

KrummDistanceSigma krumm_distance_sigma(std::string_view comment) {
  std::string text;
  for (const char c : comment)
    if (c != ' ' && c != '\t' && c != '%') text += c;
  if (text.find("(s[km]*sigma_s)^2") != std::string::npos) return KrummDistanceSigma::squares_of_km;
  for (const char* sum : {"sigma=sigma_c+s[km]*sigma_s", "sigma=sigma_c+s[m]*sigma_s"})
    if (text.find(sum) != std::string::npos) return KrummDistanceSigma::sum;
  return KrummDistanceSigma::squares;
}

std::optional<double> krumm_dms(std::string_view text) {
  text = text::trim(text);
  const bool negative = text.starts_with('-');
  if (negative) text.remove_prefix(1);
  double parts[3] = {0, 0, 0};
  static constexpr std::string_view kMarks[] = {"\xC2\xB0", "'", "\""};
  for (int i = 0; i < 3 && !text.empty(); ++i) {
    const std::size_t mark = text.find(kMarks[i]);
    if (mark == std::string_view::npos) return std::nullopt;
    const auto value = text::parse_number(text.substr(0, mark));
    if (!value || *value < 0 || (i > 0 && *value >= 60)) return std::nullopt;
    parts[i] = *value;
    text.remove_prefix(mark + kMarks[i].size());
  }
  if (!text.empty() || parts[0] > 1e6) return std::nullopt;
  const double angle = degrees_to_rad(parts[0] + parts[1] / 60 + parts[2] / 3600);
  return negative ? -angle : angle;
}

std::optional<KrummDistanceCondition> krumm_distance_condition(std::string_view text) {
  std::string line;
  for (const char c : text)
    if (c != ' ' && c != '\t') line += c;
  const std::string_view all = line;
  const std::size_t plus = all.find('+');
  const std::size_t minus = all.rfind("^2-");
  if (plus == std::string_view::npos || minus == std::string_view::npos || minus < plus || !all.ends_with("^2"))
    return std::nullopt;
  std::string_view from_x, to_x, from_y, to_y;
  if (!read_term(all.substr(0, plus), 'x', from_x, to_x) ||
      !read_term(all.substr(plus + 1, minus + 2 - plus - 1), 'y', from_y, to_y) || from_x != from_y || to_x != to_y)
    return std::nullopt;
  const auto distance = text::parse_number(all.substr(minus + 3, all.size() - 2 - minus - 3));
  if (!distance || *distance <= 0 || from_x == to_x) return std::nullopt;
  return KrummDistanceCondition{std::string(from_x), std::string(to_x), *distance};
}

}  // namespace plumbline::survey

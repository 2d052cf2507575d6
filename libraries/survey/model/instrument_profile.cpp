#include "survey/model/instrument_profile.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "base/text/one_document.hpp"
#include "base/text/whole_file.hpp"
#include "builtin_profiles.hpp"
#include "survey/model/starnet_project.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

constexpr double kArcsecond = std::numbers::pi / 180 / 3600;
constexpr double kMillimetre = 1e-3;

struct Field {
  double InstrumentProfile::*member;
  double unit;
  bool required;
};

const std::map<std::string, Field>& fields() {
  using P = InstrumentProfile;
  static const std::map<std::string, Field> table = {
      {"direction_arcsec", {&P::direction_sigma, kArcsecond, true}},
      {"zenith_angle_arcsec", {&P::zenith_sigma, kArcsecond, true}},
      {"angle_arcsec", {&P::angle_sigma, kArcsecond, false}},
      {"azimuth_arcsec", {&P::azimuth_sigma, kArcsecond, false}},
      {"single_face_factor", {&P::single_face_factor, 1, false}},
      {"distance_mm", {&P::distance_constant, kMillimetre, true}},
      {"distance_ppm", {&P::distance_ppm, 1, true}},
      {"instrument_centring_mm", {&P::instrument_centring, kMillimetre, false}},
      {"target_centring_mm", {&P::target_centring, kMillimetre, false}},
      {"height_centring_mm", {&P::height_centring, kMillimetre, false}},
      {"instrument_height_mm", {&P::instrument_height, kMillimetre, false}},
      {"levelling_arcsec", {&P::levelling, kArcsecond, false}},
      {"distance_centring_mm", {&P::distance_centring, kMillimetre, false}},
      {"height_difference_mm", {&P::height_difference, kMillimetre, false}},
      {"height_difference_mm_per_sqrt_km", {&P::height_difference_per_sqrt_km, kMillimetre, false}},
  };
  return table;
}

[[noreturn]] void fail(const std::string& origin, const YAML::Mark& mark, const std::string& text) {
  throw std::runtime_error(origin + ":" + std::to_string(mark.line + 1) + ":" + std::to_string(mark.column + 1) + ": " +
                           text);
}

std::string known_keys() {
  std::string text = "name, sigmas_of_mean, instruments";
  for (const auto& [key, field] : fields()) text += ", " + key;
  return text;
}

}  // namespace

double InstrumentProfile::direction(double horizontal, double slope, int sets, bool single_face) const {
  const double one = direction_sigma * (single_face ? single_face_factor : 1.0);
  const double centring = std::hypot(instrument_centring, target_centring) / horizontal;
  const double height = std::sqrt(std::max(0.0, slope * slope - horizontal * horizontal));
  return std::hypot(one / std::sqrt(sigmas_of_mean ? 1.0 : sets), centring, levelling * height / horizontal);
}

double InstrumentProfile::azimuth(double horizontal, double slope, int sets) const {
  InstrumentProfile as_direction = *this;
  if (!std::isnan(azimuth_sigma)) as_direction.direction_sigma = azimuth_sigma;
  return as_direction.direction(horizontal, slope, sets, false);
}

double InstrumentProfile::angle(const double (&horizontal)[2], const double (&slope)[2], double apart, int sets) const {
  const double one = (std::isnan(angle_sigma) ? std::numbers::sqrt2 * direction_sigma : angle_sigma) /
                     std::sqrt(sigmas_of_mean ? 1.0 : sets);
  double variance = one * one + std::pow(instrument_centring * apart / (horizontal[0] * horizontal[1]), 2);
  for (int arm = 0; arm < 2; ++arm) {
    const double height = std::sqrt(std::max(0.0, slope[arm] * slope[arm] - horizontal[arm] * horizontal[arm]));
    variance += std::pow(target_centring / horizontal[arm], 2) + std::pow(levelling * height / horizontal[arm], 2);
  }
  return std::sqrt(variance);
}

double InstrumentProfile::zenith_angle(double slope, int sets, bool single_face) const {
  const double one = zenith_sigma * (single_face ? single_face_factor : 1.0);
  return std::hypot(one / std::sqrt(sigmas_of_mean ? 1.0 : sets), height_centring / slope, levelling);
}

double InstrumentProfile::distance(double slope, int sets) const {
  const double one = distance_constant + distance_ppm * 1e-6 * slope;
  const double centring =
      std::isnan(distance_centring) ? std::hypot(instrument_centring, target_centring) : distance_centring;
  return std::hypot(one / std::sqrt(sigmas_of_mean ? 1.0 : sets), centring);
}

double InstrumentProfile::levelled(double length) const {
  return std::hypot(height_difference, height_difference_per_sqrt_km * std::sqrt(length / 1000));
}

InstrumentProfile InstrumentProfile::without_instrument_centring() const {
  InstrumentProfile rest = *this;
  rest.instrument_centring = 0;
  return rest;
}

InstrumentProfile InstrumentProfile::without_centring() const {
  InstrumentProfile rest = *this;
  rest.instrument_centring = rest.target_centring = rest.height_centring = 0;
  return rest;
}

std::string in_words(const InstrumentProfile& p) {
  return p.name + ": directions " + fixed_digits(p.direction_sigma / kArcsecond, 1) + "\u2033, zenith angles " +
         fixed_digits(p.zenith_sigma / kArcsecond, 1) + "\u2033 (one set in both faces), distances " +
         fixed_digits(p.distance_constant / kMillimetre, 1) + " mm + " + fixed_digits(p.distance_ppm, 1) +
         " ppm, centring of targets " + fixed_digits(p.target_centring / kMillimetre, 1) + " mm, of the instrument " +
         fixed_digits(p.instrument_centring / kMillimetre, 1) + " mm where it stands over a mark";
}

namespace {

/// The keys of one instrument into `profile`; which were there into `seen`.
void take_keys(const YAML::Node& map, const std::string& origin, InstrumentProfile& profile,
               std::set<std::string>& seen) {
  for (const auto& entry : map) {
    const auto key = entry.first.as<std::string>();
    if (!seen.insert(key).second) fail(origin, entry.first.Mark(), "'" + key + "' is given twice");
    try {
      if (key == "name") {
        profile.name = entry.second.as<std::string>();
      } else if (key == "sigmas_of_mean") {
        profile.sigmas_of_mean = entry.second.as<bool>();
      } else if (const auto field = fields().find(key); field != fields().end()) {
        const double value = entry.second.as<double>();
        if (!(value >= 0) || !std::isfinite(value))
          fail(origin, entry.second.Mark(), "'" + key + "' is " + std::to_string(value) + ", expected a number >= 0");
        profile.*(field->second.member) = value * field->second.unit;
      } else if (key != "instruments") {
        fail(origin, entry.first.Mark(), "unknown key '" + key + "', expected one of " + known_keys());
      }
    } catch (const YAML::Exception&) {
      const std::string found = entry.second.IsScalar() ? "'" + entry.second.Scalar() + "'" : "no single value";
      fail(origin, entry.second.Mark(),
           "'" + key + "' is " + found + ", expected " +
               (key == "name"             ? "a text"
                : key == "sigmas_of_mean" ? "true or false"
                                          : "a number"));
    }
  }
  if (seen.contains("direction_arcsec") && profile.direction_sigma <= 0)
    fail(origin, map.Mark(), "direction_arcsec must be positive");
}

YAML::Node load(const std::string& yaml, const std::string& origin) {
  YAML::Node root;
  try {
    root = text::load_one_document(yaml);
  } catch (const YAML::ParserException& error) {
    fail(origin, error.mark, error.msg);
  }
  if (!root.IsMap()) fail(origin, root.Mark(), "expected an instrument profile: a map with " + known_keys());
  return root;
}

}  // namespace

InstrumentProfile parse_profile(const std::string& yaml, const std::string& origin) {
  const YAML::Node root = load(yaml, origin);
  InstrumentProfile profile;
  std::set<std::string> seen;
  take_keys(root, origin, profile, seen);
  for (const auto& [key, field] : fields())
    if (field.required && !seen.contains(key)) fail(origin, root.Mark(), "'" + key + "' is missing");
  if (profile.direction_sigma <= 0 || profile.zenith_sigma <= 0 || profile.distance_constant <= 0)
    fail(origin, root.Mark(), "direction_arcsec, zenith_angle_arcsec and distance_mm must be positive");
  return profile;
}

std::map<std::string, InstrumentProfile> parse_instruments(const std::string& yaml, const std::string& origin) {
  const InstrumentProfile common = parse_profile(yaml, origin);
  std::map<std::string, InstrumentProfile> instruments;
  const YAML::Node list = load(yaml, origin)["instruments"];
  if (list && !list.IsMap()) fail(origin, list.Mark(), "'instruments' is expected to be a map: name: {keys}");
  for (const auto& entry : list) {
    const auto name = entry.first.as<std::string>();
    if (!entry.second.IsMap()) fail(origin, entry.second.Mark(), "instrument '" + name + "' is expected to be a map");
    InstrumentProfile own = common;
    own.name = name;
    std::set<std::string> seen;
    take_keys(entry.second, origin, own, seen);
    instruments[name] = own;
  }
  return instruments;
}

std::map<std::string, InstrumentProfile> read_instruments(const std::string& path) {
  const std::string text = text::read_whole(path);
  return is_starnet_project(text) ? parse_starnet_project(text, path).library : parse_instruments(text, path);
}

InstrumentProfile read_profile(const std::string& path) {
  const std::string text = text::read_whole(path);
  return is_starnet_project(text) ? parse_starnet_project(text, path).instrument : parse_profile(text, path);
}

std::vector<const char*> profile_names() {
  std::vector<const char*> names;
  for (const auto& builtin : kBuiltinProfiles) names.push_back(builtin.name);
  return names;
}

InstrumentProfile built_in_profile(const std::string& name) {
  std::string known;
  for (const auto& builtin : kBuiltinProfiles) {
    if (name == builtin.name) return parse_profile(builtin.yaml, "profile " + name);
    known += (known.empty() ? "" : ", ") + std::string(builtin.name);
  }
  throw std::runtime_error("no instrument profile is called '" + name + "'; there are: " + known +
                           "; a profile of your own is given by path");
}

InstrumentProfile choose_profile(const std::string& profile, const std::string& profile_file,
                                 const std::string& instrument, std::string& remark) {
  if (!profile_file.empty()) {
    const std::string text = text::read_whole(profile_file);
    if (is_starnet_project(text))
      remark = "of the project " + profile_file +
               " the instruments are taken; not what else it sets, which is to be given: " +
               join(parse_starnet_project(text, profile_file).settings, 20);
    return read_profile(profile_file);
  }
  if (profile != "automatic") return built_in_profile(profile);
  const std::vector<const char*> names = profile_names();
  if (std::find(names.begin(), names.end(), instrument) != names.end()) return built_in_profile(instrument);
  if (!instrument.empty())
    remark = "the observations name the instrument '" + instrument +
             "', of which there is no profile; ics50_assumed is used unless profile or profile_file says otherwise";
  return built_in_profile("ics50_assumed");
}

}  // namespace plumbline::survey

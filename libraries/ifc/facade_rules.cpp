// What a user says of facades, and what he is asked to say.
#include <charconv>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "ifc/facades.hpp"
#include "ifc/selection_rule.hpp"
#include "text/text.hpp"

namespace plumbline::bim {
namespace {

using formats::trim;

constexpr const char* kExample = "name~^N-: azimuth=180deg, name=South";

/// Angle with its unit, deg or gon [rad]; nan if it is none.
double angle_of(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string_view unit = trim(text.substr(static_cast<std::size_t>(end - text.data())));
  const double radian = unit == "deg" ? std::numbers::pi / 180 : unit == "gon" ? std::numbers::pi / 200 : 0;
  return error == std::errc() && radian > 0 && std::isfinite(number) ? number * radian : FacadeFrame::nan;
}

}  // namespace

FacadeRule parse_facade_rule(const std::string& text) {
  auto [selection, rest] = split_rule(text, kExample);
  FacadeRule rule{std::move(selection), {}, false, "", std::string(trim(text))};
  double azimuth = FacadeFrame::nan, tilt = 0;
  const auto refuse = [&](std::string_view part) {
    throw std::runtime_error("facade rule '" + text + "': found '" + std::string(part) +
                             "', expected azimuth=…deg (clockwise from the y axis of the design), tilt=…deg (upward "
                             "positive), out=up, out=down, name=… or confirmed, such as '" +
                             kExample + "'");
  };
  for (const std::string_view part : formats::split(rest, ',')) {
    const std::string_view written = trim(part);
    const std::size_t equals = std::min(written.find('='), written.size());
    const std::string_view key = trim(written.substr(0, equals));
    const std::string_view value = trim(written.substr(std::min(equals + 1, written.size())));
    if (key == "azimuth" && std::isfinite(angle_of(value)))
      azimuth = angle_of(value);
    else if (key == "tilt" && std::abs(angle_of(value)) <= 0.5 * std::numbers::pi)
      tilt = angle_of(value);
    else if (key == "out" && (value == "up" || value == "down"))
      rule.out = value == "up" ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d(-Eigen::Vector3d::UnitZ());
    else if (key == "name" && !value.empty())
      rule.name = value;
    else if (written == "confirmed")
      rule.confirmed = true;
    else
      refuse(written);
  }
  if (std::isfinite(azimuth)) rule.out = facing(azimuth, tilt);
  if (!rule.out && !rule.confirmed && rule.name.empty()) refuse(rest);
  if (!rule.out && tilt != 0) refuse(rest);
  return rule;
}

std::vector<std::string> facade_warnings(const std::vector<Facade>& facades) {
  std::vector<std::string> warnings;
  for (const Facade& facade : facades) {
    if (facade.confirmed) continue;
    const std::string what =
        facade.name + " (" + std::to_string(facade.anchors) + " anchors, " + std::to_string(facade.panels) + " panels)";
    warnings.push_back("Nobody may be sent outward or inward on facade " + what +
                       " before its direction is confirmed: " + facade.note + ". If it faces " +
                       facing_words(facade.out) +
                       " (azimuth clockwise from the y axis of the design), say so: \"design.with.facades=['*: "
                       "confirmed']\"; else give its azimuth, such as \"design.with.facades=['" +
                       kExample + "']\", or facing_azimuth_deg in the plate table.");
  }
  return warnings;
}

}  // namespace plumbline::bim

// What a user says of facades, and what he is asked to say.
#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <numbers>
#include <set>
#include <stdexcept>

#include "base/text/text.hpp"
#include "building/ifc/facades.hpp"
#include "building/ifc/selection_rule.hpp"

namespace plumbline::ifc {
namespace {

using text::trim;

constexpr const char* kExample = "name~^N-: azimuth=180deg, name=South";

/// Angle with its unit, deg or gon [rad]; nan if it is none.
double angle_of(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const std::string_view unit = trim(text.substr(static_cast<std::size_t>(end - text.data())));
  const double radian = unit == "deg" ? std::numbers::pi / 180 : unit == "gon" ? std::numbers::pi / 200 : 0;
  return error == std::errc() && radian > 0 && std::isfinite(number) ? number * radian : FacadeFrame::nan;
}

/// As part of an expression between quotes in a command line: what is no letter or digit there is any one character.
std::string as_expression(const std::string& text) {
  std::string out;
  for (const char c : text) {
    const bool plain = std::isalnum(static_cast<unsigned char>(c)) || c == '-' || c == '_' || c == ' ';
    out += plain || static_cast<unsigned char>(c) >= 0x80 ? c : '.';
  }
  return out;
}

/// More alternatives than this are no command that anybody reads.
constexpr std::size_t kMostAlternatives = 60;

/// "name~^(S-|PS-)": the shortest beginnings of the members' names that nobody else's name has; empty: there are none.
std::string by_names(const std::vector<const FacadeMember*>& own, const std::vector<const FacadeMember*>& others) {
  std::set<std::string> beginnings;
  for (const FacadeMember* member : own) {
    const std::string& name = member->element.name;
    const auto alone = [&](const std::string& beginning) {
      return std::none_of(others.begin(), others.end(),
                          [&](const FacadeMember* other) { return other->element.name.starts_with(beginning); });
    };
    std::size_t n = 1;
    while (n <= name.size() && !alone(name.substr(0, n))) ++n;
    if (n > name.size()) return "";
    beginnings.insert(name.substr(0, n));
    if (beginnings.size() > kMostAlternatives) return "";
  }
  std::string all;
  for (const std::string& beginning : beginnings) all += (all.empty() ? "" : "|") + as_expression(beginning);
  return beginnings.size() == 1 ? "name~^" + all : "name~^(" + all + ")";
}

/// A selection of the members of one facade and of nobody else; empty if no short one does.
std::string selection_of(const std::string& facade, const std::vector<FacadeMember>& members) {
  std::vector<const FacadeMember*> own, others;
  for (const FacadeMember& member : members) (member.facade == facade ? own : others).push_back(&member);
  if (own.empty()) return "";
  if (others.empty()) return "*";
  const auto exact = [&](const std::string& text) {
    if (text.empty()) return false;
    const Selection selection(text);
    return std::all_of(members.begin(), members.end(), [&](const FacadeMember& member) {
      return selection.matches(member.element) == (member.facade == facade);
    });
  };
  if (const std::string names = by_names(own, others); exact(names)) return names;
  std::string guids;
  for (const FacadeMember* member : own) guids += (guids.empty() ? "" : "|") + as_expression(member->element.guid);
  if (guids = "guid~^(" + guids + ")"; own.size() <= kMostAlternatives && exact(guids)) return guids;
  return "";
}

/// "azimuth=0deg", "azimuth=180deg, tilt=-10deg", "out=down".
std::string direction_rule(const Eigen::Vector3d& out) {
  const auto degrees = [](double value) {
    std::string short_text(fmt::format("{:.3f}", value));
    short_text.erase(short_text.find_last_not_of('0') + 1);
    if (short_text.back() == '.') short_text.pop_back();
    return (short_text == "-0" ? "0" : short_text == "360" ? "0" : short_text) + "deg";
  };
  if (std::abs(out.z()) > 0.9999) return out.z() > 0 ? "out=up" : "out=down";
  const double tilt = std::asin(std::clamp(out.z(), -1.0, 1.0)) * 180 / std::numbers::pi;
  const std::string azimuth = "azimuth=" + degrees(azimuth_degrees(out));
  return std::abs(tilt) < 0.001 ? azimuth : azimuth + ", tilt=" + degrees(tilt);
}

/// What settles one facade, for the words after "If it faces …".
std::string command_of(const Facade& facade, const std::vector<FacadeMember>& members) {
  constexpr double straight = 0.05;  // [rad] what bends more has no one azimuth
  bool by_plates = false;
  for (const FacadeMember& member : members)
    by_plates =
        by_plates || (member.facade == facade.name && member.frame && member.frame->source == FacadeSource::plate);
  const std::string selection = selection_of(facade.name, members);
  if (facade.bend > straight && by_plates)
    return "; it bends, so give the azimuth of each of its parts, such as \"design.with.facades=['" +
           std::string(kExample) + "']\", or mend facing_azimuth_deg in the plate table.";
  const std::string rule = (selection.empty() ? "SELECTION" : selection) + ": " +
                           (facade.bend > straight ? std::string("confirmed") : direction_rule(facade.out));
  return ", say so: \"design.with.facades=['" + rule + "']\"" +
         (selection.empty() ? ", where SELECTION is what selects its elements (class=, name~, storey=, tag~ or "
                              "Set.Property=)"
                            : "") +
         "; else give another azimuth in the same place, or facing_azimuth_deg in the plate table.";
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
  for (const std::string_view part : text::split(rest, ',')) {
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

std::vector<std::string> facade_warnings(const std::vector<Facade>& facades, const std::vector<FacadeMember>& members) {
  std::vector<std::string> warnings;
  for (const Facade& facade : facades) {
    if (facade.confirmed) continue;
    const std::string what =
        facade.name + " (" + std::to_string(facade.anchors) + " anchors, " + std::to_string(facade.panels) + " panels)";
    warnings.push_back("Nobody may be sent outward or inward on facade " + what +
                       " before its direction is confirmed: " + facade.note + ". If it faces " +
                       facing_words(facade.out) + " (azimuth clockwise from the y axis of the design)" +
                       command_of(facade, members));
  }
  std::string nobodys;
  int number = 0;
  for (const FacadeMember& member : members) {
    if (!member.frame || member.frame->known() || member.frame->note.empty() || ++number > 6) continue;
    nobodys += (nobodys.empty() ? "" : ", ") + member.element.name + " (" + member.frame->note + ")";
  }
  if (number > 0)
    warnings.push_back("Nobody may be sent outward or inward at " + nobodys +
                       (number > 6 ? " and " + std::to_string(number - 6) + " more" : "") +
                       " before somebody says which way they face, such as \"design.with.facades=['name~^C-: "
                       "azimuth=135deg']\", or by facing_azimuth_deg in the plate table.");
  return warnings;
}

}  // namespace plumbline::ifc

#include "building/judgement/surface_rules.hpp"

#include <cmath>
#include <stdexcept>

#include "base/text/text.hpp"
#include "building/ifc/selection_rule.hpp"

namespace plumbline::judgement {
namespace {

constexpr const char* kSurfaceExample = "class=IfcPlate: flatness(1m)=3mm, bow=4mm, step=2mm, joint=+4/-3mm";
constexpr SurfaceQuantity kQuantities[] = {SurfaceQuantity::flatness,  SurfaceQuantity::bow,    SurfaceQuantity::twist,
                                           SurfaceQuantity::offset,    SurfaceQuantity::step,   SurfaceQuantity::joint,
                                           SurfaceQuantity::narrowest, SurfaceQuantity::widest, SurfaceQuantity::shift};

[[noreturn]] void refuse(const std::string& rule, const std::string& part, const std::string& why) {
  throw std::runtime_error("surface rule '" + rule + "': found '" + part + "', " + why + "; expected such as '" +
                           kSurfaceExample + "'");
}

SurfaceQuantity quantity_of(std::string_view name, const std::string& rule, const std::string& part) {
  for (const SurfaceQuantity quantity : kQuantities)
    if (name == name_of(quantity)) return quantity;
  refuse(rule, part, "which is none of flatness(length), bow, twist, offset, step, joint, narrowest, widest, shift");
}

/// "+4/-3mm": above and below, in one unit.
bool two_sides(std::string_view text, double& above, double& below) {
  const size_t slash = text.find('/');
  if (slash == std::string_view::npos || !text.starts_with('+')) return false;
  const std::string_view second = text::trim(text.substr(slash + 1));
  if (!second.starts_with('-')) return false;
  const std::string unit = second.ends_with("mm") ? "mm" : "m";
  const std::string first(text::trim(text.substr(1, slash - 1)));
  above = ifc::length_with_unit(first.ends_with("m") ? first : first + unit);
  below = ifc::length_with_unit(second.substr(1));
  return true;
}

/// Of two parts of a rule that cannot both hold, whichever were taken, the other would be dropped.
void refuse_contradictions(const std::string& rule, const SurfaceLimit& limit, const std::string& part,
                           const SurfaceLimit& before, const std::string& part_before) {
  if (same_question(limit, before))
    refuse(rule, part, "and before it '" + part_before + "', which is the same with another limit; give it once");
  const bool narrow = before.quantity == SurfaceQuantity::narrowest && limit.quantity == SurfaceQuantity::widest,
             wide = before.quantity == SurfaceQuantity::widest && limit.quantity == SurfaceQuantity::narrowest;
  if ((narrow && before.lower > limit.upper) || (wide && limit.lower > before.upper))
    refuse(rule, part, "and before it '" + part_before + "': no joint is at most the one and at least the other");
}

}  // namespace

bool same_question(const SurfaceLimit& a, const SurfaceLimit& b) {
  return a.quantity == b.quantity && (std::isnan(a.length) || std::abs(a.length - b.length) < 1e-9);
}

const char* name_of(SurfaceQuantity quantity) {
  switch (quantity) {
    case SurfaceQuantity::flatness:
      return "flatness";
    case SurfaceQuantity::bow:
      return "bow";
    case SurfaceQuantity::twist:
      return "twist";
    case SurfaceQuantity::offset:
      return "offset";
    case SurfaceQuantity::step:
      return "step";
    case SurfaceQuantity::joint:
      return "joint";
    case SurfaceQuantity::narrowest:
      return "narrowest";
    case SurfaceQuantity::widest:
      return "widest";
    case SurfaceQuantity::shift:
      return "shift";
  }
  return "";
}

bool is_of_joints(SurfaceQuantity quantity) {
  return quantity != SurfaceQuantity::flatness && quantity != SurfaceQuantity::bow &&
         quantity != SurfaceQuantity::twist && quantity != SurfaceQuantity::offset;
}

SurfaceRule parse_surface_rule(const std::string& text) {
  auto [selection, lengths, whole] = ifc::parse_lengths(text, kSurfaceExample);
  SurfaceRule rule{std::move(selection), {}, std::move(whole)};
  for (const auto& [written, metres, part] : lengths) {
    SurfaceLimit limit;
    const size_t bracket = std::min(written.find('('), written.size());
    limit.quantity = quantity_of(text::trim(std::string_view(written).substr(0, bracket)), text, part);
    if (limit.quantity == SurfaceQuantity::flatness) {
      if (bracket < written.size() && written.ends_with(')'))
        limit.length = ifc::length_with_unit(written.substr(bracket + 1, written.size() - bracket - 2));
      if (!(limit.length > 0)) refuse(text, part, "flatness is under a straightedge of a length, such as flatness(1m)");
    } else if (bracket < written.size()) {
      refuse(text, part, "only flatness has a length of its own");
    }
    double above = metres, below = metres;
    const size_t equals = std::min(part.find('='), part.size() - 1);
    const bool sides = two_sides(text::trim(std::string_view(part).substr(equals + 1)), above, below);
    if (sides && limit.quantity != SurfaceQuantity::joint && limit.quantity != SurfaceQuantity::offset)
      refuse(text, part, "two sides are for joint and offset only");
    if (!(above >= 0 && above <= 1 && below >= 0 && below <= 1))
      refuse(text, part, "a limit is a length from 0 to 1 m with its unit, mm or m");
    if (limit.quantity == SurfaceQuantity::narrowest)
      limit.lower = below;
    else
      limit.upper = above;
    const bool one_sided = limit.quantity == SurfaceQuantity::flatness ||
                           limit.quantity == SurfaceQuantity::narrowest || limit.quantity == SurfaceQuantity::widest;
    if (!one_sided) limit.lower = -below;
    for (size_t i = 0; i < rule.limits.size(); ++i)
      refuse_contradictions(text, limit, part, rule.limits[i], lengths[i].text);
    rule.limits.push_back(limit);
  }
  return rule;
}

}  // namespace plumbline::judgement

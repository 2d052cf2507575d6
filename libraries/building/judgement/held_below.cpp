#include "building/judgement/held_below.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "building/ifc/selection_rule.hpp"

namespace plumbline::judgement {
namespace {

constexpr const char* kHeldExample = "class=IfcPlate: sigma=0.5mm, sill_sigma=2mm";
constexpr double kUnsaid = std::numeric_limits<double>::quiet_NaN();
constexpr double kMost = 0.1;  ///< [m]

/// As it was said; nan: not.
struct Said {
  double sigma = kUnsaid, play = kUnsaid, sill_sigma = kUnsaid;
  bool is_joint() const { return !std::isnan(sigma) || !std::isnan(play); }
  StackJoint joint(const std::string& source) const {
    const double other = std::isnan(sigma) ? 0 : sigma, width = std::isnan(play) ? 0 : play;
    return {std::sqrt(other * other + width * width / 3), sill_sigma, source};
  }
};

bool is_length(double metres) { return metres >= 0 && metres <= kMost; }

}  // namespace

HeldBelowRule parse_held_below(const std::string& text) {
  auto [selection, lengths, whole] = ifc::parse_lengths(text, kHeldExample);
  Said said;
  for (const auto& [name, length, part] : lengths) {
    double* value = name == "sigma"        ? &said.sigma
                    : name == "play"       ? &said.play
                    : name == "sill_sigma" ? &said.sill_sigma
                                           : nullptr;
    if (!value || !is_length(length))
      throw std::runtime_error("held_below rule '" + text + "': found '" + part +
                               "', expected sigma, play or sill_sigma with a length from 0 to 100 mm, such as '" +
                               kHeldExample + "'");
    *value = length;
  }
  if (!said.is_joint())
    throw std::runtime_error("held_below rule '" + text +
                             "' does not say how well the edge is held; expected sigma or play, such as '" +
                             kHeldExample + "'");
  return {std::move(selection), said.joint(whole), whole};
}

bool HeldBelow::is_sill(const ifc::ElementFacts& anchor) const {
  return std::any_of(sills.begin(), sills.end(), [&](const ifc::Selection& sill) { return sill.matches(anchor); });
}

std::optional<StackJoint> HeldBelow::of(const ifc::ElementFacts& panel, std::vector<ifc::NotApplied>& refused) const {
  for (auto rule = rules.rbegin(); rule != rules.rend(); ++rule)
    if (rule->selection.matches(panel)) return rule->joint;
  if (!panel.properties) return {};
  Said said;
  bool asked = false;
  for (const ifc::Property& property : *panel.properties) {
    if (property.set != "Pset_StackJoint") continue;
    asked = true;
    double* value = property.name == "Sigma"       ? &said.sigma
                    : property.name == "Play"      ? &said.play
                    : property.name == "SillSigma" ? &said.sill_sigma
                                                   : nullptr;
    const std::string name = property.set + "." + property.name;
    const bool has_unit = property.measure.empty() || property.measure.ends_with("LENGTHMEASURE");
    if (value && has_unit && is_length(property.number))
      *value = property.number;
    else
      refused.push_back({name + (property.text.empty() ? "" : " '" + property.text + "'"), "design",
                         value ? "expected a length from 0 to 100 mm" : "expected Sigma, Play or SillSigma"});
  }
  if (said.is_joint()) return said.joint("design: Pset_StackJoint");
  if (asked)
    refused.push_back({"Pset_StackJoint", "design", "it does not say how well the edge is held: Sigma or Play"});
  return {};
}

}  // namespace plumbline::judgement

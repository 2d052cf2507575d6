#include "show/report/exact_lengths.hpp"

#include <fmt/core.h>

#include <cmath>
#include <memory>
#include <vector>

#include "building/judgement/panels.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// A length that a sentence may be about.
struct Told {
  std::string what;
  double value, limit;  ///< [m]
};

void add(const std::string& what, const std::unique_ptr<JudgedLengthT>& length, std::vector<Told>& all) {
  if (length) all.push_back({what, length->value, length->tolerance});
}

std::vector<Told> lengths_of(const PanelDeviationT& panel, const DeviationT& deviation) {
  std::vector<Told> all;
  add("out of plane", panel.out_of_plane, all), add("sideways", panel.sideways, all);
  add("height", panel.vertical, all), add("in plane", panel.in_plane, all), add("tilt at an anchor", panel.tilt, all),
      add("warp", panel.warp, all);
  add("slots of the anchors", panel.misfit, all), add("corner out of plane", panel.corner, all);
  for (const auto& joint : panel.joints)
    add("joint to " + (joint->name.empty() ? joint->panel : joint->name), joint->change, all);
  for (const auto& fixing : panel.fixings) {
    if (!panel.reason.starts_with("anchor " + fixing->anchor + " ")) continue;
    for (const auto& anchor : deviation.anchors)
      if (anchor->id == fixing->anchor)
        for (const auto& axis : anchor->axes)
          all.push_back({"anchor " + anchor->id + " " + axis->axis, axis->value, axis->tolerance});
  }
  return all;
}

/// Puts the exact length in the place of the first "{written} mm" behind `from`; where it ends. npos: it is not there.
std::size_t put(const std::string& written, const std::string& exact, std::size_t from, std::string& text) {
  const std::size_t at = text.find(written + " mm", from);
  if (at == std::string::npos) return at;
  text.replace(at, written.size(), exact);
  return at + exact.size();
}

/// Directions that shifts are told along: up, and right and out of every facade.
std::vector<Eigen::Vector3d> directions_of(const DeviationT& deviation) {
  std::vector<Eigen::Vector3d> all = {Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY()};
  for (const auto& facade : deviation.facades) {
    const Eigen::Vector3d right = Eigen::Vector3d::UnitZ().cross(facade->out);
    all.push_back(facade->out);
    if (right.norm() > 1e-6) all.push_back(right.normalized());
  }
  return all;
}

}  // namespace

std::string reason_of(const PanelDeviationT& panel, const DeviationT& deviation) {
  if (speech().units == Units::millimetres) return panel.reason;
  for (const Told& told : lengths_of(panel, deviation))
    if (std::isfinite(told.value) && judgement::words_of_length(told.what, told.value, told.limit) == panel.reason)
      return told.what + " " + mm(told.value, 1) + " mm (limit " + tolerance(told.limit) + ")";
  return panel.reason;
}

std::string words_of(const CommonShiftT& shift) {
  std::string text = shift.words;
  if (speech().units == Units::millimetres) return text;
  std::size_t from = 0;
  for (int axis = 0; axis < 3 && from != std::string::npos; ++axis)
    from = put(fmt::format("{:+.1f}", 1e3 * shift.shift[axis]), signed_mm(shift.shift[axis], 1), from, text);
  return text;
}

std::string words_of(const GroupShiftT& shift, const DeviationT& deviation) {
  std::string text = shift.words;
  if (speech().units == Units::millimetres) return text;
  for (const Eigen::Vector3d& along : directions_of(deviation)) {
    const double value = std::abs(along.dot(shift.shift)), u = std::sqrt(shift.u.cwiseAbs2().dot(along.cwiseAbs2()));
    const std::string written = fmt::format("{:.1f} mm ± {:.1f}", 1e3 * value, 1e3 * u);
    if (const std::size_t at = text.find(written + " mm"); at != std::string::npos)
      text.replace(at, written.size(), mm(value, 1) + " mm ± " + mm(u, 1));
  }
  return text;
}

}  // namespace plumbline::report

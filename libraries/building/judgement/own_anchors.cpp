#include "building/judgement/own_anchors.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

namespace plumbline::judgement {
namespace {

/// An anchor belongs to both panels if it is not nearer to one than to the other by more than a joint is wide [m].
constexpr double kAsNear = 0.025;
constexpr double kAlike = 0.94;  // cosine of the directions that panels of one facade face, which may bend a little

/// Less thin than this share of its next edge a box is no plate: it is the box of an L or a U, which faces two ways.
constexpr double kThin = 0.5;

/// How far an anchor is from a panel, and in which direction the panel is thin.
struct Candidate {
  std::size_t panel = 0;
  double distance = 0;                               ///< of its box [m]
  Eigen::Vector3d off = Eigen::Vector3d::Zero();     ///< the way there
  Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< zero: it is no plate
};

Candidate distance_of(const PanelCase& panel, const Eigen::Vector3d& anchor) {
  const Eigen::Vector3d own = panel.frame_from_panel.inverse() * anchor;
  const Eigen::Vector3d off = (panel.low - own).cwiseMax(own - panel.high).cwiseMax(0);
  const Eigen::Vector3d size = panel.high - panel.low;
  int thin = 0;
  const double least = size.minCoeff(&thin);
  const Eigen::Matrix3d axes = panel.frame_from_panel.rotation.toRotationMatrix();
  Candidate candidate;
  candidate.distance = off.norm();
  candidate.off = axes * (own.cwiseMax(panel.low).cwiseMin(panel.high) - own);
  if (least < kThin * std::min(size[(thin + 1) % 3], size[(thin + 2) % 3])) candidate.across = axes.col(thin);
  return candidate;
}

/// What is along a face.
double beside(const Candidate& candidate, const Eigen::Vector3d& across) {
  return (candidate.off - across * across.dot(candidate.off)).norm();
}

/// Along the face where both face one way, and where one of them goes round a corner: its box is in front of anchors
/// that are none of it.
bool is_nearer(const Candidate& one, const Candidate& other) {
  if (std::abs(one.across.dot(other.across)) > kAlike)
    return beside(one, one.across) + kAsNear < beside(other, other.across);
  if (one.across.isZero() != other.across.isZero()) {
    const Eigen::Vector3d& face = one.across.isZero() ? other.across : one.across;
    return beside(one, face) + kAsNear < beside(other, face);
  }
  return one.distance + kAsNear < other.distance;
}

}  // namespace

std::vector<char> find_own_anchors(std::vector<PanelCase>& panels, const std::vector<std::set<std::string>>& said,
                                   const std::vector<AnchorCase>& anchors, double reach) {
  std::map<std::string, std::vector<std::size_t>> tied;  // panels by the GlobalId of an anchor
  for (std::size_t p = 0; p < panels.size(); ++p)
    for (const std::string& guid : said[p]) tied[guid].push_back(p);
  std::vector<Eigen::Vector3d> middle;
  std::vector<double> farthest;
  for (const PanelCase& panel : panels) {
    middle.push_back(panel.frame_from_panel * Eigen::Vector3d(0.5 * (panel.low + panel.high)));
    farthest.push_back(0.5 * (panel.high - panel.low).norm() + reach);
  }
  std::vector<char> others_alone(panels.size());
  for (std::size_t a = 0; a < anchors.size(); ++a) {
    const AnchorCase& anchor = anchors[a];
    if (!anchor.design.allFinite()) continue;
    const Eigen::Vector3d reference = anchor.design - anchor.target_offset;
    const auto holds = tied.find(anchor.element.guid);
    const bool is_tied = holds != tied.end();
    if (is_tied)
      for (const std::size_t p : holds->second) panels[p].anchors.push_back(a);
    std::vector<Candidate> near;
    for (std::size_t p = 0; p < panels.size(); ++p) {
      if ((reference - middle[p]).norm() > farthest[p]) continue;
      Candidate candidate = distance_of(panels[p], reference);
      candidate.panel = p;
      if (candidate.distance <= reach) near.push_back(candidate);
    }
    for (const Candidate& one : near) {
      if (!said[one.panel].empty()) continue;
      const bool own = !is_tied && std::none_of(near.begin(), near.end(),
                                                [&](const Candidate& other) { return is_nearer(other, one); });
      if (own)
        panels[one.panel].anchors.push_back(a);
      else
        others_alone[one.panel] = 1;
    }
  }
  for (std::size_t p = 0; p < panels.size(); ++p) others_alone[p] = others_alone[p] && panels[p].anchors.empty();
  return others_alone;
}

namespace {

/// Panels that ought to hang on as many anchors: of one size [cm, whichever way the axes lie], and alike in whether
/// they share anchors with a panel below and above. In a stack the lowest has those at its top alone: its sills hold no
/// panel.
using Likeness = std::tuple<std::array<long, 3>, bool, bool>;

Likeness likeness_of(const PanelCase& panel, const std::vector<int>& holds, const DeviationInputs& inputs) {
  const Eigen::Vector3d size = 100 * (panel.high - panel.low);
  std::array<long, 3> extent = {std::lround(size.x()), std::lround(size.y()), std::lround(size.z())};
  std::sort(extent.begin(), extent.end());
  const double middle = (panel.frame_from_panel * Eigen::Vector3d(0.5 * (panel.low + panel.high))).z();
  bool below = false, above = false;
  for (const std::size_t anchor : panel.anchors)
    if (holds[anchor] > 1) (inputs.anchors[anchor].design.z() < middle ? below : above) = true;
  return {extent, below, above};
}

}  // namespace

void tell_of_nearness(const std::vector<std::size_t>& panels, double reach, DeviationInputs& inputs) {
  if (panels.empty()) return;
  const std::size_t all = inputs.panels.size();
  inputs.requests.push_back(
      {fmt::format(
           "which anchors hold a panel: the design says it of {} of {}; the others hang on those within {:.3g} m",
           all - panels.size(), all, reach),
       "panel_reach", 0, static_cast<int>(panels.size()), ""});
  std::vector<int> holds(inputs.anchors.size());  // panels, by anchor
  for (const PanelCase& panel : inputs.panels)
    for (const std::size_t anchor : panel.anchors) ++holds[anchor];
  std::map<Likeness, std::vector<const PanelCase*>> alike;
  for (const std::size_t p : panels) alike[likeness_of(inputs.panels[p], holds, inputs)].push_back(&inputs.panels[p]);
  const auto name_of = [](const PanelCase& panel) { return panel.name.empty() ? panel.guid : panel.name; };
  for (const auto& [likeness, of] : alike) {
    const auto [least, most] = std::minmax_element(
        of.begin(), of.end(), [](const auto* a, const auto* b) { return a->anchors.size() < b->anchors.size(); });
    if ((*least)->anchors.size() == (*most)->anchors.size()) continue;
    inputs.warnings.push_back(fmt::format(
        "Panels of one size are taken to hang on different numbers of anchors, {} on {} and {} on {}: the design does "
        "not say which hold them, and those within {:.3g} m (panel_reach) count. Look whether that is so.",
        name_of(**least), (*least)->anchors.size(), name_of(**most), (*most)->anchors.size(), reach));
  }
}

}  // namespace plumbline::judgement

#include "build/evaluate/plate_sides.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "building/ifc/facades.hpp"

namespace plumbline::judgement {
namespace {

/// Plates are true to a few degrees: within 30° they say the same as what is more exact.
const double kPlateAlike = std::cos(30 * std::numbers::pi / 180);

/// A plate that is in dispute itself, though it may stand as the panel does, or a rule that says the opposite.
bool contradicts(const ifc::FacadeFrame& anchor, const ifc::FacadeFrame& panel) {
  const double along = anchor.known() ? anchor.out.dot(panel.out) : 1;
  return (anchor.source == ifc::FacadeSource::plate && !anchor.confirmed) ||
         (anchor.source == ifc::FacadeSource::rule && along < -kPlateAlike);
}

/// The panel turns with its anchors where its plane allows it: they stay one facade, and one rule settles both.
void dispute(PanelCase& panel, const AnchorCase& anchor) {
  const ifc::FacadeFrame before = panel.facade;
  if (std::abs(anchor.facade.out.dot(before.out)) > kPlateAlike) {
    const bool by_rule = anchor.facade.source == ifc::FacadeSource::rule;
    panel.facade = ifc::frame_facing(anchor.facade.out, by_rule ? before.source : ifc::FacadeSource::plate, false);
    panel.facade.facade = before.facade, panel.facade.named = before.named;
  }
  panel.facade.confirmed = false;
  panel.facade.note = anchor.facade.source == ifc::FacadeSource::plate
                          ? anchor.facade.note
                          : "a rule has its anchor " + anchor.id + " face " + ifc::facing_words(anchor.facade.out) +
                                ", and the design has it face " + ifc::facing_words(before.out);
}

/// What the plates at its anchors say holds for a panel too, and so does what they contradict: nobody is sent outward
/// by a panel whose anchors are in dispute.
void follow_anchors(const std::vector<AnchorCase>& anchors, PanelCase& panel) {
  if (panel.facade.known() && panel.facade.source != ifc::FacadeSource::rule)
    for (const std::size_t i : panel.anchors)
      if (contradicts(anchors[i].facade, panel.facade)) return dispute(panel, anchors[i]);
  for (const std::size_t i : panel.anchors) {
    const ifc::FacadeFrame& anchor = anchors[i].facade;
    if (anchor.source == ifc::FacadeSource::plate && anchor.confirmed &&
        (!panel.facade.known() || std::abs(anchor.out.dot(panel.facade.out)) > kPlateAlike))
      return ifc::add_plate(panel.facade, anchor.out);
  }
}

}  // namespace

/// Where all plates of a facade keep, or all turn, what the design had guessed, the rest of it does so too.
void PlateSides::follow_facade(ifc::FacadeFrame& frame) const {
  const auto sides = sides_.find(frame.facade);
  if (frame.confirmed || !frame.known() || sides == sides_.end()) return;
  const auto [least, most] = std::minmax_element(sides->second.begin(), sides->second.end());
  if (*least > 0.8 || *most < -0.8) ifc::add_plate(frame, *least > 0.8 ? frame.out : Eigen::Vector3d(-frame.out));
}

void PlateSides::group(DeviationInputs& inputs) const {
  std::vector<ifc::Facing> all;
  for (AnchorCase& anchor : inputs.anchors) {
    follow_facade(anchor.facade);
    if (anchor.design.allFinite()) all.push_back({anchor.design, &anchor.facade, false});
  }
  for (PanelCase& panel : inputs.panels) {
    follow_anchors(inputs.anchors, panel);
    follow_facade(panel.facade);
    all.push_back({panel.frame_from_panel * Eigen::Vector3d(0.5 * (panel.low + panel.high)), &panel.facade, true});
  }
  inputs.facades = ifc::group_facades(all);
}

}  // namespace plumbline::judgement

// Frames of facades for tests that build their anchors and panels themselves.
#pragma once

#include "building/judgement/deviation.hpp"

namespace plumbline::test {

/// All anchors and panels face `out`, as a rule of the user would say it.
inline void face(judgement::DeviationInputs& inputs, const Eigen::Vector3d& out) {
  const ifc::FacadeFrame frame = ifc::frame_facing(out, ifc::FacadeSource::rule, true);
  std::vector<ifc::Facing> all;
  for (auto& anchor : inputs.anchors) {
    anchor.facade = frame;
    if (anchor.design.allFinite()) all.push_back({anchor.design, &anchor.facade, false});
  }
  for (auto& panel : inputs.panels) {
    panel.facade = frame;
    all.push_back({panel.frame_from_panel * Eigen::Vector3d(0.5 * (panel.low + panel.high)), &panel.facade, true});
  }
  inputs.facades = ifc::group_facades(all);
}

}  // namespace plumbline::test

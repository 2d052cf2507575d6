// What the evaluation takes from a design artifact: anchors and panels.
#pragma once

#include <functional>
#include <string>

#include "artifacts/design.hpp"
#include "judgement/accuracy.hpp"

namespace plumbline::evaluate {

/// Design positions of the anchors, by name; a name that several anchors bear says nothing: it is left out, and `warn`
/// is told.
PointSet design_points(const DesignT& design, const std::function<void(const std::string&)>& warn);

/// Facade panels with the anchors of `points` that hold them: those the design says, else those within kPanelReach of
/// the panel's box. Wholes made of other panels (a curtain wall of plates) are left out, and all panels of a facade
/// without a known direction.
std::vector<PanelEntry> design_panels(const DesignT& design, const PointSet& points);

}  // namespace plumbline::evaluate

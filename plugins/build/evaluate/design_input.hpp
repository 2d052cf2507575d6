// What the judgement takes from the artifacts: which anchor is which element, its tolerances, and the panels it holds.
#pragma once

#include "artifacts/design.hpp"
#include "artifacts/element_matches.hpp"
#include "artifacts/plates.hpp"
#include "building/judgement/deviation.hpp"
#include "building/judgement/mounting.hpp"

namespace plumbline::judgement {

/// Anchors of the plate table with their elements, then those anchors of the design that it does not list; leaf panels
/// with the anchors that hold them: those the design says, else those within kPanelReach of the panel's box. Wholes
/// made of other panels (a curtain wall of plates) are left out. Which way anchors and panels face is what the design
/// says and, before that, the azimuths of the plates.
/// Anchors that `held_below` has as places of a sill hold no panel, whatever the design says.
/// `model` is not filled. Throws std::runtime_error if `matches` names elements that `design` does not have.
judgement::DeviationInputs deviation_inputs(const DesignT& design, const ElementMatchesT& matches,
                                            const PlatesT& plates, const judgement::ToleranceTable& tolerances,
                                            double panel_reach, const judgement::Mounting& mounting = {},
                                            const judgement::HeldBelow& held_below = {});

}  // namespace plumbline::judgement

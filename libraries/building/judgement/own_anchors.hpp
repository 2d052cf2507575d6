// Which anchors hold which panels, where the design does not say so.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "building/judgement/deviation.hpp"

namespace plumbline::judgement {

/// Fills `anchors` of every panel, in their order. `said`: of each panel the GlobalIds of the anchors that the design
/// ties to it; empty where it does not say. Those are its own and nobody else's, unless they are tied to others too. Of
/// the rest a panel has those within `reach` [m] of its box that are not nearer to another panel: a bracket 100 mm
/// within its own panel is no more than 120 mm from the next one, and holds it not. One in the joint between two is of
/// both, and so is one behind a panel and what hangs before that. Panels that face alike are compared along the facade,
/// others by their distance.
/// Returns which panels have anchors within their reach, though none of their own.
std::vector<char> find_own_anchors(std::vector<PanelCase>& panels, const std::vector<std::set<std::string>>& said,
                                   const std::vector<AnchorCase>& anchors, double reach);

/// Which anchors hold a panel decides what it passes by. `panels` (indices of inputs.panels): those of which the design
/// does not say it, and anchors within `reach` [m] were supposed. Adds a request that counts them, and a warning where
/// panels of one size came to different numbers of anchors, though they share some with panels above and below alike:
/// the lowest of a stack, whose sills hold no panel, and the highest have fewer.
void tell_of_nearness(const std::vector<std::size_t>& panels, double reach, DeviationInputs& inputs);

}  // namespace plumbline::judgement

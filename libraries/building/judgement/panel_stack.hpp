// What holds panels at their bottom edge: the panel below, which may be held likewise, or a sill. Private to
// libraries/building/judgement.
//
// A unitised panel hangs on two brackets near its top, and its bottom edge stands in the top edge of the panel below
// (stack joint) or in a starter sill, which hold it out of plane and in no other way. So how far out a panel is depends
// on all panels of its column below it. With h from the bottom edge up to the brackets and H to the top edge, a panel
// whose brackets are out by d and whose bottom edge is by b has its top edge out by d H/h - b (H - h)/h: an error is
// handed on with the other sign, times r = (H - h)/h. Below r = 1 (brackets above mid-height) the standard deviation
// of an edge stays below sqrt(((1 + r)² σd² + σs²) / (1 - r²)), for brackets with σd and joints with σs of their own;
// above it grows from floor to floor. What all brackets share is handed on as it is.
#pragma once

#include <string>
#include <vector>

#include "building/judgement/judged_panel.hpp"

namespace plumbline::judgement {

struct Support {
  PanelSupportT told;  ///< `by` is empty where nobody says that anything holds the panel, or its anchors tell all of it
  std::string doubt;   ///< why the panel is undecided although its support is known; empty: nothing is against it
};

/// Holds every panel that is said to be held below and that its anchors alone do not tell; one entry for each of
/// `panels`. The panel below is found along the directions of the one above, among those that nobody measured, too.
/// None, or more than one, is no support. What joints and assumed sills add is appended to `basis`.
std::vector<Support> hold_panels(std::vector<JudgedPanel>& panels, const DeviationInputs& inputs, LengthBasis& basis);

/// What the reader is to know of them: sills that were assumed, edges whose errors grow upwards.
std::vector<std::string> support_warnings(const std::vector<std::unique_ptr<PanelDeviationT>>& panels);

}  // namespace plumbline::judgement

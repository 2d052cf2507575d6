// What panels are called in plans and jobs, so that people know which of them to hang.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "artifacts/loop_state.hpp"
#include "build/loop/design_elements.hpp"
#include "loop/fit/facade.hpp"

namespace plumbline::loop {

/// Names of the judged panels by their GlobalIds: by its name where that is its own. Else as a round before named it,
/// by its tag, or by its name and the anchor next to its lower left corner: a GlobalId tells nobody which panel to
/// hang. `state`: null in the first round.
std::map<std::string, std::string> names_of_panels(const DeviationT& deviation, const DesignElements& elements,
                                                   const LoopStateT* state);

/// As a round before named a panel that is not judged, by its name where no other has it, or its GlobalId. `planned`:
/// those whose names are taken.
std::string name_of_unplanned(const DesignElementT& element, const DesignElements& elements, const LoopStateT* state,
                              const std::vector<Panel>& planned);

/// Ids of the anchors that hold a panel, also of those that nobody measured.
std::vector<std::string> anchors_of(const PanelDeviationT& judged);

}  // namespace plumbline::loop

// Which panels wait for which: what stands below, what joints say, what people say.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "artifacts/loop_state.hpp"
#include "build/loop/design_elements.hpp"
#include "build/loop/facade_input.hpp"

namespace plumbline::loop {

/// `panel` hangs after the one called `before`.
void depend(Panel& panel, const std::string& before);

/// A panel waits for the next ones below, whatever is between; for those too of which no anchor was measured, and
/// which are no panels of the facade (a note says so). `panel_at`: places of the planned panels by GlobalId. Throws
/// std::runtime_error where `standing` names no panel of the design.
void wait_for_what_is_below(const FacadeRules& rules, const DesignElements& elements,
                            const std::map<std::string, std::size_t>& panel_at, const LoopStateT* state,
                            FacadeInput& in);

/// As FacadeRules::after says. Throws std::runtime_error that names a panel which is none.
void add_dependence(const std::string& panel, const std::vector<std::string>& before, std::vector<Panel>& panels);

}  // namespace plumbline::loop

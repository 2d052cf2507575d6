// What to do next, for who stands on the site.
#pragma once

#include <string>

#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

/// First how far it is and the next step, then floor by floor what is to be set, hung, measured and looked at, and what
/// each waiting panel waits for. Text of several lines.
std::string next_words(const LoopStateT& state);

/// The next step alone.
std::string next_step(const LoopStateT& state);

}  // namespace plumbline::loop

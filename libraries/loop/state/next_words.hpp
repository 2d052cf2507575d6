// What to do next, for who stands on the site.
#pragma once

#include <string>

#include "artifacts/loop_state.hpp"

namespace plumbline::loop {

/// LoopItem::why of a bracket that is planned and waits for nothing: it is no work.
inline constexpr const char* kHoldsNothing = "no panel hangs on it: nothing is to be set";
/// Of a place of a sill; after it what it holds.
inline constexpr const char* kHoldsEdge = "holds the bottom edge of ";
/// Of one whose panel this plan leaves out.
inline constexpr const char* kHoldsUnplanned = "the panel on it is not planned: installation.txt says why";

/// First how far it is and the next step, then floor by floor what is to be set, hung, measured and looked at, and what
/// each waiting panel waits for. Text of several lines.
std::string next_words(const LoopStateT& state);

/// The next step alone.
std::string next_step(const LoopStateT& state);

}  // namespace plumbline::loop

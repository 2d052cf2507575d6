// What tests of rounds begin with: a panel that is released, and one that hangs.
#pragma once

#include "two_floors.hpp"

namespace plumbline::test {

/// Brackets of the first panel set, measured, verified; the panel is released.
inline LoopStateT with_released_panel() {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, plan_after_setting(0));
  return state;
}

inline LoopStateT with_hung_panel() {
  LoopStateT state = with_released_panel();
  apply_actuals(state, done({"p0"}, item(state, "p0").revision));
  return state;
}

}  // namespace plumbline::test

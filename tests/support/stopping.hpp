// Whether a node can be stopped: it is asked to end at some of the places where it asks, the first and the last among
// them, and must say that it was stopped, not that its work failed, and give no result as if nothing had been.
#pragma once

#include <functional>
#include <string>
#include <utility>

#include "node_harness.hpp"
#include "parameter_effects.hpp"

namespace plumbline::test {

/// Kinds that may take longer than a second must ask; those that never take so long need not.
enum class MayTakeLong { yes, no };

/// A line for each place where the node was told to stop and did something else. `situation`: the node with inputs, for
/// which it succeeds.
inline std::string stopping_at_fault(const Situation& situation, MayTakeLong may = MayTakeLong::yes) {
  NodeHarness undisturbed = situation();
  if (const std::string outcome = undisturbed.outcome(); outcome.rfind("failed: ", 0) == 0)
    return "nothing can be seen of a node that fails by itself: " + outcome + "\n";
  const long asks = undisturbed.asked_to_stop();
  if (asks == 0)
    return may == MayTakeLong::no
               ? ""
               : "it never asks whether it is to stop, so Ctrl-C waits for its end: call plumbline::stop_point() "
                 "(plumbline/stop.hpp) in the loops that take long\n";
  std::string faults;
  for (int part = 0; part <= 4; ++part) {
    const long limit = (asks - 1) * part / 4;
    NodeHarness node = situation();
    node.stop_after(limit);
    const std::string outcome = node.outcome();
    // Several threads ask in another order each time: who was not told to stop need not have.
    if (outcome.rfind("failed: stopped", 0) != 0 && node.asked_to_stop() > limit)
      faults += "told to stop when it asked the " + std::to_string(limit + 1) + ". of " + std::to_string(asks) +
                " times, it said: " + outcome.substr(0, 300) + "\n";
  }
  return faults;
}

}  // namespace plumbline::test

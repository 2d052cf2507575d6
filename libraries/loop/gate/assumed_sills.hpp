// Sills that nobody measured: what stands on them is GO by an assumption.
#pragma once

#include <string>
#include <vector>

#include "loop/gate/gate.hpp"

namespace plumbline::loop {

/// A panel that would not be GO were the sill below it, or below what it stands on, twice as far off as it is taken to
/// be, is HOLD: the assumption decides it. One that stands on such a sill and is GO either way says that it is assumed.
void doubt_assumed_sills(const Facade& facade, const Fit& fit, const GateOptions& options,
                         std::vector<PanelGate>& gates);

/// What is assumed, as a note; empty: nothing.
std::string assumed_sill_words(const Facade& facade);

}  // namespace plumbline::loop

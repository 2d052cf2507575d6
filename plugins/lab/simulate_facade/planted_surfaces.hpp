// The truth of a simulated facade in the words of what measures it.
#pragma once

#include "artifacts/surfaces.hpp"
#include "panelled_facade.hpp"

namespace plumbline::simulate {

/// Adds the panels of a facade as they hang, row by row of `columns`, each on the design's plane at its own place along
/// it, and the joints between neighbours, every 10 mm. A panel that no photograph can measure says what it is in
/// `not_measured`.
void add_planted_surfaces(const PanelledFacade& facade, std::int64_t columns, double nominal_joint, SurfacesT& planted);

}  // namespace plumbline::simulate

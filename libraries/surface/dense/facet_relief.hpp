// What facets beside each other say of the form of the surface: relief too fine for a facet, and heights that nothing
// around them supports.
#pragma once

#include <vector>

#include "surface/dense/facet.hpp"

namespace plumbline::surface {

/// By facet what its place lies off the straight lines through its neighbours, beyond the noise of their heights, over
/// the extent of a facet instead of their distance (relief of stone, brick or ornament grows with the length it is
/// looked at over) [m]. A facet is taken for a plane; where the surface is none, its height hangs on which part of it
/// has texture and on who sees it, by some share of this. 0 where nothing is known, and of facets that were not
/// measured.
///
/// From second differences of heights, which planes of any slope do not have: along rows, columns and both diagonals
/// the facet against the middle of its two neighbours, or, at the border of what was measured, against the next two;
/// the median of their squares counts, so that one wrong neighbour says nothing, and the median of all facets as much
/// as one of them.
std::vector<double> relief_around(const std::vector<const Facet*>& facets);

}  // namespace plumbline::surface

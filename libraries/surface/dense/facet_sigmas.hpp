// Standard deviations of facets that were measured beside each other.
#pragma once

#include <vector>

#include "surface/dense/facet.hpp"

namespace plumbline::surface {

/// What photographs do to facets beside each other, each photograph as a whole.
struct ViewScatter {
  /// How many times larger the variance of each facet's height is because its photographs pull apart by what is its
  /// own: light, or what one sees of a stone that another does not. Of one facet as uncertain as chi-square with the
  /// number of its views less 2 degrees of freedom over that number. 1 where it is not known: of two photographs, which
  /// a height always brings together, and of facets that were not measured.
  std::vector<double> apart;
  /// Further than the mean of all, because what a photograph is off on all facets alike (its orientation, its lens)
  /// moves each by what the directions of its own texture let it [m]. What it moves all of them by is no random error,
  /// and the orientations' covariance states it. 0 where it is not known.
  std::vector<double> uneven;
};

/// Source: the covariance of estimates whose errors come in clusters, here photographs (Liang and Zeger 1986), over
/// what is left of it in residuals (Bell and McCaffrey 2002), after the shifts that each photograph has on all facets,
/// which are found by least squares together with the facets' heights.
ViewScatter view_scatter(const std::vector<const Facet*>& facets);

/// Standard deviations of the facets that are measured, 0 of the others: enlarged by what neighbouring places of a
/// facet are off together or by what photographs pull apart, whichever is more, on average over all, since of one facet
/// both are too uncertain to weight points by; of a facet whose photographs pull apart more than those of the others by
/// more, as much as its own few photographs say against `others` degrees of freedom that the average counts as. To this
/// comes what photographs that were left out contradict (Facet::set_aside), the square of `uneven`, and that of a
/// third of the relief around the facet (relief_around), which holds too where a height stands alone because something
/// else was matched.
std::vector<double> stated_sigmas(const std::vector<const Facet*>& facets, double others = 8);

/// The same without facets whose standard deviation comes out above `most` [m]: those are infinite. They go from the
/// worst on, since one whose photographs contradict each other (at the border of something before the facade) makes the
/// average of all larger.
std::vector<double> sigmas_within(const std::vector<const Facet*>& facets, double most);

}  // namespace plumbline::surface

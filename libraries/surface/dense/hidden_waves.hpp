// What lies within the cells that flatness takes the means of, and their means do not show.
#pragma once

#include <vector>

#include "surface/dense/panel_samples.hpp"

namespace plumbline::surface {

/// Waves, grooves or dents that are smaller than a cell, as a height from valley to crest [m]; 0 if no cell shows one.
/// Of the cell with most, the larger of two:
/// - what its points scatter by beyond their noise, as a sine of that variance. Noise is what is stated; where the
///   points' errors are independent of each other (PanelOptions::independent, a scan) it is no more than neighbours
///   differ by (von Neumann's mean square successive difference, Annals of Mathematical Statistics 12, 1941): a noise
///   that is stated too large hides no wave.
/// - how far behind the surface those points lie that do not count in it: nothing can be seen through a panel, so they
///   are grooves of it.
double hidden_in_cells(const PanelFace& face, const std::vector<Sample>& samples, const std::vector<char>& counts,
                       const Vector6& form, const PanelOptions& options);

}  // namespace plumbline::surface

// The transfer curve of a photograph, as the profiles of the edges in it tell.
#pragma once

#include <vector>

#include "photo/detect/corner_refinement.hpp"

namespace plumbline::detect {

struct CurveEstimate {
  double gamma = 1;        ///< see EdgeFitOptions::gamma
  double inset_sigma = 0;  ///< what the doubt about it moves all edges by together, to or from their dark side [px]
};

/// The exponent that explains the edges best, of those that cameras have; where JPEG, noise or sharpening hide it, the
/// most usual. Blur mixes light, so a wrong curve moves all edges towards the dark side or away from it: by how much is
/// the scatter of the edges over the curves, weighted by how likely each of them is.
CurveEstimate estimate_curve(const std::vector<Quadrilateral>& found, const EdgeFitOptions& options);

/// Standard deviation of the mean misfit that chance alone gives, from the edges' mean squared noise in units of their
/// contrast and their pixels.
double chance_of(double relative_noise_squared, double samples);

}  // namespace plumbline::detect

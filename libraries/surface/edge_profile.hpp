// The place of an edge in a row of grey values.
#pragma once

#include <optional>
#include <vector>

namespace plumbline::surface {

struct Edge {
  double place = 0;   ///< in samples, from the first
  double sigma = 0;   ///< of the place: noise and what the model leaves
  double rise = 0;    ///< grey values from the left level to the right one
};

/// Fits level + rise · Φ((x − place) / blur) to the samples within `window` of `start` by Gauss-Newton. Nothing where the
/// fit does not hold, leaves the window, or rises less than four times its noise.
std::optional<Edge> fit_edge(const std::vector<double>& samples, double start, double window);

/// The steepest place within `reach` of `middle`: of rising edges, or of falling ones. Negative if there is none.
double steepest(const std::vector<double>& samples, double middle, double reach, bool rising);

}  // namespace plumbline::surface

// The places of a joint's two edges in a row of grey values.
#pragma once

#include <optional>
#include <vector>

namespace plumbline::surface {

/// Two edges and what lies between them.
struct GapEdges {
  double place[2] = {0, 0};  ///< in samples, from the first
  double sigma[2] = {0, 0};
};

/// Fits three levels with edges at two places and one blur to the samples from `window` before the first start to
/// `window` behind the second. Nothing where the fit does not hold, or an edge rises less than four times the noise or
/// in the wrong direction: `dark` says that the middle is darker than both sides.
std::optional<GapEdges> fit_gap(const std::vector<double>& samples, double first, double second, double window,
                                bool dark);

/// The steepest place within `reach` of `middle`: of rising edges, or of falling ones. Negative if there is none.
double steepest(const std::vector<double>& samples, double middle, double reach, bool rising);

}  // namespace plumbline::surface

// Where crosshairs and quadrant targets may be: templates of both, turned, over the neighbourhood of a prediction.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "photo/detect/target_fit.hpp"

namespace plumbline::detect {

/// A place that looks like a target at one size.
struct TargetCandidate {
  TargetKind kind = TargetKind::quadrants;
  Eigen::Vector2d centre{0, 0};  ///< right to about a pixel [px]
  double radius = 0;             ///< out to which it was compared [px]
  double first = 0, second = 0;  ///< directions of the two lines [rad]
  double half_width = 0;         ///< of a crosshair's bars [px]
  double likeness = 0;           ///< correlation with the template; negative: black and white exchanged
};

struct TargetSearch {
  std::vector<TargetCandidate> candidates;  ///< the likeliest first, apart from each other
  bool contrast_seen = false;
};

TargetSearch search_targets(const GreyImage& image, const Eigen::Vector2d& predicted, const TargetFitOptions& options);

}  // namespace plumbline::detect

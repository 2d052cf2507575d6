// A similarity between point sets of which some may be wrong, such as surveyed points and a model that shows them.
#pragma once

#include <vector>

#include "geometry/similarity.hpp"

namespace plumbline::markers {

struct RobustSimilarity {
  SimilarityMotion motion;
  std::vector<double> distances;  ///< of each pair after the motion [unit of `to`]
  std::vector<bool> agrees;       ///< pairs that the motion was fitted to
};

/// The motion that two thirds of the pairs agree with best (triples of pairs, all of them or 2000), refitted to all
/// pairs within five times their distance and within `tolerance` at least. Three pairs are taken as they are. Throws
/// std::runtime_error if there are fewer than three, or all lie on one line.
RobustSimilarity fit_similarity_robustly(const std::vector<Eigen::Vector3d>& from,
                                         const std::vector<Eigen::Vector3d>& to, double tolerance);

}  // namespace plumbline::markers

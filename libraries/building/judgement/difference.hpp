// Differences between two point sets with the covariance of the differences.
#pragma once

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "building/judgement/accuracy.hpp"

namespace plumbline::judgement {

/// Index of every id of a point set. Throws std::runtime_error, naming `what`, on a repeated id or a covariance of the
/// wrong size.
std::map<std::string, std::size_t> index_points(const PointSet& points, const std::string& what);

/// Model minus reference for some anchors.
struct DifferenceSet {
  std::vector<std::size_t> anchors;  ///< index into the anchor table
  Eigen::VectorXd difference;        ///< 3n [m], x y z of each anchor
  BlockCovariance covariance;        ///< 3n x 3n [m²]

  std::size_t size() const { return anchors.size(); }
  Eigen::VectorXd heights() const;  ///< n [m]
  DifferenceSet subset(const std::vector<std::size_t>& positions) const&;
  /// The same without a copy of blocks that are taken whole.
  DifferenceSet subset(const std::vector<std::size_t>& positions) &&;
};

/// Which point stands for an anchor in model and reference.
struct Match {
  std::size_t anchor, model, reference;
};

/// Covariance of model minus survey for the matches: S_M + S_S - C - C', with C = cov(model, survey).
///
/// For a model that was adjusted to the surveyed control K with its covariance, (5), the estimate moves with the survey
/// by dX/dS_K = S_M[:,K] S_S[K,K]^-1, the gain of a direct observation, so C = S_M[:,K] S_S[K,K]^-1 S_S[K,:]. On
/// control anchors that is the covariance of adjusted residuals, S_S - S_M; on check anchors it carries what the survey
/// network ties them to the control by. Exact for `covariance` weights; a model of other weights can make the result
/// indefinite, which `consistent` tells.
struct DifferenceCovariance {
  BlockCovariance matrix;  ///< 3n x 3n [m²], order of the matches
  bool consistent = true;  ///< false: C did not fit to S_M and S_S, and the matrix is S_M + S_S
};
DifferenceCovariance difference_covariance(const PointSet& model, const PointSet& survey,
                                           const std::vector<Match>& matches, const std::vector<Match>& control);

}  // namespace plumbline::judgement

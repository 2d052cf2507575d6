// Check points: surveyed, and withheld from the adjustment to judge it by. What they are off is compared with what the
// covariances of block and survey allow.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plumbline::block {

struct JudgedCheckPoint {
  std::string name;
  Eigen::Vector3d difference;  ///< adjusted minus surveyed [m]
  Eigen::Vector3d w;           ///< over its standard deviation, coordinate by coordinate
  double nees = 0;  ///< dᵀ Σ⁻¹ d, 3 degrees of freedom; infinite where Σ is singular and d is not zero
  bool contradicts = false;
};

struct CheckJudgement {
  std::vector<JudgedCheckPoint> points;
  double limit = 0;  ///< of one point's NEES: 0.1 % for all points together (Šidák 1967)
  /// Of the points that do not contradict, with the covariance that they have in common.
  double nees = 0, freedom = 0, joint_limit = 0;
  bool holds = true;               ///< no point contradicts, and all together are not off by more than is stated
  std::vector<std::string> words;  ///< a sentence for each thing that does not hold
};

/// `differences` [m] and their covariance [m²]: that of the block plus that of the survey, in the order of `names`,
/// three rows a point. Where only the blocks of single points are known (`joint` false), what the points have in common
/// is not, and all together are not tested.
CheckJudgement judge_check_points(const std::vector<std::string>& names, const Eigen::VectorXd& differences,
                                  const Eigen::MatrixXd& covariance, bool joint = true);

/// Largest NEES of three degrees of freedom that is no contradiction, where so many points are tested together.
double check_limit(std::size_t points);

}  // namespace plumbline::block

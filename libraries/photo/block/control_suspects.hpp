// Which single points of a block's control are wrong, and whether that can be told.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace plumbline::block {

/// A control point that contradicts the rest, and what its survey is off.
struct SuspectedControl {
  std::size_t point = 0;
  double test = 0, limit = 0;  ///< chi-squared
  int freedom = 3;
  Eigen::Vector3d off;  ///< survey minus model [m]
};

/// Points one of which is wrong, and which the others do not tell.
struct RivalControl {
  SuspectedControl worst;
  std::vector<std::size_t> others;  ///< that, were they wrong, would explain the same as well
};

struct ControlSuspects {
  std::optional<SuspectedControl> worst;  ///< of those that contradict and have no rival the one that does so most
  std::vector<RivalControl> rivals;       ///< what contradicts more than `worst`, or all there is
  std::vector<std::size_t> hidden;        ///< points that may be off in some direction without that it shows
};

/// Tests the points one by one (Baarda 1968; Kok 1984). With the weights P of all control coordinates, three a point,
/// their residuals v (adjusted minus survey) and the cofactors Q of the adjusted coordinates: `weight` is P, `seen` is
/// P - P Q P, what of errors shows, `pull` is P v. Of the three coordinates b of a point T = pull_b^T seen_bb^-1 pull_b
/// is chi-squared with 3 degrees of freedom at 0.001 over all points, and -seen_bb^-1 pull_b what the survey is off. In
/// directions in which less than a hundredth of an error shows nothing is tested, and T has fewer degrees of freedom. A
/// point explains a contradiction as well as the worst one if the worst is not contradicted any more once that point's
/// error is an unknown (Foerstner 1983). Rivals are no end: errors of all of them are unknowns, and the other points
/// are tested beside those, so that what is clear whoever of the rivals is wrong is found. `unknown`: points whose
/// error is one from the beginning. `variance`: of unit weight, if it is not 1.
ControlSuspects suspects_of(const Eigen::MatrixXd& seen, const Eigen::MatrixXd& weight, const Eigen::VectorXd& pull,
                            double variance = 1, std::vector<std::size_t> unknown = {});

}  // namespace plumbline::block

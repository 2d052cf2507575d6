// What the photographs of one camera, each by itself, say of its interior orientation: how far they scatter, and what
// that makes of the covariance of their adjustment.
//
// The covariance of an adjustment takes every corner's error for its own. What a photograph's corners have in common
// (rows read one after another, a principal point that a stabiliser moves, a lens that is not quite the model) errs
// with the photograph, so hundreds of corners are as good as one photograph. The scatter between the photographs holds
// it.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "geometry/camera.hpp"
#include "photo/markers/photograph_shares.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::markers {

/// Effects that a photograph may have of its own and the model has not: how far the rows move from the first to the
/// last, along x and along y [px].
constexpr int effect_count = 2;

/// Derivatives of `pixel` by the effects, 2 × effect_count; of a camera whose image is `height` high.
Eigen::Matrix2d effects_at(const Eigen::Vector2d& pixel, int height);

/// Photographs of one camera in the order of their names, numbers counted as numbers.
struct CameraEvidence {
  std::vector<std::string> paths;
  std::vector<int> members;                     ///< their shares
  std::vector<int> parameters;                  ///< which of the nine are estimated, ascending
  Eigen::MatrixXd formal;                       ///< their covariance by the adjustment
  std::vector<Eigen::VectorXd> score;           ///< of each photograph: the parameters', then the effects'
  std::vector<Eigen::MatrixXd> information;     ///< of each: of the same, all else known
  std::vector<Eigen::VectorXd> change_without;  ///< of the parameters, if the photograph is left out
  /// The photographs show an object that is known, as a board. Tags in unknown places follow a camera that changes, so
  /// that its scores tell less than the change.
  bool object_is_known = false;
};

/// `shares` with effects and `cofactor` are of one adjustment, `factor` is its variance factor: scores and information
/// are divided by it. `columns`: the nine parameters' in the kept unknowns, −1 for those held; `members`: shares of
/// this camera's photographs, `paths` their names.
CameraEvidence evidence_of(const std::vector<PhotographShare>& shares, const Eigen::MatrixXd& cofactor, double factor,
                           const std::vector<int>& columns, const std::vector<int>& members,
                           const std::vector<std::string>& paths);

/// Fewer photographs than this say too little of their scatter to be believed alone.
constexpr int fewest_to_scatter = 6;

struct EmpiricalCovariance {
  bool judged = false;  ///< false: fewer than fewest_to_scatter photographs, see empirical_covariance()
  int photographs = 0;
  Eigen::MatrixXd scatter;  ///< covariance of the estimated parameters by the scatter of the photographs alone
  Eigen::MatrixXd written;  ///< the larger of this and the formal one, direction by direction
  double factor = 1;        ///< by which the standard deviations of `written` are larger than the formal ones
  double by_order = 1;  ///< of that: because photographs that follow one another err alike; by_place alike, where the
  double by_place = 1;  ///< larger one counts
  Eigen::VectorXd sigma_ratio;  ///< of each parameter
  /// Standard deviations by the bootstrap over photographs over those of `scatter`, median over the parameters.
  double bootstrap_ratio = 1;
};

/// Covariance from the scatter of the photographs: the change of the parameters with each photograph left out. These
/// changes are larger than what the photographs do, the more so the more of the information each of few has, and the
/// larger for errors of single corners than for effects of whole photographs. Both are computed (expected_scatter), in
/// a model of the corners' errors and one effect of all parameters alike, whose size makes the mean of both fit, and
/// the scatter is reduced by that (bias-reduced linearisation by a working model: Bell and McCaffrey 2002, Bias
/// reduction in standard errors for linear regression with multi-stage samples, Survey Methodology 28(2)). From n
/// photographs a matrix of nine parameters is a rough one: its mean given them counts, in an inverse Wishart
/// distribution around the model's covariance whose narrowness they tell (most_likely), and no direction gets less than
/// the formal one.
///
/// Photographs that follow one another, or were taken from places near to each other (`cam_from_object`, in the order
/// of the evidence; may be empty), err alike where a board is not quite the model or a camera moves on: their
/// influences are then summed with the products of neighbours (Newey and West 1987 in the order; Conley 1999 by place),
/// and the whole is enlarged by what that adds in the mean over the parameters.
///
/// Of fewer than fewest_to_scatter photographs the formal covariance is enlarged by one factor, that of their scatter
/// drawn towards what public sets of photographs have.
EmpiricalCovariance empirical_covariance(const CameraEvidence& evidence,
                                         const std::vector<RigidTransform>& cam_from_object = {});

/// 9 × 9 of the estimated parameters' p × p.
Eigen::MatrixXd in_nine(const CameraEvidence& evidence, const Eigen::MatrixXd& of_estimated);

}  // namespace plumbline::markers

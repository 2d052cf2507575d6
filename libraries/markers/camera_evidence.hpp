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

#include "adjustment/schur.hpp"
#include "geometry/camera.hpp"
#include "markers/photograph_shares.hpp"

namespace plumbline::markers {

/// Effects that a photograph may have of its own and the model has not: how far the rows move from the first to the
/// last, along x and along y [px].
constexpr int effect_count = 2;

/// Derivatives of `pixel` by the effects, 2 × effect_count; of a camera whose image is `height` high.
Eigen::Matrix2d effects_at(const Eigen::Vector2d& pixel, int height);

/// Numbers in names count as numbers: 2.jpg before 10.jpg.
bool before_by_name(const std::string& a, const std::string& b);

/// Photographs of one camera in the order of their names, numbers counted as numbers.
struct CameraEvidence {
  std::vector<std::string> paths;
  std::vector<int> members;                     ///< their shares
  std::vector<int> parameters;                  ///< which of the nine are estimated, ascending
  Eigen::MatrixXd formal;                       ///< their covariance by the adjustment
  std::vector<Eigen::VectorXd> score;           ///< of each photograph: the parameters', then the effects'
  std::vector<Eigen::MatrixXd> information;     ///< of each: of the same, all else known
  std::vector<Eigen::VectorXd> change_without;  ///< of the parameters, if the photograph is left out
};

/// `shares` with effects and `cofactor` are of one adjustment, `factor` is its variance factor: scores and information
/// are divided by it. `columns`: the nine parameters' in the kept unknowns, −1 for those held; `members`: shares of
/// this camera's photographs, `paths` their names.
CameraEvidence evidence_of(const std::vector<PhotographShare>& shares, const Eigen::MatrixXd& cofactor, double factor,
                           const std::vector<int>& columns, const std::vector<int>& members,
                           const std::vector<std::string>& paths);

/// Fewer photographs than this say nothing of their scatter.
constexpr int fewest_to_scatter = 6;

struct EmpiricalCovariance {
  bool judged = false;  ///< false: fewer than fewest_to_scatter photographs, and `written` is the formal one
  int photographs = 0;
  Eigen::MatrixXd scatter;      ///< covariance of the estimated parameters by the scatter of the photographs alone
  Eigen::MatrixXd written;      ///< the larger of this and the formal one, direction by direction
  double factor = 1;            ///< by which the standard deviations of `written` are larger than the formal ones
  Eigen::VectorXd sigma_ratio;  ///< of each parameter
  /// Standard deviations by the bootstrap over photographs over those of `scatter`, median over the parameters.
  double bootstrap_ratio = 1;
};

/// Covariance from the scatter of the photographs: the sandwich, in which each photograph's influence meets its change
/// with the photograph left out, so that the leverage of few photographs leaves it without bias (Kline, Saggio and
/// Sølvsten 2020, by clusters). From n photographs a matrix of nine parameters is a rough one: it is drawn towards the
/// formal one times its mean ratio as far as its own scatter says (Ledoit and Wolf 2004), and no direction gets less
/// than the formal one.
EmpiricalCovariance empirical_covariance(const CameraEvidence& evidence);

/// 9 × 9 of the estimated parameters' p × p.
Eigen::MatrixXd in_nine(const CameraEvidence& evidence, const Eigen::MatrixXd& of_estimated);

/// An effect of single photographs that makes them scatter as they do.
struct Scatter {
  enum class Kind { none, focus, principal_point, rolling_shutter };
  Kind kind = Kind::none;
  double rms = 0;             ///< of focus: relative; else [px]
  double gain = 0;            ///< of the logarithm of the likelihood, over the other effects without it
  Kind instead = Kind::none;  ///< another that explains as much in its place, within significant_gain
  double instead_rms = 0;
};

/// Logarithm of a likelihood ratio from which an effect counts.
constexpr double significant_gain = 5;

/// The effects, each normal from photograph to photograph, whose variances together explain the scores best: one after
/// the other that explains most of what those before it leave, each only if it adds more than significant_gain beside
/// all others.
std::vector<Scatter> explain_scatter(const CameraEvidence& evidence, const BrownCamera& camera);

/// That of a kind; 0 where it is not among them.
double rms_of(const std::vector<Scatter>& causes, Scatter::Kind kind);

/// The evidence with a movement of the rows of each photograph by `rms` [px] as an unknown of its own, normal about
/// zero, taken out: scores about the parameters that fit best then. What is left scatters less, and differs sooner.
CameraEvidence without_rolling_shutter(const CameraEvidence& evidence, double rms);

/// Scores about the parameters that fit best if the principal distance and point are each photograph's own, as far as
/// `causes` has them scatter: photographs with another one do not pull those of the rest.
CameraEvidence about_common(const CameraEvidence& evidence, const BrownCamera& camera,
                            const std::vector<Scatter>& causes);

/// What to say of a camera whose photographs scatter by more than its corners allow; empty if they do not.
std::string in_words(const EmpiricalCovariance& empirical, const std::vector<Scatter>& causes);

/// That they scatter, without a cause.
std::string scatter_in_words(const EmpiricalCovariance& empirical);

}  // namespace plumbline::markers

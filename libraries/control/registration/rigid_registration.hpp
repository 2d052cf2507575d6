// Registration of two sets of points, equations (6) and (8): target_k = scale · rotation · source_k + translation.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "plumbline/failure.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::registration {

/// The covariance of the source that weights follow is always that of its inner datum, see inner_datum().
enum class Weighting {
  equal,       ///< every point counts alike; closed form
  scalar,      ///< one weight a point, 3 / trace of the sum of both covariances; closed form: (6) as printed
  covariance,  ///< full covariance of both sides, correlations between points included; Gauss-Newton
};

struct Options {
  Weighting weighting = Weighting::equal;
  bool estimate_scale = false;
  /// Width of the figure of control points over its length (ratio of the second to the first principal deviation). A
  /// figure that is narrower is taken for a line: the rotation about it would come from noise.
  double min_width_ratio = 0.01;
  /// One a point, positive; empty: 1. For robust estimation, with weighting by covariance only. They change the
  /// estimate; its covariance is that of the given covariances through the weighted estimate.
  Eigen::VectorXd point_weights{};
  /// Somebody else's least-squares rotation of equal weights between points that have both their
  /// centroid at the origin: target = R source. Takes the place of ours; translation and statistics follow from it. For
  /// equal weights without scale only.
  std::function<Eigen::Matrix3d(const Eigen::Matrix3Xd& source, const Eigen::Matrix3Xd& target)> rotation{};
};

/// Points that correspond, one a column [m], each with the 3n x 3n covariance [m²] or an empty matrix if it is not
/// known.
struct Correspondences {
  std::vector<std::string> ids;  ///< for messages
  Eigen::Matrix3Xd source, target;
  Eigen::MatrixXd source_covariance, target_covariance;
};

struct Registration {
  RigidTransform to_from_from;
  double scale = 1;
  /// Of (rotation vector in the target frame [rad], translation [m]), and scale if it was estimated: 6 x 6 or 7 x 7.
  Eigen::MatrixXd covariance;
  Eigen::Matrix3Xd residuals;           ///< target minus transformed source [m]
  Eigen::Matrix3d residual_covariance;  ///< (8) as printed, with 1 / (N - 1) [m²]
  Eigen::Matrix3d
      residual_covariance_unbiased;  ///< with 3 / (3N - unknowns): its trace is that of one point's error [m²]
  double sigma0 = 0;                 ///< a posteriori; [1] if covariances were given, else [m]
  /// Standard deviation of the scale if the source is taken for free of error in scale: what control leaves it. nan
  /// with 6 unknowns.
  double sigma_scale_of_control = std::numeric_limits<double>::quiet_NaN();
  double weighted_sum_of_squares = 0;
  int degrees_of_freedom = 0;
  int unknowns = 6;
  /// Influence of the residuals on (rotation vector, position of the source's centroid, scale), unknowns x 3n.
  Eigen::MatrixXd influence;
  Eigen::Vector3d source_centroid;     ///< about which `influence` is meant
  Eigen::MatrixXd centred_covariance;  ///< of (rotation vector, position of the source's centroid, scale)
};

/// The points do not determine the transform; the text names the direction that is free.
class DegenerateRegistration : public BadInput {
 public:
  using BadInput::BadInput;
};

/// Covariance [m²], 3n x 3n, of points in the datum that these points hold themselves: S C S' with
/// S = I - A (A'A)^-1 A' (Baarda 1973), A the slopes of a motion (6 unknowns) or of a motion and scale (7), so that the
/// mean position, orientation and size of the figure are without error. The same for every datum that `covariance` may
/// be stated in, if its blocks between points are.
Eigen::MatrixXd inner_datum(const Eigen::MatrixXd& covariance, const Eigen::Matrix3Xd& points, int unknowns);

/// Closed form: Umeyama (1991) with weights. Full covariances: Gauss-Newton from there, weights from C_target + s² R
/// C_inner R'. A singular sum, as two free networks have, is treated by Rao's unified least squares (Rao 1971), which
/// needs the transform to cover the null space. Throws DegenerateRegistration, and std::invalid_argument for what does
/// not fit together.
///
/// Why the inner datum: what leaves a registration are moved points. Let e be the errors of the source, t those of the
/// target, and G an estimate of the transform, G A = I, from target minus source. Points come out with the error
/// e + A G (t - e). With e = S e + A a, the part a that is a motion (and scale) of all these points drops out of any G:
/// S e + A G (t - S e). Both terms are orthogonal, A' S = 0, so that the points come out best where G (t - S e) is
/// least: by weights from C_target + S C_source S' (Gauss-Markov). Weights from C_source itself make the transform
/// between the two data as good as can be, out of what a and S e have in common, and the points pay for it. The
/// covariances that are stated go by G from the covariances as given.
Registration register_points(const Correspondences& points, const Options& options);

/// States the covariances of a fit from those of the points that took part, through its influence.
void state_covariance(const Correspondences& points, Registration& fit);

/// Derivative of a moved point by (rotation vector, position of the source's centroid, scale), 3 × unknowns.
Eigen::MatrixXd point_slopes(const Registration& registration, const Eigen::Vector3d& source);

/// Points of the source frame in the target frame, with covariance. `fitted` are the columns of `points` that took part
/// in the registration, in its order: their errors act twice, by themselves and through the transform, and that is
/// accounted for.
struct MovedPoints {
  Eigen::Matrix3Xd positions;
  Eigen::MatrixXd covariance;  ///< 3m x 3m [m²]; empty if `covariance` was
};
MovedPoints move_points(const Registration& registration, const Eigen::Matrix3Xd& points,
                        const Eigen::MatrixXd& covariance, const std::vector<int>& fitted,
                        const Eigen::MatrixXd& target_covariance);

}  // namespace plumbline::registration

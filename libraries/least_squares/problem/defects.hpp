// Says in words what an adjustment does not determine.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plumbline::least_squares {

struct NamedPoint {
  std::string name;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< [m]
};

/// Similarity motions about a centre, dX = t + ω × (X − centre) + s (X − centre), in the order t (3), ω (3), s.
constexpr int motion_count = 7;

/// Motions of `points` as columns, 3n × 7.
Eigen::MatrixXd motion_basis(const std::vector<NamedPoint>& points, const Eigen::Vector3d& centre);

Eigen::Vector3d centre_of(const std::vector<NamedPoint>& points);

/// Names a subspace of similarity motions (7 × d, any basis): "scale", "translation along (…)", "rotation about the
/// line through A and B". `fixed` are the points that hold the datum, which motions that are left over leave in place;
/// `extent` [m] is the size of the block, the yardstick between translations and rotations.
std::vector<std::string> describe_motions(const Eigen::MatrixXd& subspace, const Eigen::Vector3d& centre, double extent,
                                          const std::vector<NamedPoint>& fixed);

/// What a set of datum information leaves open.
struct DatumAnalysis {
  std::vector<std::string> undetermined;  ///< nothing at all fixes these motions
  std::vector<std::string> weak;          ///< fixed, but with a standard deviation far above that of the control
  double weakest_sigma = 0;  ///< rms displacement of the points [m], one sigma, of the weakest motion that is fixed
};

/// Splits the similarity motions by how well `information` (7 × 7 normal matrix of the motions [1/m², 1/(m·rad) …])
/// fixes them. A motion is measured by the rms displacement of `points` [m]; it is undetermined if its standard
/// deviation is 1000 times, weak if it is `weak_ratio` times that of the best determined one. `with_scale` false leaves
/// scale out.
DatumAnalysis analyse_datum(const Eigen::MatrixXd& information, const std::vector<NamedPoint>& points,
                            const std::vector<NamedPoint>& fixed, bool with_scale, double weak_ratio);

}  // namespace plumbline::least_squares

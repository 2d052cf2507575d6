// Congruency of two epochs of a network and the movement of its points (Pelzer 1971; Niemeier, Ausgleichungsrechnung,
// ch. 12). Free networks say nothing of where they are: their difference d is taken modulo the motions G they are free
// to make. With the covariance C of d
//   P = (C + k G G')^-1,  R = P - P G (G'PG)^-1 G'P,  T = d' R d  ~  chi-squared, rank 3n - dim G
// and a point whose movement is left open lowers T by u_i' R_ii^-1 u_i, u = R d; so the point that moved is found
// without adjusting again. Movements are then given in a datum carried by the points that have not moved
// (S-transformation, Baarda 1973).
#pragma once

#include <Eigen/Core>
#include <limits>
#include <string>
#include <vector>

namespace plumbline::survey {

struct Epoch {
  std::vector<std::string> ids;
  Eigen::VectorXd coordinates;  ///< 3n [m]; NaN: component does not exist
  Eigen::MatrixXd covariance;   ///< 3n x 3n [m^2]; 0 rows and columns: held without error
};

struct Movement {
  std::string id;
  /// In the first epoch, and second minus first [m]; NaN: the point has no such coordinate (levelling, plane networks).
  Eigen::Vector3d position = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  Eigen::Vector3d movement = position, sigma = position;
  Eigen::Matrix3d covariance;  ///< of the movement [m^2]
  double statistic = 0;        ///< chi-squared with `rank` degrees of freedom without movement
  double critical = 0;
  int rank = 3;                  ///< coordinates it has
  bool moved = false;            ///< the statistic exceeds its critical value
  bool stable = true;            ///< carries the datum
  double detectable_height = 0;  ///< [m], at the power given
};

/// A point taken out of the datum because the others fit each other without it.
struct Exclusion {
  std::string id;
  double statistic = 0, critical = 0;     ///< of the points left
  std::vector<std::string> alternatives;  ///< points whose exclusion would have made the rest congruent as well
};

/// What an epoch's own readings say of its variance of unit weight, a priori 1.
struct EpochVariance {
  double sigma0 = 1;           ///< a posteriori
  int degrees_of_freedom = 0;  ///< 0: nothing is said
  bool applied = false;        ///< the epoch's covariance was multiplied with it already
};

/// The first test of a comparison: are the readings of both epochs as good as they were said to be, and as good as each
/// other? Covariances of readings that are noisier than stated are too small, and every point would have moved.
struct VarianceTest {
  double ratio = 1, critical = 0;  ///< larger over smaller sigma0 squared, Fisher's F; critical 0: not tested
  bool differ = false;             ///< the ratio exceeds it
  double first_factor = 1, second_factor = 1;  ///< by which the covariances were multiplied
  int degrees_of_freedom = 0;                  ///< of these factors; 0: a priori variances hold
  std::string text;                            ///< in words
};

VarianceTest test_variances(const EpochVariance& first, const EpochVariance& second, double alpha);

struct Comparison {
  VarianceTest variances;
  std::vector<Movement> movements;     ///< common points, in the order of the first epoch
  double statistic = 0, critical = 0;  ///< of all common points
  int rank = 0;
  bool congruent = true;
  /// Where the points that were left out fit each other as one body that moved against the rest: those of the rest. A
  /// free network does not tell which of the two stayed. Empty: they do not, or the frame is held.
  std::vector<std::string> other_body;
  /// Both bodies have a third of all points at least. Of three prisms against twenty the twenty are taken for what
  /// stayed, as most of what is built does; that the three may be the references is told all the same.
  bool bodies_are_rivals() const;
  std::vector<Exclusion> excluded;                               ///< in the order they were found to have moved
  std::vector<std::string> only_first, only_second, incomplete;  ///< points that could not be compared
};

struct ComparisonOptions {
  double alpha = 0.05;    ///< global test
  double alpha0 = 0.001;  ///< each point
  double power = 0.80;
  bool localise = true;  ///< false: the test as a whole alone, no point is left out of the datum
  /// Motions the two epochs may differ by: 0 none (both in one fixed frame), 3 translation, 4 with rotation about the
  /// vertical (levelled networks with distances), 5 with scale, 6 any rigid motion, 7 with scale.
  /// Of these, what moves no coordinate that is there does not count: of bench marks, 3 is a common lift.
  int free_motions = 4;
  EpochVariance first_variance, second_variance;
  int variance_degrees = 0;  ///< of covariances that were multiplied with an estimated variance; 0: a priori
};

/// Throws std::runtime_error with too few common points, or if a covariance is missing or has the wrong size.
Comparison compare_epochs(const Epoch& first, const Epoch& second, const ComparisonOptions& options);

/// The points that `keep` says yes to.
Epoch part_of(const Epoch& epoch, const std::vector<char>& keep);

}  // namespace plumbline::survey

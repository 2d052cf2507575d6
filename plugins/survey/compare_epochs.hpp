// Congruency of two epochs of a network and the movement of its points (Pelzer 1971; Niemeier, Ausgleichungsrechnung,
// ch. 12). Free networks say nothing of where they are: their difference is taken modulo translation and rotation about
// the vertical, in a datum carried by the points that have not moved.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace plumbline::survey {

struct Epoch {
  std::vector<std::string> ids;
  Eigen::VectorXd coordinates;  ///< 3n [m]
  Eigen::MatrixXd covariance;   ///< 3n x 3n [m^2]
};

struct Movement {
  std::string id;
  Eigen::Vector3d movement, sigma;  ///< [m]
  double statistic = 0;             ///< chi-squared with 3 degrees of freedom without movement
  bool moved = false, stable = true;
  double detectable_height = 0;  ///< [m], at the power given
};

struct Comparison {
  std::vector<Movement> movements;     ///< common points, in the order of the first epoch
  double statistic = 0, critical = 0;  ///< of all common points
  int rank = 0;
  bool congruent = true;
  std::vector<std::string> excluded;  ///< in the order they were found to have moved
};

struct ComparisonOptions {
  double alpha = 0.05;    ///< global test
  double alpha0 = 0.001;  ///< each point
  double power = 0.80;
  bool free_datum = true;  ///< false: both epochs are in one fixed frame
};

/// Throws std::runtime_error with fewer than three common points, or if a covariance is missing or has the wrong size.
Comparison compare_epochs(const Epoch& first, const Epoch& second, const ComparisonOptions& options);

}  // namespace plumbline::survey

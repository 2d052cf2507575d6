// Part of epoch_series.cpp: what one point did, from where the epochs have it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "survey/epochs/epoch_series.hpp"

namespace plumbline::survey {

/// A point in one epoch, laid on the stable points.
struct SeenPoint {
  size_t epoch;
  double time;
  Eigen::Vector3d at;          ///< [m]
  Eigen::Matrix3d covariance;  ///< [m^2], of the coordinates that are compared
  Eigen::Vector3d before;      ///< variances before it was laid on the stable points
  std::array<bool, 3> compared;

  std::vector<Eigen::Index> axes() const {
    std::vector<Eigen::Index> result;
    for (Eigen::Index c = 0; c < 3; ++c)
      if (compared[c]) result.push_back(c);
    return result;
  }
};

/// `at`, `first`, `reference` of `point`; `seen` by epoch, each with an axis that is compared. `degrees` of freedom of
/// the variance, 0: known.
void add_movements(const std::vector<SeenPoint>& seen, const SeriesOptions& options, int degrees, SeriesPoint& point);

/// Velocity, its test and the misfit of the line.
void add_velocity(const std::vector<SeenPoint>& seen, const SeriesOptions& options, int degrees, SeriesPoint& point);

}  // namespace plumbline::survey

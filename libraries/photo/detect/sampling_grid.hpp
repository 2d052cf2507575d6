// Pixels that lie off an even grid. Cameras that make a smaller picture than their sensor's by a fraction such as 5 : 3
// often take the nearest of its pixels. Columns and rows then lie up to half a pixel off their place, the same every
// few columns: an edge along the grid is displaced, and one that crosses it slowly is turned.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "photo/detect/edge_model.hpp"
#include "photo/detect/edge_samples.hpp"

namespace plumbline::detect {

/// Adds up what the residuals of an image's fitted edges say of its grid. Each edge's own parameters are eliminated, so
/// that no edge needs a known place.
class SamplingGridEstimate {
 public:
  /// Of edges that were fitted with `used`.
  explicit SamplingGridEstimate(const SamplingGrid& used) : used_(used) {}

  /// One fitted edge. `normal`: J^T J over the noise's variance, with priors. `origin`: the image's column and row of
  /// the samples' (0, 0).
  void add(const EdgeSamples& samples, const EdgeColumns& columns, const EdgeFrame& frame, const EdgeNormal& normal,
           double noise, const Eigen::Vector2i& origin);

  /// Grids of a camera that takes nearest pixels of which the edges say that they would fit better than `used`: of
  /// every period the best, of the same period if `used` is uneven. None where an even grid explains the residuals.
  std::vector<SamplingGrid> better() const;

  /// Mean logarithm of the residuals' variance: lower is better.
  double cost() const { return samples_ > 0 ? log_variance_ / samples_ : 0; }

 private:
  static constexpr int kClasses = 6;  // of columns: a multiple of all periods
  using Sums = Eigen::Matrix<double, kClasses, 1>;

  /// Normal equations of the offsets of the columns, then of the rows.
  struct Equations {
    Eigen::MatrixXd normal;
    Eigen::VectorXd right;
  };
  Equations equations(int period) const;

  SamplingGrid used_;
  Sums column_squares_ = Sums::Zero(), row_squares_ = Sums::Zero();  // of the derivatives
  Eigen::Matrix<double, kClasses, kClasses> products_ = Eigen::Matrix<double, kClasses, kClasses>::Zero();
  Sums column_right_ = Sums::Zero(), row_right_ = Sums::Zero();
  /// What the edges' own parameters take of the normal matrix, by period.
  std::array<Eigen::MatrixXd, SamplingGrid::kLargestPeriod + 1> taken_;
  int edges_ = 0;
  double samples_ = 0, log_variance_ = 0;
};

}  // namespace plumbline::detect

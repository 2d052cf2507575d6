// Centres of crosshairs and quadrant targets (quarters of a disc or square in black and white) near a predicted place.
//
// Both are two straight lines through a point and look the same after half a turn about it; so they do after a tilt of
// their plane, a symmetric blur and any curve that turns light into grey values. The model is drawn with that symmetry:
// what it leaves out of blur or curve is even about the centre, the derivative by the centre is odd, so no error of the
// model moves the centre. Only the odd part of the residuals is noise to it, and the covariance is that part's.
#pragma once

#include <Eigen/Core>
#include <string>

namespace plumbline {
struct GreyImage;
}

namespace plumbline::detect {

enum class TargetKind { any, quadrants, crosshair };

struct TargetFitOptions {
  TargetKind kind = TargetKind::any;
  double search = 10;      ///< how far the centre may be from the prediction [px]
  double max_radius = 24;  ///< of the part that is fitted; it grows from 5 px as long as it looks like the target [px]
  double min_contrast = 20;    ///< between the two plateaus [grey values]
  double sigma_floor = 0.002;  ///< added in quadrature [px]
};

struct MeasuredTarget {
  TargetKind kind = TargetKind::any;
  Eigen::Vector2d centre{0, 0};                          ///< centre of the top-left pixel at (0, 0) [px]
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< [px²]
  double radius = 0;                                     ///< of the part that was fitted [px]
  double blur = 0;                                       ///< standard deviation of the Gaussian [px]
  double misfit = 0;                                     ///< root mean square residual, as a share of the contrast
  std::string problem;                                   ///< why there is none, in words; empty if it was measured
};

MeasuredTarget measure_target(const GreyImage& image, const Eigen::Vector2d& predicted,
                              const TargetFitOptions& options);

}  // namespace plumbline::detect

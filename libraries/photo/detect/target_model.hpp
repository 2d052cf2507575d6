// What a target looks like, and the parameters at which it looks most like the photograph.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "photo/detect/target_fit.hpp"

namespace plumbline::detect {

/// Parameters of a target: centre [px], directions of its two lines [rad], logarithm of the blur [px], grey values of
/// its two levels, shading as a share of the light at the rim, gamma as in EdgeFitOptions, logarithms of half the bars'
/// widths.
namespace target {
enum : Eigen::Index { kX, kY, kFirst, kSecond, kBlur, kLow, kHigh, kShadeX, kShadeY, kGamma, kWidth1, kWidth2, kAll };
}  // namespace target
using TargetParameters = Eigen::Matrix<double, target::kAll, 1>;
using TargetNormal = Eigen::Matrix<double, target::kAll, target::kAll>;

/// A disc of pixels and their grey values.
struct TargetPixels {
  std::vector<Eigen::Vector2i> at;
  Eigen::VectorXd grey;
};

/// Those within `radius` [px] of `centre` that the image has.
TargetPixels disc(const GreyImage& image, const Eigen::Vector2d& centre, double radius);

struct TargetFit {
  TargetKind kind = TargetKind::any;
  TargetParameters p = TargetParameters::Zero();
  double radius = 0;
  TargetPixels pixels;
  Eigen::VectorXd residuals;
  Eigen::MatrixXd jacobian;
  TargetNormal normal = TargetNormal::Identity();  // with the priors, of unit weight one grey value
  bool converged = false;

  double contrast() const { return std::abs(p[target::kHigh] - p[target::kLow]); }
  double rms() const {
    return std::sqrt(residuals.squaredNorm() / std::max(1.0, static_cast<double>(residuals.size())));
  }
};

/// Grey values of the model at `pixels`; `radius` [px] is where shading is stated.
Eigen::VectorXd model_at(TargetKind kind, const TargetParameters& p, double radius, const TargetPixels& pixels);

/// Levenberg and Marquardt's method over the disc about the centre that it starts from; not converged where the disc
/// has too few pixels.
TargetFit minimise(const GreyImage& image, TargetKind kind, TargetParameters p, double radius);

}  // namespace plumbline::detect

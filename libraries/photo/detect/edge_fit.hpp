// Fits the position of one straight (or slightly bowed) step edge to the grey values themselves.
//
// The model is a step between two plateaus, blurred by a Gaussian and integrated over the pixel:
//   grey(t, d) = low(t) + (high(t) - low(t)) · E((d - a - b t - c t²) / s),
// t in [-1, 1] along the edge, d [px] across it, E the Gaussian edge averaged over the pixel's box, plateaus linear in
// t. All pixels of a strip take part, none is interpolated, so the residuals are the camera's noise and the covariance
// is that of a maximum-likelihood fit. The blur is symmetric, so the position has no bias to first order whatever the
// blur is.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "photo/detect/edge_model.hpp"
#include "photo/detect/edge_samples.hpp"
#include "photo/detect/sampling_grid.hpp"

namespace plumbline::detect {

/// Where the edge is expected and how far the plateaus reach.
struct EdgeStrip {
  Eigen::Vector2d start, end;  ///< of the edge [px]
  double margin = 0;           ///< pixels left out at either end, where the neighbouring edges' blur reaches [px]
  double plain = 0;  ///< distance to the next edge on either side: up to there nothing but the two plateaus [px]
};

struct EdgeFitOptions {
  /// Standard deviation of the image edge's curvature, a prior of mean zero [1/px]; 0 forces a straight line. A lens
  /// with radial distortion k1 bows edges by 2 k1 r / f²: 3e-5 for k1 = -0.1, r = 3000 px, f = 4500 px. Small tags are
  /// held straight by it, large ones that show their bow are free.
  double curvature_sigma = 2e-5;
  /// Exponent of the camera's transfer curve from light to grey values: 1 for linear files, 2.4 for sRGB. Blur mixes
  /// light, so a curve that is left out moves edges towards the dark side by a share of the blur.
  double gamma = 1;
  /// Where the image's pixels lie; nothing: measure_corners() finds it from the edges.
  std::optional<SamplingGrid> grid = SamplingGrid{};
  /// Grey values a plateau must differ by, at least [grey values].
  double min_contrast = 12;
};

/// A fitted edge: points centre + h t along + (a + b t + c t²) across.
struct FittedEdge {
  Eigen::Vector2d centre, along, across;  ///< [px], unit vectors
  double half_length = 0;                 ///< h [px]
  Eigen::Vector3d shape;                  ///< a, b, c [px]
  Eigen::Matrix3d covariance;             ///< of a, b, c [px²]
  double blur = 0;                        ///< s, standard deviation of the Gaussian [px]
  double contrast = 0;                    ///< difference of the plateaus at the middle [grey values]
  double noise = 0;                       ///< standard deviation of the residuals [grey values]
  int samples = 0;                        ///< pixels that took part
  /// What the profile across the edge differs from the model by, mean square in units of the contrast, with the share
  /// that noise alone would leave taken off: below zero by chance where the model holds.
  double misfit = 0;
  double dark = 1;  ///< +1: the dark side is where `across` points, -1: it is the other one
};

/// Fits edges one after the other; holds the memory that they need. One for each thread.
class EdgeFitter {
 public:
  explicit EdgeFitter(const EdgeFitOptions& options) : options_(options), curve_(options.gamma) {}

  /// Of the images that follow: the grid's column and row of their first pixel.
  void set_origin(const Eigen::Vector2i& origin) { origin_ = origin; }

  /// Nothing if the strip leaves the image, is too short, has too little contrast or the fit does not converge near it.
  std::optional<FittedEdge> fit(const GreyImage& image, const EdgeStrip& strip);

  /// The same edge with each of several curves in place of options.gamma, over the same pixels: those of the fit with
  /// the first. Empty if one of the fits fails.
  std::vector<FittedEdge> fit_with_curves(const GreyImage& image, const EdgeStrip& strip,
                                          const std::vector<TransferCurve>& curves);

  /// What the edge that was fitted last says of the grid.
  void add_to(SamplingGridEstimate& estimate) const;

 private:
  struct Solution {
    EdgeParameters p;
    double noise = 1;  // [grey values]
    bool converged = false;
  };
  struct Prior;

  bool fit_strip(const GreyImage& image, const EdgeStrip& strip, const TransferCurve& curve);
  std::optional<FittedEdge> fitted_edge(const TransferCurve& curve) const;
  Solution solve(EdgeParameters p);
  Prior prior() const;
  double drop_disturbed_bins(double margin);
  double misfit(double contrast) const;

  EdgeFitOptions options_;
  TransferCurve curve_;
  Eigen::Vector2i origin_ = Eigen::Vector2i::Zero();
  EdgeFrame frame_;
  EdgeSamples samples_;
  EdgeColumns columns_;  // of the solution, but for a last step that changes nothing
  Solution solution_;
};

}  // namespace plumbline::detect

// Corners of a tag as intersections of its four fitted edges.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "photo/detect/edge_fit.hpp"

namespace plumbline::detect {

struct RefinedCorners {
  std::array<Eigen::Vector2d, 4> corners;  ///< [px], in the order of the initial ones
  std::array<Eigen::Matrix2d, 4>
      covariances;  ///< [px²]; neighbours share an edge and are correlated, which is left out
};

/// A quadrilateral found in the image: four edges, each `modules` cells long with one cell of plain colour on either
/// side.
struct Quadrilateral {
  std::array<Eigen::Vector2d, 4> corners;  ///< right to about 2 px [px]
  int modules = 0;
  const GreyImage* part =
      nullptr;  ///< the part of the image that it lies in and that `corners` count from; null: the image
  Eigen::Vector2i origin = Eigen::Vector2i::Zero();  ///< of the part in the image
  int border = 1;                                    ///< cells of plain colour on either side of an edge
};

/// Strip of the edge from corner i to the next.
EdgeStrip strip_of(const Quadrilateral& q, int i);

/// How an image came to be, as the edges in it tell.
struct ImageQuality {
  double gamma = 1;   ///< exponent of the transfer curve, see EdgeFitOptions::gamma
  SamplingGrid grid;  ///< where the pixels lie
  double model_error =
      0;  ///< what the edges' profiles differ from the model by, root mean square in units of the contrast
  /// Standard deviation of how far all edges of the image are drawn towards their dark side together, inwards on tags
  /// that are black on white; the stated covariances leave it out [px]. 0: the curve was given. Where tags of both
  /// polarities are in the image it moves some inwards and some outwards, so that no common inset can hold it, and the
  /// covariances have it, too.
  double inset_sigma = 0;
};

struct Measurement {
  std::vector<std::optional<RefinedCorners>> corners;  ///< nothing where one of the edges cannot be fitted
  ImageQuality quality;
};

/// Measures all quadrilaterals of one image. The transfer curve is common to the image and is estimated from its edges
/// where options.gamma is 0. The stated covariance is that of the fit plus what an error of the model does to an edge:
/// a profile that differs from the model by `model_error` displaces the edge by a multiple of model_error times its
/// width; the multiple is measured on real boards (docs/photographs.md).
Measurement measure_corners(const GreyImage& image, const std::vector<Quadrilateral>& found,
                            const EdgeFitOptions& options);

/// The same where each quadrilateral has a part of the image of its own.
Measurement measure_corners(const std::vector<Quadrilateral>& found, const EdgeFitOptions& options);

/// Of one quadrilateral alone; the others of an image tell its transfer curve better.
std::optional<RefinedCorners> refine_corners(const GreyImage& image, const std::array<Eigen::Vector2d, 4>& initial,
                                             int modules, const EdgeFitOptions& options);

}  // namespace plumbline::detect

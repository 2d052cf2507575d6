// What a planned campaign of photographs will reach, and what improves it cheapest: the Cramér-Rao bound of the plan,
// and of the plan with one photograph or one surveyed marker more.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "photo/block/tag_bound.hpp"

namespace plumbline::block {

/// Why an image says little: fewer than three plates, or plates that cover little of it.
struct WeakImage {
  std::size_t image = 0;  ///< index into BoundProblem::cam_from_world
  int plates = 0;
  double coverage = 0;  ///< area of the convex hull of their tags over that of the image
};

struct Addition {
  enum class Kind {
    again,   ///< a further photograph from the place of an image
    rolled,  ///< the same with the camera rolled by 90°
    survey   ///< a marker that is surveyed as well
  };
  Kind kind = Kind::again;
  std::size_t of = 0;   ///< image or plate
  double rmse_z = 0;    ///< of the wanted plates with it [m]
  double per_cost = 0;  ///< relative loss of RMSE_z over the cost
};

struct ImagePlanOptions {
  int fewest_plates = 3;
  double least_coverage = 0.05;  ///< of the image
  double survey_sigma = 1e-3;    ///< of a marker that is surveyed as well [m], each coordinate
  double survey_cost = 3;        ///< in photographs
};

struct ImagePlan {
  double rmse_z = 0, rmse_3d = 0;  ///< expected, of the wanted plates [m]
  std::size_t worst = 0;
  double worst_sigma = 0;  ///< of its height [m]
  std::vector<WeakImage> weak;
  std::vector<Addition> additions;  ///< by loss of RMSE_z for their cost, largest first
};

/// `wanted`: plates whose heights count, each seen by an image. Additions are every image again, every image rolled by
/// 90° about its axis (with those of its plates that still fall into it), and every plate that is seen, and neither
/// control nor wanted: what is to prove the result is not made part of it.
ImagePlan plan_images(const BoundProblem& problem, const TagBound& bound, const std::vector<std::size_t>& wanted,
                      const ImagePlanOptions& options);

}  // namespace plumbline::block

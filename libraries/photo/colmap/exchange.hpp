// A block as COLMAP's `bundle_adjuster` takes it, and its answer.
//
// Its adjustment: images of Brown cameras, single points, every image coordinate with the same weight and no loss, no
// control, no priors. It holds the pose of the first image and one coordinate of the second's translation (COLMAP 3.8,
// src/exe/sfm.cc and src/controllers/bundle_adjustment.cc); which images these are is chosen here.
#pragma once

#include <filesystem>

#include "photo/bundle/problem.hpp"
#include "photo/cameras/colmap_files.hpp"
#include "photo/colmap/program.hpp"

namespace plumbline::colmap {

struct BundleOptions {
  bool refine_focal_length = true, refine_principal_point = false, refine_extra_params = true;
  int max_iterations = 100;
  double time_limit = 600;              ///< [s]
  std::string program = usual_program;  ///< name or path
};

struct BundleSummary {
  int iterations = 0;
  std::string message;  ///< what COLMAP says of its end
};

/// Images in the order in which COLMAP gets them. First come the two with the longest base along the second's own x
/// axis: what it holds of them fixes the scale best.
std::vector<int> image_order(const bundle::State& state);

/// Precondition: only image points, of Brown cameras; every point is seen by two images or more.
cameras::ColmapModel model_of(const bundle::Problem& problem, const bundle::State& state,
                              const std::vector<int>& order);

/// Lets COLMAP adjust the problem from `state`, which becomes its answer: up to a similarity, which nothing determines.
/// Camera values that it may not refine stay as they are. Throws std::runtime_error that tells what it lost or why it
/// did not converge, and what run_program() throws.
BundleSummary adjust_by_colmap(const bundle::Problem& problem, bundle::State& state, const BundleOptions& options);

}  // namespace plumbline::colmap

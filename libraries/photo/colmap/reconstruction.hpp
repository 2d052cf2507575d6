// Photographs without markers to a sparse model, by the program `colmap`: features, matches, incremental
// reconstruction. The model has no scale and a frame of its own; markers/control_adjustment.hpp takes it to metres.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "photo/cameras/colmap_files.hpp"
#include "photo/colmap/program.hpp"

namespace plumbline::colmap {

struct ReconstructionOptions {
  std::string camera_model = "SIMPLE_RADIAL";  ///< one that colmap_files.hpp reads
  bool one_camera = true;                      ///< all photographs are of one camera with one focus
  int max_image_size = 3200;                   ///< larger photographs are reduced for the features [px]
  int max_features = 8192;                     ///< an image
  int threads = 1;                             ///< with more the model is not the same twice
  double time_limit = 3600;                    ///< of each of the three programs [s]
  std::string program = usual_program;         ///< name or path
};

struct Reconstruction {
  cameras::ColmapModel model;             ///< the one with most photographs, if there are several
  std::vector<std::string> unregistered;  ///< photographs that are not in it
  std::vector<std::string> warnings;
};

/// Throws std::runtime_error: the program is not installed, fails or takes too long; fewer than two photographs in the
/// folder; no model found. Stopped if the work is to end.
Reconstruction reconstruct(const std::filesystem::path& photographs, const ReconstructionOptions& options);

}  // namespace plumbline::colmap

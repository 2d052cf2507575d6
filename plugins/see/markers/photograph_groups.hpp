// Photographs by the camera that took them, told from folder or name, size and EXIF.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "input.hpp"

namespace plumbline::markers {

std::string size_text(int width, int height);

/// What tells one camera from another.
struct CameraKey {
  std::string folder, model, serial;
  int width = 0, height = 0;
  double focal_length = 0;  ///< [m]; 0: EXIF does not say it
  auto operator<=>(const CameraKey&) const = default;
};

struct CameraGroup {
  CameraKey key;
  std::vector<size_t> images;                ///< indices into the observations
  double principal_distance = std::nan("");  ///< [px], from EXIF; nan if it does not say it
};

/// Groups of the images that are to be used, in the order of their first image; `by` as in camera_name().
std::vector<CameraGroup> groups_of(const std::vector<ImageT>& images, const TagObservationsT& observations,
                                   const std::vector<bool>& use, const std::string& by);

/// Drops groups too small to calibrate beside a large one of the same folder: turned, cropped or resized by a program.
void drop_odd_groups(std::vector<CameraGroup>& groups, const TagObservationsT& observations, BlockInput& input);

/// Says of every folder and body in how many sizes its photographs come, if in several: resized, cropped or turned by a
/// program, another setting of the camera or, where no EXIF tells, another camera. Each becomes a camera of its own.
std::vector<std::string> words_of_sizes(const std::vector<CameraGroup>& groups);

/// Leaves photographs out that another body took than the one that `known`, the only calibration, is of. Throws
/// std::runtime_error if nobody can tell which of several that is.
void drop_other_bodies(std::vector<CameraGroup> groups, const CameraT& known, const TagObservationsT& observations,
                       std::vector<bool>& use, BlockInput& input);

/// One camera a group, started from EXIF where that says anything; each with a name of its own.
std::vector<MarkerCamera> cameras_of_groups(const std::vector<CameraGroup>& groups);

}  // namespace plumbline::markers

// What real photographs, prints and plates have and ideal ones have not. Every perturbation has a name and a size; zero
// is nothing of it.
#pragma once

#include <string>

namespace plumbline::simulate {

struct Perturbations {
  // The camera.
  std::string transfer = "linear";  ///< light to grey values: "linear", "srgb" or "camera" (sRGB with a steeper middle)
  double sharpening = 0;            ///< share of the difference from the mean around a pixel that is added
  int jpeg_quality = 0;             ///< 0: the camera profile's
  double motion_blur = 0;           ///< longest movement during the exposure [px]; length and direction drawn by image
  double rolling_shutter = 0;       ///< movement between the first and the last row [px]; direction drawn by image
  double low_light = 0;             ///< stops that the exposure is short of, amplified again: noise grows
  double principal_point_sigma = 0;  ///< of each image's own principal point [px]
  double distance_distortion = 0;    ///< relative change of the radial distortion by image, standard deviation
  /// How k1 changes with the depth Z of what is seen: by this times 1/Z − 1/(distance of the stations) [m]. In observed
  /// corners only.
  double depth_distortion = 0;
  // Print and plate.
  double ink_spread = 0;          ///< black grows by this much at every edge [m]
  double dirt = 0;                ///< specks on a plate, on average
  double glare = 0;               ///< share of the plates of an image that mirror a lamp
  double plate_bend = 0;          ///< height of a tag's corners over the plane of the others, standard deviation [m]
  double plate_offset_sigma = 0;  ///< of the tag's place on its plate, right and up [m]
  double mounting_sigma = 0;      ///< of the plate's place on its anchor, each axis [m]
  // The scene.
  double clutter = 0;  ///< share of the wall that is brick, mesh or text instead of boards
};

/// "ideal": nothing of all that; "real": a consumer camera's curve and sharpening, a laser printer's ink, a site's
/// dirt. Throws std::invalid_argument for another name.
Perturbations optics_of(const std::string& name);

}  // namespace plumbline::simulate

#include "perturbations.hpp"

#include <stdexcept>

namespace plumbline::simulate {

Perturbations optics_of(const std::string& name) {
  Perturbations p;
  if (name == "ideal") return p;
  if (name != "real") throw std::invalid_argument("optics is '" + name + "'; possible are ideal and real");
  p.transfer = "srgb";
  p.sharpening = 0.3;
  p.jpeg_quality = 88;
  p.motion_blur = 0.7;
  p.rolling_shutter = 0.3;
  p.low_light = 1;
  p.principal_point_sigma = 0.3;
  p.distance_distortion = 0.005;
  p.ink_spread = 0.0001;
  p.dirt = 2;
  p.glare = 0.03;
  p.plate_bend = 0.0002;
  p.plate_offset_sigma = 0.0001;
  p.mounting_sigma = 0.0005;
  p.clutter = 0.3;
  return p;
}

}  // namespace plumbline::simulate

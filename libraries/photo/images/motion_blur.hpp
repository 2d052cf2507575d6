// Whether the camera or what it looked at moved while the shutter was open.
#pragma once

#include <string>

#include "photo/images/grey_image.hpp"

namespace plumbline {

/// Blur of the sharpest edges across which most is smeared, and of those across which least is. Motion smears edges
/// across its direction and leaves those along it; a lens out of focus blurs all alike.
struct MotionBlur {
  double most = 0, least = 0;  ///< 1-sigma widths [px]; 0 where fewer than two directions have enough edges
  double direction = 0;        ///< across the edges of `most` [rad], from x to y, 0 to π

  /// Whether it is one: photographs of boards and tags at rest have edges of one width within 1.3.
  bool found() const { return least > 0 && most > 1.7 * least && most > 1.5; }
};

/// By edges of a quarter of the image's contrast and more, told between squares of 8 px; the width is contrast over
/// steepest slope, as of a Gaussian edge, and of each direction (four) the width counts that a tenth of the edges are
/// below. Smear of more than about 20 px is told as less.
MotionBlur motion_blur(const GreyImage& image);

/// "it is blurred from left to right, 2.9 times as much as in the sharpest direction: the camera or what it looks at
/// moved while it was taken"; empty where it is none.
std::string in_words(const MotionBlur& blur);

}  // namespace plumbline

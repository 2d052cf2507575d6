// Why nothing was found in a photograph: too dark, too bright, without contrast, or without a sharp edge.
#pragma once

#include <string>

#include "photo/images/grey_image.hpp"

namespace plumbline {

/// Grey values and sharpness of an image.
struct Visibility {
  int darkest = 0, brightest = 0;  ///< grey values that 0.5 % of the pixels are below or above
  int contrast = 0;       ///< between the 2nd and the 98th of a hundred grey values, in the best square of 64 px
  double edge_sigma = 0;  ///< [px] 1-sigma width of the blur of the steepest edge; infinite without an edge
};

/// Contrast is looked at in squares, because light that changes over the facade is none. The largest slope of a step of
/// height h blurred by a Gaussian is h / (sigma sqrt(2 pi)); slopes are taken over two pixels, of which the largest but
/// 1 in 10 000 counts, and h is `brightest` - `darkest`. One edge of that height suffices for `edge_sigma` to be small:
/// it is a lower bound of the blur.
Visibility visibility(const GreyImage& image);

/// What keeps tags from being found, in words with the figures; empty where none of these is the cause.
std::string why_nothing_is_found(const GreyImage& image);

}  // namespace plumbline

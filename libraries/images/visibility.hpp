// Why nothing was found in a photograph: too dark, too bright, without contrast, or without a sharp edge.
#pragma once

#include <string>

#include "images/grey_image.hpp"

namespace plumbline {

/// Grey values and sharpness of an image, as its histograms tell.
struct Visibility {
  int darkest = 0, brightest = 0;  ///< grey values that 0.5 % of the pixels are below or above
  double edge_sigma = 0;           ///< [px] 1-sigma width of the blur of its steepest edges; infinite without an edge
};

/// One edge of the whole contrast suffices for `edge_sigma` to be small, so that it is a lower bound of the blur: the
/// largest slope of a step of height h blurred by a Gaussian is h / (sigma sqrt(2 pi)); of the slopes over two pixels,
/// in rows and columns, the one that 1 in 10 000 exceeds is taken.
Visibility visibility(const GreyImage& image);

/// What keeps tags from being found, in words with the figures; empty where none of these is the cause.
std::string why_nothing_is_found(const GreyImage& image);

}  // namespace plumbline

// Patches of photographs, taken along an affine map.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "photo/images/grey_image.hpp"

namespace plumbline::surface {

/// (2 · half + 1)² grey values, row by row in v from below, in u from the left.
struct Patch {
  Eigen::ArrayXf values;
  double mean = 0, contrast = 0;  ///< mean and standard deviation before they were taken out
};

/// Samples at pixel + by_u · i · spacing + by_v · j · spacing, i and j from −half to half; cubic convolution (Keys
/// 1981, a = −0.5) if `cubic`, else bilinear. False if a sample needs pixels outside of the image.
bool sample_patch(const GreyImage& image, const Eigen::Vector2d& pixel, const Eigen::Vector2d& by_i,
                  const Eigen::Vector2d& by_j, int half, bool cubic, Patch& patch);

/// Takes mean and contrast out. A patch without contrast becomes zero.
void normalise(Patch& patch);

}  // namespace plumbline::surface

// Both kinds of depth and OpenCV's StereoSGBM by itself on a rectified pair with published disparities.
#pragma once

#include <string>

namespace plumbline::surface {

/// Prints, for all places with a known disparity that both photographs show, how many each kind measures and how far
/// off it is. `truth`: an image or PFM whose values over `scale` are the left photograph's disparities [px]; 0 or
/// infinite: unknown. Throws std::runtime_error for files that are none, or do not fit.
void compare_on_published_pair(const std::string& left, const std::string& right, const std::string& truth,
                               double scale);

}  // namespace plumbline::surface

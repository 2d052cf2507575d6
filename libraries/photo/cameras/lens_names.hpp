// What other programs call the models of a lens.
#pragma once

#include <string>

namespace plumbline::cameras {

/// `other`: a model that is neither Brown's nor the fisheye's of Kannala and Brandt. `not_quite_brown`: one with
/// Brown's coefficients in another formula (inverse, modified), which is Brown's where all of them are zero.
enum class LensName { unknown, brown, fisheye, not_quite_brown, other };

/// Of a whole name in small letters and digits alone ("plumbbob" for plumb_bob): OpenCV, ROS, Kalibr, COLMAP, ORB-SLAM,
/// RealSense.
LensName lens_named(const std::string& name);

}  // namespace plumbline::cameras

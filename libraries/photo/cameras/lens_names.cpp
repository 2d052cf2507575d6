#include "photo/cameras/lens_names.hpp"

#include <algorithm>
#include <vector>

namespace plumbline::cameras {
namespace {

const std::vector<std::string> kBrown = {"brown",
                                         "brownconrady",
                                         "rs2distortionbrownconrady",
                                         "distortionbrownconrady",
                                         "plumbbob",
                                         "radtan",
                                         "radial",
                                         "radialtangential",
                                         "simpleradial",
                                         "pinhole",
                                         "simplepinhole",
                                         "pinholeradtan",
                                         "perspective",
                                         "opencv",
                                         "fullopencv",
                                         "rational",
                                         "rationalpolynomial",
                                         "polynomial",
                                         "standard",
                                         "none"};
const std::vector<std::string> kFisheye = {"fisheye",
                                           "opencvfisheye",
                                           "equi",
                                           "equidistant",
                                           "equidistantfisheye",
                                           "pinholeequi",
                                           "pinholeequidistant",
                                           "pinholefisheye",
                                           "kannalabrandt",
                                           "kannalabrandt4",
                                           "kannalabrandt8",
                                           "kb",
                                           "kb4",
                                           "kb8"};
// RealSense's: the polynomial may run from the distorted to the ideal point, and of some versions of its library it
// runs there in one function and back in another. In the modified one decentring counts at the distorted point.
const std::vector<std::string> kNotQuiteBrown = {"inversebrownconrady",
                                                 "modifiedbrownconrady",
                                                 "rs2distortioninversebrownconrady",
                                                 "rs2distortionmodifiedbrownconrady",
                                                 "distortioninversebrownconrady",
                                                 "distortionmodifiedbrownconrady"};
const std::vector<std::string> kOther = {"omni",
                                         "omniradtan",
                                         "omninone",
                                         "omnidirectional",
                                         "mei",
                                         "ucm",
                                         "unified",
                                         "eucm",
                                         "eucmnone",
                                         "ds",
                                         "dsnone",
                                         "doublesphere",
                                         "fov",
                                         "pinholefov",
                                         "atan",
                                         "arctan",
                                         "thinprism",
                                         "thinprismfisheye",
                                         "scaramuzza",
                                         "ocam",
                                         "division",
                                         "spherical",
                                         "equirectangular",
                                         "stereographic",
                                         "equisolid",
                                         "orthographic",
                                         "splined"};

}  // namespace

LensName lens_named(const std::string& name) {
  const auto is_of = [&](const std::vector<std::string>& names) {
    return std::find(names.begin(), names.end(), name) != names.end();
  };
  if (is_of(kBrown)) return LensName::brown;
  if (is_of(kFisheye)) return LensName::fisheye;
  if (is_of(kNotQuiteBrown) || name.find("inverse") != std::string::npos) return LensName::not_quite_brown;
  if (is_of(kOther)) return LensName::other;
  return LensName::unknown;
}

}  // namespace plumbline::cameras

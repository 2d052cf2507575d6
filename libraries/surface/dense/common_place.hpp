// Whether what was measured lies beside its place as a whole: panels and joints that are all off alike.
#pragma once

#include <string>
#include <vector>

#include "surface/dense/joint.hpp"

namespace plumbline::surface {

/// What the panels of one facade, or the joints in it, are off by in one direction on average [m].
struct CommonOffset {
  double mean = 0;
  double sigma = 0;    ///< of the mean, with what all have in common
  double scatter = 0;  ///< of the single ones about it, root mean square
  int count = 0;
  /// Too far for what is stated (4 standard deviations), far enough to matter (2 mm), and the same for all: more than
  /// three times what they differ by; of three or more.
  bool stands_out() const;
};

/// By how much more joints are off, the further along the facade they are: a scan that is larger than the design (its
/// scale, a temperature), or panels that were hung with another pitch.
struct CommonScale {
  double slope = 0;  ///< metres a metre
  double sigma = 0;  ///< by how far the joints lie off the line
  double span = 0;   ///< over which they lie [m]
  int count = 0;
  /// Of four or more, 2 mm and more from end to end, and surer than one chance in a thousand (Student's t of the line).
  bool stands_out() const;
};

/// Of the panels' planes out of the facade, and of the joints' middles to the right (upright joints) and upwards
/// (others).
struct CommonPlace {
  std::string first;                                 ///< id of the first panel of the facade
  Eigen::Vector3d facade = Eigen::Vector3d::Zero();  ///< unit vector out of it
  CommonOffset out, right, up;
  CommonScale width, height;  ///< of the upright joints to the right, of the others upwards
};

/// One of each direction that faces look to (within 10°), in the order of the faces. `surfaces` of `faces` and `found`
/// of `joints`, in their order; what was not measured does not count. Errors of planes and shifts are those that they
/// state; joints' are taken to be all common, as a scan's place is.
std::vector<CommonPlace> common_places(const std::vector<PanelFace>& faces, const std::vector<PanelSurface>& surfaces,
                                       const std::vector<Joint>& joints, const std::vector<MeasuredJoint>& found);

/// "… all 6 panels lie 9.0 ± 0.5 mm before their place; …", of the facades where something stands out; empty without.
std::string words_of_common_places(const std::vector<CommonPlace>& places);

/// "… 14 upright joints lie 2.00 ± 0.10 mm further to the right with each metre; …", likewise.
std::string words_of_common_scales(const std::vector<CommonPlace>& places);

}  // namespace plumbline::surface

// Which panels of a design have a joint between them that can be measured, and which have none and look as if they had:
// of these nobody may say that all joints were judged.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "surface/dense/joint.hpp"

namespace plumbline::surface {

/// Joints between faces whose edges lie in one plane within `offset` and that are turned by up to 10°, face each other
/// along at least 50 mm, are no further apart than `widest` [m], and have no other face between them. In the order of
/// the faces.
std::vector<Joint> joints_of(const std::vector<PanelFace>& faces, double widest = 0.06, double offset = 0.05);

/// Faces that come as near to each other, along at least 50 mm of an edge of each, with nothing between, and have no
/// joint by joints_of(): they meet at a corner, overlap, or one stands further out than `offset`. Numbers of the faces,
/// the smaller first.
std::vector<std::pair<size_t, size_t>> corners_between(const std::vector<PanelFace>& faces, double widest = 0.06,
                                                       double offset = 0.05);

/// Why a joint is not measured: its panels' outlines overlap, one stands further out, they do not face each other edge
/// to edge, the facade is folded there, or its designed width is above what is measured.
enum class WhyNoJoint { overlap, stands_out, not_facing, folded, wide };

/// Two neighbours between which a joint is, or may be, that is not measured.
struct PairWithoutJoint {
  size_t a = 0, b = 0;  ///< numbers of the faces
  WhyNoJoint kind = WhyNoJoint::not_facing;
  std::string why;                                          ///< in words
  double width = std::numeric_limits<double>::quiet_NaN();  ///< in the design, of a joint that is too wide [m]
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();         ///< between the edges that face each other
  Eigen::Vector3d along = Eigen::Vector3d::UnitZ();         ///< unit vector along them
  bool upright = true;                                      ///< runs upwards on the facade; else across
};

/// Of corners_between() those that a facade has within it, turned by less than 45°: where it bends, where panels
/// overlap (tongue and groove, shiplap), where one stands further out. And parallel faces that are further apart than
/// `widest`, up to `furthest` [m], with nothing between them: expansion joints.
std::vector<PairWithoutJoint> pairs_without_joint(const std::vector<PanelFace>& faces, double widest = 0.06,
                                                  double furthest = 0.15);

/// What people should know of pairs without a joint, a sentence each: corners of the building, pairs_without_joint(),
/// one of each kind with how many, and gaps that are wider than joints, from 0.15 m to 0.5 m (pilasters, slab edges,
/// windows).
std::vector<std::string> words_of_pairs(const std::vector<PanelFace>& faces, double widest);

}  // namespace plumbline::surface

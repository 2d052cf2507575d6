// Where images and survey contradict each other, in words.
#pragma once

#include <string>
#include <vector>

#include "photo/block/tag_block.hpp"

namespace plumbline::block {

/// What the residuals of the control look like: an error that all tag offsets have in common, or the control points
/// that stand out. Begins with "; ", empty without control. `result` needs anchors, world_from_plate and control.
///
/// An offset that is wrong by e on every plate moves the adjusted anchors by R_k e, R_k the plate's rotation. Of that
/// the datum takes the mean, and only the plates' different tilts leave a trace: r_k = R_k e + t + ω × (p_k − c), least
/// squares.
std::string control_in_words(const TagBlock& block, const TagBlockResult& result);

/// Points (by index) fewer than half of whose distances to the others are, within a tenth, those of the block at the
/// scale that most distances share. Empty for fewer than four points, and unless that scale is shared by half of the
/// distances: then nobody knows which points are the wrong ones.
std::vector<std::size_t> strangers_in_figure(const std::vector<Eigen::Vector3d>& in_block,
                                             const std::vector<Eigen::Vector3d>& in_control);

/// Throws std::runtime_error if most distances between control points are not those between the points of these names
/// in the block, at whatever scale: then the names are those of something else. One wrong point among four or more is
/// left to the adjustment, which finds it.
void require_same_figure(const std::vector<std::string>& names, const std::vector<Eigen::Vector3d>& in_block,
                         const std::vector<Eigen::Vector3d>& in_control);

/// Throws std::runtime_error if the control fits the block far better as its mirror image: two coordinates are
/// exchanged, or one has the wrong sign. Level ground seen from above alone does not tell: images then fit as well from
/// below it. Precondition: at least three points that are not on one line.
void require_same_hand(const std::vector<Eigen::Vector3d>& in_block, const std::vector<Eigen::Vector3d>& in_control);

}  // namespace plumbline::block

// Why tags do not agree with the poses of their images: mistakes that people make with plate tables, calibrations and
// detectors, tried one by one. Only asked once something is wrong; nothing here changes a pose.
#pragma once

#include <string>
#include <vector>

#include "pose/tag_field.hpp"

namespace plumbline::pose {

/// A sentence about the one mistake that makes at least nine tenths of the tags agree in the images that show most of
/// them, and leaves at most 0.4 of those that disagree without it; empty if none does. Tried: another family, ids moved
/// by one, two floors exchanged, tag sizes in another unit, plates that look elsewhere or whose azimuth is in radians,
/// corners that begin elsewhere or run the other way round, principal distance in millimetres, principal point
/// exchanged, photographs scaled by a half or two.
std::string what_would_explain(const std::vector<ImageTagsT>& images, const CameraT& camera, const Field& field,
                               const TagPoseSolver& solver, const PoseSettings& settings);

/// Tags that hang where the field has another plate, found from the rays of at least two oriented images: "F01-C01-R1
/// and F01-C02-R1 hang in each other's place". One sentence a pair, or a tag.
std::vector<std::string> exchanged_plates(const std::vector<ImageTagsT>& images, const PosesT& poses,
                                          const BrownCamera& camera, const Field& field);

/// Tags that were seen and are in no row of the plate table, in one sentence; empty if there are none.
std::string unknown_tags(const std::vector<ImageTagsT>& images, const PlatesT& plates);

/// Images whose tags lie in the very same places, or within a third of a pixel: one photograph under two names, saved
/// again perhaps, which would count double.
std::vector<std::string> same_photographs(const std::vector<ImageTagsT>& images);

}  // namespace plumbline::pose

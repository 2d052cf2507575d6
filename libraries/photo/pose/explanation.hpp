// Why tags do not agree with the poses of their images: mistakes that people make with plate tables, calibrations and
// detectors, tried one by one. Only asked once something is wrong; nothing here changes a pose.
#pragma once

#include <string>
#include <vector>

#include "photo/pose/image_cameras.hpp"
#include "photo/pose/tag_field.hpp"

namespace plumbline::pose {

/// A sentence about the one mistake that makes at least nine tenths of the tags agree in the images that show most of
/// them, and leaves at most 0.4 of those that disagree without it; empty if none does. Tried: another family, ids moved
/// by one, two floors exchanged, tag sizes in another unit, plates that look elsewhere or whose azimuth is in radians,
/// corners that begin elsewhere or run the other way round, principal distance in millimetres, principal point
/// exchanged, photographs scaled by a half or two, photographs of another of the cameras. Of several cameras each is
/// asked by itself, and named.
std::string what_would_explain(const std::vector<ImageTagsT>& images, const ImageCameras& cameras, const Field& field,
                               const TagPoseSolver& solver, const PoseSettings& settings);

/// Tags that hang where the field has another plate, found from the rays of at least two oriented images: "F01-C01-R1
/// and F01-C02-R1 hang in each other's place". One sentence a pair, or a tag.
std::vector<std::string> exchanged_plates(const std::vector<ImageTagsT>& images, const PosesT& poses,
                                          const ImageCameras& cameras, const Field& field);

}  // namespace plumbline::pose

// What the page of an image block is made of, from a block as the adjusters give it: of marker plates with everything
// that it was adjusted from, or of the measured targets of other programs.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "artifacts/block.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"

namespace plumbline::report {

struct TagBlockInput {
  BlockT block;
  PointsT points;  ///< adjusted
  PosesT poses;    ///< adjusted
  CameraT camera;  ///< adjusted
  PlatesT plates;
  std::vector<ImageTagsT> observations;
};

/// In the form of a block.json of tags. Residuals are computed anew: measured minus where block, points, poses and
/// camera put a corner. Throws std::runtime_error if these are not of one adjustment.
nlohmann::ordered_json tag_block_json(const TagBlockInput& input);

/// The same of a block of measured targets. Throws std::runtime_error for another one.
nlohmann::ordered_json target_block_json(const BlockT& block, const ImageBlockT& measured);

}  // namespace plumbline::report

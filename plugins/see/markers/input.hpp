// From photographs and their tags to a block: which camera took what, which photographs and tags cannot take part.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "artifacts/camera.hpp"
#include "artifacts/camera_artifact.hpp"
#include "artifacts/image.hpp"
#include "artifacts/tag_observations.hpp"
#include "photo/markers/marker_block.hpp"

namespace plumbline::markers {

/// A photograph that takes no part, and why.
struct LeftOut {
  std::string path, reason;
};

struct BlockInput {
  MarkerBlock block;
  std::vector<LeftOut> left_out;      ///< photographs
  std::vector<std::string> warnings;  ///< tags left out of photographs, doubts
};

struct InputOptions {
  double tag_size = 0;                ///< [m]
  std::string cameras = "by_folder";  ///< what tells cameras apart: as camera_name() has it
};

/// The block's images, views and markers; markers get `tag_size`. Cameras: `known` if there are any (one for all
/// photographs, or several that are called as camera_name calls them; photographs of another size are left out), else
/// one for each name, EXIF model, size and focal length, started from EXIF.
BlockInput block_of(const std::vector<ImageT>& images, const TagObservationsT& observations, std::vector<CameraT> known,
                    const InputOptions& options);

/// "7,12,1.234" or "tag36h11:7,12,1.234,0.0005": two tags, the distance between their centres in metres and, if given,
/// its standard deviation (otherwise 0.5 mm). Throws what is wrong with it.
MarkerDistance parse_distance(const std::string& text, const MarkerBlock& block);

}  // namespace plumbline::markers

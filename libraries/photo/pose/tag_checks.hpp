// What the tags of a block's photographs say before any pose: tags that nobody listed, photographs that count twice.
#pragma once

#include <string>
#include <vector>

#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"

namespace plumbline::pose {

/// Tags that were seen and are in no row of the plate table, in one sentence; empty if there are none.
std::string unknown_tags(const std::vector<ImageTagsT>& images, const PlatesT& plates);

/// Images whose tags lie in the very same places, or within a third of a pixel: one photograph under two names, saved
/// again perhaps, which would count double.
std::vector<std::string> same_photographs(const std::vector<ImageTagsT>& images);

}  // namespace plumbline::pose

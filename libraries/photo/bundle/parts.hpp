// Whether a block hangs together.
#pragma once

#include <string>
#include <vector>

#include "photo/bundle/problem.hpp"

namespace plumbline::bundle {

/// Images by part: two images are of one part if they see the same point or plate, or bodies between which a distance
/// is known, or are joined by others that do. In the order of the images; one part in a sound block.
std::vector<std::vector<int>> image_parts(const Problem& problem);

/// "the block falls into 2 parts that share no tag and no point: ... (10 images) and ... (10 images); ..."; empty for
/// one part.
std::string words_of_parts(const Problem& problem);

}  // namespace plumbline::bundle

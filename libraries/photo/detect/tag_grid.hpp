// Grids of tags in photographs.
#pragma once

#include <string>
#include <vector>

#include "photo/detect/board.hpp"
#include "photo/detect/tag_detector.hpp"

namespace plumbline::detect {

/// Finds the tags of a grid and measures their corners. Tags that lie otherwise than the file has them contradict it.
SeenBoard find_tags(const GreyImage& image, const Board& board);

/// The tags of a board, of `count` ids, that are once in a photograph.
struct SingleTags {
  std::vector<DetectedTag> tags;  ///< by id
  std::string twice;              ///< ids that are there more than once: only one of them can be it
  std::string problem;            ///< not empty where so many are there twice that this is no photograph of one board
};

SingleTags single_tags(std::vector<DetectedTag> found, int first_id, int count);

}  // namespace plumbline::detect

// Disparities of a rectified pair by semi-global matching, OpenCV's StereoSGBM. Source: Hirschmüller (2008), Stereo
// processing by semiglobal matching and mutual information.
#pragma once

#include <vector>

#include "surface/dense/pair_heights.hpp"

namespace plumbline::surface {

struct SemiGlobalOptions {
  PairOptions pair;
  int block = 5;  ///< edge of what is compared, odd [px]
};

/// Disparities that a pair has over a grid, as whole pixels: how many hypotheses each pixel takes. Nothing if more than
/// 1024: the pair sees the face too much from the side, or the search is too wide for it.
struct DisparityRange {
  int least = 0, count = 0;   ///< count: a multiple of 16
  Eigen::Vector2d low, high;  ///< of the left photograph, rectified [px]
};
std::optional<DisparityRange> disparity_range(const RectifiedPair& pair, const CellGrid& grid, double search);

/// What the pair says of each cell of the grid. In strips of rows, so that memory goes with the width of a face alone.
std::vector<PairHeight> semi_global_heights(const RectifiedPair& pair, const CellGrid& grid,
                                            const std::vector<FacetView>& views, const SemiGlobalOptions& options);

}  // namespace plumbline::surface

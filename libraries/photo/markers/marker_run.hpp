// One adjustment of a block of tags as it was made, and what is read from it.
#pragma once

#include <memory>

#include "photo/bundle/adjust.hpp"
#include "photo/markers/marker_model.hpp"

namespace plumbline::markers {

/// Everything of one adjustment that the results are read from; not to be moved, since the parts point to each other.
struct MarkerRun {
  MarkerModel model;
  std::unique_ptr<bundle::Layout> layout;
  bundle::Adjusted adjusted;
  bundle::Reliability reliability;
  Eigen::MatrixXd cofactor(bundle::Ref ref) const { return adjusted.cofactors->own(layout->block(ref)); }
};

/// Cameras with their covariance, the inset of their edges, and how many photographs they took.
void fill_cameras(const MarkerBlock& block, const MarkerRun& run, MarkerResult& result);

/// Tags with places, sizes, corners [m] and the covariance of their centres, each and all together.
void fill_markers(const MarkerBlock& block, const MarkerRun& run, MarkerResult& result);

/// Poses of the photographs; one that took no part is not oriented.
void fill_images(const MarkerBlock& block, const MarkerRun& run, MarkerResult& result);

/// Residuals [px], w and redundancy of each view, and what they are together by photograph, camera and block: after
/// fill_cameras() and fill_images().
void fill_views(const MarkerBlock& block, const MarkerRun& run, MarkerResult& result);

}  // namespace plumbline::markers

// What the result of a marker block has to be told in words: why a photograph has no pose, what is weak, what the
// observations contradict.
#pragma once

#include "markers/marker_block.hpp"

namespace plumbline::markers {

/// Corners that are much worse than the detector states are a finding about the photographs.
void warn_about_variance(MarkerResult& result);
/// Tags that the photographs show elsewhere than the layout has them, and which were exchanged.
void warn_about_layout(const MarkerBlock& block, const MarkerOptions& options, MarkerResult& result);
/// Why an image is not oriented, and which tags could not be placed.
void explain_images(const MarkerBlock& block, MarkerResult& result);
/// The second pose of photographs with one tag.
void explain_single_tags(const MarkerBlock& block, MarkerResult& result);
/// Poses, cameras and tags that hang on little.
void warn_about_weak(const MarkerBlock& block, MarkerResult& result);

}  // namespace plumbline::markers

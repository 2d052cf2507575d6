// What the result of a marker block has to be told in words: why a photograph has no pose, what is weak, what the
// observations contradict.
#pragma once

#include <map>
#include <set>

#include "markers/marker_block.hpp"

namespace plumbline::markers {

/// Corners that are much worse than the detector states are a finding about the photographs.
void warn_about_variance(MarkerResult& result);
/// Where the photographs have a tag that the layout has elsewhere.
struct TagOffLayout {
  Eigen::Vector3d place;
  double distance = 0;  ///< [m]
};
/// By marker: those that are off by five standard deviations of the layout's places and half their size.
std::map<int, TagOffLayout> tags_off_layout(const MarkerBlock& block, const MarkerOptions& options,
                                            const MarkerResult& result);
/// Names them, and which were exchanged. `left_out`: markers whose place in the layout took no part.
void warn_about_layout(const MarkerBlock& block, const MarkerOptions& options, const std::set<int>& left_out,
                       MarkerResult& result);
/// Why an image is not oriented, and which tags could not be placed.
void explain_images(const MarkerBlock& block, MarkerResult& result);
/// The second pose of photographs with one tag.
void explain_single_tags(const MarkerBlock& block, MarkerResult& result);
/// Poses, cameras and tags that hang on little.
void warn_about_weak(const MarkerBlock& block, MarkerResult& result);

}  // namespace plumbline::markers

// A block of tags against the layout that says where they are, and against the calibrations it comes with: what does
// not hold of these is left out or refused, and the rest is adjusted again.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include "geometry/median.hpp"
#include "photo/markers/marker_adjustment.hpp"
#include "photo/markers/marker_model.hpp"
#include "photo/markers/marker_words.hpp"
#include "photo/markers/rearranged_tags.hpp"

namespace plumbline::markers {
namespace {

/// One tag that the layout has facing away can leave nothing that converges. Then the one without whose place the rest
/// fits best is `left_out`. Throws what the block fails of if that is no single tag.
MarkerResult adjust_without_worst(const MarkerBlock& block, const MarkerOptions& options, const std::set<int>& seen,
                                  std::set<int>& left_out) {
  try {
    return adjust_as_given(block, options);
  } catch (const std::runtime_error&) {
    std::optional<MarkerResult> best;
    for (const int marker : seen) {
      if (seen.size() < 3) break;
      MarkerBlock without = block;
      without.markers[marker].world_from_tag.reset();
      try {
        MarkerResult result = adjust_as_given(without, options);
        const auto fits_better = [&] {
          return result.rejected.size() != best->rejected.size() ? result.rejected.size() < best->rejected.size()
                                                                 : result.rms < best->rms;
        };
        if (!best || fits_better()) best = std::move(result), left_out = {marker};
      } catch (const std::runtime_error&) {  // another tag, or none
      }
    }
    if (!best) throw;
    return *best;
  }
}

/// Neighbours share what one of them is off by, so only the one whose rotation has by far the largest residual is the
/// one; -1 if others have nearly the same.
int most_contradicted(const std::map<int, TagOffLayout>& off, double nearly) {
  int worst = -1;
  double largest = 0, second = 0;
  for (const auto& [marker, tag] : off) {
    if (tag.contradiction > largest)
      worst = marker, second = largest;
    else
      second = std::max(second, tag.contradiction);
    largest = std::max(largest, tag.contradiction);
  }
  return second < nearly * largest ? worst : -1;
}

/// The layout's distances give the tags' size, which must be that they are said to have. `used`: without the places of
/// tags that were moved. Throws std::runtime_error with the size that the photographs show where it is another.
void require_size(const MarkerBlock& used, const MarkerOptions& options) {
  constexpr double free_size = 0.3, limit = 5, much = 0.02;  // relative, standard deviations, relative
  if (!(options.size_sigma > 0) || !(options.size_sigma < free_size)) return;
  MarkerOptions free = options;
  free.size_sigma = free_size;
  std::vector<double> scales, sigmas;
  int together = 0;
  try {
    const MarkerResult result = adjust_as_given(used, free);
    for (const AdjustedMarker& marker : result.markers) {
      if (!used.markers[marker.marker].world_from_tag) continue;
      if (marker.scale_sigma > 0.5 * free_size) continue;  // seen with no other tag
      scales.push_back(marker.scale), sigmas.push_back(marker.scale_sigma);
    }
    for (const AdjustedMarkerImage& image : result.images) together += image.tags > 1;
  } catch (const std::runtime_error&) {
    return;  // the places say nothing of the sizes
  }
  if (scales.size() < 2) return;
  // The tags' mean, whose standard deviation holds how far they scatter: a layout that is wrong in itself makes sizes
  // of all kinds.
  double weights = 0, sum = 0, squares = 0;
  for (size_t k = 0; k < scales.size(); ++k) {
    const double weight = 1 / (sigmas[k] * sigmas[k]);
    weights += weight, sum += weight * scales[k], squares += weight * scales[k] * scales[k];
  }
  const double scale = sum / weights, freedom = static_cast<double>(scales.size() - 1);
  const double sigma = std::sqrt(std::max(1.0, (squares - sum * scale) / freedom) / weights);
  const double off = std::abs(scale - 1);
  if (!(off > std::max(limit * sigma, much)) || off > free_size) return;
  std::vector<double> stated;
  for (const Marker& marker : used.markers)
    if (marker.world_from_tag) stated.push_back(marker.size);
  const double size = median(stated);
  const std::string text = fmt::format(
      "the tags are not {:.1f} mm large: by the distances in the layout their edge is {:.1f} \u00b1 {:.1f} mm ({} "
      "photographs with two tags and more). With the wrong size every photograph would be placed wrongly by {:.0f} % "
      "of its distance. Correct tag_size (the edge of the black square), or the layout; where the layout is less "
      "certain than position_sigma says, state that",
      1e3 * size, 1e3 * size * scale, 1e3 * size * sigma, together, 100 * std::abs(scale - 1));
  throw std::runtime_error(text);
}

/// Tags that were moved or turned since their layout was made would pull the frame along. The layout's places of those
/// that are furthest off are left out as long as most of the tags stay, and the rest is adjusted again.
MarkerResult adjust_to_layout(const MarkerBlock& block, const MarkerOptions& options) {
  constexpr double as_far = 0.75;  // one moved tag of three pulls the others by half of what it is off itself
  MarkerBlock used = block;
  std::set<int> seen, left_out;
  for (const MarkerView& view : block.views)
    if (block.markers[view.marker].world_from_tag) seen.insert(view.marker);
  MarkerResult result = adjust_without_worst(block, options, seen, left_out);
  for (const int marker : left_out) used.markers[marker].world_from_tag.reset();
  for (;;) {
    const auto off = tags_off_layout(used, options, result);
    double furthest = 1;
    for (const auto& [marker, tag] : off) furthest = std::max(furthest, tag.excess);
    std::set<int> next = left_out;
    for (const auto& [marker, tag] : off)
      if (tag.excess > 1 && tag.excess >= as_far * furthest) next.insert(marker);
    if (next == left_out) {
      const int worst = most_contradicted(off, as_far);
      if (worst >= 0) next.insert(worst);
    }
    if (next == left_out || 2 * next.size() >= seen.size()) break;
    left_out = next;
    for (const int marker : left_out) used.markers[marker].world_from_tag.reset();
    result = adjust_as_given(used, options);
  }
  if (has_layout(used)) require_size(used, options);
  warn_about_layout(block, options, left_out, result);
  return result;
}

MarkerResult adjust_with_calibrations(const MarkerBlock& block, const MarkerOptions& options) {
  MarkerBlock held = block;
  bool estimated = false;   // a camera of which something is known, but not as exact
  bool calibrated = false;  // by more than what EXIF says
  for (MarkerCamera& camera : held.cameras)
    if (camera.covariance.size() > 0 && !camera.held)
      camera.held = estimated = true, calibrated = calibrated || !camera.any_lens;
  if (!estimated) return adjust_to_layout(block, options);
  try {
    return adjust_to_layout(block, options);
  } catch (const std::runtime_error&) {
    const std::exception_ptr first = std::current_exception();
    MarkerResult result;
    try {
      result = adjust_to_layout(held, options);
    } catch (const std::runtime_error&) {
      std::rethrow_exception(first);
    }
    if (!calibrated) return result;
    result.warnings.insert(result.warnings.begin(),
                           "the photographs do not improve the calibrations they come with, which are taken as exact: "
                           "standard deviations do not hold their uncertainty");
    return result;
  }
}

}  // namespace

MarkerResult adjust_marker_block(const MarkerBlock& block, const MarkerOptions& options) {
  MarkerResult result;
  try {
    result = adjust_with_calibrations(block, options);
  } catch (const std::runtime_error&) {
    const std::string moved = rearranged_tags(block);
    if (moved.empty()) throw;
    throw BadInput(std::to_string(block.images.size()) + " photographs do not make one block: " + moved);
  }
  if (3 * result.rejected.size() > block.views.size())
    if (const std::string moved = rearranged_tags(block); !moved.empty()) result.warnings.push_back(moved);
  return result;
}

}  // namespace plumbline::markers

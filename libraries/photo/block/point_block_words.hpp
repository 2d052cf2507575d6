// What stands out in an adjusted block of measured targets, in words; each is empty if nothing does.
#pragma once

#include <string>

#include "photo/block/point_block.hpp"

namespace plumbline::block {

/// What the control's variance component says beside that of the images, and single points whose error would explain
/// what the images contradict; empty if it may be chance. Both components are compared by their ratio, because nobody
/// knows the standard deviation of image coordinates beforehand: F test, 0.1 %; points as suspects_of() tests them,
/// where the joint covariance is known.
std::string control_against_images(const PointBlockResult& result);

/// Scale bars that contradict each other, or the control: by their own standard deviations, or those of images that are
/// worse than stated (F test, 0.1 %); with those that could be the wrong one. Empty if it may be chance, or if nothing
/// checks them, as the only bar of a free block.
std::string scale_bars_against_images(const PointBlockResult& result);

/// Measurements that no chance explains: |w| above 12. Matched features have long tails (up to 11.5 in public blocks
/// that are sound otherwise), so not everything that a test at some per cent finds is worth a warning.
std::string blunders_in_words(const PointBlockResult& result);

/// Images that the adjustment has turned by more than 45° against their approximate orientation where four fifths
/// of all have turned alike, within 10°. A view of level ground whose coordinates are exchanged or mirrored fits
/// from below the ground, and no residual tells.
std::string turned_images(const PointBlock& given, const PointBlockResult& result);

}  // namespace plumbline::block

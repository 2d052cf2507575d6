// What a block of measured targets has to have before it is adjusted. Each throws std::runtime_error that names what is
// missing or wrong.
#pragma once

#include "photo/block/point_block.hpp"

namespace plumbline::block {

/// Two images, points seen twice, images with three points.
void require_enough_observations(const PointBlock& block);

/// Images and scale bars tell the block's shape and size: where it is and how it is turned take three known points.
void require_enough_control(const PointBlock& block);

/// Coordinates of points, control and projection centres that can be some of a site: one of 1e308 is the mean of all.
void require_coordinates(const PointBlock& block);

}  // namespace plumbline::block

// What is known of a block of measured targets whose normal matrix was not factorised: residuals, and NaN for the rest.
#pragma once

#include "photo/block/point_block.hpp"

namespace plumbline::block {

/// Residuals with their standard deviations a priori; NaN for all that takes the inverse of the normal matrix.
bundle::Reliability residuals_of(const bundle::Problem& problem, const bundle::Layout& layout,
                                 const bundle::State& state);

/// NaN in the shapes that covariances would have.
void fill_unknown_covariances(const bundle::Problem& problem, const bundle::Layout& layout, PointBlockResult& result);

}  // namespace plumbline::block

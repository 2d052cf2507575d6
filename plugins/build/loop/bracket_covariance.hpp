// How well the brackets of a facade are known: all together, and of the readings alone.
#pragma once

#include <string>
#include <vector>

#include "artifacts/deviation.hpp"
#include "artifacts/points.hpp"
#include "build/loop/facade_input.hpp"

namespace plumbline::loop {

/// Facade::covariance and Facade::own of in.facade.brackets [m²], three rows each, in the frame of the points: of
/// `model`, and on the diagonal what the judgement has. `anchors`: the brackets as judged, in their order; `control`:
/// points of the model that all campaigns rest on, those that are in it go to in.control. Throws std::runtime_error
/// where the model has no covariance, or lacks an anchor that was judged.
void add_covariance(const PointsT& model, const std::vector<const AnchorDeviationT*>& anchors,
                    const std::vector<std::string>& control, FacadeInput& in);

}  // namespace plumbline::loop

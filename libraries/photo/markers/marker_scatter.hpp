// What photographs have of their own beside the noise of their corners, in the covariances of tags and photographs.
//
// An adjustment with one camera takes what a photograph's camera differs by for noise of its corners. The pose of that
// photograph takes most of it: two per cent of the principal distance are two per cent of the distance. The truth test
// (camera_changes.hpp) says how large these effects are; how far they move each unknown follows from the normal
// equations, so nothing is assumed of it.
#pragma once

#include <vector>

#include "photo/markers/marker_block.hpp"
#include "photo/markers/marker_model.hpp"
#include "photo/markers/photograph_shares.hpp"

namespace plumbline::markers {

/// Adds to the formal covariances of photographs what moves them: the effects that CameraTruth has of each, propagated
/// through the adjustment that does not know them, and what the covariance of a camera is larger by than these and the
/// formal one together; the formal ones grow by the corners' variance factor beside the effects. Tags meet in many
/// photographs, whose effects mostly cancel there: their covariances grow by how much more the photographs' influences
/// on them scatter than they should, with eight photographs and more. `shares` with effects and `cofactor` (of all kept
/// unknowns) are of `model`.
void add_scatter(const MarkerModel& model, const bundle::Layout& layout, const std::vector<PhotographShare>& shares,
                 const Eigen::MatrixXd& cofactor, MarkerResult& result);

}  // namespace plumbline::markers

// Results of a marker block as files and artifacts; docs/photographs.md has the fields.
#pragma once

#include <string>
#include <vector>

#include "artifacts/camera.hpp"
#include "artifacts/file.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "input.hpp"
#include "photo/markers/marker_halves.hpp"

namespace plumbline::markers {

FileT file_of(const std::string& name, const std::string& media_type, const std::string& text);

/// tags[] {id, family, centre, corners, sigma, ...}.
std::string tags_json(const MarkerBlock& block, const MarkerResult& result);
/// The whole adjustment: statistics, groups, cameras, images, points, observations, rejected, left_out, warnings.
std::string block_json(const BlockInput& input, const MarkerResult& result,
                       const std::vector<MarkerHalves>& halves = {});
/// images[] {path, oriented, reason, centre, rotation, sigma, ...}, every photograph that was given.
std::string poses_json(const BlockInput& input, const MarkerResult& result);
/// One tag a line with its deviation from the layout.
std::string points_csv(const MarkerBlock& block, const MarkerResult& result);

PointsT points_of(const MarkerBlock& block, const MarkerResult& result);
PosesT poses_of(const MarkerBlock& block, const MarkerResult& result);
CameraT camera_artifact(const MarkerCamera& camera, const AdjustedMarkerCamera& adjusted);

}  // namespace plumbline::markers

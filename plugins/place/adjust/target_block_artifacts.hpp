// Between the artifacts of a pipeline and the plain structs of point_block.hpp.
#pragma once

#include "artifacts/block.hpp"
#include "artifacts/camera.hpp"
#include "artifacts/image_block.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "photo/block/read_block.hpp"

namespace plumbline::block {

/// Throws std::runtime_error for a number out of range, an unknown camera model or a control point without a name in
/// the block.
PointBlock target_block_of(const ImageBlockT& artifact);
ImageBlockT target_block_artifact(const ReadBlock& read);

/// The a priori standard deviation [mm] that the measurements have, the first one's if they differ; 0.0005 if they have
/// none.
double image_sigma_of(const PointBlock& block);

/// Covariances in the results already hold sigma0: they are of unit weight 1 for whoever reads them.
/// `given` is the block before the adjustment.
BlockT describe_targets(const PointBlock& given, const PointBlockResult& result, const PointBlockOptions& options);
PointsT target_points(const PointBlockResult& result);
/// cam_from_world in the camera frame of Poses (y down, z forward).
PosesT target_poses(const PointBlockResult& result);
/// The first camera's name and size; without parameters, which `Block.targets` has: they are of another model.
CameraT target_camera(const PointBlockResult& result);

}  // namespace plumbline::block

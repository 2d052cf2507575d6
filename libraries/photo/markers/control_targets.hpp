// Points that take part in the adjustment of a COLMAP model with control: surveyed ones and tie points, with their
// rays.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "photo/markers/control_block.hpp"

namespace plumbline::markers {

/// A measurement of a point in a photograph of the model [px].
struct Measured {
  std::uint32_t image;
  Eigen::Vector2d pixel;
  double sigma;
};

/// A point with its rays.
struct Target {
  std::string name;
  Eigen::Vector3d position;
  std::vector<Measured> rays;
  const ControlPoint* control = nullptr;
  std::int64_t tie = -1;
  bool aside = false;  ///< control that contradicts the rest and does not take part
};

/// Linear intersection of the rays of a point; nothing if they are nearly parallel.
std::optional<Eigen::Vector3d> intersect(const cameras::ColmapModel& model, const std::vector<Measured>& rays);

/// Largest angle between two rays [rad].
double largest_angle(const cameras::ColmapModel& model, const Eigen::Vector3d& point,
                     const std::vector<Measured>& rays);

/// The control points with their measurements. What belongs to no photograph or point is told in `result`; throws
/// std::runtime_error if nothing belongs together.
std::vector<Target> targets_of(const cameras::ColmapModel& model, const std::vector<ControlPoint>& control,
                               const std::vector<ImagePoint>& measured, const ControlOptions& options,
                               ControlResult& result);

/// Leaves out measurements of a surveyed point that lie more than 25 px, or twenty times their standard deviation, from
/// where the point's other photographs have it in the model as it is, if nothing else explains it; the whole point if
/// it cannot be told which is wrong. Each is a warning. One such measurement bends the photographs until their tie
/// points no longer fit, and the adjustment names anything but its cause.
void set_wrong_measurements_aside(const cameras::ColmapModel& model, std::vector<Target>& targets,
                                  ControlResult& result);

/// Adds the tie points with the longest tracks, every photograph its share.
void add_ties(const cameras::ColmapModel& model, const ControlOptions& options, std::vector<Target>& targets);

}  // namespace plumbline::markers

// Files of point clouds: PLY (text, binary of both byte orders), LAS 1.0 to 1.4 without compression, E57, PTS, XYZ.
//
// Files come from scanners and programs of others, so nothing in them is believed: what a header announces is held
// against the size of the file before anything is allocated, and every refusal names the file, the place in it, what
// was found and what was expected.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "plumbline/failure.hpp"

namespace plumbline::cloud {

/// What is wrong with a file: "scan.las, byte 107: ...".
struct CloudError : BadInput {
  using BadInput::BadInput;
};

struct CloudSummary {
  std::string format;  ///< "LAS 1.4, point format 6"
  double unit =
      std::numeric_limits<double>::quiet_NaN();  ///< metres in one unit of its coordinates; nan: it does not say
  std::uint64_t points = 0;                      ///< that were delivered
  std::uint64_t without_place = 0;  ///< NaN or infinite, as organised scans write where nothing came back; left out
  std::uint64_t withheld = 0;       ///< that a LAS file says not to use (withheld, noise); left out
  Eigen::Vector3d low =
      Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());  ///< of the delivered points
  Eigen::Vector3d high = Eigen::Vector3d::Constant(-std::numeric_limits<double>::infinity());
  /// Steps that each coordinate is written in, in the unit of the file: the scale of LAS, what a 32-bit float leaves at
  /// the largest coordinate, the last decimal of text. Known after read_cloud.
  Eigen::Vector3d resolution = Eigen::Vector3d::Zero();
  int scans = 1;  ///< that it says it has: blocks of PTS, point source ids of LAS, scans of E57; each may err by itself
  int without_pose = 0;  ///< of them, scans of E57 that say no pose where others do: perhaps in the scanner's own frame
  bool either_foot = false;  ///< it says feet and not which; `unit` is then that of the international foot
  double unit_of_heights = std::numeric_limits<double>::quiet_NaN();  ///< likewise, where it says one of its own
  std::string without_unit_of;  ///< a coordinate system that it names by a number without its unit: "EPSG:2263"
};

/// Takes some points, in the unit of the file, its scale and offset applied. `done`: share of the file that was read.
/// `scan`: which of the file's scans they are of, counted from 0 as they come; those beyond the 256th are of that one.
using PointSink = std::function<void(const std::vector<Eigen::Vector3d>& points, double done, int scan)>;

/// What the file says before its points: format and unit. Throws CloudError as read_cloud does.
CloudSummary look_at_cloud(const std::string& path);

/// Reads a file of whatever format it is, by its first bytes, and hands its points on, up to 65536 at a time, those of
/// a scan in the order of the file. Throws CloudError for a file that is empty, shorter than it announces, of a kind
/// that is not read (compressed LAZ, PTX, PCD: it says how to get one that is), or without a single point that has
/// coordinates. What `sink` throws goes through.
CloudSummary read_cloud(const std::string& path, const PointSink& sink);

}  // namespace plumbline::cloud

// What the XML section of an E57 file says of its scans.
#pragma once

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "surface/cloud/e57_pages.hpp"

namespace plumbline::cloud {

/// A number of every point, packed into so many bits: (minimum + what is stored) · scale + offset, or a float.
struct E57Field {
  std::string name;
  enum class Kind { integer, single_float, double_float, text } kind = Kind::integer;
  int bits = 0;  ///< of one; 0: all points have the minimum
  std::int64_t minimum = 0;
  double scale = 1, offset = 0;
};

struct E57Scan {
  std::string name;
  std::uint64_t points_at = 0;  ///< of the section with its points, with checksums
  std::uint64_t points = 0;
  std::vector<E57Field> fields;
  int coordinates[3] = {-1, -1, -1};  ///< numbers of fields: x, y, z, or range, azimuth, elevation
  int invalid = -1;                   ///< of the field that says which points have none
  bool spherical = false;
  bool has_pose = false;
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();  ///< from the scan's frame to the file's
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();         ///< [m]
};

/// Throws CloudError, with the scan and what is wrong, for XML that does not parse, points without coordinates, numbers
/// that are none, another codec than the standard's own, and more points than the file has bits for.
std::vector<E57Scan> e57_scans(const std::string& xml, const CloudStream& stream);

}  // namespace plumbline::cloud

// The header of a PLY file (Turk 1994).
#pragma once

#include <string>
#include <vector>

#include "surface/cloud/cloud_stream.hpp"

namespace plumbline::cloud {

enum class PlyType { int8, uint8, int16, uint16, int32, uint32, float32, float64 };
int bytes_of(PlyType type);

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::float32;
  bool is_list = false;
  PlyType count_type = PlyType::uint8;  ///< of a list
};

struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties;
  bool has_list() const;
  std::uint64_t row() const;  ///< bytes of one, without lists
};

struct PlyHeader {
  enum class Layout { text, little_endian, big_endian } layout = Layout::text;
  std::vector<PlyElement> elements;
  double unit = std::numeric_limits<double>::quiet_NaN();  ///< by "comment unit: mm" and the like [m]
  bool either_foot = false;                                ///< "feet", and not which
};

/// Leaves the stream after "end_header". Throws CloudError with the line.
PlyHeader read_ply_header(CloudStream& stream);

}  // namespace plumbline::cloud

// Bytes of cloud files as a scanner's program would write them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace plumbline::cloud_bytes {

template <typename T>
std::string bytes_of(T value, bool big_endian = false) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

template <typename T>
void put(std::string& bytes, size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof(T));
}

struct LasFile {
  int minor = 2, format = 0;
  double scale = 0.0001;
  Eigen::Vector3d offset = {500000, 200000, 100};
  std::string records;  ///< between header and points
  std::uint32_t record_count = 0;
  std::uint16_t extra_bytes = 0;
  bool with_box = false;  ///< of the points as they are given, whatever becomes of them
};

/// One record before the points.
inline std::string las_record(std::uint16_t id, const std::string& content) {
  std::string record(54, '\0');
  std::memcpy(record.data() + 2, "LASF_Projection", 15);
  put(record, 18, id), put(record, 20, static_cast<std::uint16_t>(content.size()));
  return record + content;
}

inline std::string las_file(const LasFile& file, const std::vector<Eigen::Vector3d>& points) {
  const std::uint16_t sizes[] = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};
  const std::uint16_t header = file.minor == 4 ? 375 : file.minor == 3 ? 235 : 227;
  const auto record = static_cast<std::uint16_t>(sizes[file.format] + file.extra_bytes);
  std::string bytes(header, '\0');
  bytes.replace(0, 4, "LASF");
  bytes[24] = 1, bytes[25] = static_cast<char>(file.minor), bytes[104] = static_cast<char>(file.format);
  put(bytes, 94, header), put(bytes, 96, static_cast<std::uint32_t>(header + file.records.size())),
      put(bytes, 100, file.record_count);
  put(bytes, 105, record);
  if (file.minor < 4)
    put(bytes, 107, static_cast<std::uint32_t>(points.size()));
  else
    put(bytes, 247, static_cast<std::uint64_t>(points.size()));
  for (size_t axis = 0; axis < 3; ++axis) {
    put(bytes, 131 + 8 * axis, file.scale);
    put(bytes, 155 + 8 * axis, file.offset(static_cast<Eigen::Index>(axis)));
  }
  for (size_t axis = 0; axis < 3 && file.with_box; ++axis) {
    const auto a = static_cast<Eigen::Index>(axis);
    const auto less = [a](const auto& p, const auto& q) { return p(a) < q(a); };
    const auto [low, high] = std::minmax_element(points.begin(), points.end(), less);
    put(bytes, 179 + 16 * axis, (*high)(a)), put(bytes, 187 + 16 * axis, (*low)(a));
  }
  bytes += file.records;
  for (const Eigen::Vector3d& point : points) {
    std::string one(record, '\0');
    for (size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<Eigen::Index>(axis);
      put(one, 4 * axis, static_cast<std::int32_t>(std::lround((point(a) - file.offset(a)) / file.scale)));
    }
    bytes += one;
  }
  return bytes;
}

/// float x, y, z with a byte before and a list of another element before the vertices.
inline std::string binary_ply(const std::vector<Eigen::Vector3d>& points, bool big) {
  std::string bytes =
      std::string("ply\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") +
      " 1.0\ncomment unit: mm\nelement group 1\nproperty list uchar short members\nelement vertex " +
      std::to_string(points.size()) +
      "\nproperty uchar grey\nproperty double x\nproperty float y\nproperty float z\nproperty uchar red\nend_header\n";
  bytes += bytes_of<std::uint8_t>(2) + bytes_of<std::int16_t>(7, big) + bytes_of<std::int16_t>(8, big);
  for (const Eigen::Vector3d& point : points)
    bytes += "g" + bytes_of(point.x(), big) + bytes_of(static_cast<float>(point.y()), big) +
             bytes_of(static_cast<float>(point.z()), big) + "r";
  return bytes;
}

}  // namespace plumbline::cloud_bytes

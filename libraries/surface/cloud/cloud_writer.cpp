#include "surface/cloud/cloud_writer.hpp"

#include <cmath>
#include <cstring>

namespace plumbline::cloud {
namespace {

constexpr double kStep = 1e-4;  // of coordinates in LAS [m]
constexpr size_t kHeader = 375, kRecordHeader = 54, kExtraBytes = 192, kPoint = 30 + sizeof(float);
constexpr size_t kLongestName = 200;

/// What is written is in metres, in a frame that no registry knows: its name is all there is to say. Which way its axes
/// point is not said, as a scanner's or a building's point anywhere.
std::string system_of(const std::string& frame) {
  return "LOCAL_CS[\"" + frame + "\",LOCAL_DATUM[\"" + frame +
         "\",0],UNIT[\"metre\",1,AUTHORITY[\"EPSG\",\"9001\"]],AXIS[\"X\",OTHER],AXIS[\"Y\",OTHER]]";
}

std::string checked(const std::string& frame, const std::string& path) {
  if (frame.size() <= kLongestName && frame.find_first_of("\"\n\r") == std::string::npos)
    return frame.empty() ? "frame not stated" : frame;
  throw CloudError(path + ": the name of the frame has " + std::to_string(frame.size()) +
                   " characters, or a quotation mark or a line break among them; a cloud holds one of up to " +
                   std::to_string(kLongestName) + " without");
}

template <typename T>
void put(std::string& bytes, size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

void put_text(std::string& bytes, size_t at, const char* text) {
  std::memcpy(bytes.data() + at, text, std::strlen(text));
}

std::string record(const char* user, std::uint16_t id, const std::string& content) {
  std::string bytes(kRecordHeader, '\0');
  put_text(bytes, 2, user);
  put(bytes, 18, id), put(bytes, 20, static_cast<std::uint16_t>(content.size()));
  return bytes + content;
}

/// Before the points: the system's text and what the extra bytes of each point are.
std::string records(const std::string& frame) {
  std::string sigma(kExtraBytes, '\0');
  sigma[2] = 9;  // a 32-bit float
  put_text(sigma, 4, "sigma");
  put_text(sigma, 160, "1 sigma along the normal, m");
  return record("LASF_Projection", 2112, system_of(frame) + '\0') + record("LASF_Spec", 4, sigma);
}

std::string las_header(std::uint64_t points, const Eigen::Vector3d& offset, const Eigen::Vector3d& low,
                       const Eigen::Vector3d& high, size_t points_at) {
  std::string bytes(kHeader, '\0');
  put_text(bytes, 0, "LASF");
  put(bytes, 6, std::uint16_t{16});  // the system is WKT
  bytes[24] = 1, bytes[25] = 4;
  put_text(bytes, 26, "Plumbline"), put_text(bytes, 58, "Plumbline");
  put(bytes, 94, static_cast<std::uint16_t>(kHeader)), put(bytes, 96, static_cast<std::uint32_t>(points_at));
  put(bytes, 100, std::uint32_t{2});
  bytes[104] = 6;
  put(bytes, 105, static_cast<std::uint16_t>(kPoint));
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<size_t>(axis);
    put(bytes, 131 + 8 * a, kStep), put(bytes, 155 + 8 * a, offset(axis));
    put(bytes, 179 + 16 * a, high(axis)), put(bytes, 187 + 16 * a, low(axis));
  }
  put(bytes, 247, points), put(bytes, 255, points);  // all of them first returns
  return bytes;
}

}  // namespace

CloudWriter::CloudWriter(const std::string& path, CloudFormat format, std::uint64_t count, const Eigen::Vector3d& near,
                         const std::string& frame)
    : path_(path),
      format_(format),
      frame_(checked(frame, path)),
      file_(path, std::ios::binary | std::ios::trunc),
      announced_(count) {
  offset_ = near.array().round();
  if (format_ == CloudFormat::las) {
    write(std::string(kHeader, '\0') + records(frame_));  // the header is known at the end
    return;
  }
  write("ply\nformat binary_little_endian 1.0\ncomment unit: m\ncomment frame: " + frame_ +
        "\ncomment sigma: standard deviation along the surface's "
        "normal\nelement vertex " +
        std::to_string(count) +
        "\nproperty double x\nproperty double y\nproperty double z\nproperty float sigma\nend_header\n");
}

void CloudWriter::write(const std::string& bytes) {
  file_.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!file_) throw CloudError(path_ + " cannot be written: is the disk full?");
}

void CloudWriter::add(const Eigen::Vector3d& point, float sigma) {
  ++written_;
  std::string bytes;
  if (format_ == CloudFormat::ply) {
    bytes.resize(3 * sizeof(double) + sizeof(float));
    for (Eigen::Index axis = 0; axis < 3; ++axis) put(bytes, 8 * static_cast<size_t>(axis), point(axis));
    put(bytes, 24, sigma);
    return write(bytes);
  }
  bytes.resize(kPoint);
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double steps = std::round((point(axis) - offset_(axis)) / kStep);
    if (!(std::abs(steps) < 2e9))
      throw CloudError(path_ + ": the point " + std::to_string(written_) + " lies at " + std::to_string(point(axis)) +
                       " m, too far from " + std::to_string(offset_(axis)) + " m for LAS; write PLY instead");
    put(bytes, 4 * static_cast<size_t>(axis), static_cast<std::int32_t>(steps));
    const double kept = offset_(axis) + kStep * steps;
    low_(axis) = std::min(low_(axis), kept), high_(axis) = std::max(high_(axis), kept);
  }
  bytes[14] = 0x11;  // the first of one return
  put(bytes, 30, sigma);
  write(bytes);
}

void CloudWriter::finish() {
  if (written_ != announced_)
    throw CloudError(path_ + ": " + std::to_string(written_) + " points came, " + std::to_string(announced_) +
                     " were announced");
  if (format_ == CloudFormat::las) {
    file_.seekp(0);
    write(las_header(written_, offset_, low_, high_, kHeader + records(frame_).size()));
  }
  file_.close();
  if (!file_) throw CloudError(path_ + " cannot be written: is the disk full?");
}

}  // namespace plumbline::cloud

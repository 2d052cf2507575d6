// A file of points while it is read, and the points on their way out. For the readers of this folder.
#pragma once

#include <bit>
#include <cmath>
#include <cstring>
#include <fstream>
#include <string_view>

#include "surface/cloud/cloud_file.hpp"

namespace plumbline::cloud {

static_assert(std::endian::native == std::endian::little, "binary files are read as they lie in memory");

class CloudStream {
 public:
  /// Throws CloudError if there is no such file or it has nothing in it.
  explicit CloudStream(const std::string& path);

  std::uint64_t size() const { return size_; }
  std::uint64_t position() const { return position_; }
  std::uint64_t left() const { return size_ - position_; }
  void seek(std::uint64_t position);  ///< at most the size
  /// Reads exactly so many bytes; throws CloudError with the place and `what` was to come.
  void read(char* to, std::uint64_t bytes, const char* what);
  /// A line without its end; false at the end of the file. Throws CloudError for one of more than 1 MiB.
  bool line(std::string& to);
  std::uint64_t line_number() const { return line_; }

  [[noreturn]] void fail_at_byte(std::uint64_t byte, const std::string& what) const;
  [[noreturn]] void fail_at_line(const std::string& what) const;
  [[noreturn]] void fail(const std::string& what) const;

 private:
  std::string name_;
  std::ifstream stream_;
  std::vector<char> buffer_;  ///< of a line
  std::uint64_t size_ = 0, position_ = 0, line_ = 0;
};

/// Collects points and hands them on in pieces, each of one scan.
class PointBatch {
 public:
  PointBatch(CloudSummary& summary, const CloudStream& stream, const PointSink& sink)
      : summary_(summary), stream_(stream), sink_(sink) {}
  void add(const Eigen::Vector3d& point, std::size_t scan = 0) {
    if (!point.allFinite()) {
      ++summary_.without_place;
      return;
    }
    summary_.low = summary_.low.cwiseMin(point), summary_.high = summary_.high.cwiseMax(point);
    scan = std::min(scan, kMostScans - 1);
    if (scan >= points_.size()) points_.resize(scan + 1);
    points_[scan].push_back(point);
    if (++waiting_ == 65536) flush();
  }
  void flush() {
    const double done = static_cast<double>(stream_.position()) / static_cast<double>(stream_.size());
    for (std::size_t scan = 0; scan < points_.size(); ++scan) {
      if (points_[scan].empty()) continue;
      sink_(points_[scan], done, static_cast<int>(scan));
      summary_.points += points_[scan].size();
      points_[scan].clear();
    }
    waiting_ = 0;
  }

 private:
  static constexpr std::size_t kMostScans = 256;
  CloudSummary& summary_;
  const CloudStream& stream_;
  const PointSink& sink_;
  std::vector<std::vector<Eigen::Vector3d>> points_;  ///< by scan
  std::size_t waiting_ = 0;
};

/// What a number with decimals can tell apart: 0.01 of "12.50" and "1.25e1"; 1 of "12".
double step_of_text(std::string_view word);

/// Finds the steps that coordinates are written in. A program that keeps 32-bit floats writes their steps out as text
/// and as doubles too: values that are all floats are taken for such.
class Steps {
 public:
  /// `step`: of the way the number is written; 0: a double.
  void take(Eigen::Index axis, double value, double step) {
    if (!std::isfinite(value)) return;
    finest_(axis) = std::min(finest_(axis), step);
    largest_(axis) = std::max(largest_(axis), std::abs(value));
    const double off = std::abs(static_cast<double>(static_cast<float>(value)) - value);
    floats_[axis] = floats_[axis] && off <= 0.5000001 * step;
    if (!(first_(axis) == value)) several_[axis] = several_[axis] || std::isfinite(first_(axis));
    if (!std::isfinite(first_(axis))) first_(axis) = value;
  }
  void declare_float(Eigen::Index axis) { declared_[axis] = true; }
  Eigen::Vector3d found() const;

 private:
  Eigen::Vector3d finest_ = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity()),
                  largest_ = Eigen::Vector3d::Zero(),
                  first_ = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  bool floats_[3] = {true, true, true}, several_[3] = {}, declared_[3] = {};
};

/// The number whose bytes lie at `from`, of either byte order.
template <typename T>
T number_at(const char* from, bool big_endian = false) {
  char bytes[sizeof(T)];
  for (size_t i = 0; i < sizeof(T); ++i) bytes[i] = from[big_endian ? sizeof(T) - 1 - i : i];
  T value;
  std::memcpy(&value, bytes, sizeof(T));
  return value;
}

/// Readers: `sink` empty: only what the file says before its points.
CloudSummary read_ply(CloudStream& stream, const PointSink& sink);
CloudSummary read_las(CloudStream& stream, const PointSink& sink);
CloudSummary read_text(CloudStream& stream, const PointSink& sink);
CloudSummary read_e57(CloudStream& stream, const PointSink& sink);

/// Where the records of a LAS file lie that are no points.
struct LasRecords {
  std::uint64_t header_size = 0, points_at = 0, extended_at = 0;
  std::uint32_t count = 0, extended = 0;
};

/// Puts into `summary` what the records say of the unit. Throws CloudError for degrees, and for a height of another
/// unit than the plan.
void take_las_unit(CloudStream& stream, const LasRecords& records, CloudSummary& summary);

}  // namespace plumbline::cloud

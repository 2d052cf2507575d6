// LAS 1.0 to 1.4 (ASPRS, "LAS Specification 1.4 - R15"): header, point records of formats 0 to 10.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <limits>

#include "surface/cloud/cloud_stream.hpp"

namespace plumbline::cloud {
namespace {

/// Bytes of a record of formats 0 to 10 without extra bytes.
constexpr std::array<std::uint16_t, 11> kRecord = {20, 28, 26, 34, 57, 63, 30, 36, 38, 59, 67};

struct LasHeader {
  int minor = 0, format = 0;
  std::uint16_t header_size = 0, record = 0;
  LasRecords records;  ///< that are no points
  std::uint64_t points_at = 0, points = 0;
  Eigen::Vector3d scale, offset, low, high;  ///< low and high: of the points, as it says; some programs leave them at 0
  bool has_box() const {
    return low.allFinite() && high.allFinite() && (low.array() <= high.array()).all() &&
           !(low.isZero(0) && high.isZero(0));
  }
};

LasHeader read_header(CloudStream& stream) {
  constexpr std::uint64_t smallest = 227, of_1_4 = 375;
  char bytes[of_1_4] = {};
  stream.read(bytes, smallest, "the header of 227 bytes");
  LasHeader header;
  const int major = static_cast<unsigned char>(bytes[24]);
  header.minor = static_cast<unsigned char>(bytes[25]);
  if (major != 1 || header.minor > 4)
    stream.fail_at_byte(
        24, "LAS version " + std::to_string(major) + "." + std::to_string(header.minor) + ", expected 1.0 to 1.4");
  header.header_size = number_at<std::uint16_t>(bytes + 94);
  header.points_at = number_at<std::uint32_t>(bytes + 96);
  header.records.count = number_at<std::uint32_t>(bytes + 100);
  header.records.header_size = header.header_size, header.records.points_at = header.points_at;
  const int format = static_cast<unsigned char>(bytes[104]);
  if (format & 0xC0)
    stream.fail_at_byte(
        104, "the points are compressed (LAZ), which is not read; unpack them, for example with laszip or PDAL");
  header.format = format;
  if (header.format > 10) stream.fail_at_byte(104, "point format " + std::to_string(format) + ", expected 0 to 10");
  header.record = number_at<std::uint16_t>(bytes + 105);
  const std::uint16_t least = kRecord[static_cast<size_t>(header.format)];
  if (header.record < least)
    stream.fail_at_byte(105, "records of " + std::to_string(header.record) + " bytes, those of point format " +
                                 std::to_string(format) + " have at least " + std::to_string(least));
  header.points = number_at<std::uint32_t>(bytes + 107);
  for (int axis = 0; axis < 3; ++axis) {
    header.scale(axis) = number_at<double>(bytes + 131 + 8 * axis);
    header.offset(axis) = number_at<double>(bytes + 155 + 8 * axis);
    if (!std::isfinite(header.scale(axis)) || !(header.scale(axis) > 0))
      stream.fail_at_byte(
          131 + 8 * static_cast<std::uint64_t>(axis),
          "the scale of coordinates is " + std::to_string(header.scale(axis)) + ", expected more than 0");
    if (!std::isfinite(header.offset(axis)))
      stream.fail_at_byte(155 + 8 * static_cast<std::uint64_t>(axis), "the offset of coordinates is no number");
    header.high(axis) = number_at<double>(bytes + 179 + 16 * axis);
    header.low(axis) = number_at<double>(bytes + 187 + 16 * axis);
  }
  if (header.minor == 4 && header.header_size >= of_1_4) {
    stream.read(bytes + smallest, of_1_4 - smallest, "the header of 375 bytes");
    const auto points = number_at<std::uint64_t>(bytes + 247);
    if (header.points != 0 && points != 0 && points != header.points)
      stream.fail_at_byte(247,
                          std::to_string(points) + " points, but " + std::to_string(header.points) + " at byte 107");
    if (points != 0) header.points = points;
    header.records.extended_at = number_at<std::uint64_t>(bytes + 235);
    header.records.extended = number_at<std::uint32_t>(bytes + 243);
  }
  if (header.header_size < smallest || header.points_at < header.header_size || header.points_at > stream.size())
    stream.fail_at_byte(94, "a header of " + std::to_string(header.header_size) + " bytes and points from byte " +
                                std::to_string(header.points_at) + " on do not fit a file of " +
                                std::to_string(stream.size()));
  return header;
}

/// Whether the file itself says not to use a point: withheld, or classified as noise (7, 18).
bool is_withheld(const char* record, int format) {
  const auto byte = [record](int at) { return static_cast<unsigned char>(record[at]); };
  if (format <= 5) return (byte(15) & 0x80) || (byte(15) & 0x1F) == 7;
  return (byte(15) & 0x04) || byte(16) == 7 || byte(16) == 18;
}

/// Which of several scans in a file the point is of.
std::uint16_t source_of(const char* record, int format) {
  return number_at<std::uint16_t>(record + (format <= 5 ? 18 : 20));
}

/// Coordinates are whole numbers of 32 bits times a scale. One that is finer than the cloud is small makes them wrap,
/// or stop at the largest: points then lie somewhere else, and look as good as others.
class WholeNumbers {
 public:
  WholeNumbers(const LasHeader& header, const CloudStream& stream)
      : header_(header), stream_(stream), boxed_(header.has_box()) {
    // Boxes are rounded, or of the cloud before it was thinned out: a thousandth of it is no contradiction.
    slack_ = 2 * header.scale + Eigen::Vector3d::Constant(1e-3 * (header.high - header.low).norm()) +
             1e-9 * (header.low.cwiseAbs() + header.high.cwiseAbs());
  }

  void take(std::uint64_t number, const Eigen::Matrix<std::int64_t, 3, 1>& whole, const Eigen::Vector3d& point) {
    ++points_;
    for (int axis = 0; axis < 3; ++axis) {
      low_(axis) = std::min(low_(axis), whole(axis)), high_(axis) = std::max(high_(axis), whole(axis));
      at_limit_(axis) += whole(axis) == kLeast || whole(axis) == kMost;
    }
    // laspy 1 wrote the box in whole numbers, without scale and offset: no contradiction, if all points keep to that.
    const Eigen::Vector3d unscaled = whole.cast<double>();
    if (number == 0) in_whole_numbers_ = !in_box(point) && in_box(unscaled);
    if (!boxed_ || in_box(in_whole_numbers_ ? unscaled : point)) return;
    stream_.fail_at_byte(
        header_.points_at + number * header_.record,
        fmt::format("point {} lies at {}, outside of the box from {} to {} that the header gives (from "
                    "byte 179 on): the coordinates do not fit their 32 bits at a scale of {:g}, or the "
                    "header is that of other points; write the file again, at a scale such as 0.0001",
                    number + 1, place(point), place(header_.low), place(header_.high), header_.scale.minCoeff()));
  }

  /// When all points are read.
  void finish() const {
    for (int axis = 0; axis < 3; ++axis) {
      const double used = static_cast<double>(high_(axis) - low_(axis)) / 4294967296.0;
      const bool stopped = at_limit_(axis) >= 3 && at_limit_(axis) * 1000 > points_;
      if (points_ < 2 || (used < kAll && !stopped)) continue;
      stream_.fail_at_byte(
          131 + 8 * static_cast<std::uint64_t>(axis),
          fmt::format(
              "at a scale of {:g} the coordinates {} take {:.0f} % of what 32 bits hold, from {} to {}{}: those "
              "beyond have wrapped or stopped there, and lie elsewhere; write the file again, at a scale such as "
              "0.0001",
              header_.scale(axis), "xyz"[axis], 100 * used, low_(axis), high_(axis),
              stopped ? fmt::format(", and {} of {} points are at the end", at_limit_(axis), points_) : ""));
    }
  }

 private:
  static constexpr std::int64_t kLeast = std::numeric_limits<std::int32_t>::min(),
                                kMost = std::numeric_limits<std::int32_t>::max();
  static constexpr double kAll = 0.99;  // a program that takes the finest scale leaves half of it
  bool in_box(const Eigen::Vector3d& p) const {
    return ((p - header_.low).array() >= -slack_.array()).all() &&
           ((header_.high - p).array() >= -slack_.array()).all();
  }
  static std::string place(const Eigen::Vector3d& p) {
    return fmt::format("({:.3f}, {:.3f}, {:.3f})", p.x(), p.y(), p.z());
  }

  const LasHeader& header_;
  const CloudStream& stream_;
  bool boxed_, in_whole_numbers_ = false;
  Eigen::Vector3d slack_;
  std::uint64_t points_ = 0;
  Eigen::Matrix<std::int64_t, 3, 1> low_ = Eigen::Matrix<std::int64_t, 3, 1>::Constant(kMost),
                                    high_ = Eigen::Matrix<std::int64_t, 3, 1>::Constant(kLeast);
  Eigen::Matrix<std::uint64_t, 3, 1> at_limit_ = Eigen::Matrix<std::uint64_t, 3, 1>::Zero();
};

}  // namespace

CloudSummary read_las(CloudStream& stream, const PointSink& sink) {
  const LasHeader header = read_header(stream);
  CloudSummary summary;
  summary.format = "LAS 1." + std::to_string(header.minor) + ", point format " + std::to_string(header.format);
  if (header.points == 0) stream.fail_at_byte(107, "the file announces no points");
  const std::uint64_t room = (stream.size() - header.points_at) / header.record;
  if (header.points > room)
    stream.fail_at_byte(107, std::to_string(header.points) + " points of " + std::to_string(header.record) +
                                 " bytes from byte " + std::to_string(header.points_at) +
                                 " on are announced, the file of " + std::to_string(stream.size()) +
                                 " bytes has room for " + std::to_string(room) + "; it was cut short");
  take_las_unit(stream, header.records, summary);
  summary.resolution = header.scale;
  if (!sink) return summary;
  PointBatch batch(summary, stream, sink);
  WholeNumbers numbers(header, stream);
  stream.seek(header.points_at);
  const std::uint64_t at_a_time = std::max<std::uint64_t>(1, (1 << 20) / header.record);
  std::vector<char> bytes(at_a_time * header.record);
  std::vector<std::int32_t> scan_of(65536, -1);  // by point source id, in the order in which they come
  int scans = 0;
  for (std::uint64_t done = 0; done < header.points;) {
    const std::uint64_t count = std::min(at_a_time, header.points - done);
    stream.read(bytes.data(), count * header.record, "the points");
    for (std::uint64_t i = 0; i < count; ++i) {
      const char* record = bytes.data() + i * header.record;
      if (is_withheld(record, header.format)) {
        ++summary.withheld;
        continue;
      }
      std::int32_t& scan = scan_of[source_of(record, header.format)];
      if (scan < 0) scan = scans++;
      const Eigen::Matrix<std::int64_t, 3, 1> whole(
          number_at<std::int32_t>(record), number_at<std::int32_t>(record + 4), number_at<std::int32_t>(record + 8));
      const Eigen::Vector3d point = header.offset + header.scale.cwiseProduct(whole.cast<double>());
      numbers.take(done + i, whole, point);
      batch.add(point, static_cast<size_t>(scan));
    }
    done += count;
  }
  batch.flush();
  numbers.finish();
  summary.scans = std::max(1, scans);
  return summary;
}

}  // namespace plumbline::cloud

// LAS 1.0 to 1.4 (ASPRS, "LAS Specification 1.4 - R15"): header, point records of formats 0 to 10.
#include <algorithm>
#include <array>

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
  Eigen::Vector3d scale, offset;
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
      const Eigen::Vector3d whole(number_at<std::int32_t>(record), number_at<std::int32_t>(record + 4),
                                  number_at<std::int32_t>(record + 8));
      batch.add(header.offset + header.scale.cwiseProduct(whole), static_cast<size_t>(scan));
    }
    done += count;
  }
  batch.flush();
  summary.scans = std::max(1, scans);
  return summary;
}

}  // namespace plumbline::cloud

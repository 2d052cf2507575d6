// Bytes of E57 files as a scanner's program would write them: pages with checksums, an XML section, packets of bits.
// Shares nothing with the reader.
#pragma once

#include <Eigen/Core>
#include <bit>
#include <cmath>
#include <string>
#include <vector>

#include "cloud_bytes.hpp"

namespace plumbline::cloud_bytes {

/// CRC-32C bit by bit.
inline std::uint32_t slow_crc32c(const std::string& bytes) {
  std::uint32_t crc = 0xffffffff;
  for (const char c : bytes) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? crc >> 1 ^ 0x82f63b78u : crc >> 1;
  }
  return ~crc;
}

/// A place among contents as a place in the file.
inline std::uint64_t with_checksums(std::uint64_t place) { return place / 1020 * 1024 + place % 1020; }

struct E57ScanBytes {
  std::vector<Eigen::Vector3d> points = {};
  std::vector<int> invalid = {};  ///< one a point, or none
  std::string pose = {};          ///< XML
  /// "scaled": steps of 0.1 mm in 31 bits, so that nothing lies on whole bytes; "single", "double"; "spherical": range,
  /// azimuth, elevation as doubles.
  std::string kind = "scaled";
  size_t points_a_packet = 100;
  bool index = true;    ///< a packet before the data that readers step over
  long announced = -1;  ///< number of points; -1: as many as there are
};

class Bits {
 public:
  void add(std::uint64_t value, int bits) {
    for (int b = 0; b < bits; ++b, ++count_) {
      if (count_ % 8 == 0) bytes_ += '\0';
      if (value >> b & 1)
        bytes_.back() = static_cast<char>(static_cast<unsigned char>(bytes_.back()) | 1u << count_ % 8);
    }
  }
  /// Whole bytes that were not taken yet; all at the end.
  std::string take(bool end) {
    const size_t whole = end ? bytes_.size() : count_ / 8, from = taken_;
    taken_ = whole;
    return bytes_.substr(from, whole - from);
  }

 private:
  std::string bytes_;
  size_t count_ = 0, taken_ = 0;
};

inline std::string e57_section(const E57ScanBytes& scan) {
  constexpr int bits = 31;
  Bits stream[4];
  std::string packets;
  for (size_t i = 0; i < scan.points.size(); ++i) {
    Eigen::Vector3d p = scan.points[i];
    if (scan.kind == "spherical")
      p = Eigen::Vector3d(p.norm(), std::atan2(p.y(), p.x()), std::atan2(p.z(), std::hypot(p.x(), p.y())));
    for (int axis = 0; axis < 3; ++axis) {
      if (scan.kind == "scaled")
        stream[axis].add(static_cast<std::uint64_t>(std::llround((p(axis) - 100) / 1e-4) + 1000000000), bits);
      else if (scan.kind == "single")
        stream[axis].add(std::bit_cast<std::uint32_t>(static_cast<float>(p(axis))), 32);
      else
        stream[axis].add(std::bit_cast<std::uint64_t>(p(axis)), 64);
    }
    stream[3].add(static_cast<std::uint64_t>(scan.invalid.empty() ? 0 : scan.invalid[i]), 2);
    const bool end = i + 1 == scan.points.size();
    if (!end && (i + 1) % scan.points_a_packet != 0) continue;
    std::string lengths, content;
    for (Bits& one : stream) {
      const std::string some = one.take(end);
      lengths += bytes_of(static_cast<std::uint16_t>(some.size())), content += some;
    }
    std::string packet = std::string(4, '\0') + bytes_of(std::uint16_t{4}) + lengths + content;
    packet.resize((packet.size() + 3) / 4 * 4);
    packet[0] = 1;
    put(packet, 2, static_cast<std::uint16_t>(packet.size() - 1));
    if (packets.empty() && scan.index) {
      std::string index(16, '\0');
      put(index, 2, std::uint16_t{15});
      packets += index;
    }
    packets += packet;
  }
  std::string head(32, '\0');
  head[0] = 1;
  put(head, 8, static_cast<std::uint64_t>(32 + packets.size()));
  return head + packets;  // where the packets begin in the file is set by e57_file
}

/// `changes`: of the XML, old text and new.
inline std::string e57_file(const std::vector<E57ScanBytes>& scans,
                            const std::vector<std::pair<std::string, std::string>>& changes = {}) {
  std::string content(48, '\0'),
      xml =
          "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<e57Root type=\"Structure\" "
          "xmlns=\"http://www.astm.org/COMMIT/E57/2010-e57-v1.0\">\n<formatName type=\"String\"><![CDATA[ASTM E57 3D "
          "Imaging "
          "Data File]]></formatName>\n<guid type=\"String\"><![CDATA[{1}]]></guid>\n<versionMajor "
          "type=\"Integer\">1</versionMajor>\n<versionMinor type=\"Integer\">0</versionMinor>\n<data3D type=\"Vector\" "
          "allowHeterogeneousChildren=\"1\">\n";
  int number = 0;
  for (const E57ScanBytes& scan : scans) {
    const size_t at = content.size();
    content += e57_section(scan);
    put(content, at + 16, with_checksums(at + 32));
    const bool spherical = scan.kind == "spherical";
    ++number;
    const std::string type =
        scan.kind == "scaled"
            ? "\"ScaledInteger\" minimum=\"-1000000000\" maximum=\"1000000000\" scale=\"1.0e-4\" offset=\"100\""
        : scan.kind == "single" ? "\"Float\" precision=\"single\""
                                : "\"Float\"";
    xml += "<vectorChild type=\"Structure\"><guid type=\"String\"><![CDATA[{" + std::to_string(number) +
           "}]]></guid><name type=\"String\"><![CDATA[station " + std::to_string(number) + "]]></name>" + scan.pose +
           "<points type=\"CompressedVector\" fileOffset=\"" + std::to_string(with_checksums(at)) +
           "\" recordCount=\"" +
           std::to_string(scan.announced >= 0 ? scan.announced : static_cast<long>(scan.points.size())) +
           "\"><prototype type=\"Structure\">";
    for (const char* name : {"X", "Y", "Z"}) {
      const std::string of = *name == 'X' ? "Range" : *name == 'Y' ? "Azimuth" : "Elevation";
      const std::string field = spherical ? "spherical" + of : std::string("cartesian") + name;
      xml += "<" + field + " type=" + type + "/>";
    }
    xml += std::string(spherical ? "<sphericalInvalidState" : "<cartesianInvalidState") +
           " type=\"Integer\" minimum=\"0\" maximum=\"2\"/></prototype><codecs type=\"Vector\" "
           "allowHeterogeneousChildren=\"1\"></codecs></points></vectorChild>\n";
  }
  xml += "</data3D>\n<images2D type=\"Vector\" allowHeterogeneousChildren=\"1\"></images2D>\n</e57Root>\n";
  for (const auto& [from, to] : changes)
    for (size_t at = 0; (at = xml.find(from, at)) != std::string::npos; at += to.size())
      xml.replace(at, from.size(), to);
  const size_t xml_at = content.size();
  content += xml;
  content.resize((content.size() + 1019) / 1020 * 1020);
  content.replace(0, 8, "ASTM-E57");
  put(content, 8, std::uint32_t{1});
  put(content, 16, static_cast<std::uint64_t>(content.size() / 1020 * 1024));
  put(content, 24, with_checksums(xml_at)), put(content, 32, static_cast<std::uint64_t>(xml.size()));
  put(content, 40, std::uint64_t{1024});
  std::string file;
  for (size_t page = 0; page < content.size(); page += 1020)
    file += content.substr(page, 1020) + bytes_of(slow_crc32c(content.substr(page, 1020)), true);
  return file;
}

/// The same bytes with checksums that fit them again: what else than damage is wrong with a file.
inline std::string with_new_checksums(std::string file) {
  for (size_t page = 0; page + 1024 <= file.size(); page += 1024)
    file.replace(page + 1020, 4, bytes_of(slow_crc32c(file.substr(page, 1020)), true));
  return file;
}

}  // namespace plumbline::cloud_bytes

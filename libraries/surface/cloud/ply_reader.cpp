#include <algorithm>
#include <array>
#include <charconv>

#include "base/text/text.hpp"
#include "surface/cloud/ply_header.hpp"

namespace plumbline::cloud {
namespace {

double value_at(const char* from, PlyType type, bool big) {
  switch (type) {
    case PlyType::int8:
      return number_at<std::int8_t>(from, big);
    case PlyType::uint8:
      return number_at<std::uint8_t>(from, big);
    case PlyType::int16:
      return number_at<std::int16_t>(from, big);
    case PlyType::uint16:
      return number_at<std::uint16_t>(from, big);
    case PlyType::int32:
      return number_at<std::int32_t>(from, big);
    case PlyType::uint32:
      return number_at<std::uint32_t>(from, big);
    case PlyType::float32:
      return static_cast<double>(number_at<float>(from, big));
    case PlyType::float64:
      return number_at<double>(from, big);
  }
  return 0;
}

/// Passes one element with lists, row by row.
void skip_row(CloudStream& stream, const PlyElement& element, bool big) {
  for (const PlyProperty& property : element.properties) {
    if (!property.is_list) {
      stream.seek(stream.position() + static_cast<std::uint64_t>(bytes_of(property.type)));
      continue;
    }
    char bytes[8];
    stream.read(bytes, static_cast<std::uint64_t>(bytes_of(property.count_type)), "the length of a list");
    const double count = value_at(bytes, property.count_type, big);
    const double length = count * bytes_of(property.type);
    if (count < 0 || length > static_cast<double>(stream.left()))
      stream.fail_at_byte(stream.position(), "a list of " + text::format_shortest(count) +
                                                 " items does not fit into the file; it was cut short");
    stream.seek(stream.position() + static_cast<std::uint64_t>(length));
  }
}

/// Places of x, y and z among the vertex's properties; throws if one is missing.
std::array<size_t, 3> coordinates_of(const CloudStream& stream, const PlyElement& vertex) {
  std::array<size_t, 3> at{};
  const char* names[] = {"x", "y", "z"};
  for (size_t axis = 0; axis < 3; ++axis) {
    const auto found = std::find_if(vertex.properties.begin(), vertex.properties.end(),
                                    [&](const PlyProperty& p) { return !p.is_list && p.name == names[axis]; });
    if (found == vertex.properties.end())
      stream.fail("the element 'vertex' has no property '" + std::string(names[axis]) + "'");
    at[axis] = static_cast<size_t>(found - vertex.properties.begin());
  }
  return at;
}

void read_binary(CloudStream& stream, const PlyElement& vertex, bool big, PointBatch& batch, Steps& steps) {
  const auto coordinates = coordinates_of(stream, vertex);
  std::array<double, 3> step{};  // whole numbers have one of 1
  for (size_t axis = 0; axis < 3; ++axis) {
    const PlyType type = vertex.properties[coordinates[axis]].type;
    if (type == PlyType::float32) steps.declare_float(static_cast<Eigen::Index>(axis));
    step[axis] = type == PlyType::float32 || type == PlyType::float64 ? 0 : 1;
  }
  std::array<std::uint64_t, 3> offset{};
  for (size_t axis = 0; axis < 3; ++axis)
    for (size_t p = 0; p < coordinates[axis]; ++p)
      offset[axis] += static_cast<std::uint64_t>(bytes_of(vertex.properties[p].type));
  const std::uint64_t row = vertex.row(), room = stream.left() / row;
  if (vertex.count > room)
    stream.fail_at_byte(stream.position(), std::to_string(vertex.count) + " vertices of " + std::to_string(row) +
                                               " bytes are announced, the file of " + std::to_string(stream.size()) +
                                               " bytes has room for " + std::to_string(room) + "; it was cut short");
  const std::uint64_t at_a_time = std::max<std::uint64_t>(1, (1 << 20) / row);
  std::vector<char> bytes(std::min(at_a_time, vertex.count) * row);
  for (std::uint64_t done = 0; done < vertex.count;) {
    const std::uint64_t count = std::min(at_a_time, vertex.count - done);
    stream.read(bytes.data(), count * row, "the vertices");
    for (std::uint64_t i = 0; i < count; ++i) {
      Eigen::Vector3d point;
      for (int axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<size_t>(axis);
        point(axis) = value_at(bytes.data() + i * row + offset[a], vertex.properties[coordinates[a]].type, big);
        steps.take(axis, point(axis), step[a]);
      }
      batch.add(point);
    }
    done += count;
  }
}

/// One number of a text file; NaN and infinity are numbers here: a point without place.
double text_value(const CloudStream& stream, std::string_view word) {
  double value = 0;
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size())
    stream.fail_at_line("found " + text::quoted(word) + ", expected a number");
  return value;
}

void read_lines(CloudStream& stream, const PlyElement& vertex, PointBatch& batch, Steps& steps) {
  const auto coordinates = coordinates_of(stream, vertex);
  std::string line;
  for (std::uint64_t i = 0; i < vertex.count; ++i) {
    if (!stream.line(line))
      stream.fail_at_line(std::to_string(vertex.count) + " vertices are announced, the file ends after " +
                          std::to_string(i) + "; it was cut short");
    const auto words = text::split_blanks(line);
    if (words.size() < vertex.properties.size())
      stream.fail_at_line("a vertex with " + std::to_string(words.size()) + " values, expected " +
                          std::to_string(vertex.properties.size()));
    Eigen::Vector3d point;
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = words[coordinates[axis]];
      point(axis) = text_value(stream, word);
      steps.take(axis, point(axis), step_of_text(word));
    }
    batch.add(point);
  }
}

}  // namespace

CloudSummary read_ply(CloudStream& stream, const PointSink& sink) {
  const PlyHeader header = read_ply_header(stream);
  CloudSummary summary;
  const bool text = header.layout == PlyHeader::Layout::text, big = header.layout == PlyHeader::Layout::big_endian;
  summary.format = text ? "PLY, text" : big ? "PLY, binary, big endian" : "PLY, binary, little endian";
  summary.unit = header.unit, summary.either_foot = header.either_foot;
  const auto is_vertex = [](const PlyElement& element) { return element.name == "vertex"; };
  const auto vertex = std::find_if(header.elements.begin(), header.elements.end(), is_vertex);
  if (vertex == header.elements.end()) stream.fail("the header has no element 'vertex': there are no points");
  if (vertex->has_list()) stream.fail("the vertices have properties that are lists, which are not read");
  if (vertex->count == 0) stream.fail("the file announces no points: 'element vertex 0'");
  coordinates_of(stream, *vertex);
  if (!sink) return summary;
  PointBatch batch(summary, stream, sink);
  std::string line;
  for (auto element = header.elements.begin(); element != vertex; ++element) {
    if (!text && !element->has_list()) {
      if (element->row() > 0 && element->count > stream.left() / element->row())
        stream.fail_at_byte(stream.position(),
                            "the element '" + element->name + "' does not fit into the file; it was cut short");
      stream.seek(stream.position() + element->count * element->row());
      continue;
    }
    for (std::uint64_t i = 0; i < element->count; ++i) {
      if (stream.left() == 0)
        stream.fail_at_byte(stream.position(),
                            "the file ends within the element '" + element->name + "'; it was cut short");
      if (text)
        stream.line(line);
      else
        skip_row(stream, *element, big);
    }
  }
  Steps steps;
  if (text)
    read_lines(stream, *vertex, batch, steps);
  else
    read_binary(stream, *vertex, big, batch, steps);
  batch.flush();
  summary.resolution = steps.found();
  return summary;
}

}  // namespace plumbline::cloud

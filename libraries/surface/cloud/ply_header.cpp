#include "surface/cloud/ply_header.hpp"

#include <algorithm>
#include <optional>

#include "base/text/text.hpp"
#include "surface/cloud/unit_names.hpp"

namespace plumbline::cloud {
namespace {

using Words = std::vector<std::string_view>;

std::optional<PlyType> type_of(std::string_view name) {
  static const std::pair<std::string_view, PlyType> names[] = {
      {"char", PlyType::int8},      {"int8", PlyType::int8},       {"uchar", PlyType::uint8},
      {"uint8", PlyType::uint8},    {"short", PlyType::int16},     {"int16", PlyType::int16},
      {"ushort", PlyType::uint16},  {"uint16", PlyType::uint16},   {"int", PlyType::int32},
      {"int32", PlyType::int32},    {"uint", PlyType::uint32},     {"uint32", PlyType::uint32},
      {"float", PlyType::float32},  {"float32", PlyType::float32}, {"double", PlyType::float64},
      {"float64", PlyType::float64}};
  for (const auto& [known, type] : names)
    if (name == known) return type;
  return std::nullopt;
}

PlyType type_or_fail(const CloudStream& stream, std::string_view name) {
  const auto type = type_of(name);
  if (!type)
    stream.fail_at_line("type " + text::quoted(name) +
                        ", expected char, uchar, short, ushort, int, uint, float or double");
  return *type;
}

/// "comment unit: mm", "comment units metres".
double unit_of(const Words& words) {
  if (words.size() != 3 || !text::to_lower(std::string(words[1])).starts_with("unit"))
    return std::numeric_limits<double>::quiet_NaN();
  return unit_named(text::to_lower(std::string(words[2])));
}

void take_element(const CloudStream& stream, const Words& words, PlyHeader& header) {
  const auto count = words.size() == 3 ? text::parse_integer(words[2]) : std::nullopt;
  if (!count || *count < 0) stream.fail_at_line("expected 'element NAME COUNT'");
  header.elements.push_back({std::string(words[1]), static_cast<std::uint64_t>(*count), {}});
}

void take_property(const CloudStream& stream, const Words& words, PlyHeader& header) {
  if (header.elements.empty()) stream.fail_at_line("a property before any element");
  PlyProperty property;
  if (words.size() == 5 && words[1] == "list") {
    property.is_list = true;
    property.count_type = type_or_fail(stream, words[2]), property.type = type_or_fail(stream, words[3]);
    if (property.count_type == PlyType::float32 || property.count_type == PlyType::float64)
      stream.fail_at_line("the length of a list is of type " + text::quoted(words[2]) + ", expected a whole number");
  } else if (words.size() == 3) {
    property.type = type_or_fail(stream, words[1]);
  } else {
    stream.fail_at_line("expected 'property TYPE NAME' or 'property list TYPE TYPE NAME'");
  }
  property.name = std::string(words.back());
  header.elements.back().properties.push_back(property);
}

}  // namespace

int bytes_of(PlyType type) {
  switch (type) {
    case PlyType::int8:
    case PlyType::uint8:
      return 1;
    case PlyType::int16:
    case PlyType::uint16:
      return 2;
    case PlyType::int32:
    case PlyType::uint32:
    case PlyType::float32:
      return 4;
    case PlyType::float64:
      return 8;
  }
  return 0;
}

bool PlyElement::has_list() const {
  return std::any_of(properties.begin(), properties.end(), [](const PlyProperty& p) { return p.is_list; });
}

std::uint64_t PlyElement::row() const {
  std::uint64_t bytes = 0;
  for (const PlyProperty& property : properties)
    bytes += property.is_list ? 0 : static_cast<std::uint64_t>(bytes_of(property.type));
  return bytes;
}

PlyHeader read_ply_header(CloudStream& stream) {
  constexpr std::uint64_t longest = 1 << 16;
  PlyHeader header;
  bool has_format = false;
  std::string line;
  stream.line(line);  // "ply"
  while (true) {
    if (!stream.line(line)) stream.fail_at_line("the file ends within its header; expected 'end_header'");
    if (stream.position() > longest) stream.fail_at_line("no 'end_header' within 64 KiB");
    const Words words = text::split_blanks(line);
    if (words.empty()) continue;
    if (words[0] == "end_header") break;
    if (words[0] == "comment" || words[0] == "obj_info") {
      if (const double unit = unit_of(words); unit > 0)
        header.unit = unit, header.either_foot = says_feet(text::to_lower(std::string(words[2])));
    } else if (words[0] == "format" && words.size() == 3) {
      has_format = true;
      if (words[1] == "ascii")
        header.layout = PlyHeader::Layout::text;
      else if (words[1] == "binary_little_endian")
        header.layout = PlyHeader::Layout::little_endian;
      else if (words[1] == "binary_big_endian")
        header.layout = PlyHeader::Layout::big_endian;
      else
        stream.fail_at_line("format " + text::quoted(words[1]) +
                            ", expected ascii, binary_little_endian or binary_big_endian");
    } else if (words[0] == "element") {
      take_element(stream, words, header);
    } else if (words[0] == "property") {
      take_property(stream, words, header);
    } else {
      stream.fail_at_line("found " + text::quoted(line) +
                          ", expected format, element, property, comment or end_header");
    }
  }
  if (!has_format) stream.fail_at_line("the header has no 'format' line");
  return header;
}

}  // namespace plumbline::cloud

// ASTM E2807-11 (2019), section 8: the elements of data3D.
#include "surface/cloud/e57_scans.hpp"

#include <bit>
#include <charconv>
#include <pugixml.hpp>

#include "base/text/text.hpp"

namespace plumbline::cloud {
namespace {

/// One scan of the section while it is read.
class ScanReader {
 public:
  ScanReader(pugi::xml_node node, size_t number, const CloudStream& stream) : node_(node), stream_(stream) {
    scan_.name = node.child("name").text().as_string();
    where_ = "scan " + std::to_string(number) + (scan_.name.empty() ? "" : " ('" + scan_.name + "')") + ": ";
  }

  E57Scan read() {
    const pugi::xml_node points = node_.child("points");
    if (std::string_view(points.attribute("type").value()) != "CompressedVector")
      fail("it has no 'points' of the type CompressedVector");
    // Both are required; a scan without them would be one of no points.
    for (const char* name : {"fileOffset", "recordCount"})
      if (!points.attribute(name)) fail("its 'points' have no " + std::string(name));
    scan_.points_at = whole(points, "fileOffset", 0), scan_.points = whole(points, "recordCount", 0);
    for (const pugi::xml_node codec : points.child("codecs").children())
      if (codec.type() == pugi::node_element && !codec.child("bitPackCodec"))
        fail("its points are packed by a codec of its own, expected that of the standard");
    for (const pugi::xml_node field : points.child("prototype").children())
      if (field.type() == pugi::node_element) scan_.fields.push_back(field_of(field));
    find_coordinates();
    check_count();
    take_pose();
    return std::move(scan_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const { stream_.fail(where_ + what); }

  template <typename T>
  T number(const std::string& text, const std::string& what) const {
    T value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size()) fail(what + " is '" + text + "', expected a number");
    return value;
  }
  std::uint64_t whole(pugi::xml_node node, const char* name, std::uint64_t without) const {
    const pugi::xml_attribute attribute = node.attribute(name);
    return attribute ? number<std::uint64_t>(attribute.value(), std::string(name) + " of '" + node.name() + "'")
                     : without;
  }
  template <typename T>
  T value_of(pugi::xml_node field, const char* name, T without) const {
    const pugi::xml_attribute attribute = field.attribute(name);
    return attribute ? number<T>(attribute.value(), std::string(name) + " of '" + field.name() + "'") : without;
  }

  E57Field field_of(pugi::xml_node node) const {
    E57Field field;
    field.name = node.name();
    const std::string type = node.attribute("type").value();
    if (type == "String") {
      field.kind = E57Field::Kind::text;
    } else if (type == "Float") {
      const bool single = std::string_view(node.attribute("precision").value()) == "single";
      field.kind = single ? E57Field::Kind::single_float : E57Field::Kind::double_float;
      field.bits = single ? 32 : 64;
    } else if (type == "Integer" || type == "ScaledInteger") {
      using Limits = std::numeric_limits<std::int64_t>;
      field.minimum = value_of<std::int64_t>(node, "minimum", Limits::min());
      const auto maximum = value_of<std::int64_t>(node, "maximum", Limits::max());
      if (maximum < field.minimum) fail("'" + field.name + "' has a maximum below its minimum");
      const std::uint64_t span = static_cast<std::uint64_t>(maximum) - static_cast<std::uint64_t>(field.minimum);
      field.bits = static_cast<int>(std::bit_width(span));
      if (type == "ScaledInteger")
        field.scale = value_of<double>(node, "scale", 1), field.offset = value_of<double>(node, "offset", 0);
      if (!std::isfinite(field.scale) || field.scale == 0 || !std::isfinite(field.offset))
        fail("'" + field.name + "' has a scale of " + std::to_string(field.scale) + " and an offset of " +
             std::to_string(field.offset));
    } else {
      fail("'" + field.name + "' of a point is of the type '" + type +
           "', expected Integer, ScaledInteger, Float or String");
    }
    return field;
  }

  int number_of(std::string_view name) const {
    for (size_t f = 0; f < scan_.fields.size(); ++f)
      if (scan_.fields[f].name == name && scan_.fields[f].kind != E57Field::Kind::text) return static_cast<int>(f);
    return -1;
  }

  void find_coordinates() {
    const char* names[2][4] = {{"cartesianX", "cartesianY", "cartesianZ", "cartesianInvalidState"},
                               {"sphericalRange", "sphericalAzimuth", "sphericalElevation", "sphericalInvalidState"}};
    for (int spherical : {0, 1}) {
      for (int i = 0; i < 3; ++i) scan_.coordinates[i] = number_of(names[spherical][i]);
      scan_.invalid = number_of(names[spherical][3]), scan_.spherical = spherical == 1;
      if (scan_.coordinates[0] >= 0 && scan_.coordinates[1] >= 0 && scan_.coordinates[2] >= 0) return;
    }
    fail("its points have neither cartesianX, Y and Z nor sphericalRange, Azimuth and Elevation");
  }

  /// A count that nothing stands behind is refused before anything is made of it.
  void check_count() const {
    std::uint64_t bits = 0;
    for (const E57Field& field : scan_.fields) bits += static_cast<std::uint64_t>(field.bits);
    const std::uint64_t room = bits == 0 ? 1 : 8 * stream_.size() / bits;
    if (scan_.points > room)
      fail(std::to_string(scan_.points) + " points of " + std::to_string(bits) + " bits are announced, the file has " +
           std::to_string(stream_.size()) + " bytes");
  }

  void take_pose() {
    const pugi::xml_node pose = node_.child("pose");
    scan_.has_pose = !pose.empty();
    const auto part = [&](const char* of, const char* name, double without) {
      const std::string text = std::string(text::trim(pose.child(of).child(name).text().as_string()));
      return text.empty() ? without : number<double>(text, std::string("pose/") + of + "/" + name);
    };
    if (pose.child("rotation")) {  // an element without content is 0, as everywhere in the standard
      const Eigen::Quaterniond rotation(part("rotation", "w", 0), part("rotation", "x", 0), part("rotation", "y", 0),
                                        part("rotation", "z", 0));
      if (!(std::abs(rotation.norm() - 1) < 1e-3))
        fail("the rotation of its pose is a quaternion of length " + std::to_string(rotation.norm()) + ", expected 1");
      scan_.rotation = rotation.normalized();
    }
    scan_.translation << part("translation", "x", 0), part("translation", "y", 0), part("translation", "z", 0);
    if (!scan_.translation.allFinite()) fail("the translation of its pose is not finite");
  }

  pugi::xml_node node_;
  const CloudStream& stream_;
  std::string where_;
  E57Scan scan_;
};

}  // namespace

std::vector<E57Scan> e57_scans(const std::string& xml, const CloudStream& stream) {
  pugi::xml_document document;
  const pugi::xml_parse_result parsed = document.load_buffer(xml.data(), xml.size());
  if (!parsed)
    stream.fail("the XML section does not parse: " + std::string(parsed.description()) + " at its byte " +
                std::to_string(parsed.offset));
  const pugi::xml_node root = document.child("e57Root");
  if (!root) stream.fail("the XML section has no element 'e57Root'");
  std::vector<E57Scan> scans;
  for (const pugi::xml_node node : root.child("data3D").children())
    if (node.type() == pugi::node_element) scans.push_back(ScanReader(node, scans.size() + 1, stream).read());
  return scans;
}

}  // namespace plumbline::cloud

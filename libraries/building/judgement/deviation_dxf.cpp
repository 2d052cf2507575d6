#include "building/judgement/deviation_dxf.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <map>
#include <set>

#include "building/ifc/facade_artifact.hpp"
#include "building/judgement/facade_order.hpp"

namespace plumbline::judgement {
namespace {

constexpr double kTextHeight = 0.06;  // [m]

const char* word(ToleranceVerdict verdict) {
  static constexpr std::array<const char*, 4> words = {"NOT_MEASURED", "PASS", "UNDECIDED", "FAIL"};
  return words[static_cast<size_t>(verdict)];
}

/// Green, yellow, red, grey of AutoCAD's index.
int colour_of(const std::string& layer) {
  const std::size_t behind = layer.find('_');  // "ANCHOR_FAIL_A_180": the verdict stands before the facade
  const auto is = [&](const std::string& verdict) {
    return behind != std::string::npos && (layer.substr(behind + 1) + "_").starts_with(verdict + "_");
  };
  if (layer.starts_with("DEVIATION")) return 5;
  return is("PASS") ? 3 : is("UNDECIDED") ? 2 : is("FAIL") ? 1 : 8;
}

/// A group of a DXF is a line: what would end it is left out, what is not ASCII is escaped.
std::string one_line(const std::string& utf8) {
  std::string text;
  for (std::size_t i = 0; i < utf8.size();) {
    const auto first = static_cast<unsigned char>(utf8[i]);
    const std::size_t length = first < 0x80 ? 1 : first < 0xe0 ? 2 : first < 0xf0 ? 3 : 4;
    unsigned long code = length == 1 ? first : first & (0xffu >> (length + 1));
    bool valid = first < 0x80 || (first >= 0xc2 && first < 0xf5 && i + length <= utf8.size());
    for (std::size_t k = 1; valid && k < length; ++k) {
      const auto next = static_cast<unsigned char>(utf8[i + k]);
      valid = (next & 0xc0) == 0x80, code = code << 6 | (next & 0x3fu);
    }
    if (!valid || code > 0xffff) {
      text += "?", i += valid ? length : 1;
      continue;
    }
    i += length;
    if (code < 0x20 || code == 0x7f) continue;
    text += code < 0x80 ? std::string(1, static_cast<char>(code)) : fmt::format("\\U+{:04X}", code);
  }
  return text;
}

class Drawing {
 public:
  void point(const std::string& layer, const Eigen::Vector3d& at) { entity("POINT", layer), place(10, at); }

  void line(const std::string& layer, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
    entity("LINE", layer), place(10, from), place(11, to);
  }

  /// Upright on the facade: its place is told in the axes that DXF derives from the facade's direction, which for one
  /// that stands upright are right and up.
  void text(const std::string& layer, const Eigen::Vector3d& at, const ifc::FacadeFrame& frame,
            const std::string& words) {
    entity("TEXT", layer);
    const bool upright = frame.known() && std::abs(frame.out.z()) < 1e-9;
    const Eigen::Vector3d own(frame.right.dot(at), frame.up.dot(at), frame.out.dot(at));
    place(10, upright ? own : at);
    number(40, kTextHeight), group(1, one_line(words));
    if (upright) place(210, frame.out);
  }

  void outline(const std::string& layer, const std::array<Eigen::Vector3d, 4>& corners) {
    entity("POLYLINE", layer), group(66, "1"), place(10, Eigen::Vector3d::Zero()), group(70, "9");
    for (const Eigen::Vector3d& corner : corners) entity("VERTEX", layer), place(10, corner), group(70, "32");
    entity("SEQEND", layer);
  }

  std::string finish() const {
    std::string text =
        "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n0\nENDSEC\n0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLAYER\n70\n" +
        std::to_string(layers_.size()) + "\n";
    for (const std::string& layer : layers_)
      text += "0\nLAYER\n2\n" + layer + "\n70\n0\n62\n" + std::to_string(colour_of(layer)) + "\n6\nCONTINUOUS\n";
    return text + "0\nENDTAB\n0\nENDSEC\n0\nSECTION\n2\nENTITIES\n" + entities_ + "0\nENDSEC\n0\nEOF\n";
  }

 private:
  void group(int code, const std::string& value) { entities_ += std::to_string(code) + "\n" + value + "\n"; }
  void number(int code, double value) { group(code, fmt::format("{:.6f}", value)); }
  void place(int code, const Eigen::Vector3d& p) {
    for (int k = 0; k < 3; ++k) number(code + 10 * k, p[k]);
  }
  void entity(const char* kind, const std::string& layer) {
    layers_.insert(layer);
    group(0, kind), group(8, layer);
  }

  std::string entities_;
  std::set<std::string> layers_;
};

std::string deviation_words(const AnchorDeviationT& anchor, const ifc::FacadeFrame& frame) {
  if (!anchor.deviation.allFinite()) return anchor.id + " not measured";
  const Eigen::Vector3d& d = anchor.deviation;
  const bool known = frame.known() && frame.confirmed;
  return anchor.id + (known ? fmt::format(" right {:+.1f} up {:+.1f} out {:+.1f} mm", 1e3 * frame.right.dot(d),
                                          1e3 * frame.up.dot(d), 1e3 * frame.out.dot(d))
                            : fmt::format(" x {:+.1f} y {:+.1f} z {:+.1f} mm", 1e3 * d.x(), 1e3 * d.y(), 1e3 * d.z()));
}

}  // namespace

std::string deviation_dxf(const DeviationT& deviation, double exaggeration) {
  Drawing drawing;
  // Whoever measures a line in the drawing has to see it: DXF has no other place that every program shows.
  const std::string layer_of_deviations = fmt::format("DEVIATION_{:g}_TIMES_AS_LONG", exaggeration);
  const std::map<std::string, std::string> codes = facade_codes(deviation);
  const auto of_facade = [&](const std::unique_ptr<FacadeFrameT>& frame) {
    const auto code = codes.find(facade_name(frame));
    return code == codes.end() ? std::string() : "_" + code->second;
  };
  for (const auto& anchor : deviation.anchors) {
    if (!anchor->design.allFinite()) continue;
    const std::string layer = std::string("ANCHOR_") + word(anchor->verdict) + of_facade(anchor->facade);
    const ifc::FacadeFrame frame = ifc::frame_or_none(anchor->facade);
    drawing.point(layer, anchor->design);
    drawing.text(layer, anchor->design, frame, deviation_words(*anchor, frame));
    if (anchor->deviation.allFinite())
      drawing.line(layer_of_deviations, anchor->design, anchor->design + exaggeration * anchor->deviation);
  }
  for (const auto& panel : deviation.panels) {
    if (panel->corners.size() != 4) continue;
    const auto at = [&](const char* name) {
      for (const auto& corner : panel->corners)
        if (corner->name == name) return Eigen::Vector3d(corner->design);
      return Eigen::Vector3d(panel->corners[0]->design);
    };
    drawing.outline(std::string("PANEL_") + word(panel->verdict) + of_facade(panel->facade),
                    {at("bottom_left"), at("bottom_right"), at("top_right"), at("top_left")});
  }
  return drawing.finish();
}

}  // namespace plumbline::judgement

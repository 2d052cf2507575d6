// One identity: which element of the design every anchor of the campaign is. Decided once, before anything is measured
// against it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "building/ifc/design.hpp"
#include "building/ifc/selection.hpp"

namespace plumbline::ifc {

/// A line of the mapping table: name of a point, and what its element is called in the design.
struct MappingRow {
  std::string point, element;
  int line = 0;
};

/// Where the surveyed target of a class of elements is, seen from their reference point [m]: in the facade's axes
/// (outward, to the right as one looks at it, up) or in the element's own.
struct TargetOffset {
  Selection selection;
  double out = 0, right = 0, up = 0;
  Eigen::Vector3d own = Eigen::Vector3d::Zero();
  std::string text;
};

/// Which point of a class of elements the reference point is, where the reader's rule is not what the plan means.
struct ReferencePoint {
  Selection selection;
  std::string rule;  ///< placement, middle (centre of its box) or head (centre of the outward face of its box)
  std::string text;
};

/// "class=IfcMechanicalFastener: out=40mm, up=-5mm" (keys out, right, up, or x, y, z of the element's axes). Throws
/// std::runtime_error that quotes the text and says what is expected.
TargetOffset parse_offset(const std::string& text);
/// "class=IfcMechanicalFastener: head". Throws likewise.
ReferencePoint parse_reference(const std::string& text);

struct MatchOptions {
  std::vector<std::string> by{"guid", "tag", "name"};  ///< or Set.Property; in this order
  std::vector<MappingRow> mapping;                     ///< goes before `by`
  std::vector<TargetOffset> offsets;                   ///< the last that fits
  std::vector<ReferencePoint> references;              ///< the last that fits
};

struct MatchedElement {
  std::string anchor;
  const Element* element = nullptr;  ///< null: none fits
  std::string found_by, note;
  std::string reference_rule;  ///< as recorded in the output
  Eigen::Vector3d reference = Eigen::Vector3d::Zero(), target_offset = Eigen::Vector3d::Zero();  ///< project frame [m]
};

/// One entry an anchor, in the order given. Of several elements that one key gives, the only anchor among them is
/// meant; if that leaves several, or two keys lead to different elements, or two anchors to one element, nothing is
/// chosen and the note names them. Without any, the note names elements that come near (other case, separators, leading
/// zeros, one or two letters; a name cut off at the 8 or 16 characters of a GSI file). Throws std::runtime_error if
/// nothing at all fits, or an offset needs a facade and which way the element faces is not known or not confirmed.
/// `not_applied` gets the rules for offsets and reference points that select no anchor, or hold nowhere because of a
/// later, wider one.
std::vector<MatchedElement> match_elements(const Design& design, const std::vector<std::string>& anchors,
                                           const MatchOptions& options, std::vector<std::string>& warnings,
                                           std::vector<NotApplied>* not_applied = nullptr);

}  // namespace plumbline::ifc

// match.elements: which element of the design every anchor of the campaign is.
#pragma once

#include "artifacts/design.hpp"
#include "artifacts/element_matches.hpp"
#include "artifacts/file.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "building/ifc/match_elements.hpp"
#include "plumbline/node.hpp"

namespace plumbline::ifc {

/// The rows of a mapping table; none of an empty file. Throws std::runtime_error with file and line.
std::vector<MappingRow> mapping_rows(const FileT& file);

struct MatchElements : Node {
  static constexpr Info info{
      "match.elements", "", 2,
      "Finds the design element of every anchor: by GlobalId, tag, name, property or a mapping table"};
  In<plumbline::Design> design{"design", frame("frame=?F"), "the design as read"};
  In<Plates> plates{"plates", frame("frame=?P"), "anchor table: the names as survey and model know them"};
  Optional<File> mapping{"mapping",
                         "table with the columns 'point' and 'element' (GlobalId, tag or name); may be empty"};
  Param<std::vector<std::string>> by{
      "by", {"guid", "tag", "name"}, "what a name is looked for in, in this order: guid, tag, name or Set.Property"};
  Param<std::vector<std::string>> offsets{"offsets", std::vector<std::string>{},
                                          "from the reference point of elements to the surveyed target: "
                                          "'class=IfcMechanicalFastener: out=40mm, up=-5mm' (out, "
                                          "right, up of the facade; x, y, z of the element)"};
  Param<std::vector<std::string>> reference_points{
      "reference_points", std::vector<std::string>{},
      "which point of elements counts: 'class=IfcMechanicalFastener: head' (placement, middle or head)"};
  Out<ElementMatches> matches{"matches", frame("frame=?F"), "one entry an anchor"};
  Out<Points> points{"points", frame("frame=?F"), "where the targets are by the design, named as in the anchor table"};

  void run(Context& context) override;
};

}  // namespace plumbline::ifc

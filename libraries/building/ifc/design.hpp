// The design as Plumbline uses it: storeys, elements with one reference point each, and which of them are facade
// anchors and panels.
//
// Frames: `project` is the coordinate system of the file's placements, in metres, z up. Map coordinates are not
// applied: real files disagree about what their IfcMapConversion means, so it is handed on as written, with warnings.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "building/ifc/facades.hpp"
#include "building/ifc/grid.hpp"
#include "building/ifc/ifc_schema.hpp"
#include "building/ifc/selection.hpp"
#include "building/step/step.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::ifc {

struct Storey {
  std::string guid, name;
  double elevation = 0;         ///< attribute Elevation [m], else the height of its placement
  double placement_height = 0;  ///< z of its placement in the project frame [m]
  std::uint64_t instance = 0;   ///< number in the file
};

/// Where the reference point of an element comes from.
enum class ReferencePointRule {
  placement,            ///< origin of its placement, which lies within its shape (or it has none)
  axis_middle,          ///< middle of the axis of its only solid: extrusion, cylinder or rod
  bounding_box_centre,  ///< centre of the box of its shape, in its own axes
  parts_centre,         ///< centre of the box around the parts it is an aggregate of
};
const char* name_of(ReferencePointRule rule);

struct Element {
  std::string guid, name, tag, object_type, type_name;
  std::string ifc_class;                               ///< as in the standard: "IfcMechanicalFastener"
  std::string storey, storey_guid;                     ///< empty if it is in none
  std::string parent_guid;                             ///< of the element it is a part of
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< reference point, project frame [m]
  ReferencePointRule rule = ReferencePointRule::placement;
  bool is_anchor = false, is_panel = false;
  /// Of a panel: that it clads, by its class, its kind or the user's word. Other plates (base plates, linings) and
  /// walls may lie behind their anchors.
  bool is_cladding = false;
  RigidTransform project_from_element;  ///< its placement [m]
  bool has_box = false;                 ///< whether the box below is known
  Eigen::Vector3d box_low = Eigen::Vector3d::Zero(),
                  box_high = Eigen::Vector3d::Zero();  ///< of its shape, in its own axes [m]
  std::vector<double> sag;  ///< of a panel: of each side, as sag_of_sides says (outer_sides.hpp) [m]; empty: not known
  std::vector<double> filled;      ///< of a panel: of each side, as filled_sides says; empty: not known
  std::vector<double> rectangles;  ///< of a panel: of each side, as rectangles_of_sides says [m]; empty: the box's
  /// Of an anchor whose shape has several items (IFC lets one fastener stand for many): the centre of each, project
  /// frame [m].
  std::vector<Eigen::Vector3d> item_positions;
  /// Of a panel: GlobalIds of the anchors that it is fixed by (IfcRelConnectsWithRealizingElements), if the file says
  /// so.
  std::vector<std::string> anchor_guids;
  std::string host_guid;             ///< of an anchor: GlobalId of the wall or slab that the file says it is fixed to
  FacadeFrame facade;                ///< of an anchor or panel: which way it faces
  std::vector<Property> properties;  ///< of an anchor or panel, its own before its type's
  std::uint64_t instance = 0;        ///< number in the file
};

/// What a selection looks at.
ElementFacts facts_of(const Element& element);

/// IfcMapConversion (or ePset_MapConversion in IFC2X3) as written: numbers in whatever unit the exporter meant.
struct MapConversion {
  double eastings = 0, northings = 0, orthogonal_height = 0;
  double x_axis_abscissa = 1, x_axis_ordinate = 0;
  double scale = 1;
  bool scale_given = false;
  std::string crs_name;
  double map_unit = std::numeric_limits<double>::quiet_NaN();  ///< metres in one unit of the map; nan: not given

  /// The same numbers; the map's unit may be missing in both.
  bool operator==(const MapConversion& o) const {
    return eastings == o.eastings && northings == o.northings && orthogonal_height == o.orthogonal_height &&
           x_axis_abscissa == o.x_axis_abscissa && x_axis_ordinate == o.x_axis_ordinate && scale == o.scale;
  }
};

struct Design {
  std::string file_name, schema, project_guid, project_name;
  double length_unit = 1;  ///< metres in one length unit of the file
  std::string length_unit_name;
  std::vector<Storey> storeys;                  ///< ascending elevation
  std::vector<Element> elements;                ///< in the order of the file
  std::vector<Facade> facades;                  ///< that its anchors and panels lie in
  std::optional<MapConversion> map_conversion;  ///< the first, if the file has several
  /// Origin of the IfcSite's placement: where exporters put map coordinates, too [m]; nan without.
  Eigen::Vector3d site_origin = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  std::vector<GridAxis> grid;  ///< its axes
  /// Azimuth of true north, clockwise from the y axis of the project [rad]; nan where the file does not say it.
  double true_north = std::numeric_limits<double>::quiet_NaN();
  std::vector<std::string> skipped;  ///< elements that were not placed, with the reason
  std::vector<std::string> warnings;
  std::vector<NotApplied> not_applied;  ///< what the rule asked for and could not be done
};

/// Which elements are anchors: those of a class, those whose name, type or tag matches, those named or listed outright.
struct AnchorRule {
  std::vector<std::string> classes{"IfcMechanicalFastener", "IfcDiscreteAccessory"};
  std::string
      pattern;  ///< ECMAScript regular expression on name, object type, type name and tag; empty matches nothing
  std::vector<std::string> guids;
  std::vector<std::string> names;  ///< for example the anchors of the plates table: exact names, tags or GlobalIds
  std::vector<std::string> selections{};  ///< in the language of selection.hpp
  /// Reads the shapes of all elements, and not only of anchors, panels, their parts and some of the others: it is most
  /// of the work.
  bool all_shapes = false;
  std::vector<std::string> panels{};  ///< which elements are panels, in the same language; empty: plates, curtain
                                      ///< walls, cladding, and walls that hang before anchors which hold none of these
  std::vector<FacadeRule> facades{};  ///< which way anchors and panels face, where the user says it
};

bool is_wall(const Element& element);

/// Takes walls that hang before their anchors (precast panels) for panels, where it is known which way those face;
/// where it is not, they stand in `not_applied`. `bare`: the anchors that hold no other panel (what_hangs.hpp). Of
/// walls that anchors are fixed to, and of those behind them, none is.
void hang_walls(Design& design, const std::vector<FacadeRule>& rules, const std::set<const Element*>& bare);

/// Reads the design out of a file. What cannot be placed (a curved grid axis, a dangling reference, an argument that is
/// missing, an anchor with neither placement nor shape) is left out and stands in `skipped`; a file without project or
/// storeys is read with a warning. Throws step::Error with file, line and column for a file that cannot be read at all,
/// for units that cannot be (a length that may be wrong by a factor is worse than none), for an impossible pattern.
Design read_design(const step::File& file, const AnchorRule& rule);

}  // namespace plumbline::ifc

#include "design_ifc.hpp"

#include <fmt/core.h>

#include <cstdio>
#include <vector>

#include "building/ifc/ifc_guid.hpp"
#include "building/step/step_writer.hpp"
#include "panels.hpp"

namespace plumbline::simulate {
namespace {

using step::enumeration;
using step::list;
using step::null;
using step::real_rounded;
using step::reference;
using step::text;
using Id = std::uint64_t;

class DesignWriter {
 public:
  DesignWriter(const Building& building, std::uint64_t seed, bool millimetres)
      : building_(building), millimetres_(millimetres) {
    const ifc::Uuid name_space =
        *ifc::uuid_from_text("0b1d7a52-5b0e-5a1c-9a53-6f0c7c1f7c11");  // drawn once, for this writer
    project_guid_ = ifc::ifc_guid(ifc::uuid_v5(
        name_space, "simulated building " + std::to_string(seed) + ", " + std::to_string(building.options.floors) +
                        " floors, " + std::to_string(building.options.columns) + " columns" +
                        (building.wings.size() > 1 ? ", facades " + std::to_string(building.wings.size()) : "")));
  }

  std::string write() {
    write_owner();
    write_context();
    const Id project = add("IFCPROJECT", {text(project_guid_), reference(owner_), text("Simulated facade"), null, null,
                                          null, null, list({reference(context_)}), reference(units_)});
    const Id site_placement = placement(0, {0, 0, 0});
    const Id site = spatial("IFCSITE", "Site", site_placement, {null, null, null, null, null});
    const Id building_placement = placement(site_placement, {0, 0, 0});
    const Id house = spatial("IFCBUILDING", "Building", building_placement, {null, null, null});
    aggregate("project", project, {site});
    aggregate("site", site, {house});
    std::vector<Id> storeys;
    for (int floor = 1; floor <= building_.options.floors; ++floor)
      storeys.push_back(write_storey(floor, building_placement));
    aggregate("building", house, storeys);
    return header() + lines_ + "ENDSEC;\nEND-ISO-10303-21;\n";
  }

 private:
  static std::string header() {
    return "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('ViewDefinition [ReferenceView_V1.2]'),'2;1');\n"
           "FILE_NAME('design.ifc','2026-05-01T08:00:00',('Designer'),('Plumbline'),'Plumbline simulation',"
           "'Plumbline simulation','');\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n";
  }

  Id add(std::string_view keyword, const std::vector<std::string>& arguments) {
    lines_ += step::instance(++last_id_, keyword, arguments) + "\n";
    return last_id_;
  }
  std::string guid(const std::string& key) const { return text(ifc::derived_ifc_guid(project_guid_, key)); }
  std::string length(double metres) const { return real_rounded(millimetres_ ? 1e3 * metres : metres, 9); }
  static std::string references(const std::vector<Id>& ids) {
    std::vector<std::string> items;
    for (const Id id : ids) items.push_back(reference(id));
    return list(items);
  }

  void write_owner() {
    const Id person = add("IFCPERSON", {null, text("Designer"), null, null, null, null, null, null});
    const Id organisation = add("IFCORGANIZATION", {null, text("Plumbline"), null, null, null});
    const Id both = add("IFCPERSONANDORGANIZATION", {reference(person), reference(organisation), null});
    const Id application =
        add("IFCAPPLICATION", {reference(organisation), text("0.1"), text("Plumbline simulation"), text("plumbline")});
    owner_ = add("IFCOWNERHISTORY", {reference(both), reference(application), null, enumeration("NOCHANGE"), null, null,
                                     null, step::integer(1777622400)});  // 2026-05-01 08:00 UTC
  }

  void write_context() {
    std::vector<Id> units = {
        add("IFCSIUNIT", {step::derived, enumeration("LENGTHUNIT"), millimetres_ ? enumeration("MILLI") : null,
                          enumeration("METRE")}),
        add("IFCSIUNIT", {step::derived, enumeration("AREAUNIT"), null, enumeration("SQUARE_METRE")}),
        add("IFCSIUNIT", {step::derived, enumeration("VOLUMEUNIT"), null, enumeration("CUBIC_METRE")}),
        add("IFCSIUNIT", {step::derived, enumeration("PLANEANGLEUNIT"), null, enumeration("RADIAN")})};
    units_ = add("IFCUNITASSIGNMENT", {references(units)});
    along_y_ = add("IFCDIRECTION", {list({"0.", "1.", "0."})});
    along_x_ = add("IFCDIRECTION", {list({"1.", "0.", "0."})});
    along_z_ = add("IFCDIRECTION", {list({"0.", "0.", "1."})});
    const Id origin = add("IFCCARTESIANPOINT", {list({"0.", "0."})});
    in_profile_ = add("IFCAXIS2PLACEMENT2D", {reference(origin), null});  // optional in IFC 4, but readers want it
    context_ = add("IFCGEOMETRICREPRESENTATIONCONTEXT",
                   {null, text("Model"), "3", "1.E-05", reference(axes({0, 0, 0})), null});
    body_ = add("IFCGEOMETRICREPRESENTATIONSUBCONTEXT",
                {text("Body"), text("Model"), step::derived, step::derived, step::derived, step::derived,
                 reference(context_), null, enumeration("MODEL_VIEW"), null});
  }

  Id axes(const Eigen::Vector3d& origin) {
    const Id point = add("IFCCARTESIANPOINT", {list({length(origin.x()), length(origin.y()), length(origin.z())})});
    return add("IFCAXIS2PLACEMENT3D", {reference(point), null, null});
  }
  /// Placement relative to another, 0 for none.
  Id placement(Id parent, const Eigen::Vector3d& origin) {
    const Id at = axes(origin);
    return add("IFCLOCALPLACEMENT", {parent ? reference(parent) : std::string(null), reference(at)});
  }

  /// The same turned about the vertical, as a facade stands.
  Id turned_placement(Id parent, const RigidTransform& place) {
    const Eigen::Vector3d &o = place.translation, x = place.rotation * Eigen::Vector3d::UnitX();
    const Id point = add("IFCCARTESIANPOINT", {list({length(o.x()), length(o.y()), length(o.z())})});
    const Id along = add("IFCDIRECTION", {list({real_rounded(x.x(), 15), real_rounded(x.y(), 15), "0."})});
    const Id at = add("IFCAXIS2PLACEMENT3D", {reference(point), reference(along_z_), reference(along)});
    return add("IFCLOCALPLACEMENT", {reference(parent), reference(at)});
  }

  Id spatial(std::string_view keyword, const std::string& name, Id at, const std::vector<std::string>& rest) {
    std::vector<std::string> arguments = {
        guid(name), reference(owner_), text(name), null, null, reference(at), null, null, enumeration("ELEMENT")};
    arguments.insert(arguments.end(), rest.begin(), rest.end());
    return add(keyword, arguments);
  }

  void aggregate(const std::string& key, Id whole, const std::vector<Id>& parts) {
    add("IFCRELAGGREGATES",
        {guid("parts of " + key), reference(owner_), null, null, reference(whole), references(parts)});
  }

  Id shape(Id profile, Id position, Id direction, double depth) {
    const Id solid =
        add("IFCEXTRUDEDAREASOLID", {reference(profile), reference(position), reference(direction), length(depth)});
    const Id representation =
        add("IFCSHAPEREPRESENTATION", {reference(body_), text("Body"), text("SweptSolid"), list({reference(solid)})});
    return add("IFCPRODUCTDEFINITIONSHAPE", {null, null, list({reference(representation)})});
  }

  /// A box that stands on the placement's x-y plane, its footprint centred at (x, y) [m].
  Id box(double x, double y, double size_x, double size_y, double height) {
    const Id profile = add("IFCRECTANGLEPROFILEDEF",
                           {enumeration("AREA"), null, reference(in_profile_), length(size_x), length(size_y)});
    return shape(profile, axes({x, y, 0}), along_z_, height);
  }

  /// The solid all anchors share: a bolt of 40 mm that goes 120 mm into the wall.
  Id bolt() {
    if (bolt_solid_) return bolt_solid_;
    const Id profile = add("IFCCIRCLEPROFILEDEF", {enumeration("AREA"), null, reference(in_profile_), length(0.02)});
    const Id point = add("IFCCARTESIANPOINT", {list({"0.", "0.", "0."})});
    const Id position = add("IFCAXIS2PLACEMENT3D", {reference(point), reference(along_y_), reference(along_x_)});
    bolt_solid_ =
        add("IFCEXTRUDEDAREASOLID", {reference(profile), reference(position), reference(along_z_), length(0.12)});
    return bolt_solid_;
  }

  /// `in_facade`: its design, in the frame of its facade.
  Id write_anchor(const Anchor& anchor, const Eigen::Vector3d& in_facade, Id facade_placement, double elevation) {
    const Id at = placement(facade_placement, in_facade - Eigen::Vector3d(0, 0, elevation));
    const Id representation =
        add("IFCSHAPEREPRESENTATION", {reference(body_), text("Body"), text("SweptSolid"), list({reference(bolt())})});
    const Id form = add("IFCPRODUCTDEFINITIONSHAPE", {null, null, list({reference(representation)})});
    return add("IFCMECHANICALFASTENER",
               {guid(anchor.id), reference(owner_), text(anchor.id), null, text("Facade anchor"), reference(at),
                reference(form), text(anchor.id), length(0.04), length(0.12), enumeration("ANCHORBOLT")});
  }

  Id write_storey(int floor, Id building_placement) {
    const double elevation = building_.storey_height * (floor - 1);
    const std::string name = "Floor " + std::to_string(floor);
    const Id at = placement(building_placement, {0, 0, elevation});
    const Id storey = spatial("IFCBUILDINGSTOREY", name, at, {length(elevation)});
    std::vector<Id> contained;
    for (std::size_t wing = 0; wing < building_.wings.size(); ++wing) write_wing(wing, floor, name, at, contained);
    add("IFCRELCONTAINEDINSPATIALSTRUCTURE",
        {guid(name + " contents"), reference(owner_), null, null, references(contained), reference(storey)});
    return storey;
  }

  /// One facade of a storey: slab behind it, curtain wall with its panels, anchors, all in the frame of the facade.
  void write_wing(std::size_t wing, int floor, const std::string& storey, Id storey_placement,
                  std::vector<Id>& contained) {
    const bool many = building_.wings.size() > 1;
    const std::string name = many ? storey + " " + std::string(1, static_cast<char>('A' + wing)) : storey;
    const RigidTransform& place = building_.wings[wing];
    const Id at = many ? turned_placement(storey_placement, place) : storey_placement;
    const double depth = many ? 2.0 : 6.0;  // behind an inner corner there is no room for more
    const Id slab_placement = placement(at, {0, 0, -0.16});
    const Id slab_shape = box(0.5 * building_.width, 0.5 * depth + 0.05, building_.width, depth, 0.32);
    const Id slab = add("IFCSLAB", {guid(name + " slab"), reference(owner_), text(name + " slab"), null, null,
                                    reference(slab_placement), reference(slab_shape), null, enumeration("FLOOR")});
    const Id wall_placement = placement(at, {0, 0, 0});
    const Id wall = add("IFCCURTAINWALL", {guid(name + " facade"), reference(owner_), text(name + " facade"), null,
                                           null, reference(wall_placement), null, null, enumeration("NOTDEFINED")});
    contained.push_back(slab), contained.push_back(wall);
    std::vector<Id> panels;
    const int columns = building_.options.columns, first = static_cast<int>(wing) * columns;
    std::vector<std::vector<Id>> fixings(static_cast<std::size_t>(columns));
    for (const Anchor& anchor : building_.anchors) {
      if (anchor.floor != floor || anchor.wing != static_cast<int>(wing)) continue;
      contained.push_back(
          write_anchor(anchor, place.inverse() * anchor.design, at, building_.storey_height * (floor - 1)));
      if (anchor.role == AnchorRole::control) fixings[anchor.column - first - 1].push_back(contained.back());
    }
    // A panel hangs between two columns of anchors and shares them with its neighbours.
    for (int column = 1; column < columns; ++column) {
      std::vector<Id> corners = fixings[column - 1];
      corners.insert(corners.end(), fixings[column].begin(), fixings[column].end());
      panels.push_back(write_panel(floor, first, column, wall_placement, slab, corners));
    }
    aggregate(name + " facade", wall, panels);
  }

  /// `column`: that of its facade, which follows the `first` columns of others.
  Id write_panel(int floor, int first, int column, Id wall_placement, Id slab, const std::vector<Id>& anchors) {
    const std::string name = panel_name(floor, first + column);
    const double pitch = building_.options.spacing, joint = PanelGrid::joint;
    const Id at = placement(wall_placement, {pitch * column, PanelGrid::middle, 0.5 * joint});
    const Id form = box(0, 0, pitch - joint, PanelGrid::thickness, building_.storey_height - joint);
    const Id panel = add("IFCPLATE", {guid(name), reference(owner_), text(name), null, text("Facade panel"),
                                      reference(at), reference(form), text(name), enumeration("CURTAIN_PANEL")});
    add("IFCRELCONNECTSWITHREALIZINGELEMENTS",
        {guid(std::string(name) + " fixing"), reference(owner_), null, null, null, reference(slab), reference(panel),
         references(anchors), text("FacadeFixing")});
    return panel;
  }

  const Building& building_;
  bool millimetres_;
  std::string project_guid_, lines_;
  Id last_id_ = 0, owner_ = 0, units_ = 0, context_ = 0, body_ = 0;
  Id along_x_ = 0, along_y_ = 0, along_z_ = 0, in_profile_ = 0, bolt_solid_ = 0;
};

}  // namespace

std::string write_design_ifc(const Building& building, std::uint64_t seed, bool millimetres) {
  return DesignWriter(building, seed, millimetres).write();
}

}  // namespace plumbline::simulate

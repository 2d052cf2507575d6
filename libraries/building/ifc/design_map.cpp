#include "building/ifc/design_map.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "building/ifc/ifc_units.hpp"

namespace plumbline::ifc {
namespace {

std::string describe(const MapConversion& map) {
  return "E " + std::to_string(map.eastings) + ", N " + std::to_string(map.northings) + ", H " +
         std::to_string(map.orthogonal_height);
}

class MapReader {
 public:
  MapReader(const Model& model, Damage& damage, Design& design) : model_(model), damage_(damage), design_(design) {}
  void read();

 private:
  std::optional<MapConversion> conversion(const Entity& entity);
  bool scaled(const Entity& entity, MapConversion& map);
  void check_origin(const Entity& entity);
  void property_set();
  void check_scale(const MapConversion& map, double map_unit);

  const Model& model_;
  Damage& damage_;
  Design& design_;
};

void MapReader::read() {
  int found = 0;
  for (const char* keyword : {"IFCMAPCONVERSION", "IFCMAPCONVERSIONSCALED", "IFCRIGIDOPERATION"})
    for_all(model_, keyword, damage_, [&](const Entity& entity) {
      ++found;
      const std::optional<MapConversion> map = conversion(entity);
      if (!map) return;
      check_origin(entity);
      if (!design_.map_conversion)
        design_.map_conversion = map;
      else if (!(*map == *design_.map_conversion))
        design_.warnings.push_back("the file has another georeference (#" + std::to_string(entity.id()) + ", " +
                                   describe(*map) + ") beside the first (" + describe(*design_.map_conversion) +
                                   "); the first is handed on");
    });
  if (found == 0) property_set();
  if (!design_.map_conversion) return;
  if (design_.site_origin.allFinite() && design_.site_origin.head<2>().norm() > 1e4)
    design_.warnings.push_back(
        "the file is georeferenced twice: its site stands far from the origin and it has a map conversion; check "
        "both "
        "against surveyed points before use");
}

/// Nothing, with a warning, for what is no shift, turn and scale in the plane of a map.
std::optional<MapConversion> MapReader::conversion(const Entity& entity) {
  MapConversion map;
  const std::uint64_t target = entity.reference("TargetCRS");
  const bool rigid = entity.keyword() == "IFCRIGIDOPERATION";
  const bool angles = rigid && entity.value("FirstCoordinate").kind == step::Kind::typed &&
                      entity.value("FirstCoordinate").text == "IFCPLANEANGLEMEASURE";
  if (angles || model_.keyword(target) == "IFCGEOGRAPHICCRS") {
    design_.warnings.push_back("the georeference #" + std::to_string(entity.id()) +
                               " gives longitude and latitude, no coordinates of a map: it is not used; a survey in "
                               "map coordinates needs frames.use=fitted or given");
    return std::nullopt;
  }
  if (rigid) {
    map.eastings = entity.number("FirstCoordinate");
    map.northings = entity.number("SecondCoordinate");
    map.orthogonal_height = entity.optional_number("Height").value_or(0);
  } else {
    map.eastings = entity.number("Eastings");
    map.northings = entity.number("Northings");
    map.orthogonal_height = entity.number("OrthogonalHeight");
    map.x_axis_abscissa = entity.optional_number("XAxisAbscissa").value_or(1);
    map.x_axis_ordinate = entity.optional_number("XAxisOrdinate").value_or(0);
    map.scale_given = entity.optional_number("Scale").has_value();
    map.scale = entity.optional_number("Scale").value_or(1);
  }
  if (entity.keyword() == "IFCMAPCONVERSIONSCALED" && !scaled(entity, map)) return std::nullopt;
  if (model_.keyword(target) == "IFCPROJECTEDCRS") {
    const Entity crs = model_.entity(target, entity.id());
    map.crs_name = crs.text("Name");
    if (const auto unit = crs.optional_reference("MapUnit")) map.map_unit = unit_factor(model_, *unit);
  }
  // Without MapUnit the map counts in the project's unit by the standard, in metres by many exporters.
  if (!std::isnan(map.map_unit))
    check_scale(map, map.map_unit);
  else if (!(std::abs(map.scale - 1) < 0.01))
    check_scale(map, 1);
  return map;
}

/// Factors of the three axes beside the scale of the units. One of the plan goes into the scale; false, with a warning,
/// for what would deform the building.
bool MapReader::scaled(const Entity& entity, MapConversion& map) {
  const double x = entity.number("FactorX"), y = entity.number("FactorY"), z = entity.number("FactorZ");
  if (std::abs(x - y) > 1e-9 || std::abs(z - 1) > 1e-9) {
    design_.warnings.push_back("the georeference #" + std::to_string(entity.id()) + " stretches x by " +
                               std::to_string(x) + ", y by " + std::to_string(y) + ", heights by " + std::to_string(z) +
                               ": it is not used; a survey in map coordinates needs frames.use=fitted or given");
    return false;
  }
  map.scale *= x;
  return true;
}

/// A world coordinate system off the origin: exporters disagree whether their map conversion starts from there.
void MapReader::check_origin(const Entity& entity) {
  const auto context = model_.file().find(entity.reference("SourceCRS"));
  if (!context || model_.file().type_name(*context) != "IFCGEOMETRICREPRESENTATIONCONTEXT") return;
  const auto arguments = model_.file().arguments(*context);
  if (arguments.size() < 5 || arguments[4].kind != step::Kind::reference) return;
  const std::uint64_t location = model_.entity(arguments[4].id, context->id).reference("Location");
  if (model_.keyword(location) != "IFCCARTESIANPOINT") return;
  const std::vector<double> origin = model_.entity(location).numbers("Coordinates");
  if (std::any_of(origin.begin(), origin.end(), [](double c) { return std::abs(c) > 1e-9; }))
    design_.warnings.push_back("the world coordinate system of the file (#" + std::to_string(context->id) +
                               ") stands off its origin: whether the map conversion starts from there is not said; "
                               "check it against surveyed points before use");
}

/// IFC2X3 has no IfcMapConversion; the usual stand-in is a property set.
void MapReader::property_set() {
  for (const std::uint32_t index : model_.file().of_type("IFCPROPERTYSET")) {
    const step::Instance instance = model_.file().instances()[index];
    // A look at the bytes first: most files have thousands of sets.
    if (!model_.file().contains(instance, "et_MapConversion")) continue;
    const Entity set = model_.entity(instance);
    if (set.text("Name") != "ePset_MapConversion" && set.text("Name") != "ePSet_MapConversion") continue;
    MapConversion map;
    for (const std::uint64_t id : set.references("HasProperties")) {
      if (model_.keyword(id) != "IFCPROPERTYSINGLEVALUE") continue;
      const Entity property = model_.entity(id, set.id());
      const std::string name = property.text("Name");
      const step::Value& value = property.value("NominalValue");
      if (value.kind != step::Kind::typed || value.items.empty() || !value.items[0].is_number()) continue;
      const double number = value.items[0].number;
      if (name == "Eastings") map.eastings = number;
      if (name == "Northings") map.northings = number;
      if (name == "OrthogonalHeight") map.orthogonal_height = number;
      if (name == "XAxisAbscissa") map.x_axis_abscissa = number;
      if (name == "XAxisOrdinate") map.x_axis_ordinate = number;
      if (name == "Scale") map.scale = number, map.scale_given = true;
    }
    check_scale(map, 1);
    design_.map_conversion = map;
    return;
  }
}

/// The standard's scale is project unit over map unit, times a grid scale near 1; exporters have written its inverse
/// and left it out.
void MapReader::check_scale(const MapConversion& map, double map_unit) {
  const double expected = design_.length_unit / map_unit;
  if (std::abs(map.scale / expected - 1) < 0.01) return;
  design_.warnings.push_back("the map conversion has scale " + std::to_string(map.scale) +
                             (map.scale_given ? "" : " (not given)") + ", expected about " + std::to_string(expected) +
                             " for these units: check it against surveyed points before use");
}

}  // namespace

void read_map_conversion(const Model& model, Damage& damage, Design& design) {
  MapReader(model, damage, design).read();
}

}  // namespace plumbline::ifc

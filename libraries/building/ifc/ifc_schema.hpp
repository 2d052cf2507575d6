// What we have to know of the IFC schemas: where the attributes of the entities we read and write stand, and which
// classes are elements. Facts of the EXPRESS schemas IFC2X3 TC1, IFC4 ADD2 TC1 and IFC4X3 ADD2; a test compares them
// with the schemas' text.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "building/step/step.hpp"

namespace plumbline::ifc {

enum class Schema : unsigned { ifc2x3 = 1, ifc4 = 2, ifc4x3 = 4 };
inline constexpr unsigned kAllSchemas = 7;

/// The schema that FILE_SCHEMA names. Throws step::Error that lists what we read if it is none of them.
Schema schema_of(const step::File& file);
const char* schema_name(Schema schema);

/// The leading attributes of an entity, in the order of its arguments.
struct EntityLayout {
  std::string_view keyword;     ///< in capitals
  unsigned schemas;             ///< sum of Schema values it holds for
  std::string_view attributes;  ///< names separated by one blank
};
std::span<const EntityLayout> entity_layouts();

/// The layout of a keyword (capitals) in a schema; that of IfcElement for its subtypes; nullptr if we know none.
const EntityLayout* find_layout(Schema schema, std::string_view keyword);
/// Position of an attribute in the arguments; nothing if the layout does not have it.
std::optional<std::size_t> attribute_position(const EntityLayout& layout, std::string_view attribute);

/// A concrete or abstract subtype of IfcElement.
struct ElementClass {
  std::string_view name;  ///< as in the standard: "IfcMechanicalFastener"
  unsigned schemas;
};
std::span<const ElementClass> element_classes();
/// "IFCMECHANICALFASTENER" → "IfcMechanicalFastener"; empty if it is no subtype of IfcElement in this schema.
std::string_view element_class_name(Schema schema, std::string_view keyword);

}  // namespace plumbline::ifc

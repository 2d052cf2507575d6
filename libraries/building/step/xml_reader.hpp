// ifcXML (ISO 10303-28) turned into the STEP file that says the same, for readers that know STEP.
//
// Both arrangements that exporters write: that of IFC4 and later (root `ifcXML`; simple attributes as attributes of
// XML, inverses as elements around the relation) and that of IFC2x3 (`iso_10303_28` around `uos`; everything as
// elements). Names of the schema are taken in any case, enumerations in small letters; numbers that are not (Revit's
// NAN for what is not set) are left out. Instances are numbered in the order in which the file first speaks of them.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::step {

/// Whether it looks like XML rather than STEP: the first character, past a byte order mark, is '<', or it is UTF-16.
bool is_xml(std::string_view bytes);

struct StepOfXml {
  std::string text;                  ///< of the STEP file: one instance a line
  std::vector<std::uint32_t> lines;  ///< the line of the XML file that each line of `text` comes from; 0: none
};

/// Throws Error as "file:line:column: element: found …, expected …": for XML that is damaged or something else than
/// ifcXML, another schema, names that the schema does not have, references to nothing, values of another kind.
StepOfXml step_of_xml(std::string_view bytes, const std::string& file);

}  // namespace plumbline::step

// Names and texts of XML's nodes as ifcXML has them: without prefixes of namespaces, without what is the format's own.
#pragma once

#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace plumbline::step {

/// "IfcWall" of "ifc:IfcWall".
std::string_view local(const char* name);
std::string_view local(pugi::xml_node node);
bool has_prefix(const char* name);
/// Of XSI and of ISO 10303-28 itself: no attributes of entities.
bool is_of_the_format(const pugi::xml_attribute& attribute);
std::vector<pugi::xml_node> elements_of(pugi::xml_node node);
/// All of its text: a comment in the midst parts it into several nodes.
std::string text_of(pugi::xml_node node);
/// "xs:double": a type of XML Schema, which says nothing of IFC.
bool is_of_xml(std::string_view type);
/// "IfcLabel" of "IfcLabel-wrapper".
std::string_view without_wrapper(std::string_view name);

}  // namespace plumbline::step

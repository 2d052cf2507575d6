#include "building/step/xml_nodes.hpp"

#include <set>

namespace plumbline::step {

std::string_view local(const char* name) {
  const std::string_view whole(name);
  const std::size_t colon = whole.rfind(':');
  return colon == std::string_view::npos ? whole : whole.substr(colon + 1);
}
std::string_view local(pugi::xml_node node) { return local(node.name()); }

bool has_prefix(const char* name) { return std::string_view(name).find(':') != std::string_view::npos; }

bool is_of_the_format(const pugi::xml_attribute& attribute) {
  static const std::set<std::string_view> names = {"id", "ref", "href", "pos", "path", "xmlns"};
  return has_prefix(attribute.name()) || names.contains(attribute.name());
}

std::vector<pugi::xml_node> elements_of(pugi::xml_node node) {
  std::vector<pugi::xml_node> found;
  for (pugi::xml_node child : node.children())
    if (child.type() == pugi::node_element) found.push_back(child);
  return found;
}

std::string text_of(pugi::xml_node node) {
  std::string text;
  for (pugi::xml_node child : node.children())
    if (child.type() == pugi::node_pcdata || child.type() == pugi::node_cdata) text += child.value();
  return text;
}

bool is_of_xml(std::string_view type) { return type.starts_with("xs:") || type.starts_with("xsd:"); }

std::string_view without_wrapper(std::string_view name) {
  constexpr std::string_view end = "-wrapper";
  return name.ends_with(end) ? name.substr(0, name.size() - end.size()) : name;
}

}  // namespace plumbline::step

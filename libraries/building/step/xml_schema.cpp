#include "building/step/xml_schema.hpp"

#include <algorithm>
#include <array>

#include "building/step/express_schemas.hpp"
#include "building/step/step_scanner.hpp"

namespace plumbline::step {
namespace {

const char* text_of(const std::string& schema) {
  return schema == "IFC2X3" ? schemas::ifc2x3 : schema == "IFC4" ? schemas::ifc4 : schemas::ifc4x3;
}

/// The part before the delimiter, which `text` loses with it.
std::string_view next_part(std::string_view& text, char delimiter) {
  const std::size_t end = std::min(text.find(delimiter), text.size());
  const std::string_view part = text.substr(0, end);
  text.remove_prefix(std::min(end + 1, text.size()));
  return part;
}

}  // namespace

std::string capitals(std::string_view name) {
  std::string text(name);
  std::transform(text.begin(), text.end(), text.begin(), upper);
  return text;
}

const XmlSchema::Attribute* XmlSchema::Entity::attribute(std::string_view wanted) const {
  for (const Attribute& one : attributes)
    if (one.name == wanted) return &one;
  return nullptr;
}

const XmlSchema::Inverse* XmlSchema::Entity::inverse(std::string_view wanted) const {
  for (const Inverse& one : inverses)
    if (one.name == wanted) return &one;
  return nullptr;
}

XmlSchema::XmlSchema(const std::string& name) : name_(name) {
  std::string_view text = text_of(name);
  while (!text.empty()) {
    std::string_view rest = next_part(text, '\n');
    const std::size_t end = rest.find_first_of("=!<");
    if (end == std::string_view::npos) continue;
    Line line{rest.substr(0, end), rest.substr(end), rest[end] == '!'};
    line.rest.remove_prefix(line.is_abstract ? 2 : 1);
    (rest[end] == '=' ? types_ : lines_)[capitals(line.name)] = line;
  }
}

const XmlSchema::Entity* XmlSchema::entity(std::string_view name) {
  const std::string key = capitals(name);
  if (const auto known = entities_.find(key); known != entities_.end()) return &known->second;
  const auto line = lines_.find(key);
  if (line == lines_.end()) return nullptr;
  std::string_view rest = line->second.rest;
  Entity made;
  if (const std::string_view parent = next_part(rest, ';'); !parent.empty()) made = *entity(parent);
  made.name = line->second.name, made.is_abstract = line->second.is_abstract;
  while (!rest.empty()) {
    std::string_view part = next_part(rest, ';');
    if (part[0] == '*') {
      for (Attribute& inherited : made.attributes)
        if (inherited.name == part.substr(1)) inherited.derived = true;
    } else if (part[0] == '~') {
      part.remove_prefix(1);
      Inverse inverse{next_part(part, ':'), {}, {}};
      inverse.entity = next_part(part, '.'), inverse.forward = part;
      made.inverses.push_back(inverse);
    } else {
      Attribute attribute{next_part(part, ':'), part};
      made.attributes.push_back(attribute);
    }
  }
  return &entities_.emplace(key, std::move(made)).first->second;
}

std::string_view XmlSchema::defined_type(std::string_view name) const {
  const auto found = types_.find(capitals(name));
  return found == types_.end() ? std::string_view() : found->second.name;
}

std::string_view XmlSchema::resolved(std::string_view type) const {
  while (type.size() > 1 && type[0] != '[') {
    const auto found = types_.find(capitals(type));
    if (found == types_.end()) break;
    type = found->second.rest;
  }
  return type;
}

}  // namespace plumbline::step

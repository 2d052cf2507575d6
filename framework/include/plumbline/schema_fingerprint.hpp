// The fingerprint of an artifact's type: eight hexadecimal digits over everything that gives its bytes their meaning,
// so that two plugins built from different schemas are told apart before one reads what the other wrote.
//
// It covers, of the root table and of all that it holds: names, the ids of the fields, types, defaults, whether a field
// is required or may be null, unit and frame, and of enums every name with its value. Comments do not count.
#pragma once

#include <flatbuffers/reflection.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <set>
#include <string>

namespace plumbline {

namespace detail {

template <typename Holder>
std::string schema_attribute(const Holder& holder, const char* key) {
  if (holder.attributes())
    if (const auto* found = holder.attributes()->LookupByKey(key)) return found->value() ? found->value()->str() : "";
  return "";
}

inline std::string default_text(const reflection::Field& field) {
  if (std::isnan(field.default_real())) return "nan";  // its sign would print too
  char text[64];
  std::snprintf(text, sizeof text, "%lld %.17g", static_cast<long long>(field.default_integer()), field.default_real());
  return text;
}

inline void describe_object(const reflection::Schema& schema, const reflection::Object& object,
                            std::set<std::string>& seen, std::string& text);

inline void describe_enum(const reflection::Schema& schema, const reflection::Enum& type, std::set<std::string>& seen,
                          std::string& text) {
  if (!seen.insert(type.name()->str()).second) return;
  text += "enum " + type.name()->str() + "{";
  for (const auto* value : *type.values()) text += value->name()->str() + "=" + std::to_string(value->value()) + ";";
  text += "}";
  for (const auto* value : *type.values())
    if (type.is_union() && value->union_type() && value->union_type()->base_type() == reflection::Obj)
      describe_object(schema, *schema.objects()->Get(static_cast<uint32_t>(value->union_type()->index())), seen, text);
}

inline void describe_object(const reflection::Schema& schema, const reflection::Object& object,
                            std::set<std::string>& seen, std::string& text) {
  if (!seen.insert(object.name()->str()).second) return;
  text += std::string(object.is_struct() ? "struct " : "table ") + object.name()->str() + "{";
  for (uint32_t id = 0; id < object.fields()->size(); ++id) {
    for (const auto* field : *object.fields()) {
      if (field->id() != id) continue;
      const auto& type = *field->type();
      text += std::to_string(id) + " " + field->name()->str() + ":" + std::to_string(type.base_type()) + "/" +
              std::to_string(type.element()) + "/" + std::to_string(type.fixed_length());
      const auto held = type.base_type() == reflection::Obj || type.element() == reflection::Obj;
      if (held)
        text += " " + schema.objects()->Get(static_cast<uint32_t>(type.index()))->name()->str();
      else if (type.index() >= 0)
        text += " " + schema.enums()->Get(static_cast<uint32_t>(type.index()))->name()->str();
      text += "=" + default_text(*field) + (field->required() ? "!" : "") + (field->optional() ? "?" : "") + "~" +
              schema_attribute(*field, "unit") + "@" + schema_attribute(*field, "frame") + ";";
    }
  }
  text += "}";
  for (const auto* field : *object.fields()) {
    const auto& type = *field->type();
    if (type.base_type() == reflection::Obj || type.element() == reflection::Obj)
      describe_object(schema, *schema.objects()->Get(static_cast<uint32_t>(type.index())), seen, text);
    else if (type.index() >= 0)
      describe_enum(schema, *schema.enums()->Get(static_cast<uint32_t>(type.index())), seen, text);
  }
}

}  // namespace detail

/// Of the root table of a well-formed schema. FNV-1a folded to 32 bits: it tells two builds apart and protects from
/// nobody.
inline std::string schema_fingerprint(const reflection::Schema& schema) {
  const reflection::Object& root = *schema.root_table();
  std::set<std::string> seen;
  std::string text = detail::schema_attribute(root, "frames") + ";";
  detail::describe_object(schema, root, seen, text);
  uint64_t hash = 0xcbf29ce484222325u;
  for (const unsigned char c : text) hash = (hash ^ c) * 0x100000001b3u;
  char digits[9];
  std::snprintf(digits, sizeof digits, "%08x", static_cast<unsigned>(static_cast<uint32_t>(hash ^ (hash >> 32))));
  return digits;
}

}  // namespace plumbline

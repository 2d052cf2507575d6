#include "runtime/plugins/type_schema.hpp"

#include <cstring>
#include <sstream>

#include "plumbline/schema_fingerprint.hpp"

namespace plumbline::runtime {

namespace {

using plumbline::detail::default_text;
using plumbline::detail::schema_attribute;
using reflection::BaseType;
using reflection::Enum;
using reflection::Field;
using reflection::Object;
using reflection::Schema;

const Schema& schema_of(const plumbline_type& type) { return *reflection::GetSchema(type.schema.data); }

bool is_scalar(BaseType type) { return type >= reflection::UType && type <= reflection::Double; }

/// What FlatBuffers' own walk over the schema takes for granted of a field; it would read outside of the schema.
std::string field_problem(const Schema& schema, const Object& object, const Field& field) {
  const auto& type = *field.type();
  const BaseType base = type.base_type(), element = type.element();
  const bool list = base == reflection::Vector || base == reflection::Array;
  const BaseType held = list ? element : base;
  if (held <= reflection::None || held >= reflection::MaxBaseType || held == reflection::Vector ||
      held == reflection::Array)
    return "has no type";
  if (list && held == reflection::Union) return "is a list of unions, which the host cannot verify";
  const int index = type.index();
  if (held == reflection::Obj && (index < 0 || static_cast<uint32_t>(index) >= schema.objects()->size()))
    return "holds a table that the schema does not have";
  if (held == reflection::Union && (index < 0 || static_cast<uint32_t>(index) >= schema.enums()->size()))
    return "holds a union that the schema does not have";
  if (is_scalar(held) && index >= 0 && static_cast<uint32_t>(index) >= schema.enums()->size())
    return "holds an enum that the schema does not have";
  if (!object.is_struct()) {
    if (base == reflection::Array) return "is an array in a table";
    return field.offset() == 4 + 2 * field.id() ? "" : "does not lie where its number says";
  }
  const bool inner_struct = base == reflection::Obj && schema.objects()->Get(static_cast<uint32_t>(index))->is_struct();
  if (!is_scalar(held) && !inner_struct && base != reflection::Array) return "is neither number nor struct in a struct";
  const int size = inner_struct ? schema.objects()->Get(static_cast<uint32_t>(index))->bytesize()
                                : static_cast<int>(flatbuffers::GetTypeSize(held));
  return size > 0 && field.offset() + size <= object.bytesize() ? "" : "lies outside of its struct";
}

/// Structs within structs must come to an end.
bool ends(const Schema& schema, const Object& object, int depth) {
  if (depth > 32) return false;
  for (const Field* field : *object.fields()) {
    const auto& type = *field->type();
    if (type.base_type() != reflection::Obj) continue;
    const Object& inner = *schema.objects()->Get(static_cast<uint32_t>(type.index()));
    if (inner.is_struct() && !ends(schema, inner, depth + 1)) return false;
  }
  return true;
}

std::string union_problem(const Schema& schema, const Enum& type) {
  for (const auto* value : *type.values()) {
    const auto* held = value->union_type();
    if (!type.is_union() || !held || held->base_type() != reflection::Obj) continue;
    if (held->index() < 0 || static_cast<uint32_t>(held->index()) >= schema.objects()->size())
      return type.name()->str() + " holds a table that the schema does not have";
  }
  return "";
}

std::string structure_problem(const Schema& schema) {
  for (const Enum* type : *schema.enums())
    if (const std::string problem = union_problem(schema, *type); !problem.empty()) return problem;
  for (const Object* object : *schema.objects()) {
    std::set<uint16_t> ids;
    for (const Field* field : *object->fields()) {
      const std::string name = object->name()->str() + "." + field->name()->str();
      const std::string problem = field_problem(schema, *object, *field);
      if (!problem.empty()) return name + " " + problem;
      if (field->id() >= object->fields()->size() || !ids.insert(field->id()).second)
        return name + " has the number " + std::to_string(field->id()) + ", which is not its own";
    }
  }
  for (const Object* object : *schema.objects())
    if (object->is_struct() && !ends(schema, *object, 0)) return object->name()->str() + " holds itself";
  return "";
}

}  // namespace

std::string check_schema(const plumbline_type& type) {
  const std::string mend = "; make it with plumbline_add_artifacts() in CMake";
  if (!type.schema.data || type.schema.size < 8) return "has no schema" + mend;
  flatbuffers::Verifier verifier(static_cast<const uint8_t*>(type.schema.data), type.schema.size);
  if (!reflection::VerifySchemaBuffer(verifier)) return "has a schema that is no binary FlatBuffers schema" + mend;
  const Schema& schema = schema_of(type);
  if (!schema.root_table()) return "has a schema without root_type" + mend;
  if (const std::string problem = structure_problem(schema); !problem.empty())
    return "has a damaged schema: " + problem + mend;
  const Object& root = *schema.root_table();
  // The walk starts at the root by its place in the list of objects, so it has to be one of them.
  const Object* listed = schema.objects()->LookupByKey(root.name()->c_str());
  if (!listed || root.is_struct() || root.fields()->size() != listed->fields()->size())
    return "has a schema whose root is not one of its tables" + mend;
  const std::string name = root.name()->str() + "/" + schema_attribute(root, "artifact_version");
  if (name != type.name) return "has the schema of " + name + mend;
  const std::string fingerprint = schema_fingerprint(schema);
  if (fingerprint != type.fingerprint)
    return std::string("has the fingerprint ") + type.fingerprint + ", its schema gives " + fingerprint +
           "; build the plugin anew with this installation's plumbline-typegen";
  return "";
}

std::set<std::string> frame_parameters(const plumbline_type& type) {
  std::set<std::string> names;
  std::istringstream list(schema_attribute(*schema_of(type).root_table(), "frames"));
  for (std::string name; std::getline(list, name, ',');) names.insert(name);
  return names;
}

namespace {

std::string type_text(const Schema& schema, const reflection::Type& type) {
  const bool list = type.base_type() == reflection::Vector || type.base_type() == reflection::Array;
  const BaseType base = list ? type.element() : type.base_type();
  std::string text = reflection::EnumNameBaseType(base);
  const auto index = static_cast<uint32_t>(type.index());
  if (base == reflection::Obj)
    text = schema.objects()->Get(index)->name()->str();
  else if (type.index() >= 0)
    text = schema.enums()->Get(index)->name()->str() + " (" + text + ")";
  if (type.fixed_length()) text += ":" + std::to_string(type.fixed_length());
  return list ? "[" + text + "]" : text;
}

/// What two fields in the same slot disagree on.
std::string compare_fields(const std::string& table, const Field& here, const Schema& schema_here, const Field& there,
                           const Schema& schema_there) {
  const auto with_unit = [](const Field& field) {
    const std::string unit = schema_attribute(field, "unit");
    return "'" + field.name()->str() + "'" + (unit.empty() ? "" : " in unit '" + unit + "'");
  };
  if (here.name()->str() != there.name()->str())
    return "field " + std::to_string(here.id()) + " of " + table + " is " + with_unit(here) + " here and " +
           with_unit(there) + " there";
  const auto flag = [](bool set) { return std::string(set ? "yes" : "no"); };
  const struct {
    const char* what;
    std::string a, b;
  } properties[] = {
      {"has the type", type_text(schema_here, *here.type()), type_text(schema_there, *there.type())},
      {"is in unit", schema_attribute(here, "unit"), schema_attribute(there, "unit")},
      {"is in frame", schema_attribute(here, "frame"), schema_attribute(there, "frame")},
      {"has the default", default_text(here), default_text(there)},
      {"must be there:", flag(here.required()), flag(there.required())},
      {"may be null:", flag(here.optional()), flag(there.optional())},
  };
  for (const auto& property : properties)
    if (property.a != property.b)
      return table + "." + here.name()->str() + " " + property.what + " '" + property.a + "' here and '" + property.b +
             "' there";
  return "";
}

const Field* field_in_slot(const Object& object, uint16_t id) {
  for (const Field* field : *object.fields())
    if (field->id() == id) return field;
  return nullptr;
}

/// Of the fields that only `longer` has: in a struct none may be, in a table they may be missing.
std::string compare_surplus(const Object& longer, size_t common, const std::string& where, const std::string& other) {
  for (auto id = static_cast<uint16_t>(common); id < longer.fields()->size(); ++id) {
    const Field& field = *field_in_slot(longer, id);
    const std::string name = longer.name()->str() + "." + field.name()->str();
    if (longer.is_struct()) return name + " is there only " + where + ", and a struct cannot grow";
    if (field.required()) return name + " is required " + where + " and unknown " + other;
  }
  return "";
}

std::string compare_objects(const Object& here, const Schema& schema_here, const Object& there,
                            const Schema& schema_there) {
  const std::string name = here.name()->str();
  const size_t common = std::min(here.fields()->size(), there.fields()->size());
  for (uint16_t id = 0; id < common; ++id) {
    const std::string difference =
        compare_fields(name, *field_in_slot(here, id), schema_here, *field_in_slot(there, id), schema_there);
    if (!difference.empty()) return difference;
  }
  if (here.is_struct() != there.is_struct()) return name + " is a struct on one side and a table on the other";
  const std::string more_here = compare_surplus(here, common, "here", "there");
  return more_here.empty() ? compare_surplus(there, common, "there", "here") : more_here;
}

std::string compare_enums(const Enum& here, const Enum& there) {
  const auto meaning = [](const Enum& type, int64_t number) -> std::string {
    for (const auto* value : *type.values())
      if (value->value() == number) return value->name()->str();
    return "";
  };
  for (const Enum* side : {&here, &there})
    for (const auto* value : *side->values()) {
      const std::string a = meaning(here, value->value()), b = meaning(there, value->value());
      if (a != b)
        return "value " + std::to_string(value->value()) + " of the enum " + here.name()->str() + " is " +
               (a.empty() ? "nothing" : "'" + a + "'") + " here and " + (b.empty() ? "nothing" : "'" + b + "'") +
               " there";
    }
  return "";
}

}  // namespace

std::string compare_types(const plumbline_type& here, const plumbline_type& there) {
  if (std::strcmp(here.fingerprint, there.fingerprint) == 0) return "";
  const Schema &a = schema_of(here), &b = schema_of(there);
  for (const Object* object : *a.objects())
    if (const Object* other = b.objects()->LookupByKey(object->name()->c_str())) {
      const std::string difference = compare_objects(*object, a, *other, b);
      if (!difference.empty()) return difference;
    }
  for (const Enum* type : *a.enums())
    if (const Enum* other = b.enums()->LookupByKey(type->name()->c_str())) {
      const std::string difference = compare_enums(*type, *other);
      if (!difference.empty()) return difference;
    }
  const std::string frames_here = schema_attribute(*a.root_table(), "frames");
  const std::string frames_there = schema_attribute(*b.root_table(), "frames");
  if (frames_here != frames_there)
    return std::string(here.name) + " has the frame parameters '" + frames_here + "' here and '" + frames_there +
           "' there";
  return "";
}

}  // namespace plumbline::runtime

#include "runtime/plugins/artifact_type.hpp"

#include <flatbuffers/reflection.h>

#include <charconv>
#include <cmath>
#include <cstring>

#include "runtime/base/json_text.hpp"
#include "runtime/plugins/artifact_rules.hpp"

namespace plumbline::runtime {

namespace {

using reflection::BaseType;
using reflection::Field;
using reflection::Object;
using reflection::Schema;

const Schema& schema_of(const plumbline_type& type) { return *reflection::GetSchema(type.schema.data); }

bool is_float(BaseType type) { return type == reflection::Float || type == reflection::Double; }

void append_double(double value, bool single, std::string& out) {
  if (!std::isfinite(value)) {
    out += "null";
    return;
  }
  char buffer[40];
  const auto end = single ? std::to_chars(buffer, buffer + sizeof buffer, static_cast<float>(value)).ptr
                          : std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  out.append(buffer, end);
}

/// Prints by walking schema and data together. Fields come in the order of their declaration.
class Printer {
 public:
  Printer(const Schema& schema, std::string& out) : schema_(schema), out_(out) {}

  void table(const Object& object, const flatbuffers::Table& table, int depth) {
    out_ += '{';
    bool first = true;
    for (uint16_t id = 0; id < object.fields()->size(); ++id)
      for (const Field* field : *object.fields()) {
        if (field->id() != id || !present(*field, table)) continue;
        out_ += first ? "\n" : ",\n";
        first = false;
        indent(depth + 1);
        out_ += json_quoted(field->name()->string_view());
        out_ += ": ";
        value(*field, table, depth + 1);
      }
    if (!first) {
      out_ += '\n';
      indent(depth);
    }
    out_ += '}';
  }

 private:
  void indent(int depth) { out_.append(2 * static_cast<size_t>(depth), ' '); }

  /// Scalars always print, with their default; what is stored elsewhere prints if it is there.
  static bool present(const Field& field, const flatbuffers::Table& table) {
    return field.type()->base_type() < reflection::String || table.CheckField(field.offset());
  }

  void scalar(BaseType type, const uint8_t* data) {
    if (is_float(type))
      append_double(flatbuffers::GetAnyValueF(type, data), type == reflection::Float, out_);
    else if (type == reflection::Bool)
      out_ += *data ? "true" : "false";
    else if (type == reflection::ULong)
      out_ += std::to_string(flatbuffers::ReadScalar<uint64_t>(data));
    else
      out_ += std::to_string(flatbuffers::GetAnyValueI(type, data));
  }

  /// A value of an enum by its name: numbers say nothing to who reads, and change where a name is put between others.
  void named(int index, int64_t number) {
    const auto* value = schema_.enums()->Get(static_cast<flatbuffers::uoffset_t>(index))->values()->LookupByKey(number);
    out_ += value ? json_quoted(value->name()->string_view()) : std::to_string(number);
  }

  /// Structs are small records of numbers: an array in the order of their fields, nested as they are.
  void structure(const Object& object, const uint8_t* data) {
    out_ += '[';
    for (uint16_t id = 0; id < object.fields()->size(); ++id)
      for (const Field* field : *object.fields()) {
        if (field->id() != id) continue;
        if (id) out_ += ", ";
        const auto* type = field->type();
        if (type->base_type() == reflection::Obj)
          structure(*schema_.objects()->Get(type->index()), data + field->offset());
        else
          scalar(type->base_type(), data + field->offset());
      }
    out_ += ']';
  }

  void value(const Field& field, const flatbuffers::Table& table, int depth) {
    const auto* type = field.type();
    switch (type->base_type()) {
      case reflection::String:
        out_ += json_quoted(table.GetPointer<const flatbuffers::String*>(field.offset())->string_view());
        break;
      case reflection::Vector:
        vector(field, table, depth);
        break;
      case reflection::Obj: {
        const Object& object = *schema_.objects()->Get(type->index());
        if (object.is_struct())
          structure(object, table.GetStruct<const uint8_t*>(field.offset()));
        else
          this->table(object, *table.GetPointer<const flatbuffers::Table*>(field.offset()), depth);
        break;
      }
      default:
        if (is_float(type->base_type()))
          append_double(flatbuffers::GetAnyFieldF(table, field), type->base_type() == reflection::Float, out_);
        else if (type->index() >= 0)
          named(type->index(), flatbuffers::GetAnyFieldI(table, field));
        else if (type->base_type() == reflection::Bool)
          out_ += flatbuffers::GetAnyFieldI(table, field) ? "true" : "false";
        else
          out_ += std::to_string(flatbuffers::GetAnyFieldI(table, field));
    }
  }

  void vector(const Field& field, const flatbuffers::Table& table, int depth) {
    const auto& list = *table.GetPointer<const flatbuffers::VectorOfAny*>(field.offset());
    const BaseType element = field.type()->element();
    const Object* object = element == reflection::Obj ? schema_.objects()->Get(field.type()->index()) : nullptr;
    const bool one_line = element < reflection::String || (object && object->is_struct() && list.size() <= 4);
    out_ += '[';
    for (flatbuffers::uoffset_t i = 0; i < list.size(); ++i) {
      if (i) out_ += one_line ? ", " : ",";
      if (!one_line) {
        out_ += '\n';
        indent(depth + 1);
      }
      if (object && object->is_struct())
        structure(*object, list.Data() + i * static_cast<size_t>(object->bytesize()));
      else if (object)
        this->table(*object, *flatbuffers::GetAnyVectorElemPointer<const flatbuffers::Table>(&list, i), depth + 1);
      else if (element == reflection::String)
        out_ += json_quoted(flatbuffers::GetAnyVectorElemPointer<const flatbuffers::String>(&list, i)->string_view());
      else if (field.type()->index() >= 0 && !is_float(element))
        named(field.type()->index(),
              flatbuffers::GetAnyValueI(element, list.Data() + i * flatbuffers::GetTypeSize(element)));
      else
        scalar(element, list.Data() + i * flatbuffers::GetTypeSize(element));
    }
    if (!one_line && list.size()) {
      out_ += '\n';
      indent(depth);
    }
    out_ += ']';
  }

  const Schema& schema_;
  std::string& out_;
};

}  // namespace

std::string verify_artifact(const plumbline_type& type, plumbline_bytes bytes) {
  if (bytes.size < 8 || !bytes.data) return "has " + std::to_string(bytes.size) + " bytes, too few for any artifact";
  const Schema& schema = schema_of(type);
  if (!flatbuffers::Verify(schema, *schema.root_table(), static_cast<const uint8_t*>(bytes.data), bytes.size, 64,
                           1u << 30)) {
    const std::string missing = missing_field(type, bytes);
    return missing.empty() ? std::string("is not a well-formed ") + type.name : missing;
  }
  return missing_field_of_verified(type, bytes);
}

std::string artifact_to_json(const plumbline_type& type, plumbline_bytes bytes) {
  const Schema& schema = schema_of(type);
  std::string out;
  Printer(schema, out)
      .table(*schema.root_table(), *flatbuffers::GetAnyRoot(static_cast<const uint8_t*>(bytes.data)), 0);
  out += '\n';
  return out;
}

}  // namespace plumbline::runtime

// plumbline-typegen SCHEMA.bfbs NAME: writes to standard output the C++ header `artifacts/NAME.hpp` of one artifact:
// the traits of its root table with type name, fingerprint and the schema itself.
//
// flatc never puts user attributes (units, frames) into its C++ output; they exist only in the binary schema, so the
// fingerprint that tells a millimetre from a metre is made here.
#include <flatbuffers/reflection.h>

#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <string>

namespace {

std::string attribute(const reflection::Field& field, const char* key) {
  if (field.attributes())
    if (const auto* found = field.attributes()->LookupByKey(key)) return found->value() ? found->value()->str() : "";
  return "";
}

std::string attribute(const reflection::Object& object, const char* key) {
  if (object.attributes())
    if (const auto* found = object.attributes()->LookupByKey(key)) return found->value() ? found->value()->str() : "";
  return "";
}

/// The text that is hashed: every field of the table and of what it holds, as "field:type~unit@frame;".
void describe(const reflection::Schema& schema, const reflection::Object& object, std::set<std::string>& seen,
              std::string& text) {
  if (!seen.insert(object.name()->str()).second) return;
  text += object.name()->str() + "{";
  std::set<const reflection::Object*> inner;
  // Fields in the order of their ids: the order of declaration, which is part of the layout.
  for (uint16_t id = 0; id < object.fields()->size(); ++id) {
    for (const auto* field : *object.fields()) {
      if (field->id() != id) continue;
      const auto type = field->type();
      text += field->name()->str() + ":" + reflection::EnumNameBaseType(type->base_type()) + "/" +
              reflection::EnumNameBaseType(type->element());
      const bool holds_object = type->base_type() == reflection::Obj || type->element() == reflection::Obj;
      if (holds_object) text += " " + schema.objects()->Get(type->index())->name()->str();
      text += "~" + attribute(*field, "unit") + "@" + attribute(*field, "frame") + ";";
      if (holds_object) inner.insert(schema.objects()->Get(type->index()));
    }
  }
  text += "}";
  for (const auto* field : *object.fields()) {
    const auto type = field->type();
    if (type->base_type() == reflection::Obj || type->element() == reflection::Obj)
      describe(schema, *schema.objects()->Get(type->index()), seen, text);
  }
}

/// FNV-1a, folded to 32 bits: this tells two builds apart, it protects from nobody.
uint32_t fingerprint(const std::string& text) {
  uint64_t hash = 0xcbf29ce484222325u;
  for (const unsigned char c : text) hash = (hash ^ c) * 0x100000001b3u;
  return static_cast<uint32_t>(hash ^ (hash >> 32));
}

void write_header(const std::string& bytes, const std::string& name) {
  flatbuffers::Verifier verifier(reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size());
  if (!reflection::VerifySchemaBuffer(verifier)) throw std::runtime_error("not a binary FlatBuffers schema");
  const reflection::Schema& schema = *reflection::GetSchema(bytes.data());
  const bool has_root = schema.root_table() != nullptr;
  const bool has_eigen = schema.objects()->LookupByKey("plumbline.Vec3") != nullptr;
  std::printf("// Generated from schemas: do not edit.\n#pragma once\n#include \"plumbline/artifact.hpp\"\n");
  std::printf("#include \"plumbline/plugin.h\"\n#include \"%s_generated.h\"\n", name.c_str());
  if (has_eigen) std::printf("#include \"plumbline/native_types_inline.hpp\"\n");
  if (!has_root) return;

  const reflection::Object& root = *schema.root_table();
  const std::string full = root.name()->str();
  const std::string table = full.substr(full.rfind('.') + 1);
  const std::string version = attribute(root, "artifact_version");
  if (version.empty()) throw std::runtime_error(full + ": the root table needs (artifact_version: \"1\")");
  std::string cpp_name = "::";
  for (const char c : full) cpp_name += c == '.' ? std::string("::") : std::string(1, c);
  std::string text;
  std::set<std::string> seen;
  describe(schema, root, seen, text);

  std::printf("namespace plumbline {\ntemplate <>\nstruct artifact_traits<%s> {\n", cpp_name.c_str());
  std::printf("  using Native = %sT;\n", cpp_name.c_str());
  std::printf("  static constexpr const char* name = \"%s/%s\";\n", full.c_str(), version.c_str());
  std::printf("  static constexpr const char* fingerprint = \"%08x\";\n", fingerprint(text));
  std::printf("  static const plumbline_type& type() {\n    alignas(8) static const unsigned char schema[] = {");
  for (size_t i = 0; i < bytes.size(); ++i)
    std::printf("%s%u,", i % 32 ? "" : "\n", static_cast<unsigned char>(bytes[i]));
  std::printf("};\n    static const plumbline_type entry = {sizeof(plumbline_type), 0, name, fingerprint,");
  std::printf(" {schema, sizeof schema}};\n    return entry;\n  }\n};\n}  // namespace plumbline\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    std::cerr << "usage: plumbline-typegen SCHEMA.bfbs NAME > NAME.hpp\n";
    return 2;
  }
  try {
    std::ifstream stream(argv[1], std::ios::binary);
    if (!stream) throw std::runtime_error("cannot read it");
    const std::string bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
    write_header(bytes, argv[2]);
  } catch (const std::exception& error) {
    std::cerr << argv[1] << ": " << error.what() << '\n';
    return 1;
  }
}

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
#include <stdexcept>
#include <string>

#include "plumbline/schema_fingerprint.hpp"

namespace {

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
  const std::string version = plumbline::detail::schema_attribute(root, "artifact_version");
  if (version.empty()) throw std::runtime_error(full + ": the root table needs (artifact_version: \"1\")");
  std::string cpp_name = "::";
  for (const char c : full) cpp_name += c == '.' ? std::string("::") : std::string(1, c);
  std::printf("namespace plumbline {\ntemplate <>\nstruct artifact_traits<%s> {\n", cpp_name.c_str());
  std::printf("  using Native = %sT;\n", cpp_name.c_str());
  std::printf("  static constexpr const char* name = \"%s/%s\";\n", full.c_str(), version.c_str());
  std::printf("  static constexpr const char* fingerprint = \"%s\";\n", plumbline::schema_fingerprint(schema).c_str());
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

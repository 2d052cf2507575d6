// The lint of schemas/artifacts: every field documented, with unit and frame, and safe when it is absent.
#include <flatbuffers/reflection.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "test_support.hpp"

namespace test_schemas {

namespace fs = std::filesystem;
using reflection::BaseType;

std::string attribute(const flatbuffers::Vector<flatbuffers::Offset<reflection::KeyValue>>* list, const char* key) {
  if (!list) return "";
  const auto* found = list->LookupByKey(key);
  return found && found->value() ? found->value()->str() : "";
}

bool has_attribute(const reflection::Field& field, const char* key) {
  return field.attributes() && field.attributes()->LookupByKey(key);
}

bool documented(const flatbuffers::Vector<flatbuffers::Offset<flatbuffers::String>>* text) {
  return text && text->size() && text->Get(0)->size() > 3;
}

/// What the rules at the head of common.fbs ask of one field of a table.
std::string field_problem(const reflection::Schema& schema, const reflection::Field& field,
                          const std::set<std::string>& frames) {
  const auto* type = field.type();
  const BaseType element = type->base_type() == reflection::Vector ? type->element() : type->base_type();
  const auto* object = element == reflection::Obj ? schema.objects()->Get(type->index()) : nullptr;
  const bool is_struct = object && object->is_struct();
  const bool floating = element == reflection::Float || element == reflection::Double;
  if (!documented(field.documentation())) return "has no comment";
  if ((floating || is_struct) && attribute(field.attributes(), "unit").empty()) return "has no unit";
  if (is_struct && type->base_type() == reflection::Obj && !(field.required() && has_attribute(field, "native_inline")))
    return "is a struct and must be (required, native_inline)";
  // A factor that is absent is one: nothing was scaled. Everything else that is absent is unknown, and 0 would read as
  // perfect.
  const bool neutral = field.name()->str().ends_with("_factor") && field.default_real() == 1;
  if (floating && type->base_type() != reflection::Vector && !std::isnan(field.default_real()) && !neutral)
    return "is a floating scalar and must default to nan";
  const std::string frame = attribute(field.attributes(), "frame");
  static const std::set<std::string> fixed = {"plate", "image", "camera", "station", "element", "facade", "panel"};
  if (!frame.empty() && !frames.count(frame) && !fixed.count(frame))
    return "is in frame '" + frame + "', which is neither a frame parameter of the root nor a fixed name";
  return "";
}

std::set<std::string> frame_parameters(const reflection::Schema& schema) {
  std::set<std::string> names;
  if (!schema.root_table()) return names;
  std::istringstream list(attribute(schema.root_table()->attributes(), "frames"));
  for (std::string name; std::getline(list, name, ',');) names.insert(name);
  return names;
}

std::string schema_problems(const fs::path& file) {
  const std::string bytes = plumbline::test::read_file(file);
  const reflection::Schema& schema = *reflection::GetSchema(bytes.data());
  std::string text;
  const auto complain = [&](const std::string& where, const std::string& what) {
    text += file.filename().string() + ": " + where + " " + what + "\n";
  };
  const auto frames = frame_parameters(schema);
  for (const auto* object : *schema.objects()) {
    if (object->is_struct()) continue;
    if (!documented(object->documentation())) complain(object->name()->str(), "has no comment");
    for (const auto* field : *object->fields()) {
      // A table that is included brings its own frames with it; they are checked in its own file.
      const std::string problem = field_problem(schema, *field, frames);
      const bool foreign_frame = problem.find("is in frame") == 0 && object != schema.root_table() && frames.empty();
      if (!problem.empty() && !foreign_frame) complain(object->name()->str() + "." + field->name()->str(), problem);
    }
  }
  if (schema.root_table() && attribute(schema.root_table()->attributes(), "artifact_version").empty())
    complain(schema.root_table()->name()->str(), "has no artifact_version");
  return text;
}

TEST(ArtifactSchemas, EveryFieldHasCommentUnitAndASafeDefault) {
  int checked = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(plumbline::test::binary_dir()) /
                                                  "framework/include/plumbline_artifacts/artifacts")) {
    if (entry.path().extension() != ".bfbs") continue;
    EXPECT_EQ(schema_problems(entry.path()), "");
    ++checked;
  }
  EXPECT_GT(checked, 5);
}

}  // namespace test_schemas

// schemas/pipeline.schema.json is what `plumbline schema` prints, it accepts every shipped pipeline, and refuses
// mistakes.
#include <yaml-cpp/yaml.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validation_results.hpp>
#include <valijson/validator.hpp>

#include "test_support.hpp"

namespace plumbline::test {
namespace test_pipeline_schema {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Scalars as YAML's core schema reads them, which is what editors do.
Json to_json(const YAML::Node& node) {
  Json json;
  if (node.IsMap()) {
    json = Json::object();
    for (const auto& item : node) json[item.first.Scalar()] = to_json(item.second);
  } else if (node.IsSequence()) {
    json = Json::array();
    for (const auto& item : node) json.push_back(to_json(item));
  } else if (node.IsScalar()) {
    if (node.Tag() == "!") return node.Scalar();  // quoted
    if (node.Scalar() == "true" || node.Scalar() == "false") return node.Scalar() == "true";
    const Json number = Json::parse(node.Scalar(), nullptr, false);
    json = number.is_number() ? number : Json(node.Scalar());
  }
  return json;
}

std::string problems_of(const Json& schema_json, const Json& pipeline) {
  valijson::Schema schema;
  valijson::SchemaParser parser;
  const valijson::adapters::NlohmannJsonAdapter schema_adapter(schema_json), adapter(pipeline);
  parser.populateSchema(schema_adapter, schema);
  valijson::Validator validator;
  valijson::ValidationResults results;
  std::string text;
  if (validator.validate(schema, adapter, &results)) return text;
  for (valijson::ValidationResults::Error error; results.popError(error);) {
    for (const std::string& step : error.context) text += step;
    text += ": " + error.description + "\n";
  }
  return text;
}

std::string printed_schema() {
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(PLUMBLINE_PROGRAM " schema", "r"), &pclose);
  std::string text;
  char buffer[4096];
  while (const size_t got = std::fread(buffer, 1, sizeof buffer, pipe.get())) text.append(buffer, got);
  return text;
}

const fs::path source = plumbline::test::source_dir();

TEST(PipelineSchema, IsWhereEditorsLookForIt) {
  EXPECT_TRUE(printed_schema() == read_file(source / "schemas" / "pipeline.schema.json"))
      << "the nodes have changed: build the target pipeline_schema";
}

TEST(PipelineSchema, AcceptsEveryShippedPipeline) {
  const Json schema = Json::parse(printed_schema());
  for (const auto& entry : fs::recursive_directory_iterator(source / "pipelines")) {
    if (entry.path().extension() != ".yaml") continue;
    EXPECT_EQ(problems_of(schema, to_json(YAML::LoadFile(entry.path()))), "") << entry.path();
  }
}

TEST(PipelineSchema, RefusesMistakes) {
  const Json schema = Json::parse(printed_schema());
  const auto accepts = [&](const std::string& text) { return problems_of(schema, to_json(YAML::Load(text))).empty(); };
  EXPECT_TRUE(accepts("plumbline: 1\nnodes: {a: {use: read.file, with: {file: x.txt}}}"));
  EXPECT_TRUE(accepts("plumbline: 1\nnodes: {a: {use: read.file, with: {file: \"${file}\"}}}"));
  EXPECT_FALSE(accepts("nodes: {a: {use: read.file}}")) << "the version is missing";
  EXPECT_FALSE(accepts("plumbline: 1\nnodes: {a: {use: read.fiel}}"));
  EXPECT_FALSE(accepts("plumbline: 1\nnodes: {a: {use: read.file, with: {fiel: x}}}"));
  EXPECT_FALSE(accepts("plumbline: 1\nnodes: {a: {use: read.file, wiht: {file: x}}}"));
  EXPECT_FALSE(accepts("plumbline: 1\nnode: {}"));
}

}  // namespace test_pipeline_schema
}  // namespace plumbline::test

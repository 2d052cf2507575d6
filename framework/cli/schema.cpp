// plumbline schema: the JSON Schema of pipeline files, made from the declarations of all nodes, for editors.
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"

namespace plumbline::cli {

using Json = nlohmann::ordered_json;

namespace {

/// Every value may also be a text with a variable in it: "${floors}".
Json or_variable(Json value) { return {{"anyOf", {std::move(value), {{"$ref", "#/$defs/variable"}}}}}; }

Json value_schema(const plumbline_param& param) {
  Json value;
  switch (param.kind) {
    case PLUMBLINE_NUMBER:
    case PLUMBLINE_INTEGER:
      value["type"] = param.kind == PLUMBLINE_NUMBER ? "number" : "integer";
      if (std::isfinite(param.minimum)) value["minimum"] = param.minimum;
      if (std::isfinite(param.maximum)) value["maximum"] = param.maximum;
      break;
    case PLUMBLINE_BOOLEAN:
      value["type"] = "boolean";
      break;
    default:
      // A number or a date without quotes is as good a text as any.
      value["type"] = {"string", "number", "boolean"};
      if (param.choice_count)
        value = {{"enum", std::vector<std::string>(param.choices, param.choices + param.choice_count)}};
  }
  return or_variable(std::move(value));
}

Json param_schema(const plumbline_param& param) {
  Json json = value_schema(param);
  if (param.is_list) json = {{"anyOf", {{{"type", "array"}, {"items", json}}, json}}};
  std::string doc = param.doc;
  if (*param.unit) doc += std::string(" [") + param.unit + "]";
  doc += param.default_text ? std::string("; default ") + (*param.default_text ? param.default_text : "empty")
                            : "; required";
  for (char& c : doc)
    if (c == '\x1f') c = ',';
  json["description"] = doc;
  return json;
}

Json node_schema(const plumbline_node& node) {
  Json inputs = Json::object(), required_inputs = Json::array();
  for (uint32_t i = 0; i < node.input_count; ++i) {
    const plumbline_port& port = *node.inputs[i];
    const bool many = port.cardinality == PLUMBLINE_LIST || port.cardinality == PLUMBLINE_EACH;
    inputs[port.name] = {{"$ref", many ? "#/$defs/sources" : "#/$defs/source"},
                         {"description", std::string(port.type) + ": " + port.doc}};
    if (port.cardinality != PLUMBLINE_OPTIONAL) required_inputs.push_back(port.name);
  }
  Json with = Json::object();
  for (uint32_t i = 0; i < node.param_count; ++i) with[node.params[i]->name] = param_schema(*node.params[i]);
  Json in_schema{{"type", "object"}, {"additionalProperties", false}, {"properties", inputs}};
  Json with_schema{{"type", "object"}, {"additionalProperties", false}, {"properties", with}};
  return {{"if", {{"properties", {{"use", {{"const", node.kind}}}}}, {"required", {"use"}}}},
          {"then", {{"properties", {{"in", in_schema}, {"with", with_schema}}}}}};
}

}  // namespace

int schema(const Options&) {
  const runtime::Registry registry = discover();
  Json kinds = Json::array(), rules = Json::array();
  for (const auto& [name, kind] : registry.kinds()) {
    kinds.push_back({{"const", name}, {"description", kind.node->summary}});
    rules.push_back(node_schema(*kind.node));
  }
  kinds.push_back({{"$ref", "#/$defs/variable"}});
  const Json scalar{{"type", {"string", "number", "boolean", "null"}}};
  const Json node{
      {"type", "object"},
      {"additionalProperties", false},
      {"properties",
       {{"use", {{"anyOf", kinds}}},
        {"in", {{"type", "object"}}},
        {"with", {{"type", "object"}}},
        {"each",
         {{"type", "string"}, {"description", "an input that takes one item: the node runs for each item of a list"}}},
        {"for_each",
         {{"type", "string"},
          {"description",
           "ROLE or ROLE.PARAMETER: one node for each kind of the role (that has the parameter); "
           "${kind} is its name, ${kind.PARAMETER} its default"}}},
        {"isolate",
         {{"anyOf", {{{"enum", {"process", "no"}}}, {{"$ref", "#/$defs/variable"}}}},
          {"description", "process: run it in a process of its own"}}},
        {"time_limit", {{"type", {"string", "number"}}, {"description", "90 s or 5 min; implies isolate: process"}}},
        {"memory_limit", {{"type", {"string", "number"}}, {"description", "2GiB; implies isolate: process"}}}}},
      {"allOf", rules}};
  const Json include{{"anyOf", {{{"type", "string"}}, {{"type", "array"}, {"items", {{"type", "string"}}}}}},
                     {"description", "pipelines to start from, relative to this file; what stands here replaces"}};
  const Json source{{"$ref", "#/$defs/source"}};
  const Json carried{{"anyOf",
                      {source,
                       {{"type", "object"},
                        {"additionalProperties", false},
                        {"required", {"next"}},
                        {"properties", {{"first", source}, {"next", source}}}}}}};
  const Json rounds{
      {"type", "object"},
      {"additionalProperties", false},
      {"properties",
       {{"carry",
         {{"type", "object"},
          {"additionalProperties", carried},
          {"description", "name: what the next round takes as rounds.NAME, and what the first takes in its place"}}},
        {"until", {{"type", "string"}, {"description", "node.metric (above 0) or node.metric < 0.1"}}},
        {"most", or_variable({{"type", "integer"}, {"minimum", 1}})}}},
      {"description", "what one round gives the next one takes, until a metric says that it is enough"}};
  const Json document{
      {"$schema", "http://json-schema.org/draft-07/schema#"},
      {"title", "Plumbline pipeline"},
      {"type", "object"},
      {"required", {"plumbline"}},
      {"additionalProperties", false},
      {"properties",
       {{"plumbline", {{"const", 1}, {"description", "version of the format"}}},
        {"include", include},
        {"vars",
         {{"type", "object"},
          {"additionalProperties", scalar},
          {"description", "names and values for ${name}; without a value it must be given on the command line"}}},
        {"rounds", rounds},
        {"nodes", {{"type", "object"}, {"additionalProperties", {{"$ref", "#/$defs/node"}}}}},
        {"outputs",
         {{"type", "object"},
          {"additionalProperties", {{"$ref", "#/$defs/source"}}},
          {"description", "file name under the output folder: node.port"}}}}},
      {"$defs",
       {{"variable", {{"type", "string"}, {"pattern", "\\$\\{[^}]+\\}"}}},
        {"source", {{"type", "string"}, {"pattern", "^[^.]+\\..+$|\\$\\{"}, {"description", "node.port"}}},
        {"sources",
         {{"anyOf", Json::array({Json{{"$ref", "#/$defs/source"}},
                                 Json{{"type", "array"}, {"items", Json{{"$ref", "#/$defs/source"}}}}})}}},
        {"node", node}}}};
  std::printf("%s\n", document.dump(1).c_str());
  return 0;
}

}  // namespace plumbline::cli

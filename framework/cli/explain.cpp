// plumbline list pipelines, artifacts; describe PIPELINE, ARTIFACT
#include <algorithm>
#include <cctype>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>

#include "commands.hpp"
#include "runtime/graph/pipeline_doc.hpp"
#include "runtime/plugins/type_doc.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

/// Shipped and local pipelines that can be run by name.
std::map<std::string, fs::path> pipelines() {
  std::map<std::string, fs::path> found;
  std::error_code failed;
  for (const fs::path& folder : pipeline_folders())
    for (const auto& entry : fs::directory_iterator(folder, failed))
      if (entry.path().extension() == ".yaml") found.emplace(entry.path().stem().string(), entry.path());
  return found;
}

std::string first_sentence(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  for (size_t i = 0; i + 2 < text.size(); ++i)
    if (text.compare(i, 2, ". ") == 0 &&
        (std::isupper(static_cast<unsigned char>(text[i + 2])) != 0 || text.compare(i + 2, 5, "docs/") == 0 ||
         text.compare(i + 2, 13, "plumbline run") == 0))
      text.resize(i + 1);
  // "…: plumbline run NAME folder=…" tells how; the variables say the same.
  if (const size_t how = text.find(": plumbline run"); how != std::string::npos) text.resize(how);
  return text;
}

/// What a variable is: its comment in the file, else what the parameter that takes it says.
std::string doc_of(const runtime::VariableDoc& variable, const runtime::Registry& registry) {
  if (!variable.comment.empty()) return variable.comment;
  for (const auto& use : variable.uses)
    if (const runtime::Kind* kind = registry.find(use.kind))
      if (const plumbline_param* param = kind->param(use.parameter)) return param->doc;
  return "";
}

std::string unit_of(const runtime::VariableDoc& variable, const runtime::Registry& registry) {
  for (const auto& use : variable.uses)
    if (const runtime::Kind* kind = registry.find(use.kind))
      if (const plumbline_param* param = kind->param(use.parameter)) return param->unit;
  return "";
}

}  // namespace

std::vector<std::string> names_of_pipelines_and_artifacts(const runtime::Registry& registry) {
  std::vector<std::string> names;
  for (const auto& [name, file] : pipelines()) names.push_back(name);
  for (const auto& [name, type] : registry.types()) {
    const std::string bare = name.substr(0, name.find('/'));
    names.push_back(bare.substr(bare.rfind('.') + 1));
  }
  return names;
}

int list_pipelines(const Options& options) {
  Json json = Json::array();
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, file] : pipelines()) {
    const runtime::PipelineDoc doc = runtime::read_pipeline_doc(file, pipeline_folders());
    std::string needs;
    for (const auto& variable : doc.variables)
      if (variable.required) needs += (needs.empty() ? "" : " ") + variable.name + "=";
    json.push_back({{"name", name},
                    {"file", file.string()},
                    {"sentence", first_sentence(doc.summary)},
                    {"summary", doc.summary},
                    {"needs", needs}});
    rows.push_back({name, needs, first_sentence(doc.summary)});
  }
  std::printf("%s", options.json ? (json.dump(1) + "\n").c_str() : columns(rows).c_str());
  return 0;
}

int list_artifacts(const Options& options) {
  const std::regex source(
      " \\(libraries/[^) ]*\\)");  // for who changes the tree; as one word it is wider than a screen
  const runtime::Registry registry = discover();
  Json json = Json::array();
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, type] : registry.types()) {
    const std::string doc = runtime::tables_of(*type).front().doc;
    json.push_back({{"type", name}, {"doc", doc}});
    rows.push_back({name, std::regex_replace(doc, source, "")});
  }
  std::printf("%s", options.json ? (json.dump(1) + "\n").c_str() : columns(rows).c_str());
  return 0;
}

bool describe_pipeline(const Options& options, const runtime::Registry& registry) {
  const auto known = pipelines();
  const auto found = known.find(options.name);
  const fs::path file = found != known.end() ? found->second : fs::path(options.name);
  if (found == known.end() && (file.extension() != ".yaml" || !fs::is_regular_file(file))) return false;
  const runtime::PipelineDoc doc = runtime::read_pipeline_doc(file, pipeline_folders());
  if (options.json) {
    Json variables = Json::array();
    for (const auto& v : doc.variables) {
      Json uses = Json::array();
      for (const auto& use : v.uses) uses.push_back(use.node + ".with." + use.parameter);
      variables.push_back({{"name", v.name},
                           {"default", v.required ? Json() : Json(v.value)},
                           {"unit", unit_of(v, registry)},
                           {"doc", doc_of(v, registry)},
                           {"sets", uses}});
    }
    std::printf("%s\n", Json{{"pipeline", file.stem().string()},
                             {"file", file.string()},
                             {"summary", doc.summary},
                             {"variables", variables},
                             {"outputs", doc.outputs}}
                            .dump(1)
                            .c_str());
    return true;
  }
  print_title(file.stem().string(), file.string());
  std::printf("\n%s", columns({{doc.summary}}).c_str());
  std::vector<std::vector<std::string>> rows;
  for (const auto& v : doc.variables)
    rows.push_back(
        {"  " + v.name, v.required ? "required" : "= " + v.value, unit_of(v, registry), doc_of(v, registry)});
  if (!rows.empty()) std::printf("\n%s\n%s", paint(Colour::bold, "variables").c_str(), columns(rows).c_str());
  if (!doc.outputs.empty()) {
    std::string all;
    for (const std::string& output : doc.outputs) all += (all.empty() ? "" : ", ") + output;
    std::printf("\n%s\n%s", paint(Colour::bold, "outputs").c_str(), columns({{" ", all}}).c_str());
  }
  std::printf("\n`plumbline graph %s` draws it.\n", file.stem().c_str());
  return true;
}

bool describe_artifact(const Options& options, const runtime::Registry& registry) {
  const plumbline_type* type = nullptr;
  for (const auto& [name, candidate] : registry.types()) {
    const std::string bare = name.substr(0, name.find('/'));
    if (options.name == name || options.name == bare || options.name == bare.substr(bare.rfind('.') + 1))
      type = candidate;
  }
  if (!type) return false;
  const auto tables = runtime::tables_of(*type);
  if (options.json) {
    Json json = Json::array();
    for (const auto& table : tables) {
      Json fields = Json::array();
      for (const auto& f : table.fields)
        fields.push_back({{"name", f.name},
                          {"type", f.type},
                          {"required", f.required},
                          {"unit", f.unit},
                          {"frame", f.frame},
                          {"doc", f.doc}});
      json.push_back({{"table", table.name}, {"doc", table.doc}, {"fields", fields}});
    }
    std::printf("%s\n",
                Json{{"type", type->name}, {"fingerprint", type->fingerprint}, {"tables", json}}.dump(1).c_str());
    return true;
  }
  for (const auto& table : tables) {
    const bool root = &table == &tables.front();
    if (!root) std::printf("\n");
    print_title(root ? type->name : table.name, table.doc);
    std::vector<std::vector<std::string>> rows;
    for (const auto& f : table.fields)
      rows.push_back({"  " + f.name, f.type, f.required ? "required" : "", f.unit, f.doc});
    std::printf("%s", columns(rows).c_str());
  }
  return true;
}

}  // namespace plumbline::cli

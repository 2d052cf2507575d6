// plumbline list, describe
#include <fmt/core.h>

#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "linked_licences.hpp"
#include "runtime/base/printable.hpp"
#include "terminal.hpp"

namespace plumbline::cli {

using Json = nlohmann::ordered_json;

namespace {

const char* cardinality_text(uint32_t cardinality) {
  static constexpr const char* names[] = {"one", "optional", "list", "each"};
  return cardinality < 4 ? names[cardinality] : "?";
}

std::string kind_text(const plumbline_param& param) {
  static constexpr const char* names[] = {"number", "integer", "boolean", "text", "file", "folder"};
  return std::string(param.is_list ? "list of " : "") + (param.kind < 6 ? names[param.kind] : "?");
}

std::string type_text(const plumbline_port& port) {
  return port.type + (*port.frames ? "<" + std::string(port.frames) + ">" : "");
}

std::string shown(const char* text) {
  std::string result = text;
  for (char& c : result)
    if (c == '\x1f') c = ',';
  return result;
}

Json ports_json(const plumbline_port* const* ports, uint32_t count) {
  Json json = Json::array();
  for (uint32_t i = 0; i < count; ++i)
    json.push_back({{"name", ports[i]->name},
                    {"type", ports[i]->type},
                    {"frames", ports[i]->frames},
                    {"fingerprint", ports[i]->fingerprint},
                    {"cardinality", cardinality_text(ports[i]->cardinality)},
                    {"doc", ports[i]->doc}});
  return json;
}

Json param_json(const plumbline_param& param) {
  Json json{{"name", param.name}, {"kind", kind_text(param)}};
  json["default"] = param.default_text ? Json(shown(param.default_text)) : Json();
  if (*param.unit) json["unit"] = param.unit;
  if (std::isfinite(param.minimum)) json["minimum"] = param.minimum;
  if (std::isfinite(param.maximum)) json["maximum"] = param.maximum;
  if (param.choice_count) json["choices"] = std::vector<std::string>(param.choices, param.choices + param.choice_count);
  json["doc"] = param.doc;
  return json;
}

Json kind_json(const runtime::Kind& kind) {
  const plumbline_node& node = *kind.node;
  Json linked = Json::array();
  for (const LinkedLicence& l : copyleft_libraries(*kind.plugin))
    linked.push_back({{"library", l.library}, {"licence", l.licence}});
  Json json{{"kind", node.kind},
            {"role", node.role},
            {"summary", node.summary},
            {"version", node.version},
            {"deterministic", node.deterministic != 0},
            {"lacks", node.lacks},
            {"plugin", kind.plugin->identity.name},
            {"plugin_version", kind.plugin->identity.version},
            {"licence", kind.plugin->identity.licence},
            {"linked", linked},
            {"inputs", ports_json(node.inputs, node.input_count)},
            {"outputs", ports_json(node.outputs, node.output_count)}};
  json["parameters"] = Json::array();
  for (uint32_t i = 0; i < node.param_count; ++i) json["parameters"].push_back(param_json(*node.params[i]));
  return json;
}

void print_ports(const char* title, const plumbline_port* const* ports, uint32_t count) {
  if (count == 0) return;
  std::vector<std::vector<std::string>> rows;
  for (uint32_t i = 0; i < count; ++i)
    rows.push_back({"  " + std::string(ports[i]->name), type_text(*ports[i]),
                    ports[i]->cardinality == PLUMBLINE_ONE ? "" : cardinality_text(ports[i]->cardinality),
                    ports[i]->doc});
  std::printf("\n%s\n%s", paint(Colour::bold, title).c_str(), columns(rows).c_str());
}

/// "0.1 … 100 m", "epnp, upnp"
std::string range_text(const plumbline_param& param) {
  std::string text;
  for (uint32_t i = 0; i < param.choice_count; ++i) text += (i ? ", " : "") + std::string(param.choices[i]);
  const auto number = [](double value) { return fmt::format("{:.12g}", value); };
  const bool low = std::isfinite(param.minimum), high = std::isfinite(param.maximum);
  if (low && high)
    text += number(param.minimum) + " … " + number(param.maximum);
  else if (low)
    text += "≥ " + number(param.minimum);
  else if (high)
    text += "≤ " + number(param.maximum);
  return text;
}

}  // namespace

namespace {

/// What is there and cannot be used. Of what another plugin hides both files are named: either may be the one that is
/// meant.
void tell_refused(const runtime::Registry& registry) {
  size_t refused = 0;
  for (const auto& one : registry.refused()) {
    refused += one.hidden_by.empty();
    if (!one.hidden_by.empty())
      std::fprintf(stderr, "warning: %s %s\n", one.path.c_str(), runtime::printable(one.problem).c_str());
  }
  if (refused > 0)
    std::fprintf(stderr,
                 refused == 1 ? "%zu plugin was refused; `plumbline doctor` says why\n"
                              : "%zu plugins were refused; `plumbline doctor` says why\n",
                 refused);
}

}  // namespace

int list(const Options& options) {
  if (options.name == "pipelines") return list_pipelines(options);
  if (options.name == "artifacts") return list_artifacts(options);
  if (options.name == "errors") return list_errors(options);
  const runtime::Registry registry = discover();
  Json json = Json::array();
  std::vector<std::vector<std::string>> rows;
  for (const auto& [name, kind] : registry.kinds()) {
    if (!options.role.empty() && options.role != kind.node->role) continue;
    json.push_back({{"kind", name}, {"role", kind.node->role}, {"summary", kind.node->summary}});
    rows.push_back({name, kind.node->role, kind.node->summary});
  }
  if (options.json)
    std::printf("%s\n", json.dump(1).c_str());
  else
    std::printf("%s", columns(rows).c_str());
  tell_refused(registry);
  return 0;
}

int describe(const Options& options) {
  const runtime::Registry registry = discover();
  const runtime::Kind* kind = registry.find(options.name);
  if (!kind) {
    if (describe_pipeline(options, registry) || describe_artifact(options, registry)) return 0;
    std::vector<std::string> names = names_of_pipelines_and_artifacts(registry);
    for (const auto& [name, entry] : registry.kinds()) names.push_back(name);
    std::string bare = options.name.substr(0, options.name.find('/'));
    if (bare.rfind("plumbline.", 0) == 0) bare.erase(0, bare.find('.') + 1);
    const std::string hint = did_you_mean(bare, names);
    throw UsageError(
        "there is no node, pipeline or artifact '" + options.name + "'" +
        (hint.empty() ? "; `plumbline list`, `list pipelines` and `list artifacts` show what there is" : hint));
  }
  const std::string others = offered_too_by(registry, kind->node->kind);
  if (!others.empty())
    std::fprintf(stderr, "warning: %s is that of %s; %s\n", kind->node->kind, kind->plugin->identity.path.c_str(),
                 others.c_str());
  if (options.json) {
    std::printf("%s\n", kind_json(*kind).dump(1).c_str());
    return 0;
  }
  const plumbline_node& node = *kind->node;
  print_title(node.kind, node.summary);
  if (*node.role) std::printf("role %s%s%s, ", node.role, *node.lacks ? " without " : "", node.lacks);
  std::printf("version %u, plugin %s %s (%s)\n", node.version, kind->plugin->identity.name.c_str(),
              kind->plugin->identity.version.c_str(), kind->plugin->identity.licence.c_str());
  if (const std::string linked = licences_in_words(*kind->plugin); !linked.empty())
    std::printf("%s\n", lines(linked).c_str());
  print_ports("in", node.inputs, node.input_count);
  print_ports("out", node.outputs, node.output_count);
  if (node.param_count) {
    std::vector<std::vector<std::string>> rows;
    for (uint32_t i = 0; i < node.param_count; ++i) {
      const plumbline_param& param = *node.params[i];
      rows.push_back({"  " + std::string(param.name), kind_text(param),
                      param.default_text ? "= " + shown(param.default_text) : "required", param.unit, range_text(param),
                      param.doc});
    }
    std::printf("\n%s\n%s", paint(Colour::bold, "with").c_str(), columns(rows).c_str());
  }
  return 0;
}

}  // namespace plumbline::cli

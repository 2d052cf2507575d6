#include "runtime/sweep/sweep_places.hpp"

#include "runtime/base/near_names.hpp"
#include "runtime/graph/pipeline_file.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

/// The file's pipeline and those of scenarios and alternatives, as they stand before anything is overridden but by the
/// command line.
std::map<fs::path, PipelineSpec> pipelines_of(const SweepFile& file, const Overrides& overrides) {
  std::map<fs::path, PipelineSpec> specs;
  std::vector<Problem> ignored;  // load_pipeline() tells them
  const auto add = [&](const fs::path& path) {
    if (specs.count(path) == 0) specs[path] = read_pipeline(path, overrides, {}, ignored);
  };
  add(file.pipeline);
  for (const SweepScenario& scenario : file.scenarios)
    if (!scenario.pipeline.empty()) add(scenario.pipeline);
  for (const SweepGroup& group : file.groups)
    for (const SweepAlternative& alternative : group.alternatives)
      if (!alternative.pipeline.empty()) add(alternative.pipeline);
  return specs;
}

std::string role_of(const std::string& kind, const Registry& registry) {
  const Kind* found = registry.find(kind);
  return found ? found->node->role : "";
}

/// A list of kinds fills the node of the group's name, or the nodes of the role of that name.
void refuse_place(const std::string& group, const SweepAlternative& alternative,
                  const std::map<fs::path, PipelineSpec>& specs, const Registry& registry,
                  std::vector<Problem>& problems) {
  const std::string own = role_of(alternative.kind, registry);
  std::vector<std::string> names;
  std::string other;
  for (const auto& [path, spec] : specs)
    for (const NodeSpec& node : spec.nodes) {
      const std::string role = role_of(node.use.text, registry);
      names.push_back(node.name);
      if (!role.empty()) names.push_back(role);
      if (node.name != group && role != group) continue;
      if (own.empty() || role.empty() || own == role) return;
      other = "'" + alternative.kind + "' has the role '" + own + "', but '" + group + "' is filled by the role '" +
              role + "' (" + node.use.text + "): it cannot stand there";
    }
  const auto near = near_names(group, names);
  if (other.empty())
    other = "no pipeline of this bench has a node or a role '" + group + "' that '" + alternative.kind +
            "' could fill" + (near.empty() ? "" : " — did you mean '" + near[0] + "'?") +
            (own.empty() ? "" : " ('" + alternative.kind + "' has the role '" + own + "')");
  problems.push_back({alternative.at, other});
}

/// The same for "NODE.use=KIND".
void refuse_role(const SweepFile& file, const SweepAlternative& alternative, const std::string& text,
                 const std::map<fs::path, PipelineSpec>& specs, const Registry& registry,
                 std::vector<Problem>& problems) {
  const size_t dot = text.find('.'), equals = text.find('=');
  if (dot == std::string::npos || text.substr(dot, equals - dot) != ".use") return;
  const std::string name = text.substr(0, dot), kind = text.substr(equals + 1), own = role_of(kind, registry);
  const auto spec = specs.find(alternative.pipeline.empty() ? file.pipeline : alternative.pipeline);
  if (own.empty() || spec == specs.end()) return;
  for (const NodeSpec& node : spec->second.nodes) {
    const std::string role = role_of(node.use.text, registry);
    if (node.name == name && !role.empty() && role != own)
      problems.push_back({file.places.at(text), "'" + kind + "' has the role '" + own + "', but node '" + name +
                                                    "' is one of the role '" + role + "' (" + node.use.text +
                                                    "): it cannot stand there"});
  }
}

}  // namespace

fs::path pipeline_of(const SweepFile& file, const Combination& way) {
  fs::path pipeline = way.scenario->pipeline.empty() ? file.pipeline : way.scenario->pipeline;
  for (const auto& [group, choice] : way.choices)
    if (!choice->pipeline.empty()) pipeline = choice->pipeline;
  return pipeline;
}

std::string node_for(const fs::path& pipeline, const std::string& group, const Overrides& overrides,
                     const Registry& registry) {
  std::vector<Problem> ignored;  // load_pipeline() tells them
  const PipelineSpec spec = read_pipeline(pipeline, overrides, {}, ignored);
  std::vector<std::string> of_role;
  for (const NodeSpec& node : spec.nodes) {
    if (node.name == group) return group;
    const Kind* kind = registry.find(node.use.text);
    if (kind && group == kind->node->role) of_role.push_back(node.name);
  }
  if (of_role.size() == 1) return of_role[0];
  std::string names;
  for (const std::string& name : of_role) names += (names.empty() ? " (" : ", ") + name;
  throw std::runtime_error(pipeline.string() + " has " + (of_role.empty() ? "no node" : "several nodes" + names + ")") +
                           " of the role '" + group + "' and none of that name; name the node instead of the role");
}

void refuse_what_cannot_run(const SweepFile& file, const Overrides& overrides, const Registry& registry) {
  std::vector<Problem> problems;
  const std::map<fs::path, PipelineSpec> specs = pipelines_of(file, overrides);
  for (const auto& [path, spec] : specs)
    if (!file.seeds.empty() && !spec.nodes.empty() && spec.variables.count("seed") == 0)
      problems.push_back({file.seeds_at.file.empty() ? Position{file.path.string(), 0, 0} : file.seeds_at,
                          path.string() + " has no variable 'seed', so each of the " +
                              std::to_string(file.seeds.size()) +
                              " seeds would be the same trial: add it under its 'vars:' (seed: 1)"});
  for (const SweepGroup& group : file.groups)
    for (const SweepAlternative& alternative : group.alternatives) {
      if (!alternative.kind.empty()) refuse_place(group.name, alternative, specs, registry, problems);
      for (const std::string& text : alternative.overrides)
        refuse_role(file, alternative, text, specs, registry, problems);
    }
  if (!problems.empty()) throw InvalidPipeline(problems);
}

void refuse_unknown_kinds(const SweepFile& file, const Registry& registry) {
  std::vector<std::string> names;
  for (const auto& [name, kind] : registry.kinds()) names.push_back(name);
  std::vector<Problem> problems;
  for (const SweepGroup& group : file.groups)
    for (const SweepAlternative& alternative : group.alternatives) {
      if (alternative.kind.empty() || registry.find(alternative.kind)) continue;
      const auto near = near_names(alternative.kind, names);
      problems.push_back({alternative.at, "no plugin brings the kind '" + alternative.kind + "'" +
                                              (near.empty() ? "" : " — did you mean '" + near[0] + "'?") +
                                              " (plumbline list has all; with its plugin missing, take it out of '" +
                                              group.name + "')"});
    }
  if (!problems.empty()) throw InvalidPipeline(problems);
}

}  // namespace plumbline::runtime

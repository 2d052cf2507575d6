#include "runtime/graph/graph.hpp"

#include <algorithm>
#include <tuple>

#include "runtime/graph/graph_linker.hpp"
#include "runtime/graph/pipeline_file.hpp"

namespace plumbline::runtime {

std::string Position::text() const {
  return line > 0 ? file + ":" + std::to_string(line) + ":" + std::to_string(column) : file;
}

std::string label_of(const std::string& name, size_t round) {
  return round > 1 ? name + ", round " + std::to_string(round) : name;
}

std::string label_of(const GraphNode& node) { return label_of(node.name, node.round); }

namespace {

std::string join_problems(const std::vector<Problem>& problems) {
  std::string text;
  for (const Problem& problem : problems)
    text += (text.empty() ? "" : "\n") + problem.at.text() + ": " + problem.text();
  return text;
}

}  // namespace

std::string Problem::text() const {
  if (alike == 0) return message;
  return message + (alike == 1 ? " (and so does one other parameter that is given it)"
                               : " (and so do " + std::to_string(alike) + " others that are given it)");
}

InvalidPipeline::InvalidPipeline(std::vector<Problem> problems)
    : std::runtime_error(join_problems(problems)), problems_(std::move(problems)) {}

namespace {

Graph read_and_link(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                    const Registry& registry, const std::vector<std::filesystem::path>& include_folders,
                    std::vector<Problem>& problems) {
  const PipelineSpec spec = read_pipeline(file, overrides, include_folders, problems, &registry);
  Graph graph = link_pipeline(spec, registry, problems);
  if (problems.empty() && graph.nodes.empty())
    problems.push_back({{file.string(), 1, 1}, "this pipeline has no nodes"});
  graph.file = file.string();
  graph.overrides = overrides;
  if (const auto seed = spec.variables.find("seed"); seed != spec.variables.end()) {
    const bool digits = !seed->second.empty() && seed->second.size() < 19 &&
                        seed->second.find_first_not_of("0123456789") == std::string::npos;
    if (digits)
      graph.seed = std::stoull(seed->second);
    else
      problems.push_back(
          {{file.string(), 0, 0}, "the variable 'seed' is a whole number, found '" + seed->second + "'"});
  }
  std::stable_sort(problems.begin(), problems.end(), [](const Problem& a, const Problem& b) {
    return std::tie(a.at.file, a.at.line, a.at.column) < std::tie(b.at.file, b.at.line, b.at.column);
  });
  return graph;
}

/// A pipeline that is valid without the overrides of nodes: the one that breaks it comes first, then the first of what
/// does not fit. The rest follows from it.
void name_breaking_override(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                            const Registry& registry, const std::vector<std::filesystem::path>& include_folders,
                            std::vector<Problem>& problems) {
  const auto valid_with = [&](const std::vector<std::string>& some) {
    std::vector<Problem> found;
    read_and_link(file, some, registry, include_folders, found);
    return found.empty();
  };
  std::vector<std::string> basic, breaking;
  for (const std::string& text : overrides)
    if (!is_node_override(text)) basic.push_back(text);
  if (basic.size() == overrides.size() || !valid_with(basic)) return;
  for (const std::string& text : overrides) {
    if (!is_node_override(text)) continue;
    std::vector<std::string> with_one = basic;
    with_one.push_back(text);
    if (!valid_with(with_one)) breaking.push_back(text);
  }
  // What is wrong with an override itself names it already.
  for (const Problem& problem : problems)
    if (problem.at.line == 0 && problem.at.file[0] == '\'') return;
  std::string names;
  for (const std::string& text : breaking) names += (names.empty() ? "'" : ", '") + text + "'";
  constexpr size_t shown = 3;
  const size_t more = problems.size() > shown ? problems.size() - shown : 0;
  if (more) problems.resize(shown);
  problems.insert(problems.begin(),
                  {{names.empty() ? "the overrides together" : names, 0, 0},
                   std::string("without ") + (breaking.size() == 1 ? "it" : "them") + " the pipeline is valid, with " +
                       (breaking.size() == 1 ? "it" : "them") + " these things do not fit" +
                       (more ? ", and " + std::to_string(more) + " more that follow from them" : "") + ":"});
}

}  // namespace

std::vector<bool> changes_by_round(const Graph& graph) {
  std::vector<bool> changes(graph.nodes.size(), false);
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    changes[i] = !graph.nodes[i].carried.empty() || !graph.nodes[i].collected.empty();
    for (const auto& [port, source] : graph.nodes[i].inputs) changes[i] = changes[i] || changes[source.node];
  }
  return changes;
}

std::vector<bool> needed_by_rounds(const Graph& graph, const Rounds& rounds) {
  std::vector<bool> needed(graph.nodes.size(), false);
  for (const Carry& carry : rounds.carry) needed[carry.next.node] = true;
  if (rounds.until) needed[rounds.until->node] = true;
  for (size_t i = graph.nodes.size(); i-- > 0;)
    if (needed[i])
      for (const auto& [port, source] : graph.nodes[i].inputs) needed[source.node] = true;
  return needed;
}

Graph load_pipeline(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                    const Registry& registry, const std::vector<std::filesystem::path>& include_folders) {
  std::vector<Problem> problems;
  Graph graph = read_and_link(file, overrides, registry, include_folders, problems);
  if (problems.empty()) return graph;
  name_breaking_override(file, overrides, registry, include_folders, problems);
  throw InvalidPipeline(std::move(problems));
}

}  // namespace plumbline::runtime

#include "runtime/sweep/sweep_plan.hpp"

#include <algorithm>
#include <functional>
#include <set>

#include "runtime/base/digest.hpp"
#include "runtime/base/near_names.hpp"
#include "runtime/graph/pipeline_file.hpp"
#include "runtime/run/key.hpp"
#include "runtime/sweep/sweep_measures.hpp"
#include "runtime/sweep/sweep_settings.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

/// Names of the nodes that a metric is asked of.
std::set<std::string> measured_nodes(const SweepFile& file) {
  std::set<std::string> nodes;
  for (const auto& [quantity, metric] : file.measure) nodes.insert(metric.substr(0, metric.find('.')));
  return nodes;
}

/// The nodes of those names and all that they take from.
std::vector<bool> leading_to(const Graph& graph, const std::set<std::string>& wanted) {
  std::vector<bool> needed(graph.nodes.size(), false);
  if (graph.rounds.most > 0) needed = needed_by_rounds(graph, graph.rounds);
  for (size_t i = graph.nodes.size(); i-- > 0;) {
    if (wanted.count(graph.nodes[i].name)) needed[i] = true;
    if (needed[i])
      for (const auto& [port, source] : graph.nodes[i].inputs) needed[source.node] = true;
  }
  return needed;
}

Graph reduced(const Graph& graph, const std::set<std::string>& wanted) {
  const std::vector<bool> needed = leading_to(graph, wanted);
  Graph result = graph;
  result.nodes.clear();
  result.outputs.clear();
  std::vector<size_t> place(graph.nodes.size());
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    if (!needed[i]) continue;
    place[i] = result.nodes.size();
    result.nodes.push_back(graph.nodes[i]);
    for (auto& [port, source] : result.nodes.back().inputs) source.node = place[source.node];
  }
  for (Carry& carry : result.rounds.carry) {
    carry.next.node = place[carry.next.node];
    if (carry.first) carry.first->node = place[carry.first->node];
  }
  if (result.rounds.until) result.rounds.until->node = place[result.rounds.until->node];
  return result;
}

/// What comes from other rounds, and how many there may be.
void add_rounds(const Graph& graph, const GraphNode& node, KeyFields& fields) {
  for (const auto& [port, name] : node.carried) fields["carried " + port] = name;
  for (const auto& [port, name] : node.collected) fields["collected " + port] = name;
  if (node.carried.empty() && node.collected.empty()) return;
  // Named: what is kept of a cell has the inputs of the first round.
  std::string text = "first inputs, at most " + std::to_string(graph.rounds.most) +
                     (graph.rounds.until ? "\n" + graph.rounds.until->text : "");
  for (const Carry& carry : graph.rounds.carry) {
    text += "\n" + carry.name + " " + graph.nodes[carry.next.node].name + "." + carry.next.port;
    if (carry.first) text += " " + graph.nodes[carry.first->node].name + "." + carry.first->port;
  }
  fields["rounds"] = text;
}

/// A node draws its seed by its name, so that belongs to what it computes.
std::vector<std::string> recipes_of(const Graph& graph, FileHashes& hashes) {
  std::vector<std::string> recipes;
  for (const GraphNode& node : graph.nodes) {
    KeyFields fields = key_fields(node, hashes);
    fields["name"] = node.name;
    add_rounds(graph, node, fields);
    for (const auto& [port, source] : node.inputs) {
      std::string& text = fields["input " + port];
      text += (text.empty() ? "" : " ") + recipes[source.node] + "." + source.port;
    }
    recipes.push_back(key_of(fields));
  }
  return recipes;
}

/// Whether a value of the pipeline, of what it includes or of the overrides may hold ${seed}. In doubt it does.
bool names_seed(const Graph& graph) {
  const auto names = [](const std::string& text) { return text.find("seed}") != std::string::npos; };
  return std::any_of(graph.sources.begin(), graph.sources.end(), [&](const auto& s) { return names(s.text); }) ||
         std::any_of(graph.overrides.begin(), graph.overrides.end(), names);
}

/// One way to fill every place, without the seed.
struct Combination {
  const SweepScenario* scenario = nullptr;
  std::map<std::string, std::string> values;
  std::map<std::string, const SweepAlternative*> choices;
};

class Planner {
 public:
  Planner(const SweepFile& file, const Overrides& overrides, const Registry& registry, FileHashes& hashes)
      : overrides_(overrides),
        registry_(registry),
        hashes_(hashes),
        reach_(registry),
        given_(file.measure),
        wanted_(measured_nodes(file)) {
    plan_.file = file;
    plan_.overrides = overrides;
  }

  SweepPlan plan() {
    refuse_what_cannot_run();
    find_compared();
    for (const SweepScenario& scenario : file().scenarios) {
      Combination combination;
      combination.scenario = &scenario;
      each_value(combination, 0);
    }
    refuse_what_is_set_twice();
    refuse_what_never_holds();
    refuse_places_that_are_one();
    Sha256 id;
    std::vector<std::string> keys;
    for (const SweepCell& cell : plan_.cells) keys.push_back(cell.key);
    std::sort(keys.begin(), keys.end());
    for (const std::string& key : keys) id.add_field(key);
    plan_.id = id.hex().substr(0, 16);
    for (auto& [group, nodes] : swapped_) plan_.swapped[group].assign(nodes.begin(), nodes.end());
    return std::move(plan_);
  }

 private:
  const SweepFile& file() const { return plan_.file; }

  void each_value(Combination& combination, size_t variable) {
    if (variable == file().matrix.size()) return add_trials(combination);
    for (const std::string& value : file().matrix[variable].values) {
      combination.values[file().matrix[variable].name] = value;
      each_value(combination, variable + 1);
    }
  }

  /// All alternatives of one place, seed by seed.
  void add_trials(const Combination& place) {
    std::vector<Combination> ways{place};
    for (const SweepGroup& group : file().groups) {
      std::vector<Combination> more;
      for (const Combination& way : ways)
        for (const SweepAlternative& alternative : group.alternatives) {
          more.push_back(way);
          more.back().choices[group.name] = &alternative;
        }
      ways = std::move(more);
    }
    ways.erase(std::remove_if(ways.begin(), ways.end(), [&](const Combination& way) { return is_excluded(way); }),
               ways.end());
    std::vector<std::vector<SweepCell>> cells;
    for (const Combination& way : ways) cells.push_back(cells_of(way));
    const size_t seeds = std::max<size_t>(1, file().seeds.size());
    for (size_t k = 0; k < seeds; ++k) {
      // By turns a different alternative comes first, so that none always runs on the cold caches.
      for (size_t i = 0; i < cells.size(); ++i) {
        plan_.cells.push_back(std::move(cells[(i + k) % cells.size()][k]));
        plan_.cells.back().trial = plan_.trials;
      }
      plan_.trials += !cells.empty();
    }
  }

  static std::string value_of(const Combination& way, const std::string& key) {
    if (key == "scenario") return way.scenario->name;
    if (const auto value = way.values.find(key); value != way.values.end()) return value->second;
    return way.choices.at(key)->name;
  }

  bool is_excluded(const Combination& way) {
    for (const SweepExclusion& exclusion : file().exclude) {
      const bool all = std::all_of(exclusion.where.begin(), exclusion.where.end(),
                                   [&](const auto& pair) { return value_of(way, pair.first) == pair.second; });
      if (!all) continue;
      std::string what = way.scenario->name;
      for (const auto& [name, value] : way.values) what += (what.empty() ? "" : ", ") + name + "=" + value;
      for (const auto& [name, choice] : way.choices) what += (what.empty() ? "" : ", ") + name + "=" + choice->name;
      plan_.excluded.push_back({what, exclusion.why, std::max<size_t>(1, file().seeds.size())});
      return true;
    }
    return false;
  }

  fs::path pipeline_of(const Combination& way) const {
    fs::path pipeline = file().pipeline;
    for (const auto& [group, choice] : way.choices)
      if (!choice->pipeline.empty()) pipeline = choice->pipeline;
    return pipeline;
  }

  /// The file's pipeline and those of alternatives, as they stand before anything is overridden but by the command
  /// line.
  std::map<fs::path, PipelineSpec> pipelines() const {
    std::map<fs::path, PipelineSpec> specs;
    std::vector<Problem> ignored;  // load_pipeline() tells them
    const auto add = [&](const fs::path& path) {
      if (specs.count(path) == 0) specs[path] = read_pipeline(path, overrides_, {}, ignored);
    };
    add(file().pipeline);
    for (const SweepGroup& group : file().groups)
      for (const SweepAlternative& alternative : group.alternatives)
        if (!alternative.pipeline.empty()) add(alternative.pipeline);
    return specs;
  }

  std::string role_of(const std::string& kind) const {
    const Kind* found = registry_.find(kind);
    return found ? found->node->role : "";
  }

  /// What would make every cell of an alternative, or of the whole bench, fail one by one: a pipeline that takes no
  /// seed, and a kind in a place that no pipeline has, or that another role fills.
  void refuse_what_cannot_run() const {
    std::vector<Problem> problems;
    const std::map<fs::path, PipelineSpec> specs = pipelines();
    for (const auto& [path, spec] : specs)
      if (!file().seeds.empty() && !spec.nodes.empty() && spec.variables.count("seed") == 0)
        problems.push_back({file().seeds_at.file.empty() ? Position{file().path.string(), 0, 0} : file().seeds_at,
                            path.string() + " has no variable 'seed', so each of the " +
                                std::to_string(file().seeds.size()) +
                                " seeds would be the same trial: add it under its 'vars:' (seed: 1)"});
    for (const SweepGroup& group : file().groups)
      for (const SweepAlternative& alternative : group.alternatives) {
        if (!alternative.kind.empty()) refuse_place(group.name, alternative, specs, problems);
        for (const std::string& text : alternative.overrides) refuse_role(alternative, text, specs, problems);
      }
    if (!problems.empty()) throw InvalidPipeline(problems);
  }

  /// A list of kinds fills the node of the group's name, or the nodes of the role of that name.
  void refuse_place(const std::string& group, const SweepAlternative& alternative,
                    const std::map<fs::path, PipelineSpec>& specs, std::vector<Problem>& problems) const {
    const std::string own = role_of(alternative.kind);
    std::vector<std::string> names;
    std::string other;
    for (const auto& [path, spec] : specs)
      for (const NodeSpec& node : spec.nodes) {
        const std::string role = role_of(node.use.text);
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
  void refuse_role(const SweepAlternative& alternative, const std::string& text,
                   const std::map<fs::path, PipelineSpec>& specs, std::vector<Problem>& problems) const {
    const size_t dot = text.find('.'), equals = text.find('=');
    if (dot == std::string::npos || text.substr(dot, equals - dot) != ".use") return;
    const std::string name = text.substr(0, dot), kind = text.substr(equals + 1), own = role_of(kind);
    const auto spec = specs.find(alternative.pipeline.empty() ? file().pipeline : alternative.pipeline);
    if (own.empty() || spec == specs.end()) return;
    for (const NodeSpec& node : spec->second.nodes) {
      const std::string role = role_of(node.use.text);
      if (node.name == name && !role.empty() && role != own)
        problems.push_back({file().places.at(text), "'" + kind + "' has the role '" + own + "', but node '" + name +
                                                        "' is one of the role '" + role + "' (" + node.use.text +
                                                        "): it cannot stand there"});
    }
  }

  /// Before any combination is looked at, so that their order decides nothing.
  void find_compared() {
    for (const SweepGroup& group : file().groups)
      for (const SweepAlternative& alternative : group.alternatives) {
        for (const std::string& text : alternative.overrides)
          if (const size_t dot = text.find('.'); dot < text.find('=')) swapped_[group.name].insert(text.substr(0, dot));
        if (alternative.kind.empty()) continue;
        try {
          swapped_[group.name].insert(node_for(file().pipeline, group.name, overrides_));
        } catch (const std::runtime_error&) {
          // The combinations that it concerns tell it.
        }
      }
  }

  /// The node of the pipeline that a list of kinds fills: the one of that name, else the one of that role.
  std::string node_for(const fs::path& pipeline, const std::string& group, const Overrides& overrides) const {
    std::vector<Problem> ignored;  // load_pipeline() tells them
    const PipelineSpec spec = read_pipeline(pipeline, overrides, {}, ignored);
    std::vector<std::string> of_role;
    for (const NodeSpec& node : spec.nodes) {
      if (node.name == group) return group;
      const Kind* kind = registry_.find(node.use.text);
      if (kind && group == kind->node->role) of_role.push_back(node.name);
    }
    if (of_role.size() == 1) return of_role[0];
    std::string names;
    for (const std::string& name : of_role) names += (names.empty() ? " (" : ", ") + name;
    throw std::runtime_error(pipeline.string() + " has " +
                             (of_role.empty() ? "no node" : "several nodes" + names + ")") + " of the role '" + group +
                             "' and none of that name; name the node instead of the role");
  }

  /// What two groups both set would be that of one of them, under the name of the other.
  static void require_set_once(std::map<std::string, std::string>& set_by, const std::string& group,
                               const std::string& key) {
    const auto [found, fresh] = set_by.emplace(key, group);
    if (!fresh && found->second != group)
      throw std::runtime_error("the groups '" + found->second + "' and '" + group + "' both set " + key +
                               ": only one of them could hold; make them one group, or exclude this combination");
  }

  /// What holds around the alternatives of a combination: by whom each key is set, and to what.
  using Settings = std::map<std::string, std::pair<std::string, std::string>>;

  /// Command line, seeds, scenario and variables, of which each is told where it sets what another one has set.
  Settings settings_around(const Combination& way) {
    Settings held;
    const auto set = [&](const std::string& who, const std::string& text) {
      note_conflict(held, text);
      const size_t equals = text.find('=');
      held.emplace(text.substr(0, equals), std::pair(who, text.substr(equals + 1)));
    };
    for (const std::string& text : overrides_)
      held[text.substr(0, text.find('='))] = {"the command line", text.substr(text.find('=') + 1)};
    if (!file().seeds.empty()) {
      if (held.count("seed")) note_conflict(held, "seed=each of its 'seeds'", file().seeds_at);
      held["seed"] = {"'seeds'", "each of them"};
    }
    for (const std::string& text : way.scenario->overrides) set("scenario '" + way.scenario->name + "'", text);
    for (const auto& [name, value] : way.values) set("the matrix", name + "=" + value);
    return held;
  }

  /// `text` ("KEY=VALUE") where the key is set to something else already: only one of them could hold, and the cells
  /// would stand under the names of both.
  void note_conflict(const Settings& held, const std::string& text, Position at = {}) {
    const size_t equals = text.find('=');
    const std::string key = text.substr(0, equals), value = text.substr(equals + 1);
    const auto found = held.find(key);
    if (found == held.end() || found->second.second == value) return;
    if (const auto place = file().places.find(text); at.file.empty() && place != file().places.end())
      at = place->second;
    const std::string& who = found->second.first;
    conflicts_.emplace(
        text + "\n" + who,
        Problem{at, "'" + key + "' is set to '" + value + "' here and to '" + found->second.second + "' by " + who +
                        ": only one of them could hold; leave one of them away, or exclude this combination"});
  }

  /// `compared` gets the nodes that alternatives of this combination change.
  Overrides overrides_of(const Combination& way, std::set<std::string>& compared) {
    std::map<std::string, std::string> set_by;
    Overrides all = overrides_;
    all.insert(all.end(), way.scenario->overrides.begin(), way.scenario->overrides.end());
    for (const auto& [name, value] : way.values) all.push_back(name + "=" + value);
    Settings outer = settings_around(way);
    for (const auto& [group, choice] : way.choices) {
      all.insert(all.end(), choice->overrides.begin(), choice->overrides.end());
      if (!choice->pipeline.empty()) require_set_once(set_by, group, "pipeline");
      for (const std::string& text : choice->overrides) {
        require_set_once(set_by, group, text.substr(0, text.find('=')));
        note_conflict(outer, text);
      }
    }
    for (const auto& [group, choice] : way.choices) {
      if (choice->kind.empty()) continue;
      const std::string node = node_for(pipeline_of(way), group, all);
      require_set_once(set_by, group, node + ".use");
      note_conflict(outer, node + ".use=" + choice->kind, choice->at);
      swapped_[group].insert(node);
      all.push_back(node + ".use=" + choice->kind);
    }
    for (const auto& [group, choice] : way.choices)
      if (const auto nodes = swapped_.find(group); nodes != swapped_.end())
        compared.insert(nodes->second.begin(), nodes->second.end());
    note_what_reaches_nothing(way, all);
    return all;
  }

  /// Who sets each "KEY=VALUE" of a combination.
  std::map<std::string, std::string> setters_of(const Combination& way) const {
    std::map<std::string, std::string> setters;
    for (const std::string& text : overrides_) setters.emplace(text, "the command line");
    for (const std::string& text : way.scenario->overrides)
      setters.emplace(text, "scenario '" + way.scenario->name + "'");
    for (const auto& [name, value] : way.values) setters.emplace(name + "=" + value, "the matrix");
    for (const auto& [group, choice] : way.choices)
      for (const std::string& text : choice->overrides) setters.emplace(text, "'" + choice->name + "' of " + group);
    return setters;
  }

  /// A variable that feeds parameters of which each is set by somebody else, too: the cells would stand under its name
  /// and have nothing of it.
  void note_what_reaches_nothing(const Combination& way, const Overrides& all) {
    const std::map<std::string, std::string> setters = setters_of(way);
    for (const auto& [text, who] : setters) {
      std::string by;
      for (const std::string& other : reach_.replacing(pipeline_of(way), all, text)) {
        const auto setter = setters.find(other);
        by += (by.empty() ? "" : ", ") + ("'" + other + "' of ") +
              (setter == setters.end() ? "a list of kinds" : setter->second);
      }
      if (by.empty()) continue;
      const auto place = file().places.find(text);
      conflicts_.emplace(text + "\n" + by,
                         Problem{place == file().places.end() ? Position{"'" + text + "'", 0, 0} : place->second,
                                 "'" + text + "' of " + who + " reaches nothing: all that takes it is set by " + by +
                                     "; leave one of them away, or exclude this combination"});
    }
  }

  std::shared_ptr<const CellGraph> load(const fs::path& pipeline, Overrides overrides,
                                        const std::set<std::string>& compared, const uint64_t* seed) {
    if (seed) overrides.push_back("seed=" + std::to_string(*seed));
    auto loaded = std::make_shared<CellGraph>();
    loaded->graph = reduced(load_pipeline(pipeline, overrides, registry_), wanted_);
    const std::string error = file().measure.at("error"), node = error.substr(0, error.find('.'));
    if (std::none_of(loaded->graph.nodes.begin(), loaded->graph.nodes.end(),
                     [&](const GraphNode& n) { return n.name == node; }))
      throw std::runtime_error(pipeline.string() + " has no node '" + node + "', of which " + file().path.string() +
                               " measures '" + error + "'");
    for (const auto& [quantity, metric] : given_)
      for (const GraphNode& n : loaded->graph.nodes)
        if (n.maps && n.name == metric.substr(0, metric.find('.')))
          throw std::runtime_error("'" + metric + "', measured as " + quantity + ", is no number of a trial: node '" +
                                   n.name + "' runs once for each item of its input '" + n.each_port +
                                   "' and gives one each time; measure a node that takes all of them");
    plan_.file.measure.merge(add_role_measures(loaded->graph, compared, given_, registry_, plan_.judged));
    loaded->recipes = recipes_of(loaded->graph, hashes_);
    loaded->essential = leading_to(loaded->graph, {node});
    return loaded;
  }

  /// Whether ${seed} stands in something that leads to what is measured: in a report, say, it changes no result.
  bool reaches_cell(const fs::path& pipeline, const Overrides& overrides, const CellGraph& cell) const {
    std::set<std::string> nodes;
    for (const GraphNode& node : cell.graph.nodes) nodes.insert(node.name);
    return reach_.reaches(pipeline, overrides, "seed", nodes);
  }

  /// How often something was set, and how often that was what was wrong.
  struct Tried {
    size_t times = 0, wrong = 0;
    std::string message;
  };

  /// Kinds of a list are not asked: one that is not built is shown with its cells.
  bool was_written(const std::string& text) const {
    return file().places.count(text) > 0 || std::find(overrides_.begin(), overrides_.end(), text) != overrides_.end();
  }

  void count(const Overrides& overrides, const InvalidPipeline* error) {
    for (const std::string& text : std::set<std::string>(overrides.begin(), overrides.end())) {
      if (!was_written(text)) continue;
      Tried& tried = tried_[text];
      ++tried.times;
      if (!error) continue;
      const auto& problems = error->problems();
      const auto own = std::find_if(problems.begin(), problems.end(),
                                    [&](const Problem& p) { return p.at.file == "'" + text + "'"; });
      if (own != problems.end()) ++tried.wrong, tried.message = own->message;
    }
  }

  void refuse_what_is_set_twice() const {
    std::vector<Problem> problems;
    for (const auto& [text, problem] : conflicts_) problems.push_back(problem);
    std::stable_sort(problems.begin(), problems.end(),
                     [](const Problem& a, const Problem& b) { return a.at.line < b.at.line; });
    if (!problems.empty()) throw InvalidPipeline(problems);
  }

  static std::string place_of(const SweepCell& cell) {
    std::string text = cell.scenario.empty() ? "" : "scenario '" + cell.scenario + "'";
    for (const auto& [name, value] : cell.values) text += (text.empty() ? "" : ", ") + name + "=" + value;
    return text;
  }

  /// Places of which each cell has its like in another: they would count twice, and weigh twice.
  void refuse_places_that_are_one() const {
    std::map<std::string, std::string> cells;  // by place: what it has, told by keys
    std::vector<std::string> order;
    for (const SweepCell& cell : plan_.cells) {
      if (!cell.graph) continue;
      const auto [found, fresh] = cells.try_emplace(place_of(cell));
      if (fresh) order.push_back(found->first);
      for (const auto& [group, choice] : cell.choices) found->second += group + "=" + choice + "\n";
      found->second += cell.key + "\n";
    }
    std::vector<Problem> problems;
    std::map<std::string, std::string> first;  // by what it has: the place
    for (const std::string& place : order) {
      const auto [found, fresh] = first.emplace(cells.at(place), place);
      if (!fresh)
        problems.push_back({Position{file().path.string(), 0, 0},
                            found->second + " and " + place +
                                " are the same trials under two names: what is set for them comes to the same "
                                "parameters; leave one of them away"});
    }
    if (!problems.empty()) throw InvalidPipeline(problems);
  }

  void refuse_what_never_holds() const {
    std::vector<Problem> problems;
    for (const auto& [text, tried] : tried_) {
      if (tried.wrong == 0 || tried.wrong < tried.times) continue;
      const auto place = file().places.find(text);
      problems.push_back({place == file().places.end() ? Position{"'" + text + "'", 0, 0} : place->second,
                          "'" + text + "' holds in no combination: " + tried.message});
    }
    std::stable_sort(problems.begin(), problems.end(),
                     [](const Problem& a, const Problem& b) { return a.at.line < b.at.line; });
    if (!problems.empty()) throw InvalidPipeline(problems);
  }

  std::vector<SweepCell> cells_of(const Combination& way) {
    SweepCell cell;
    cell.scenario = way.scenario->name;
    cell.values = way.values;
    for (const auto& [group, choice] : way.choices) cell.choices[group] = choice->name;
    std::vector<SweepCell> cells(std::max<size_t>(1, file().seeds.size()), cell);
    Overrides overrides;
    try {
      std::set<std::string> compared;
      overrides = overrides_of(way, compared);
      const fs::path pipeline = pipeline_of(way);
      if (file().seeds.empty()) {
        cells[0].graph = load(pipeline, overrides, compared, nullptr);
        cells[0].seed = cells[0].graph->graph.seed;
      }
      // Where no value names the seed, which is the rule, one graph is that of all seeds. Two of them that are alike
      // prove nothing of a third: what a recipe has of a file is what stands in it.
      bool shared = false;
      for (size_t k = 0; k < file().seeds.size(); ++k) {
        cells[k].seed = file().seeds[k];
        if (k == 1) shared = !names_seed(cells[0].graph->graph) || !reaches_cell(pipeline, overrides, *cells[0].graph);
        cells[k].graph = shared ? cells[0].graph : load(pipeline, overrides, compared, &file().seeds[k]);
      }
      count(overrides, nullptr);
    } catch (const std::exception& error) {
      count(overrides, dynamic_cast<const InvalidPipeline*>(&error));
      for (size_t k = 0; k < cells.size(); ++k) {
        cells[k].graph = nullptr;
        cells[k].problem = error.what();
        if (!file().seeds.empty()) cells[k].seed = file().seeds[k];
      }
    }
    for (SweepCell& c : cells) c.key = key_of_cell(c);
    return cells;
  }

  static std::string key_of_cell(const SweepCell& cell) {
    Sha256 hash;
    hash.add_field("plumbline cell 1");
    hash.add_field(std::to_string(cell.seed));
    if (cell.graph) {
      std::vector<std::string> recipes = cell.graph->recipes;
      std::sort(recipes.begin(), recipes.end());
      for (const std::string& recipe : recipes) hash.add_field(recipe);
    } else {
      hash.add_field(cell.label());
      hash.add_field(cell.problem);
    }
    return hash.hex();
  }

  const Overrides& overrides_;
  const Registry& registry_;
  FileHashes& hashes_;
  SettingReach reach_;
  std::map<std::string, Tried> tried_;              ///< by "KEY=VALUE"
  std::map<std::string, Problem> conflicts_;        ///< by "KEY=VALUE" and who set the key otherwise
  const std::map<std::string, std::string> given_;  ///< what the file itself measures
  const std::set<std::string> wanted_;
  SweepPlan plan_;
  std::map<std::string, std::set<std::string>> swapped_;
};

}  // namespace

std::string SweepCell::label() const {
  std::string text = scenario;
  const auto add = [&](const std::string& part) { text += (text.empty() ? "" : ", ") + part; };
  for (const auto& [name, value] : values) add(name + "=" + value);
  for (const auto& [group, choice] : choices) add(group + "=" + choice);
  add("seed " + std::to_string(seed));
  return text;
}

std::vector<const Graph*> graphs_of(const SweepPlan& plan) {
  std::set<const CellGraph*> seen;
  std::vector<const Graph*> graphs;
  for (const SweepCell& cell : plan.cells)
    if (cell.graph && seen.insert(cell.graph.get()).second) graphs.push_back(&cell.graph->graph);
  return graphs;
}

SweepPlan plan_sweep(const SweepFile& file, const Overrides& overrides, const Registry& registry, FileHashes& hashes) {
  return Planner(file, overrides, registry, hashes).plan();
}

std::vector<std::vector<size_t>> chunks_of(const SweepPlan& plan, size_t size) {
  std::vector<std::vector<size_t>> chunks;
  size_t last_trial = 0;
  for (size_t i = 0; i < plan.cells.size(); ++i) {
    const bool new_trial = i == 0 || plan.cells[i].trial != last_trial;
    if (chunks.empty() || (new_trial && chunks.back().size() >= size)) chunks.emplace_back();
    chunks.back().push_back(i);
    last_trial = plan.cells[i].trial;
  }
  return chunks;
}

}  // namespace plumbline::runtime

#include "runtime/sweep/sweep_plan.hpp"

#include <algorithm>
#include <set>

#include "runtime/base/digest.hpp"
#include "runtime/graph/pipeline_file.hpp"
#include "runtime/sweep/sweep_conflicts.hpp"
#include "runtime/sweep/sweep_graph.hpp"
#include "runtime/sweep/sweep_measures.hpp"
#include "runtime/sweep/sweep_places.hpp"
#include "runtime/sweep/sweep_settings.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

class Planner {
 public:
  Planner(const SweepFile& file, const Overrides& overrides, const Registry& registry, FileHashes& hashes)
      : overrides_(overrides),
        registry_(registry),
        hashes_(hashes),
        reach_(registry),
        conflicts_(file, overrides),
        tried_(file, overrides),
        given_(file.measure),
        wanted_(measured_nodes(file)) {
    plan_.file = file;
    plan_.overrides = overrides;
  }

  SweepPlan plan() {
    refuse_what_cannot_run(plan_.file, overrides_, registry_);
    find_compared();
    for (const SweepScenario& scenario : file().scenarios) {
      Combination combination;
      combination.scenario = &scenario;
      each_value(combination, 0);
    }
    conflicts_.refuse();
    tried_.refuse_what_never_holds();
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

  /// Before any combination is looked at, so that their order decides nothing.
  void find_compared() {
    for (const SweepGroup& group : file().groups)
      for (const SweepAlternative& alternative : group.alternatives) {
        for (const std::string& text : alternative.overrides)
          if (const size_t dot = text.find('.'); dot < text.find('=')) swapped_[group.name].insert(text.substr(0, dot));
        if (alternative.kind.empty()) continue;
        try {
          swapped_[group.name].insert(node_for(file().pipeline, group.name, overrides_, registry_));
        } catch (const std::runtime_error&) {
          // The combinations that it concerns tell it.
        }
      }
  }

  /// `compared` gets the nodes that alternatives of this combination change.
  Overrides overrides_of(const Combination& way, std::set<std::string>& compared) {
    Overrides all = overrides_;
    all.insert(all.end(), way.scenario->overrides.begin(), way.scenario->overrides.end());
    for (const auto& [name, value] : way.values) all.push_back(name + "=" + value);
    SettingConflicts::Held held = conflicts_.around(way);
    for (const auto& [group, choice] : way.choices) {
      all.insert(all.end(), choice->overrides.begin(), choice->overrides.end());
      conflicts_.add(held, group, *choice);
    }
    for (const auto& [group, choice] : way.choices) {
      if (choice->kind.empty()) continue;
      const std::string node = node_for(pipeline_of(file(), way), group, all, registry_);
      conflicts_.add_kind(held, group, *choice, node);
      swapped_[group].insert(node);
      all.push_back(node + ".use=" + choice->kind);
    }
    for (const auto& [group, choice] : way.choices)
      if (const auto nodes = swapped_.find(group); nodes != swapped_.end())
        compared.insert(nodes->second.begin(), nodes->second.end());
    conflicts_.add_unreached(way, pipeline_of(file(), way), all, reach_);
    return all;
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
      const fs::path pipeline = pipeline_of(file(), way);
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
      tried_.count(overrides, nullptr);
    } catch (const std::exception& error) {
      tried_.count(overrides, dynamic_cast<const InvalidPipeline*>(&error));
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
  SettingConflicts conflicts_;
  SettingTries tried_;
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

#include "runtime/sweep/sweep_file.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <set>
#include <sstream>

#include "base/text/one_document.hpp"
#include "runtime/base/near_names.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

const std::vector<std::string> quantities = {"error", "bias",    "worst",      "predicted", "bound",
                                             "nees",  "freedom", "start_cost", "final_cost"};

bool read_number(std::string_view text, uint64_t& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

class SweepReader {
 public:
  SweepReader(const fs::path& file, const Registry& registry, const std::vector<fs::path>& folders)
      : file_(file), registry_(registry), folders_(folders) {}

  SweepFile read() {
    sweep_.path = file_;
    const YAML::Node root = load();
    if (problems_.empty()) read_root(root);
    if (!problems_.empty()) throw InvalidPipeline(problems_);
    return sweep_;
  }

 private:
  Position at(const YAML::Node& node) const { return {file_.string(), node.Mark().line + 1, node.Mark().column + 1}; }
  void problem(const YAML::Node& node, const std::string& message) { problems_.push_back({at(node), message}); }

  YAML::Node load() {
    std::ifstream stream(file_, std::ios::binary);
    if (!stream || fs::is_directory(file_)) {
      problems_.push_back({{file_.string(), 0, 0}, "cannot read this bench file"});
      return {};
    }
    std::ostringstream text;
    text << stream.rdbuf();
    sweep_.text = text.str();
    try {
      const YAML::Node root = text::load_one_document(sweep_.text);
      if (root.IsMap()) return root;
      problems_.push_back({{file_.string(), 1, 1}, "a bench file is a map that begins with 'bench: 1'"});
    } catch (const YAML::Exception& error) {
      problems_.push_back({{file_.string(), error.mark.line + 1, error.mark.column + 1}, error.msg});
    }
    return {};
  }

  void check_keys(const YAML::Node& map, const std::vector<std::string>& known, const std::string& of) {
    std::set<std::string> seen;
    for (const auto& item : map) {
      const std::string key = item.first.as<std::string>("");
      if (!known.empty() && std::find(known.begin(), known.end(), key) == known.end()) {
        const auto near = near_names(key, known);
        problem(item.first,
                of + " has no key '" + key + "'" + (near.empty() ? "" : " — did you mean '" + near[0] + "'?"));
      }
      if (!seen.insert(key).second) problem(item.first, "the key '" + key + "' stands here a second time");
    }
  }

  bool is_map(const YAML::Node& node, const std::string& what) {
    if (node.IsMap()) return true;
    problem(node, what);
    return false;
  }

  std::string text_of(const YAML::Node& node, const std::string& what) {
    if (!node.IsScalar()) problem(node, what + " is one plain value");
    return node.IsScalar() ? node.Scalar() : "";
  }

  std::vector<std::string> texts_of(const YAML::Node& node, const std::string& what) {
    std::vector<std::string> texts;
    if (node.IsSequence())
      for (const auto& item : node) texts.push_back(text_of(item, what));
    else
      texts.push_back(text_of(node, what));
    return texts;
  }

  fs::path pipeline_path(const YAML::Node& node) {
    const std::string text = text_of(node, "a pipeline");
    const fs::path path = (file_.parent_path() / text).lexically_normal();
    if (fs::is_regular_file(path)) return path;
    std::vector<std::string> names;
    for (const fs::path& folder : folders_) {
      for (const fs::path& candidate : {folder / text, folder / (text + ".yaml")})
        if (text.find('/') == std::string::npos && fs::is_regular_file(candidate)) return candidate;
      std::error_code ignored;
      for (const auto& entry : fs::directory_iterator(folder, ignored))
        if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
    }
    problem(node, "there is no pipeline " + path.string() + did_you_mean(path.stem().string(), names));
    return path;
  }

  void read_root(const YAML::Node& root) {
    check_keys(root,
               {"bench", "title", "pipeline", "measure", "rope", "tolerances", "seeds", "scenarios", "matrix",
                "alternatives", "weights", "stop", "exclude", "keep"},
               "a bench file");
    if (!root["bench"] || root["bench"].as<std::string>("") != "1")
      problems_.push_back({{file_.string(), 1, 1}, "the first line is 'bench: 1' (the version of the format)"});
    sweep_.title = root["title"] ? text_of(root["title"], "'title'") : file_.stem().string();
    if (root["pipeline"])
      sweep_.pipeline = pipeline_path(root["pipeline"]);
    else
      problems_.push_back({{file_.string(), 1, 1}, "'pipeline' is missing: the pipeline file that is run"});
    if (root["measure"]) read_measure(root["measure"]);
    sweep_.measure.try_emplace("error", "errors.rmse_z");
    if (root["rope"]) read_length(root["rope"], sweep_.rope);
    read_tolerances(root["tolerances"]);
    if (root["seeds"]) read_seeds(root["seeds"]);
    read_scenarios(root["scenarios"]);
    if (root["matrix"]) read_matrix(root["matrix"]);
    if (root["alternatives"]) read_groups(root["alternatives"]);
    if (root["stop"]) read_stop(root["stop"]);
    if (root["weights"]) read_weights(root["weights"]);
    if (root["exclude"]) read_exclude(root["exclude"]);
    if (const YAML::Node keep = root["keep"]) {
      const std::string text = text_of(keep, "'keep'");
      if (text != "everything" && text != "results") problem(keep, "'keep' is 'everything' or 'results'");
      sweep_.keep_everything = text != "results";
    }
  }

  void read_measure(const YAML::Node& map) {
    if (!is_map(map, "'measure' is a map: {error: NODE.METRIC, …}")) return;
    check_keys(map, quantities, "'measure'");
    for (const auto& item : map) {
      const std::string metric = text_of(item.second, "a metric");
      if (metric.find('.') == std::string::npos)
        problem(item.second, "a metric is NODE.METRIC, such as errors.rmse_z; found '" + metric + "'");
      sweep_.measure[item.first.as<std::string>("")] = metric;
    }
  }

  void read_length(const YAML::Node& node, double& value) {
    const std::string text = text_of(node, "a length");
    const auto metres = length_of(text);
    if (!metres || !(*metres > 0))
      problem(node, "'" + text + "' is no length above zero with its unit, such as 0.05 mm");
    else
      value = *metres;
  }

  void read_tolerances(const YAML::Node& node) {
    if (!node) {
      for (int tau = 2; tau <= 8; ++tau) sweep_.tolerances.push_back(1e-3 * tau);
      return;
    }
    std::vector<YAML::Node> items;
    if (node.IsSequence())
      for (const auto& item : node) items.push_back(item);
    else
      items.push_back(node);
    for (const YAML::Node& item : items) {
      double tau = 0;
      read_length(item, tau);
      sweep_.tolerances.push_back(tau);
    }
    std::sort(sweep_.tolerances.begin(), sweep_.tolerances.end());
  }

  void read_seeds(const YAML::Node& node) {
    const auto seeds = seeds_of(texts_of(node, "a seed"));
    if (!seeds)
      problem(node,
              "seeds are whole numbers from 0, ranges such as 1-200, or a list of them without repetition; at most a "
              "million in all");
    else
      sweep_.seeds = *seeds;
    sweep_.seeds_at = at(node);
  }

  void read_stop(const YAML::Node& map) {
    if (!is_map(map, "'stop' is a map: {when: decided, after: [20, 60, 200]}")) return;
    check_keys(map, {"when", "after"}, "'stop'");
    if (!map["when"] || text_of(map["when"], "'when'") != "decided")
      problem(map, "'when' is 'decided': every comparison has a winner or is equal");
    if (!map["after"])
      return problem(map, "'after' is missing: the numbers of seeds after which is looked, [20, 60, 200]");
    for (const std::string& text : texts_of(map["after"], "a number of seeds")) {
      uint64_t count = 0;
      if (!read_number(text, count) || count == 0)
        problem(map["after"], "'after' has whole numbers of seeds; found '" + text + "'");
      sweep_.looks.push_back(count);
    }
    for (size_t k = 1; k < sweep_.looks.size(); ++k)
      if (sweep_.looks[k] <= sweep_.looks[k - 1]) problem(map["after"], "the numbers in 'after' rise");
    if (!sweep_.looks.empty() && sweep_.looks.back() != sweep_.seeds.size())
      problem(map["after"], "the last look is at all seeds, " + std::to_string(sweep_.seeds.size()) + "; found " +
                                std::to_string(sweep_.looks.back()));
  }

  void read_weights(const YAML::Node& node) {
    sweep_.weighted = true;
    if (node.IsScalar() && node.Scalar() == "equal") return;
    if (!is_map(node, "'weights' is 'equal' or a map of all scenarios: {one floor: 1, full height: 3}")) return;
    std::vector<std::string> names;
    for (const SweepScenario& scenario : sweep_.scenarios) names.push_back(scenario.name);
    check_keys(node, names, "'weights' (of scenarios)");
    for (const std::string& name : names)
      if (!node[name]) problem(node, "'weights' does not say how much scenario '" + name + "' weighs");
    for (const auto& item : node) {
      const std::string text = text_of(item.second, "a weight");
      double weight = 0;
      const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), weight);
      if (error != std::errc() || end != text.data() + text.size() || !(weight > 0) || !std::isfinite(weight))
        problem(item.second, "a weight is a number above zero; found '" + text + "'");
      sweep_.weights[item.first.as<std::string>("")] = weight;
    }
  }

  Overrides overrides_of(const YAML::Node& map, const std::string& what) {
    Overrides overrides;
    if (map.IsNull() || !is_map(map, what + " is a map of what it changes: {floors: 3, block.use: adjust.ceres}"))
      return overrides;
    check_keys(map, {}, what);
    for (const auto& item : map) {
      const std::string key = item.first.as<std::string>("");
      if (key == "pipeline") continue;  // whoever calls takes it
      std::string value;
      if (item.second.IsSequence()) {
        for (const auto& part : item.second) value += (value.empty() ? "" : ", ") + text_of(part, "a value");
        value = "[" + value + "]";
      } else if (item.second.IsNull()) {
        value = "~";
      } else {
        value = text_of(item.second, "a value");
      }
      overrides.push_back(key + "=" + value);
      sweep_.places.emplace(overrides.back(), at(item.first));
    }
    return overrides;
  }

  void read_scenarios(const YAML::Node& map) {
    if (map && is_map(map, "'scenarios' is a map of names: {full height: {floors: 5}}")) {
      check_keys(map, {}, "'scenarios'");
      for (const auto& item : map) {
        const std::string name = item.first.as<std::string>("");
        SweepScenario scenario{name, overrides_of(item.second, "scenario '" + name + "'"), {}, at(item.first)};
        if (item.second.IsMap() && item.second["pipeline"]) scenario.pipeline = pipeline_path(item.second["pipeline"]);
        sweep_.scenarios.push_back(std::move(scenario));
      }
    }
    if (sweep_.scenarios.empty()) sweep_.scenarios.emplace_back();
  }

  void read_matrix(const YAML::Node& map) {
    if (!is_map(map, "'matrix' is a map of variables and the values they take: {floors: [1, 2, 5]}")) return;
    check_keys(map, {}, "'matrix'");
    for (const auto& item : map) {
      SweepVariable variable{item.first.as<std::string>(""), texts_of(item.second, "a value")};
      if (std::set<std::string>(variable.values.begin(), variable.values.end()).size() != variable.values.size())
        problem(item.first, "'" + variable.name + "' has a value twice");
      if (variable.values.empty()) problem(item.first, "'" + variable.name + "' has no values");
      if (variable.name == "scenario") problem(item.first, "'scenario' is the name of what scenarios are told by");
      for (const std::string& value : variable.values)
        sweep_.places.emplace(variable.name + "=" + value, at(item.first));
      sweep_.matrix.push_back(std::move(variable));
    }
  }

  void read_groups(const YAML::Node& map) {
    if (!is_map(map, "'alternatives' is a map: {ROLE or NODE: [KIND, …]} or {NAME: {ALTERNATIVE: {…}}}")) return;
    check_keys(map, {}, "'alternatives'");
    for (const auto& item : map) {
      SweepGroup group{item.first.as<std::string>(""), {}};
      if (group.name == "scenario" || group.name == "seed" ||
          std::any_of(sweep_.matrix.begin(), sweep_.matrix.end(), [&](const auto& v) { return v.name == group.name; }))
        problem(item.first, "'" + group.name +
                                "' is the name of something else of a cell, too, in exclusions and tables: " +
                                "give these alternatives another one");
      if (item.second.IsMap())
        for (const auto& alternative : item.second) read_alternative(alternative.first, alternative.second, group);
      else if (item.second.IsScalar() && item.second.Scalar() == "all")
        add_role(item.second, group);
      else
        for (const std::string& kind : texts_of(item.second, "a kind of node"))
          group.alternatives.push_back({kind, {}, kind, {}, at(item.second)});
      std::set<std::string> names;
      for (const auto& alternative : group.alternatives)
        if (!names.insert(alternative.name).second)
          problem(item.first, "'" + alternative.name + "' is an alternative of '" + group.name + "' twice");
      if (group.alternatives.empty()) problem(item.first, "'" + group.name + "' has no alternatives");
      sweep_.groups.push_back(std::move(group));
    }
  }

  void read_alternative(const YAML::Node& name, const YAML::Node& what, SweepGroup& group) {
    SweepAlternative alternative;
    alternative.name = name.as<std::string>("");
    alternative.at = at(name);
    if (what.IsScalar())
      alternative.kind = what.Scalar();
    else
      alternative.overrides = overrides_of(what, "alternative '" + alternative.name + "'");
    if (what.IsMap() && what["pipeline"]) alternative.pipeline = pipeline_path(what["pipeline"]);
    group.alternatives.push_back(std::move(alternative));
  }

  void add_role(const YAML::Node& node, SweepGroup& group) {
    for (const auto& [name, kind] : registry_.kinds())
      if (group.name == kind.node->role) group.alternatives.push_back({name, {}, name, {}, at(node)});
    if (group.alternatives.empty()) problem(node, "no kind of node has the role '" + group.name + "'");
  }

  void read_exclude(const YAML::Node& list) {
    if (!list.IsSequence()) return problem(list, "'exclude' is a list of maps: [{floors: 5, adjuster: adjust.slow}]");
    std::map<std::string, std::vector<std::string>> known;
    for (const auto& scenario : sweep_.scenarios) known["scenario"].push_back(scenario.name);
    for (const auto& variable : sweep_.matrix) known[variable.name] = variable.values;
    for (const auto& group : sweep_.groups)
      for (const auto& alternative : group.alternatives) known[group.name].push_back(alternative.name);
    std::vector<std::string> keys{"why"};
    for (const auto& [key, values] : known) keys.push_back(key);
    for (const auto& item : list) {
      if (!is_map(item, "an exclusion is a map: {floors: 5, adjuster: adjust.slow, why: …}")) continue;
      check_keys(item, keys, "an exclusion");
      SweepExclusion exclusion;
      for (const auto& pair : item) {
        const std::string key = pair.first.as<std::string>(""), value = text_of(pair.second, "a value");
        if (key == "why") {
          exclusion.why = value;
          continue;
        }
        const auto& values = known[key];
        if (!values.empty() && std::find(values.begin(), values.end(), value) == values.end())
          problem(pair.second, "'" + key + "' never is '" + value + "', so this excludes nothing");
        exclusion.where[key] = value;
      }
      if (exclusion.where.empty()) problem(item, "an exclusion that names nothing would exclude everything");
      sweep_.exclude.push_back(std::move(exclusion));
    }
  }

  const fs::path& file_;
  const Registry& registry_;
  const std::vector<fs::path>& folders_;
  std::vector<Problem> problems_;
  SweepFile sweep_;
};

}  // namespace

SweepFile read_sweep(const fs::path& file, const Registry& registry, const std::vector<fs::path>& folders) {
  return SweepReader(file, registry, folders).read();
}

std::optional<double> length_of(const std::string& text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || !std::isfinite(value)) return std::nullopt;
  std::string unit(end, text.data() + text.size());
  unit.erase(0, unit.find_first_not_of(' ') == std::string::npos ? unit.size() : unit.find_first_not_of(' '));
  static const std::map<std::string, double> units{{"m", 1}, {"cm", 1e-2}, {"mm", 1e-3}, {"um", 1e-6}, {"µm", 1e-6}};
  const auto found = units.find(unit);
  if (found == units.end()) return std::nullopt;
  return value * found->second;
}

std::optional<std::vector<uint64_t>> seeds_of(const std::vector<std::string>& texts) {
  constexpr size_t most_seeds = 1'000'000;
  std::vector<uint64_t> seeds;
  for (const std::string& text : texts) {
    const size_t dash = text.find('-');
    uint64_t first = 0, last = 0;
    if (!read_number(std::string_view(text).substr(0, dash), first)) return std::nullopt;
    last = first;
    if (dash != std::string::npos && !read_number(std::string_view(text).substr(dash + 1), last)) return std::nullopt;
    if (last < first || last - first >= most_seeds - seeds.size()) return std::nullopt;
    for (uint64_t seed = first; seed <= last; ++seed) seeds.push_back(seed);
  }
  if (std::set<uint64_t>(seeds.begin(), seeds.end()).size() != seeds.size() || seeds.empty()) return std::nullopt;
  return seeds;
}

}  // namespace plumbline::runtime

#include "runtime/graph/pipeline_file.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>

#include "base/text/one_document.hpp"
#include "runtime/base/near_names.hpp"
#include "runtime/base/printable.hpp"
#include "runtime/graph/command_words.hpp"
#include "runtime/graph/include_paths.hpp"
#include "runtime/graph/node_overrides.hpp"
#include "runtime/graph/pipeline_variables.hpp"
#include "runtime/graph/role_expansion.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

constexpr size_t deepest_include = 100;
constexpr const char* kCommand = "${command}";

/// Reads one file and, first, those it includes.
class FileReader {
 public:
  FileReader(const std::vector<std::string>& overrides, const std::vector<fs::path>& include_folders,
             std::vector<Problem>& problems, const Registry* registry)
      : overrides_(overrides),
        include_folders_(include_folders),
        problems_(problems),
        registry_(registry),
        variables_(problems) {}

  PipelineSpec read(const fs::path& file) {
    PipelineSpec spec;
    collect(file, spec);
    const size_t told = problems_.size();
    expand_roles(spec, registry_, problems_);
    variables_.tell_unused(overrides_);
    variables_.apply(overrides_);
    apply_node_overrides(overrides_, spec, problems_);
    // What a part that was not read declares or uses nobody knows: these would be told of what is not wrong.
    if (lacks_a_part_) problems_.erase(problems_.begin() + static_cast<std::ptrdiff_t>(told), problems_.end());
    variables_.resolve();
    std::vector<Scalar*> descriptions;
    for (NodeSpec& node : spec.nodes) {
      refuse_variable_in_name(node.name, node.at);
      variables_.replace(node.use);
      for (auto& [name, value] : node.conditions) variables_.replace(value);
      for (auto& [port, source] : node.inputs) variables_.replace(source);
      for (auto& [name, parameter] : node.parameters)
        for (Scalar& value : parameter.values)
          is_description(value) ? descriptions.push_back(&value) : variables_.replace(value);
    }
    const std::string nodes = descriptions.empty() ? "" : nodes_in_words(spec);
    for (Scalar* value : descriptions)
      value->text = value->text == kCommand ? command_words(file, overrides_, include_folders_) : nodes;
    for (auto& [name, source] : spec.outputs) {
      refuse_variable_in_name(name, source.at);
      variables_.replace(source);
    }
    for (auto& carry : spec.rounds.carry) variables_.replace(carry.first), variables_.replace(carry.next);
    variables_.replace(spec.rounds.until);
    variables_.replace(spec.rounds.most);
    spec.variables = variables_.values();
    return spec;
  }

 private:
  void problem(const Position& at, const std::string& message) { problems_.push_back({at, message}); }

  /// The values "${pipeline}", what runs in words, and "${command}", what somebody typed, for a report. A variable of
  /// that name goes before it.
  bool is_description(const Scalar& value) const {
    return (value.text == "${pipeline}" && !variables_.has("pipeline")) ||
           (value.text == kCommand && !variables_.has("command"));
  }

  /// A line for each node: its name, its kind, and the parameters that the pipeline gives it. Paths are left out: where
  /// a file lies is no part of a result, and what is in it is told by hashes.
  std::string nodes_in_words(const PipelineSpec& spec) const {
    std::string text;
    for (const NodeSpec& node : spec.nodes) {
      text += (text.empty() ? "" : "\n") + node.name + ": " + node.use.text;
      for (const auto& [name, parameter] : node.parameters) {
        std::string values;
        for (const Scalar& value : parameter.values)
          if (!is_description(value)) values += (values.empty() ? "" : ",") + value.text;
        if (!values.empty() && values.find('/') == std::string::npos) text += " " + name + "=" + values;
      }
    }
    return text;
  }

  static Position position(const fs::path& file, const YAML::Node& node) {
    const YAML::Mark mark = node.Mark();
    return {file.string(), mark.line + 1, mark.column + 1};
  }

  static bool has_tab(const std::string& text, int line) {
    std::istringstream stream(text);
    std::string found;
    for (int i = 0; i <= line && std::getline(stream, found); ++i) {
    }
    return found.find('\t') != std::string::npos;
  }

  void collect(const fs::path& file, PipelineSpec& spec) {
    read_.insert(fs::weakly_canonical(file));
    const std::string text = read_text(file);
    spec.sources.push_back({file.string(), text});
    YAML::Node root;
    try {
      root = text::load_one_document(text);
    } catch (const YAML::Exception& error) {
      std::string message = error.msg;
      if (text.find("${") != std::string::npos && message.find("map flow") != std::string::npos)
        message += " (a variable inside { } must be quoted: \"${name}\")";
      else if (message.starts_with("end of map not found"))
        message += " (is this line indented as those beside it?)";
      if (has_tab(text, error.mark.line)) message += " (this line has a tab; YAML is indented by blanks)";
      problem({file.string(), error.mark.line + 1, error.mark.column + 1}, message);
      lacks_a_part_ = true;
      return;
    }
    if (!root.IsMap()) {
      problem({file.string(), 1, 1},
              "a pipeline is a map with the keys plumbline, vars, nodes, outputs; found something else");
      return;
    }
    const size_t told = problems_.size();
    check_keys(file, root, {"plumbline", "include", "vars", "rounds", "nodes", "outputs"}, "a pipeline");
    lacks_a_part_ = lacks_a_part_ || problems_.size() > told;
    if (!root["plumbline"])
      problem({file.string(), 1, 1}, "the first line of a pipeline is 'plumbline: 1' (the version of the format)");
    else if (!root["plumbline"].IsScalar() || root["plumbline"].Scalar() != "1")
      problem(position(file, root["plumbline"]), "the version of the format must be 1");
    roots_.push_back(root);
    if (root["include"]) read_includes(file, root["include"], spec);
    roots_.pop_back();
    if (root["vars"]) read_variables(file, root["vars"]);
    if (root["rounds"]) read_rounds(file, root["rounds"], spec.rounds);
    if (root["nodes"]) read_nodes(file, root["nodes"], spec);
    if (root["outputs"]) read_outputs(file, root["outputs"], spec);
  }

  std::string read_text(const fs::path& file) {
    std::error_code error;
    std::ifstream stream;
    if (fs::is_regular_file(file, error)) stream.open(file, std::ios::binary);
    if (!stream.is_open() || !stream) {
      problem({file.string(), 0, 0}, "cannot read this pipeline file");
      return "plumbline: 1";
    }
    if (const auto size = fs::file_size(file, error); error || size > largest_pipeline_file) {
      problem({file.string(), 0, 0}, "has " + std::to_string(size >> 20) + " MiB; a pipeline file has at most " +
                                         std::to_string(largest_pipeline_file >> 20) + ". Is it data?");
      return "plumbline: 1";
    }
    std::ostringstream text;
    text << stream.rdbuf();
    return text.str();
  }

  void check_keys(const fs::path& file, const YAML::Node& map, const std::vector<std::string>& known,
                  const std::string& of) {
    std::set<std::string> seen;
    for (const auto& item : map) {
      if (!item.first.IsScalar()) {
        problem(position(file, item.first), "a key must be plain text");
        continue;
      }
      const std::string key = item.first.Scalar();
      if (!known.empty() && std::find(known.begin(), known.end(), key) == known.end())
        problem(position(file, item.first), of + " has no key '" + key + "'" + did_you_mean(key, known));
      if (!seen.insert(key).second)
        problem(position(file, item.first), "the key '" + key + "' stands here a second time; keep one of them");
    }
  }

  void read_includes(const fs::path& file, const YAML::Node& list, PipelineSpec& spec) {
    std::vector<YAML::Node> items;
    if (list.IsScalar()) items.push_back(list);
    if (list.IsSequence())
      for (const auto& item : list) items.push_back(item);
    including_.push_back(fs::weakly_canonical(file));
    for (const YAML::Node& item : items) {
      const std::string name = item.as<std::string>("");
      variables_.mention(name);
      std::string unknown;
      const std::string replaced = with_values(
          name, [&](const std::string& variable) { return value_for_include(variable); }, unknown);
      if (!unknown.empty()) {
        problem(position(file, item), "'" + name + "' is included by a variable '" + unknown +
                                          "' that has no value; give it one under 'vars' of this file");
        continue;
      }
      const fs::path included = find_include(file, replaced, include_folders_);
      const fs::path same = fs::weakly_canonical(included);
      if (included.empty())
        problem(position(file, item),
                "included file not found: " + included_places(file, name, replaced, include_folders_));
      else if (std::find(including_.begin(), including_.end(), same) != including_.end())
        problem(position(file, item), "this include goes round in a circle");
      else if (including_.size() > deepest_include)
        problem(position(file, item), "files include one another deeper than " + std::to_string(deepest_include) +
                                          " levels; name them side by side in one list");
      else if (!read_.count(same))
        collect(included, spec);
    }
    including_.pop_back();
  }

  /// Of what includes wait for: the command line, else `vars` of the files that lead here, the outermost first, as it
  /// is for every other value.
  std::optional<std::string> value_for_include(const std::string& name) const {
    for (auto text = overrides_.rbegin(); text != overrides_.rend(); ++text)
      if (text->starts_with(name + "=")) return text->substr(name.size() + 1);
    for (const YAML::Node& root : roots_)
      if (const YAML::Node vars = root["vars"]; vars && vars.IsMap())
        if (const YAML::Node value = vars[name]; value && value.IsScalar()) return value.Scalar();
    return std::nullopt;
  }

  void read_variables(const fs::path& file, const YAML::Node& map) {
    if (!map.IsMap()) return problem(position(file, map), "'vars' is a map of names and values");
    check_keys(file, map, {}, "vars");
    for (const auto& item : map) {
      if (!item.second.IsScalar() && !item.second.IsNull()) {
        problem(position(file, item.second), "a variable has one plain value");
        continue;
      }
      const bool given = item.second.IsScalar();
      if (given) variables_.mention(item.second.Scalar());
      variables_.declare(item.first.as<std::string>(""),
                         {given ? item.second.Scalar() : "", position(file, item.first), file.parent_path()}, given);
    }
  }

  void read_nodes(const fs::path& file, const YAML::Node& map, PipelineSpec& spec) {
    if (!map.IsMap()) return problem(position(file, map), "'nodes' is a map: name: {use: …, in: {…}, with: {…}}");
    check_keys(file, map, {}, "nodes");
    for (const auto& item : map) {
      const std::string name = item.first.as<std::string>("");
      if (name.find('.') != std::string::npos || name.empty() || printable_line(name) != name)
        problem(position(file, item.first),
                "a node's name is one line without dots and control characters: '" + printable_line(name) + "'");
      if (!item.second.IsMap()) {
        problem(position(file, item.second), "node '" + name + "' is a map: {use: …, in: {…}, with: {…}}");
        continue;
      }
      check_keys(file, item.second, {"use", "in", "with", "each", "for_each", "isolate", "time_limit", "memory_limit"},
                 "a node");
      // An including file may change parts of an included node: what it says replaces, the rest stays.
      const auto [found, fresh] = node_index_.emplace(name, spec.nodes.size());
      if (fresh) spec.nodes.push_back({name, {}, {}, {}, {}});
      NodeSpec& node = spec.nodes[found->second];
      node.at = position(file, item.first);
      read_node(file, item.second, node);
    }
  }

  Scalar scalar(const fs::path& file, const YAML::Node& node) {
    if (!node.IsScalar()) problem(position(file, node), "one plain value is expected here");
    if (node.IsScalar()) variables_.mention(node.Scalar());
    return {node.IsScalar() ? node.Scalar() : "", position(file, node), file.parent_path(), !node.IsScalar()};
  }

  void read_node(const fs::path& file, const YAML::Node& map, NodeSpec& node) {
    if (map["use"]) node.use = scalar(file, map["use"]);
    if (map["each"]) node.each = scalar(file, map["each"]);
    if (map["for_each"]) node.for_each = scalar(file, map["for_each"]);
    for (const char* condition : {"isolate", "time_limit", "memory_limit"})
      if (map[condition]) set_named(node.conditions, condition, scalar(file, map[condition]));
    if (const YAML::Node inputs = map["in"]) {
      if (!inputs.IsMap()) return problem(position(file, inputs), "'in' is a map: {port: node.port}");
      check_keys(file, inputs, {}, "in");
      for (const auto& item : inputs) {
        const std::string port = item.first.as<std::string>("");
        std::erase_if(node.inputs, [&](const auto& input) { return input.first == port; });
        const auto connect = [&](const YAML::Node& value, const YAML::Node& place) {
          Scalar source = scalar(file, value);
          source.at = position(file, place);
          node.inputs.emplace_back(port, std::move(source));
        };
        if (item.second.IsSequence())
          for (const auto& value : item.second) connect(value, value);
        else
          connect(item.second, item.first);
      }
    }
    if (const YAML::Node with = map["with"]) {
      if (!with.IsMap()) return problem(position(file, with), "'with' is a map: {parameter: value}");
      check_keys(file, with, {}, "with");
      for (const auto& item : with) {
        ParameterSpec parameter;
        parameter.at = position(file, item.first);
        parameter.is_list = item.second.IsSequence();
        if (parameter.is_list)
          for (const auto& value : item.second) parameter.values.push_back(scalar(file, value));
        else
          parameter.values.push_back(scalar(file, item.second));
        set_named(node.parameters, item.first.as<std::string>(""), std::move(parameter));
      }
    }
  }

  void read_rounds(const fs::path& file, const YAML::Node& map, RoundsSpec& rounds) {
    if (!map.IsMap())
      return problem(position(file, map),
                     "'rounds' is a map: {carry: {name: node.port}, until: node.metric, most: 20}");
    check_keys(file, map, {"carry", "until", "most"}, "rounds");
    rounds.given = true;
    rounds.at = position(file, map);
    if (map["until"]) rounds.until = scalar(file, map["until"]);
    if (map["most"]) rounds.most = scalar(file, map["most"]);
    const YAML::Node carry = map["carry"];
    if (!carry) return;
    if (!carry.IsMap())
      return problem(position(file, carry), "'carry' is a map: {name: node.port} or {name: {first: …, next: …}}");
    check_keys(file, carry, {}, "carry");
    for (const auto& item : carry) {
      RoundsSpec::Carry one{item.first.as<std::string>(""), position(file, item.first), {}, {}};
      if (item.second.IsMap()) {
        check_keys(file, item.second, {"first", "next"}, "what is carried");
        if (item.second["first"]) one.first = scalar(file, item.second["first"]);
        if (item.second["next"]) one.next = scalar(file, item.second["next"]);
      } else {
        one.next = scalar(file, item.second);
      }
      std::erase_if(rounds.carry, [&](const auto& other) { return other.name == one.name; });
      rounds.carry.push_back(std::move(one));
    }
  }

  void read_outputs(const fs::path& file, const YAML::Node& map, PipelineSpec& spec) {
    if (!map.IsMap()) return problem(position(file, map), "'outputs' is a map: {file name: node.port}");
    check_keys(file, map, {}, "outputs");
    for (const auto& item : map) {
      Scalar source = scalar(file, item.second);
      source.at = position(file, item.first);
      set_named(spec.outputs, item.first.as<std::string>(""), std::move(source));
    }
  }

  void refuse_variable_in_name(const std::string& name, const Position& at) {
    if (name.find("${") != std::string::npos)
      problem(at, "'" + name + "': variables stand in values, not in names; write the name out");
  }

  const std::vector<std::string>& overrides_;
  const std::vector<fs::path>& include_folders_;
  std::vector<Problem>& problems_;
  bool lacks_a_part_ = false;  // a file that is no YAML, a key that is none
  const Registry* registry_;
  PipelineVariables variables_;
  std::map<std::string, size_t> node_index_;  // in PipelineSpec::nodes
  std::set<fs::path> read_;
  std::vector<fs::path> including_;
  std::vector<YAML::Node> roots_;  // of the files that are read, the outermost first
};

}  // namespace

PipelineSpec read_pipeline(const fs::path& file, const std::vector<std::string>& overrides,
                           const std::vector<fs::path>& include_folders, std::vector<Problem>& problems,
                           const Registry* registry) {
  return FileReader(overrides, include_folders, problems, registry).read(file);
}

}  // namespace plumbline::runtime

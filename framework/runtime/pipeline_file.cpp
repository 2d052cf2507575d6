#include "runtime/pipeline_file.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

std::string did_you_mean(const std::string& wanted, const std::vector<std::string>& candidates) {
  const auto near = near_names(wanted, candidates);
  if (near.empty()) return "";
  std::string text = " — did you mean ";
  for (size_t i = 0; i < near.size(); ++i) text += (i ? " or '" : "'") + near[i] + "'";
  return text + "?";
}

struct Variable {
  std::string value;
  bool given = false;  ///< has a value
  Position at;
  fs::path base;
};

/// Reads one file and, first, those it includes.
class Reader {
 public:
  Reader(const std::vector<std::string>& overrides, std::vector<Problem>& problems)
      : overrides_(overrides), problems_(problems) {}

  PipelineSpec read(const fs::path& file) {
    PipelineSpec spec;
    collect(file, spec, true);
    apply_variable_overrides();
    for (NodeSpec& node : spec.nodes) {
      replace(node.use);
      for (auto& [port, source] : node.inputs) replace(source);
      for (auto& [name, parameter] : node.parameters)
        for (Scalar& value : parameter.values) replace(value);
    }
    for (auto& [name, source] : spec.outputs) replace(source);
    apply_node_overrides(spec);
    for (const auto& [name, variable] : variables_) spec.variables[name] = variable.value;
    return spec;
  }

 private:
  void problem(const Position& at, const std::string& message) { problems_.push_back({at, message}); }

  static Position position(const fs::path& file, const YAML::Node& node) {
    const YAML::Mark mark = node.Mark();
    return {file.string(), mark.line + 1, mark.column + 1};
  }

  void collect(const fs::path& file, PipelineSpec& spec, bool outermost) {
    const std::string text = read_text(file);
    if (outermost) spec.text = text;
    YAML::Node root;
    try {
      root = YAML::Load(text);
    } catch (const YAML::Exception& error) {
      std::string message = error.msg;
      if (text.find("${") != std::string::npos && message.find("map flow") != std::string::npos)
        message += " (a variable inside { } must be quoted: \"${name}\")";
      problem({file.string(), error.mark.line + 1, error.mark.column + 1}, message);
      return;
    }
    if (!root.IsMap()) {
      problem({file.string(), 1, 1},
              "a pipeline is a map with the keys plumbline, vars, nodes, outputs; found something else");
      return;
    }
    check_keys(file, root, {"plumbline", "include", "vars", "nodes", "outputs"}, "a pipeline");
    if (!root["plumbline"])
      problem({file.string(), 1, 1}, "the first line of a pipeline is 'plumbline: 1' (the version of the format)");
    else if (!root["plumbline"].IsScalar() || root["plumbline"].Scalar() != "1")
      problem(position(file, root["plumbline"]), "the version of the format must be 1");
    if (root["include"]) read_includes(file, root["include"], spec);
    if (root["vars"]) read_variables(file, root["vars"]);
    if (root["nodes"]) read_nodes(file, root["nodes"], spec);
    if (root["outputs"]) read_outputs(file, root["outputs"], spec);
  }

  std::string read_text(const fs::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream || fs::is_directory(file)) {
      problem({file.string(), 0, 0}, "cannot read this pipeline file");
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
      const fs::path included = file.parent_path() / item.as<std::string>("");
      if (!fs::is_regular_file(included))
        problem(position(file, item), "included file not found: " + included.string());
      else if (std::find(including_.begin(), including_.end(), fs::weakly_canonical(included)) != including_.end())
        problem(position(file, item), "this include goes round in a circle");
      else
        collect(included, spec, false);
    }
    including_.pop_back();
  }

  void read_variables(const fs::path& file, const YAML::Node& map) {
    if (!map.IsMap()) return problem(position(file, map), "'vars' is a map of names and values");
    check_keys(file, map, {}, "vars");
    for (const auto& item : map) {
      if (!item.second.IsScalar() && !item.second.IsNull()) {
        problem(position(file, item.second), "a variable has one plain value");
        continue;
      }
      Variable& variable = variables_[item.first.as<std::string>("")];
      variable.given = item.second.IsScalar();
      variable.value = variable.given ? item.second.Scalar() : "";
      variable.at = position(file, item.first);
      variable.base = file.parent_path();
    }
  }

  void read_nodes(const fs::path& file, const YAML::Node& map, PipelineSpec& spec) {
    if (!map.IsMap()) return problem(position(file, map), "'nodes' is a map: name: {use: …, in: {…}, with: {…}}");
    check_keys(file, map, {}, "nodes");
    for (const auto& item : map) {
      const std::string name = item.first.as<std::string>("");
      if (name.find('.') != std::string::npos || name.empty())
        problem(position(file, item.first), "a node's name has no dots: '" + name + "'");
      if (!item.second.IsMap()) {
        problem(position(file, item.second), "node '" + name + "' is a map: {use: …, in: {…}, with: {…}}");
        continue;
      }
      check_keys(file, item.second, {"use", "in", "with"}, "a node");
      // An including file may change parts of an included node: what it says replaces, the rest stays.
      auto found =
          std::find_if(spec.nodes.begin(), spec.nodes.end(), [&](const NodeSpec& n) { return n.name == name; });
      if (found == spec.nodes.end()) {
        spec.nodes.push_back({name, {}, {}, {}, {}});
        found = spec.nodes.end() - 1;
      }
      found->at = position(file, item.first);
      read_node(file, item.second, *found);
    }
  }

  Scalar scalar(const fs::path& file, const YAML::Node& node) {
    if (!node.IsScalar()) problem(position(file, node), "one plain value is expected here");
    return {node.IsScalar() ? node.Scalar() : "", position(file, node), file.parent_path()};
  }

  template <typename Value>
  static void set(std::vector<std::pair<std::string, Value>>& list, const std::string& key, Value value) {
    for (auto& [name, old] : list)
      if (name == key) {
        old = std::move(value);
        return;
      }
    list.emplace_back(key, std::move(value));
  }

  void read_node(const fs::path& file, const YAML::Node& map, NodeSpec& node) {
    if (map["use"]) node.use = scalar(file, map["use"]);
    if (const YAML::Node inputs = map["in"]) {
      if (!inputs.IsMap()) return problem(position(file, inputs), "'in' is a map: {port: node.port}");
      check_keys(file, inputs, {}, "in");
      for (const auto& item : inputs) {
        Scalar source = scalar(file, item.second);
        source.at = position(file, item.first);
        set(node.inputs, item.first.as<std::string>(""), std::move(source));
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
        set(node.parameters, item.first.as<std::string>(""), std::move(parameter));
      }
    }
  }

  void read_outputs(const fs::path& file, const YAML::Node& map, PipelineSpec& spec) {
    if (!map.IsMap()) return problem(position(file, map), "'outputs' is a map: {file name: node.port}");
    check_keys(file, map, {}, "outputs");
    for (const auto& item : map) {
      Scalar source = scalar(file, item.second);
      source.at = position(file, item.first);
      set(spec.outputs, item.first.as<std::string>(""), std::move(source));
    }
  }

  static bool names_a_node(const std::string& key) { return key.find('.') != std::string::npos; }

  std::vector<std::string> variable_names() const {
    std::vector<std::string> names;
    for (const auto& [name, variable] : variables_) names.push_back(name);
    return names;
  }

  void apply_variable_overrides() {
    for (const std::string& text : overrides_) {
      const size_t equals = text.find('=');
      if (equals == std::string::npos) {
        problem({"'" + text + "'", 0, 0}, "is not KEY=VALUE");
        continue;
      }
      const std::string key = text.substr(0, equals);
      if (names_a_node(key)) continue;
      const auto found = variables_.find(key);
      if (found == variables_.end()) {
        problem({"'" + text + "'", 0, 0},
                "this pipeline has no variable '" + key + "'" + did_you_mean(key, variable_names()));
        continue;
      }
      found->second.value = text.substr(equals + 1);
      found->second.given = true;
      found->second.base = fs::current_path();
    }
  }

  void apply_node_overrides(PipelineSpec& spec) {
    for (const std::string& text : overrides_) {
      const size_t equals = text.find('=');
      if (equals == std::string::npos || !names_a_node(text.substr(0, equals))) continue;
      const std::string key = text.substr(0, equals), value = text.substr(equals + 1);
      const Position at{"'" + text + "'", 0, 0};
      const size_t dot = key.find('.');
      const std::string name = key.substr(0, dot), what = key.substr(dot + 1);
      const auto node =
          std::find_if(spec.nodes.begin(), spec.nodes.end(), [&](const NodeSpec& n) { return n.name == name; });
      if (node == spec.nodes.end()) {
        std::vector<std::string> names;
        for (const NodeSpec& n : spec.nodes) names.push_back(n.name);
        problem(at, "this pipeline has no node '" + name + "'" + did_you_mean(name, names));
      } else if (what == "use") {
        node->use = {value, at, fs::current_path()};
      } else if (what.rfind("with.", 0) == 0) {
        set(node->parameters, what.substr(5), override_value(value, at));
      } else if (what.rfind("in.", 0) == 0) {
        set(node->inputs, what.substr(3), Scalar{value, at, fs::current_path()});
      } else {
        problem(at, "write " + name + ".use=KIND, " + name + ".with.PARAMETER=VALUE or " + name + ".in.PORT=NODE.PORT");
      }
    }
  }

  /// `[a, b]` on the command line is a list, everything else one value.
  static ParameterSpec override_value(const std::string& value, const Position& at) {
    ParameterSpec parameter;
    parameter.at = at;
    if (value.size() >= 2 && value.front() == '[' && value.back() == ']') {
      parameter.is_list = true;
      std::istringstream items(value.substr(1, value.size() - 2));
      for (std::string item; std::getline(items, item, ',');) {
        const size_t first = item.find_first_not_of(' '), last = item.find_last_not_of(' ');
        if (first != std::string::npos)
          parameter.values.push_back({item.substr(first, last - first + 1), at, fs::current_path()});
      }
    } else {
      parameter.values.push_back({value, at, fs::current_path()});
    }
    return parameter;
  }

  /// Replaces every ${name}; a path that came with a variable stays relative to where the variable was given.
  void replace(Scalar& scalar) {
    size_t at = 0;
    while ((at = scalar.text.find("${", at)) != std::string::npos) {
      const size_t end = scalar.text.find('}', at);
      if (end == std::string::npos) return problem(scalar.at, "'${' without '}' in '" + scalar.text + "'");
      const std::string name = scalar.text.substr(at + 2, end - at - 2);
      const auto found = variables_.find(name);
      if (found == variables_.end())
        return problem(scalar.at,
                       "there is no variable '" + name + "' under vars" + did_you_mean(name, variable_names()));
      if (!found->second.given)
        return problem(found->second.at,
                       "the variable '" + name + "' has no value: give " + name + "=… on the command line");
      if (at == 0) scalar.base = found->second.base;
      scalar.text.replace(at, end - at + 1, found->second.value);
      at += found->second.value.size();
    }
  }

  const std::vector<std::string>& overrides_;
  std::vector<Problem>& problems_;
  std::map<std::string, Variable> variables_;
  std::vector<fs::path> including_;
};

}  // namespace

PipelineSpec read_pipeline(const fs::path& file, const std::vector<std::string>& overrides,
                           std::vector<Problem>& problems) {
  return Reader(overrides, problems).read(file);
}

}  // namespace plumbline::runtime

#include "runtime/graph/node_overrides.hpp"

#include <algorithm>

#include "runtime/base/near_names.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

/// Items between commas, without blanks at both ends; one in quotes, single or double, may have commas and blanks in
/// it.
std::vector<std::string> list_items(const std::string& text) {
  std::vector<std::string> items;
  for (size_t at = 0; at < text.size();) {
    const size_t first = text.find_first_not_of(' ', at);
    if (first == std::string::npos) break;
    const bool quoted = text[first] == '"' || text[first] == '\'';
    const size_t close = quoted ? text.find(text[first], first + 1) : std::string::npos;
    // A quote that nothing closes is a character like any other.
    const size_t end = std::min(text.find(',', close == std::string::npos ? first : close), text.size());
    const size_t last = text.find_last_not_of(' ', end - 1);
    if (close != std::string::npos && last == close)
      items.push_back(text.substr(first + 1, close - first - 1));
    else if (first < end)
      items.push_back(text.substr(first, last - first + 1));
    at = end + 1;
  }
  return items;
}

/// `[a, b]` on the command line is a list, everything else one value.
ParameterSpec override_value(const std::string& value, const Position& at) {
  ParameterSpec parameter;
  parameter.at = at;
  if (value.size() >= 2 && value.front() == '[' && value.back() == ']') {
    parameter.is_list = true;
    for (const std::string& item : list_items(value.substr(1, value.size() - 2)))
      parameter.values.push_back({item, at, fs::current_path()});
  } else {
    parameter.values.push_back({value, at, fs::current_path()});
  }
  return parameter;
}

void override_rounds(const std::string& what, const Scalar& value, RoundsSpec& rounds, std::vector<Problem>& problems) {
  if (what == "most")
    rounds.most = value;
  else if (what == "until")
    rounds.until = value.text == "~" ? Scalar{} : value;
  else
    problems.push_back(
        {value.at, "of rounds the command line sets rounds.most=NUMBER and rounds.until=NODE.METRIC, no other"});
}

}  // namespace

void apply_node_overrides(const std::vector<std::string>& overrides, PipelineSpec& spec,
                          std::vector<Problem>& problems) {
  for (const std::string& text : overrides) {
    const size_t equals = text.find('=');
    if (!is_node_override(text)) continue;
    const std::string key = text.substr(0, equals), value = text.substr(equals + 1);
    const Position at{"'" + text + "'", 0, 0};
    const size_t dot = key.find('.');
    const std::string name = key.substr(0, dot), what = key.substr(dot + 1);
    if (name == "rounds" && spec.rounds.given) {
      override_rounds(what, Scalar{value, at, fs::current_path()}, spec.rounds, problems);
      continue;
    }
    const auto node =
        std::find_if(spec.nodes.begin(), spec.nodes.end(), [&](const NodeSpec& n) { return n.name == name; });
    if (node == spec.nodes.end()) {
      std::vector<std::string> names;
      for (const NodeSpec& n : spec.nodes) names.push_back(n.name);
      problems.push_back({at, "this pipeline has no node '" + name + "'" + did_you_mean(name, names)});
    } else if (what == "use") {
      node->use = {value, at, fs::current_path()};
    } else if (what.rfind("with.", 0) == 0 && value == "~") {  // what the pipeline sets for the kind it names
      std::erase_if(node->parameters, [&](const auto& parameter) { return parameter.first == what.substr(5); });
    } else if (what.rfind("with.", 0) == 0) {
      set_named(node->parameters, what.substr(5), override_value(value, at));
    } else if (what.rfind("in.", 0) == 0) {
      const std::string port = what.substr(3);
      std::erase_if(node->inputs, [&](const auto& input) { return input.first == port; });
      for (Scalar& source : override_value(value, at).values) node->inputs.emplace_back(port, std::move(source));
    } else if (what == "isolate" || what == "time_limit" || what == "memory_limit") {
      set_named(node->conditions, what, Scalar{value, at, fs::current_path()});
    } else {
      problems.push_back({at, "write " + name + ".use=KIND, " + name + ".with.PARAMETER=VALUE, " + name +
                                  ".in.PORT=NODE.PORT, " + name + ".isolate=process, " + name + ".time_limit=TIME or " +
                                  name + ".memory_limit=SIZE"});
    }
  }
}

bool is_node_override(const std::string& text) {
  const size_t equals = text.find('=');
  return equals != std::string::npos && text.find('.') < equals;
}

}  // namespace plumbline::runtime

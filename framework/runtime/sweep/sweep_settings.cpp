#include "runtime/sweep/sweep_settings.hpp"

#include <algorithm>

namespace plumbline::runtime {

namespace {

const std::string probe = "\x02probe\x02";  // a value that no pipeline has

std::string key_of_setting(const std::string& text) { return text.substr(0, text.find('=')); }
std::string value_of_setting(const std::string& text) { return text.substr(text.find('=') + 1); }

std::map<std::string, std::string> fields_of(const PipelineSpec& spec) {
  std::map<std::string, std::string> fields;
  for (const NodeSpec& node : spec.nodes) {
    fields[node.name + ".use"] = node.use.text;
    fields[node.name + ".each"] = node.each.text;
    for (const auto& [port, source] : node.inputs) fields[node.name + ".in." + port] += source.text + ",";
    for (const auto& [name, parameter] : node.parameters)
      for (const Scalar& value : parameter.values) fields[node.name + ".with." + name] += value.text + ",";
    for (const auto& [name, value] : node.conditions) fields[node.name + "." + name] = value.text;
  }
  fields["rounds.until"] = spec.rounds.until.text;
  fields["rounds.most"] = spec.rounds.most.text;
  return fields;
}

bool has_probe(const std::string& text) { return text.find(probe) != std::string::npos; }

}  // namespace

SettingReach::Fields SettingReach::fields(const std::filesystem::path& pipeline,
                                          const std::vector<std::string>& overrides) const {
  std::vector<Problem> ignored;  // load_pipeline() tells them
  return fields_of(read_pipeline(pipeline, overrides, {}, ignored, &registry_));
}

const SettingReach::Uses& SettingReach::uses_of(const std::filesystem::path& pipeline, const std::string& key) {
  const auto [found, fresh] = uses_.try_emplace({pipeline, key});
  if (!fresh) return found->second;
  std::vector<Problem> ignored;
  const PipelineSpec spec = read_pipeline(pipeline, {key + "=" + probe}, {}, ignored, &registry_);
  for (const auto& [place, value] : fields_of(spec))
    if (has_probe(value)) found->second.places.insert(place);
  for (const auto& [name, value] : spec.variables)
    if (name != key && has_probe(value)) found->second.variables.insert(name);
  return found->second;
}

bool SettingReach::reaches(const std::filesystem::path& pipeline, std::vector<std::string> all,
                           const std::string& variable, const std::set<std::string>& nodes) const {
  all.push_back(variable + "=" + probe);
  std::vector<Problem> problems;
  const auto found = fields_of(read_pipeline(pipeline, all, {}, problems, &registry_));
  if (!problems.empty()) return true;  // it may name what is included
  return std::any_of(found.begin(), found.end(), [&](const auto& field) {
    const std::string node = field.first.substr(0, field.first.find('.'));
    return has_probe(field.second) && (node == "rounds" || nodes.count(node) > 0);
  });
}

std::vector<std::string> SettingReach::replacing(const std::filesystem::path& pipeline,
                                                 const std::vector<std::string>& all, const std::string& text) {
  const std::string key = key_of_setting(text);
  if (is_node_override(text) || key == "seed") return {};  // the seed reaches every node by itself
  const Uses& uses = uses_of(pipeline, key);
  std::vector<std::string> replacing, others, probed;
  for (const std::string& other : all) {
    const std::string name = key_of_setting(other);
    // "~" takes back what the kind in that place has no use for.
    if ((uses.places.count(name) || uses.variables.count(name)) && value_of_setting(other) != "~")
      replacing.push_back(other);
    else
      others.push_back(other);
    probed.push_back(name == key ? key + "=" + probe : other);
  }
  if (replacing.empty()) return {};
  const Fields reached = fields(pipeline, probed);
  if (std::any_of(reached.begin(), reached.end(), [](const auto& field) { return has_probe(field.second); })) return {};
  const Fields with = fields(pipeline, all), without = fields(pipeline, others);
  const bool agree = std::all_of(uses.places.begin(), uses.places.end(), [&](const std::string& place) {
    const auto a = with.find(place), b = without.find(place);
    return a == with.end() ? b == without.end() : b != without.end() && a->second == b->second;
  });
  return agree ? std::vector<std::string>() : replacing;
}

}  // namespace plumbline::runtime

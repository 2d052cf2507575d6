#include "runtime/graph/pipeline_variables.hpp"

#include <algorithm>

#include "runtime/base/near_names.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

constexpr size_t largest_value = size_t{1} << 20;
constexpr const char* the_seed = "seed";  // of the run: it need be neither declared nor named by a value

}  // namespace

std::string PipelineVariables::near_or_all(const std::string& wanted) const {
  if (const std::string near = did_you_mean(wanted); !near.empty()) return near;
  std::string all;
  for (const auto& [name, variable] : variables_)
    if (name != the_seed) all += (all.empty() ? "" : ", ") + name;
  return "; it has " + (all.empty() ? "none" : all) + "; a parameter of a node is set by NODE.with.PARAMETER=VALUE";
}

std::string PipelineVariables::did_you_mean(const std::string& wanted) const {
  std::vector<std::string> names;
  for (const auto& [name, variable] : variables_) names.push_back(name);
  return runtime::did_you_mean(wanted, names);
}

void PipelineVariables::mention(const std::string& text) {
  for (size_t at = text.find("${"); at != std::string::npos; at = text.find("${", at + 2))
    if (const size_t end = text.find('}', at); end != std::string::npos)
      mentioned_.insert(text.substr(at + 2, end - at - 2));
}

void PipelineVariables::tell_unused(const std::vector<std::string>& overrides) {
  for (const std::string& text : overrides) mention(text);
  for (const auto& [name, variable] : variables_) {
    if (name == the_seed || mentioned_.count(name)) continue;
    std::vector<std::string> others(mentioned_.begin(), mentioned_.end());
    for (const auto& [other, entry] : variables_)
      if (other != name) others.push_back(other);
    std::sort(others.begin(), others.end());
    others.erase(std::unique(others.begin(), others.end()), others.end());
    const std::string near = runtime::did_you_mean(name, others);
    problem(variable.declared,
            "nothing uses the variable '" + name + "'" +
                (near.empty() ? "; write ${" + name + "} where its value belongs, or take it away" : near));
  }
}

void PipelineVariables::apply(const std::vector<std::string>& overrides) {
  for (const std::string& text : overrides) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos) {
      problem({"'" + text + "'", 0, 0}, "is not KEY=VALUE");
      continue;
    }
    if (is_node_override(text)) continue;
    const std::string key = text.substr(0, equals);
    auto found = variables_.find(key);
    if (found == variables_.end() && key == the_seed) found = variables_.try_emplace(key).first;
    if (found == variables_.end()) {
      problem({"'" + text + "'", 0, 0}, "this pipeline has no variable '" + key + "'" + near_or_all(key));
      continue;
    }
    found->second.value = {text.substr(equals + 1), {"'" + text + "'", 0, 0}, fs::current_path()};
    found->second.given = true;
  }
}

std::map<std::string, std::string> PipelineVariables::values() const {
  std::map<std::string, std::string> list;
  for (const auto& [name, variable] : variables_) list[name] = variable.value.text;
  return list;
}

void PipelineVariables::resolve() {
  for (auto& [name, variable] : variables_)
    if (variable.given) resolve(variable);
}

void PipelineVariables::resolve(Variable& variable) {
  if (variable.state == Variable::done) return;
  if (variable.state == Variable::busy) {
    problem(variable.value.at,
            "this variable takes its value from itself; write a value that does not lead back to it");
    variable.value.unresolved = true;
    return;
  }
  variable.state = Variable::busy;
  replace(variable.value);
  variable.state = Variable::done;
}

void PipelineVariables::replace(Scalar& scalar) {
  const auto give_up = [&](const Position& at, const std::string& message) {
    problem(at, message);
    scalar.unresolved = true;
  };
  std::string result;
  size_t done = 0;
  for (size_t at; (at = scalar.text.find("${", done)) != std::string::npos;) {
    const size_t end = scalar.text.find('}', at);
    if (end == std::string::npos) return give_up(scalar.at, "'${' without '}' in '" + scalar.text + "'");
    const std::string name = scalar.text.substr(at + 2, end - at - 2);
    const auto found = variables_.find(name);
    if (found == variables_.end())
      return give_up(scalar.at, "there is no variable '" + name + "' under vars" + did_you_mean(name));
    Variable& variable = found->second;
    if (!variable.given) {
      const bool first = told_.insert(name).second;
      scalar.unresolved = true;
      if (first)
        problem(variable.value.at, "the variable '" + name + "' has no value: give " + name + "=… on the command line");
      return;
    }
    resolve(variable);
    if (variable.value.unresolved) {
      scalar.unresolved = true;
      return;
    }
    if (at == 0) scalar.base = variable.value.base;
    if (at == 0 && end + 1 == scalar.text.size())
      scalar.given_at = variable.value.given_at.file.empty() ? variable.value.at : variable.value.given_at;
    result += scalar.text.substr(done, at - done) + variable.value.text;
    if (result.size() > largest_value) return give_up(scalar.at, "its value grows beyond a mebibyte");
    done = end + 1;
  }
  scalar.text = result + scalar.text.substr(done);
}

}  // namespace plumbline::runtime

#include "runtime/graph/role_expansion.hpp"

#include <algorithm>
#include <set>

#include "runtime/base/near_names.hpp"

namespace plumbline::runtime {
namespace {

constexpr const char* item_separator = "\x1f";  // plugin.h

std::string node_of(const Scalar& source) { return source.text.substr(0, source.text.find('.')); }

/// "readers", "read.tracker" -> "readers_read_tracker": a name of a node has no dots.
std::string copy_name(const std::string& node, std::string kind) {
  std::replace(kind.begin(), kind.end(), '.', '_');
  return node + "_" + kind;
}

std::vector<Scalar> default_values(const Kind& kind, const std::string& parameter, const Scalar& at) {
  std::vector<Scalar> values;
  const plumbline_param* found = kind.param(parameter);
  std::string text = found && found->default_text ? found->default_text : "";
  for (size_t end; !text.empty(); text = end == std::string::npos ? "" : text.substr(end + 1)) {
    end = text.find(item_separator);
    values.push_back({text.substr(0, end), at.at, at.base});
  }
  return values;
}

class Expansion {
 public:
  Expansion(PipelineSpec& spec, const Registry* registry, std::vector<Problem>& problems)
      : spec_(spec), registry_(registry), problems_(problems) {}

  void run() {
    for (const NodeSpec& node : spec_.nodes)
      if (!node.for_each.text.empty()) families_.emplace(node.name, Family{node.for_each.text, kinds_of(node)});
    if (families_.empty()) return;
    std::vector<NodeSpec> nodes;
    std::set<std::string> names;
    for (const NodeSpec& node : spec_.nodes)
      if (node.for_each.text.empty()) names.insert(node.name);
    for (NodeSpec& node : spec_.nodes) {
      const auto family = families_.find(node.name);
      if (family == families_.end()) {
        if (connect(node, nullptr, "")) nodes.push_back(std::move(node));
        continue;
      }
      for (const auto& [name, kind] : family->second.kinds) {
        NodeSpec copy = node;
        if (!names.insert(copy_name(node.name, name)).second)
          problems_.push_back({node.for_each.at, "'" + node.name + "' for " + name + " would be called '" +
                                                     copy_name(node.name, name) +
                                                     "', and so is another node: give one of them another name"});
        if (connect(copy, &family->second, name)) nodes.push_back(of_kind(std::move(copy), name, *kind));
      }
    }
    for (NodeSpec& node : nodes)
      std::erase_if(node.inputs, [&](const auto& input) { return fallen_.count(node_of(input.second)); });
    spec_.nodes = std::move(nodes);
    check_outputs();
  }

 private:
  struct Family {
    std::string for_each;
    std::map<std::string, const Kind*> kinds;
  };

  std::map<std::string, const Kind*> kinds_of(const NodeSpec& node) {
    std::map<std::string, const Kind*> kinds;
    if (!registry_) return kinds;
    const std::string& text = node.for_each.text;
    const std::string role = text.substr(0, text.find('.'));
    const std::string parameter = role.size() < text.size() ? text.substr(role.size() + 1) : "";
    std::vector<std::string> roles;
    for (const auto& [name, entry] : registry_->roles().all()) roles.push_back(name);
    if (std::find(roles.begin(), roles.end(), role) == roles.end())
      problems_.push_back({node.for_each.at,
                           "'for_each' names a role, or ROLE.PARAMETER for the kinds of it that have "
                           "the parameter; there is no role '" +
                               role + "'" + did_you_mean(role, roles)});
    for (const auto& [name, kind] : registry_->kinds())
      if (role == kind.node->role && (parameter.empty() || kind.param(parameter))) kinds.emplace(name, &kind);
    return kinds;
  }

  /// False if an input that the node names has nothing left to take.
  bool connect(NodeSpec& node, const Family* family, const std::string& kind) {
    std::vector<std::pair<std::string, Scalar>> inputs;
    std::set<std::string> named, fed;
    for (const auto& [port, source] : node.inputs) {
      const auto from = families_.find(node_of(source));
      named.insert(port);
      if (from == families_.end()) {
        inputs.emplace_back(port, source);
        fed.insert(port);
        continue;
      }
      const bool within = family && family->for_each == from->second.for_each;
      for (const auto& [name, entry] : from->second.kinds) {
        if (within && name != kind) continue;
        Scalar one = source;
        one.text = copy_name(from->first, name) + source.text.substr(from->first.size());
        inputs.emplace_back(port, std::move(one));
        fed.insert(port);
      }
    }
    node.inputs = std::move(inputs);
    if (named == fed) return true;
    fallen_.insert(family ? copy_name(node.name, kind) : node.name);
    return false;
  }

  static NodeSpec of_kind(NodeSpec node, const std::string& name, const Kind& kind) {
    node.name = copy_name(node.name, name);
    if (node.use.text == "${kind}") node.use.text = name;
    for (auto& [parameter, spec] : node.parameters) {
      std::vector<Scalar> values;
      for (const Scalar& value : spec.values) {
        const std::string& text = value.text;
        if (text == "${kind}") {
          values.push_back({name, value.at, value.base});
        } else if (text.starts_with("${kind.") && text.ends_with("}")) {
          const std::string of = text.substr(7, text.size() - 8);
          spec.is_list = spec.is_list || (kind.param(of) && kind.param(of)->is_list);
          for (Scalar& one : default_values(kind, of, value)) values.push_back(std::move(one));
        } else {
          values.push_back(value);
        }
      }
      spec.values = std::move(values);
    }
    return node;
  }

  void check_outputs() {
    std::erase_if(spec_.outputs, [&](const auto& output) { return fallen_.count(node_of(output.second)); });
    for (const auto& [file, source] : spec_.outputs)
      if (families_.count(node_of(source)))
        problems_.push_back({source.at, "'" + node_of(source) +
                                            "' stands once for each kind of a role, and an output is one: name one of "
                                            "them, or join them in a node"});
  }

  PipelineSpec& spec_;
  const Registry* registry_;
  std::vector<Problem>& problems_;
  std::map<std::string, Family> families_;  // by node
  std::set<std::string> fallen_;            // nodes that had nothing to take
};

}  // namespace

void expand_roles(PipelineSpec& spec, const Registry* registry, std::vector<Problem>& problems) {
  Expansion(spec, registry, problems).run();
}

}  // namespace plumbline::runtime

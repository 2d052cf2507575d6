#include "runtime/graph/graph_linker.hpp"

#include <algorithm>
#include <cstring>
#include <set>
#include <utility>

#include "runtime/base/near_names.hpp"
#include "runtime/graph/output_name.hpp"
#include "runtime/graph/parameters.hpp"
#include "runtime/graph/rounds_linker.hpp"
#include "runtime/plugins/frames.hpp"
#include "runtime/plugins/type_schema.hpp"

namespace plumbline::runtime {

std::string list_text(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

namespace {

std::vector<std::string> port_names(const plumbline_port* const* ports, uint32_t count) {
  std::vector<std::string> names;
  for (uint32_t i = 0; i < count; ++i) names.push_back(ports[i]->name);
  return names;
}

/// Builds the graph from the file's words; every step adds what is wrong to `problems` and goes on with the rest.
class Linker {
 public:
  Linker(const PipelineSpec& spec, const Registry& registry, std::vector<Problem>& problems)
      : spec_(spec), registry_(registry), problems_(problems), rounds_(spec.rounds, problems) {}

  Graph link() {
    for (const NodeSpec& node : spec_.nodes) add_node(node);
    if (const auto named = index_.find("rounds"); spec_.rounds.given && named != index_.end())
      problem(nodes_[named->second].at, "in a pipeline with rounds no node can have the name 'rounds'");
    rounds_.find_carries([this](const Scalar& text, Source& source) { return find_source(text, source); });
    for (size_t i = 0; i < nodes_.size(); ++i) connect(i);
    Graph graph;
    sort(graph);
    for (GraphNode& node : graph.nodes) unify(graph, node);
    add_outputs(graph);
    graph.rounds = rounds_.finish(graph, position_);
    graph.variables = spec_.variables;
    graph.sources = spec_.sources;
    return graph;
  }

 private:
  void problem(const Position& at, const std::string& message) { problems_.push_back({at, message}); }

  void add_node(const NodeSpec& spec) {
    GraphNode node;
    node.name = spec.name;
    node.at = spec.at;
    if (spec.use.unresolved) {
      // told already
    } else if (spec.use.text.empty()) {
      problem(spec.at, "node '" + spec.name + "' does not say which kind to use: {use: family.name}");
    } else if (const Kind* kind = registry_.find(spec.use.text)) {
      node.kind = *kind;
      node.parameters = check_parameters(*kind, spec, problems_);
    } else {
      std::vector<std::string> names;
      for (const auto& [name, entry] : registry_.kinds()) names.push_back(name);
      const std::string hint = did_you_mean(spec.use.text, names);
      problem(spec.use.at, "there is no node '" + spec.use.text + "'" +
                               (hint.empty() ? "; `plumbline list` shows what there is" : hint) + refused_text());
    }
    index_.emplace(node.name, nodes_.size());
    set_conditions(node, spec);
    nodes_.push_back(std::move(node));
    specs_.push_back(&spec);
  }

  void set_conditions(GraphNode& node, const NodeSpec& spec) {
    const NodeSpec::Condition* refusal = nullptr;
    for (const auto& condition : spec.conditions) {
      const auto& [name, value] = condition;
      if (value.unresolved) continue;
      const std::string expected = set_condition(node, name, value.text);
      if (!expected.empty())
        problem(value.at, "'" + name + "' of node '" + spec.name + "' is " + expected + ", found '" + value.text + "'");
      if (name == "isolate" && value.text == "no") refusal = &condition;
    }
    if (refusal && node.isolate)
      problem(refusal->second.at, "node '" + spec.name +
                                      "' has a limit, which is kept only in a process of its own; take away the limit "
                                      "or write isolate: process");
  }

  /// Returns what would be right, if this is not.
  static std::string set_condition(GraphNode& node, const std::string& name, const std::string& text) {
    if (name == "isolate") {
      node.isolate |= text == "process";
      return text == "process" || text == "no" ? "" : "process or no";
    }
    node.isolate = true;
    if (name == "time_limit") {
      const auto seconds = parse_seconds(text);
      node.limits.seconds = seconds.value_or(0);
      return seconds ? "" : "a time, such as 90 s or 5 min";
    }
    const auto bytes = parse_bytes(text);
    node.limits.memory = bytes.value_or(0);
    return bytes ? "" : "a size of memory, such as 2GiB";
  }

  /// What is missing may be in a plugin that was refused.
  std::string refused_text() {
    std::string text;
    if (std::exchange(refused_are_told_, true)) return text;
    for (const PluginIdentity& plugin : registry_.refused())
      if (plugin.hidden_by.empty())
        text += (text.empty() ? "; it may be in what was refused: " : "; ") + plugin.path.string() + ", which " +
                plugin.problem;
    return text;
  }

  /// "poses.poses" -> index of the node and its output port; nothing after telling what is wrong.
  bool find_source(const Scalar& text, Source& source) {
    if (text.unresolved) return false;  // told already
    const size_t dot = text.text.find('.');
    const std::string name = text.text.substr(0, dot);
    const auto at = index_.find(name);
    if (at == index_.end()) {
      std::vector<std::string> names;
      for (const GraphNode& node : nodes_) names.push_back(node.name);
      problem(text.at, "there is no node '" + name + "' in this pipeline" + did_you_mean(name, names));
      return false;
    }
    const GraphNode* found = &nodes_[at->second];
    if (!found->kind.node) return false;  // its kind is unknown, which was told already
    const auto outputs = port_names(found->kind.node->outputs, found->kind.node->output_count);
    source = {at->second, dot == std::string::npos ? "" : text.text.substr(dot + 1), text.at};
    if (found->kind.output(source.port)) return true;
    problem(text.at, (source.port.empty()
                          ? "write node.port, not only '" + name + "'"
                          : "'" + name + "' (" + found->kind.node->kind + ") has no output '" + source.port + "'") +
                         (source.port.empty() || did_you_mean(source.port, outputs).empty()
                              ? (outputs.empty() ? "; it has none" : "; its outputs are: " + list_text(outputs))
                              : did_you_mean(source.port, outputs)));
    return false;
  }

  void connect(size_t index) {
    GraphNode& node = nodes_[index];
    if (!node.kind.node) return;
    for (const auto& [port_name, text] : specs_[index]->inputs) {
      const plumbline_port* port = node.kind.input(port_name);
      if (!port && registry_.roles().may_lack(*node.kind.node, port_name)) {
        Source unused;  // left out, but a name that is nowhere is a mistake all the same
        if (!rounds_.is_meant(text.text)) find_source(text, unused);
        continue;
      }
      if (!port) {
        const auto inputs = port_names(node.kind.node->inputs, node.kind.node->input_count);
        const bool of_another_kind = specs_[index]->use.at.line == 0 && text.at.line > 0;  // the kind is an override
        const std::string hint = of_another_kind ? "" : did_you_mean(port_name, inputs);
        problem(text.at, "'" + std::string(node.kind.node->kind) + "' has no input '" + port_name + "'" +
                             (!hint.empty()    ? hint
                              : inputs.empty() ? "; it has none"
                                               : "; its inputs are: " + list_text(inputs)) +
                             (of_another_kind ? "; " + node.name + ".in." + port_name + "=[] leaves it out" : ""));
        continue;
      }
      std::string& connection = node.connections[port_name];
      connection += (connection.empty() ? "" : ", ") + text.text;
      if (!missing_is_told_.insert({index, port_name}).second) refuse_second(node, *port, text);
      if (rounds_.is_meant(text.text)) {
        connect_to_rounds(node, *port, text);
        continue;
      }
      Source source;
      if (find_source(text, source) && types_agree(node, *port, source)) node.inputs.emplace(port_name, source);
    }
    for (uint32_t i = 0; i < node.kind.node->input_count; ++i) {
      const plumbline_port& port = *node.kind.node->inputs[i];
      if (port.cardinality != PLUMBLINE_OPTIONAL && !node.inputs.count(port.name) &&
          !missing_is_told_.count({index, port.name}))
        problem(node.at, "input '" + std::string(port.name) + "' of '" + node.name + "' (" + node.kind.node->kind +
                             ") is not connected; it takes " + port.type + ": " + port.doc);
      if (port.cardinality == PLUMBLINE_EACH) {
        node.maps = true;
        node.each_port = port.name;
      }
    }
    map_over_one(node, specs_[index]->each);
    for (uint32_t i = 0; i < node.kind.node->output_count; ++i) {
      const plumbline_port& port = *node.kind.node->outputs[i];
      node.output_is_list[port.name] = node.maps || port.cardinality == PLUMBLINE_LIST;
    }
  }

  /// `each: PORT`: a node whose port takes one item runs for every item of a list.
  void map_over_one(GraphNode& node, const Scalar& each) {
    if (each.text.empty()) return;
    const plumbline_port* port = node.kind.input(each.text);
    if (!port || port->cardinality != PLUMBLINE_ONE || node.maps)
      return problem(each.at, "'each' of node '" + node.name +
                                  "' names an input that takes one item, for each item of " + "a list; '" +
                                  node.kind.node->kind + "' " +
                                  (node.maps ? "runs for each item of '" + node.each_port + "' already"
                                   : port    ? "takes more than one at '" + each.text + "'"
                                             : "has no input '" + each.text + "'"));
    node.maps = true;
    node.each_port = port->name;
  }

  /// Another connection of an input that has one already: only of a list, and not beside what rounds carry.
  void refuse_second(const GraphNode& node, const plumbline_port& port, const Scalar& text) {
    const std::string input = "input '" + std::string(port.name) + "' of '" + node.name + "' takes one connection";
    if (port.cardinality != PLUMBLINE_LIST && port.cardinality != PLUMBLINE_EACH)
      problem(text.at, input + ", found several: it is no list");
    else if (rounds_.is_meant(text.text) || node.carried.count(port.name) || node.collected.count(port.name))
      problem(text.at, input + " where one of them comes from the rounds; join them in a node");
  }

  void connect_to_rounds(GraphNode& node, const plumbline_port& port, const Scalar& text) {
    bool first_is_input = false, good = true;
    const std::vector<Source> sources = rounds_.connect(node, port, text, first_is_input);
    for (const Source& source : sources) good = types_agree(node, port, source) && good;
    if (good && first_is_input) node.inputs.emplace(port.name, sources.front());
  }

  bool types_agree(const GraphNode& node, const plumbline_port& port, const Source& source) {
    const GraphNode& from = nodes_[source.node];
    const plumbline_port& output = *from.kind.output(source.port);
    if (std::strcmp(port.type, output.type) == 0) return builds_agree(node, port, from, source);
    problem(source.at, "input '" + std::string(port.name) + "' of '" + node.name + "' takes " + port.type + ", '" +
                           from.name + "." + source.port + "' gives " + output.type);
    return false;
  }

  /// Two plugins may have been built from different schemas of one name.
  bool builds_agree(const GraphNode& node, const plumbline_port& port, const GraphNode& from, const Source& source) {
    const plumbline_port& output = *from.kind.output(source.port);
    if (std::strcmp(port.fingerprint, output.fingerprint) == 0) return true;
    const std::string difference = compare_types(node.kind.type_of(port), from.kind.type_of(output));
    if (difference.empty()) return true;
    problem(source.at,
            "input '" + std::string(port.name) + "' of '" + node.name + "' and '" + from.name + "." + source.port +
                "' are both " + port.type + ", but " + node.kind.plugin->identity.path.filename().string() +
                " (here) and " + from.kind.plugin->identity.path.filename().string() +
                " (there) were built from different schemas: " + difference + "; rebuild the older of the two");
    return false;
  }

  void sort(Graph& graph) {
    std::vector<State> state(nodes_.size(), State::fresh);
    for (size_t i = 0; i < nodes_.size(); ++i) visit(i, state);
    position_.resize(nodes_.size());
    for (size_t i = 0; i < order_.size(); ++i) position_[order_[i]] = i;
    graph.nodes.reserve(nodes_.size());
    for (const size_t i : order_) {
      for (auto& [port, source] : nodes_[i].inputs) source.node = position_[source.node];
      graph.nodes.push_back(nodes_[i]);
    }
  }

  enum class State { fresh, on_path, done };

  /// Depth first with a path of its own: a chain of many thousand nodes must not grow the stack.
  void visit(size_t first, std::vector<State>& state) {
    struct Step {
      size_t node;
      std::multimap<std::string, Source>::const_iterator next;
    };
    if (state[first] != State::fresh) return;
    std::vector<Step> path{{first, nodes_[first].inputs.begin()}};
    state[first] = State::on_path;
    while (!path.empty()) {
      Step& step = path.back();
      if (step.next == nodes_[step.node].inputs.end()) {
        state[step.node] = State::done;
        order_.push_back(step.node);
        path.pop_back();
        continue;
      }
      const size_t source = (step.next++)->second.node;
      if (state[source] == State::fresh) {
        state[source] = State::on_path;
        path.push_back({source, nodes_[source].inputs.begin()});
      } else if (state[source] == State::on_path) {
        std::string circle;
        auto at = std::find_if(path.begin(), path.end(), [&](const Step& s) { return s.node == source; });
        for (; at != path.end(); ++at) circle += nodes_[at->node].name + " → ";
        if (circles_.insert(circle).second)  // two connections may close the same one
          problem(nodes_[source].at, "the nodes go round in a circle: " + circle + nodes_[source].name +
                                         "; one of them has to take its input from elsewhere");
      }
    }
  }

  /// Checks cardinalities and binds the frame variables of a node whose sources are done.
  void unify(const Graph& graph, GraphNode& node) {
    if (!node.kind.node) return;
    std::map<std::string, std::string> bound;
    for (uint32_t i = 0; i < node.kind.node->input_count; ++i) {
      const plumbline_port& port = *node.kind.node->inputs[i];
      const auto [first, last] = node.inputs.equal_range(port.name);
      for (auto edge = first; edge != last; ++edge) unify_edge(graph, node, port, edge->second, bound);
    }
    for (uint32_t i = 0; i < node.kind.node->output_count; ++i) {
      const plumbline_port& port = *node.kind.node->outputs[i];
      std::string text;
      for (const auto& [key, frame] : split_frames(port.frames)) {
        const auto value = bound.find(frame);
        text += (text.empty() ? "" : ",") + key + "=" + (value == bound.end() ? frame : value->second);
      }
      node.output_frames[port.name] = text;
    }
  }

  void unify_edge(const Graph& graph, const GraphNode& node, const plumbline_port& port, const Source& source,
                  std::map<std::string, std::string>& bound) {
    const GraphNode& from = graph.nodes[source.node];
    const auto list = from.output_is_list.find(source.port);
    if (list != from.output_is_list.end() && list->second && node.each_port != port.name &&
        (port.cardinality == PLUMBLINE_ONE || port.cardinality == PLUMBLINE_OPTIONAL))
      problem(source.at, "input '" + std::string(port.name) + "' of '" + node.name + "' takes one " + port.type +
                             ", '" + from.name + "." + source.port + "' gives a list of them");
    const auto frames = from.output_frames.find(source.port);
    if (frames != from.output_frames.end()) unify_port(node, port, from, source, frames->second, bound);
  }

  void unify_port(const GraphNode& node, const plumbline_port& port, const GraphNode& from, const Source& source,
                  const std::string& given_text, std::map<std::string, std::string>& bound) {
    std::map<std::string, std::string> given;
    for (const auto& [key, frame] : split_frames(given_text)) given[key] = frame;
    for (const auto& [key, wanted] : split_frames(port.frames)) {
      const auto found = given.find(key);
      if (found == given.end() || is_frame_variable(found->second)) continue;
      std::string expected = wanted, reason;
      if (is_frame_variable(wanted)) {
        const auto [value, fresh] = bound.emplace(wanted, found->second);
        expected = value->second;
        reason = " (as its other inputs)";
      }
      if (expected != found->second)
        problem(source.at, "input '" + std::string(port.name) + "' of '" + node.name + "' takes " + key + " '" +
                               expected + "'" + reason + ", '" + from.name + "." + source.port + "' gives " + key +
                               " '" + found->second + "'");
    }
  }

  void add_outputs(Graph& graph) {
    std::set<std::string> names;
    for (const auto& [file, text] : spec_.outputs) names.insert(file);
    for (const auto& [file, text] : spec_.outputs) {
      if (const std::string wrong = output_name_problem(file); !wrong.empty()) problem(text.at, wrong);
      for (size_t at = file.find('/'); at != std::string::npos; at = file.find('/', at + 1))
        if (names.count(file.substr(0, at)))
          problem(text.at,
                  "output '" + file + "' lies inside output '" + file.substr(0, at) + "'; give it another name");
      Source source;
      if (!find_source(text, source)) continue;
      source.node = position_[source.node];
      graph.outputs.push_back({file, source});
    }
  }

  const PipelineSpec& spec_;
  const Registry& registry_;
  std::vector<Problem>& problems_;
  std::vector<GraphNode> nodes_;
  std::vector<const NodeSpec*> specs_;
  std::map<std::string, size_t> index_;  // in nodes_, by name
  std::set<std::pair<size_t, std::string>> missing_is_told_;
  std::vector<size_t> order_, position_;
  bool refused_are_told_ = false;
  RoundsLinker rounds_;
  std::set<std::string> circles_;  // that were told of
};

}  // namespace

Graph link_pipeline(const PipelineSpec& spec, const Registry& registry, std::vector<Problem>& problems) {
  return Linker(spec, registry, problems).link();
}

}  // namespace plumbline::runtime

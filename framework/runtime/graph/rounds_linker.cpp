#include "runtime/graph/rounds_linker.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "runtime/base/near_names.hpp"
#include "runtime/graph/graph_linker.hpp"
#include "runtime/plugins/frames.hpp"

namespace plumbline::runtime {

namespace {

constexpr size_t most_rounds = 100'000;
const std::string all_prefix = "all.";

std::string without_blanks(const std::string& text) {
  const size_t first = text.find_first_not_of(' ');
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(' ') - first + 1);
}

}  // namespace

void RoundsLinker::find_carries(const std::function<bool(const Scalar&, Source&)>& find_source) {
  for (const RoundsSpec::Carry& spec : spec_.carry) {
    Found found;
    found.carry.name = spec.name;
    if (spec.next.text.empty() && !spec.next.unresolved) {
      problem(spec.at, "what is carried as '" + spec.name + "' must say what the next round takes: next: NODE.PORT");
    } else {
      found.good = find_source(spec.next, found.carry.next);
    }
    if (Source first; !spec.first.text.empty()) {
      found.good = find_source(spec.first, first) && found.good;
      found.carry.first = first;
    }
    found_.push_back(std::move(found));
  }
}

std::vector<Source> RoundsLinker::connect(GraphNode& node, const plumbline_port& port, const Scalar& text,
                                          bool& first_is_input) {
  first_is_input = false;
  std::string name = text.text.substr(std::string("rounds.").size());
  const bool all = name.rfind(all_prefix, 0) == 0;
  if (all) name = name.substr(all_prefix.size());
  const auto found = std::find_if(found_.begin(), found_.end(), [&](const Found& f) { return f.carry.name == name; });
  if (found == found_.end()) {
    std::vector<std::string> names;
    for (const Found& f : found_) names.push_back(f.carry.name);
    const std::string hint = did_you_mean(name, names);
    problem(text.at, "nothing is carried from round to round as '" + name + "'" +
                         (!hint.empty()   ? hint
                          : names.empty() ? "; say rounds: {carry: {" + name + ": node.port}}"
                                          : "; carried are: " + list_text(names)));
    return {};
  }
  found->used = true;
  if (!found->good) return {};
  Source next = found->carry.next;
  next.at = text.at;
  if (all) {
    node.collected[port.name] = name;
    if (port.cardinality == PLUMBLINE_ONE || port.cardinality == PLUMBLINE_OPTIONAL)
      problem(text.at, "input '" + std::string(port.name) + "' of '" + node.name + "' takes one " + port.type + ", '" +
                           text.text + "' gives a list of them, one a round");
    return {next};
  }
  node.carried[port.name] = name;
  if (!found->carry.first) {
    if (port.cardinality != PLUMBLINE_OPTIONAL)
      problem(text.at, "input '" + std::string(port.name) + "' of '" + node.name +
                           "' must be connected in the first round, too; write carry: {" + name +
                           ": {first: NODE.PORT, next: NODE.PORT}}");
    return {next};
  }
  first_is_input = true;
  Source first = *found->carry.first;
  first.at = text.at;
  return {first, next};
}

/// "node.metric" or "node.metric < 0.1".
std::optional<Condition> RoundsLinker::condition(const Graph& graph) {
  if (spec_.until.text.empty() || spec_.until.unresolved) return std::nullopt;
  Condition condition;
  condition.text = spec_.until.text;
  std::string metric = spec_.until.text;
  const auto refuse = [&](const std::string& found) {
    problem(spec_.until.at,
            "'until' is a metric of a node that is above 0 in the last round, NODE.METRIC, or a "
            "comparison, NODE.METRIC < 0.1 (>, >=, <, <=, =); found " +
                found);
    return std::nullopt;
  };
  if (const size_t at = metric.find_first_of("<>="); at != std::string::npos) {
    const size_t end = metric.find_first_not_of("<>=", at);
    condition.comparison = metric.substr(at, end == std::string::npos ? end : end - at);
    if (condition.comparison == "==") condition.comparison = "=";
    const std::string number = end == std::string::npos ? "" : without_blanks(metric.substr(end));
    const auto [last, error] = std::from_chars(number.data(), number.data() + number.size(), condition.limit);
    if (error != std::errc() || last != number.data() + number.size() || !std::isfinite(condition.limit))
      return refuse("'" + spec_.until.text + "'");
    if (condition.comparison != ">" && condition.comparison != ">=" && condition.comparison != "<" &&
        condition.comparison != "<=" && condition.comparison != "=")
      return refuse("the comparison '" + condition.comparison + "'");
    metric = metric.substr(0, at);
  }
  metric = without_blanks(metric);
  const size_t dot = metric.find('.');
  if (dot == std::string::npos || dot == 0 || dot + 1 == metric.size()) return refuse("'" + spec_.until.text + "'");
  const std::string name = metric.substr(0, dot);
  condition.metric = metric.substr(dot + 1);
  std::vector<std::string> names;
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    names.push_back(graph.nodes[i].name);
    if (graph.nodes[i].name != name) continue;
    condition.node = i;
    return condition;
  }
  problem(spec_.until.at, "there is no node '" + name + "' in this pipeline" + did_you_mean(name, names));
  return std::nullopt;
}

Rounds RoundsLinker::finish(const Graph& graph, const std::vector<size_t>& position) {
  Rounds rounds;
  if (!spec_.given) return rounds;
  size_t most = 0;
  const std::string& text = spec_.most.text;
  const auto [last, error] = std::from_chars(text.data(), text.data() + text.size(), most);
  if (!spec_.most.unresolved &&
      (error != std::errc() || last != text.data() + text.size() || most == 0 || most > most_rounds))
    problem(text.empty() ? spec_.at : spec_.most.at,
            "'rounds' must say how many there may be at most: most: 20 (1 to " + std::to_string(most_rounds) + ")" +
                (text.empty() ? "" : ", found '" + text + "'"));
  if (spec_.carry.empty())
    problem(spec_.at, "'rounds' must say what one round takes from the one before: carry: {name: node.port}");
  bool good = true;
  for (size_t i = 0; i < found_.size(); ++i) {
    Found& found = found_[i];
    if (!found.used)
      problem(spec_.carry[i].at, "nothing takes what is carried as '" + found.carry.name +
                                     "'; connect an input to rounds." + found.carry.name + ", or take it away");
    good = good && found.good;
    if (!found.good) continue;
    found.carry.next.node = position[found.carry.next.node];
    if (found.carry.first) found.carry.first->node = position[found.carry.first->node];
    rounds.carry.push_back(found.carry);
  }
  rounds.until = condition(graph);
  rounds.most = std::max<size_t>(most, 1);
  if (!good || !problems_.empty()) return rounds;
  const std::vector<bool> changes = changes_by_round(graph);
  for (size_t i = 0; i < rounds.carry.size(); ++i)
    if (!changes[rounds.carry[i].next.node])
      problem(spec_.carry[i].at, "'" + graph.nodes[rounds.carry[i].next.node].name +
                                     "' takes nothing from the round before, so it is the same in all of them");
  if (rounds.until && !changes[rounds.until->node])
    problem(spec_.until.at, "'" + graph.nodes[rounds.until->node].name +
                                "' takes nothing from the round before, so its metrics are the same in all of them");
  const std::vector<bool> needed = needed_by_rounds(graph, rounds);
  for (size_t i = 0; i < graph.nodes.size(); ++i) {
    if (needed[i] && !graph.nodes[i].collected.empty())
      problem(graph.nodes[i].at, "'" + graph.nodes[i].name +
                                     "' takes what all rounds gave, but the rounds need it; "
                                     "only nodes after the last round can take rounds.all");
    check_ports(graph, graph.nodes[i], rounds);
  }
  check_joins(graph, changes, needed);
  return rounds;
}

/// Several connections of a list come from one pass over the graph, where their order is kept: all of them change from
/// round to round or none, and all are needed by the rounds or none.
void RoundsLinker::check_joins(const Graph& graph, const std::vector<bool>& changes, const std::vector<bool>& needed) {
  for (const GraphNode& node : graph.nodes)
    for (auto next = node.inputs.begin(); next != node.inputs.end(); ++next) {
      const auto& [port, source] = *next;
      const Source& first = node.inputs.lower_bound(port)->second;
      if (changes[source.node] != changes[first.node] || needed[source.node] != needed[first.node])
        problem(source.at, "input '" + port + "' of '" + node.name + "' takes '" + graph.nodes[first.node].name +
                               "' and '" + graph.nodes[source.node].name +
                               "', of which one belongs to the rounds and the other does not; join them in a node");
    }
}

/// What comes in later rounds must fit as well as what came in the first: one or a list of it, and in which frames.
void RoundsLinker::check_ports(const Graph& graph, const GraphNode& node, const Rounds& rounds) {
  for (const auto& [port_name, name] : node.carried) {
    const plumbline_port& port = *node.kind.input(port_name);
    const auto carry =
        std::find_if(rounds.carry.begin(), rounds.carry.end(), [&](const Carry& c) { return c.name == name; });
    const GraphNode& from = graph.nodes[carry->next.node];
    const std::string next = from.name + "." + carry->next.port;
    if (from.output_is_list.at(carry->next.port) &&
        (port.cardinality == PLUMBLINE_ONE || port.cardinality == PLUMBLINE_OPTIONAL))
      problem(carry->next.at, "input '" + port_name + "' of '" + node.name + "' takes one " + port.type + ", '" + next +
                                  "' gives a list of them to the next round");
    std::map<std::string, std::string> given, before;
    for (const auto& [key, frame] : split_frames(from.output_frames.at(carry->next.port))) given[key] = frame;
    if (carry->first)
      for (const auto& [key, frame] :
           split_frames(graph.nodes[carry->first->node].output_frames.at(carry->first->port)))
        before[key] = frame;
    for (const auto& [key, wanted] : split_frames(port.frames)) {
      const std::string expected = is_frame_variable(wanted) ? before[key] : wanted;
      if (given[key].empty() || is_frame_variable(given[key]) || expected.empty() || is_frame_variable(expected) ||
          given[key] == expected)
        continue;
      problem(carry->next.at, "input '" + port_name + "' of '" + node.name + "' takes " + key + " '" + expected +
                                  "' in the first round, '" + next + "' gives " + key + " '" + given[key] +
                                  "' to the next");
    }
  }
}

}  // namespace plumbline::runtime

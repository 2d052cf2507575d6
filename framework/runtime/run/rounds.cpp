#include "runtime/run/rounds.hpp"

#include <fmt/core.h>

#include <algorithm>

namespace plumbline::runtime {

namespace {

std::string number_text(double value) { return fmt::format("{:.9g}", value); }

bool compare(double value, const std::string& comparison, double limit) {
  if (comparison == ">") return value > limit;
  if (comparison == ">=") return value >= limit;
  if (comparison == "<") return value < limit;
  if (comparison == "<=") return value <= limit;
  return value == limit;
}

void append(std::vector<std::string>& all, const std::vector<std::string>& more) {
  all.insert(all.end(), more.begin(), more.end());
}

}  // namespace

RoundsCourse::RoundsCourse(const Graph& graph)
    : graph_(graph),
      changes_(changes_by_round(graph)),
      needed_(needed_by_rounds(graph, graph.rounds)),
      outputs_(graph.nodes.size()),
      metrics_(graph.nodes.size()),
      there_(graph.nodes.size(), false) {}

/// The nodes that are `in`; what they take from others is given as blobs.
RoundsCourse::Stage RoundsCourse::stage(const std::vector<bool>& in, size_t round,
                                        const std::map<std::string, Hashes>& carried) const {
  Stage result;
  result.graph.file = graph_.file;
  result.graph.variables = graph_.variables;
  result.graph.seed = graph_.seed;
  result.graph.sources = graph_.sources;
  result.graph.overrides = graph_.overrides;
  std::vector<size_t> place(graph_.nodes.size());
  for (size_t i = 0; i < graph_.nodes.size(); ++i) {
    if (!in[i]) continue;
    GraphNode node = graph_.nodes[i];
    node.round = changes_[i] ? round : 0;
    std::multimap<std::string, Source> inputs;
    for (auto& [port, source] : node.inputs) {
      if (round > 1 && node.carried.count(port)) continue;
      if (in[source.node])
        inputs.emplace(port, Source{place[source.node], source.port, source.at});
      else
        append(node.given[port], outputs_[source.node].at(source.port));
    }
    node.inputs = std::move(inputs);
    if (round > 1)
      for (const auto& [port, name] : node.carried) node.given[port] = carried.at(name);
    for (const auto& [port, name] : node.collected) node.given[port] = collected_.at(name);
    place[i] = result.graph.nodes.size();
    result.graph.nodes.push_back(std::move(node));
    result.nodes.push_back(i);
  }
  return result;
}

RoundsCourse::Stage RoundsCourse::round() const {
  std::vector<bool> in = needed_;
  if (round_ > 1)
    for (size_t i = 0; i < in.size(); ++i) in[i] = in[i] && changes_[i];
  return stage(in, round_, carried_);
}

void RoundsCourse::put(size_t node, const std::map<std::string, Hashes>& outputs, const std::vector<Metric>& metrics,
                       bool drew_seed) {
  outputs_[node] = outputs;
  metrics_[node] = metrics;
  there_[node] = true;
  drew_seed_ |= drew_seed && changes_[node];
}

/// What the condition says of the round, with the value.
std::string RoundsCourse::condition_text(bool& holds) const {
  const Condition& until = *graph_.rounds.until;
  std::string values, names;
  holds = true;
  for (const Metric& metric : metrics_[until.node]) {
    names += (names.empty() ? "" : ", ") + metric.name;
    if (metric.name != until.metric) continue;
    holds = holds && compare(metric.value, until.comparison, until.limit);
    values += (values.empty() ? "" : ", ") + number_text(metric.value);
  }
  if (values.empty())
    throw std::runtime_error("'" + graph_.nodes[until.node].name + "' gave no metric '" + until.metric + "' in round " +
                             std::to_string(round_) + (names.empty() ? "; it gave none" : "; it gave " + names));
  return until.text + (holds ? " holds" : " does not hold") + " (" + values + ")";
}

RoundsEnd RoundsCourse::judge() {
  const Rounds& rounds = graph_.rounds;
  RoundsEnd end;
  end.rounds = last_ = round_;
  std::map<std::string, Hashes> next;
  for (const Carry& carry : rounds.carry) {
    const Hashes& given = outputs_[carry.next.node].at(carry.next.port);
    next[carry.name] = given;
    collected_[carry.name].insert(collected_[carry.name].end(), given.begin(), given.end());
  }
  try {
    if (rounds.until) end.text = condition_text(end.finished);
  } catch (const std::exception& error) {
    end.problem = error.what();
    end.over = true;
    return end;
  }
  const bool still = round_ > 1 && next == carried_ && !drew_seed_;
  if (!rounds.until) {
    end.finished = still;
    end.text = still ? "what is carried is what the round before gave" : "what is carried has changed";
  } else if (still && !end.finished) {
    end.text += ", and no later round can change that: what is carried is what the round before gave";
  }
  end.over = end.finished || still || round_ >= rounds.most;
  // Without a condition the bound is the wish.
  if (!rounds.until && round_ >= rounds.most) end.finished = true;
  taken_ = std::move(carried_);
  carried_ = std::move(next);
  if (!end.over) ++round_;
  return end;
}

RoundsCourse::Stage RoundsCourse::rest(bool known, std::vector<size_t>& unknown) const {
  std::vector<bool> in(graph_.nodes.size(), false), missing(graph_.nodes.size(), false);
  for (size_t i = 0; i < in.size(); ++i) {
    const bool in_rounds = needed_[i];
    missing[i] = in_rounds ? !there_[i] : !known && changes_[i];
    for (const auto& [port, source] : graph_.nodes[i].inputs)
      if (!(known && last_ > 1 && graph_.nodes[i].carried.count(port))) missing[i] = missing[i] || missing[source.node];
    if (in_rounds) continue;
    in[i] = !missing[i];
    if (missing[i]) unknown.push_back(i);
  }
  return stage(in, last_, taken_);
}

}  // namespace plumbline::runtime

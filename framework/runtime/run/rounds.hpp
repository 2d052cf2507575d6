// Graphs with rounds: what one round gives the next one takes, until a metric says that it is enough or a bound is met.
//
//   rounds:
//     carry: {state: {first: start.points, next: update.state}}   # or state: update.state, with nothing in round 1
//     until: update.changed = 0                                   # none: until nothing changes any more
//     most: 20
//   nodes:
//     update: {use: …, in: {state: rounds.state}}
//     report: {use: …, in: {states: rounds.all.state}}            # after the last round: what each of them gave
//
// A graph stays one without circles: a round is an ordinary graph whose carried inputs are blobs of the round before.
// The first round has all nodes that the rounds need; a later one those of them that depend on the round before; after
// the last come the others, once. Results are named by content, so rounds that were computed are reused, and a loop
// that was killed goes on where it was. A node that draws its seed draws another one in each round after the first.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "runtime/graph/graph.hpp"
#include "runtime/run/executor.hpp"

namespace plumbline::runtime {

/// The way of a graph through its rounds: which graph comes next, given what the ones before gave.
class RoundsCourse {
 public:
  explicit RoundsCourse(const Graph& graph);

  struct Stage {
    Graph graph;                ///< an ordinary one; its nodes say their round
    std::vector<size_t> nodes;  ///< their places in the whole graph
  };

  /// The graph of the round that is due.
  Stage round() const;
  size_t number() const { return round_; }

  /// What a node of the whole graph gave. `drew_seed`: another round may give something else for the same inputs.
  void put(size_t node, const std::map<std::string, Hashes>& outputs, const std::vector<Metric>& metrics,
           bool drew_seed);

  /// Judges the round that was put; number() is that of the next if there is one.
  RoundsEnd judge();

  /// What comes after the last round. After a round that failed or is not known, `known` is false and only what does
  /// not depend on it is in it; `unknown` are the others.
  Stage rest(bool known, std::vector<size_t>& unknown) const;

 private:
  Stage stage(const std::vector<bool>& in, size_t round, const std::map<std::string, Hashes>& carried) const;
  std::string condition_text(bool& holds) const;

  const Graph& graph_;
  const std::vector<bool> changes_, needed_;
  size_t round_ = 1, last_ = 1;
  std::vector<std::map<std::string, Hashes>> outputs_;
  std::vector<std::vector<Metric>> metrics_;
  std::vector<bool> there_;
  std::map<std::string, Hashes> carried_;    // into the round that is due
  std::map<std::string, Hashes> taken_;      // into the round that was judged
  std::map<std::string, Hashes> collected_;  // of all rounds
  bool drew_seed_ = false;
};

}  // namespace plumbline::runtime

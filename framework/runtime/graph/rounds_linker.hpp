// The part of linking that belongs to `rounds:`, see rounds.hpp.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "runtime/graph/graph.hpp"
#include "runtime/graph/pipeline_file.hpp"

namespace plumbline::runtime {

class RoundsLinker {
 public:
  /// `find_source` looks up a "node.port" and tells what is wrong with it.
  RoundsLinker(const RoundsSpec& spec, std::vector<Problem>& problems) : spec_(spec), problems_(problems) {}

  /// True if the text is "rounds.…" and this pipeline has rounds.
  bool is_meant(const std::string& text) const { return spec_.given && text.rfind("rounds.", 0) == 0; }

  /// Looks up what `carry` names. `nodes` are all nodes, by their place in the pipeline.
  void find_carries(const std::function<bool(const Scalar&, Source&)>& find_source);

  /// What "rounds.state" or "rounds.all.state" stands for: notes it in the node. Returns the sources whose types must
  /// fit; the first of them, if `first_is_input` becomes true, is the node's input in the first round.
  std::vector<Source> connect(GraphNode& node, const plumbline_port& port, const Scalar& text, bool& first_is_input);

  /// With the graph in its final order, `position` of each node of the pipeline in it.
  Rounds finish(const Graph& graph, const std::vector<size_t>& position);

 private:
  struct Found {
    Carry carry;
    bool good = false, used = false;
  };
  void problem(const Position& at, const std::string& message) { problems_.push_back({at, message}); }
  std::optional<Condition> condition(const Graph& graph);
  void check_ports(const Graph& graph, const GraphNode& node, const Rounds& rounds);
  void check_joins(const Graph& graph, const std::vector<bool>& changes, const std::vector<bool>& needed);

  const RoundsSpec& spec_;
  std::vector<Problem>& problems_;
  std::vector<Found> found_;
};

}  // namespace plumbline::runtime

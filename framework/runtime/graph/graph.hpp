// A pipeline, read from YAML and linked: every node's kind found, its parameters checked against the declaration and
// written in canonical form, its ports connected, types and frames unified. All errors of a file come at once, each
// with its position.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "runtime/base/quantities.hpp"
#include "runtime/plugins/registry.hpp"

namespace plumbline::runtime {

struct Position {
  std::string file;
  int line = 0;              ///< from 1; 0: not from a file (an override on the command line)
  int column = 0;            ///< from 1
  std::string text() const;  ///< "file:line:column"
};

struct Problem {
  Position at;
  std::string message;
  /// Parameters beside the one of `message` that took the same value from the same place and refuse it likewise.
  size_t alike = 0;
  std::string refusal = {};  ///< what of `message` they have in common

  std::string text() const;  ///< `message`, and how many are alike
};

/// Thrown by load_pipeline() with everything that is wrong; what() has one line a problem.
class InvalidPipeline : public std::runtime_error {
 public:
  explicit InvalidPipeline(std::vector<Problem> problems);
  const std::vector<Problem>& problems() const { return problems_; }

 private:
  std::vector<Problem> problems_;
};

/// One end of a connection: output `port` of the node with index `node` in Graph::nodes.
struct Source {
  size_t node = 0;
  std::string port;
  Position at;
};

struct GraphNode {
  std::string name;  ///< as in the pipeline
  Kind kind;
  std::multimap<std::string, Source> inputs;         ///< by input port; several of a list, in the pipeline's order
  std::map<std::string, std::string> connections;    ///< the same as written: "node.port", "rounds.state"
  std::map<std::string, std::string> parameters;     ///< canonical text of every parameter, defaults included
  std::map<std::string, std::string> output_frames;  ///< by output port: "frame=building"; unbound variables stay "?S"
  /// True if the node runs once for each item of its EACH input; `each_port` names that port.
  bool maps = false;
  std::string each_port;
  /// By output port: one item, or a list (a LIST output, or any output of a node that maps).
  std::map<std::string, bool> output_is_list;
  bool isolate = false;  ///< it wants a process of its own (workers.hpp); limits imply it
  Limits limits;         ///< of each run
  Position at;
  // Of a pipeline with rounds (rounds.hpp):
  std::map<std::string, std::string> carried;    ///< by input port: what of the round before it takes
  std::map<std::string, std::string> collected;  ///< by input port: what of all rounds it takes
  size_t round = 0;                              ///< the one it runs in; 0: none, or it is the same in all of them
  std::map<std::string, std::vector<std::string>> given;  ///< by input port: blobs that no node of this graph gives
};

/// The name in records and messages: with the round, if it is not the first.
std::string label_of(const GraphNode& node);
std::string label_of(const std::string& name, size_t round);

/// An output that becomes an input of the next round.
struct Carry {
  std::string name;
  std::optional<Source> first;  ///< what the first round takes in its place; none: an input that is not connected
  Source next;
};

/// A metric of a node, held against a number.
struct Condition {
  size_t node = 0;
  std::string metric;
  std::string comparison = ">";  ///< or >=, <, <=, =
  double limit = 0;
  std::string text;  ///< as written
};

/// `rounds:` of a pipeline.
struct Rounds {
  std::vector<Carry> carry;
  std::optional<Condition> until;  ///< none: until what is carried does not change any more
  size_t most = 0;                 ///< 0: the pipeline has no rounds
};

struct GraphOutput {
  std::string file;  ///< name under the output folder
  Source from;
};

/// A file that a pipeline was read from.
struct SourceFile {
  std::string path, text;
};

struct Graph {
  std::string file;                  ///< the pipeline's path as given
  std::vector<GraphNode> nodes;      ///< in topological order, ties in the file's order
  std::vector<GraphOutput> outputs;  ///< in the file's order
  Rounds rounds;
  std::map<std::string, std::string> variables;
  uint64_t seed = 0;                   ///< the run's seed: the variable `seed`, 0 if there is none
  std::vector<SourceFile> sources;     ///< the file itself, then what it includes: for the record
  std::vector<std::string> overrides;  ///< as given, in order
};

/// By node: whether it takes, itself or through others, what is carried by rounds.
std::vector<bool> changes_by_round(const Graph& graph);
/// By node: whether it leads to what is carried or to the condition.
std::vector<bool> needed_by_rounds(const Graph& graph, const Rounds& rounds);

/// `overrides` are the KEY=VALUE arguments in order: `floors=3` sets a variable, `poses.with.solver=epnp` a parameter,
/// `poses.use=pose.opencv` a kind. Relative paths in parameters: those written in the pipeline file are relative to its
/// folder, those given on the command line to the working directory. What `include:` names is looked for beside the
/// file and then in `include_folders`. Throws InvalidPipeline.
Graph load_pipeline(const std::filesystem::path& file, const std::vector<std::string>& overrides,
                    const Registry& registry, const std::vector<std::filesystem::path>& include_folders = {});

/// The graph as Graphviz DOT or as a Mermaid flowchart, left to right.
std::string to_dot(const Graph& graph);
std::string to_mermaid(const Graph& graph);

}  // namespace plumbline::runtime

// From a bench file to its cells: every combination of scenario, variables, alternatives and seed that is not excluded.
//
// A cell is identified by what it computes, not by what it is called: its key is the hash of the recipe of every node
// that leads to a measured metric (kind, version, binary, parameters, recipes of its inputs) and of the seed. So the
// order of alternatives, the number of tries, the host and the time never enter, and two bench files share a cell.
// Cells of one trial (same scenario, variables and seed) become one graph in which equal recipes are one node.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "runtime/store/file_hashes.hpp"
#include "runtime/sweep/sweep_file.hpp"

namespace plumbline::runtime {

/// A linked pipeline, reduced to the nodes that lead to what is measured.
struct CellGraph {
  Graph graph;
  std::vector<std::string> recipes;  ///< by node; the seed is not in them
  std::vector<bool> essential;       ///< by node: leads to the error that is measured; the others may fail
};

struct SweepCell {
  std::string scenario;
  std::map<std::string, std::string> values;   ///< of the matrix, by variable
  std::map<std::string, std::string> choices;  ///< name of the alternative, by group
  uint64_t seed = 0;
  size_t trial = 0;                        ///< cells of one trial share it
  std::string key;                         ///< under which the store keeps the result
  std::shared_ptr<const CellGraph> graph;  ///< null if the cell cannot run
  std::string problem;                     ///< why not
  std::string label() const;               ///< "full height, network=parallel, adjuster=adjust.ceres, seed 3"
};

struct ExcludedCells {
  std::string what, why;
  size_t cells = 0;
};

struct SweepPlan {
  SweepFile file;
  Overrides overrides;           ///< of the command line, for every cell
  std::vector<SweepCell> cells;  ///< trial by trial, alternatives by turns: times are interleaved
  size_t trials = 0;
  std::vector<ExcludedCells> excluded;
  std::map<std::string, std::vector<std::string>> swapped;  ///< by group: nodes that its alternatives change
  std::set<std::string> judged;  ///< nodes of which the bench itself computes what their role says (sweep_measures.hpp)
  std::string id;                ///< of all keys: equal plans have equal ids
};

/// `overrides` hold for every cell. A combination that makes no valid pipeline becomes cells with a problem, so that it
/// is shown. What is wrong in every combination it stands in is a slip of the pen, and what command line, seeds,
/// scenario, matrix and alternative set to different values would hold under a name that is not its own: throws
/// InvalidPipeline with its place.
SweepPlan plan_sweep(const SweepFile& file, const Overrides& overrides, const Registry& registry, FileHashes& hashes);

/// All graphs of its cells, each once.
std::vector<const Graph*> graphs_of(const SweepPlan& plan);

/// Several cells as one graph. `nodes[c]` are the indices, in the merged graph, of the nodes of the c-th of them.
struct MergedGraph {
  Graph graph;
  std::vector<std::vector<size_t>> nodes;
  std::vector<const SweepCell*> cells;
};
MergedGraph merge_cells(const std::vector<const SweepCell*>& cells);

/// Cells of whole trials in chunks of about `size`, for executors that want tasks of some length.
std::vector<std::vector<size_t>> chunks_of(const SweepPlan& plan, size_t size);

}  // namespace plumbline::runtime

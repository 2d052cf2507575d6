// A linked pipeline as a cell of a bench sees it: cut to what is measured, and told apart by recipes.
#pragma once

#include <set>
#include <string>
#include <vector>

#include "runtime/graph/graph.hpp"
#include "runtime/store/file_hashes.hpp"
#include "runtime/sweep/sweep_file.hpp"

namespace plumbline::runtime {

/// Names of the nodes that a metric is asked of.
std::set<std::string> measured_nodes(const SweepFile& file);

/// By node: whether it is one of those names, or they take from it, or the rounds need it.
std::vector<bool> leading_to(const Graph& graph, const std::set<std::string>& wanted);

/// The graph without the nodes that lead to none of those names, and without outputs.
Graph reduced(const Graph& graph, const std::set<std::string>& wanted);

/// By node: the hash of its kind, version, binary, parameters, name and of the recipes of its inputs. A node draws its
/// seed by its name, so that belongs to what it computes; the seed itself does not.
std::vector<std::string> recipes_of(const Graph& graph, FileHashes& hashes);

/// Whether a value of the pipeline, of what it includes or of the overrides may hold ${seed}. In doubt it does.
bool names_seed(const Graph& graph);

}  // namespace plumbline::runtime

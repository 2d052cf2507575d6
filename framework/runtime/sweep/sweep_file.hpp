// A bench file: one pipeline, what varies, and what is measured. docs/benchmarking.md has the format.
//
//   bench: 1
//   title: Which adjuster
//   pipeline: ../pipelines/observations.yaml
//   measure: {error: errors.rmse_z}
//   rope: 0.05 mm
//   seeds: 1-200
//   scenarios: {one floor: {floors: 1}, full height: {floors: 5}}
//   matrix: {network: [convergent, parallel]}
//   alternatives:
//     adjuster: [adjust.ceres, adjust.schur]
//     method: {constrained: {}, registered: {pipeline: free.yaml, registration.with.scale: fixed}}
//   stop: {when: decided, after: [20, 60, 200]}  # looks at so many seeds; each has its share of the error probability
//   weights: {one floor: 1, full height: 3}      # or `equal`; without them nothing is said over all places together
//   exclude: [{scenario: full height, adjuster: adjust.slow, why: takes a day}]
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "runtime/graph/graph.hpp"

namespace plumbline::runtime {

using Overrides = std::vector<std::string>;  ///< "KEY=VALUE", as on the command line

/// One thing that can stand in a place.
struct SweepAlternative {
  std::string name;
  std::filesystem::path pipeline;  ///< empty: the file's
  std::string kind;                ///< of a list of kinds; then `overrides` is empty
  Overrides overrides;
  Position at;
};

/// A place that is filled in several ways: a node, a role of the pipeline, or a name for a whole set of changes.
struct SweepGroup {
  std::string name;
  std::vector<SweepAlternative> alternatives;  ///< in the file's order, which decides nothing but that of the tables
};

struct SweepScenario {
  std::string name;
  Overrides overrides;
  std::filesystem::path pipeline = {};  ///< empty: the file's
  Position at = {};
};

struct SweepVariable {
  std::string name;
  std::vector<std::string> values;
};

struct SweepExclusion {
  std::map<std::string, std::string> where;  ///< scenario, variable or group -> value
  std::string why;
};

struct SweepFile {
  std::filesystem::path path;
  std::string title;
  std::filesystem::path pipeline;
  std::map<std::string, std::string> measure;  ///< quantity -> NODE.METRIC
  double rope = 0;                             ///< [m]; 0: none given
  std::vector<double> tolerances;              ///< [m]
  std::vector<uint64_t> seeds;                 ///< empty: one trial with the pipeline's own seed
  Position seeds_at;
  std::vector<size_t> looks;              ///< numbers of seeds after which a bench may stop, rising; empty: none
  bool weighted = false;                  ///< weights are stated, so that a mean over places has a meaning
  std::map<std::string, double> weights;  ///< of scenarios; empty although weighted: all places alike
  std::vector<SweepScenario> scenarios;   ///< at least one; a file without any has one of empty name
  std::vector<SweepVariable> matrix;
  std::vector<SweepGroup> groups;
  std::vector<SweepExclusion> exclude;
  std::map<std::string, Position> places;  ///< where "KEY=VALUE" of a scenario, variable or alternative stands
  bool keep_everything = true;             ///< false: only results go to the store, what nodes hand on is thrown away
  std::string text;
};

/// Reads a bench file; `all` in place of a list of alternatives stands for every kind of the role that the registry
/// has. A pipeline is a path from the file's folder, or the name of one in `folders`. Throws InvalidPipeline with all
/// that is wrong.
SweepFile read_sweep(const std::filesystem::path& file, const Registry& registry,
                     const std::vector<std::filesystem::path>& folders = {});

/// "0.05 mm", "1 cm", "2e-3 m" in metres; nothing if it is no length.
std::optional<double> length_of(const std::string& text);

/// "7", "1-200" or a list of such, without repetition. Nothing if it is none.
std::optional<std::vector<uint64_t>> seeds_of(const std::vector<std::string>& texts);

}  // namespace plumbline::runtime

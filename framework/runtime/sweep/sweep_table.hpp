// Everything a sweep has found so far, as one JSON text: what the node bench.summary reads.
#pragma once

#include <string>

#include "runtime/sweep/sweep_plan.hpp"
#include "runtime/sweep/sweep_records.hpp"

namespace plumbline::runtime {

struct BuildFacts {
  std::string version, commit, compiler;
  std::vector<std::string> libraries;  ///< files of shared libraries that it has loaded, with their versions
};

/// Files of shared libraries that cells compute with, sorted: those of the program, of the plugins whose nodes cells
/// run in workers of their own, and of nodes in other languages the program that runs them ("python3.11").
std::vector<std::string> libraries_of(const SweepPlan& plan, const BuildFacts& build);

/// Why a cell counts as failed: its record's error, that it has no finite value of the error that the file measures, or
/// that `plumbline run` would end with exit code 3, not to be used: a node that leads to the error says `invalid`, or
/// the rounds came to no end. Empty if it counts.
std::string failure_of(const SweepCell& cell, const CellRecord& record, const SweepFile& file);

/// {"title", "file", "overrides", "measure", "rope", "tolerances", "scenarios", "variables", "groups", "excluded",
/// "machine", "cells"}: see docs/benchmarking.md. Cells that have not run yet are there with the status "missing".
/// `build`: what the program says of itself ("version", "commit", "compiler", …); goes to "machine".
/// Cells of other than the first `first_seeds` seeds count as missing; those of them that have run are counted as
/// "behind". 0: all seeds, or where the file has looks those of the last look that is complete (of the first, if none
/// is).
std::string sweep_table(const SweepPlan& plan, const CellRecords& records, const Registry& registry,
                        const BuildFacts& build, size_t first_seeds = 0);

/// The pipelines that cells run and all that they include, once each, in the order of the cells.
std::vector<SourceFile> sources_of(const SweepPlan& plan);

}  // namespace plumbline::runtime

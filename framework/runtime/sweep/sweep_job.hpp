// Some cells of a plan as one merged graph, run in the process that asks.
#pragma once

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "runtime/sweep/sweep_plan.hpp"
#include "runtime/sweep/sweep_records.hpp"

namespace plumbline::runtime {

/// Cells that run as one graph.
struct SweepJob {
  std::vector<size_t> cells;
  std::string run = {};  ///< names the call of the program that runs them
};

/// What a worker says of a job; plain bytes.
struct SweepAnswer {
  size_t nodes = 0, merged = 0, executed = 0, failed = 0;
  bool cancelled = false, store_failed = false;
  bool plugins_changed = false;  ///< of cells that failed: see changed_plugins()
};

std::string this_host();

/// Files of the plugins behind a graph's nodes that are not those any more that were looked at: edited, gone, or linked
/// anew to other bytes. Ascending.
std::vector<std::string> changed_plugins(const Graph& graph);

/// Runs one job and leaves its records in the store, but for failures while a plugin changed: those say nothing of the
/// cells. `scratch` takes what nodes hand on where the plan keeps only
/// results. `memory`: bytes that nodes may announce together.
SweepAnswer run_sweep_job(const SweepPlan& plan, const SweepJob& job, const Registry& registry, Store& store,
                          const std::filesystem::path& scratch, int threads, uint64_t memory,
                          const std::atomic<bool>* cancel);

}  // namespace plumbline::runtime

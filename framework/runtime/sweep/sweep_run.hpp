// Runs the cells of a plan on this machine: trials side by side in worker processes, each trial one merged graph.
//
// Workers are forked before any thread is started, so they share what is loaded. A crash of a node is a failed cell:
// the worker that died is replaced, the cells of its trial run one by one, and the one that kills its worker again is
// recorded with the signal. What is in the store already is not run.
#pragma once

#include <atomic>
#include <functional>
#include <string>
#include <vector>

#include "runtime/run/executor.hpp"
#include "runtime/sweep/sweep_plan.hpp"
#include "runtime/sweep/sweep_records.hpp"

namespace plumbline::runtime {

struct SweepRunOptions {
  int workers = 0;      ///< 0: one a processor
  uint64_t memory = 0;  ///< bytes that nodes may announce together; 0: MemoryBudget::default_limit()
  double limit = 0;     ///< seconds a cell may take; 0: as long as it likes
  bool retry = false;   ///< runs cells again whose record says that they failed
  const std::atomic<bool>* cancel = nullptr;
};

struct SweepProgress {
  size_t cells = 0;         ///< asked for
  size_t found = 0;         ///< of those, in the store when it began
  size_t done = 0;          ///< with a record now
  size_t failed = 0;        ///< of those, failed
  size_t nodes = 0;         ///< runs of nodes that the cells that were not in the store would take one by one
  size_t merged_nodes = 0;  ///< of those, different ones
  size_t executed = 0;      ///< of those, that really ran; the others were in the store
  bool cancelled = false;
};

/// `indices` of plan.cells, whole trials together. `tell` is called whenever something is done. Throws StoreError if
/// results cannot be kept.
SweepProgress run_cells(const SweepPlan& plan, const std::vector<size_t>& indices, const Registry& registry,
                        Store& store, const SweepRunOptions& options,
                        const std::function<void(const SweepProgress&)>& tell);

/// All indices, for run_cells().
std::vector<size_t> all_cells(const SweepPlan& plan);

}  // namespace plumbline::runtime

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
};

/// What a worker says of a job; plain bytes.
struct SweepAnswer {
  size_t nodes = 0, merged = 0, executed = 0, failed = 0;
  bool cancelled = false, store_failed = false;
};

std::string this_host();

/// Runs one job and leaves its records in the store; `scratch` takes what nodes hand on where the plan keeps only
/// results. `memory`: bytes that nodes may announce together.
SweepAnswer run_sweep_job(const SweepPlan& plan, const SweepJob& job, const Registry& registry, Store& store,
                          const std::filesystem::path& scratch, int threads, uint64_t memory,
                          const std::atomic<bool>* cancel);

}  // namespace plumbline::runtime

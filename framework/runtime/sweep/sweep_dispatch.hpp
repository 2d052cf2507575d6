// Sends the cells of a plan to other machines. A task is one more call of this program on the same bench file and the
// same store, told which chunk of the plan is its own; it finds out by itself what of it is left to do, so that a task
// may run twice, on a machine with a wrong clock, or never. Nothing is ever asked of the scheduler after submission.
#pragma once

#include <string>
#include <vector>

#include "runtime/sweep/sweep_plan.hpp"
#include "runtime/sweep/sweep_records.hpp"

namespace plumbline::runtime {

struct DispatchOptions {
  std::string executor;  ///< "slurm", "ssh" or "print"
  size_t cells_per_task = 50;
  std::vector<std::string> hosts;    ///< for ssh
  std::string scheduler_options;     ///< for sbatch, such as "--partition=long --time=2:00:00"
  bool retry = false;                ///< cells whose record says failed count as left to do
  std::vector<std::string> command;  ///< what a task runs, without its number
};

struct Dispatched {
  size_t tasks = 0, cells = 0;  ///< sent
  std::string text;             ///< what to tell the user
  int exit_code = 0;            ///< of the program that was called
};

/// Numbers of the chunks in which something is left to do.
std::vector<size_t> open_tasks(const SweepPlan& plan, const std::vector<std::vector<size_t>>& chunks,
                               const CellRecords& records, bool retry);

/// "0,3,7-9"
std::string array_text(const std::vector<size_t>& numbers);

/// Quoted for a shell where it must be.
std::string shell_text(const std::vector<std::string>& words);

/// The size of a chunk that keeps a plan within a scheduler's usual limit of 1000 tasks an array.
size_t task_size(const SweepPlan& plan, size_t wished);

/// Writes the task script beside the records, in the store's sweeps/<plan id>/, and calls sbatch once, or parallel; or
/// returns the commands as text. Throws std::runtime_error if the program that is needed is missing or refuses.
Dispatched dispatch(const SweepPlan& plan, Store& store, const DispatchOptions& options);

}  // namespace plumbline::runtime

// plumbline bench: runs what a bench file asks for and compares.
#pragma once

#include <string>
#include <vector>

#include "commands.hpp"

namespace plumbline::cli {

struct BenchOptions {
  std::string file;
  std::vector<std::string> overrides;
  std::string out;    ///< empty: out/<bench file>
  std::string store;  ///< empty: Store::default_folder()
  std::string memory;
  std::string executor = "local";
  std::string hosts;                   ///< comma-separated, for ssh
  std::string scheduler_options;       ///< for sbatch
  std::vector<std::string> seeds;      ///< in place of the file's
  std::vector<std::string> scenarios;  ///< of the file, by name; empty: all
  int workers = 0, task = -1, cells_per_task = 50;
  double limit = 0;
  bool status = false, retry = false, overwrite = false, json = false, quiet = false;
  std::string archive;  ///< folder to write; empty: none
  int cells = 20;       ///< that `verify` makes again; 0: all
  std::string plan;     ///< of a task: the plan it was sent for
};

/// 0: every cell has a result; 1: some failed or are missing; 130: cancelled.
int bench(const BenchOptions& options);

}  // namespace plumbline::cli

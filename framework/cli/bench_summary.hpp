// The pages and tables of a bench, made by the node bench.summary from the table of its cells.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "bench.hpp"
#include "runtime/graph/graph.hpp"
#include "runtime/plugins/registry.hpp"
#include "runtime/record/output_folder.hpp"
#include "runtime/store/store.hpp"
#include "runtime/sweep/sweep_run.hpp"
#include "runtime/sweep/sweep_table.hpp"

namespace plumbline::cli {

/// What the tables and archives of a bench say of this program.
runtime::BuildFacts build_facts();

/// Puts bench.html and the tables in the output folder. The folder is opened before anything runs, so that what stands
/// in the way of the results is said at once.
class SummaryWriter {
 public:
  /// Throws UsageError if outputs would replace what this program did not write. The references must live as long.
  SummaryWriter(const std::filesystem::path& out, const runtime::SweepPlan& plan, const runtime::Registry& registry,
                runtime::Store& store, const BenchOptions& options);

  /// Of the last write(): whether something was compared, and all of it is decided.
  bool all_decided() const { return open_ == 0; }

  /// Of the last write(): measures that no cell has a value of, mostly misspelt.
  const std::vector<std::string>& warnings() const { return warnings_; }

  /// Of the first `first_seeds` seeds; 0: of all, or of the last look that is complete. False if something could not be
  /// written.
  bool write(size_t first_seeds = 0);

 private:
  const runtime::SweepPlan& plan_;
  const runtime::Registry& registry_;
  runtime::Store& store_;
  const BenchOptions& options_;
  const std::filesystem::path cells_;
  const runtime::Graph graph_;
  runtime::OutputFolder folder_;
  double open_ = 1;
  std::vector<std::string> warnings_;
};

}  // namespace plumbline::cli

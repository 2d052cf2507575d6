// plumbline bench verify ARCHIVE: makes cells of an archived bench again and compares.
#pragma once

#include <string>
#include <vector>

#include "bench.hpp"
#include "runtime/sweep/sweep_file.hpp"

namespace plumbline::cli {

/// Keeps those scenarios of the file, in its order, and what speaks of them.
void keep_only(runtime::SweepFile& file, const std::vector<std::string>& wanted);

/// 0: all that were made again agree; 1: some differ; 130: cancelled. The first of `options.overrides` is the archive,
/// the others hold in place of its own: where inputs and programs lie here. `options.cells` of the cells, spread over
/// the bench; 0: all.
int verify_bench(const BenchOptions& options);

}  // namespace plumbline::cli

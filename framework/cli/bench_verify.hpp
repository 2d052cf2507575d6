// plumbline bench verify ARCHIVE: makes cells of an archived bench again and compares.
#pragma once

#include "bench.hpp"

namespace plumbline::cli {

/// 0: all that were made again agree; 1: some differ; 130: cancelled. `options.cells` of them, spread over the bench;
/// 0: all.
int verify_bench(const std::string& archive, const BenchOptions& options);

}  // namespace plumbline::cli

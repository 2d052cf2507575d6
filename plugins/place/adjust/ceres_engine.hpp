// Ceres as the engine of an adjuster. Who includes this links plumbline_block_ceres, and with it Debian's Ceres, whose
// SuiteSparse is under the GPL.
#pragma once

#include "photo/bundle/adjust.hpp"
#include "plumbline/node.hpp"

namespace plumbline::block {

struct CeresEngine {
  static constexpr bool refines_robust = false;  // its answer is Ceres', not ours
  static constexpr Info info{"adjust.ceres", "adjuster", 5,
                             "Bundle adjustment with Ceres (DENSE_SCHUR), free (4) or with control (5)"};
  static bundle::MinimiseSummary minimise(const bundle::Problem& problem, bundle::State& state,
                                          const bundle::MinimiseOptions& options) {
    return bundle::minimise_ceres(problem, state, options);
  }
};

}  // namespace plumbline::block

// What every adjuster of marker plates says of the global tests of its block.
#pragma once

#include "photo/block/tag_block.hpp"
#include "plumbline/node.hpp"

namespace plumbline::block {

/// Warns of each test that failed. A block that fails one of its observations is no result: the metric `invalid` makes
/// the exit code 3, so that no script builds on it.
inline void tell_global_tests(Context& context, const TagBlockResult& result) {
  bool failed = false;
  for (const auto& test : result.tests) {
    if (test.passed) continue;
    failed = true;
    context.warn((test.group == "control points" ? "test of the single control points failed: "
                                                 : "global test of the image block failed: ") +
                 test.words);
  }
  for (const auto& test : result.models)
    if (!test.passed) context.warn("the camera model does not hold: " + test.words);
  context.metric("invalid", failed ? 1 : 0, "1");
}

}  // namespace plumbline::block

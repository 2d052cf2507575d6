// Whose answer a node gives: adjust.ceres asks Ceres for every minimum, adjust.schur refines the robust one itself.
#include <gtest/gtest.h>

#include <vector>

#include "adjuster_node.hpp"
#include "ceres_engine.hpp"
#include "synthetic_block.hpp"

namespace test_engine {

using namespace plumbline;
using namespace plumbline::block;

/// What an engine was asked for, and where it was sent from.
struct Call {
  bundle::Loss::Kind loss;
  Eigen::Vector3d from, to;  ///< the first plate
};

/// The engine's calls in an adjustment as its node would make it.
template <typename Engine>
std::vector<Call> calls_of() {
  const auto synthetic = test::make_block({.floors = 1});
  std::vector<Call> calls;
  TagBlockOptions options;
  choose_engine<Engine>(options);
  const bundle::Minimiser engine = options.minimiser;
  options.minimiser = [&](const bundle::Problem& problem, bundle::State& state, const bundle::MinimiseOptions& how) {
    Call call{how.loss.kind, state.plates.front().position, {}};
    const bundle::MinimiseSummary summary = engine(problem, state, how);
    call.to = state.plates.front().position;
    calls.push_back(call);
    return summary;
  };
  adjust_tag_block(synthetic.block, options);
  return calls;
}

TEST(Engines, CeresIsAskedForTheLeastSquaresAndBeginsWhereItsRobustAdjustmentEnded) {
  const auto calls = calls_of<CeresEngine>();
  std::size_t robust = 0;
  while (robust < calls.size() && calls[robust].loss != bundle::Loss::Kind::none) ++robust;
  ASSERT_GT(robust, 0u);
  ASSERT_LT(robust, calls.size()) << "the least squares are somebody else's";
  EXPECT_EQ(calls[robust].from, calls[robust - 1].to) << "somebody else went first";
}

TEST(Engines, OurOwnRefinesItsRobustAdjustmentByItself) {
  for (const Call& call : calls_of<SchurEngine>()) EXPECT_NE(call.loss, bundle::Loss::Kind::none);
}

}  // namespace test_engine

// What a larger model would explain (score.hpp), against a dense fit of all its derivatives.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "bundle_scene.hpp"
#include "photo/bundle/adjust.hpp"
#include "photo/bundle/score.hpp"

namespace test_bundle_score {

using namespace plumbline;
using namespace plumbline::bundle;

/// By a dense least-squares fit of all derivatives, of a larger model, to the residuals.
void expect_score_of_dense(const Scene& scene, const State& minimum, const Elimination& factors, Kind kind) {
  Scene larger = {scene.problem, minimum};
  if (kind == Kind::camera)
    for (auto& camera : larger.problem.cameras) camera.free[4] = camera.free[5] = true;
  for (int i = 0; i < 6 && kind == Kind::shift; ++i) {
    auto& image = larger.problem.images[i];
    if (!image.shift_free)
      larger.problem.known.push_back({{{Kind::shift, i}}, minimum.shift(i), 10 * Eigen::Matrix2d::Identity(), 2});
    image.shift_free = true;
  }
  const ScoreTest::Explained explained = ScoreTest(scene.problem, larger.problem, minimum, factors).by(kind);
  const Layout layout(larger.problem);
  Eigen::MatrixXd jacobian;
  const Eigen::VectorXd rows = all_rows(larger.problem, layout, minimum, &jacobian);
  const Eigen::VectorXd scale = jacobian.colwise().norm().cwiseInverse();
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> dense;
  dense.setThreshold(1e-10);
  dense.compute(jacobian * scale.asDiagonal());
  const Eigen::VectorXd step = dense.solve(-rows);
  EXPECT_GT(explained.decrease, 0.1);
  EXPECT_NEAR(explained.decrease / (jacobian * scale.asDiagonal() * step).squaredNorm(), 1, 1e-5);
  // The further unknowns are those that the smaller model's blocks had no room for.
  const Layout before(scene.problem);
  std::vector<int> further;
  for (int b = 0; b < layout.block_count(); ++b)
    for (int c = before.size(before.block(layout.ref(b))); c < layout.size(b); ++c)
      further.push_back(layout.offset(b) + c);
  const Eigen::VectorXd expected = (scale.asDiagonal() * step)(further);
  ASSERT_EQ(explained.step.size(), expected.size());
  EXPECT_LT((explained.step - expected).norm(), 1e-4 * expected.norm());
}

TEST(Bundle, ScoreOfFurtherUnknownsIsWhatALargerModelWouldExplain) {
  for (bool free : {false, true})
    for (Side side : {Side::bodies, Side::images}) {
      const Scene scene = noisy_scene(3, free);
      const Layout layout(scene.problem);
      AdjustOptions options;
      options.datum = inner_datum(scene.problem, layout, free_motions(scene.problem));
      options.minimise.side = side;
      const Adjusted adjusted = bundle::adjust(scene.problem, layout, scene.state, options);
      expect_score_of_dense(scene, adjusted.state, *adjusted.elimination, Kind::camera);
      expect_score_of_dense(scene, adjusted.state, *adjusted.elimination, Kind::shift);
    }
}

TEST(Bundle, VarianceOfWhatIsObservedIsThatOfItsGroups) {
  for (bool free : {false, true}) {
    const Scene scene = noisy_scene(3, free);
    const Layout layout(scene.problem);
    AdjustOptions options;
    options.datum = inner_datum(scene.problem, layout, free_motions(scene.problem));
    const Adjusted adjusted = bundle::adjust(scene.problem, layout, scene.state, options);
    const auto groups = reliability_of(scene.problem, adjusted).groups;
    const double expected =
        (groups[0].sum_of_squares + groups[1].sum_of_squares) / (groups[0].redundancy + groups[1].redundancy);
    EXPECT_NEAR(observed_variance(scene.problem, layout, adjusted, options.datum) / expected, 1, 1e-8);
  }
}

/// One principal point by itself explains less than all together, and as much as a larger model with it alone.
TEST(Bundle, ScoreOfOneImageIsThatOfAModelWithItAlone) {
  const Scene scene = noisy_scene(3, false);
  const Layout layout(scene.problem);
  const Adjusted adjusted = bundle::adjust(scene.problem, layout, scene.state, {});
  const auto with = [&](const std::vector<int>& images) {
    Scene larger = {scene.problem, adjusted.state};
    for (const int i : images) {
      larger.problem.images[i].shift_free = true;
      larger.problem.known.push_back(
          {{{Kind::shift, i}}, adjusted.state.shift(i), 10 * Eigen::Matrix2d::Identity(), 2});
    }
    return larger.problem;
  };
  std::vector<int> held;
  for (int i = 0; i < 6; ++i)
    if (!scene.problem.images[i].shift_free) held.push_back(i);
  ASSERT_GE(held.size(), 2u);
  const Problem all = with(held);
  const ScoreTest test(scene.problem, all, adjusted.state, *adjusted.elimination);
  double most = 0;
  for (const int i : held) {
    const Problem alone = with({i});
    const double expected =
        ScoreTest(scene.problem, alone, adjusted.state, *adjusted.elimination).by(Kind::shift).decrease;
    EXPECT_NEAR(test.by(Kind::shift, i).decrease / expected, 1, 1e-9);
    EXPECT_EQ(test.by(Kind::shift, i).step.size(), 2);
    most = std::max(most, expected);
  }
  EXPECT_GT(test.by(Kind::shift).decrease, most);
}

/// All images of one camera moved alike are its principal point, which is free already: nothing is left to explain.
TEST(Bundle, ScoreOfWhatIsUndeterminedIsNotANumber) {
  Scene scene = noisy_scene(3, false);
  for (auto& image : scene.problem.images) image.shift_free = false;
  std::erase_if(scene.problem.known, [](const Known& k) { return k.refs[0].kind == Kind::shift; });
  const Layout layout(scene.problem);
  const Adjusted adjusted = bundle::adjust(scene.problem, layout, scene.state, {});
  Problem larger = scene.problem;
  for (auto& image : larger.images) image.shift_free = true;
  const ScoreTest test(scene.problem, larger, adjusted.state, *adjusted.elimination);
  EXPECT_TRUE(std::isnan(test.by(Kind::shift).decrease));
  EXPECT_EQ(test.by(Kind::shift).step.size(), 0);
  EXPECT_FALSE(std::isnan(test.by(Kind::shift, 0).decrease)) << "one image against the others is determined";
}

}  // namespace test_bundle_score

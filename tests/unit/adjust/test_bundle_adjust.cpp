// Adjusted blocks: engines beside each other, stated covariances against repeated simulation, what is undetermined by
// name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "bundle_scene.hpp"
#include "photo/bundle/adjust.hpp"
#include "photo/bundle/parts.hpp"
#include "plumbline/stop.hpp"
#include "test_support.hpp"

namespace test_bundle_adjust {

using namespace plumbline;
using namespace plumbline::bundle;
using test::error_of;
using testing::HasSubstr;

TEST(Bundle, EnginesEndInTheSamePlace) {
  Scene scene = noisy_scene(3, false);
  const Layout layout(scene.problem);
  State start = scene.state;
  test::Random random(5);
  const Eigen::VectorXd away =
      Eigen::VectorXd::NullaryExpr(layout.unknown_count(), [&] { return 0.01 * random.normal(); });
  Eigen::VectorXd shift = away;
  for (int b = 0; b < layout.block_count(); ++b)
    if (layout.ref(b).kind == Kind::camera) shift.segment(layout.offset(b), layout.size(b)).setZero();
  apply_step(scene.problem, layout, shift, start);
  AdjustOptions schur, ceres;
  ceres.minimiser = minimise_ceres;
  const Adjusted a = bundle::adjust(scene.problem, layout, start, schur),
                 b = bundle::adjust(scene.problem, layout, start, ceres);
  EXPECT_NEAR(a.sum_of_squares / b.sum_of_squares, 1, 1e-12);
  for (size_t j = 0; j < a.state.points.size(); ++j) EXPECT_LT((a.state.points[j] - b.state.points[j]).norm(), 1e-9);
}

/// Without the steps that finish an adjustment: a wrong step of a quaternion would leave Ceres far off, or on its way.
TEST(Bundle, CeresAloneComesToTheMinimum) {
  Scene scene = noisy_scene(3, false);
  const Layout layout(scene.problem);
  test::Random random(5);
  Eigen::VectorXd shift = Eigen::VectorXd::Zero(layout.unknown_count());
  for (int i = 0; i < 6; ++i)
    for (int c = 3; c < 6; ++c) shift(layout.offset(layout.block({Kind::image, i})) + c) = 0.02 * random.normal();
  State by_schur = scene.state;
  apply_step(scene.problem, layout, shift, by_schur);
  State by_ceres = by_schur;
  const auto schur = minimise_schur(scene.problem, by_schur, {}), ceres = minimise_ceres(scene.problem, by_ceres, {});
  EXPECT_TRUE(ceres.converged);
  EXPECT_NEAR(ceres.initial_cost / schur.initial_cost, 1, 1e-12);
  EXPECT_NEAR(ceres.final_cost / schur.final_cost, 1, 1e-9);
  for (size_t i = 0; i < 6; ++i)
    EXPECT_LT(by_ceres.images[i].rotation.angularDistance(by_schur.images[i].rotation), 1e-6);
}

TEST(Bundle, ThreadsChangeNoBit) {
  const Scene scene = noisy_scene(3, false);
  const Layout layout(scene.problem);
  Elimination one(scene.problem, layout, Side::bodies, 1), three(scene.problem, layout, Side::bodies, 3);
  ASSERT_TRUE(one.build(scene.state, 1e-3) && three.build(scene.state, 1e-3));
  ASSERT_TRUE(one.factorise({}) && three.factorise({}));
  EXPECT_EQ(one.step(), three.step());
  EXPECT_EQ(one.sum_of_squares(), three.sum_of_squares());
}

/// Errors over repeated simulation against the covariance that is stated of them, for every kind of unknown.
void expect_covariance_covers(bool free) {
  const int trials = std::getenv("PLUMBLINE_LONG") ? 600 : 60;
  double points = 0, images = 0, interior = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const Scene scene = noisy_scene(100 + static_cast<uint64_t>(trial), free);
    const Layout layout(scene.problem);
    AdjustOptions options;
    options.datum = inner_datum(scene.problem, layout, free_motions(scene.problem));
    const Adjusted adjusted = bundle::adjust(scene.problem, layout, scene.state, options);
    const int image = layout.block({Kind::image, 2}), point = layout.block({Kind::point, 9}),
              camera = layout.block({Kind::camera, 0});
    Eigen::VectorXd pose(6);
    pose.head<3>() = adjusted.state.images[2].position - scene.state.images[2].position;
    const Eigen::Quaterniond turn = adjusted.state.images[2].rotation * scene.state.images[2].rotation.conjugate();
    pose.tail<3>() = 2 * (turn.w() < 0 ? -1 : 1) * turn.vec();
    Eigen::VectorXd values(layout.size(camera));
    for (size_t k = 0; k < layout.free_values(0).size(); ++k)
      values(static_cast<Eigen::Index>(k)) =
          adjusted.state.interiors[0][layout.free_values(0)[k]] - scene.state.interiors[0][layout.free_values(0)[k]];
    const Eigen::VectorXd error = adjusted.state.points[9] - scene.state.points[9];
    points += error.dot(adjusted.cofactors->own(point).ldlt().solve(error)) / 3;
    images += pose.dot(adjusted.cofactors->own(image).ldlt().solve(pose)) / 6;
    interior += values.dot(adjusted.cofactors->own(camera).ldlt().solve(values)) / double(values.size());
  }
  const double n = trials;
  EXPECT_NEAR(points / n, 1, 4 * std::sqrt(2 / (3 * n)));
  EXPECT_NEAR(images / n, 1, 4 * std::sqrt(2 / (6 * n)));
  EXPECT_NEAR(interior / n, 1, 4 * std::sqrt(2 / (4 * n)));
}

TEST(Bundle, CovarianceOfEveryUnknownCoversItsErrors) { expect_covariance_covers(false); }
TEST(Bundle, CovarianceOfAFreeBlockBelongsToItsDatum) { expect_covariance_covers(true); }

TEST(Bundle, DatumOfTheFirstImageHoldsIt) {
  const Scene scene = noisy_scene(9, true);
  const Layout layout(scene.problem);
  AdjustOptions options;
  options.datum = first_image_datum(scene.problem, layout, scene.state, free_motions(scene.problem));
  const Adjusted adjusted = bundle::adjust(scene.problem, layout, scene.state, options);
  EXPECT_EQ(options.datum.count, 6);  // the distance gives scale
  EXPECT_LT((adjusted.state.images[0].position - scene.state.images[0].position).norm(), 1e-12);
  EXPECT_LT(adjusted.cofactors->own(layout.block({Kind::image, 0})).cwiseAbs().maxCoeff(), 1e-15);
}

TEST(Bundle, WhatIsUndeterminedIsNamed) {
  Scene scene = noisy_scene(1, false);
  scene.problem.known.clear();
  scene.problem.distances.clear();
  for (auto& image : scene.problem.images) image.shift_free = false;
  const Layout layout(scene.problem);
  const std::string motions = error_of([&] { bundle::adjust(scene.problem, layout, scene.state, {}); });
  EXPECT_THAT(motions, HasSubstr("rank defect of 7"));
  EXPECT_THAT(motions, HasSubstr("of the whole block"));
  Scene alone = noisy_scene(1, false);
  alone.problem.points.push_back({"lonely"});
  alone.state.points.push_back({0, 0, 0});
  alone.problem.image_points.push_back(alone.problem.image_points[0]);
  alone.problem.image_points.back().point = 12;
  const Layout larger(alone.problem);
  EXPECT_THAT(error_of([&] { bundle::adjust(alone.problem, larger, alone.state, {}); }),
              HasSubstr("undetermined is the position of lonely"));
}

TEST(Bundle, PartsThatShareNothingAreNamed) {
  Scene one = noisy_scene(1, false), two = noisy_scene(1, false);
  EXPECT_EQ(image_parts(one.problem).size(), 1u);
  one.problem.known.clear(), one.problem.distances.clear();
  // The same block once more, beside the first: what it is made of has numbers of its own.
  const int images = static_cast<int>(one.problem.images.size()), points = static_cast<int>(one.problem.points.size()),
            plates = static_cast<int>(one.problem.plates.size());
  const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
  append(one.problem.images, two.problem.images), append(one.state.images, two.state.images);
  append(one.state.shifts, two.state.shifts);
  append(one.problem.points, two.problem.points), append(one.state.points, two.state.points);
  append(one.problem.plates, two.problem.plates), append(one.state.plates, two.state.plates);
  for (auto o : two.problem.image_points) o.image += images, o.point += points, one.problem.image_points.push_back(o);
  for (auto o : two.problem.image_tags) o.image += images, o.plate += plates, one.problem.image_tags.push_back(o);
  EXPECT_EQ(image_parts(one.problem).size(), 2u);
  const Layout layout(one.problem);
  AdjustOptions options;
  options.datum = inner_datum(one.problem, layout, 7);
  EXPECT_THAT(error_of([&] { bundle::adjust(one.problem, layout, one.state, options); }),
              HasSubstr("falls into 2 parts that share no tag and no point"));
}

TEST(Bundle, ABadStartNamesTheImage) {
  Scene scene = noisy_scene(1, false);
  Placement& pose = scene.state.images[3];
  pose.set(quaternion_from_rotation_vector({0, 0, 2.8}) * pose.rotation, pose.position);
  AdjustOptions options;
  options.minimise.max_iterations = 1;
  const Layout layout(scene.problem);
  EXPECT_THAT(error_of([&] { bundle::adjust(scene.problem, layout, scene.state, options); }), HasSubstr("image3"));
}

/// Both engines ask once an iteration; nothing asks outside of the scope.
TEST(Bundle, StopsWhenNobodyWaitsForIt) {
  const Scene scene = noisy_scene(1, false);
  const Layout layout(scene.problem);
  AdjustOptions schur, ceres;
  ceres.minimiser = minimise_ceres;
  for (const AdjustOptions* options : {&schur, &ceres}) {
    int asked = 0;
    {
      const StopScope scope([](const void* count) { return ++*static_cast<int*>(const_cast<void*>(count)) > 1; },
                            &asked);
      EXPECT_THROW(bundle::adjust(scene.problem, layout, scene.state, *options), Stopped);
    }
    EXPECT_GE(asked, 2);
    EXPECT_NO_THROW(bundle::adjust(scene.problem, layout, scene.state, *options));
  }
}

/// Also while it eliminates, factorises, inverts and computes cofactors: 11 s and more of a large block.
TEST(Bundle, StopsWhereverItIs) {
  const Scene scene = noisy_scene(1, false);
  const Layout layout(scene.problem);
  struct Count {
    int asked, limit;
  };
  const auto ends = [&](int limit) {
    Count count{0, limit};
    const StopScope scope(
        [](const void* of) {
          auto& c = *static_cast<Count*>(const_cast<void*>(of));
          return ++c.asked > c.limit;
        },
        &count);
    try {
      reliability_of(scene.problem, bundle::adjust(scene.problem, layout, scene.state, {}));
    } catch (const Stopped&) {
      return false;
    } catch (const std::exception& error) {
      ADD_FAILURE() << "taken for a failure: " << error.what();
    }
    return true;
  };
  int limit = 1;
  while (limit < 1'000'000 && !ends(limit)) limit += 1 + limit / 8;
  EXPECT_GT(limit, 200) << "it is hardly asked";
}

}  // namespace test_bundle_adjust

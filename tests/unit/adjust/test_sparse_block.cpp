// Blocks whose reduced system is sparse, against dense normal equations: long strips of images.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "photo/bundle/adjust.hpp"
#include "plumbline/rigid_transform.hpp"
#include "plumbline/stop.hpp"
#include "synthetic_block.hpp"
#include "test_support.hpp"

namespace test_sparse_block {

using namespace plumbline;
using namespace plumbline::bundle;

struct Strip {
  Problem problem;
  State state;
};

/// Images 10 m above a strip of ground, 1 m apart, each with the points 3 m before and behind it. `hinge`: where the
/// strip is cut but for two points.
Strip make_strip(int images, bool held, int hinge = -1) {
  Strip strip;
  test::Random random(5);
  Problem& p = strip.problem;
  p.groups = {{"images", 1.3}};
  p.cameras.push_back({"camera", Lens::brown, 0, std::vector<bool>(11, false)});
  p.cameras[0].free[0] = p.cameras[0].free[4] = true;
  strip.state.interiors.push_back({1000, 1000, 500, 400, -0.1, 0.02, 0, 0, 0, 0});
  Eigen::Matrix3d down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  for (int i = 0; i < images; ++i) {
    p.images.push_back({"image " + std::to_string(i), 0});
    strip.state.images.emplace_back();
    const Eigen::Vector3d turn(0.05 * random.normal(), 0.05 * random.normal(), 0.05 * random.normal());
    strip.state.images.back().set(quaternion_from_rotation_vector(turn) * Eigen::Quaterniond(down),
                                  Eigen::Vector3d(i, random.normal(), 10 + random.normal()));
  }
  if (held) p.images.front().fixed = p.images.back().fixed = true;
  for (int j = 0; j < 4 * images; ++j) {
    const double x = 0.25 * j, y = 3 * random.normal(), z = random.normal();
    p.points.push_back({"point " + std::to_string(j)});
    strip.state.points.emplace_back(x, y, z);
    const bool joins = j % 4 == 0 && hinge >= 0 && (j == 4 * hinge || j == 4 * hinge + 4);
    for (int i = std::max(0, j / 4 - 3); i < std::min(images, j / 4 + 4); ++i) {
      if (hinge >= 0 && !joins && (i <= hinge) != (j / 4 <= hinge)) continue;
      ImagePoint o;
      o.image = i, o.point = j;
      const Placement& pose = strip.state.images[i];
      o.observed = computed_image_point(p.cameras[0], strip.state.interiors[0],
                                        pose.matrix * (strip.state.points.back() - pose.position)) +
                   0.3 * Eigen::Vector2d(random.normal(), random.normal());
      o.whitening << 3, 0.5, 0, 2;
      p.image_points.push_back(o);
    }
  }
  return strip;
}

/// Whitened rows of all observations, and the design matrix.
Eigen::MatrixXd design(const Strip& strip, const Layout& layout, Eigen::VectorXd& rows_of_all) {
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(strip.problem.row_count(), layout.unknown_count());
  rows_of_all.resize(jacobian.rows());
  Rows rows;
  Eigen::Index at = 0;
  for (const auto& term : strip.problem.image_points) {
    EXPECT_TRUE(evaluate(strip.problem, layout, strip.state, term, true, rows));
    for (int k = 0; k < rows.parts; ++k) {
      const Rows::Part& part = rows.part[k];
      jacobian.block(at, layout.offset(part.block), rows.rows, part.size) = rows.jacobian(k);
    }
    rows_of_all.segment(at, rows.rows) = rows.values();
    at += rows.rows;
  }
  return jacobian;
}

/// Largest difference in units of the standard deviations, or of 1e-4: held unknowns have none but for rounding.
double difference(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) {
  const Eigen::VectorXd weight = expected.diagonal().cwiseMax(1e-8).cwiseSqrt().cwiseInverse();
  return (weight.asDiagonal() * (found - expected) * weight.asDiagonal()).cwiseAbs().maxCoeff();
}

std::vector<int> unknowns_of(const Layout& layout, const std::vector<int>& blocks) {
  std::vector<int> result;
  for (int b : blocks)
    for (int c = 0; c < layout.size(b); ++c) result.push_back(layout.offset(b) + c);
  return result;
}

void compare_with_dense(const Strip& strip, const Datum& datum) {
  const Layout layout(strip.problem);
  Eigen::VectorXd rows;
  const Eigen::MatrixXd jacobian = design(strip, layout, rows);
  const Eigen::VectorXd scale = jacobian.colwise().norm().cwiseInverse();
  Eigen::MatrixXd normal = scale.asDiagonal() * (jacobian.transpose() * jacobian).eval() * scale.asDiagonal();
  Eigen::MatrixXd g;  // null space, and the S-transformation to the datum
  if (datum.count > 0) {
    g = motions_of(strip.problem, layout, strip.state, least_squares::centre_of(bodies_of(strip.problem, strip.state)))
            .leftCols(datum.count);
    const Eigen::MatrixXd scaled = (scale.cwiseInverse().asDiagonal() * g).householderQr().householderQ() *
                                   Eigen::MatrixXd::Identity(g.rows(), g.cols());
    normal += scaled * scaled.transpose();
  }
  Eigen::MatrixXd inverse = scale.asDiagonal() *
                            normal.llt().solve(Eigen::MatrixXd::Identity(normal.rows(), normal.cols())) *
                            scale.asDiagonal();
  const Eigen::VectorXd expected = -inverse * (jacobian.transpose() * rows);
  if (datum.count > 0) {
    Eigen::MatrixXd c = Eigen::MatrixXd::Zero(g.rows(), g.cols());
    c(datum.held, Eigen::all) = g(datum.held, Eigen::all);
    const Eigen::MatrixXd s =
        Eigen::MatrixXd::Identity(g.rows(), g.rows()) - g * (c.transpose() * g).inverse() * c.transpose();
    inverse = (s * inverse * s.transpose()).eval();
  }
  Elimination elimination(strip.problem, layout);
  ASSERT_TRUE(elimination.build(strip.state));
  ASSERT_TRUE(require_determined(strip.problem, layout, strip.state, elimination, datum));
  ASSERT_FALSE(elimination.factor().analysis().is_dense());
  const Eigen::VectorXd step = elimination.step();
  if (datum.count == 0) {
    EXPECT_LT((step - expected).norm(), 1e-8 * expected.norm());
  }
  // In any datum: it solves the normal equations.
  EXPECT_LT((scale.asDiagonal() * (jacobian.transpose() * (jacobian * step + rows)).eval()).norm(), 1e-9 * rows.norm());
  const Cofactors cofactors(strip.problem, layout, strip.state, elimination, datum);
  std::vector<int> all;
  for (int b = 0; b < layout.block_count(); ++b) all.push_back(b);
  EXPECT_LT(difference(cofactors.joint(all), inverse), 1e-7);
  const auto own = cofactors.all_own();
  for (int b : all) {
    const auto at = unknowns_of(layout, {b});
    if (at.empty()) continue;
    EXPECT_LT(difference(own[b], inverse(at, at)), 1e-7) << b;
  }
  // An image and its camera, and neighbours, which meet; two ends of the strip, which do not.
  const auto image = [&](int i) { return layout.block({Kind::image, i}); };
  const int camera = layout.block({Kind::camera, 0}), last = static_cast<int>(strip.problem.images.size()) - 2;
  const int point = layout.block({Kind::point, 9}), far = layout.block({Kind::point, 4 * last});
  for (const auto& some : {std::vector<int>{image(3), camera},
                           {image(4), image(6), point},
                           {image(1), image(last)},
                           {far, point, camera},
                           {point, point}}) {
    const auto at = unknowns_of(layout, some);
    EXPECT_LT(difference(cofactors.joint(some), inverse(at, at)), 1e-7);
  }
  Adjusted adjusted;
  adjusted.state = strip.state;
  adjusted.cofactors = std::make_unique<Cofactors>(strip.problem, layout, strip.state, elimination, datum);
  const Reliability reliability = reliability_of(strip.problem, adjusted);
  EXPECT_NEAR(reliability.groups[0].redundancy, static_cast<double>(rows.size() - layout.unknown_count() + datum.count),
              1e-5);
}

TEST(SparseBlock, IsTheDenseSolution) { compare_with_dense(make_strip(40, true), {}); }

TEST(SparseBlock, IsTheDenseSolutionInAFreeDatum) {
  const Strip strip = make_strip(40, false);
  const Layout layout(strip.problem);
  const int motions = free_motions(strip.problem);
  EXPECT_EQ(motions, 7);
  compare_with_dense(strip, inner_datum(strip.problem, layout, motions));
  compare_with_dense(strip, first_image_datum(strip.problem, layout, strip.state, motions));
}

/// What the adjustment says of a strip whose halves turn about two points.
std::string words_of_hinge(int images) {
  const Strip strip = make_strip(images, false, images / 2);
  const Layout layout(strip.problem);
  AdjustOptions options;
  options.datum = inner_datum(strip.problem, layout, 7);
  options.start_is_near = true;
  try {
    bundle::adjust(strip.problem, layout, strip.state, options);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

// 300 kept unknowns have all their eigenvalues computed, 720 only the smallest.
TEST(SparseBlock, SaysWhatIsUndeterminedAtAnySize) {
  const std::string small = words_of_hinge(50), large = words_of_hinge(120);
  EXPECT_NE(small.find("the block has a rank defect of 1: undetermined is"), std::string::npos) << small;
  EXPECT_NE(large.find("the block has a rank defect of 1: undetermined is"), std::string::npos) << large;
}

TEST(SparseBlock, GivesTheSameBitsOnAnyNumberOfThreads) {
  const Strip strip = make_strip(60, true);
  const Layout layout(strip.problem);
  std::vector<Adjusted> adjusted;
  for (int threads : {1, 2, 5}) {
    AdjustOptions options;
    options.minimise.threads = threads;
    State start = strip.state;
    for (auto& point : start.points) point.z() += 0.02;
    adjusted.push_back(bundle::adjust(strip.problem, layout, start, options));
  }
  for (size_t k = 1; k < adjusted.size(); ++k) {
    EXPECT_EQ(adjusted[k].sum_of_squares, adjusted[0].sum_of_squares);
    for (size_t j = 0; j < strip.problem.points.size(); ++j)
      EXPECT_EQ(adjusted[k].state.points[j], adjusted[0].state.points[j]);
    EXPECT_EQ(adjusted[k].cofactors->all_own().back(), adjusted[0].cofactors->all_own().back());
  }
}

// Twice as long a strip takes twice the memory, and the whole is told before any of it is taken.
TEST(SparseBlock, TellsItsMemoryWhichGrowsWithItsLength) {
  std::vector<double> told;
  for (int images : {100, 200}) {
    const Strip strip = make_strip(images, true);
    const Layout layout(strip.problem);
    AdjustOptions options;
    struct Enough {};
    options.announce = [&](std::size_t bytes) {
      told.push_back(static_cast<double>(bytes));
      throw Enough();
    };
    EXPECT_THROW(bundle::adjust(strip.problem, layout, strip.state, options), Enough);
  }
  EXPECT_NEAR(told[1] / told[0], 2, 0.1);
}

// Every loop over observations or unknowns asks.
TEST(SparseBlock, CanBeStoppedAnywhere) {
  const Strip strip = make_strip(60, true);
  const Layout layout(strip.problem);
  Elimination elimination(strip.problem, layout);
  ASSERT_TRUE(elimination.build(strip.state) && elimination.factorise({}));
  Eigen::VectorXd right;
  double cost = 0;
  const StopScope scope([](const void*) { return true; }, nullptr);
  EXPECT_THROW(Elimination(strip.problem, layout), Stopped);
  EXPECT_THROW(elimination.gradient(strip.state, right, cost), Stopped);
  EXPECT_THROW(elimination.step(), Stopped);
  EXPECT_THROW(Cofactors(strip.problem, layout, strip.state, elimination, {}), Stopped);
  EXPECT_THROW(elimination.factorise({}), Stopped);
  EXPECT_THROW(elimination.build(strip.state), Stopped);
}

/// Half a second passed between two of them for 100 000 points, when their shares of a solution were computed.
TEST(SparseBlock, IsAskedAtEachPointOfASolution) {
  const Strip strip = make_strip(60, true);
  const Layout layout(strip.problem);
  Elimination elimination(strip.problem, layout);
  ASSERT_TRUE(elimination.build(strip.state) && elimination.factorise({}));
  std::size_t asked = 0;
  const StopScope scope([](const void* count) { return ++*static_cast<std::size_t*>(const_cast<void*>(count)) == 0; },
                        &asked);
  elimination.solve(Eigen::MatrixXd::Zero(layout.unknown_count(), 1));
  EXPECT_GE(asked, 2 * elimination.blocks().size());
}

TEST(SparseBlock, ConjugateGradientsTakeNoFactorAndNameWhatIsOpen) {
  Strip strip = make_strip(60, true);
  const Layout layout(strip.problem);
  AdjustOptions options;
  std::size_t with_factor = 0, without = 0;
  options.announce = [&](std::size_t bytes) { with_factor = bytes; };
  const Adjusted expected = bundle::adjust(strip.problem, layout, strip.state, options);
  for (const Minimiser& minimiser : {Minimiser(minimise_schur), Minimiser(minimise_ceres)}) {
    options.minimiser = minimiser;
    options.announce = [&](std::size_t bytes) { without = bytes; };
    const Adjusted found = adjust_by_gradients(strip.problem, layout, strip.state, options);
    EXPECT_NEAR(found.sum_of_squares / expected.sum_of_squares, 1, 1e-9);
    EXPECT_EQ(found.redundancy(), expected.redundancy());
    EXPECT_FALSE(found.cofactors);
    EXPECT_LT(without, with_factor);
  }
  strip.problem.points.push_back({"lonely"});
  strip.state.points.push_back(strip.state.points[0]);
  strip.problem.image_points.push_back(strip.problem.image_points[0]);
  strip.problem.image_points.back().point = static_cast<int>(strip.problem.points.size()) - 1;
  const Layout larger(strip.problem);
  options.minimiser = minimise_schur;
  EXPECT_THAT(test::error_of([&] { adjust_by_gradients(strip.problem, larger, strip.state, options); }),
              testing::HasSubstr("the position of lonely is undetermined"));
}

}  // namespace test_sparse_block

// The block model and its elimination, each held by something that does not share its code: numerical differentiation
// and a dense normal matrix.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "bundle_scene.hpp"
#include "photo/bundle/adjust.hpp"

namespace test_bundle {

using namespace plumbline;
using namespace plumbline::bundle;

class Lenses : public testing::TestWithParam<Lens> {};
std::string name_of_lens(const testing::TestParamInfo<Lens>& lens) {
  const char* names[] = {"brown", "balanced", "correcting", "fisheye"};
  return names[static_cast<size_t>(lens.param)];
}
INSTANTIATE_TEST_SUITE_P(All, Lenses, testing::Values(Lens::brown, Lens::balanced, Lens::correcting, Lens::fisheye),
                         name_of_lens);

/// The derivatives of all rows against differences of the rows.
void expect_derivatives_of_rows(const Scene& scene) {
  const Layout layout(scene.problem);
  Eigen::MatrixXd jacobian;
  all_rows(scene.problem, layout, scene.state, &jacobian);
  for (int u = 0; u < layout.unknown_count(); ++u) {
    // A step that changes the fit by about one standard deviation or less: coefficients of r⁶ are tiny numbers.
    const double step = 1e-3 / std::max(1e-3, jacobian.col(u).norm());
    State plus = scene.state, minus = scene.state;
    apply_step(scene.problem, layout, step * Eigen::VectorXd::Unit(layout.unknown_count(), u), plus);
    apply_step(scene.problem, layout, -step * Eigen::VectorXd::Unit(layout.unknown_count(), u), minus);
    const Eigen::VectorXd difference =
        (all_rows(scene.problem, layout, plus, nullptr) - all_rows(scene.problem, layout, minus, nullptr)) / (2 * step);
    EXPECT_LT((difference - jacobian.col(u)).norm(), 3e-6 * jacobian.col(u).norm() + 1e-9)
        << name_of_unknown(scene.problem, layout, u);
  }
}

TEST_P(Lenses, EveryDerivativeIsThatOfTheRows) {
  expect_derivatives_of_rows(make_scene(GetParam(), front(GetParam()) > 0));
}

/// What a rotation off a known one costs falls along the derivatives that its rows state, however far it is off.
TEST(Bundle, GradientOfAKnownRotationIsThatOfItsCost) {
  Scene scene = make_scene(Lens::brown, true);
  const auto term = std::find_if(scene.problem.known.begin(), scene.problem.known.end(),
                                 [](const Known& k) { return k.world_from_plate.has_value(); });
  ASSERT_NE(term, scene.problem.known.end());
  term->world_from_plate = quaternion_from_rotation_vector({0.3, -0.5, 0.4}) * *term->world_from_plate;
  const Layout layout(scene.problem);
  const KnownRows rows = evaluate(scene.problem, layout, scene.state, *term);
  const Eigen::VectorXd gradient = 2 * rows.jacobian.transpose() * rows.residual;
  constexpr double step = 1e-5;
  for (size_t c = 3; c < 6; ++c) {
    double cost[2];
    for (int side = 0; side < 2; ++side) {
      State moved = scene.state;
      apply_step(scene.problem, layout,
                 (side == 0 ? -step : step) * Eigen::VectorXd::Unit(layout.unknown_count(), rows.columns[c]), moved);
      cost[side] = evaluate(scene.problem, layout, moved, *term).residual.squaredNorm();
    }
    EXPECT_NEAR((cost[1] - cost[0]) / (2 * step), gradient(static_cast<Eigen::Index>(c)), 1e-6 * gradient.norm());
  }
}

TEST_P(Lenses, MotionsOfTheWholeBlockChangeNoImage) {
  const Scene scene = make_scene(GetParam(), front(GetParam()) > 0);
  const Layout layout(scene.problem);
  Eigen::MatrixXd jacobian;
  all_rows(scene.problem, layout, scene.state, &jacobian);
  const Eigen::Index rows =
      static_cast<Eigen::Index>(2 * scene.problem.image_points.size() + 8 * scene.problem.image_tags.size());
  const Eigen::MatrixXd images = jacobian.topRows(rows);
  const Eigen::MatrixXd motions = motions_of(scene.problem, layout, scene.state, {0.3, -0.2, 0.1});
  for (Eigen::Index m = 0; m < motions.cols(); ++m)
    EXPECT_LT((images * motions.col(m)).norm(), 1e-9 * images.norm() * motions.col(m).norm()) << m;
}

/// The elimination against a dense normal matrix: step, and cofactors of everything with everything.
void compare_with_dense(const Scene& scene, Side side) {
  const Layout layout(scene.problem);
  Eigen::MatrixXd jacobian;
  const Eigen::VectorXd rows = all_rows(scene.problem, layout, scene.state, &jacobian);
  const Eigen::VectorXd scale = jacobian.colwise().norm().cwiseInverse();
  const Eigen::MatrixXd scaled = jacobian * scale.asDiagonal();
  const Eigen::MatrixXd inverse =
      scale.asDiagonal() *
      (scaled.transpose() * scaled).ldlt().solve(Eigen::MatrixXd::Identity(jacobian.cols(), jacobian.cols())) *
      scale.asDiagonal();
  Elimination elimination(scene.problem, layout, side);
  ASSERT_TRUE(elimination.build(scene.state));
  EXPECT_NEAR(elimination.sum_of_squares() / rows.squaredNorm(), 1, 1e-12);
  ASSERT_TRUE(elimination.factorise({}));
  const Eigen::VectorXd expected = -inverse * (jacobian.transpose() * rows);
  EXPECT_LT((elimination.step() - expected).cwiseQuotient(inverse.diagonal().cwiseSqrt()).norm(),
            1e-5 * expected.cwiseQuotient(inverse.diagonal().cwiseSqrt()).norm());
  const Cofactors cofactors(scene.problem, layout, scene.state, elimination, {});
  std::vector<int> all;
  for (int b = 0; b < layout.block_count(); ++b) all.push_back(b);
  const Eigen::VectorXd sigma = inverse.diagonal().cwiseSqrt().cwiseInverse();
  const auto largest = [&](const Eigen::MatrixXd& q, const std::vector<int>& rows_of) {
    std::vector<int> at;
    for (int b : rows_of)
      for (int c = 0; c < layout.size(b); ++c) at.push_back(layout.offset(b) + c);
    const Eigen::VectorXd s = sigma(at);
    return (s.asDiagonal() * (q - inverse(at, at)) * s.asDiagonal()).cwiseAbs().maxCoeff();
  };
  EXPECT_LT(largest(cofactors.joint(all), all), 1e-6);
  // The short way for few blocks, and blocks of every kind with each other.
  for (const std::vector<int>& few : {std::vector<int>{0, 6, 7}, {8, 2}, {layout.block({Kind::camera, 0}), 1, 9}})
    EXPECT_LT(largest(cofactors.joint(few), few), 1e-6);
  const auto own = cofactors.all_own();
  for (int b = 0; b < layout.block_count(); ++b)
    if (layout.size(b) > 0) {
      EXPECT_LT(largest(own[b], {b}), 1e-6);
    }
  // Redundancy: the trace of I − J Q Jᵀ is rows less unknowns, and each row's is that of the dense matrix.
  Adjusted adjusted;
  adjusted.state = scene.state;
  adjusted.cofactors = std::make_unique<Cofactors>(scene.problem, layout, scene.state, elimination, Datum{});
  const Reliability reliability = reliability_of(scene.problem, adjusted);
  double redundancy = 0;
  for (const auto& group : reliability.groups) redundancy += group.redundancy;
  EXPECT_NEAR(redundancy, static_cast<double>(rows.size() - layout.unknown_count()), 1e-5);
  const Eigen::MatrixXd residual =
      Eigen::MatrixXd::Identity(rows.size(), rows.size()) - jacobian * inverse * jacobian.transpose();
  for (size_t i = 0; i < scene.problem.image_points.size(); ++i) {
    const Eigen::Index at = 2 * static_cast<Eigen::Index>(i);
    const Eigen::Matrix2d w = scene.problem.image_points[i].whitening / 1.3;
    const Eigen::Matrix2d unwhitened = w.inverse() * residual.block<2, 2>(at, at) * w;
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(reliability.points[i][k].redundancy_number, unwhitened(k, k), 1e-6);
    EXPECT_NEAR(reliability.points[i][0].residual, (w.inverse() * rows.segment<2>(at))(0), 1e-9 * rows.norm());
  }
}

TEST_P(Lenses, EliminatingEitherSideIsTheDenseSolution) {
  const Scene scene = make_scene(GetParam(), front(GetParam()) > 0);
  compare_with_dense(scene, Side::bodies);
  compare_with_dense(scene, Side::images);
}

/// Six photographs of three moments by two cameras that are fixed to each other, of points some of which lie on a
/// sheet.
Scene rig_scene() {
  Scene scene = make_scene(Lens::fisheye, false);
  Problem& p = scene.problem;
  p.mounts = {{"left", true}, {"right"}};
  p.sheets = {{"the board", true}};
  scene.state.mounts.resize(2);
  scene.state.mounts[1].set(quaternion_from_rotation_vector({0.1, -0.2, 0.15}), {0.4, 0.02, -0.03});
  scene.state.bends = {{0.02, -0.03}};
  for (size_t i = 0; i < 6; ++i) p.images[i].mount = static_cast<int>(i % 2);
  for (size_t i : {1, 3, 5}) p.images[i].exposure = static_cast<int>(i) - 1;
  for (size_t j = 6; j < 12; ++j) {
    p.points[j].fixed = true, p.points[j].sheet = 0;
    p.points[j].bent_by = {0.3 + 0.1 * static_cast<double>(j - 6), 1 - 0.15 * static_cast<double>(j - 6)};
  }
  p.known.push_back({{{Kind::bend, 0}}, Eigen::Vector2d::Zero(), 300 * Eigen::Matrix2d::Identity(), 2});
  std::erase_if(p.known, [](const Known& k) { return k.refs.size() > 1; });  // of points that are fixed now
  return scene;
}

TEST(Bundle, DerivativesOfARigBeforeASheetAreThoseOfItsRows) { expect_derivatives_of_rows(rig_scene()); }

TEST(Bundle, ARigBeforeASheetIsTheDenseSolution) {
  compare_with_dense(rig_scene(), Side::bodies);
  compare_with_dense(rig_scene(), Side::images);
}

/// x = R_mount (R (X + bend − C) − C_mount) through the fisheye of OpenCV's formula.
TEST(Bundle, ARigSeesASheetWhereItIs) {
  const Scene scene = rig_scene();
  const Layout layout(scene.problem);
  Rows rows;
  int compared = 0;
  for (const ImagePoint& o : scene.problem.image_points) {
    const size_t i = static_cast<size_t>(o.image), j = static_cast<size_t>(o.point);
    if (i % 2 == 0 || j < 6) continue;
    ASSERT_TRUE(evaluate(scene.problem, layout, scene.state, o, false, rows));
    Eigen::Vector3d point = scene.state.points[j];
    point.z() += 0.02 * scene.problem.points[j].bent_by.x() - 0.03 * scene.problem.points[j].bent_by.y();
    const Placement &exposure = scene.state.images[i - 1], &mount = scene.state.mounts[1];
    const Eigen::Vector3d seen = mount.rotation * (exposure.rotation * (point - exposure.position) - mount.position);
    const Interior& f = scene.state.interiors[1];
    const double r = seen.head<2>().norm() / seen.z(), t = std::atan(r);
    const double drawn =
        t + f[4] * std::pow(t, 3) + f[5] * std::pow(t, 5) + f[6] * std::pow(t, 7) + f[7] * std::pow(t, 9);
    const Eigen::Vector2d pixel(f[0] * drawn / r * seen.x() / seen.z() + f[2],
                                f[1] * drawn / r * seen.y() / seen.z() + f[3]);
    const Eigen::Vector2d expected = o.whitening / 1.3 * (pixel + scene.state.shift(o.image) - o.observed);
    EXPECT_LT((rows.values() - expected).norm(), 1e-9 * expected.norm());
    ++compared;
  }
  EXPECT_GT(compared, 10);
}

/// W (computed − observed), corner by corner, of a tag that is drawn where it is.
TEST(Bundle, ResidualsOfATagAreItsWhitenedMisclosures) {
  const Scene scene = make_scene(Lens::brown, true);
  const Problem& p = scene.problem;
  const Layout layout(p);
  Rows rows;
  int compared = 0;
  for (const ImageTag& tag : p.image_tags) {
    const Plate& plate = p.plates[tag.plate];
    const size_t batch = static_cast<size_t>(plate.batch);
    if (scene.state.insets[batch] != 0) continue;
    ASSERT_TRUE(evaluate(p, layout, scene.state, tag, false, rows));
    const size_t camera = static_cast<size_t>(p.images[tag.image].camera);
    const Placement &pose = scene.state.images[tag.image], &body = scene.state.plates[tag.plate];
    MarkerPlate printed = plate.shape;
    printed.tag_size *= scene.state.scales[batch];
    const auto corners = tag_corners_in_plate(printed);
    for (size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d in_camera = pose.rotation * (body.position + body.rotation * corners[k] - pose.position);
      const Eigen::Vector2d misclosure =
          computed_image_point(p.cameras[camera], scene.state.interiors[camera], in_camera) +
          scene.state.shift(tag.image) - tag.corners[k];
      const Eigen::Vector2d expected = tag.whitening[k] / p.groups[0].sigma_factor * misclosure;
      EXPECT_LT((rows.values().segment<2>(2 * static_cast<Eigen::Index>(k)) - expected).norm(), 1e-9 * expected.norm());
      ++compared;
    }
  }
  EXPECT_GT(compared, 20);
}

TEST(Bundle, GradientAloneIsThatOfTheNormalEquations) {
  for (Loss::Kind kind : {Loss::Kind::none, Loss::Kind::huber, Loss::Kind::tukey}) {
    Scene scene = make_scene(Lens::brown, true);  // tags that are drawn inwards, and some that are not
    scene.problem.images[4].fixed = true;
    for (auto& o : scene.problem.image_points) o.robust = o.point % 2 == 0;
    for (auto& o : scene.problem.image_tags) o.robust = o.image % 2 == 0;
    const Layout layout(scene.problem);
    const Loss loss{kind, 6000};
    Elimination elimination(scene.problem, layout);
    ASSERT_TRUE(elimination.build(scene.state, 0, loss));
    Eigen::VectorXd right;
    double cost = 0;
    ASSERT_TRUE(elimination.gradient(scene.state, right, cost, loss));
    EXPECT_NEAR(cost / elimination.sum_of_squares(), 1, 1e-12);
    EXPECT_LT((right - elimination.right()).cwiseAbs().cwiseQuotient(elimination.diagonal().cwiseSqrt()).maxCoeff(),
              1e-9 * std::sqrt(cost));
  }
}

TEST(Bundle, HeldPointsAndImagesAreNoUnknowns) {
  Scene scene = make_scene(Lens::brown, true);
  scene.problem.points[2].fixed = scene.problem.images[4].fixed = true;
  compare_with_dense(scene, Side::bodies);
  compare_with_dense(scene, Side::images);
}

}  // namespace test_bundle

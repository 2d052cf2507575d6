// The block model and its elimination, each held by something that does not share its code: numerical differentiation,
// a dense normal matrix, and repeated simulation.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>

#include "photo/bundle/adjust.hpp"
#include "photo/bundle/parts.hpp"
#include "photo/bundle/score.hpp"
#include "plumbline/stop.hpp"
#include "synthetic_block.hpp"
#include "test_support.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::bundle;
using test::error_of;
using testing::HasSubstr;

/// Two cameras of `lens`, six images around twelve points and three plates, everything unknown.
struct Scene {
  Problem problem;
  State state;
};

Interior values_of(Lens lens) {
  if (lens == Lens::brown) return {3000, 3010, 1990, 1510, -0.11, 0.08, -0.02, 1e-3, -7e-4, 0.3, -0.2};
  if (lens == Lens::balanced) return {-28, 0.02, -0.03, -1e-4, 1.5e-7, 1e-10, 6e-6, -9e-6, 2e-4, -1e-4, 3e-5, -2e-8};
  if (lens == Lens::fisheye) return {900, 905, 1990, 1510, 0.05, -0.02, 0.008, -0.003};
  return {7.5, 3.6, 2.6, 5e-3, -1e-4, 1e-6, -6e-5, -3e-5, 1e-3, -2e-3, 1e-3, -2e-5};
}

Scene make_scene(Lens lens, bool with_tags) {
  Scene scene;
  Problem& p = scene.problem;
  test::Random random(7);
  p.groups = {{"images", 1.3}, {"distances", 0.8}, {"known", 1.1}};
  for (int c = 0; c < 2; ++c) {
    p.cameras.push_back({std::to_string(c), lens, 13, std::vector<bool>(static_cast<size_t>(value_count(lens)), true)});
    p.cameras[static_cast<size_t>(c)].free[1] = c == 0;  // one value held in the second
    p.cameras[static_cast<size_t>(c)].inverse_reference = 0.16;
    if (lens == Lens::balanced) p.cameras[static_cast<size_t>(c)].free[11] = false;  // next to undetermined beside D1
    scene.state.interiors.push_back(values_of(lens));
  }
  const auto disturbed = [&](double size) -> Eigen::Vector3d {
    return size * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
  };
  for (int i = 0; i < 6; ++i) {
    const double angle = 2 * M_PI * i / 6;
    const Eigen::Vector3d centre(3 * std::cos(angle), 3 * std::sin(angle), 5 + 0.3 * i);
    const Eigen::Vector3d z = front(lens) * (Eigen::Vector3d(0, 0, 0.2) - centre).normalized();
    const Eigen::Vector3d x = Eigen::Vector3d(std::cos(1.3 * i), std::sin(1.3 * i), 0).cross(z).normalized();
    Eigen::Matrix3d world_from_camera;
    world_from_camera << x, z.cross(x), z;
    p.images.push_back({"image" + std::to_string(i), i % 2, false, i % 3 > 0});
    scene.state.shifts.push_back(lens == Lens::brown ? Eigen::Vector2d(3 - i, 2 * i)
                                                     : Eigen::Vector2d(0.01 * i, -0.02));
    scene.state.images.emplace_back();
    scene.state.images.back().set(Eigen::Quaterniond(Eigen::Matrix3d(world_from_camera.transpose())), centre);
  }
  for (int j = 0; j < 12; ++j) {
    p.points.push_back({std::to_string(j)});
    scene.state.points.push_back(disturbed(0.5));
  }
  if (with_tags) {
    p.batches = {{"a", true, true}, {"b", true, false}};
    scene.state.scales = {1.02, 0.99};
    scene.state.insets = {0.2, 0};
    for (int j = 0; j < 3; ++j) {
      p.plates.push_back({"plate" + std::to_string(j), {0.3, {0.05, -0.1, 0.02}}, j == 2});
      scene.state.plates.emplace_back();
      scene.state.plates.back().set(quaternion_from_rotation_vector(disturbed(0.3)), disturbed(0.4));
    }
    // The first tag's corners are anywhere, the second's in the corners of a square and off its plane.
    scene.state.forms = {{0.02, -0.01, 0.03, -0.02, 0.05}, {0, 0, 0, 0, -0.04}, {}};
    p.plates[0].form_end = form_count;
    p.plates[1].form_begin = form_count - 1, p.plates[1].form_end = form_count;
  }
  const Layout layout(p);
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 12; ++j) {
      if ((i + j) % 5 == 0) continue;
      ImagePoint o;
      o.image = i;
      o.point = j;
      // What is observed matters to the correcting model only; anything on the sensor will do.
      o.observed = lens == Lens::correcting ? Eigen::Vector2d(3 + random.normal(), 2.5 + random.normal())
                                            : Eigen::Vector2d(1000 * random.normal(), 20);
      o.whitening << 2, 0, 0.4, 3;
      p.image_points.push_back(o);
    }
    for (int j = 0; with_tags && j < 3; ++j) {
      ImageTag o;
      o.image = i;
      o.plate = j;
      for (size_t k = 0; k < 4; ++k) o.corners[k].setZero(), o.whitening[k] << 1.5, 0, -0.2, 1.2 + 0.1 * double(k);
      p.image_tags.push_back(o);
    }
  }
  p.distances.push_back({"bar", {Kind::point, 1}, {Kind::point, 5}, 0.7, 1e-4, 1});
  Known control;
  control.refs = {{Kind::point, 0}, {Kind::point, 3}, {Kind::point, 7}};
  control.target = Eigen::VectorXd::Zero(9);
  Eigen::MatrixXd mix = Eigen::MatrixXd::NullaryExpr(9, 9, [&] { return random.normal(); });
  control.whitening = 100 * Eigen::MatrixXd(mix.triangularView<Eigen::Lower>());
  control.whitening.diagonal().array() += 300;
  control.group = 2;
  p.known.push_back(control);
  Known calibration;
  calibration.refs = {{Kind::camera, 1}};
  calibration.target = Eigen::VectorXd::Zero(value_count(lens));
  for (int k = 0; k < value_count(lens); ++k) calibration.target(k) = scene.state.interiors[1][static_cast<size_t>(k)];
  calibration.whitening = Eigen::MatrixXd::Identity(value_count(lens), value_count(lens));
  for (int k = 0; k < value_count(lens); ++k)
    calibration.whitening(k, k) = 1 / (1e-3 * std::abs(calibration.target(k)) + 1e-9);
  calibration.group = 2;
  p.known.push_back(calibration);
  const double shift_weight = lens == Lens::brown ? 1 : 1e3;
  for (int i = 0; i < 6; ++i)
    if (p.images[static_cast<size_t>(i)].shift_free)
      p.known.push_back({{{Kind::shift, i}}, Eigen::Vector2d::Zero(), shift_weight * Eigen::Matrix2d::Identity(), 2});
  if (with_tags) {
    p.known.push_back({{{Kind::scale, 0}}, Eigen::VectorXd::Constant(1, 1.0), Eigen::MatrixXd::Constant(1, 1, 1e3), 2});
    p.known.push_back({{{Kind::scale, 1}}, Eigen::VectorXd::Constant(1, 1.0), Eigen::MatrixXd::Constant(1, 1, 1e3), 2});
    p.known.push_back({{{Kind::plate, 1}}, Eigen::VectorXd::Zero(6), 500 * Eigen::MatrixXd::Identity(6, 6), 2});
    p.known.back().world_from_plate = scene.state.plates[1].rotation;
    p.known.push_back({{{Kind::form, 0}}, Eigen::VectorXd::Zero(5), 100 * Eigen::MatrixXd::Identity(5, 5), 2});
    p.known.push_back({{{Kind::form, 1}}, Eigen::VectorXd::Zero(5), 100 * Eigen::MatrixXd::Identity(5, 5), 2});
  }
  return scene;
}

/// All rows, one below the other, in the order of the problem's lists.
Eigen::VectorXd all_rows(const Problem& p, const Layout& layout, const State& state, Eigen::MatrixXd* jacobian) {
  Eigen::VectorXd r(p.row_count());
  if (jacobian) jacobian->setZero(p.row_count(), layout.unknown_count());
  Eigen::Index at = 0;
  Rows rows;
  const auto add = [&](const auto& term) {
    ASSERT_TRUE(evaluate(p, layout, state, term, jacobian != nullptr, rows));
    r.segment(at, rows.rows) = rows.values();
    for (int k = 0; jacobian && k < rows.parts; ++k)
      jacobian->block(at, layout.offset(rows.part[static_cast<size_t>(k)].block), rows.rows,
                      rows.part[static_cast<size_t>(k)].size) = rows.jacobian(k);
    at += rows.rows;
  };
  for (const auto& o : p.image_points) add(o);
  for (const auto& o : p.image_tags) add(o);
  for (const auto& o : p.distances) add(o);
  for (const auto& o : p.known) {
    const KnownRows known = evaluate(p, layout, state, o);
    r.segment(at, known.residual.size()) = known.residual;
    if (jacobian)
      for (size_t c = 0; c < known.columns.size(); ++c)
        jacobian->block(at, known.columns[c], known.residual.size(), 1) =
            known.jacobian.col(static_cast<Eigen::Index>(c));
    at += known.residual.size();
  }
  return r;
}

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
  expect_derivatives_of_rows(make_scene(GetParam(), GetParam() == Lens::brown));
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
  const Scene scene = make_scene(GetParam(), GetParam() == Lens::brown);
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
      EXPECT_LT(largest(own[static_cast<size_t>(b)], {b}), 1e-6);
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
    for (int k = 0; k < 2; ++k)
      EXPECT_NEAR(reliability.points[i][static_cast<size_t>(k)].redundancy_number, unwhitened(k, k), 1e-6);
    EXPECT_NEAR(reliability.points[i][0].residual, (w.inverse() * rows.segment<2>(at))(0), 1e-9 * rows.norm());
  }
}

TEST_P(Lenses, EliminatingEitherSideIsTheDenseSolution) {
  const Scene scene = make_scene(GetParam(), GetParam() == Lens::brown);
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
    const Plate& plate = p.plates[static_cast<size_t>(tag.plate)];
    const size_t batch = static_cast<size_t>(plate.batch);
    if (scene.state.insets[batch] != 0) continue;
    ASSERT_TRUE(evaluate(p, layout, scene.state, tag, false, rows));
    const size_t camera = static_cast<size_t>(p.images[static_cast<size_t>(tag.image)].camera);
    const Placement &pose = scene.state.images[static_cast<size_t>(tag.image)],
                    &body = scene.state.plates[static_cast<size_t>(tag.plate)];
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

/// A consistent scene: what the balanced camera would measure, with noise of half a micrometre.
Scene noisy_scene(uint64_t seed, bool free) {
  Scene scene = make_scene(Lens::balanced, false);
  Problem& p = scene.problem;
  test::Random random(seed);
  if (free) {
    p.known.clear();
    for (auto& image : p.images) image.shift_free = false;  // what nothing says of it is not to be an unknown
  }
  p.cameras[0].free =
      p.cameras[1].free = {true, true, true, true, false, false, false, false, false, false, false, false};
  for (auto& group : p.groups) group.sigma_factor = 1;
  for (auto& o : p.image_points) {
    const Placement& pose = scene.state.images[static_cast<size_t>(o.image)];
    const size_t camera = static_cast<size_t>(p.images[static_cast<size_t>(o.image)].camera);
    o.whitening = Eigen::Matrix2d::Identity() / 0.0005;
    o.observed =
        computed_image_point(p.cameras[camera], scene.state.interiors[camera],
                             pose.matrix * (scene.state.points[static_cast<size_t>(o.point)] - pose.position)) +
        scene.state.shift(o.image) + 0.0005 * Eigen::Vector2d(random.normal(), random.normal());
  }
  for (auto& d : p.distances)
    d.length = (scene.state.points[1] - scene.state.points[5]).norm() + d.sigma * random.normal();
  for (auto& k : p.known) {
    for (size_t r = 0, at = 0; r < k.refs.size(); ++r, at += 3)
      if (k.refs[r].kind == Kind::shift)
        k.target = scene.state.shift(k.refs[r].index);
      else if (k.refs[r].kind == Kind::point)
        k.target.segment<3>(static_cast<Eigen::Index>(at)) = scene.state.points[static_cast<size_t>(k.refs[r].index)];
    const Eigen::VectorXd noise = Eigen::VectorXd::NullaryExpr(k.whitening.rows(), [&] { return random.normal(); });
    k.target += k.whitening.lu().solve(noise);
  }
  return scene;
}

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
          adjusted.state.interiors[0][static_cast<size_t>(layout.free_values(0)[k])] -
          scene.state.interiors[0][static_cast<size_t>(layout.free_values(0)[k])];
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

/// By a dense least-squares fit of all derivatives, of a larger model, to the residuals.
void expect_score_of_dense(const Scene& scene, const State& minimum, const Elimination& factors, Kind kind) {
  Scene larger = {scene.problem, minimum};
  if (kind == Kind::camera)
    for (auto& camera : larger.problem.cameras) camera.free[4] = camera.free[5] = true;
  for (int i = 0; i < 6 && kind == Kind::shift; ++i) {
    auto& image = larger.problem.images[static_cast<size_t>(i)];
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

}  // namespace

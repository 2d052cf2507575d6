// Image blocks of two cameras for the tests of the bundle, and all rows of one with their derivatives.
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "photo/bundle/terms.hpp"
#include "synthetic_block.hpp"

namespace plumbline::bundle {

/// Two cameras of `lens`, six images around twelve points and three plates, everything unknown.
struct Scene {
  Problem problem;
  State state;
};

inline Interior values_of(Lens lens) {
  if (lens == Lens::brown) return {3000, 3010, 1990, 1510, -0.11, 0.08, -0.02, 1e-3, -7e-4, 0.3, -0.2};
  if (lens == Lens::balanced) return {-28, 0.02, -0.03, -1e-4, 1.5e-7, 1e-10, 6e-6, -9e-6, 2e-4, -1e-4, 3e-5, -2e-8};
  if (lens == Lens::fisheye) return {900, 905, 1990, 1510, 0.05, -0.02, 0.008, -0.003};
  return {7.5, 3.6, 2.6, 5e-3, -1e-4, 1e-6, -6e-5, -3e-5, 1e-3, -2e-3, 1e-3, -2e-5};
}

inline Scene make_scene(Lens lens, bool with_tags) {
  Scene scene;
  Problem& p = scene.problem;
  test::Random random(7);
  p.groups = {{"images", 1.3}, {"distances", 0.8}, {"known", 1.1}};
  for (int c = 0; c < 2; ++c) {
    p.cameras.push_back({std::to_string(c), lens, 13, std::vector<bool>(static_cast<size_t>(value_count(lens)), true)});
    p.cameras[c].free[1] = c == 0;  // one value held in the second
    p.cameras[c].inverse_reference = 0.16;
    if (lens == Lens::balanced) p.cameras[c].free[11] = false;  // next to undetermined beside D1
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
  for (int k = 0; k < value_count(lens); ++k) calibration.target(k) = scene.state.interiors[1][k];
  calibration.whitening = Eigen::MatrixXd::Identity(value_count(lens), value_count(lens));
  for (int k = 0; k < value_count(lens); ++k)
    calibration.whitening(k, k) = 1 / (1e-3 * std::abs(calibration.target(k)) + 1e-9);
  calibration.group = 2;
  p.known.push_back(calibration);
  const double shift_weight = lens == Lens::brown ? 1 : 1e3;
  for (int i = 0; i < 6; ++i)
    if (p.images[i].shift_free)
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
inline Eigen::VectorXd all_rows(const Problem& p, const Layout& layout, const State& state, Eigen::MatrixXd* jacobian) {
  Eigen::VectorXd r(p.row_count());
  if (jacobian) jacobian->setZero(p.row_count(), layout.unknown_count());
  Eigen::Index at = 0;
  Rows rows;
  const auto add = [&](const auto& term) {
    ASSERT_TRUE(evaluate(p, layout, state, term, jacobian != nullptr, rows));
    r.segment(at, rows.rows) = rows.values();
    for (int k = 0; jacobian && k < rows.parts; ++k)
      jacobian->block(at, layout.offset(rows.part[k].block), rows.rows, rows.part[k].size) = rows.jacobian(k);
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

/// A consistent scene: what the balanced camera would measure, with noise of half a micrometre.
inline Scene noisy_scene(uint64_t seed, bool free) {
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
    const Placement& pose = scene.state.images[o.image];
    const size_t camera = static_cast<size_t>(p.images[o.image].camera);
    o.whitening = Eigen::Matrix2d::Identity() / 0.0005;
    o.observed = computed_image_point(p.cameras[camera], scene.state.interiors[camera],
                                      pose.matrix * (scene.state.points[o.point] - pose.position)) +
                 scene.state.shift(o.image) + 0.0005 * Eigen::Vector2d(random.normal(), random.normal());
  }
  for (auto& d : p.distances)
    d.length = (scene.state.points[1] - scene.state.points[5]).norm() + d.sigma * random.normal();
  for (auto& k : p.known) {
    for (size_t r = 0, at = 0; r < k.refs.size(); ++r, at += 3)
      if (k.refs[r].kind == Kind::shift)
        k.target = scene.state.shift(k.refs[r].index);
      else if (k.refs[r].kind == Kind::point)
        k.target.segment<3>(static_cast<Eigen::Index>(at)) = scene.state.points[k.refs[r].index];
    const Eigen::VectorXd noise = Eigen::VectorXd::NullaryExpr(k.whitening.rows(), [&] { return random.normal(); });
    k.target += k.whitening.lu().solve(noise);
  }
  return scene;
}

}  // namespace plumbline::bundle

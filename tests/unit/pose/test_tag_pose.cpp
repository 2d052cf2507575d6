// Robust orientation, with every solver of both libraries.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <iostream>
#include <set>
#include <sstream>

#include "geometry/edge_inset.hpp"
#include "geometry/samples.hpp"
#include "geometry/statistics.hpp"
#include "geometry/tag_pose.hpp"
#include "geometry/tag_pose_errors.hpp"
#include "photo/pose/rig_pose.hpp"
#include "place/pose/opencv_solvers.hpp"
#include "place/pose/opengv_solvers.hpp"
#include "synthetic_facade.hpp"

namespace plumbline {
namespace test_tag_pose {

using test::Random;

BrownCamera make_camera() {
  BrownCamera camera;
  camera.width = 6000, camera.height = 4000;
  camera.fx = camera.fy = 5000;
  camera.cx = 3010, camera.cy = 1990;
  camera.k1 = -0.05, camera.k2 = 0.02, camera.p1 = 2e-4;
  return camera;
}

struct Field {
  double point_sigma = 0;     ///< error of the approximate anchors [m]
  double rotation_sigma = 0;  ///< of the plates [rad]
  double pixel_sigma = 0;     ///< [px]
  double shape_sigma = 0;     ///< of a corner against its tag's plane square [m]
  double depth = 0.02;        ///< spread of the anchors across the facade [m]
  int columns = 4, rows = 3;
  std::uint64_t seed = 1;
};

InteriorOrientation make_fisheye() {
  InteriorOrientation camera = make_camera();
  camera.lens = LensModel::fisheye, camera.fx = 2300, camera.fy = 2310;
  camera.k1 = 0.04, camera.k2 = -0.015, camera.k3 = 0.005, camera.k4 = -0.001;
  return camera;
}

struct Scene {
  BrownCamera camera = make_camera();
  RigidTransform cam_from_world;
  std::vector<TagView> views;
};

/// Plates on a 2 m grid in the plane y = 0 that face -y, seen from 8 m, obliquely and rolled.
Scene make_scene(const Field& field, const InteriorOrientation& camera = make_camera()) {
  Scene scene;
  scene.camera = camera;
  Random random(field.seed);
  scene.cam_from_world = test::detail::look_at({2.0 + random.normal(), -8, 1.0}, {3, 0, 2}, 0.3 * random.normal());
  Eigen::Matrix3d facing;
  facing << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  for (int row = 0; row < field.rows; ++row)
    for (int column = 0; column < field.columns; ++column) {
      TagView view;
      view.id = static_cast<int>(scene.views.size());
      view.tag_size = 0.2;
      const Eigen::Vector3d truth(2.0 * column, field.depth * random.normal(), 2.0 * row);
      view.anchor_in_world = truth + random.normal3(field.point_sigma);
      view.anchor_covariance = Eigen::Matrix3d::Identity() * std::max(1e-8, field.point_sigma * field.point_sigma);
      const Eigen::Vector3d centre(0, -0.16, 0);
      const Eigen::Quaterniond nominal(facing);
      view.world_from_tag = {nominal, view.anchor_in_world + nominal * centre};
      const RigidTransform true_plate{quaternion_from_rotation_vector(random.normal3(field.rotation_sigma)) * nominal,
                                      truth};
      bool inside = true;
      for (int i = 0; i < 4; ++i) {
        Eigen::Vector3d corner = centre + view.corner_in_tag(i);
        if (field.shape_sigma > 0) corner += random.normal3(field.shape_sigma);
        const auto pixel = project(scene.camera, scene.cam_from_world * (true_plate * corner));
        const Eigen::Vector2d noise(random.normal(), random.normal());
        if (!pixel) throw std::logic_error("behind the camera");
        view.pixels[i] = *pixel + field.pixel_sigma * noise;
        view.pixel_covariances[i] = Eigen::Matrix2d::Identity() * std::max(1e-4, field.pixel_sigma * field.pixel_sigma);
        inside = inside && pixel->x() > 0 && pixel->y() > 0 && pixel->x() < 6000 && pixel->y() < 4000;
        const auto normalised = unproject(scene.camera, view.pixels[i]);
        inside = inside && normalised;
        if (normalised) view.bearings[i] = normalised->homogeneous().normalized();
      }
      if (inside) scene.views.push_back(view);
    }
  return scene;
}

/// The next tag's corners, for every `step`th tag: as if it were taken for another one.
void confuse(Scene& scene, std::size_t step) {
  const auto original = scene.views;
  for (std::size_t i = 0; i < original.size(); i += step) {
    const TagView& other = original[(i + 1) % original.size()];
    scene.views[i].pixels = other.pixels;
    scene.views[i].bearings = other.bearings;
  }
}

TagPoseOptions options_for(const Field& field) {
  TagPoseOptions options;
  options.plate_rotation_sigma = std::max(field.rotation_sigma, 1e-6);
  options.tag_shape_sigma = field.shape_sigma / 0.2;
  return options;
}

double centre_error(const TagPose& found, const Scene& scene) {
  return (found.cam_from_world.inverse().translation - scene.cam_from_world.inverse().translation).norm();
}

class TagPoseSolvers : public testing::TestWithParam<std::string> {
 protected:
  static TagPoseSolver solver() {
    const std::string name = GetParam().substr(GetParam().find(':') + 1);
    return GetParam().rfind("opengv", 0) == 0 ? pose::make_opengv_solver(name) : pose::make_opencv_solver(name);
  }
};

TEST_P(TagPoseSolvers, RecoverTheTruthWithoutNoise) {
  for (const double depth : {0.0, 0.02, 1.0}) {
    const Field field{.depth = depth};
    const Scene scene = make_scene(field);
    const TagPose found = estimate_tag_pose(scene.camera, scene.views, solver(), options_for(field));
    EXPECT_LT(centre_error(found, scene), 1e-7) << "anchors spread over " << depth << " m";
    EXPECT_EQ(found.inlier_count, static_cast<int>(scene.views.size()));
  }
}

TEST_P(TagPoseSolvers, RecoverTheTruthThroughAFisheye) {
  const Field field{.depth = 0.02, .columns = 8, .rows = 5};
  const Scene scene = make_scene(field, make_fisheye());
  double widest = 0;
  for (const TagView& view : scene.views) widest = std::max(widest, std::acos(view.bearings[0].z()));
  ASSERT_GT(widest, 45 * M_PI / 180);
  const TagPose found = estimate_tag_pose(scene.camera, scene.views, solver(), options_for(field));
  EXPECT_LT(centre_error(found, scene), 1e-7);
  EXPECT_EQ(found.inlier_count, static_cast<int>(scene.views.size()));
}

TEST_P(TagPoseSolvers, FindTheWrongTagsOfAThird) {
  const Field field{.point_sigma = 0.02, .rotation_sigma = 0.03, .pixel_sigma = 0.2, .seed = 5};
  Scene scene = make_scene(field);
  confuse(scene, 3);
  const TagPose found = estimate_tag_pose(scene.camera, scene.views, solver(), options_for(field));
  for (std::size_t i = 0; i < scene.views.size(); ++i) EXPECT_EQ(found.inliers[i], i % 3 != 0) << i;
  EXPECT_LT(centre_error(found, scene), 0.06);
}

TEST_P(TagPoseSolvers, OrientWithThreeTags) {
  const Field field{
      .point_sigma = 0.01, .rotation_sigma = 0.02, .pixel_sigma = 0.1, .columns = 2, .rows = 2, .seed = 2};
  Scene scene = make_scene(field);
  ASSERT_GE(scene.views.size(), 3u);
  scene.views.resize(3);
  EXPECT_LT(centre_error(estimate_tag_pose(scene.camera, scene.views, solver(), options_for(field)), scene), 0.15);
}

INSTANTIATE_TEST_SUITE_P(OpenGv, TagPoseSolvers, testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const auto& name : pose::opengv_solver_names()) names.push_back("opengv:" + name);
                           for (const auto& name : pose::opencv_solver_names()) names.push_back("opencv:" + name);
                           return names;
                         }()),
                         [](const auto& test) {
                           std::string name = test.param;
                           std::replace(name.begin(), name.end(), ':', '_');
                           return name;
                         });

/// Plates turned by 2 and by 3.5 degrees also look smaller by the square of the angle. Bent tags whose places are known
/// well leave their shape as the largest error.
TEST(TagPose, HasACovarianceThatCoversItsError) {
  struct Sigmas {
    double rotation, point, shape;
  };
  for (const auto& [rotation_sigma, point_sigma, shape_sigma] :
       {Sigmas{0.03, 0.02, 0}, {0.06, 0.02, 0}, {0.001, 0.0005, 0.002}}) {
    double sum = 0;
    const int trials = 60;
    for (int k = 0; k < trials; ++k) {
      const Field field{.point_sigma = point_sigma,
                        .rotation_sigma = rotation_sigma,
                        .pixel_sigma = 0.2,
                        .shape_sigma = shape_sigma,
                        .seed = static_cast<std::uint64_t>(k + 10)};
      const Scene scene = make_scene(field);
      TagPoseOptions options = options_for(field);
      options.max_samples = 30;
      const TagPose found =
          estimate_tag_pose(scene.camera, scene.views, pose::make_opengv_solver("p3p_kneip"), options);
      // Error in the tangent of the estimate: R = exp(w) R_true with w in the camera frame, and the translation's
      // difference.
      const Eigen::AngleAxisd turn(found.cam_from_world.rotation * scene.cam_from_world.rotation.conjugate());
      Eigen::Matrix<double, 6, 1> e;
      e << turn.angle() * turn.axis(), found.cam_from_world.translation - scene.cam_from_world.translation;
      sum += e.dot(found.covariance.ldlt().solve(e));
    }
    EXPECT_GT(sum, chi_squared_quantile(0.0005, 6 * trials)) << rotation_sigma << ", " << shape_sigma;
    EXPECT_LT(sum, chi_squared_quantile(0.9995, 6 * trials)) << rotation_sigma << ", " << shape_sigma;
  }
}

/// A calibration that is off by as much as it states, and anchors that are off together, as those of one survey are:
/// without them a pose states far too little, with them what is true. In national coordinates likewise.
TEST(TagPose, HasTheCalibrationAndWhatAnchorsShareInItsCovariance) {
  const Field field{.point_sigma = 0.0005, .rotation_sigma = 0.002, .pixel_sigma = 0.1, .seed = 3};
  const Eigen::Matrix<double, 9, 1> sigma =
      (Eigen::Matrix<double, 9, 1>() << 1.5, 1.5, 1.5, 1.5, 5e-4, 1.5e-3, 0, 5e-5, 5e-5).finished();
  const double together = 0.001;
  const Eigen::Vector3d national(350000, 5800000, 100);
  double alone = 0, with = 0;
  const int trials = 60;
  for (int k = 0; k < trials; ++k) {
    Scene scene = make_scene({.point_sigma = field.point_sigma,
                              .rotation_sigma = field.rotation_sigma,
                              .pixel_sigma = field.pixel_sigma,
                              .seed = static_cast<std::uint64_t>(k + 10)});
    Random random(static_cast<std::uint64_t>(1000 + k));
    auto values = scene.camera.parameters();
    for (std::size_t p = 0; p < values.size(); ++p) values[p] += sigma[static_cast<Eigen::Index>(p)] * random.normal();
    BrownCamera believed = scene.camera;
    believed.set_parameters(values);
    const Eigen::Vector3d shift = random.normal3(together) + (k % 2 == 0 ? Eigen::Vector3d::Zero() : national);
    if (k % 2 != 0) scene.cam_from_world.translation -= scene.cam_from_world.rotation * national;
    const auto n = 3 * static_cast<Eigen::Index>(scene.views.size());
    SharedTagErrors shared;
    shared.interior = sigma.cwiseAbs2().asDiagonal();
    shared.anchors.resize(n, n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j)
        shared.anchors(i, j) = (i % 3 == j % 3 ? together * together : 0) + (i == j ? 2.5e-7 : 0);
    for (TagView& view : scene.views) {
      view.anchor_in_world += shift, view.world_from_tag.translation += shift;
      view.anchor_covariance = (2.5e-7 + together * together) * Eigen::Matrix3d::Identity();
    }
    TagPoseOptions options = options_for(field);
    options.max_samples = 30;
    const TagPose found = estimate_tag_pose(believed, scene.views, pose::make_opengv_solver("p3p_kneip"), options);
    const Eigen::AngleAxisd turn(found.cam_from_world.rotation * scene.cam_from_world.rotation.conjugate());
    Eigen::Matrix<double, 6, 1> e;
    e << turn.angle() * turn.axis(), found.cam_from_world.translation - scene.cam_from_world.translation;
    // About the origin of national coordinates translation and rotation are one: compared where the tags are.
    Eigen::Matrix<double, 6, 6> here = Eigen::Matrix<double, 6, 6>::Identity();
    if (k % 2 != 0) here.bottomLeftCorner<3, 3>() = -skew(found.cam_from_world.rotation * national);
    const Eigen::Matrix<double, 6, 6> total = covariance_with(shared, believed, scene.views, options, found);
    e.tail<3>() = found.cam_from_world * (k % 2 == 0 ? Eigen::Vector3d::Zero() : national).eval() -
                  scene.cam_from_world * (k % 2 == 0 ? Eigen::Vector3d::Zero() : national).eval();
    const auto nees = [&](const Eigen::Matrix<double, 6, 6>& covariance) {
      return e.dot((here * covariance * here.transpose()).ldlt().solve(e)) / (6 * trials);
    };
    alone += nees(found.covariance), with += nees(total);
  }
  EXPECT_GT(alone, 2.5);
  EXPECT_GT(with, chi_squared_quantile(0.0005, 6 * trials) / (6 * trials));
  EXPECT_LT(with, chi_squared_quantile(0.9995, 6 * trials) / (6 * trials));
}

/// Edges that a photograph draws inwards, all by the same: each corner slides by it along both of its edges.
TEST(TagPose, HasWhatAllEdgesAreDrawnInwardsByInItsCovariance) {
  constexpr double inset_sigma = 0.2;
  double with = 0, without = 0;
  const int trials = 60;
  Random random(7);
  for (int k = 0; k < trials; ++k) {
    const Field field{
        .point_sigma = 0.003, .rotation_sigma = 0.003, .pixel_sigma = 0.1, .seed = static_cast<std::uint64_t>(k + 10)};
    Scene scene = make_scene(field);
    TagPoseOptions options = options_for(field);
    const auto pose_of = [&] {
      return estimate_tag_pose(scene.camera, scene.views, pose::make_opengv_solver("p3p_kneip"), options);
    };
    const Eigen::MatrixXd of_corners_alone = pose_of().covariance;
    const double inset = inset_sigma * random.normal();
    for (TagView& view : scene.views) {
      const auto corners = view.pixels;
      for (std::size_t i = 0; i < 4; ++i) {
        const Eigen::Vector2d next = (corners[(i + 1) % 4] - corners[i]).normalized(),
                              last = (corners[(i + 3) % 4] - corners[i]).normalized();
        Eigen::Matrix2d distances;  // of a point from the line towards `next` and from that towards `last`
        distances << -next.y(), next.x(), last.y(), -last.x();
        if (distances.row(0).dot(last) < 0) distances = -distances;
        view.pixels[i] += distances.inverse() * Eigen::Vector2d(inset, inset);
        view.bearings[i] = unproject(scene.camera, view.pixels[i])->homogeneous().normalized();
      }
    }
    options.inset_sigma = inset_sigma;
    const TagPose found = pose_of();
    const Eigen::AngleAxisd turn(found.cam_from_world.rotation * scene.cam_from_world.rotation.conjugate());
    Eigen::Matrix<double, 6, 1> e;
    e << turn.angle() * turn.axis(), found.cam_from_world.translation - scene.cam_from_world.translation;
    with += e.dot(found.covariance.ldlt().solve(e)) / (6 * trials);
    without += e.dot(of_corners_alone.ldlt().solve(e)) / (6 * trials);
  }
  RecordProperty("with", std::to_string(with)), RecordProperty("without", std::to_string(without));
  EXPECT_GT(without, 2) << "the case shows nothing";
  EXPECT_GT(with, 0.7);
  EXPECT_LT(with, 1.4);
}

pose::RigPoseSolver as_one_camera() {
  return [solver = pose::make_opengv_solver("p3p_kneip")](const auto&, const std::vector<const pose::RigTag*>& sample) {
    std::vector<const TagView*> tags;
    for (const pose::RigTag* tag : sample) tags.push_back(&tag->tag);
    return solver(tags);
  };
}

/// Tags of a scene, every third of them by the second of two cameras at one place, whose edges are drawn in [px].
std::vector<pose::RigTag> tags_of_rig(const Scene& scene, bool by_two, double first, double second) {
  std::vector<pose::RigTag> tags;
  for (TagView view : scene.views) {
    const std::size_t camera = by_two && tags.size() % 3 == 0;
    const auto moved = moved_by_inset(view.pixels);
    for (std::size_t i = 0; i < 4; ++i) {
      view.pixels[i] += (camera ? second : first) * moved[i];
      view.bearings[i] = unproject(scene.camera, view.pixels[i])->homogeneous().normalized();
    }
    tags.push_back({camera, view});
  }
  return tags;
}

Eigen::Matrix<double, 6, 1> difference(const RigidTransform& a, const RigidTransform& b) {
  const Eigen::AngleAxisd turn(a.rotation * b.rotation.conjugate());
  Eigen::Matrix<double, 6, 1> d;
  d << turn.angle() * turn.axis(), a.translation - b.translation;
  return d;
}

TEST(RigPose, HasWhatACameraDrawsEdgesInByInItsCovariance) {
  constexpr double inset_sigma = 0.2;
  double with = 0, without = 0, trials = 0;
  Random random(8);
  for (int k = 0; k < 60; ++k) {
    const Field field{
        .point_sigma = 0.003, .rotation_sigma = 0.003, .pixel_sigma = 0.1, .seed = static_cast<std::uint64_t>(k + 10)};
    const Scene scene = make_scene(field);
    std::vector<pose::RigView> views{{scene.camera, RigidTransform{}, 0}};
    const std::vector<pose::RigTag> tags = tags_of_rig(scene, false, inset_sigma * random.normal(), 0);
    const TagPoseOptions options = options_for(field);
    try {
      const Eigen::MatrixXd of_corners = pose::estimate_rig_pose(views, tags, as_one_camera(), options).covariance;
      views[0].inset_sigma = inset_sigma;
      const pose::RigPose found = pose::estimate_rig_pose(views, tags, as_one_camera(), options);
      const auto e = difference(found.rig_from_world, scene.cam_from_world);
      with += e.dot(found.covariance.ldlt().solve(e)) / 6;
      without += e.dot(of_corners.ldlt().solve(e)) / 6;
      trials += 1;
    } catch (const NoTagPose&) {  // the few hypotheses that a rig keeps are all wrong now and then
    }
  }
  with /= trials, without /= trials;
  EXPECT_GE(trials, 50);
  RecordProperty("with", std::to_string(with)), RecordProperty("without", std::to_string(without));
  EXPECT_GT(without, 2) << "the case shows nothing";
  EXPECT_GT(with, 0.7);
  EXPECT_LT(with, 1.4);
}

/// Each camera draws edges in as it pleases: two effects, as moving the corners of each shows them.
TEST(RigPose, HoldsTheInsetOfEachCameraByItself) {
  const Field field{.point_sigma = 0.003, .rotation_sigma = 0.003, .pixel_sigma = 0.1, .seed = 12};
  const Scene scene = make_scene(field);
  constexpr double first = 0.02, second = 0.03;
  std::vector<pose::RigView> views(2, {scene.camera, RigidTransform{}, 0});
  const auto pose_of = [&](double a, double b) {
    return pose::estimate_rig_pose(views, tags_of_rig(scene, true, a, b), as_one_camera(), options_for(field));
  };
  const pose::RigPose without = pose_of(0, 0), one = pose_of(first, 0), other = pose_of(0, second);
  views[0].inset_sigma = first, views[1].inset_sigma = second;
  const auto a = difference(one.rig_from_world, without.rig_from_world),
             b = difference(other.rig_from_world, without.rig_from_world);
  const Eigen::MatrixXd expected = a * a.transpose() + b * b.transpose();
  EXPECT_LT((pose_of(0, 0).covariance - without.covariance - expected).norm(), 0.1 * expected.norm());
}

/// The approximate anchors allow for millimetres that all corners of a tag have in common, not for a bent one.
TEST(TagPose, AgreesWithBentTagsOfWhichItWasTold) {
  const Field bent{.point_sigma = 0.02, .rotation_sigma = 0.03, .pixel_sigma = 0.03, .shape_sigma = 0.0005, .seed = 3};
  const Scene scene = make_scene(bent);
  const auto solver = pose::make_opengv_solver("p3p_kneip");
  const TagPose told = estimate_tag_pose(scene.camera, scene.views, solver, options_for(bent));
  EXPECT_EQ(told.inlier_count, static_cast<int>(scene.views.size()));
  TagPoseOptions flat = options_for(bent);
  flat.tag_shape_sigma = 0;
  try {
    EXPECT_LT(estimate_tag_pose(scene.camera, scene.views, solver, flat).inlier_count, told.inlier_count);
  } catch (const NoTagPose&) {
  }
}

TEST(TagPose, IsEquivariantUnderAMotionOfTheWorldToNationalCoordinates) {
  const Field field{.point_sigma = 0.01, .rotation_sigma = 0.02, .pixel_sigma = 0.2, .seed = 8};
  const Scene scene = make_scene(field);
  const RigidTransform motion{quaternion_from_rotation_vector({0.1, -0.3, 2.0}), {512'345.0, 5'412'678.0, 431.0}};
  Scene moved = scene;
  for (TagView& view : moved.views) {
    view.world_from_tag = motion * view.world_from_tag;
    view.anchor_in_world = motion * view.anchor_in_world;
  }
  const auto solver = pose::make_opengv_solver("p3p_kneip");
  const TagPose plain = estimate_tag_pose(scene.camera, scene.views, solver, options_for(field));
  const TagPose there = estimate_tag_pose(moved.camera, moved.views, solver, options_for(field));
  const Eigen::Vector3d expected = motion * plain.cam_from_world.inverse().translation;
  // A coordinate of five million metres is itself only known to a nanometre.
  EXPECT_LT((there.cam_from_world.inverse().translation - expected).norm(), 1e-6);
}

TEST(TagPose, RefusesTagsThatAgreeWithNothing) {
  const Field field{.seed = 4};
  Scene scene = make_scene(field);
  Random random(3);
  for (TagView& view : scene.views)
    for (int i = 0; i < 4; ++i) {
      view.pixels[i] = {6000 * random.uniform(), 4000 * random.uniform()};
      view.bearings[i] = unproject(scene.camera, view.pixels[i])->homogeneous().normalized();
    }
  try {
    estimate_tag_pose(scene.camera, scene.views, pose::make_opencv_solver("sqpnp"), options_for(field));
    FAIL() << "random corners gave a pose";
  } catch (const NoTagPose& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("of " + std::to_string(scene.views.size())));
  }
}

TEST(TagPose, ASampleThatDeterminesNothingIsNotTalkedAbout) {
  Scene scene = make_scene({});
  for (TagView& view : scene.views) {
    view.tag_size = 0;
    view.world_from_tag = scene.views[0].world_from_tag;
    view.bearings.fill(Eigen::Vector3d::UnitZ());
  }
  const std::vector<const TagView*> sample = {&scene.views[0], &scene.views[1], &scene.views[2]};
  std::ostringstream printed;
  std::streambuf* const before = std::cerr.rdbuf(printed.rdbuf());
  const PoseHypotheses poses = pose::make_opengv_solver("epnp")(sample);
  std::cerr.rdbuf(before);
  EXPECT_EQ(printed.str(), "");
  EXPECT_THAT(poses, testing::IsEmpty());
}

TEST(Samples, AreAllCombinationsInOrderOrAsManyDrawnOnes) {
  std::vector<std::vector<int>> all;
  std::vector<int> sample;
  for (Samples samples(5, 3, 10, 1); samples.next(sample);) all.push_back(sample);
  EXPECT_EQ(all.size(), 10u);
  EXPECT_EQ(all.front(), (std::vector<int>{0, 1, 2}));
  EXPECT_EQ(all.back(), (std::vector<int>{2, 3, 4}));
  EXPECT_TRUE(std::is_sorted(all.begin(), all.end()));
  EXPECT_EQ(std::adjacent_find(all.begin(), all.end()), all.end());
  int drawn = 0;
  std::set<int> seen;
  for (Samples samples(5, 3, 9, 1); samples.next(sample); ++drawn) {
    EXPECT_EQ(std::set<int>(sample.begin(), sample.end()).size(), 3u);
    seen.insert(sample.begin(), sample.end());
  }
  EXPECT_EQ(drawn, 9);
  EXPECT_EQ(seen, (std::set<int>{0, 1, 2, 3, 4}));
}

/// Barrel distortion with which an ideal corner of this image would lie a fifth of its radius further in.
TEST(Camera, UndistortsToTheLastDigitsOverAStronglyDistortedImage) {
  BrownCamera camera = make_camera();
  camera.fx = camera.fy = 3000;
  camera.k1 = -0.22, camera.k2 = 0.05, camera.k3 = -0.004, camera.p1 = 1e-3, camera.p2 = -8e-4;
  for (double u = 0; u <= 6000; u += 250)
    for (double v = 0; v <= 4000; v += 250) {
      const auto ray = unproject(camera, {u, v});
      ASSERT_TRUE(ray) << u << " " << v;
      const auto again = project(camera, ray->homogeneous());
      ASSERT_TRUE(again);
      EXPECT_LT((*again - Eigen::Vector2d(u, v)).norm(), 1e-11) << u << " " << v;
    }
}

TEST(Camera, UnprojectsAFisheyeAlmostToASquareAngle) {
  const InteriorOrientation camera = make_fisheye();
  for (double angle = 0; angle < 89; angle += 4)
    for (double turn = 0; turn < 6.2; turn += 0.7) {
      const double r = std::sin(angle * M_PI / 180);
      const Eigen::Vector3d direction(r * std::cos(turn), r * std::sin(turn), std::cos(angle * M_PI / 180));
      const auto pixel = project(camera, 3.0 * direction);
      ASSERT_TRUE(pixel);
      const auto ray = unproject(camera, *pixel);
      ASSERT_TRUE(ray) << angle;
      EXPECT_LT((ray->homogeneous().normalized() - direction).norm(), 1e-13) << angle;
    }
  EXPECT_FALSE(unproject(camera, {camera.cx + 2 * camera.fx, camera.cy})) << "more than 90 degrees off the axis";
  InteriorOrientation turns_back = camera;
  turns_back.k1 = -0.5, turns_back.k2 = turns_back.k3 = turns_back.k4 = 0;
  EXPECT_TRUE(unproject(turns_back, {camera.cx + 0.4 * camera.fx, camera.cy}));
  EXPECT_FALSE(unproject(turns_back, {camera.cx + 0.6 * camera.fx, camera.cy})) << "no angle is drawn there";
}

/// By the point and by every parameter, none of which is zero.
TEST(Camera, DerivativesAreThoseOfTheProjection) {
  InteriorOrientation brown = make_camera();
  brown.k1 = -0.22, brown.k2 = 0.05, brown.k3 = -0.004, brown.p1 = 1e-3, brown.p2 = -8e-4, brown.fy = 4900;
  for (const InteriorOrientation& camera : {brown, make_fisheye()})
    for (const Eigen::Vector3d& point :
         {Eigen::Vector3d(0.3, -0.2, 1), Eigen::Vector3d(-1.1, 0.7, 1.4), Eigen::Vector3d(1e-9, 2e-9, 2)}) {
      const auto at = project_with_slope(camera, point);
      ASSERT_TRUE(at);
      EXPECT_LT((at->pixel - *project(camera, point)).norm(), 1e-9);
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(k);
        const Eigen::Vector2d slope = (*project(camera, point + step) - *project(camera, point - step)) / 2e-6;
        EXPECT_LT((at->by_point.col(k) - slope).norm(), 1e-6 * camera.fx) << k;
      }
      const auto by_parameters = pixel_by_parameters(camera, point.x() / point.z(), point.y() / point.z());
      const auto values = camera.parameters();
      for (int k = 0; k < InteriorOrientation::parameter_count; ++k) {
        InteriorOrientation moved[2] = {camera, camera};
        const double step = k < 4 ? 1e-2 : 1e-5;
        for (int side = 0; side < 2; ++side) {
          auto changed = values;
          changed[k] += side ? step : -step;
          moved[side].set_parameters(changed);
        }
        const Eigen::Vector2d slope = (*project(moved[1], point) - *project(moved[0], point)) / (2 * step);
        EXPECT_LT((by_parameters.col(k) - slope).norm(), 1e-7 * camera.fx) << k;
      }
    }
}

TEST(TagPose, RefusesAnUnknownSolverByListingTheKnown) {
  EXPECT_THROW(pose::make_opencv_solver("epnp"), std::runtime_error);
  try {
    pose::make_opengv_solver("p4p");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), testing::AllOf(testing::HasSubstr("'p4p'"), testing::HasSubstr("p3p_kneip, ")));
  }
}

}  // namespace test_tag_pose
}  // namespace plumbline

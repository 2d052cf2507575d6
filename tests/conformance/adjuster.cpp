// What every adjuster must do: equations (4) and (5).
#include <Eigen/Dense>
#include <cstdlib>

#include "node_harness.hpp"
#include "parameter_effects.hpp"
#include "runtime/plugins/programs.hpp"
#include "stopping.hpp"
#include "synthetic_facade.hpp"

namespace adjuster_tests {

using namespace plumbline;
using namespace plumbline::test;

/// What a node of this role cannot do it declares.
bool gives_no_covariance(const std::string& kind) {
  return std::string(built_registry().find(kind)->node->lacks) == "covariance";
}

/// A program that a node starts, which its parameters name, if it is not there.
std::string missing_program(const std::string& kind) {
  const plumbline_node& node = *built_registry().find(kind)->node;
  for (uint32_t i = 0; i < node.param_count; ++i)
    if (runtime::names_program(*node.params[i]) &&
        runtime::find_program(node.params[i]->default_text).find('/') == std::string::npos)
      return node.params[i]->default_text;
  return {};
}

class Adjuster : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override {
    if (const std::string program = missing_program(GetParam()); !program.empty())
      GTEST_SKIP() << GetParam() << " needs the program " << program << ", which is not installed";
  }
  static NodeHarness prepared(const SyntheticFacade& facade, bool with_control = true) {
    NodeHarness node(GetParam());
    node.input<Camera>("camera", facade.camera_artifact());
    node.input<Plates>("plates", facade.plates);
    node.input<Poses>("poses", facade.poses);
    for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
    if (with_control) node.input<Points>("control", facade.control);
    return node;
  }
  static PointsT adjusted(const SyntheticFacade& facade) {
    NodeHarness node = prepared(facade);
    node.run();
    return node.output<Points>("points");
  }
  /// Who gives no covariance gives no number in its place, either.
  static void expect_no_standard_deviation() {
    NodeHarness node = prepared(make_facade({.floors = 1, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 100}));
    node.run();
    const PointsT points = node.output<Points>("points");
    EXPECT_TRUE(points.covariance.empty());
    for (const auto& point : points.points) EXPECT_TRUE(point->sigma.array().isNaN().all()) << point->id;
    for (const auto& pose : node.output<Poses>("poses").poses) EXPECT_TRUE(pose->covariance.empty()) << pose->path;
    EXPECT_TRUE(node.output<Camera>("camera").covariance.empty());
  }
  static const PointT& find(const PointsT& points, const std::string& id) {
    for (const auto& point : points.points)
      if (point->id == id) return *point;
    throw std::runtime_error("no point " + id);
  }
};

TEST_P(Adjuster, RecoversTheTruthWithoutNoise) {
  SyntheticFacade facade = make_facade({.floors = 1, .survey_sigma = 0.0});
  // Exact control still needs a standard deviation: 0.1 mm.
  for (size_t i = 0; i < 3 * facade.control.points.size(); ++i)
    for (size_t j = 0; j <= i; ++j) facade.control.covariance.push_back(i == j ? 1e-8 : 0.0);
  for (auto& point : facade.control.points) point->sigma.setConstant(1e-4);
  const PointsT points = adjusted(facade);
  for (const auto& truth : facade.truth.points)
    EXPECT_LT((find(points, truth->id).position - truth->position).norm(), 2e-6) << truth->id;
}

TEST_P(Adjuster, ItsCovarianceCoversItsErrors) {
  // Normalised squared error of all coordinates: its mean over the trials must be near their number.
  if (gives_no_covariance(GetParam())) return expect_no_standard_deviation();
  double sum = 0;
  const int trials = 6;
  size_t coordinates = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const SyntheticFacade facade = make_facade(
        {.floors = 1, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 100u + static_cast<uint64_t>(trial)});
    const PointsT points = adjusted(facade);
    coordinates = 3 * points.points.size();
    ASSERT_EQ(points.covariance.size(), coordinates * (coordinates + 1) / 2);
    Eigen::MatrixXd covariance(coordinates, coordinates);
    Eigen::VectorXd error(coordinates);
    for (size_t i = 0, k = 0; i < coordinates; ++i)
      for (size_t j = 0; j <= i; ++j, ++k) covariance(i, j) = covariance(j, i) = points.covariance[k];
    for (size_t i = 0; i < points.points.size(); ++i)
      error.segment<3>(3 * i) = points.points[i]->position - find(facade.truth, points.points[i]->id).position;
    sum += error.dot(covariance.ldlt().solve(error));
  }
  // chi-squared with trials * coordinates degrees of freedom, four standard deviations.
  const double expected = static_cast<double>(trials) * static_cast<double>(coordinates);
  EXPECT_NEAR(sum, expected, 4 * std::sqrt(2 * expected));
}

Eigen::MatrixXd unpacked(const std::vector<double>& packed, Eigen::Index n) {
  Eigen::MatrixXd c(n, n);
  size_t k = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j <= i; ++j, ++k) c(i, j) = c(j, i) = packed.at(k);
  return c;
}

/// Every standard deviation and correlation of poses and interior orientation is in these normalised squared errors;
/// 200 trials with PLUMBLINE_LONG.
TEST_P(Adjuster, CovariancesOfPosesAndCameraCoverTheirErrors) {
  if (gives_no_covariance(GetParam())) return expect_no_standard_deviation();
  const int trials = std::getenv("PLUMBLINE_LONG") ? 200 : 8;
  const std::vector<double> prior = {2, 2, 2, 2, 1e-3, 1e-3, 0, 0, 0};  // of the calibration; 0 is held
  double of_poses = 0, of_first_pose = 0, of_camera = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const SyntheticFacade facade = make_facade(
        {.floors = 1, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 500u + static_cast<uint64_t>(trial)});
    CameraT given = facade.camera_artifact();
    Random random(9000 + static_cast<uint64_t>(trial));
    for (size_t i = 0; i < prior.size(); ++i) {
      given.parameters[i] += prior[i] * random.normal();
      for (size_t j = 0; j <= i; ++j) given.covariance.push_back(i == j ? prior[i] * prior[i] : 0);
    }
    NodeHarness node(GetParam());
    node.input<Camera>("camera", given);
    node.input<Plates>("plates", facade.plates);
    node.input<Poses>("poses", facade.poses);
    for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
    node.input<Points>("control", facade.control);
    node.run();
    const PosesT poses = node.output<Poses>("poses");
    ASSERT_EQ(poses.poses.size(), facade.poses.poses.size());
    for (size_t i = 0; i < poses.poses.size(); ++i) {
      const RigidTransform &found = poses.poses[i]->cam_from_world, &truth = facade.poses.poses[i]->cam_from_world;
      const Eigen::AngleAxisd turn(found.rotation * truth.rotation.conjugate());
      Eigen::Matrix<double, 6, 1> error;
      error << turn.angle() * turn.axis(), found.translation - truth.translation;
      const double square = error.dot(unpacked(poses.poses[i]->covariance, 6).ldlt().solve(error));
      of_poses += square / static_cast<double>(poses.poses.size());
      if (i == 0) of_first_pose += square;
    }
    const CameraT camera = node.output<Camera>("camera");
    const Eigen::MatrixXd covariance = unpacked(camera.covariance, 9);
    std::vector<int> free;
    Eigen::VectorXd error(9);
    for (int i = 0; i < 9; ++i) {
      error(i) = camera.parameters[i] - facade.camera.parameters()[i];
      if (covariance(i, i) > 0) free.push_back(i);
    }
    ASSERT_EQ(free.size(), 6u);
    of_camera += Eigen::VectorXd(error(free)).dot(Eigen::MatrixXd(covariance(free, free)).ldlt().solve(error(free)));
  }
  // Chi-squared with 6 degrees of freedom a trial; the mean over the poses of a trial scatters no more than one of
  // them.
  const double expected = 6.0 * trials, slack = 4 * std::sqrt(2 * expected);
  EXPECT_NEAR(of_poses, expected, slack);
  EXPECT_NEAR(of_first_pose, expected, slack);
  EXPECT_NEAR(of_camera, expected, slack);
}

TEST_P(Adjuster, IsEquivariantUnderAChangeOfFrame) {
  FacadeOptions options{.floors = 1, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 5};
  const PointsT plain = adjusted(make_facade(options));
  options.world_from_facade = {quaternion_from_rotation_vector({0, 0, 0.7}), {100, 200, 30}};
  SyntheticFacade moved = make_facade(options);
  for (size_t i = 0; i < moved.control.points.size(); ++i) {  // the same noise, moved along
    const SyntheticFacade original = make_facade({.floors = 1, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 5});
    moved.control.points[i]->position = options.world_from_facade * original.control.points[i]->position;
  }
  const PointsT turned = adjusted(moved);
  for (const auto& point : plain.points)
    EXPECT_LT((find(turned, point->id).position - options.world_from_facade * point->position).norm(), 1e-6);
}

TEST_P(Adjuster, GivesTheSameBitsTwice) {
  const SyntheticFacade facade = make_facade({.floors = 1, .pixel_sigma = 0.1, .survey_sigma = 0.001});
  NodeHarness a = prepared(facade), b = prepared(facade);
  a.run();
  b.run();
  EXPECT_EQ(a.output_bytes("points"), b.output_bytes("points"));
}

TEST_P(Adjuster, NamesTheDefectOfASingleControlColumn) {
  SyntheticFacade facade = make_facade({.floors = 2, .pixel_sigma = 0.1, .survey_sigma = 0.001});
  for (auto& plate : facade.plates.plates)
    if (plate->column != 2) plate->role = "check";
  NodeHarness node = prepared(facade);
  try {
    node.run();
    FAIL() << "control on one vertical line was accepted: the block can turn about it";
  } catch (const NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find("rotation about"), std::string::npos) << error.what();
  }
}

TEST_P(Adjuster, EveryParameterHasItsEffect) {
  SyntheticFacade facade = make_facade({.floors = 1, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 7});
  for (auto& corner : facade.images[1].tags[1]->corners) corner += Eigen::Vector2d(3.0, -4.0);
  for (auto& tag : facade.images[0].tags) tag->corner_covariances.clear();
  // Control in one column, of which the points lie 2 cm off a line.
  SyntheticFacade weak = make_facade({.floors = 2, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 8});
  weak.control.covariance.clear();
  std::erase_if(weak.control.points, [](const auto& p) { return p->id.find("C01") == std::string::npos; });
  SyntheticFacade wrong = make_facade({.floors = 2, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 9});
  wrong.control.points[2]->position.z() += 0.05;
  const auto with = [](const SyntheticFacade& of, const std::map<std::string, std::string>& settings) {
    return [&of, settings] {
      NodeHarness node = prepared(of);
      for (const auto& [name, value] : settings)
        if (node.has_parameter(name, value)) node.set(name, value);
      return node;
    };
  };
  // Threads change no bit, and what is for targets nothing where there are tags only.
  EXPECT_EQ(parameters_at_fault({with(facade, {}), with(facade, {{"weighting", "lambda"}}),
                                 with(facade, {{"self_calibration", "free"}}), with(weak, {}), with(wrong, {})},
                                {"threads", "image_sigma", "free", "free_datum", "principal_point_sigma"}),
            "");
}

TEST_P(Adjuster, StopsWhereverItAsks) {
  const SyntheticFacade facade = make_facade({.floors = 1, .pixel_sigma = 0.1, .survey_sigma = 0.001, .seed = 7});
  EXPECT_EQ(stopping_at_fault([&] { return prepared(facade); }), "");
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Adjuster);
INSTANTIATE_TEST_SUITE_P(Role, Adjuster, testing::ValuesIn(kinds_of_role("adjuster")), test_name);

}  // namespace adjuster_tests

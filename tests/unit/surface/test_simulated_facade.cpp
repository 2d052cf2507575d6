// simulate.facade: orientations err as their joint covariance says, and panels hang as far off as was asked.
#include <cmath>

#include "artifacts/camera.hpp"
#include "artifacts/design.hpp"
#include "artifacts/poses.hpp"
#include "artifacts/surfaces.hpp"
#include "geometry/packed_symmetric.hpp"
#include "node_harness.hpp"

namespace test_simulated_facade {

using namespace plumbline;
using namespace plumbline::test;

using Settings = std::vector<std::pair<std::string, std::string>>;

/// As few and as small photographs as there may be.
NodeHarness site(const Settings& settings, std::uint64_t seed = 1) {
  NodeHarness node("simulate.facade");
  for (const auto& [name, value] : Settings{{"columns", "2"},
                                            {"rows", "1"},
                                            {"photographs", "2"},
                                            {"width", "200"},
                                            {"height", "200"},
                                            {"panel_width", "0.5"},
                                            {"panel_height", "0.4"}})
    node.set(name, value);
  for (const auto& [name, value] : settings) node.set(name, value);
  node.seed(seed), node.run();
  return node;
}

TEST(SimulatedFacade, OrientationsErrAsTheirJointCovarianceSays) {
  const Settings errors = {{"rotation_sigma", "0.002"}, {"centre_sigma", "0.003"}, {"common_sigma", "0.008"}};
  const PosesT exact =
      site({{"rotation_sigma", "0"}, {"centre_sigma", "0"}, {"common_sigma", "0"}}).output<Poses>("poses");
  constexpr int kTrials = 40;
  double sum = 0, alone = 0;
  for (int seed = 1; seed <= kTrials; ++seed) {
    const PosesT poses = site(errors, static_cast<std::uint64_t>(seed)).output<Poses>("poses");
    const Eigen::MatrixXd all = unpack_symmetric(poses.joint_covariance, 25, "test");  // two poses, one camera
    Eigen::VectorXd off(12);
    std::vector<Eigen::Index> rows;
    for (Eigen::Index k = 0; k < 2; ++k) {
      const RigidTransform& found = poses.poses[k]->cam_from_world;
      const RigidTransform& truth = exact.poses[k]->cam_from_world;
      const Eigen::AngleAxisd turn(found.rotation * truth.rotation.conjugate());
      off.segment<3>(6 * k) = turn.angle() * turn.axis();
      off.segment<3>(6 * k + 3) = found.translation - truth.translation;
      for (Eigen::Index i = 0; i < 6; ++i) rows.push_back(8 * k + i);
      const Eigen::MatrixXd own = unpack_symmetric(poses.poses[k]->covariance, 6, "test");
      alone += off.segment<6>(6 * k).dot(own.ldlt().solve(off.segment<6>(6 * k)));
    }
    const Eigen::MatrixXd joint = all(rows, rows);
    sum += off.dot(joint.ldlt().solve(off));
  }
  // Chi-square of 480 degrees of freedom over them: 99.9 %.
  EXPECT_NEAR(sum / (12 * kTrials), 1, 0.21);
  EXPECT_NEAR(alone / (12 * kTrials), 1, 0.3);
}

TEST(SimulatedFacade, PanelsHangAsFarOffAsWasAsked) {
  // One of them alone is not none: the others' figures stay what they are.
  const auto of = [](const Settings& settings) {
    Settings all = {{"offset_sigma", "0"}, {"tilt_sigma", "0"}, {"bow_sigma", "0"},    {"place_sigma", "0"},
                    {"columns", "20"},     {"rows", "10"},      {"panel_width", "0.5"}};
    all.insert(all.end(), settings.begin(), settings.end());
    const NodeHarness node = site(all);
    const SurfacesT planted = node.output<Surfaces>("planted");
    const DesignT design = node.output<Design>("design");
    EXPECT_EQ(planted.panels.size(), 200u);
    double offset = 0, tilt = 0, bow = 0, place = 0;
    for (size_t i = 0; i < planted.panels.size(); ++i) {
      const auto& panel = *planted.panels[i];
      offset += panel.offset * panel.offset / 200;
      tilt += panel.tilt.squaredNorm() / 400, bow += panel.form.head<2>().squaredNorm() / 400;
      place += (panel.face->origin - design.elements[i]->position).squaredNorm() / 400;
    }
    return std::array{std::sqrt(offset), std::sqrt(tilt), std::sqrt(bow), std::sqrt(place)};
  };
  const std::array<const char*, 4> names = {"offset_sigma", "tilt_sigma", "bow_sigma", "place_sigma"};
  for (size_t k = 0; k < 4; ++k) {
    const auto found = of({{names[k], "0.002"}});
    for (size_t other = 0; other < 4; ++other)
      EXPECT_NEAR(found[other], other == k ? 0.002 : 0, other == k ? 0.0004 : 1e-9) << names[k] << " " << names[other];
  }
}

/// Around the corner of a block: panels and photographs of their own, joints on one facade only, and no photograph that
/// could see the next.
TEST(SimulatedFacade, ABlockHasSeveral) {
  const NodeHarness node = site({{"facades", "3"}});
  const SurfacesT planted = node.output<Surfaces>("planted");
  const DesignT design = node.output<Design>("design");
  const PosesT poses = node.output<Poses>("poses");
  ASSERT_EQ(planted.panels.size(), 6U);
  ASSERT_EQ(design.elements.size(), 6U);
  ASSERT_EQ(poses.poses.size(), 6U);
  ASSERT_EQ(planted.joints.size(), 3U);
  EXPECT_EQ(planted.joints[2]->first_panel, 4);
  EXPECT_EQ(design.elements[2]->name, "F2-P01-01");
  for (size_t facade = 0; facade < 3; ++facade) {
    const SurfaceFaceT& face = *planted.panels[2 * facade]->face;
    EXPECT_NEAR(face.out.dot(planted.panels[0]->face->out), facade == 0 ? 1 : facade == 1 ? 0 : -1, 1e-12);
    EXPECT_NEAR((face.origin - design.elements[2 * facade]->position).dot(face.out), 0, 1e-9);
    const double right = face.out.dot(planted.panels[0]->face->right);
    EXPECT_NEAR(right, facade == 1 ? 1 : 0, 1e-12) << "the next one is to the right";
    for (size_t k = 0; k < 6; ++k) {
      const Eigen::Vector3d centre = poses.poses[k]->cam_from_world.inverse().translation;
      EXPECT_EQ((centre - face.origin).dot(face.out) > 0, k / 2 == facade) << "photograph " << k;
    }
  }
}

}  // namespace test_simulated_facade

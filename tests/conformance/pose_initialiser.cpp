// What every pose initialiser must do.
#include "node_harness.hpp"
#include "parameter_effects.hpp"
#include "stopping.hpp"
#include "synthetic_facade.hpp"

namespace pose_initialiser_tests {

using namespace plumbline;
using namespace plumbline::test;

class PoseInitialiser : public testing::TestWithParam<std::string> {
 protected:
  static NodeHarness prepared(const SyntheticFacade& facade) {
    NodeHarness node(GetParam());
    node.input<Camera>("camera", facade.camera_artifact());
    node.input<Plates>("plates", facade.plates);
    node.input<Points>("points", facade.truth);
    for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
    return node;
  }
  /// Largest distance of a projection centre from its true place [m].
  static double worst_centre(const PosesT& found, const SyntheticFacade& facade) {
    double worst = found.poses.size() == facade.poses.poses.size() ? 0 : 1e9;
    for (size_t i = 0; i < std::min(found.poses.size(), facade.poses.poses.size()); ++i)
      worst = std::max(worst, (found.poses[i]->cam_from_world.inverse().translation -
                               facade.poses.poses[i]->cam_from_world.inverse().translation)
                                  .norm());
    return worst;
  }
};

TEST_P(PoseInitialiser, FindsThePosesWellEnoughForAnAdjustment) {
  const SyntheticFacade facade = make_facade({.floors = 1});
  NodeHarness node = prepared(facade);
  node.run();
  // The plates are turned by degrees against their nominal rotation, so a centimetre or two is all that can be asked.
  EXPECT_LT(worst_centre(node.output<Poses>("poses"), facade), 0.05);
}

TEST_P(PoseInitialiser, SurvivesAThirdOfWrongCorrespondences) {
  SyntheticFacade facade = make_facade({.floors = 1, .pixel_sigma = 0.1});
  for (ImageTagsT& image : facade.images)
    for (size_t i = 0; i + 2 < image.tags.size(); i += 3)
      for (auto& corner : image.tags[i]->corners) corner += Eigen::Vector2d(431.0, -377.0);
  NodeHarness node = prepared(facade);
  node.run();
  EXPECT_LT(worst_centre(node.output<Poses>("poses"), facade), 0.05);
}

TEST_P(PoseInitialiser, GivesTheSameBitsTwice) {
  const SyntheticFacade facade = make_facade({.floors = 1, .pixel_sigma = 0.2});
  NodeHarness a = prepared(facade), b = prepared(facade);
  a.run();
  b.run();
  EXPECT_EQ(a.output_bytes("poses"), b.output_bytes("poses"));
}

TEST_P(PoseInitialiser, NamesAnImageWithTooFewMarkers) {
  SyntheticFacade facade = make_facade({.floors = 1});
  facade.images[2].tags.resize(2);
  NodeHarness node = prepared(facade);
  try {
    node.run();
    FAIL() << "an image with two markers was accepted";
  } catch (const NodeFailed& error) {
    EXPECT_NE(std::string(error.what()).find(facade.images[2].path), std::string::npos) << error.what();
  }
}

TEST_P(PoseInitialiser, EveryParameterHasItsEffect) {
  // Seven tags in two images, three of them wrong, and no sigmas in the second.
  SyntheticFacade facade = make_facade({.floors = 1, .pixel_sigma = 0.3});
  facade.images.resize(2);
  for (ImageTagsT& image : facade.images) {
    image.tags.resize(7);
    for (size_t i = 0; i < 3; ++i)
      for (auto& corner : image.tags[2 * i]->corners) corner += Eigen::Vector2d(431.0, -377.0) * (1.0 + double(i));
  }
  for (auto& tag : facade.images[1].tags) tag->corner_covariances.clear();
  SyntheticFacade poor = make_facade({.floors = 1, .pixel_sigma = 0.3});
  poor.images.resize(2);
  poor.images[1].tags.resize(2);
  SyntheticFacade mistaken = make_facade({.floors = 1, .pixel_sigma = 0.3});  // tags are half as large as said
  mistaken.images.resize(2);
  for (auto& plate : mistaken.plates.plates) plate->tag_size *= 2;
  EXPECT_EQ(parameters_at_fault(
                {[&] { return prepared(facade); }, [&] { return prepared(poor); }, [&] { return prepared(mistaken); }}),
            "");
}

TEST_P(PoseInitialiser, StopsWhereverItAsks) {
  const SyntheticFacade facade = make_facade({.floors = 1, .pixel_sigma = 0.2});
  EXPECT_EQ(stopping_at_fault([&] { return prepared(facade); }), "");
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(PoseInitialiser);
INSTANTIATE_TEST_SUITE_P(Role, PoseInitialiser, testing::ValuesIn(kinds_of_role("pose_initialiser")), test_name);

}  // namespace pose_initialiser_tests

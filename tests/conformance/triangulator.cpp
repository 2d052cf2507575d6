// What every triangulator must do.
#include "node_harness.hpp"
#include "synthetic_facade.hpp"

namespace triangulator_tests {

using namespace plumbline;
using namespace plumbline::test;

class Triangulator : public testing::TestWithParam<std::string> {
 protected:
  static NodeHarness prepared(const SyntheticFacade& facade) {
    NodeHarness node(GetParam());
    node.input<Camera>("camera", facade.camera_artifact());
    node.input<Plates>("plates", facade.plates);
    node.input<Poses>("poses", facade.poses);
    for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
    return node;
  }
  static PointsT placed(const SyntheticFacade& facade) {
    NodeHarness node = prepared(facade);
    node.run();
    return node.output<Points>("points");
  }
  static double worst(const PointsT& found, const PointsT& truth) {
    double result = 0;
    for (const auto& point : found.points)
      for (const auto& other : truth.points)
        if (other->id == point->id) result = std::max(result, (point->position - other->position).norm());
    return result;
  }
};

TEST_P(Triangulator, FindsAllAnchorsOfExactImages) {
  const SyntheticFacade facade = make_facade({.floors = 1});
  const PointsT points = placed(facade);
  EXPECT_EQ(points.points.size(), facade.truth.points.size());
  EXPECT_LT(worst(points, facade.truth), 1e-8);
}

TEST_P(Triangulator, IsEquivariantUnderAChangeOfFrame) {
  FacadeOptions options{.floors = 1, .pixel_sigma = 0.2, .seed = 4};
  const PointsT plain = placed(make_facade(options));
  options.world_from_facade = {quaternion_from_rotation_vector({0.2, -0.1, 0.7}), {100, 200, 30}};
  PointsT turned = placed(make_facade(options));
  for (auto& point : turned.points) point->position = options.world_from_facade.inverse() * point->position;
  EXPECT_LT(worst(turned, plain), 1e-7);
}

TEST_P(Triangulator, TakesNoiseAsFewMillimetres) {
  const SyntheticFacade facade = make_facade({.floors = 1, .pixel_sigma = 0.2});
  EXPECT_LT(worst(placed(facade), facade.truth), 0.003);
}

TEST_P(Triangulator, LeavesOutWhatOneImageSees) {
  SyntheticFacade facade = make_facade({.floors = 1});
  const int tag = facade.plates.plates[0]->tag_id;
  bool first = true;
  for (ImageTagsT& image : facade.images)
    std::erase_if(image.tags, [&](const auto& t) { return t->id == tag && !std::exchange(first, false); });
  const PointsT points = placed(facade);
  EXPECT_EQ(points.points.size(), facade.truth.points.size() - 1);
  for (const auto& point : points.points) EXPECT_NE(point->id, facade.plates.plates[0]->anchor);
}

TEST_P(Triangulator, GivesTheSameBitsTwice) {
  const SyntheticFacade facade = make_facade({.floors = 1, .pixel_sigma = 0.2});
  NodeHarness a = prepared(facade), b = prepared(facade);
  a.run();
  b.run();
  EXPECT_EQ(a.output_bytes("points"), b.output_bytes("points"));
}

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(Triangulator);
INSTANTIATE_TEST_SUITE_P(Role, Triangulator, testing::ValuesIn(kinds_of_role("triangulator")), test_name);

}  // namespace triangulator_tests

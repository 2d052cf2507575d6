// The adjusters as they come: what a detector does to edges must not become the length of a free network.
#include <gtest/gtest.h>

#include "artifacts/camera.hpp"
#include "artifacts/points.hpp"
#include "node_harness.hpp"
#include "synthetic_facade.hpp"

namespace plumbline::test {
namespace test_inset_node {

/// Every edge of a tag `inset` px towards its middle, as a transfer curve and a sharpened photograph move it.
void draw_inwards(SyntheticFacade& facade, double inset) {
  for (ImageTagsT& image : facade.images)
    for (const auto& tag : image.tags) {
      auto& c = tag->corners;
      const Eigen::Vector2d middle = 0.25 * (c[0] + c[1] + c[2] + c[3]);
      const double side =
          0.25 * ((c[1] - c[0]).norm() + (c[2] - c[1]).norm() + (c[3] - c[2]).norm() + (c[0] - c[3]).norm());
      for (auto& corner : c) corner = middle + (corner - middle) * (1 - 2 * inset / side);
    }
}

const PointT& point_called(const PointsT& points, const std::string& id) {
  for (const auto& point : points.points)
    if (point->id == id) return *point;
  throw std::runtime_error("no point " + id);
}

/// Error of a free network's length across the facade, relative.
double error_of_length(NodeHarness& node, const SyntheticFacade& facade) {
  node.input<Camera>("camera", facade.camera_artifact());
  node.input<Plates>("plates", facade.plates);
  node.input<Poses>("poses", facade.poses);
  for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
  node.run();
  const PointsT found = node.output<Points>("points");
  const auto length = [](const PointsT& points) {
    return (point_called(points, "F01-C01-R1").position - point_called(points, "F02-C04-R2").position).norm();
  };
  return length(found) / length(facade.truth) - 1;
}

class Inset : public testing::TestWithParam<std::string> {};

TEST_P(Inset, DoesNotShrinkAFreeNetwork) {
  SyntheticFacade facade = make_facade({.floors = 2, .pixel_sigma = 0.1});
  draw_inwards(facade, 0.8);
  NodeHarness as_it_comes(GetParam()), without(GetParam());
  without.set("corner_inset_sigma", "0");
  const double error = error_of_length(as_it_comes, facade);
  EXPECT_LT(std::abs(error), 3e-3) << "three times the prior of the tags' size";
  EXPECT_GT(std::abs(error_of_length(without, facade)), 2 * std::abs(error)) << "the facade would not show it";
}

INSTANTIATE_TEST_SUITE_P(Adjusters, Inset, testing::Values("adjust.schur", "adjust.ceres"));

}  // namespace test_inset_node
}  // namespace plumbline::test

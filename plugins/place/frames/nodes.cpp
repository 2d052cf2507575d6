// Nodes that say what frame coordinates belong to.
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "place/frames/graph_node.hpp"
#include "place/frames/to_building.hpp"
#include "plumbline/node.hpp"

namespace {

using namespace plumbline;

/// A free adjustment needs approximate coordinates but must not claim their frame. Here they are moved to their own
/// centroid and called `block`; only a registration leads back to a surveyed frame, and the graph checks that one
/// stands in between.
struct LocalBlock : Node {
  static constexpr Info info{
      "frame.block", "", 1,
      "Takes coordinates as mere approximations of a local block frame with its origin in their centroid"};
  In<Points> points{"points", frame("frame=?S"), "coordinates in some frame"};
  In<Plates> plates{"plates", frame("frame=?S"), "plates with nominal rotations in that frame"};
  Out<Points> block_points{"points", frame("frame=block"), "the same figure about its centroid, without covariance"};
  Out<Plates> block_plates{"plates", frame("frame=block"),
                           "the plates with their nominal rotations in the block frame"};

  void run(Context&) override {
    PointsT result = points.unpack();
    if (result.points.empty()) throw std::runtime_error("'points' holds no point; a block needs at least three");
    Eigen::Vector3d centroid = Eigen::Vector3d::Zero();
    for (const auto& point : result.points) centroid += point->position / static_cast<double>(result.points.size());
    for (auto& point : result.points) {
      point->position -= centroid;
      point->sigma.setConstant(std::nan(""));
    }
    result.covariance.clear();
    result.statistics.reset();
    block_points.commit(result);
    block_plates.commit(plates.unpack());
  }
};

}  // namespace

PLUMBLINE_PLUGIN("frames", PLUMBLINE_BUILD_ID, "MIT", LocalBlock, frames::ToBuilding, frames::FramesGraph)

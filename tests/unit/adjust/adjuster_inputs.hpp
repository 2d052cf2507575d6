// What tests of adjusting nodes share: a facade for their ports, and why one failed.
#pragma once

#include <string>

#include "node_harness.hpp"
#include "synthetic_facade.hpp"

namespace plumbline::test {

inline const FacadeOptions noisy{.floors = 1, .pixel_sigma = 0.1, .survey_sigma = 0.001};

inline void connect(NodeHarness& node, const SyntheticFacade& facade, bool with_control = true) {
  node.input<Camera>("camera", facade.camera_artifact());
  node.input<Plates>("plates", facade.plates);
  node.input<Poses>("poses", facade.poses);
  for (const ImageTagsT& image : facade.images) node.input<ImageTags>("observations", image);
  if (with_control) node.input<Points>("control", facade.control);
}

inline std::string failure(NodeHarness& node) {
  try {
    node.run();
  } catch (const NodeFailed& error) {
    return error.what();
  }
  return {};
}

}  // namespace plumbline::test

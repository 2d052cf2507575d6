// A facade of panels: where each really hangs, what it looks like, and photographs of it by rays.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "geometry/camera.hpp"
#include "plumbline/rigid_transform.hpp"

namespace plumbline::simulate {

enum class Skin : std::uint8_t { plaster, plain, glass };
const char* to_string(Skin skin);

/// A panel on the facade's plane: u to the right, v up, heights out of it [m].
struct RaisedPanel {
  std::string id;
  double u = 0, v = 0, width = 0, height = 0;  ///< middle and size as built
  double offset = 0, tilt_u = 0, tilt_v = 0;   ///< of its best plane at the middle
  double bow_u = 0, bow_v = 0;                 ///< the middle over the edges
  Skin skin = Skin::plaster;
  std::uint64_t grain = 0;  ///< seed of its texture
  /// Height at a place of the facade.
  double at(double place_u, double place_v) const;
};

struct PanelledFacade {
  RigidTransform world_from_facade;  ///< axes right, up, out
  std::vector<RaisedPanel> panels;
  double recess = 0.03;   ///< of the joints' ground behind the design's face [m]
  double finest = 0.002;  ///< of the texture [m]
};

struct Exposure {
  double noise = 1.5;     ///< grey values
  int supersampling = 3;  ///< rays across a pixel, each way
  std::uint64_t seed = 1;
};

/// Grey values row by row. Glass shows a world of its own that lies `mirrored` behind it, so that photographs disagree.
/// Same input, same bits on any number of threads.
std::vector<std::uint8_t> photograph(const PanelledFacade& facade, const BrownCamera& camera,
                                     const RigidTransform& cam_from_world, const Exposure& exposure);

/// An 8-bit grey PNG. Throws std::runtime_error if it cannot be written.
void write_png(const std::string& path, int width, int height, const std::vector<std::uint8_t>& grey);

}  // namespace plumbline::simulate

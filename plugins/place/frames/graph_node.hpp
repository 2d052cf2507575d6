// frames.graph: all frames of a site, the ways between them, and points in every one of them.
#pragma once

#include "artifacts/design.hpp"
#include "artifacts/file.hpp"
#include "artifacts/points.hpp"
#include "artifacts/site_frames.hpp"
#include "artifacts/transform.hpp"
#include "plumbline/node.hpp"

namespace plumbline::frames {

struct FramesGraph : Node {
  static constexpr Info info{"frames.graph", "", 1,
                             "Gathers the frames of a site and the transforms between them, with covariance and "
                             "origin, and gives points in every frame"};
  In<Transform> survey{"survey", frame("to=building,from=?S"), "from the frame of the survey"};
  Optional<Transform> registration{"registration", frame("to=building,from=?B"),
                                   "from the block's own frame, where it was adjusted freely"};
  Optional<Design> design{"design", frame("frame=building"), "the design, for its map conversion"};
  Optional<Points> points{"points", frame("frame=building"), "points that are given in every frame"};
  Out<SiteFrames> frames{"frames", "the transforms"};
  Out<File> coordinates{"coordinates", "CSV: id,frame,x,y,z,sigma_x,sigma_y,sigma_z [m]"};

  void run(Context& context) override;
};

}  // namespace plumbline::frames

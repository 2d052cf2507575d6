// Points of surfaces as a file for programs of others.
#pragma once

#include "artifacts/folder.hpp"
#include "artifacts/surface_points.hpp"
#include "plumbline/node.hpp"

namespace plumbline::surface {

struct WriteCloud : Node {
  static constexpr Info info{"write.cloud", "", 1, "Writes points of surfaces as a LAS or PLY cloud"};
  In<SurfacePoints> surface{"surface", frame("frame=?F"), "the points"};
  Param<std::string> format{
      "format", "las", one_of("las", "ply"),
      "LAS 1.4 in steps of 0.1 mm, or binary PLY; both with the standard deviation of each point"};
  Param<std::string> frame_name{
      "frame", "",
      "name of the frame that the points are in, as their files shall say it ('survey', 'scan'); empty: they say that "
      "it is not stated"};
  Out<Folder> folder{"folder", "points.las or points.ply; metres"};

  void run(Context& context) override;
};

}  // namespace plumbline::surface

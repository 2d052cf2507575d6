// Planes of a scan of which there is no design.
#pragma once

#include "artifacts/design.hpp"
#include "artifacts/file.hpp"
#include "plumbline/node.hpp"

namespace plumbline::surface {

struct FindPlanes : Node {
  static constexpr Info info{
      "surface.planes", "", 1,
      "Finds planes in a point cloud without a design: as the panels of a design they are measured like any other"};
  Param<FilePath> file{"file", required, "the cloud: .ply, .las, .e57, .pts, .xyz, recognised by its content"};
  Param<std::string> unit{"unit", "from_file", one_of("from_file", "m", "cm", "mm", "ft", "us_ft"),
                          "of the file's coordinates; from_file: what the file says, metres if it says nothing"};
  Param<std::vector<double>> seen_from{
      "seen_from", std::vector<double>{}, "m", between(-1e9, 1e9),
      "x, y, z of the scanner's stations, one after the other: the outside of a plane is where they stood"};
  Param<double> cell{"cell", 0.1, "m", between(0.005, 5), "edge of the cells that points are summed in"};
  Param<double> roughness{"roughness", 0.006, "m", between(1e-5, 1),
                          "of the points of a cell and its neighbours about their plane, rms: noise and relief"};
  Param<double> angle{"angle", 0.09, "rad", between(0.001, 0.8), "of a cell's plane to the plane it belongs to"};
  Param<double> least_area{"least_area", 1.0, "m²", between(1e-4, 1e6), "a smaller plane is left out"};
  Param<double> memory{"memory", 1.5, "GiB", between(0.05, 64), "for the cells; a cloud that takes more is refused"};
  Out<Design> design{"design", frame("frame=scan"), "the planes as panels, S001 the largest"};
  Out<File> table{"table", "one line a plane, CSV"};

  void run(Context& context) override;
};

}  // namespace plumbline::surface

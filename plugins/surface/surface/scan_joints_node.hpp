// Joints between panels from the borders that a scan shows.
#pragma once

#include "artifacts/file.hpp"
#include "artifacts/surface_points.hpp"
#include "artifacts/surfaces.hpp"
#include "plumbline/node.hpp"

namespace plumbline::surface {

struct ScanJoints : Node {
  static constexpr Info info{"surface.scan_joints", "", 6,
                             "Width and flush step along the joints between panels, from where a scan's points end"};
  In<SurfacePoints> points{"points", frame("frame=?F"), "the scan's points on the faces, and beside them"};
  In<Surfaces> panels{"panels", frame("frame=?F"), "the panels, measured in the same points"};
  Param<double> station{"station", 0.05, "m", between(0.002, 1), "length along a joint of which points count together"};
  Param<double> widest{
      "widest", 0.15, "m", between(0.001, 0.5),
      "wider joints of the design are not measured; up to 0.15 m they are named as not measured, up to "
      "0.5 m a warning says that there is a gap"};
  Param<double> search{"search", 0.012, "m", between(0.001, 0.2),
                       "how far an edge may be from where the design has it; 'beside' of dense.import has to reach it"};
  Param<double> beam{"beam", 0.006, "m", between(0, 0.2),
                     "diameter of the scanner's beam on the panels: by half of it an edge may seem further out or in, "
                     "all edges alike"};
  Out<Surfaces> surfaces{"surfaces", frame("frame=?F"), "panels and joints"};
  Out<File> table{"table", "one line a joint, CSV"};

  void run(Context& context) override;
};

}  // namespace plumbline::surface

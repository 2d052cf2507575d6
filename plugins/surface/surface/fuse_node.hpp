// Several clouds of the same faces as one surface.
#pragma once

#include "artifacts/folder.hpp"
#include "panels_node.hpp"
#include "surface/dense/fuse.hpp"

namespace plumbline::surface {

struct Fuse : Node {
  static constexpr Info info{"surface.fuse", "", 2,
                             "Brings points of the same faces from several sources together: what they agree on, with "
                             "random and systematic errors apart; what they contradict each other on is a hole"};
  List<SurfacePoints> surfaces{"surfaces", frame("frame=?F"),
                               "points of the same faces: of other kinds of depth, other photographs, scans"};
  Param<double> cell{"cell", 0.05, "m", between(0.002, 1), "edge of the parts that sources are compared on"};
  Param<double> reach{"reach", 0.1, "m", between(0.001, 2), "points further from a face are not taken"};
  Param<double> agreement{"agreement", 4.0, "1", between(1, 20), "standard deviations that sources may differ by"};
  Param<int64_t> least_points{"least_points", 3, between(1, 1000), "of a source in a part; fewer are left out"};
  Param<bool> may_share_errors{
      "may_share_errors", true,
      "sources may have errors in common, such as two kinds of depth from the same photographs: standard deviations "
      "are "
      "enlarged by the root of their number, as nobody knows how they are correlated; false: they are independent"};
  Out<SurfacePoints> surface{"surface", frame("frame=?F"), "the points"};
  Out<Folder> files{"files", "where they lie"};

  void run(Context& context) override;
};

}  // namespace plumbline::surface

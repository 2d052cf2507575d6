// Points of one face from several sources (blocks of photographs, kinds of depth, scans) as one surface: what they
// agree on is kept, each point with its source's own errors, and what they contradict each other on is a hole.
#pragma once

#include <vector>

#include "surface/dense/panel_surface.hpp"

namespace plumbline::surface {

struct FuseOptions {
  double cell = 0.05;    ///< edge of the parts of a face that sources are compared on [m]
  double agreement = 4;  ///< standard deviations by which two sources may differ there
  int least_points = 3;  ///< of a source in a cell: fewer are neither compared nor kept
  /// Sources may share errors, such as two kinds of depth from the same photographs: nothing is known of their
  /// correlation then, and both parts of every source's covariance are made as many times larger as there are sources.
  /// Of a mean of k sources that is what it is if all their errors are alike (covariance intersection with equal
  /// weights; Julier and Uhlmann 1997), and never too small.
  bool may_share_errors = true;
};

/// Cells of a face by what became of them.
struct FuseCounts {
  int agreed = 0;        ///< several sources, most of which agree
  int alone = 0;         ///< one source
  int contradicted = 0;  ///< several, and no most of them agree: a hole
  int empty = 0;
};

struct FusedFace {
  std::vector<MeasuredTile> tiles;  ///< of the sources, with the columns of all of them side by side
  FuseCounts counts;
};

/// Of `faces` the one of number `which`. `sources`: the tiles that hold points of the face, source by source; points
/// beside the face are left out, and so are those that lie nearer to another of the faces, which has them: where faces
/// overlap each point is one face's, of two alike the first's. `ranks`: of each source's systematic part, which is 0
/// where none is known. Throws std::invalid_argument for a factor of another rank.
FusedFace fuse_face(const std::vector<PanelFace>& faces, size_t which,
                    const std::vector<std::vector<MeasuredTile>>& sources, const std::vector<int>& ranks, double reach,
                    const FuseOptions& options);

}  // namespace plumbline::surface

// Whether a scan could lie some panels further: on a facade of equal panels, or storeys, it looks the same there.
#pragma once

#include <string>
#include <vector>

#include "surface/dense/scan_tiles.hpp"

namespace plumbline::surface {

/// Where else a scan would be as well placed.
struct OtherPlace {
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  ///< of the points [m]
  std::string words;                                ///< "1.52 m to the right"
  int panels = 0;                                   ///< that have points there, on a quarter of their parts or more
};

struct ScanPlaces {
  int panels = 0;                  ///< that have points where the scan is
  std::vector<OtherPlace> equal;   ///< where as many do: nothing in the scan says which panel is which
  std::vector<OtherPlace> better;  ///< where more do: the scan is probably there; the best first
};

/// Moves the scan by the steps from panels to the nearest equal ones that recur on the facades, to neighbours and
/// beyond them, and counts panels that have points. A scan that ends where the facade does is confirmed by it; one that
/// shows a part of the facade, or more than it, may be anywhere. `points`: some of the scan [m, frame of the faces],
/// with those beside the faces; `tiles`: of these faces.
ScanPlaces places_of_scan(const std::vector<PanelFace>& faces, const ScanTiles& tiles,
                          const std::vector<Eigen::Vector3d>& points);

}  // namespace plumbline::surface

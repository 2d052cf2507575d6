// Whether a surface that was measured is that of its panel: what hangs before it, or lies behind it, is as flat.
#pragma once

#include <string>
#include <vector>

#include "artifacts/surfaces.hpp"

namespace plumbline::judgement {

/// How far a panel's surface may be from the design's face and still be taken for it, unless said otherwise [m]. Panels
/// are set to a tolerance of some 5 mm, whatever their brackets had to make up for; three times that leaves room for
/// their form and for the place of a scan. Boards that are put before a panel are 18 mm thick and more, nets of a
/// scaffold hang 100 mm before it, and the wall behind is further away than the brackets' 25 mm of adjustment.
inline constexpr double kPlausiblePlace = 0.015;

/// Of every panel of `surfaces`, in their order, why what was measured may not be its surface; empty where nothing says
/// so. That is: the plane that fits best is further than `within` [m] from the design's face at a corner, or nobody
/// says how far it is; another panel of the design has the same face (within `within`, over half of the smaller one);
/// the place of the whole measurement is in doubt. A panel that was not measured has none: that is its reason.
std::vector<std::string> doubts_of_panels(const SurfacesT& surfaces, double within);

}  // namespace plumbline::judgement

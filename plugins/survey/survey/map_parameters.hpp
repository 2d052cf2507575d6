// What the nodes that adjust on a map have in common.
#pragma once

#include <limits>
#include <numbers>

#include "profiled_node.hpp"
#include "survey/model/map_frame.hpp"

namespace plumbline::survey {

struct MappedNode : ProfiledNode {
  Param<std::string> map{"map", "",
                         "map that E and N are on: 'EPSG:25832', 'utm:32' or its name; empty: a plane in which lengths "
                         "are true; plane: likewise, and coordinates that look like a map's are none"};
  Param<double> geoid_height{"geoid_height", 0.0, "m", between(-200, 200),
                             "of the geoid above the map's ellipsoid, for the reduction of lengths from the heights"};
  Param<double> mean_height{"mean_height", std::numeric_limits<double>::quiet_NaN(), "m", between(-500, 9000),
                            "of the site above the geoid, where no point has a height: lengths are reduced from it"};
  Param<std::vector<double>> deflection{"deflection", std::vector<double>{}, "arcsec", between(-100, 100),
                                        "of the vertical, xi (north) and eta (east) of the astronomic zenith from the "
                                        "ellipsoid's normal; empty: none, or "
                                        "the slope of geoid_grid"};
  Param<FilePath> geoid_grid{"geoid_grid", FilePath{},
                             "grid of geoid heights in place of geoid_height, as PROJ reads it (.gtx, GeoTIFF)"};
  Param<double> geoid_slope{"geoid_slope", 10.0, "arcsec", between(0, 100),
                            "prior of the geoid's unknown slope over a site with GNSS vectors on a map, where "
                            "geoid_height is all that is known of it; 0: none, as of heights above the ellipsoid"};

 protected:
  GeoidChoice geoid() const {
    constexpr double kArcsecond = std::numbers::pi / 180 / 3600;
    if (!deflection->empty() && deflection->size() != 2)
      throw std::runtime_error("deflection has " + std::to_string(deflection->size()) +
                               " values; expected two, [xi, eta], in seconds of arc");
    GeoidChoice choice;
    choice.height = *geoid_height;
    choice.grid = geoid_grid->path;
    choice.slope_sigma = *geoid_slope * kArcsecond;
    if (!deflection->empty()) choice.deflection = kArcsecond * Eigen::Vector2d((*deflection)[0], (*deflection)[1]);
    return choice;
  }
};

}  // namespace plumbline::survey

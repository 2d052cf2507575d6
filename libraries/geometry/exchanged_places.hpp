// Things that were found where others belong.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace plumbline {

struct ExchangedPlace {
  std::size_t thing = 0, place = 0;  ///< indices: `thing` lies where `place` belongs
  bool mutual = false;               ///< and the other way round; told once, with thing < place
};

/// `found[i]` is where thing i is (nan: not found) and `expected[i]` where it belongs, in one frame [m]. A thing lies
/// in another's place if it is there to a quarter of their distance and to 0.25 m, which is closer than two plates
/// hang, and as far from its own as three quarters of that distance. In the order of the things.
std::vector<ExchangedPlace> exchanged_places(const std::vector<Eigen::Vector3d>& found,
                                             const std::vector<Eigen::Vector3d>& expected);

}  // namespace plumbline

#include "geometry/exchanged_places.hpp"

#include <algorithm>
#include <map>

namespace plumbline {

std::vector<ExchangedPlace> exchanged_places(const std::vector<Eigen::Vector3d>& found,
                                             const std::vector<Eigen::Vector3d>& expected) {
  std::map<std::size_t, std::size_t> lies_at;
  for (std::size_t i = 0; i < found.size(); ++i)
    for (std::size_t k = 0; k < found.size(); ++k) {
      const double apart = (expected[k] - expected[i]).norm();
      if (i != k && (found[i] - expected[i]).norm() > 0.75 * apart &&
          (found[i] - expected[k]).norm() < std::min(0.25 * apart, 0.25))
        lies_at[i] = k;
    }
  std::vector<ExchangedPlace> exchanged;
  for (const auto& [thing, place] : lies_at) {
    const auto back = lies_at.find(place);
    const bool mutual = back != lies_at.end() && back->second == thing;
    if (!mutual || thing < place) exchanged.push_back({thing, place, mutual});
  }
  return exchanged;
}

}  // namespace plumbline

#include "obstruction.hpp"

#include <algorithm>
#include <stdexcept>
#include <string>

#include "geometry/random.hpp"

namespace plumbline::simulate {
namespace {

constexpr double kLift = 2.0;    // height of a scaffold's lift [m]
constexpr double kBeyond = 4.0;  // the scaffold reaches so far past the facade [m]

std::vector<double> tubes(double first, double spacing, double length) {
  std::vector<double> places;
  for (double at = first - kBeyond; at <= length + kBeyond; at += spacing) places.push_back(at);
  return places;
}

bool covered(const std::vector<double>& tubes, double radius, double low, double high) {
  return std::any_of(tubes.begin(), tubes.end(), [&](double at) { return at + radius > low && at - radius < high; });
}

}  // namespace

Obstruction make_obstruction(const Building& building, const ObstructionOptions& options, std::uint64_t seed) {
  if (options.scaffold_spacing != 0 && !(options.scaffold_spacing >= 0.5 && options.scaffold_spacing <= 20))
    throw std::invalid_argument("scaffold_spacing is " + std::to_string(options.scaffold_spacing) +
                                " m, it must be 0 (no scaffold) or 0.5 to 20 m");
  if (!(options.scaffold_distance >= 0.2 && options.scaffold_distance <= 3))
    throw std::invalid_argument("scaffold_distance is " + std::to_string(options.scaffold_distance) +
                                " m, it must be 0.2 to 3 m: between the plates and the cameras");
  if (!(options.lost_plates >= 0 && options.lost_plates <= 1))
    throw std::invalid_argument("lost_plates is " + std::to_string(options.lost_plates) + ", it must be 0 to 1");
  Obstruction obstruction;
  obstruction.plane = -options.scaffold_distance;
  if (options.scaffold_spacing > 0) {
    Random random(seed, "scaffold");
    obstruction.uprights = tubes(random.uniform(0, options.scaffold_spacing), options.scaffold_spacing, building.width);
    obstruction.ledgers = tubes(random.uniform(0, kLift), kLift, building.height);
  }
  if (options.lost_plates > 0)
    for (const Anchor& anchor : building.anchors)
      obstruction.lost.push_back(Random(seed, "lost " + anchor.id).uniform() < options.lost_plates);
  return obstruction;
}

bool tag_is_free(const Obstruction& obstruction, const Building& building, std::size_t index,
                 const Eigen::Vector3d& centre) {
  if (!obstruction.lost.empty() && obstruction.lost[index]) return false;
  if (obstruction.uprights.empty()) return true;
  const Anchor& anchor = building.anchors[index];
  const double reach = 0.5 * anchor.true_plate.tag_size * 1.25;  // with the white edge, which the detector needs
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e9), high = -low;
  for (const double dx : {-reach, reach})
    for (const double dy : {-reach, reach}) {
      const Eigen::Vector3d in_plate = anchor.true_plate.tag_centre_in_plate + Eigen::Vector3d(dx, dy, 0);
      const Eigen::Vector3d corner = anchor.building_from_plate * in_plate;
      // Where the ray to the corner passes the tubes' plane; a camera behind the tubes sees past them.
      if (centre.y() >= obstruction.plane) return true;
      const double t = (obstruction.plane - centre.y()) / (corner.y() - centre.y());
      const Eigen::Vector3d through = centre + t * (corner - centre);
      const Eigen::Vector2d at(through.x(), through.z());
      low = low.cwiseMin(at), high = high.cwiseMax(at);
    }
  return !covered(obstruction.uprights, obstruction.radius, low.x(), high.x()) &&
         !covered(obstruction.ledgers, obstruction.radius, low.y(), high.y());
}

}  // namespace plumbline::simulate

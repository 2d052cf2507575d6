#include "surface/dense/find_planes.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include "plumbline/stop.hpp"
#include "surface/dense/facade_plane.hpp"

namespace plumbline::surface {
namespace {

constexpr double kLeastPoints = 12;  // of a cell with its neighbours
constexpr size_t kNone = std::numeric_limits<size_t>::max();

using Place = Eigen::Matrix<std::int32_t, 3, 1>;

std::uint64_t key_of(const Place& place) {
  constexpr std::uint64_t mask = (1ULL << 21) - 1;
  const auto part = [](std::int32_t value) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(value)) & mask;
  };
  return part(place.x()) << 42 | part(place.y()) << 21 | part(place.z());
}

}  // namespace

struct PlaneFinder::Fit {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  double rms = std::numeric_limits<double>::infinity();
  double points = 0;
  bool flat = false;  ///< wide in two directions
};

PlaneFinder::Fit PlaneFinder::fit_of(const Sums& sums, const Eigen::Vector3d& about) {
  Fit fit;
  fit.points = sums.count;
  if (!(sums.count > 2)) return fit;
  const Eigen::Vector3d mean = sums.first / sums.count;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(sums.second / sums.count - mean * mean.transpose());
  fit.centre = about + mean, fit.normal = axes.eigenvectors().col(0);
  fit.rms = std::sqrt(std::max(0.0, axes.eigenvalues()(0)));
  fit.flat = axes.eigenvalues()(1) > 9 * axes.eigenvalues()(0) && axes.eigenvalues()(1) > 0.01 * axes.eigenvalues()(2);
  return fit;
}

void PlaneFinder::Sums::add(const Sums& other, const Eigen::Vector3d& apart) {
  second += other.second + apart * other.first.transpose() + other.first * apart.transpose() +
            other.count * apart * apart.transpose();
  first += other.first + other.count * apart;
  count += other.count;
}

PlaneFinder::PlaneFinder(const PlaneOptions& options) : options_(options) {
  if (!(options.cell > 0) || !(options.roughness > 0) || !(options.angle > 0) || !(options.least_area > 0))
    throw std::invalid_argument("cell, roughness, angle and least area of planes must be above zero");
}

Eigen::Vector3d PlaneFinder::middle(const Cell& cell) const {
  return options_.cell * (cell.place.cast<double>() + Eigen::Vector3d::Constant(0.5));
}

void PlaneFinder::add(const Eigen::Vector3d& point) {
  Place place;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double at = std::floor(point(axis) / options_.cell);
    if (!(std::abs(at) < 2e9)) throw std::length_error("a point lies at " + std::to_string(point(axis)) + " m");
    place(axis) = static_cast<std::int32_t>(at);
  }
  // Places 2^21 cells apart have one key: in 200 km nothing lies so far apart.
  const auto [found, added] = number_of_.emplace(key_of(place), cells_.size());
  if (added) {
    if (cells_.size() == options_.most_cells)
      throw std::length_error("the cloud takes more than " + std::to_string(options_.most_cells) + " cells of " +
                              std::to_string(options_.cell) + " m; take larger ones, or allow more memory");
    cells_.push_back({place, {}});
  }
  Cell& cell = cells_[found->second];
  const Eigen::Vector3d from = point - middle(cell);
  cell.sums.count += 1, cell.sums.first += from, cell.sums.second += from * from.transpose();
}

std::vector<size_t> PlaneFinder::around(const Cell& cell) const {
  std::vector<size_t> found;
  for (std::int32_t x = -1; x <= 1; ++x)
    for (std::int32_t y = -1; y <= 1; ++y)
      for (std::int32_t z = -1; z <= 1; ++z)
        if (const auto other = number_of_.find(key_of(cell.place + Place(x, y, z))); other != number_of_.end())
          found.push_back(other->second);
  return found;
}

std::vector<PlaneFinder::Fit> PlaneFinder::fits_of_cells() const {
  std::vector<Fit> local(cells_.size());
  for (size_t c = 0; c < cells_.size(); ++c) {
    if (c % 4096 == 0) stop_point();
    Sums sums;
    for (const size_t other : around(cells_[c]))
      sums.add(cells_[other].sums, middle(cells_[other]) - middle(cells_[c]));
    local[c] = fit_of(sums, middle(cells_[c]));
    local[c].flat = local[c].flat && sums.count >= kLeastPoints && local[c].rms <= options_.roughness;
  }
  return local;
}

std::vector<size_t> PlaneFinder::grow(size_t seed, const std::vector<Fit>& local, std::vector<size_t>& plane_of,
                                      Fit& all) const {
  const double turned = std::cos(options_.angle);
  const Eigen::Vector3d about = middle(cells_[seed]);
  std::vector<size_t> members = {seed};
  plane_of[seed] = seed;
  Sums sums = cells_[seed].sums;
  all = local[seed];
  size_t fitted = 4;  // members at which the plane is fitted again
  for (size_t next = 0; next < members.size(); ++next)
    for (const size_t other : around(cells_[members[next]])) {
      const Eigen::Vector3d centre = middle(cells_[other]) + cells_[other].sums.first / cells_[other].sums.count;
      if (plane_of[other] != kNone || !local[other].flat || std::abs(all.normal.dot(local[other].normal)) < turned ||
          std::abs(all.normal.dot(centre - all.centre)) > 2 * options_.roughness)
        continue;
      plane_of[other] = seed, members.push_back(other);
      sums.add(cells_[other].sums, middle(cells_[other]) - about);
      if (members.size() < fitted) continue;
      all = fit_of(sums, about), fitted = members.size() + members.size() / 2;
    }
  all = fit_of(sums, about);
  return members;
}

FoundPlane PlaneFinder::outline(const std::vector<size_t>& members, const Fit& all) const {
  const FacadePlane frame = facade_plane(all.centre, all.normal);
  Eigen::Vector2d low = Eigen::Vector2d::Constant(1e300), high = -low;
  std::vector<Eigen::Vector2d> places;
  places.reserve(members.size());
  for (const size_t member : members) {
    const Sums& of = cells_[member].sums;
    places.push_back(frame.local(middle(cells_[member]) + of.first / of.count).head<2>());
    low = low.cwiseMin(places.back()), high = high.cwiseMax(places.back());
  }
  std::vector<std::pair<long, long>> covered;  // a plane that lies on the border of cells has two for each place
  covered.reserve(places.size());
  for (const Eigen::Vector2d& at : places)
    covered.emplace_back(std::lround((at.x() - low.x()) / options_.cell),
                         std::lround((at.y() - low.y()) / options_.cell));
  std::sort(covered.begin(), covered.end());
  covered.erase(std::unique(covered.begin(), covered.end()), covered.end());
  const Eigen::Vector2d centre = 0.5 * (low + high);
  FoundPlane plane;
  plane.area = static_cast<double>(covered.size()) * options_.cell * options_.cell;
  plane.origin = frame.world({centre.x(), centre.y(), 0}), plane.normal = all.normal;
  plane.width = high.x() - low.x() + options_.cell, plane.height = high.y() - low.y() + options_.cell;
  plane.roughness = all.rms, plane.points = static_cast<std::uint64_t>(all.points);
  return plane;
}

std::vector<FoundPlane> PlaneFinder::planes() const {
  const std::vector<Fit> local = fits_of_cells();
  std::vector<size_t> seeds, plane_of(cells_.size(), kNone);
  seeds.reserve(cells_.size());
  for (size_t c = 0; c < cells_.size(); ++c)
    if (local[c].flat) seeds.push_back(c);
  std::stable_sort(seeds.begin(), seeds.end(), [&](size_t a, size_t b) { return local[a].rms < local[b].rms; });
  std::vector<FoundPlane> planes;
  for (const size_t seed : seeds) {
    if (plane_of[seed] != kNone) continue;
    stop_point();
    Fit all;
    const std::vector<size_t> members = grow(seed, local, plane_of, all);
    if (!std::isfinite(all.rms) ||
        !(static_cast<double>(members.size()) * options_.cell * options_.cell >= options_.least_area))
      continue;
    if (const FoundPlane plane = outline(members, all); plane.area >= options_.least_area) planes.push_back(plane);
  }
  std::stable_sort(planes.begin(), planes.end(), [](const auto& a, const auto& b) { return a.area > b.area; });
  return planes;
}

}  // namespace plumbline::surface

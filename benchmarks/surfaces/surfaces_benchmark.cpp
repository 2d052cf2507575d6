// surfaces_benchmark FOLDER [DISTANCE]: heights of the wall of fountain-P11 (Strecha et al. 2008) with its published
// cameras, once from the photographs of even numbers and once from those of odd ones. What both say of one place
// differs by their errors: random ones, which each states, and those of the cameras, which nobody states; within a tile
// of the wall the latter are a height and two slopes, so they are taken out for the second set of figures.
#include <oneapi/tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cstdio>
#include <map>

#include "fountain.hpp"
#include "surface/dense/facet_tile.hpp"

namespace {

using namespace plumbline;
using namespace plumbline::surface;

constexpr int kColumns = 8, kRows = 6;
constexpr double kTile = 0.4;

std::vector<FacetTile> measure(const FacadePlane& plane, const std::vector<FacetView>& views,
                               const TileOptions& options) {
  std::vector<FacetTile> tiles(kColumns * kRows);
  oneapi::tbb::parallel_for(size_t{0}, tiles.size(), [&](size_t t) {
    const Eigen::Vector2d low(kTile * (static_cast<double>(t % kColumns) - 0.5 * kColumns),
                              kTile * (static_cast<double>(t / kColumns) - 0.5 * kRows));
    tiles[t] = measure_tile(plane, {low, low + Eigen::Vector2d(kTile, kTile)}, views, {}, options);
  });
  return tiles;
}

/// Differences of one tile at places that both sets have.
struct Pairs {
  std::vector<Eigen::Vector2d> place;
  std::vector<double> difference, sigma;
};

Pairs pairs_of(const FacadePlane& plane, const FacetTile& a, const FacetTile& b) {
  std::map<std::pair<long, long>, std::pair<double, double>> first;
  const auto key = [](const Eigen::Vector3d& at) {
    return std::pair(std::lround(at.x() * 1e3), std::lround(at.y() * 1e3));
  };
  for (const MeasuredPoint& point : a.measured.points) {
    const Eigen::Vector3d at = plane.local(a.measured.at(point));
    first[key(at)] = {at.z(), static_cast<double>(point.sigma)};
  }
  Pairs pairs;
  for (const MeasuredPoint& point : b.measured.points) {
    const Eigen::Vector3d at = plane.local(b.measured.at(point));
    const auto found = first.find(key(at));
    if (found == first.end()) continue;
    pairs.place.push_back(at.head<2>() - b.place);
    pairs.difference.push_back(at.z() - found->second.first);
    pairs.sigma.push_back(std::hypot(static_cast<double>(point.sigma), found->second.second));
  }
  return pairs;
}

double median_of(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

/// Takes height and slopes of the differences out, robustly, from their median on. Tiles of few places are left out.
bool level(Pairs& pairs) {
  constexpr size_t few = 12;
  const size_t count = pairs.difference.size();
  if (count < few) return false;
  Eigen::Vector3d plane(median_of(pairs.difference), 0, 0);
  std::vector<double> off(count), size(count);
  for (int pass = 0; pass < 12; ++pass) {
    for (size_t i = 0; i < count; ++i) {
      off[i] = pairs.difference[i] - plane(0) - plane.tail<2>().dot(pairs.place[i]);
      size[i] = std::abs(off[i]);
    }
    if (pass == 11) break;
    const double scale = 1.4826 * median_of(size) + 1e-6;
    Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
    Eigen::Vector3d right = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < count; ++i) {
      const Eigen::Vector3d base(1, pairs.place[i].x(), pairs.place[i].y());
      const double weight = 1 / (1 + std::pow(off[i] / scale, 2));
      normal += weight * base * base.transpose(), right += weight * pairs.difference[i] * base;
    }
    plane = normal.ldlt().solve(right);
  }
  pairs.difference = off;
  return true;
}

void print(const char* what, const std::vector<Pairs>& all) {
  std::vector<double> sizes, ratios;
  double within = 0;
  for (const Pairs& pairs : all)
    for (size_t i = 0; i < pairs.difference.size(); ++i) {
      sizes.push_back(std::abs(pairs.difference[i])), ratios.push_back(sizes.back() / pairs.sigma[i]);
      within += ratios.back() < 3;
    }
  if (sizes.empty()) return;
  const double count = static_cast<double>(sizes.size());
  std::sort(sizes.begin(), sizes.end()), std::sort(ratios.begin(), ratios.end());
  std::printf(
      "%s: %.0f places; |difference| median %.2f mm, 90 %% below %.2f mm; over its random sigma median %.2f (expected "
      "0.67), within 3 sigma %.1f %%\n",
      what, count, 1e3 * sizes[sizes.size() / 2], 1e3 * sizes[sizes.size() * 9 / 10], ratios[ratios.size() / 2],
      100 * within / count);
}

}  // namespace

int main(int count, char** arguments) try {
  if (count < 2)
    throw std::runtime_error("usage: surfaces_benchmark FOLDER [distance of the wall from the middle camera, m]");
  const Fountain photographs = read_fountain(arguments[1]);
  const double distance = count > 2 ? std::atof(arguments[2]) : 8;
  const FacadePlane plane = photographs.wall(distance);
  TileOptions options;
  options.facet.search = 0.4, options.facet.max_sigma = 0.01;
  options.pitch = 0.045;  // more than a facet of either set, so that both look at the same places
  std::printf("ground pixel %.2f mm\n", 1e3 * distance / photographs.views[5].camera.fx);
  const auto even = measure(plane, photographs.every(0, 2), options),
             odd = measure(plane, photographs.every(1, 2), options);
  for (const auto* set : {&even, &odd}) {
    std::array<int, 6> outcomes{};
    for (const FacetTile& tile : *set)
      for (size_t o = 0; o < outcomes.size(); ++o) outcomes[o] += tile.outcomes[o];
    std::printf("%s photographs:", set == &even ? "even" : "odd");
    for (size_t o = 0; o < outcomes.size(); ++o)
      std::printf(" %d %s%s", outcomes[o], to_string(static_cast<FacetOutcome>(o)),
                  o + 1 < outcomes.size() ? "," : "\n");
  }
  std::vector<Pairs> all;
  for (size_t t = 0; t < even.size(); ++t) all.push_back(pairs_of(plane, even[t], odd[t]));
  print("as they are", all);
  std::erase_if(all, [](Pairs& pairs) { return !level(pairs); });
  print("without height and slopes of each tile", all);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}

#include "surface/dense/facet_relief.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

#include "geometry/median.hpp"

namespace plumbline::surface {
namespace {

constexpr double kMedianOfChiSquare = 0.455;  // of one degree of freedom

/// Least distance of two facets in one direction [m]; 0 if all stand at the same place of it.
double step_of(std::vector<double> places) {
  constexpr double rounding = 1e-6;
  std::sort(places.begin(), places.end());
  double step = 0;
  for (size_t i = 1; i < places.size(); ++i)
    if (const double apart = places[i] - places[i - 1]; apart > rounding && (step == 0 || apart < step)) step = apart;
  return step;
}

/// A second difference: its square and the variance that noise gives it [m²].
struct Bend {
  double square, noise;
};

/// Measured facets by row and column.
class Lattice {
 public:
  explicit Lattice(const std::vector<const Facet*>& facets) {
    std::vector<double> u, v;
    for (const Facet* facet : facets)
      if (facet->outcome == FacetOutcome::measured) u.push_back(facet->place.x()), v.push_back(facet->place.y());
    if (u.empty()) return;
    low_ = {*std::min_element(u.begin(), u.end()), *std::min_element(v.begin(), v.end())};
    step_ = {step_of(u), step_of(v)};
    for (const Facet* facet : facets)
      if (facet->outcome == FacetOutcome::measured) at_[cell_of(*facet)] = facet;
  }
  double step() const { return step_.maxCoeff(); }

  std::vector<Bend> bends_at(const Facet& facet) const {
    constexpr std::array<std::pair<long, long>, 4> directions = {{{1, 0}, {0, 1}, {1, 1}, {1, -1}}};
    std::vector<Bend> bends;
    const auto [column, row] = cell_of(facet);
    for (const auto& [right, up] : directions) {
      const auto along = [&, c = column, r = row, a = right, b = up](long k) { return find(c + k * a, r + k * b); };
      const Facet *before = along(-1), *after = along(1);
      if (before && after) {
        bends.push_back(bend(1, facet, -0.5, *before, -0.5, *after));
        continue;
      }
      for (const long side : {-1L, 1L})
        if (const Facet* next = along(side), *second = along(2 * side); next && second)
          bends.push_back(bend(0.5, facet, -1, *next, 0.5, *second));
    }
    return bends;
  }

 private:
  std::pair<long, long> cell_of(const Facet& facet) const {
    const auto number = [](double place, double step) { return step > 0 ? std::lround(place / step) : 0L; };
    return {number(facet.place.x() - low_.x(), step_.x()), number(facet.place.y() - low_.y(), step_.y())};
  }
  const Facet* find(long column, long row) const {
    const auto found = at_.find({column, row});
    return found == at_.end() ? nullptr : found->second;
  }
  static Bend bend(double of_a, const Facet& a, double of_b, const Facet& b, double of_c, const Facet& c) {
    const auto square = [](double value) { return value * value; };
    return {square(of_a * a.height + of_b * b.height + of_c * c.height),
            square(of_a * a.sigma) + square(of_b * b.sigma) + square(of_c * c.sigma)};
  }

  Eigen::Vector2d low_ = Eigen::Vector2d::Zero(), step_ = Eigen::Vector2d::Zero();
  std::map<std::pair<long, long>, const Facet*> at_;
};

/// What of second differences noise does not explain [m²]; may be negative.
double beyond_noise(const std::vector<Bend>& bends) {
  std::vector<double> squares;
  double noise = 0;
  for (const Bend& bend : bends)
    squares.push_back(bend.square), noise += bend.noise / static_cast<double>(bends.size());
  return median(squares) / kMedianOfChiSquare - noise;
}

}  // namespace

std::vector<double> relief_around(const std::vector<const Facet*>& facets) {
  const Lattice lattice(facets);
  std::vector<std::vector<Bend>> bends(facets.size());
  std::vector<Bend> all;
  for (size_t i = 0; i < facets.size(); ++i) {
    if (facets[i]->outcome != FacetOutcome::measured) continue;
    bends[i] = lattice.bends_at(*facets[i]);
    all.insert(all.end(), bends[i].begin(), bends[i].end());
  }
  const double common = all.empty() ? 0 : std::max(0.0, beyond_noise(all));
  std::vector<double> relief(facets.size(), 0.0);
  for (size_t i = 0; i < facets.size(); ++i) {
    if (facets[i]->outcome != FacetOutcome::measured || all.empty()) continue;
    const double count = static_cast<double>(bends[i].size()), own = count > 0 ? count * beyond_noise(bends[i]) : 0;
    const double part = facets[i]->extent > 0 ? std::min(1.0, facets[i]->extent / lattice.step()) : 1;
    relief[i] = part * std::sqrt(std::max(0.0, (own + common) / (count + 1)));
  }
  return relief;
}

}  // namespace plumbline::surface

// Heights of the same cells by both kinds of the role depth, as their nodes make them.
#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "semi_global.hpp"
#include "surface/dense/facet_sigmas.hpp"
#include "surface/dense/facet_tile.hpp"

namespace plumbline::surface {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

inline double seconds_of(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

inline double quantile(std::vector<double>& values, double share) {
  if (values.empty()) return kNan;
  const auto at = static_cast<size_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
  return values[at];
}

/// Heights of all cells by one kind; nan: a hole.
struct Heights {
  std::vector<double> height, sigma;
  double seconds = 0;
  std::array<int, 6> outcomes{};  ///< of dense.plane_sweep, by FacetOutcome
};

/// What the nodes state of facets, tile by tile (of 0.5 m, or here so many cells), into `result`.
inline void state(const CellGrid& grid, const std::vector<Facet>& facets, double max_sigma, Heights& result) {
  constexpr int tile = 11;
  for (int row = 0; row < grid.rows; row += tile)
    for (int column = 0; column < grid.columns; column += tile) {
      std::vector<const Facet*> some;
      std::vector<size_t> cells;
      for (int r = row; r < std::min(row + tile, static_cast<int>(grid.rows)); ++r)
        for (int c = column; c < std::min(column + tile, static_cast<int>(grid.columns)); ++c)
          cells.push_back(static_cast<size_t>(r) * grid.columns + c), some.push_back(&facets[cells.back()]);
      const std::vector<double> sigmas = sigmas_within(some, max_sigma);
      for (size_t i = 0; i < cells.size(); ++i)
        if (some[i]->outcome == FacetOutcome::measured && std::isfinite(sigmas[i]))
          result.height[cells[i]] = some[i]->height, result.sigma[cells[i]] = sigmas[i];
    }
}

/// `wanted`: of each cell; empty: all.
inline Heights swept(const CellGrid& grid, const std::vector<FacetView>& views, const FacetOptions& options,
                     const std::vector<char>& wanted = {}) {
  Heights result;
  result.height.assign(grid.size(), kNan), result.sigma = result.height;
  std::vector<Facet> facets(grid.size());
  result.seconds = seconds_of([&] {
    for (size_t cell = 0; cell < grid.size(); ++cell) {
      if (!wanted.empty() && !wanted[cell]) continue;
      const Eigen::Vector2d at = grid.middle(cell);
      double spacing = 0;
      for (const FacetView& view : views)
        if (const auto map = map_at(*view.view, grid.plane, {at.x(), at.y(), 0}, 8))
          spacing = std::max(spacing, map->ground_pixel());
      if (!(spacing > 0)) continue;
      bool two = false;
      Facet best;
      for (const double start : search_heights(grid.plane, at, spacing, views, options, 2, &two)) {
        Facet facet = match_facet(grid.plane, at, spacing, start, views, options);
        if (best.outcome != FacetOutcome::measured && facet.outcome != FacetOutcome::measured)
          best.outcome = facet.outcome;
        if (facet.outcome == FacetOutcome::measured && facet.correlation > best.correlation) best = std::move(facet);
      }
      if (two && best.outcome == FacetOutcome::measured) best.outcome = FacetOutcome::ambiguous;
      ++result.outcomes[static_cast<size_t>(best.outcome)];
      facets[cell] = std::move(best);
    }
  });
  state(grid, facets, options.max_sigma, result);
  return result;
}

inline Heights matched(const CellGrid& grid, const std::vector<FacetView>& views,
                       const std::vector<RectifiedPair>& pairs, const SemiGlobalOptions& options) {
  Heights result;
  result.height.assign(grid.size(), kNan), result.sigma = result.height;
  std::vector<Facet> facets(grid.size());
  result.seconds = seconds_of([&] {
    std::vector<std::vector<PairHeight>> all;
    for (const RectifiedPair& pair : pairs) all.push_back(semi_global_heights(pair, grid, views, options));
    for (size_t cell = 0; cell < grid.size(); ++cell) {
      if (pairs.size() == 1) {  // nobody to agree with
        if (all[0][cell].state == PairHeight::State::found)
          result.height[cell] = all[0][cell].height, result.sigma[cell] = all[0][cell].sigma;
        continue;
      }
      std::vector<PairHeight> said;
      for (const auto& of_pair : all) said.push_back(of_pair[cell]);
      facets[cell] = agreed_facet(grid, cell, pairs, said, views, options.pair);
    }
  });
  if (pairs.size() > 1) state(grid, facets, options.pair.max_sigma, result);
  return result;
}

}  // namespace plumbline::surface

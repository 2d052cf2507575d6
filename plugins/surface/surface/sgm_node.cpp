#include "sgm_node.hpp"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>

#include "plumbline/stop.hpp"
#include "semi_global.hpp"

namespace plumbline::surface {
namespace {

/// Cells of a face that are no smaller than what is compared on them.
CellGrid grid_of(const PanelFace& face, double pitch, double own) {
  CellGrid grid;
  grid.plane = face.plane;
  grid.area = {{-0.5 * face.width, -0.5 * face.height}, {0.5 * face.width, 0.5 * face.height}};
  const double edge = std::max(pitch, own);
  grid.columns = std::max(1, static_cast<int>(face.width / edge));
  grid.rows = std::max(1, static_cast<int>(face.height / edge));
  return grid;
}

}  // namespace

void SemiGlobal::measure_face(Context& context, const Photographs& photographs, const std::vector<FacetView>& views,
                              const PanelFace& face, std::vector<FacetTile>& tiles, PartialTiles& kept) const {
  std::vector<View> oriented;
  for (const FacetView& view : views) oriented.push_back(*view.view);
  const std::vector<RectifiedPair> found =
      pairs_for(face.plane, {0, 0}, oriented, static_cast<int>(*each), static_cast<size_t>(*pairs));
  double ground = 0;
  for (const RectifiedPair& pair : found) ground = std::max(ground, pair.depth / pair.focal);
  const CellGrid grid = grid_of(face, *pitch, (2 * static_cast<double>(*half) - 1) * ground);
  SemiGlobalOptions options;
  options.block = static_cast<int>(*block) | 1;
  options.pair.search = *search, options.pair.refine = *refine, options.pair.matching_sigma = *matching_sigma,
  options.pair.half = static_cast<int>(*half);
  options.pair.min_correlation = *min_correlation, options.pair.max_sigma = *max_sigma;
  options.pair.min_views = static_cast<int>(*min_views);
  std::vector<std::vector<PairHeight>> heights(found.size());
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(size_t{0}, found.size(), [&](size_t p) {
      if (context.cancelled()) return;
      const StopScope stop([](const void* of) { return static_cast<const Context*>(of)->cancelled(); }, &context);
      heights[p] = semi_global_heights(found[p], grid, views, options);
    });
  });
  if (context.cancelled()) throw Stopped();
  for (const Rectangle& part : parts_of(face)) {
    std::vector<std::pair<Eigen::Vector2d, Facet>> facets;
    for (size_t cell = 0; cell < grid.size(); ++cell) {
      const Eigen::Vector2d at = grid.middle(cell);
      if (at.x() < part.low.x() || at.y() < part.low.y() || at.x() >= part.high.x() || at.y() >= part.high.y())
        continue;
      std::vector<PairHeight> said;
      for (const auto& of_pair : heights) said.push_back(of_pair[cell]);
      facets.emplace_back(at, agreed_facet(grid, cell, found, said, views, options.pair));
    }
    tiles.push_back(tile_of(face.plane, part, facets, views, photographs.orientations(), *max_sigma));
    kept.save(tiles.size() - 1, tiles.back());
  }
}

}  // namespace plumbline::surface

#include "sweep_node.hpp"

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include "plumbline/stop.hpp"

namespace plumbline::surface {

void PlaneSweep::measure_face(Context& context, const Photographs& photographs, const std::vector<FacetView>& views,
                              const PanelFace& face, std::vector<FacetTile>& tiles, PartialTiles& kept) const {
  TileOptions options;
  options.facet.search = *search, options.facet.half = static_cast<int>(*half);
  options.facet.min_views = static_cast<int>(*min_views), options.facet.min_correlation = *min_correlation;
  options.facet.max_sigma = *max_sigma, options.pitch = *pitch, options.max_views = static_cast<int>(*max_views);
  const std::vector<Rectangle> parts = parts_of(face);
  const size_t first = tiles.size();
  tiles.resize(first + parts.size());
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(size_t{0}, parts.size(), [&](size_t t) {
      if (context.cancelled() || kept.load(first + t, tiles[first + t])) return;
      const StopScope stop([](const void* of) { return static_cast<const Context*>(of)->cancelled(); }, &context);
      tiles[first + t] = measure_tile(face.plane, parts[t], views, photographs.orientations(), options);
      kept.save(first + t, tiles[first + t]);
    });
  });
}

}  // namespace plumbline::surface

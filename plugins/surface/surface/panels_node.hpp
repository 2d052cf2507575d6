// Panels from points of surfaces, whatever measured them.
#pragma once

#include <fmt/core.h>
#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <mutex>

#include "artifacts/file.hpp"
#include "plumbline/node.hpp"
#include "plumbline/stop.hpp"
#include "surface_artifacts.hpp"

namespace plumbline::surface {

inline FileT text_file(const std::string& name, const std::string& media_type, const std::string& text) {
  FileT file;
  file.name = name, file.media_type = media_type, file.content.assign(text.begin(), text.end());
  return file;
}

/// Of the sphere about the tile's centre that holds its points [m].
inline double radius_of(const MeasuredTile& tile) {
  double radius = 0;
  for (const MeasuredPoint& point : tile.points) radius = std::max(radius, static_cast<double>(point.offset.norm()));
  return radius;
}

/// Work on many things, two or more at a time; ends as soon as the run is stopped.
template <typename Work>
void in_parallel(Context& context, size_t count, const Work& work) {
  tbb::this_task_arena::isolate([&] {
    tbb::parallel_for(size_t{0}, count, [&](size_t i) {
      if (context.cancelled()) return;
      const StopScope stop([](const void* of) { return static_cast<const Context*>(of)->cancelled(); }, &context);
      work(i);
    });
  });
  if (context.cancelled()) throw Stopped();
}

struct Panels : Node {
  static constexpr Info info{"surface.panels", "", 5,
                             "Planes, bow, twist and flatness of panels from points, with their covariance"};
  In<SurfacePoints> points{"surface", frame("frame=?F"), "the points and the faces that they lie on"};
  Param<double> border{"border", 0.02, "m", between(0, 1),
                       "points nearer to a panel's edge are left out: bevels, joints"};
  Param<double> reach{"reach", 0.1, "m", between(0.001, 2),
                      "points further from the design's face are not the panel's"};
  Param<double> cell{"cell", 0.05, "m", between(0.002, 1), "of which flatness takes the means"};
  Param<double> least_coverage{"least_coverage", 0.3, "1", between(0, 1), "share of a panel that has to have points"};
  Param<std::vector<double>> straightedges{
      "straightedges", {0.1, 1.0}, "m", between(0.01, 20), "lengths under which gaps are looked for"};
  Out<Surfaces> surfaces{"surfaces", frame("frame=?F"), "the panels"};
  Out<File> table{"table", "one line a panel, CSV"};

  /// A thin panel scanned from inside looks like one that stands too far back, by its thickness.
  static void warn_of_inner_side(Context& context, const PanelFace& face, const PanelSurface& panel) {
    const double offset = panel.plane(0), sigma = std::sqrt(panel.plane_covariance()(0, 0));
    const double beyond = std::abs(offset + face.thickness);  // from the design's inner side
    if (!(face.thickness > 0) || !(beyond < 0.5 * face.thickness || beyond < 3 * sigma)) return;
    const std::string text = fmt::format(
        " lies {:.1f} mm behind its outer face and is {:.1f} mm thick: are these points of its inner side? 'seen_from' "
        "of dense.import says where the scanner stood",
        -1e3 * offset, 1e3 * face.thickness);
    context.warn(panel.id + text);
  }

  void run(Context& context) override {
    SurfacePointsT given = points.unpack();
    std::vector<std::string> paths;
    for (const auto& tile : given.tiles) paths.push_back(context.resolve(tile->uri));
    const auto read = [&](size_t t) { return read_tile(*given.tiles[t], given.rank, paths[t]); };
    // Tiles are read again panel by panel: all of a scan at once may be too much.
    std::vector<double> radius(given.tiles.size());
    in_parallel(context, radius.size(), [&](size_t t) { radius[t] = radius_of(read(t)); });
    PanelOptions options;
    options.border = *border, options.reach = *reach, options.cell = *cell, options.least_coverage = *least_coverage;
    options.straightedges = *straightedges;
    options.independent = given.source == "scan";
    if (std::isfinite(given.search)) options.search = given.search;
    SurfacesT result;
    result.rank = given.rank, result.warnings = given.warnings, result.place_doubt = given.place_doubt;
    result.left_out = std::move(given.left_out);
    const bool any =
        std::any_of(given.tiles.begin(), given.tiles.end(), [](const auto& tile) { return tile->points > 0; });
    if (given.rank == 0 && any)
      context.warn(
          "the points come without systematic errors: what is stated of a panel's place is how well it is measured "
          "among its neighbours, not where it is");
    std::vector<PanelSurface> found(given.faces.size());
    size_t done = 0;
    std::mutex telling;
    in_parallel(context, found.size(), [&](size_t f) {
      const PanelFace where = face_of(*given.faces[f]);
      std::vector<MeasuredTile> tiles;
      const double panel_radius = std::hypot(0.5 * where.width, 0.5 * where.height, *reach);
      for (size_t t = 0; t < given.tiles.size(); ++t)
        if ((given.tiles[t]->centre - where.plane.origin).norm() <= panel_radius + radius[t]) tiles.push_back(read(t));
      found[f] = measure_panel(where, tiles, options);
      const std::lock_guard lock(telling);
      context.progress(static_cast<double>(++done) / static_cast<double>(found.size()), where.id);
    });
    int measured = 0;
    for (size_t f = 0; f < found.size(); ++f) {
      const PanelFace where = face_of(*given.faces[f]);
      const PanelSurface& panel = found[f];
      if (!panel.not_measured.empty()) context.warn(panel.id + " is not measured: " + panel.not_measured);
      if (panel.not_measured.empty() && given.source == "scan") warn_of_inner_side(context, where, panel);
      if (panel.repeated > 1.05)
        context.warn(fmt::format(
            "{}: each place has {:.2f} points on average, as if scans had been put into the file more than once: its "
            "variances are larger by it; give the cloud without what is in it twice",
            panel.id, panel.repeated));
      measured += panel.not_measured.empty();
      result.panels.push_back(describe(panel, where, given.faces[f]->guid, given.rank));
      result.panels.back()->cell = *cell;
    }
    context.info(std::to_string(measured) + " of " + std::to_string(given.faces.size()) + " panels measured");
    context.metric("panels", measured, "1");
    // Nothing of what the node is for: exit code 3 (framework/cli/run.cpp).
    if (measured == 0) context.metric("invalid", 1, "1");
    surfaces.commit(result);
    table.commit(text_file("panels.csv", "text/csv", panels_table(result)));
  }
};

}  // namespace plumbline::surface

// Heights of a facade from the photographs of an adjusted block.
#pragma once

#include <oneapi/tbb/parallel_for.h>
#include <oneapi/tbb/task_arena.h>

#include <cmath>
#include <cstdio>
#include <filesystem>

#include "artifacts/folder.hpp"
#include "faces.hpp"
#include "photographs.hpp"
#include "plumbline/node.hpp"
#include "surface/facet_tile.hpp"
#include "surface_artifacts.hpp"

namespace plumbline::surface {

struct PlaneSweep : Node {
  static constexpr Info info{"dense.plane_sweep", "depth", 1,
                             "Measures the heights of panels facet by facet in all photographs that see them, with random and "
                             "systematic errors"};
  List<Image> images{"images", "the photographs"};
  In<Poses> poses{"poses", frame("frame=?F"), "their orientations, with the joint covariance of all"};
  In<Camera> camera{"camera", "the cameras that took them, as they were adjusted with the poses"};
  Optional<Design> design{"design", frame("frame=?F"), "whose panels are measured"};
  Optional<Points> points{"points", frame("frame=?F"), "without a design: the plane of these points is measured"};
  Param<double> search{"search", 0.05, "m", between(0.001, 0.5), "how far before and behind the design's face to look"};
  Param<double> pitch{"pitch", 0.02, "m", between(0.0005, 1), "between points; never less than a facet's own size"};
  Param<double> tile{"tile", 0.25, "m", between(0.02, 5), "edge of the parts that are measured at a time"};
  Param<double> margin{"margin", 0.05, "m", between(0, 5), "without a design: how far beyond the points the plane reaches"};
  Param<int64_t> half{"half", 5, between(3, 15), "a facet has (2 half + 1)² samples, a pixel apart"};
  Param<int64_t> min_views{"min_views", 3, between(2, 20), "photographs that have to agree on a facet"};
  Param<int64_t> max_views{"max_views", 8, between(2, 40), "the best photographs of a part that are used"};
  Param<double> min_correlation{"min_correlation", 0.7, "1", between(0.1, 0.99), "of a photograph with the mean of all"};
  Param<double> max_sigma{"max_sigma", 0.002, "m", between(1e-6, 0.1), "a facet known worse is a hole"};
  Param<double> memory{"memory", 1.5, "GiB", between(0.05, 64), "for the photographs' pixels"};
  Out<SurfacePoints> surface{"surface", frame("frame=?F"), "the points"};
  Out<Folder> files{"files", "where they lie"};

  void run(Context& context) override {
    std::vector<ImageT> all;
    for (size_t i = 0; i < images.size(); ++i) all.push_back(images.unpack(i));
    const Photographs photographs(all, poses.unpack(), camera.unpack());
    for (const auto& name : photographs.without_pose()) context.warn(name + " has no pose and takes no part");
    const Faces faces = wanted_faces(context, photographs);
    const auto limit = static_cast<std::uint64_t>(*memory * 1073741824.0);
    context.reserve_memory(limit);
    PixelCache pixels(photographs, limit, [&](size_t view) { return read_grey_image(context.resolve(photographs.uri(view))); });
    std::vector<FacetTile> tiles;
    std::vector<size_t> face_of_tile;
    for (size_t f = 0; f < faces.faces.size(); ++f) {
      context.progress(static_cast<double>(f) / static_cast<double>(faces.faces.size()), faces.faces[f].id);
      measure_face(context, photographs, pixels, faces.faces[f], limit, tiles);
      face_of_tile.resize(tiles.size(), f);
      if (context.cancelled()) throw Stopped();
    }
    commit(context, photographs, faces, face_of_tile, std::move(tiles));
  }

 private:
  Faces wanted_faces(Context& context, const Photographs& photographs) const {
    if (!design && !points) throw std::runtime_error("connect 'design', whose panels are measured, or 'points', whose plane is");
    Faces faces = design ? faces_of(design.unpack(), photographs.centres())
                         : face_through(points.unpack(), photographs.centres(), *margin);
    for (const auto& what : faces.left_out) context.warn("not measured: " + what);
    if (faces.faces.empty())
      throw std::runtime_error(
          "the design has no panel with a face that could be measured; mark the panels in it, or connect 'points' instead of 'design'");
    return faces;
  }

  TileOptions options() const {
    TileOptions o;
    o.facet.search = *search, o.facet.half = static_cast<int>(*half), o.facet.min_views = static_cast<int>(*min_views);
    o.facet.min_correlation = *min_correlation, o.facet.max_sigma = *max_sigma;
    o.pitch = *pitch, o.max_views = static_cast<int>(*max_views);
    return o;
  }

  void measure_face(Context& context, const Photographs& photographs, PixelCache& pixels, const PanelFace& face,
                    std::uint64_t limit, std::vector<FacetTile>& tiles) const {
    std::vector<size_t> seen = photographs.that_see(face, *search);
    std::uint64_t bytes = 0;
    size_t fit = 0;
    while (fit < seen.size() && bytes + photographs.bytes(seen[fit]) <= limit) bytes += photographs.bytes(seen[fit++]);
    if (fit < seen.size())
      context.warn(face.id + ": " + std::to_string(fit) + " of " + std::to_string(seen.size()) +
                   " photographs that see it are used; 'memory' holds no more");
    seen.resize(fit);
    const std::vector<FacetView> views = pixels.take(seen);
    const int columns = std::max(1, static_cast<int>(std::lround(face.width / *tile)));
    const int rows = std::max(1, static_cast<int>(std::lround(face.height / *tile)));
    const size_t first = tiles.size();
    tiles.resize(first + static_cast<size_t>(columns) * rows);
    const TileOptions chosen = options();
    tbb::this_task_arena::isolate([&] {
      tbb::parallel_for(size_t{0}, tiles.size() - first, [&](size_t t) {
        if (context.cancelled()) return;
        const double c = static_cast<double>(t % static_cast<size_t>(columns)), r = static_cast<double>(t / static_cast<size_t>(columns));
        const Eigen::Vector2d size(face.width / columns, face.height / rows);
        const Eigen::Vector2d low(c * size.x() - 0.5 * face.width, r * size.y() - 0.5 * face.height);
        const StopScope stop([](const void* of) { return static_cast<const Context*>(of)->cancelled(); }, &context);
        tiles[first + t] = measure_tile(face.plane, {low, low + size}, views, photographs.orientations(), chosen);
      });
    });
  }

  void commit(Context& context, const Photographs& photographs, const Faces& faces, const std::vector<size_t>& face_of_tile,
              std::vector<FacetTile> tiles) const {
    std::vector<FacadePlane> planes;
    for (size_t f : face_of_tile) planes.push_back(faces.faces[f].plane);
    add_systematic_part(tiles, planes, photographs.orientations());
    SurfacePointsT artifact;
    artifact.source = "photographs";
    const auto folder = files.make_folder();
    FolderT listing;
    listing.uri = folder.uri;
    std::array<std::int64_t, 6> outcomes{};
    for (size_t t = 0; t < tiles.size(); ++t) {
      for (size_t o = 0; o < outcomes.size(); ++o) outcomes[o] += tiles[t].outcomes[o];
      const MeasuredTile& measured = tiles[t].measured;
      if (measured.points.empty()) continue;
      char name[32];
      std::snprintf(name, sizeof name, "%06zu.points", t);
      const std::string path = folder.path + "/" + name;
      append_points(measured, path);
      auto entry = std::make_unique<SurfaceTileT>();
      entry->sha256 = context.digest(path), entry->uri = "sha256:" + entry->sha256 + "/" + name;
      entry->points = measured.points.size(), entry->centre = measured.centre;
      entry->factor = row_by_row(measured.factor);
      artifact.rank = static_cast<int>(measured.factor.cols());
      auto file = std::make_unique<FolderEntryT>();
      file->path = name, file->sha256 = entry->sha256, file->size = measured.points.size() * sizeof(MeasuredPoint);
      listing.files.push_back(std::move(file));
      artifact.tiles.push_back(std::move(entry));
    }
    for (size_t f = 0; f < faces.faces.size(); ++f) artifact.faces.push_back(describe(faces.faces[f], faces.guids[f]));
    artifact.measured = outcomes[0];
    std::int64_t holes = 0;
    for (size_t o = 1; o < outcomes.size(); ++o) {
      if (outcomes[o] == 0) continue;
      auto entry = std::make_unique<SurfaceHolesT>();
      entry->reason = to_string(static_cast<FacetOutcome>(o)), entry->count = outcomes[o];
      holes += outcomes[o];
      artifact.holes.push_back(std::move(entry));
    }
    artifact.warnings = faces.left_out;
    context.info(std::to_string(artifact.measured) + " points on " + std::to_string(faces.faces.size()) + " faces, " +
                 std::to_string(holes) + " holes");
    for (const auto& entry : artifact.holes) context.info("holes: " + std::to_string(entry->count) + ", " + entry->reason);
    context.metric("points", static_cast<double>(artifact.measured), "1");
    context.metric("holes", static_cast<double>(holes), "1");
    surface.commit(artifact);
    files.commit(listing);
  }
};

}  // namespace plumbline::surface

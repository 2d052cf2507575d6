#include "fuse_node.hpp"

#include <fmt/core.h>

namespace plumbline::surface {
namespace {

/// One source with where its tiles lie.
struct Source {
  SurfacePointsT points;
  std::vector<std::string> paths;
  std::vector<double> radius;  ///< of each tile [m]
};

std::string key_of(const SurfaceFaceT& face) { return face.guid.empty() ? "name " + face.id : face.guid; }

/// The faces of all sources, each once, in the order they come. Throws std::runtime_error if two sources place a face
/// differently: they are of two designs.
std::vector<const SurfaceFaceT*> faces_of_all(const std::vector<Source>& sources) {
  std::vector<const SurfaceFaceT*> faces;
  std::map<std::string, const SurfaceFaceT*> known;
  for (const Source& source : sources)
    for (const auto& face : source.points.faces) {
      const auto [found, added] = known.emplace(key_of(*face), face.get());
      if (added) {
        faces.push_back(face.get());
        continue;
      }
      const double apart = (found->second->origin - face->origin).norm();
      if (apart > 1e-6 || (found->second->out - face->out).norm() > 1e-6)
        throw std::runtime_error("the sources place the face of " + face->id + " differently, " +
                                 std::to_string(1e3 * apart) +
                                 " mm apart: they were made with different designs; make all with one");
      if (std::abs(found->second->width - face->width) > 1e-6 || std::abs(found->second->height - face->height) > 1e-6)
        throw std::runtime_error("the sources give the face of " + face->id +
                                 " different sizes: they were made with different designs; make all with one");
    }
  return faces;
}

std::vector<MeasuredTile> tiles_near(const Source& source, const PanelFace& face, double reach) {
  std::vector<MeasuredTile> tiles;
  const double radius = std::hypot(0.5 * face.width, 0.5 * face.height, reach);
  for (size_t t = 0; t < source.paths.size(); ++t)
    if ((source.points.tiles[t]->centre - face.plane.origin).norm() <= radius + source.radius[t])
      tiles.push_back(read_tile(*source.points.tiles[t], source.points.rank, source.paths[t]));
  return tiles;
}

/// A source without systematic errors among others that have them would be believed to lie where it says, and what
/// comes after could not tell: of a surface on which none has any, surface.panels says so.
void refuse_one_without_place(const std::vector<int>& ranks) {
  if (std::all_of(ranks.begin(), ranks.end(), [](int rank) { return rank == 0; })) return;
  for (size_t s = 0; s < ranks.size(); ++s)
    if (ranks[s] == 0)
      throw std::runtime_error(
          "source " + std::to_string(s + 1) + " of " + std::to_string(ranks.size()) +
          " states no systematic errors, the others do: wherever it has points a panel's place would be stated too "
          "sure; "
          "say how well it is placed (a scan: 'registration', or 'place_sigma' and 'turn_sigma' of dense.import)");
}

/// Panels without a face in one source, which another may have seen.
void take_left_out(const SurfacePointsT& source, SurfacePointsT& result) {
  for (const auto& panel : source.left_out)
    if (std::none_of(result.left_out.begin(), result.left_out.end(), [&](const auto& known) {
          return known->guid == panel->guid && known->id == panel->id && known->reason == panel->reason;
        }))
      result.left_out.push_back(std::make_unique<SurfaceLeftOutT>(*panel));
}

}  // namespace

void Fuse::run(Context& context) {
  if (surfaces.size() == 0) throw std::runtime_error("connect 'surfaces': there is nothing to bring together");
  std::vector<Source> sources(surfaces.size());
  std::vector<int> ranks;
  SurfacePointsT result;
  for (size_t s = 0; s < sources.size(); ++s) {
    Source& source = sources[s];
    source.points = surfaces.unpack(s);
    for (const auto& tile : source.points.tiles) source.paths.push_back(context.resolve(tile->uri));
    source.radius.resize(source.paths.size());
    in_parallel(context, source.paths.size(), [&](size_t t) {
      source.radius[t] = radius_of(read_tile(*source.points.tiles[t], source.points.rank, source.paths[t]));
    });
    ranks.push_back(source.points.rank), result.rank += source.points.rank;
    result.source = s == 0 || source.points.source == result.source ? source.points.source : "several sources";
    for (const auto& text : source.points.warnings)
      if (std::find(result.warnings.begin(), result.warnings.end(), text) == result.warnings.end())
        result.warnings.push_back(text);
    take_left_out(source.points, result);
    if (result.place_doubt.empty()) result.place_doubt = source.points.place_doubt;
    if (std::isfinite(source.points.search))
      result.search =
          std::isfinite(result.search) ? std::min(result.search, source.points.search) : source.points.search;
  }
  refuse_one_without_place(ranks);
  if (sources.size() == 1) context.warn("there is one source only: nothing is compared");
  FuseOptions options;
  options.cell = *cell, options.agreement = *agreement, options.least_points = static_cast<int>(*least_points);
  options.may_share_errors = *may_share_errors;
  const auto folder = files.make_folder();
  FolderT listing;
  listing.uri = folder.uri;
  FuseCounts all;
  const std::vector<const SurfaceFaceT*> faces = faces_of_all(sources);
  std::vector<PanelFace> places;
  for (const SurfaceFaceT* face : faces) places.push_back(face_of(*face));
  for (size_t f = 0; f < faces.size(); ++f) {
    context.progress(static_cast<double>(f) / static_cast<double>(faces.size()), faces[f]->id);
    if (context.cancelled()) throw Stopped();
    const PanelFace& face = places[f];
    std::vector<std::vector<MeasuredTile>> tiles;
    for (const Source& source : sources) tiles.push_back(tiles_near(source, face, *reach));
    const FusedFace fused = fuse_face(places, f, tiles, ranks, *reach, options);
    const FuseCounts& counts = fused.counts;
    all.agreed += counts.agreed, all.alone += counts.alone, all.contradicted += counts.contradicted;
    all.empty += counts.empty;
    if (counts.contradicted > 0)
      context.warn(face.id + ": the sources contradict each other on " + std::to_string(counts.contradicted) + " of " +
                   std::to_string(counts.agreed + counts.alone + counts.contradicted + counts.empty) +
                   " parts, which are holes");
    for (const MeasuredTile& tile : fused.tiles) {
      const std::string name = fmt::format("{:06}.points", result.tiles.size());
      const std::string path = folder.path + "/" + name;
      append_points(tile, path);
      auto entry = std::make_unique<SurfaceTileT>();
      entry->sha256 = context.digest(path), entry->uri = "sha256:" + entry->sha256 + "/" + name;
      entry->points = tile.points.size(), entry->centre = tile.centre, entry->factor = row_by_row(tile.factor);
      auto listed = std::make_unique<FolderEntryT>();
      listed->path = name, listed->sha256 = entry->sha256, listed->size = tile.points.size() * sizeof(MeasuredPoint);
      listing.files.push_back(std::move(listed));
      result.measured += static_cast<std::int64_t>(tile.points.size());
      result.tiles.push_back(std::move(entry));
    }
    result.faces.push_back(std::make_unique<SurfaceFaceT>(*faces[f]));
  }
  for (const auto& [reason, count] :
       {std::pair<const char*, int>{"the sources contradict each other", all.contradicted},
        {"no source has points", all.empty}}) {
    if (count == 0) continue;
    auto hole = std::make_unique<SurfaceHolesT>();
    hole->reason = reason, hole->count = count;
    result.holes.push_back(std::move(hole));
  }
  context.info(std::to_string(result.measured) + " points; of " +
               std::to_string(all.agreed + all.alone + all.contradicted + all.empty) +
               " parts several sources agree on " + std::to_string(all.agreed) + ", one alone has " +
               std::to_string(all.alone) + ", they contradict on " + std::to_string(all.contradicted));
  context.metric("points", static_cast<double>(result.measured), "1");
  context.metric("contradicted_parts", all.contradicted, "1");
  surface.commit(result);
  files.commit(listing);
}

}  // namespace plumbline::surface

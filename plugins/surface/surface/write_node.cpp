#include "write_node.hpp"

#include <filesystem>
#include <stdexcept>

#include "plumbline/stop.hpp"
#include "surface/cloud/cloud_writer.hpp"
#include "surface_artifacts.hpp"

namespace plumbline::surface {

void WriteCloud::run(Context& context) {
  const SurfacePointsT given = surface.unpack();
  std::uint64_t count = 0;
  for (const auto& tile : given.tiles) count += tile->points;
  if (count == 0) throw std::runtime_error("there is no point to write: nothing was measured");
  const auto place = folder.make_folder();
  const std::string name = "points." + *format, path = place.path + "/" + name;
  cloud::CloudWriter writer(path, *format == "las" ? cloud::CloudFormat::las : cloud::CloudFormat::ply, count,
                            given.tiles.front()->centre, *frame_name);
  for (size_t t = 0; t < given.tiles.size(); ++t) {
    if (context.cancelled()) throw Stopped();
    context.progress(static_cast<double>(t) / static_cast<double>(given.tiles.size()), "tiles");
    const MeasuredTile tile = read_tile(*given.tiles[t], given.rank, context.resolve(given.tiles[t]->uri));
    for (const MeasuredPoint& point : tile.points) writer.add(tile.at(point), point.sigma);
  }
  writer.finish();
  if (given.rank > 0)
    context.info(
        "the standard deviations in the file are those of each point by itself; what all have in common is in "
        "none of the formats");
  FolderT listing;
  listing.uri = place.uri;
  auto entry = std::make_unique<FolderEntryT>();
  entry->path = name, entry->sha256 = context.digest(path), entry->size = std::filesystem::file_size(path);
  listing.files.push_back(std::move(entry));
  folder.commit(listing);
}

}  // namespace plumbline::surface

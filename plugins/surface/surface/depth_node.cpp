#include "depth_node.hpp"

#include <fmt/core.h>

#include <cmath>
#include <filesystem>
#include <iterator>

namespace plumbline::surface {
namespace {

/// Appends the next `count` tiles if all of them are there; else none, and they are counted where they are taken.
bool all_kept(size_t count, std::vector<FacetTile>& tiles, PartialTiles& kept) {
  std::vector<FacetTile> found(count);
  for (size_t t = 0; t < count; ++t)
    if (!kept.has(tiles.size() + t)) return false;
  for (size_t t = 0; t < count; ++t)
    if (!kept.load(tiles.size() + t, found[t])) return false;
  std::move(found.begin(), found.end(), std::back_inserter(tiles));
  return true;
}

}  // namespace

void DepthNode::run(Context& context) {
  std::vector<ImageT> all;
  for (size_t i = 0; i < images.size(); ++i) all.push_back(images.unpack(i));
  const Photographs photographs(all, poses.unpack(), camera.unpack());
  for (const auto& name : photographs.without_pose()) context.warn(name + " has no pose and takes no part");
  const Faces faces = wanted_faces(context, photographs);
  const auto limit = static_cast<std::uint64_t>(*memory * 1073741824.0);
  context.reserve_memory(limit);
  PixelCache pixels(photographs, limit,
                    [&](size_t view) { return read_grey_image(context.resolve(photographs.uri(view))); });
  std::vector<FacetTile> tiles;
  std::vector<size_t> face_of_tile;
  PartialTiles kept(context);
  for (size_t f = 0; f < faces.faces.size(); ++f) {
    context.progress(static_cast<double>(f) / static_cast<double>(faces.faces.size()), faces.faces[f].id);
    const std::vector<size_t> seen = that_fit(context, photographs, faces.faces[f], limit);
    if (!all_kept(parts_of(faces.faces[f]).size(), tiles, kept))
      measure_face(context, photographs, pixels.take(seen), faces.faces[f], tiles, kept);
    face_of_tile.resize(tiles.size(), f);
    if (context.cancelled()) throw Stopped();
  }
  if (kept.found() > 0)
    context.info(std::to_string(kept.found()) + " of " + std::to_string(tiles.size()) +
                 " parts were there from a run that was stopped");
  commit(context, photographs, faces, face_of_tile, std::move(tiles));
}

Faces DepthNode::wanted_faces(Context& context, const Photographs& photographs) const {
  if (!design && !points)
    throw std::runtime_error("connect 'design', whose panels are measured, or 'points', whose plane is");
  Faces faces = design ? faces_of(design.unpack(), photographs.centres())
                       : face_through(points.unpack(), photographs.centres(), *margin);
  for (const auto& what : faces.left_out) context.warn("not measured: " + in_words(what));
  if (faces.faces.empty())
    throw std::runtime_error(
        "the design has no panel with a face that could be measured; mark the panels in it, or connect 'points' "
        "instead of 'design'");
  return faces;
}

std::vector<size_t> DepthNode::that_fit(Context& context, const Photographs& photographs, const PanelFace& face,
                                        std::uint64_t limit) const {
  std::vector<size_t> seen = photographs.that_see(face, *search);
  std::uint64_t bytes = 0;
  size_t fit = 0;
  while (fit < seen.size() && bytes + photographs.bytes(seen[fit]) <= limit) bytes += photographs.bytes(seen[fit++]);
  if (fit < seen.size())
    context.warn(face.id + ": " + std::to_string(fit) + " of " + std::to_string(seen.size()) +
                 " photographs that see it are used; 'memory' holds no more");
  seen.resize(fit);
  return seen;
}

std::vector<Rectangle> DepthNode::parts_of(const PanelFace& face) const {
  const int columns = std::max(1, static_cast<int>(std::lround(face.width / *tile)));
  const int rows = std::max(1, static_cast<int>(std::lround(face.height / *tile)));
  const Eigen::Vector2d size(face.width / columns, face.height / rows);
  std::vector<Rectangle> parts;
  for (int r = 0; r < rows; ++r)
    for (int c = 0; c < columns; ++c) {
      const Eigen::Vector2d low(c * size.x() - 0.5 * face.width, r * size.y() - 0.5 * face.height);
      parts.push_back({low, low + size});
    }
  return parts;
}

void DepthNode::commit(Context& context, const Photographs& photographs, const Faces& faces,
                       const std::vector<size_t>& face_of_tile, std::vector<FacetTile> tiles) const {
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
    const std::string name = fmt::format("{:06}.points", t);
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
  artifact.left_out = copies_of(faces.left_out);
  context.info(std::to_string(artifact.measured) + " points on " + std::to_string(faces.faces.size()) + " faces, " +
               std::to_string(holes) + " holes");
  for (const auto& entry : artifact.holes)
    context.info("holes: " + std::to_string(entry->count) + ", " + entry->reason);
  context.metric("points", static_cast<double>(artifact.measured), "1");
  context.metric("holes", static_cast<double>(holes), "1");
  surface.commit(artifact);
  files.commit(listing);
}

}  // namespace plumbline::surface

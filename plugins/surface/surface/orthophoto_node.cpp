#include "orthophoto_node.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <fstream>

#include "panels_node.hpp"
#include "photo/images/jpeg_writer.hpp"
#include "photo/images/tiff_writer.hpp"
#include "surface/dense/panel_painter.hpp"
#include "surface_artifacts.hpp"

namespace plumbline::surface {
namespace {

constexpr int kPreview = 1600;  // pixels of the smaller picture, each way

void write_text(const std::string& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  if (!(stream << text).flush()) throw std::runtime_error("cannot write " + path);
}

std::string place_of(const std::string& name, const Orthophoto& picture) {
  const Eigen::Vector3d &o = picture.plane.origin, r = picture.plane.axes.col(0), u = picture.plane.axes.col(1);
  return fmt::format("{},{},{},{:.6f},{:.6f},{:.6f},{:.6f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f},{:.9f}\n", name,
                     picture.width, picture.height, picture.pixel, o.x(), o.y(), o.z(), r.x(), r.y(), r.z(), u.x(),
                     u.y(), u.z());
}

/// Middle of the first pixel, and what a column and a row more are, on the facade.
std::string world_file(const Orthophoto& picture) {
  return fmt::format("{:.9f}\n0\n0\n{:.9f}\n{:.9f}\n{:.9f}\n", picture.pixel, -picture.pixel,
                     picture.area.low.x() + 0.5 * picture.pixel, picture.area.high.y() - 0.5 * picture.pixel);
}

std::string share_of(std::int64_t part, const PaintCounts& counts) {
  return fmt::format("{:.1f}",
                     100 * static_cast<double>(part) / static_cast<double>(std::max<std::int64_t>(1, counts.all())));
}

/// The photographs of a panel with their pixels, the best first: as many as are asked for and as `limit` [bytes] holds.
std::vector<PaintView> painters_of(const Photographs& photographs, PixelCache& pixels,
                                   const std::vector<PanelFace>& faces, size_t f, size_t most, double beyond,
                                   std::uint64_t limit) {
  const std::vector<size_t> seeing = photographs.that_see(faces[f], 0);
  std::vector<FacetView> candidates;  // geometry alone: pixels of the best ones are read
  for (const size_t view : seeing) candidates.push_back({&photographs.views()[view], nullptr});
  std::vector<size_t> chosen;
  std::uint64_t bytes = 0;
  for (const size_t number : views_for_picture(faces[f], candidates)) {
    bytes += photographs.bytes(seeing[number]);
    if (chosen.size() == most || (bytes > limit && !chosen.empty())) break;
    chosen.push_back(seeing[number]);
  }
  std::vector<PaintView> views;
  if (chosen.empty()) return views;
  for (const FacetView& view : pixels.take(chosen))
    views.push_back({view, Screens(faces, f, view.view->cam_from_world.inverse().translation, beyond)});
  return views;
}

/// A line of seams.csv.
std::string seam_of(const PanelFace& face, const std::string& guid, const std::string& facade,
                    const std::vector<PaintView>& views, const PaintCounts& counts) {
  const auto map = views.empty() ? std::nullopt : map_at(*views[0].view.view, face.plane, {0, 0, 0}, 2);
  return csv_text(face.id) + "," + csv_text(guid) + "," + facade + "," +
         (views.empty() ? "" : csv_text(views[0].view.view->name)) + "," +
         (map ? fmt::format("{:.3f}", 1e3 * map->ground_pixel()) : "") + "," + std::to_string(views.size()) + "," +
         share_of(counts.agreed, counts) + "," + share_of(counts.unchecked, counts) + "," +
         share_of(counts.contradicted, counts) + "," + share_of(counts.unseen, counts) + "\n";
}

}  // namespace

PaintCounts OrthophotoNode::paint_panel(Context& context, const PanelPainter& painter) const {
  constexpr int rows = 128;
  const int strips = std::max(0, (painter.rows() + rows - 1) / rows);
  std::vector<PaintCounts> counts(static_cast<size_t>(strips));
  in_parallel(context, counts.size(), [&](size_t s) {
    const int from = painter.first_row() + static_cast<int>(s) * rows;
    counts[s] = painter.paint(from, std::min(from + rows, painter.first_row() + painter.rows()));
  });
  PaintCounts all;
  for (const PaintCounts& of_strip : counts) all += of_strip;
  return all;
}

/// What of a panel's picture is black, and why.
void OrthophotoNode::tell(Context& context, const std::string& panel, size_t views, const PaintCounts& counts) {
  if (views == 0) {
    context.warn(panel + ": no photograph shows it; it is black in the picture");
    return;
  }
  const double all = static_cast<double>(std::max<std::int64_t>(1, counts.all()));
  if (static_cast<double>(counts.contradicted) > 0.01 * all)
    context.warn(panel + ": " + share_of(counts.contradicted, counts) +
                 " % of it is black in the picture, because photographs show different things there: something stands "
                 "before it, or it shines");
  if (static_cast<double>(counts.unseen) > 0.01 * all)
    context.warn(panel + ": " + share_of(counts.unseen, counts) +
                 " % of it is black in the picture, because no photograph shows it or another panel hides it");
}

void OrthophotoNode::run(Context& context) {
  const SurfacesT measured = panels.unpack();
  std::vector<ImageT> all;
  for (size_t i = 0; i < images.size(); ++i) all.push_back(images.unpack(i));
  const Photographs photographs(all, poses.unpack(), camera.unpack());
  const auto limit = static_cast<std::uint64_t>(*memory * 1073741824.0);
  context.reserve_memory(limit + 2 * static_cast<std::uint64_t>(*most));
  PixelCache pixels(photographs, limit,
                    [&](size_t view) { return read_grey_image(context.resolve(photographs.uri(view))); });
  std::vector<PanelFace> faces;
  for (const auto& panel : measured.panels) faces.push_back(face_of(*panel->face));
  if (faces.empty()) throw std::runtime_error("'panels' has none: there is nothing to make a picture of");
  const auto place = folder.make_folder();
  FolderT listing;
  listing.uri = place.uri;
  const auto add = [&](const std::string& name) {
    auto entry = std::make_unique<FolderEntryT>();
    entry->path = name, entry->sha256 = context.digest(place.path + "/" + name);
    entry->size = std::filesystem::file_size(place.path + "/" + name);
    listing.files.push_back(std::move(entry));
  };
  std::string table =
      "panel,guid,facade,photograph,ground_pixel_mm,photographs,agreed_pct,unchecked_pct,contradicted_pct,unseen_pct\n";
  std::string places =
      "facade,width,height,pixel_m,origin_x,origin_y,origin_z,right_x,right_y,right_z,up_x,up_y,up_z\n";
  const auto facades = facades_of(faces);
  size_t unseen = 0, done = 0;
  PaintCounts total;
  for (size_t number = 0; number < facades.size(); ++number) {
    Orthophoto picture = orthophoto_of(faces, facades[number], *pixel, *margin, *most);
    const std::string name = "facade_" + std::to_string(number + 1);
    if (picture.pixel > *pixel)
      context.warn(name + " has pixels of " +
                   fmt::format("{:.2f} mm, because with {:.2f} mm", 1e3 * picture.pixel, 1e3 * *pixel) +
                   " it would have more of them than 'most' allows");
    for (const size_t f : facades[number]) {
      context.progress(static_cast<double>(done++) / static_cast<double>(faces.size()), faces[f].id);
      const std::vector<PaintView> views =
          painters_of(photographs, pixels, faces, f, static_cast<size_t>(*compare), *margin, limit);
      const PanelSurface surface = panel_of(*measured.panels[f], measured.rank);
      const PaintCounts counts = views.empty()
                                     ? PaintCounts()
                                     : paint_panel(context, PanelPainter(faces[f], surface, views, *margin, picture));
      unseen += views.empty(), total += counts;
      tell(context, faces[f].id, views.size(), counts);
      table += seam_of(faces[f], measured.panels[f]->face->guid, name, views, counts);
    }
    write_grey_tiff(place.path + "/" + name + ".tif", picture.width, picture.height, picture.grey.data(),
                    1 / picture.pixel);
    write_grey_tiff(place.path + "/" + name + "_shown.tif", picture.width, picture.height,
                    reinterpret_cast<const std::uint8_t*>(picture.shown.data()), 1 / picture.pixel);
    write_text(place.path + "/" + name + ".tfw", world_file(picture));
    write_text(place.path + "/" + name + "_shown.tfw", world_file(picture));
    write_text(place.path + "/" + name + ".jpg", grey_jpeg(reduced(picture, kPreview)));
    for (const char* end : {".jpg", ".tfw", ".tif", "_shown.tfw", "_shown.tif"}) add(name + end);
    places += place_of(name, picture);
  }
  write_text(place.path + "/facades.csv", places);
  add("facades.csv");
  std::sort(listing.files.begin(), listing.files.end(), [](const auto& a, const auto& b) { return a->path < b->path; });
  context.info(std::to_string(facades.size()) + " pictures of " + std::to_string(faces.size() - unseen) + " panels, " +
               share_of(total.agreed, total) + " % of them as several photographs show it");
  context.metric("panels_not_seen", static_cast<double>(unseen), "1");
  context.metric("contradicted_share",
                 static_cast<double>(total.contradicted) / static_cast<double>(std::max<std::int64_t>(1, total.all())),
                 "1");
  folder.commit(listing);
  FileT file;
  file.name = "seams.csv", file.media_type = "text/csv", file.content.assign(table.begin(), table.end());
  seams.commit(file);
}

}  // namespace plumbline::surface

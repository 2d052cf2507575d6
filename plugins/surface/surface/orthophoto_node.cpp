#include "orthophoto_node.hpp"

#include <filesystem>
#include <fstream>

#include "photo/images/tiff_writer.hpp"
#include "plumbline/stop.hpp"
#include "surface/dense/orthophoto.hpp"
#include "surface_artifacts.hpp"

namespace plumbline::surface {
namespace {

std::string line_of(const char* format, auto... values) {
  char text[400];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

void write_text(const std::string& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  if (!(stream << text).flush()) throw std::runtime_error("cannot write " + path);
}

std::string place_of(const std::string& name, const Orthophoto& picture) {
  const Eigen::Vector3d &o = picture.plane.origin, r = picture.plane.axes.col(0), u = picture.plane.axes.col(1);
  return line_of("%s,%d,%d,%.6f,%.6f,%.6f,%.6f,%.9f,%.9f,%.9f,%.9f,%.9f,%.9f\n", name.c_str(), picture.width,
                 picture.height, picture.pixel, o.x(), o.y(), o.z(), r.x(), r.y(), r.z(), u.x(), u.y(), u.z());
}

/// Middle of the first pixel, and what a column and a row more are, on the facade.
std::string world_file(const Orthophoto& picture) {
  return line_of("%.9f\n0\n0\n%.9f\n%.9f\n%.9f\n", picture.pixel, -picture.pixel,
                 picture.area.low.x() + 0.5 * picture.pixel, picture.area.high.y() - 0.5 * picture.pixel);
}

}  // namespace

void OrthophotoNode::run(Context& context) {
  const SurfacesT measured = panels.unpack();
  std::vector<ImageT> all;
  for (size_t i = 0; i < images.size(); ++i) all.push_back(images.unpack(i));
  const Photographs photographs(all, poses.unpack(), camera.unpack());
  const auto limit = static_cast<std::uint64_t>(*memory * 1073741824.0);
  context.reserve_memory(limit + static_cast<std::uint64_t>(*most));
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
  std::string table = "panel,guid,facade,photograph,ground_pixel_mm\n",
              places =
                  "facade,width,height,pixel_m,origin_x,origin_y,origin_z,right_x,right_y,right_z,up_x,up_y,up_z\n";
  const StopScope stop([](const void* of) { return static_cast<const Context*>(of)->cancelled(); }, &context);
  const auto facades = facades_of(faces);
  size_t unseen = 0, done = 0;
  for (size_t number = 0; number < facades.size(); ++number) {
    Orthophoto picture = orthophoto_of(faces, facades[number], *pixel, *margin, *most);
    const std::string name = "facade_" + std::to_string(number + 1);
    if (picture.pixel > *pixel)
      context.warn(name + " has pixels of " +
                   line_of("%.2f mm, because with %.2f mm", 1e3 * picture.pixel, 1e3 * *pixel) +
                   " it would have more of them than 'most' allows");
    for (const size_t f : facades[number]) {
      context.progress(static_cast<double>(done++) / static_cast<double>(faces.size()), faces[f].id);
      std::vector<FacetView> candidates;  // geometry alone: pixels of the best one are read
      const std::vector<size_t> seeing = photographs.that_see(faces[f], 0);
      for (const size_t view : seeing) candidates.push_back({&photographs.views()[view], nullptr});
      const int best = best_view(faces[f], candidates);
      if (best < 0) ++unseen, context.warn(faces[f].id + ": no photograph shows it; it is black in the picture");
      const auto map =
          best < 0 ? std::nullopt : map_at(*candidates[static_cast<size_t>(best)].view, faces[f].plane, {0, 0, 0}, 2);
      table += csv_text(faces[f].id) + "," + csv_text(measured.panels[f]->face->guid) + "," + name + "," +
               (best < 0 ? ","
                         : csv_text(candidates[static_cast<size_t>(best)].view->name) + "," +
                               (map ? line_of("%.3f", 1e3 * map->ground_pixel()) : "")) +
               "\n";
      if (best < 0) continue;
      const FacetView view = pixels.take({seeing[static_cast<size_t>(best)]}).front();
      paint(faces[f], panel_of(*measured.panels[f], measured.rank), view, *margin, picture);
    }
    write_grey_tiff(place.path + "/" + name + ".tif", picture.width, picture.height, picture.grey.data(),
                    1 / picture.pixel);
    write_text(place.path + "/" + name + ".tfw", world_file(picture));
    add(name + ".tfw"), add(name + ".tif");
    places += place_of(name, picture);
  }
  write_text(place.path + "/facades.csv", places);
  add("facades.csv");
  std::sort(listing.files.begin(), listing.files.end(), [](const auto& a, const auto& b) { return a->path < b->path; });
  context.info(std::to_string(facades.size()) + " pictures of " + std::to_string(faces.size() - unseen) + " panels");
  context.metric("panels_not_seen", static_cast<double>(unseen), "1");
  folder.commit(listing);
  FileT file;
  file.name = "seams.csv", file.media_type = "text/csv", file.content.assign(table.begin(), table.end());
  seams.commit(file);
}

}  // namespace plumbline::surface

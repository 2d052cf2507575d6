#include "scan_joints_node.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <stdexcept>

#include "panels_node.hpp"
#include "plumbline/failure.hpp"
#include "surface/dense/common_place.hpp"
#include "surface/dense/scan_joint.hpp"
#include "surface/dense/scan_strips.hpp"
#include "surface_artifacts.hpp"

namespace plumbline::surface {
namespace {

std::string how_measured(double beam) {
  return fmt::format(
      "Joints are those of a scan. An edge lies somewhere between the last point on a panel and the next one that "
      "there would have been, and a beam of {:.1f} mm, as it was stated, shows all edges up to {:.1f} mm further out "
      "or in: widths err by up to {:.1f} mm alike. Both are in the standard uncertainties.",
      1e3 * beam, 0.5e3 * beam, 1e3 * beam);
}

/// Whether any point lies where the design has the joint.
bool has_points(const Joint& joint, const std::vector<MeasuredTile>& tiles) {
  for (const MeasuredTile& tile : tiles)
    for (const MeasuredPoint& point : tile.points) {
      const Eigen::Vector3d local = joint.plane.local(tile.at(point));
      // Places are single-precision: a tenth of a millimetre is not beside a face.
      if (std::abs(local.x()) < 0.5 * joint.width - 1e-4 && std::abs(local.y()) < 0.5 * joint.length) return true;
    }
  return false;
}

/// What lies beside its place as a whole, or is of another size, and by how much.
void tell_common(Context& context, const std::vector<CommonPlace>& places, SurfacesT& result) {
  for (const std::string& words : {words_of_common_places(places), words_of_common_scales(places)}) {
    if (words.empty()) continue;
    context.warn(words);
    result.warnings.push_back(words);
  }
  result.beside_its_place = words_of_common_places(places);
  if (result.beside_its_place.empty()) return;
  for (const CommonPlace& place : places) result.beside.push_back(describe(place));
}

}  // namespace

void ScanJoints::run(Context& context) {
  const SurfacePointsT given = points.unpack();
  if (given.source == "photographs")
    throw std::runtime_error(
        "the points come from photographs, and joints in photographs are measured by their edges: use surface.joints");
  // A panel that ends further out would seem to end where its points were cut.
  if (given.beside < *search)
    throw BadInput(fmt::format(
        "points were kept up to {:g} mm beside the faces ('beside' of dense.import), and edges are looked for up to "
        "{:g} mm from where the design has them: a panel that ends further out would seem to end there. Keep points at "
        "least so far beside the faces, or set 'search' to no more than {:g} mm",
        1e3 * given.beside, 1e3 * *search, 1e3 * given.beside));
  SurfacesT result = panels.unpack();
  std::vector<PanelFace> faces;
  std::vector<PanelSurface> measured;
  for (const auto& panel : result.panels) {
    faces.push_back(face_of(*panel->face));
    measured.push_back(panel_of(*panel, result.rank));
  }
  const std::vector<Joint> joints = joints_of(faces, *widest);
  for (const std::string& words : words_of_pairs(faces, *widest)) context.warn(words);
  if (joints.empty())
    context.warn("no two panels are nearer than " + std::to_string(*widest) + " m: there are no joints");
  ScanJointOptions options;
  options.station = *station, options.search = *search, options.beam = *beam;
  std::vector<std::string> paths;
  for (const auto& tile : given.tiles) paths.push_back(context.resolve(tile->uri));
  const auto read = [&](size_t t) { return read_tile(*given.tiles[t], given.rank, paths[t]); };
  std::vector<double> radius(given.tiles.size());
  in_parallel(context, radius.size(), [&](size_t t) { radius[t] = radius_of(read(t)); });
  std::vector<MeasuredJoint> found(joints.size());
  std::vector<char> between(joints.size());
  size_t done = 0;
  std::mutex telling;
  in_parallel(context, joints.size(), [&](size_t j) {
    const double own = std::hypot(0.5 * joints[j].length, 0.5 * joints[j].width + *search + options.strip);
    std::vector<MeasuredTile> tiles;
    for (size_t t = 0; t < given.tiles.size(); ++t)
      if ((given.tiles[t]->centre - joints[j].plane.origin).norm() <= own + radius[t]) tiles.push_back(read(t));
    found[j] = measure_scan_joint(joints[j], faces, measured, tiles, options);
    between[j] = has_points(joints[j], tiles);
    const std::lock_guard lock(telling);
    context.progress(static_cast<double>(++done) / static_cast<double>(joints.size()),
                     joints[j].a + " | " + joints[j].b);
  });
  // Else each panel would end where the design has its edge, and each joint be as wide as designed. Where points beside
  // the faces were kept, joints without one are open to what lies deeper.
  if (!(given.beside >= *search) && std::none_of(between.begin(), between.end(), [](char any) { return any; }))
    for (MeasuredJoint& joint : found)
      if (joint.not_measured.empty()) {
        joint.not_measured =
            "no point lies in any joint, as if none beside the faces had been kept (dense.import keeps them, "
            "surface.fuse does not): where panels end nobody knows";
        joint.stations.clear();
      }
  if (closed_joints(joints, found)) {
    std::vector<EmptyStrips> strips(faces.size());
    in_parallel(context, faces.size(), [&](size_t f) {
      const double own = std::hypot(0.5 * faces[f].width, 0.5 * faces[f].height);
      std::vector<MeasuredTile> tiles;
      for (size_t t = 0; t < given.tiles.size(); ++t)
        if ((given.tiles[t]->centre - faces[f].plane.origin).norm() <= own + radius[t]) tiles.push_back(read(t));
      strips[f] = empty_strips(faces[f], measured[f], tiles);
    });
    const std::string words = beside_its_place(strips, joints, found);
    if (!words.empty()) context.warn("nothing will be judged: " + words);
    if (result.place_doubt.empty()) result.place_doubt = words;
  }
  // Where nobody stated the place's errors, nothing contradicts them.
  const std::vector<CommonPlace> places_of_all =
      result.rank > 0 ? common_places(faces, measured, joints, found) : std::vector<CommonPlace>();
  tell_common(context, places_of_all, result);
  int with_figures = 0;
  for (size_t j = 0; j < joints.size(); ++j) {
    if (!found[j].not_measured.empty())
      context.warn("joint " + joints[j].a + " | " + joints[j].b + " is not measured: " + found[j].not_measured);
    with_figures += found[j].not_measured.empty();
    result.joints.push_back(describe(found[j], joints[j]));
  }
  add_pairs_without_joint(faces, *widest, result);
  Eigen::Index places = 0;
  for (const auto& joint : result.joints) places += static_cast<Eigen::Index>(joint->places.size());
  if (places > 0) add_common_errors(Eigen::MatrixXd::Constant(places, 1, *beam / std::sqrt(3.0)), result);
  if (!joints.empty()) {
    result.joints_measured = how_measured(*beam);
    context.info(result.joints_measured);
  }
  context.info(std::to_string(with_figures) + " of " + std::to_string(joints.size()) + " joints measured");
  context.metric("joints", with_figures, "1");
  surfaces.commit(result);
  table.commit(text_file("joints.csv", "text/csv", joints_table(result)));
}

}  // namespace plumbline::surface

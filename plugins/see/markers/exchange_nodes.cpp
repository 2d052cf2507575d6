#include "exchange_nodes.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <map>

#include "base/text/whole_file.hpp"
#include "control/points/control_files.hpp"
#include "control/points/image_points.hpp"
#include "observation_files.hpp"
#include "output.hpp"
#include "photo/cameras/camera_groups.hpp"
#include "photo/cameras/colmap_files.hpp"
#include "read_nodes.hpp"

namespace plumbline::markers {
namespace {

/// The centre of a square in perspective: where its diagonals meet.
Eigen::Vector2d centre_of(const TagT& tag) {
  Eigen::Vector3d c[4];
  for (size_t k = 0; k < 4; ++k) c[k] = tag.corners[k].homogeneous();
  return c[0].cross(c[2]).cross(c[1].cross(c[3])).hnormalized();
}

}  // namespace

void ReadPoints::run(Context& context) {
  const std::string text = text::read_whole(file->path);
  control::ControlOptions options;
  options.axes = *axes == "x_north"  ? control::Axes::x_north
                 : *axes == "x_east" ? control::Axes::x_east
                                     : control::Axes::as_named;
  const control::ControlTable table = control::parse_control(text, file->path, options);
  control::require_whole(table, file->path, "read.points");
  tell(table, file->path, context);
  points.commit(point_artifacts(table.points));
}

void ReadImageObservations::run(Context&) {
  observations.commit(parse_observations(text::read_whole(file->path), file->path));
}

void ReadColmap::run(Context&) {
  const cameras::ColmapModel model = cameras::read_colmap(folder->path);
  for (const CameraT& camera : camera_artifacts(model)) cameras.commit(camera);
  poses.commit(pose_artifacts(model));
  PointsT cloud;
  for (const auto& [id, p] : model.points) {
    auto point = std::make_unique<PointT>();
    point->id = std::to_string(id), point->position = p.position;
    point->sigma = Eigen::Vector3d::Constant(std::nan(""));
    cloud.points.push_back(std::move(point));
  }
  points.commit(cloud);
}

void tell(const control::ControlTable& table, const std::string& file, Context& context) {
  if (!table.axes.empty()) context.warn(file + ": " + table.axes);
  for (const std::string& warning : table.warnings) context.warn(file + ": " + warning);
  for (const std::string& note : table.notes) context.info(file + ": " + note);
  for (const ControlPoint& p : table.points)
    if (!p.correlation.isZero(0)) {
      context.warn(file + ": correlations between E, N and H are not used, the standard deviations are");
      break;
    }
}

PointsT point_artifacts(const std::vector<ControlPoint>& control) {
  PointsT result;
  for (const ControlPoint& p : control) {
    auto point = std::make_unique<PointT>();
    point->id = p.name, point->position = p.position, point->sigma = p.sigma;
    point->role = p.check ? "check" : "control";
    result.points.push_back(std::move(point));
  }
  return result;
}

std::vector<CameraT> camera_artifacts(const cameras::ColmapModel& model) {
  std::vector<CameraT> result;
  for (const auto& [id, camera] : model.cameras) {
    CameraT artifact;
    artifact.id = std::to_string(id);
    set_interior(camera.camera, {}, artifact);
    artifact.source = "COLMAP, " + camera.model;
    result.push_back(artifact);
  }
  return result;
}

PosesT pose_artifacts(const cameras::ColmapModel& model) {
  PosesT all;
  for (const auto& [id, image] : model.images) {
    auto pose = std::make_unique<PoseT>();
    pose->path = image.name, pose->cam_from_world = image.cam_from_world;
    for (const auto& f : image.features) pose->inliers += f.point >= 0;
    pose->correspondences = pose->inliers;
    all.poses.push_back(std::move(pose));
  }
  return all;
}

FolderT write_model(const cameras::ColmapModel& model, const std::string& uri, const std::string& path,
                    Context& context) {
  FolderT listing;
  listing.uri = uri;
  for (const auto& [name, text] : cameras::colmap_text(model)) {
    std::ofstream stream(path + "/" + name, std::ios::binary);
    if (!(stream << text).flush()) throw std::runtime_error("cannot write " + path + "/" + name);
    stream.close();
    auto entry = std::make_unique<FolderEntryT>();
    entry->path = name, entry->sha256 = context.digest(path + "/" + name), entry->size = text.size();
    listing.files.push_back(std::move(entry));
  }
  return listing;
}

namespace {

/// Features of the image: the centres of its tags that stand for a point.
void add_features(const ImageTagsT& seen, const std::map<std::string, std::int64_t>& point_of,
                  cameras::ColmapModel& model, cameras::ColmapImage& image) {
  for (const auto& tag : seen.tags) {
    const std::string id = std::to_string(tag->id), full = tag->family + ":" + id;
    const auto point = point_of.count(full) ? point_of.find(full) : point_of.find(id);
    if (point == point_of.end() || tag->corners.size() != 4) continue;
    model.points.at(point->second).track.emplace_back(image.id, static_cast<std::uint32_t>(image.features.size()));
    image.features.push_back({centre_of(*tag), point->second});
  }
}

}  // namespace

void WriteColmap::run(Context& context) {
  cameras::ColmapModel result;
  std::map<std::string, std::uint32_t> camera_of_name;
  for (size_t i = 0; i < cameras.size(); ++i) {
    const CameraT given = cameras.unpack(i);
    cameras::ColmapCamera camera;
    camera.id = static_cast<std::uint32_t>(i + 1), camera.camera = camera_of(given);
    camera_of_name[given.id] = camera.id;
    result.cameras[camera.id] = camera;
  }
  std::map<std::string, std::int64_t> point_of;
  const PointsT cloud = points ? points.unpack() : PointsT();
  for (const auto& p : cloud.points) {
    const auto id = static_cast<std::int64_t>(result.points.size() + 1);
    point_of[p->id] = id;
    result.points[id].position = p->position;
  }
  std::map<std::string, const ImageTagsT*> seen;
  const TagObservationsT tags = observations ? observations.unpack() : TagObservationsT();
  for (const auto& image : tags.images) seen[image->path] = image.get();
  const PosesT oriented = poses.unpack();
  for (const auto& pose : oriented.poses) {
    cameras::ColmapImage image;
    image.id = static_cast<std::uint32_t>(result.images.size() + 1), image.name = pose->path;
    const auto named = camera_of_name.find(cameras::folder_of(pose->path));
    if (result.cameras.size() != 1 && named == camera_of_name.end())
      throw std::runtime_error(pose->path + " is of none of the " + std::to_string(result.cameras.size()) +
                               " cameras: give one camera, or several that are called as the images' folders");
    image.camera = result.cameras.size() == 1 ? 1 : named->second;
    image.cam_from_world = pose->cam_from_world;
    if (const auto tags_of = seen.find(pose->path); tags_of != seen.end())
      add_features(*tags_of->second, point_of, result, image);
    result.images[image.id] = image;
  }
  if (result.images.empty()) context.warn("there is no pose: the model is empty");
  const auto folder = model.make_folder();
  model.commit(write_model(result, folder.uri, folder.path, context));
}

void WriteGcp::run(Context& context) {
  std::vector<ControlPoint> control;
  std::map<std::string, bool> known;
  const PointsT given = points.unpack();
  for (const auto& p : given.points)
    control.push_back({p->id, p->position, p->sigma, p->role == "check"}), known[p->id] = true;
  std::vector<ImagePoint> measured;
  const TagObservationsT seen = observations.unpack();
  for (const auto& image : seen.images)
    for (const auto& tag : image->tags) {
      const std::string id = std::to_string(tag->id), full = tag->family + ":" + id;
      const std::string name = known.count(full) ? full : id;
      if (known.count(name) && tag->corners.size() == 4)
        measured.push_back({image->path, name, centre_of(*tag) + Eigen::Vector2d(0.5, 0.5), 0});
    }
  if (measured.empty()) context.warn("no tag has the name of a point: the list is empty");
  file.commit(file_of("gcp_list.txt", "text/plain", control::gcp_list(control, measured, *projection)));
}

void WritePly::run(Context&) {
  constexpr double farthest = 1e9;  // [m]; more is no coordinate, and no line of a PLY file
  const PointsT given = points.unpack();
  for (const auto& p : given.points)
    if (p->position.allFinite() && p->position.cwiseAbs().maxCoeff() > farthest)
      throw std::runtime_error("point '" + p->id + "' has a coordinate beyond 1e9 m, which is none");
  std::string text = "ply\nformat ascii 1.0\nelement vertex " + std::to_string(given.points.size()) +
                     "\nproperty double x\nproperty double y\nproperty double z\nend_header\n";
  for (const auto& p : given.points) {
    text += fmt::format("{:.6f} {:.6f} {:.6f}\n", p->position.x(), p->position.y(), p->position.z());
  }
  file.commit(file_of(*name, "model/ply", text));
}

}  // namespace plumbline::markers

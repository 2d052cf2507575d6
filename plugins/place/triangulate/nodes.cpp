// triangulate.dlt, triangulate.midpoint, triangulate.angular: anchors from oriented photographs, one node over three
// ways to intersect rays.
#include <cmath>
#include <map>
#include <stdexcept>

#include "artifacts/camera_artifact.hpp"
#include "artifacts/image_tags.hpp"
#include "artifacts/plates.hpp"
#include "artifacts/points.hpp"
#include "artifacts/poses.hpp"
#include "geometry/camera.hpp"
#include "geometry/marker_plate.hpp"
#include "geometry/similarity.hpp"
#include "geometry/triangulation.hpp"
#include "plumbline/node.hpp"

namespace {

using namespace plumbline;

struct Dlt {
  static constexpr Info info{"triangulate.dlt", "triangulator", 1,
                             "Anchors from oriented photographs: linear equations of the projections"};
  static constexpr Triangulation method = Triangulation::dlt;
};
struct Midpoint {
  static constexpr Info info{"triangulate.midpoint", "triangulator", 1,
                             "Anchors from oriented photographs: least distances from the rays"};
  static constexpr Triangulation method = Triangulation::midpoint;
};
struct Angular {
  static constexpr Info info{"triangulate.angular", "triangulator", 1,
                             "Anchors from oriented photographs: least angles to the rays"};
  static constexpr Triangulation method = Triangulation::angular;
};

/// A corner in an image.
struct Sight {
  RigidTransform cam_from_world;
  Eigen::Vector2d pixel;  ///< minus what the image's principal point differs from the camera's
};

/// The four corners of a plate's tag, each from all images that see it.
using Corners = std::array<std::vector<Sight>, 4>;

/// Where `point` [m] is seen to be; without it, at the distance where the distortion is that of the nine parameters.
/// Nothing where the camera has no image.
std::optional<std::vector<PointView>> views_of(const std::vector<Sight>& sights, const CompleteCamera& lens,
                                               const std::optional<Eigen::Vector3d>& point) {
  std::vector<PointView> views;
  for (const Sight& sight : sights) {
    const auto normalised = unproject(point ? lens.at((sight.cam_from_world * *point).z()) : lens.nine, sight.pixel);
    if (!normalised) return std::nullopt;
    views.push_back({sight.cam_from_world, *normalised});
  }
  return views;
}

std::optional<Triangulated> intersect(const std::vector<Sight>& sights, const CompleteCamera& lens,
                                      Triangulation method) {
  std::optional<Triangulated> found;
  // A depth wrong by a hundredth changes the distortion by a hundredth of what it changes over the distances.
  const int passes = lens.reference_distance > 0 ? 4 : 1;
  for (int pass = 0; pass < passes; ++pass) {
    const auto views = views_of(sights, lens, found ? std::make_optional(found->point) : std::nullopt);
    found = views ? triangulate(*views, method) : std::nullopt;
    if (!found) break;
  }
  return found;
}

template <typename Engine>
struct Triangulate : Node {
  static constexpr Info info = Engine::info;
  List<ImageTags> observations{"observations", "tags of every image; images without a pose are left out"};
  In<Camera> camera{"camera", "interior orientation"};
  In<Plates> plates{"plates", frame("frame=?F"), "which tag stands for which anchor"};
  In<Poses> poses{"poses", frame("frame=?F"), "exterior orientations, taken as exact"};
  Out<Points> points{"points", frame("frame=?F"),
                     "anchors; without standard deviations, because those of the poses are not in them"};
  Param<double> min_parallax{"min_parallax", 1.0, "deg", between(0, 180),
                             "anchors whose rays meet at a smaller angle are left out"};

  void run(Context& context) override {
    const PlatesT known = plates.unpack();
    const CompleteCamera lens = complete_camera_of(camera.unpack());
    const std::vector<Corners> seen = collect(context, lens, known);
    PointsT result;
    double squares = 0;
    int corners = 0;
    for (size_t j = 0; j < seen.size(); ++j) {
      const PlateT& plate = *known.plates[j];
      std::vector<Eigen::Vector3d> shape, found;
      double parallax = 0;
      const auto drawn = tag_corners_in_plate({plate.tag_size, plate.tag_centre_in_plate});
      for (size_t k = 0; k < 4; ++k) {
        const auto corner = intersect(seen[j][k], lens, Engine::method);
        if (!corner) break;
        shape.push_back(drawn[k]);
        found.push_back(corner->point);
        parallax = std::max(parallax, corner->parallax);
        squares += corner->rms_angle * corner->rms_angle;
        ++corners;
      }
      if (found.size() < 4 || parallax < *min_parallax * M_PI / 180) {
        if (seen[j][0].empty()) continue;
        context.warn(plate.anchor + " is left out: " +
                     (seen[j][0].size() < 2 ? "only one oriented image sees it"
                      : found.size() < 4
                          ? "its rays do not meet in front of the cameras"
                          : "its rays meet at " + std::to_string(parallax * 180 / M_PI) + " degrees only"));
        continue;
      }
      auto point = std::make_unique<PointT>();
      point->id = plate.anchor;
      point->role = plate.role;
      point->position = fit_similarity(shape, found, false).translation;
      point->sigma.setConstant(std::nan(""));
      result.points.push_back(std::move(point));
    }
    if (result.points.empty()) throw std::runtime_error("no anchor is seen by two oriented images at an angle");
    context.metric("rms_angle", std::sqrt(squares / std::max(1, corners)), "rad");
    points.commit(result);
  }

 private:
  std::vector<Corners> collect(Context& context, const CompleteCamera& lens, const PlatesT& known) {
    std::map<std::pair<std::string, int>, size_t> plate_of_tag;
    for (size_t j = 0; j < known.plates.size(); ++j)
      if (!plate_of_tag.emplace(std::make_pair(known.plates[j]->tag_family, known.plates[j]->tag_id), j).second)
        throw std::runtime_error("tag " + known.plates[j]->tag_family + ":" + std::to_string(known.plates[j]->tag_id) +
                                 " stands for two anchors");
    const PosesT oriented = poses.unpack();
    std::map<std::string, const PoseT*> pose_of;
    for (const auto& pose : oriented.poses) pose_of[pose->path] = pose.get();
    std::vector<Corners> seen(known.plates.size());
    for (size_t i = 0; i < observations.size(); ++i) {
      const ImageTagsT image = observations.unpack(i);
      const auto pose = pose_of.find(image.path);
      if (pose == pose_of.end()) continue;
      const Eigen::Vector2d shift = principal_point_of(lens, *pose->second);
      std::map<size_t, std::vector<const TagT*>> tags;
      for (const auto& tag : image.tags)
        if (const auto plate = plate_of_tag.find({tag->family, tag->id}); plate != plate_of_tag.end())
          tags[plate->second].push_back(tag.get());
      for (const auto& [plate, found] : tags) {
        if (found.size() > 1) {
          context.warn("the tag of " + known.plates[plate]->anchor + " occurs " + std::to_string(found.size()) +
                       " times in " + image.path + ": left out there, because only one can be it");
          continue;
        }
        const auto& corners = found[0]->corners;
        bool usable = corners.size() == 4;
        for (size_t k = 0; k < 4 && usable; ++k)
          usable = corners[k].allFinite() && unproject(lens.nine, corners[k] - shift).has_value();
        if (!usable) {
          context.warn("the tag of " + known.plates[plate]->anchor + " in " + image.path +
                       " is left out: a corner lies where the camera has no image");
          continue;
        }
        for (size_t k = 0; k < 4; ++k) seen[plate][k].push_back({pose->second->cam_from_world, corners[k] - shift});
      }
    }
    return seen;
  }
};

}  // namespace

PLUMBLINE_PLUGIN("triangulate", PLUMBLINE_BUILD_ID, "MIT", Triangulate<Dlt>, Triangulate<Midpoint>,
                 Triangulate<Angular>)

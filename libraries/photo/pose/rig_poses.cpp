#include "photo/pose/rig_poses.hpp"

#include <algorithm>
#include <map>
#include <memory>
#include <stdexcept>

#include "geometry/packed_symmetric.hpp"
#include "photo/pose/explanation.hpp"
#include "photo/pose/image_cameras.hpp"
#include "photo/pose/tag_checks.hpp"
#include "photo/pose/tag_field.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::pose {
namespace {

struct Inputs {
  const std::vector<ImageTagsT>& images;
  const ImageCameras& cameras;
  const Field& field;
  const RigPoseSolver& solver;
  const PoseSettings& settings;
};

std::string name_of(const Moment& moment, const std::vector<ImageTagsT>& images) {
  std::string names;
  for (const RigPhotograph& p : moment.photographs) names += (names.empty() ? "" : ", ") + images[p.image].path;
  return "moment " + moment.name + " of the rig (" + names + ")";
}

/// The pose of one photograph by that of the rig; nothing if it shows no tag of the table.
std::unique_ptr<PoseT> pose_in(std::size_t view, const RigPhotograph& photograph, const std::vector<RigView>& views,
                               const std::vector<RigTag>& tags, const RigPose& found, const Inputs& in) {
  const auto here = [view](const RigTag& tag) { return tag.view == view; };
  if (std::none_of(tags.begin(), tags.end(), here)) return nullptr;
  auto pose = std::make_unique<PoseT>();
  const RigidTransform& cam_from_rig = photograph.camera->cam_from_rig;
  pose->path = in.images[photograph.image].path;
  pose->cam_from_world = cam_from_rig * found.rig_from_world;
  Eigen::Matrix<double, 6, 6> turn = Eigen::Matrix<double, 6, 6>::Zero();
  turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = cam_from_rig.rotation.toRotationMatrix();
  pose->covariance = pack_symmetric((turn * found.covariance * turn.transpose()).eval());
  pose->correspondences = static_cast<int>(4 * std::count_if(tags.begin(), tags.end(), here));
  for (std::size_t i = 0; i < tags.size(); ++i) pose->inliers += tags[i].view == view && found.inliers[i] ? 4 : 0;
  pose->rms = rms_in_view(views, tags, found, view, in.settings.robust.plate_rotation_sigma);
  return pose;
}

/// Throws NoTagPose with what is wrong, without the moment's name.
std::vector<std::unique_ptr<PoseT>> poses_of(const Moment& moment, const Inputs& in) {
  std::vector<RigView> views;
  std::vector<RigTag> tags;
  for (const RigPhotograph& photograph : moment.photographs) {
    const ImageTagsT& image = in.images[photograph.image];
    const BrownCamera& camera = in.cameras.brown(in.cameras.of(image));
    for (const auto& tag : image.tags)
      if (const Field::Entry* entry = in.field.find(*tag))
        if (const auto view = view_of(*tag, *entry, camera, in.settings)) tags.push_back({views.size(), *view});
    const double inset_sigma = image.corner_inset_sigma > 0 ? image.corner_inset_sigma : 0;  // nan: none is stated
    views.push_back({camera, photograph.camera->cam_from_rig, inset_sigma});
  }
  const std::string need = std::to_string(in.settings.min_markers);
  if (static_cast<int>(tags.size()) < in.settings.min_markers)
    throw NoTagPose("shows " + std::to_string(tags.size()) +
                    " markers that are in the plate table, in all its photographs together, needed are " + need +
                    ". Photograph it again with more markers in view, or check the plate table");
  const RigPose found = estimate_rig_pose(views, tags, in.solver, in.settings.robust);
  if (found.inlier_count < in.settings.min_markers)
    throw NoTagPose(std::to_string(found.inlier_count) + " of " + std::to_string(tags.size()) +
                    " markers agree with one pose of the rig, needed are " + need +
                    ". Check that its photographs were taken together, the rig's file, the calibrations, the tag sizes "
                    "and ids of the plate table");
  std::vector<std::unique_ptr<PoseT>> poses;
  for (std::size_t v = 0; v < views.size(); ++v)
    if (auto pose = pose_in(v, moment.photographs[v], views, tags, found, in)) poses.push_back(std::move(pose));
  return poses;
}

}  // namespace

PosesT initial_rig_poses(const std::vector<ImageTagsT>& images, const CameraT& camera, const Rig& rig,
                         const PlatesT& plates, const PointsT& points, const RigPoseSolver& solver,
                         const TagPoseSolver& central, const PoseSettings& settings,
                         const std::function<void(const std::string&)>& warn) {
  const ImageCameras cameras(camera);
  const Field field(plates, points);
  const Inputs in{images, cameras, field, solver, settings};
  PosesT result;
  result.calibration = CalibrationErrors::taken_as_exact;
  const auto cause = [&]() -> std::string {
    const std::string words =
        settings.look_for_causes ? what_would_explain(images, cameras, field, central, settings) : "";
    return words.empty() ? "" : ". Probable cause: " + words;
  };
  for (const std::string& sentence : same_photographs(images)) warn(sentence);
  for (const Moment& moment : moments_of(images, rig)) {
    stop_point();
    try {
      for (auto& pose : poses_of(moment, in)) result.poses.push_back(std::move(pose));
    } catch (const NoTagPose& error) {
      const std::string text = name_of(moment, images) + ": " + error.what();
      if (!settings.skip_poor_images)
        throw std::runtime_error(text + ", or set on_too_few: skip to go on without it" + cause());
      warn(text + "; it is left out");
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(name_of(moment, images) + ": " + error.what());
    }
  }
  if (result.poses.empty() && !images.empty())
    throw std::runtime_error("none of the " + std::to_string(images.size()) + " images could be oriented" + cause());
  std::map<std::string, std::size_t> place;
  for (std::size_t i = 0; i < images.size(); ++i) place[images[i].path] = i;
  std::sort(result.poses.begin(), result.poses.end(),
            [&](const auto& a, const auto& b) { return place.at(a->path) < place.at(b->path); });
  if (const std::string unknown = unknown_tags(images, plates); !unknown.empty()) warn(unknown);
  for (const std::string& sentence : exchanged_plates(images, result, cameras, field)) warn(sentence);
  return result;
}

}  // namespace plumbline::pose

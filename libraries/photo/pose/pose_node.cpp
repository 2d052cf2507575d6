#include "photo/pose/pose_node.hpp"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "geometry/packed_symmetric.hpp"
#include "geometry/tag_pose_errors.hpp"
#include "photo/pose/explanation.hpp"
#include "photo/pose/image_cameras.hpp"
#include "photo/pose/raw_pose.hpp"
#include "photo/pose/tag_checks.hpp"
#include "photo/pose/tag_field.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::pose {

namespace {

Eigen::Matrix2d covariance_of_corner(const TagT& tag, int i, double fallback_sigma) {
  Eigen::Matrix2d c = Eigen::Matrix2d::Identity() * fallback_sigma * fallback_sigma;
  if (tag.corner_covariances.size() == 12) {
    const double* v = tag.corner_covariances.data() + 3 * i;
    Eigen::Matrix2d given;
    given << v[0], v[1], v[1], v[2];
    if (given.allFinite() && given(0, 0) > 0 && given.determinant() > 0) c = given;
  }
  return c;
}

}  // namespace

std::optional<TagView> view_of(const TagT& tag, const Field::Entry& entry, const BrownCamera& camera,
                               const PoseSettings& settings) {
  if (tag.corners.size() != 4) return std::nullopt;
  TagView view;
  view.id = tag.id;
  view.tag_size = entry.plate->tag_size;
  view.anchor_in_world = entry.point->position;
  const Eigen::Quaterniond rotation = entry.plate->nominal_rotation.normalized();
  view.world_from_tag = {rotation, entry.point->position + rotation * entry.plate->tag_centre_in_plate};
  const Eigen::Vector3d& sigma = entry.point->sigma;
  const bool known = sigma.allFinite() && sigma.minCoeff() >= 0;
  view.anchor_covariance = (known ? sigma : Eigen::Vector3d::Constant(settings.point_sigma)).cwiseAbs2().asDiagonal();
  for (int i = 0; i < 4; ++i) {
    view.pixels[i] = tag.corners[i];
    view.pixel_covariances[i] = covariance_of_corner(tag, i, settings.pixel_sigma);
    const auto normalised = unproject(camera, tag.corners[i]);
    if (!normalised) return std::nullopt;
    view.bearings[i] = normalised->homogeneous().normalized();
  }
  return view;
}

namespace {

/// The joint covariance of points, and where each of them is in it.
class JointPoints {
 public:
  explicit JointPoints(const PointsT& points) : packed_(points.covariance) {
    const std::size_t n = 3 * points.points.size();
    if (!packed_.empty() && packed_.size() != n * (n + 1) / 2)
      throw std::runtime_error("the covariance of the " + std::to_string(points.points.size()) + " points has " +
                               std::to_string(packed_.size()) + " values, expected " + std::to_string(n * (n + 1) / 2) +
                               ": the lower triangle of all their coordinates");
    for (std::size_t i = 0; i < points.points.size(); ++i) place_[points.points[i].get()] = 3 * i;
  }
  /// 3 x 3 for each view, in their order; what is not known jointly is that of the views, and the same anchor's where
  /// two show it.
  Eigen::MatrixXd of(const std::vector<const PointT*>& anchors, const std::vector<TagView>& views) const {
    const auto n = static_cast<Eigen::Index>(views.size());
    Eigen::MatrixXd joint = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    for (Eigen::Index i = 0; i < n; ++i)
      for (Eigen::Index j = 0; j < n; ++j) {
        const PointT *a = anchors[i], *b = anchors[j];
        const bool is_known = !packed_.empty() && a->sigma.allFinite() && b->sigma.allFinite();
        for (int r = 0; is_known && r < 3; ++r)
          for (int c = 0; c < 3; ++c) {
            const std::size_t p = place_.at(a) + static_cast<std::size_t>(r),
                              q = place_.at(b) + static_cast<std::size_t>(c);
            joint(3 * i + r, 3 * j + c) = packed_[std::max(p, q) * (std::max(p, q) + 1) / 2 + std::min(p, q)];
          }
        if (!is_known && a == b) joint.block<3, 3>(3 * i, 3 * j) = views[i].anchor_covariance;
      }
    return joint;
  }

 private:
  const std::vector<double>& packed_;
  std::map<const PointT*, std::size_t> place_;
};

std::string count_of(std::size_t count, const std::string& thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

/// The pose of one image; throws with what is wrong and what to do, without the image's name.
std::unique_ptr<PoseT> pose_of(const ImageTagsT& image, const Field& field, const BrownCamera& camera,
                               const Eigen::MatrixXd& interior_covariance, const JointPoints& joint,
                               const TagPoseSolver& solver, const PoseSettings& settings) {
  std::vector<TagView> views;
  std::vector<const PointT*> anchors;
  for (const auto& tag : image.tags)
    if (const Field::Entry* entry = field.find(*tag))
      if (const auto view = view_of(*tag, *entry, camera, settings))
        views.push_back(*view), anchors.push_back(entry->point);
  const int least = settings.raw_tags > 0 ? settings.raw_tags : settings.min_markers;
  const std::string need = std::to_string(least);
  if (image.tags.empty() && !image.problem.empty()) throw NoTagPose("shows no tag: " + image.problem);
  if (static_cast<int>(views.size()) < least)
    throw NoTagPose("shows " + count_of(views.size(), "marker") + (views.size() == 1 ? " that is" : " that are") +
                    " in the plate table (" + count_of(image.tags.size(), "tag") +
                    (image.tags.size() == 1 ? " was" : " were") + " detected, " + std::to_string(field.size()) +
                    " are in the table), needed are " + need);
  const bool raw = settings.raw_tags > 0;
  TagPoseOptions robust = settings.robust;
  if (image.corner_inset_sigma > 0) robust.inset_sigma = image.corner_inset_sigma;
  const TagPose found =
      raw ? raw_tag_pose(camera, views, solver, settings.raw_tags) : estimate_tag_pose(camera, views, solver, robust);
  if (found.inlier_count < least)
    throw NoTagPose(std::to_string(found.inlier_count) + " of " + std::to_string(views.size()) +
                    " markers agree with one pose, needed are " + need);
  auto pose = std::make_unique<PoseT>();
  pose->path = image.path;
  pose->cam_from_world = found.cam_from_world;
  if (!raw)
    pose->covariance =
        pack_symmetric(covariance_with({interior_covariance, joint.of(anchors, views)}, camera, views, robust, found));
  pose->inliers = 4 * found.inlier_count;
  pose->correspondences = static_cast<int>(4 * views.size());
  pose->rms = found.rms;
  return pose;
}

/// "8 of its 11 tags are too blurred …" of an image most of whose tags are, where the detector fits edges at all.
std::string blur_in_words(const ImageTagsT& image, const std::vector<ImageTagsT>& images) {
  const auto fitted = [](const ImageTagsT& i) {
    return std::count_if(i.tags.begin(), i.tags.end(), [](const auto& tag) { return tag->refined; });
  };
  const auto all = static_cast<std::ptrdiff_t>(image.tags.size());
  if (2 * fitted(image) >= all) return "";
  if (std::none_of(images.begin(), images.end(), [&](const ImageTagsT& i) { return fitted(i) > 0; })) return "";
  return std::to_string(all - fitted(image)) + " of its " + std::to_string(all) +
         " tags are too blurred for their edges to be fitted, so their corners are rough: photograph it again, sharp "
         "and still, or set on_too_few: skip to go on without it";
}

/// What to do about an image without a pose; `cause` comes first where there is one.
std::string advice(const ImageTagsT& image, const std::vector<ImageTagsT>& images, const Field& field,
                   const PoseSettings& settings, const std::string& cause) {
  if (!cause.empty()) return "Probable cause: " + cause;
  if (const std::string blur = blur_in_words(image, images); !blur.empty()) return blur;
  if (image.tags.empty() && !image.problem.empty())
    return "Take it again or take it away; with on_too_few: skip the others are used without it";
  const auto known = std::count_if(image.tags.begin(), image.tags.end(), [&](const auto& t) { return field.find(*t); });
  if (known < settings.min_markers)
    return "Photograph it again with more markers in view, check the plate table, or set on_too_few: skip to go on "
           "without it";
  return "Its " + std::to_string(known) +
         " tags contradict each other: check the camera's calibration, the tag sizes and ids of the plate table and "
         "the "
         "approximate anchors, or set on_too_few: skip to go on without it";
}

}  // namespace

PosesT initial_poses(const std::vector<ImageTagsT>& images, const CameraT& camera, const PlatesT& plates,
                     const PointsT& points, const TagPoseSolver& solver, const PoseSettings& settings,
                     const std::function<void(const std::string&)>& warn) {
  const ImageCameras cameras(camera);
  const Field field(plates, points);
  const JointPoints joint(points);
  std::vector<Eigen::MatrixXd> interior;
  PosesT result;
  if (settings.raw_tags == 0) result.calibration = CalibrationErrors::carried;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    interior.push_back(interior_covariance_of(cameras.given(c)));
    if (interior.back().size() == 0 && settings.raw_tags == 0) result.calibration = CalibrationErrors::taken_as_exact;
  }
  std::size_t agree = 0, all = 0;
  std::optional<std::string> explanation;  // searched for once
  const auto explain = [&] {
    if (!explanation)
      explanation = settings.look_for_causes && settings.raw_tags == 0
                        ? what_would_explain(images, cameras, field, solver, settings)
                        : "";
    return *explanation;
  };
  for (const std::string& sentence : same_photographs(images)) warn(sentence);
  for (const ImageTagsT& image : images) {
    stop_point();
    try {
      const std::size_t c = cameras.of(image);
      result.poses.push_back(pose_of(image, field, cameras.brown(c), interior[c], joint, solver, settings));
      agree += static_cast<std::size_t>(result.poses.back()->inliers);
      all += static_cast<std::size_t>(result.poses.back()->correspondences);
    } catch (const NoTagPose& error) {
      const std::string text = "image " + image.path + ": " + error.what();
      if (!settings.skip_poor_images)
        throw std::runtime_error(text + ". " + advice(image, images, field, settings, explain()));
      const std::string blur = blur_in_words(image, images);
      warn(text + (blur.empty() ? "" : ", and " + blur.substr(0, blur.find(':'))) + "; it is left out");
    } catch (const std::runtime_error& error) {
      throw std::runtime_error("image " + image.path + ": " + error.what());
    }
  }
  const double share = all == 0 ? 0 : static_cast<double>(agree) / static_cast<double>(all);
  const std::string cause = share < 0.95 && !images.empty() ? explain() : "";
  if (!cause.empty()) warn("probable cause: " + cause);
  if (result.poses.empty() && !images.empty())
    throw std::runtime_error("none of the " + std::to_string(images.size()) + " images could be oriented");
  if (const std::string unknown = unknown_tags(images, plates); !unknown.empty()) warn(unknown);
  if (cause.empty())
    for (const std::string& sentence : exchanged_plates(images, result, cameras, field)) warn(sentence);
  return result;
}

PoseSettings PoseNode::settings_of(const Context& context) const {
  PoseSettings settings;
  settings.robust.plate_rotation_sigma = *plate_rotation_sigma;
  settings.robust.tag_shape_sigma = *tag_shape_sigma;
  settings.robust.inlier_probability = *inlier_probability;
  settings.robust.max_samples = static_cast<int>(*max_samples);
  settings.robust.seed = context.seed();
  settings.point_sigma = *point_sigma;
  settings.pixel_sigma = *pixel_sigma;
  settings.min_markers = static_cast<int>(*min_markers);
  settings.skip_poor_images = *on_too_few == "skip";
  settings.look_for_causes = *look_for_causes;
  settings.raw_tags = static_cast<int>(*raw_tags);
  return settings;
}

std::vector<ImageTagsT> PoseNode::images() const {
  std::vector<ImageTagsT> list;
  for (std::size_t i = 0; i < observations.size(); ++i) list.push_back(observations.unpack(i));
  return list;
}

void PoseNode::run_with(const Context& context, const TagPoseSolver& solver) {
  const PosesT result =
      initial_poses(images(), camera.unpack(), plates.unpack(), points.unpack(), solver, settings_of(context),
                    [&context](const std::string& text) { context.warn(text); });
  context.metric("images_oriented", static_cast<double>(result.poses.size()), "1");
  poses.commit(result);
}

}  // namespace plumbline::pose

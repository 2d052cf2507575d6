#include "photographs.hpp"

#include <algorithm>
#include <stdexcept>

#include "artifacts/camera_artifact.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::surface {
namespace {

size_t number_of(const std::vector<CameraT>& cameras, const std::string& id, const std::string& image) {
  if (cameras.size() == 1) return 0;
  for (size_t c = 0; c < cameras.size(); ++c)
    if (cameras[c].id == id) return c;
  throw std::runtime_error("the image " + image + " is of camera '" + id + "', and 'camera' has none of that name");
}

}  // namespace

Photographs::Photographs(const std::vector<ImageT>& images, const PosesT& poses, const CameraT& camera) {
  const std::vector<CameraT> cameras = cameras_of(camera);
  orientations_.images = static_cast<int>(poses.poses.size()), orientations_.cameras = static_cast<int>(cameras.size());
  if (poses.joint_covariance.empty())
    throw std::runtime_error(
        "the poses have no joint covariance, so nobody could say how far a surface is off as a whole; set "
        "joint_orientations: true at the adjuster that made them");
  orientations_.matrix =
      unpack_symmetric(poses.joint_covariance, static_cast<size_t>(orientations_.size()), "the orientations");
  std::map<std::string, int> pose_of;
  for (size_t p = 0; p < poses.poses.size(); ++p) pose_of[poses.poses[p]->path] = static_cast<int>(p);
  for (const ImageT& image : images) {
    const auto found = pose_of.find(image.path);
    if (found == pose_of.end()) {
      without_pose_.push_back(image.path);
      continue;
    }
    const PoseT& pose = *poses.poses[found->second];
    const size_t number = number_of(cameras, image.camera, image.path);
    const CompleteCamera complete = complete_camera_of(cameras[number]);
    View view;
    view.name = image.path;
    view.cam_from_world = pose.cam_from_world;
    view.orientation = found->second, view.camera_number = static_cast<int>(number);
    // Distance-dependent distortion as at the distance it is stated for: over a facade's depth it hardly changes.
    view.camera = complete.nine;
    const Eigen::Vector2d shift = principal_point_of(complete, pose);
    view.camera.cx += shift.x(), view.camera.cy += shift.y();
    if (image.width > 0 && (image.width != view.camera.width || image.height != view.camera.height))
      throw std::runtime_error("the image " + image.path + " has " + std::to_string(image.width) + " x " +
                               std::to_string(image.height) + " pixels, its camera " +
                               std::to_string(view.camera.width) + " x " + std::to_string(view.camera.height));
    views_.push_back(view);
    uris_.push_back(image.uri);
  }
  if (views_.empty())
    throw std::runtime_error(
        images.empty() ? "there are no photographs"
                       : "none of the " + std::to_string(images.size()) +
                             " photographs has a pose: names of images and poses do not meet, the first are '" +
                             images.front().path + "' and '" +
                             (poses.poses.empty() ? std::string() : poses.poses.front()->path) + "'");
}

std::vector<Eigen::Vector3d> Photographs::centres() const {
  std::vector<Eigen::Vector3d> centres;
  for (const View& view : views_) centres.push_back(view.cam_from_world.inverse().translation);
  return centres;
}

std::uint64_t Photographs::bytes(size_t view) const {  // with the two smaller resolutions
  return static_cast<std::uint64_t>(views_[view].camera.width) *
         static_cast<std::uint64_t>(views_[view].camera.height) * 21 / 16;
}

std::vector<size_t> Photographs::that_see(const PanelFace& face, double reach) const {
  std::vector<size_t> result;
  for (size_t k = 0; k < views_.size(); ++k) {
    bool sees = false;
    for (int i = -3; i <= 3 && !sees; ++i)
      for (int j = -3; j <= 3 && !sees; ++j)
        for (double h : {-reach, 0.0, reach})
          sees = sees || map_at(views_[k], face.plane, {i / 6.0 * face.width, j / 6.0 * face.height, h}, 4).has_value();
    if (sees) result.push_back(k);
  }
  return result;
}

std::vector<FacetView> PixelCache::take(const std::vector<size_t>& views) {
  std::uint64_t wanted = 0;
  for (size_t view : views) wanted += photographs_.bytes(view);
  if (wanted > most_)
    throw std::runtime_error("one panel is seen by " + std::to_string(views.size()) + " photographs, which take " +
                             std::to_string(wanted >> 20) + " MiB together; 'memory' allows " +
                             std::to_string(most_ >> 20) + " MiB");
  for (size_t view : views) used_.remove(view), used_.push_front(view);
  std::uint64_t missing = 0;
  for (size_t view : views)
    if (!pixels_.contains(view)) missing += photographs_.bytes(view);
  while (held_ + missing > most_) {
    held_ -= photographs_.bytes(used_.back());
    pixels_.erase(used_.back());
    used_.pop_back();
  }
  std::vector<FacetView> result;
  for (size_t view : views) {
    if (!pixels_.contains(view)) {
      pixels_.emplace(view, pyramid_of(load_(view)));
      held_ += photographs_.bytes(view);
    }
    result.push_back({&photographs_.views()[view], &pixels_.at(view)});
  }
  return result;
}

}  // namespace plumbline::surface

#include "show/report/tag_block_json.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>

#include "artifacts/camera_artifact.hpp"
#include "geometry/marker_plate.hpp"
#include "geometry/packed_symmetric.hpp"
#include "plumbline/rigid_transform.hpp"
#include "show/report/block_json_parts.hpp"

namespace plumbline::report {
namespace {

using Json = nlohmann::ordered_json;
using Corners = std::array<Eigen::Vector2d, 4>;

/// A tag in a photograph.
struct Seen {
  const TagT* tag = nullptr;
  const PlateT* plate = nullptr;
  std::optional<Corners> residuals;  ///< measured minus computed [px]; nothing if it took no part
  double rms() const {
    double sum = 0;
    for (const auto& r : *residuals) sum += r.squaredNorm();
    return std::sqrt(sum / 8);
  }
};

struct Photograph {
  const ImageTagsT* tags = nullptr;
  const PoseT* pose = nullptr;
  size_t camera = 0;
  std::vector<Seen> seen;
  double squares = 0;  ///< of the residuals [px²]
  int used = 0;        ///< tags
  double rms() const { return used ? std::sqrt(squares / (8.0 * used)) : std::nan(""); }
};

/// Where corners are drawn: both edges at each of them `inset` further in [px].
Corners drawn(const Corners& corners, double inset) {
  Corners result;
  for (size_t k = 0; k < 4; ++k) {
    const Eigen::Vector2d &at = corners[k], to = (corners[(k + 1) % 4] - at).normalized(),
                          back = (corners[(k + 3) % 4] - at).normalized();
    const double sine = std::abs(to.x() * back.y() - to.y() * back.x());
    result[k] = at + (sine > 0 ? inset / sine : 0.0) * (to + back);
  }
  return result;
}

class Converter {
 public:
  explicit Converter(const TagBlockInput& input) : in_(input), given_(cameras_of(input.camera)) {
    for (const CameraT& camera : given_) lenses_.push_back(complete_camera_of(camera));
    for (const auto& point : in_.points.points) points_[point->id] = point.get();
    for (const auto& pose : in_.poses.poses) poses_[pose->path] = pose.get();
    for (const auto& plate : in_.plates.plates) plates_[{plate->tag_family, plate->tag_id}] = plate.get();
    for (const auto& anchor : in_.block.anchors) anchors_[anchor->anchor] = anchor.get();
    for (const auto& batch : in_.block.batches) batches_[{batch->batch, batch->camera}] = batch.get();
    for (const auto& item : in_.block.rejected) rejected_.insert({item->path, item->anchor});
    for (const ImageTagsT& image : in_.observations) photographs_.push_back(photograph_of(image));
    if (std::none_of(photographs_.begin(), photographs_.end(), [](const Photograph& p) { return p.used > 0; }))
      throw std::runtime_error(
          "no tag of the observations has a plate, an adjusted point and an adjusted pose: block, points, poses, "
          "plates "
          "and observations are not of one adjustment");
  }

  Json json() const {
    Json result = head_json(in_.block);
    result["statistics"]["rms_px"] = rms_of([](const Photograph&) { return true; });
    result["cameras"] = cameras();
    result["images"] = images();
    result["points"] = points();
    result["observations"] = observations();
    result["rejected"] = rejections();
    return result;
  }

 private:
  size_t camera_of_image(const ImageTagsT& image) const {
    for (size_t c = 0; c < given_.size(); ++c)
      if (given_[c].id == image.camera) return c;
    if (given_.size() == 1) return 0;
    throw std::runtime_error("image " + image.path + " is of camera '" + image.camera + "', which was not adjusted");
  }

  double inset_of(const PlateT& plate, size_t camera) const {
    const auto own = batches_.find({plate.batch, camera == 0 ? "" : given_[camera].id});
    return own == batches_.end() || !std::isfinite(own->second->corner_inset) ? 0 : own->second->corner_inset;
  }

  Photograph photograph_of(const ImageTagsT& image) {
    Photograph photograph;
    photograph.tags = &image;
    const auto pose = poses_.find(image.path);
    if (pose == poses_.end()) return photograph;
    photograph.pose = pose->second;
    photograph.camera = camera_of_image(image);
    for (const auto& tag : image.tags) {
      const auto plate = plates_.find({tag->family, tag->id});
      if (plate == plates_.end() || tag->corners.size() != 4) continue;
      Seen seen{tag.get(), plate->second, std::nullopt};
      if (!rejected_.count({image.path, plate->second->anchor})) seen.residuals = residuals_of(photograph, seen);
      if (seen.residuals) photograph.squares += 8 * seen.rms() * seen.rms(), ++photograph.used;
      photograph.seen.push_back(seen);
    }
    return photograph;
  }

  std::optional<Corners> residuals_of(const Photograph& photograph, const Seen& seen) const {
    const auto point = points_.find(seen.plate->anchor);
    const auto anchor = anchors_.find(seen.plate->anchor);
    if (point == points_.end() || anchor == anchors_.end()) return std::nullopt;
    const auto batch = batches_.find({seen.plate->batch, ""});
    const double scale = batch == batches_.end() ? 1 : batch->second->tag_scale;
    const RigidTransform world_from_plate{anchor->second->rotation, point->second->position};
    const CompleteCamera& lens = lenses_[photograph.camera];
    const Eigen::Vector2d shift = principal_point_of(lens, *photograph.pose);
    const auto corners = tag_corners_in_plate({scale * seen.plate->tag_size, seen.plate->tag_centre_in_plate});
    Corners computed;
    for (size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3d in_camera = photograph.pose->cam_from_world * (world_from_plate * corners[k]);
      const auto pixel = project(lens.at(in_camera.z()), in_camera);
      if (!pixel) return std::nullopt;
      computed[k] = *pixel + shift;
    }
    computed = drawn(computed, inset_of(*seen.plate, photograph.camera));
    Corners residuals;
    for (size_t k = 0; k < 4; ++k) residuals[k] = seen.tag->corners[k] - computed[k];
    return residuals;
  }

  template <typename Choose>
  double rms_of(const Choose& choose) const {
    double squares = 0;
    int used = 0;
    for (const Photograph& p : photographs_)
      if (choose(p)) squares += p.squares, used += p.used;
    return used ? std::sqrt(squares / (8.0 * used)) : std::nan("");
  }

  Json cameras() const {
    Json list = Json::array();
    for (size_t c = 0; c < given_.size(); ++c) {
      const auto own = [c](const Photograph& p) { return p.pose != nullptr && p.camera == c; };
      Json entry = {{"id", given_[c].id},
                    {"source", given_[c].source},
                    {"width", given_[c].width},
                    {"height", given_[c].height},
                    {"pixel_pitch_um", 1e6 * given_[c].pixel_pitch},
                    {"images", std::count_if(photographs_.begin(), photographs_.end(), own)},
                    {"rms_px", rms_of(own)}};
      add_interior(in_.block, given_.size() > 1 ? given_[c].id : "", entry);
      for (const auto& batch : in_.block.batches)
        if (!entry.contains("corner_inset") && batch->camera == (c == 0 ? "" : given_[c].id))
          entry["corner_inset"] = batch->corner_inset, entry["corner_inset_sigma"] = batch->corner_inset_sigma;
      list.push_back(entry);
    }
    return list;
  }

  Json images() const {
    Json list = Json::array();
    for (const Photograph& p : photographs_) {
      if (!p.pose || p.used == 0) {
        const std::string why = !p.tags->problem.empty() ? p.tags->problem
                                : p.tags->tags.empty()   ? "no tag was found in it"
                                                         : "it took no part in the adjustment";
        list.push_back({{"path", p.tags->path}, {"oriented", false}, {"reason", why}});
        continue;
      }
      Eigen::AlignedBox2d box;
      for (const Seen& seen : p.seen)
        if (seen.residuals)
          for (const auto& corner : seen.tag->corners) box.extend(corner);
      const RigidTransform world_from_cam = p.pose->cam_from_world.inverse();
      const Eigen::Quaterniond& q = p.pose->cam_from_world.rotation;
      list.push_back({{"path", p.tags->path},
                      {"oriented", true},
                      {"reason", ""},
                      {"camera", given_[p.camera].id},
                      {"centre", triple(world_from_cam.translation)},
                      {"sigma", triple(sigma_of_centre(*p.pose))},
                      {"rotation", {q.w(), q.x(), q.y(), q.z()}},
                      {"tags", p.used},
                      {"rms_px", p.rms()},
                      {"coverage", box.volume() / (1.0 * given_[p.camera].width * given_[p.camera].height)}});
    }
    return list;
  }

  /// t = −R C and a step (w, d) of the pose: dC = −Rᵀ (d − w × t).
  static Eigen::Vector3d sigma_of_centre(const PoseT& pose) {
    if (pose.covariance.size() != 21) return Eigen::Vector3d::Constant(std::nan(""));
    const Eigen::MatrixXd covariance = unpack_symmetric(pose.covariance, 6, "pose of " + pose.path);
    const Eigen::Matrix3d back = pose.cam_from_world.rotation.toRotationMatrix().transpose();
    Eigen::Matrix<double, 3, 6> slope;
    slope << -back * skew(pose.cam_from_world.translation), -back;
    return (slope * covariance * slope.transpose()).diagonal().cwiseMax(0).cwiseSqrt();
  }

  Json points() const {
    Json list = Json::array();
    for (const auto& point : in_.points.points) {
      std::vector<Eigen::Vector3d> centres;
      for (const Photograph& p : photographs_)
        for (const Seen& seen : p.seen)
          if (seen.residuals && seen.plate->anchor == point->id)
            centres.push_back(p.pose->cam_from_world.inverse().translation);
      list.push_back(point_json(point->id, point->position, point->sigma, centres));
    }
    return list;
  }

  static Json measured(const Photograph& p, const Seen& seen) {
    Json corners = Json::array();
    for (const auto& corner : seen.tag->corners) corners.push_back({corner.x(), corner.y()});
    return {{"image", p.tags->path}, {"point", seen.plate->anchor}, {"corners", corners}};
  }

  Json observations() const {
    Json list = Json::array();
    for (const Photograph& p : photographs_)
      for (const Seen& seen : p.seen) {
        if (!seen.residuals) continue;
        Json entry = measured(p, seen), residuals = Json::array();
        for (const auto& r : *seen.residuals) residuals.push_back({r.x(), r.y()});
        entry["residuals"] = residuals, entry["rms_px"] = seen.rms(), entry["refined"] = seen.tag->refined;
        list.push_back(entry);
      }
    return list;
  }

  Json rejections() const {
    Json list = Json::array();
    for (const Photograph& p : photographs_)
      for (const Seen& seen : p.seen) {
        if (!rejected_.count({p.tags->path, seen.plate->anchor})) continue;
        Json entry = measured(p, seen);
        entry["reason"] =
            "its corners fail the test of the adjustment: they contradict all others of the plate or image";
        list.push_back(entry);
      }
    return list;
  }

  const TagBlockInput& in_;
  std::vector<CameraT> given_;
  std::vector<CompleteCamera> lenses_;
  std::map<std::string, const PointT*> points_;
  std::map<std::string, const PoseT*> poses_;
  std::map<std::pair<std::string, int>, const PlateT*> plates_;
  std::map<std::string, const BlockAnchorT*> anchors_;
  std::map<std::pair<std::string, std::string>, const BlockBatchT*> batches_;  // by batch and further camera
  std::set<std::pair<std::string, std::string>> rejected_;                     ///< image, anchor
  std::vector<Photograph> photographs_;
};

}  // namespace

Json tag_block_json(const TagBlockInput& input) { return Converter(input).json(); }

}  // namespace plumbline::report

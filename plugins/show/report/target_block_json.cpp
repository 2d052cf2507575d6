// block.json of a block of measured targets, from its artifacts. No library: it knows artifacts.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "geometry/packed_symmetric.hpp"
#include "photo/block/check_points.hpp"
#include "photo/bundle/lens.hpp"
#include "show/report/block_json_parts.hpp"
#include "show/report/tag_block_json.hpp"

namespace plumbline::report {
namespace {

using Json = nlohmann::ordered_json;

std::string name_of(const char* what, int id) { return std::string(what) + " " + std::to_string(id); }

/// R = Rx(ω) Ry(φ) Rz(κ), transposed: camera from block.
Eigen::Matrix3d cam_from_block(const Eigen::Vector3d& angles) {
  return (Eigen::AngleAxisd(angles.x(), Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(angles.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(angles.z(), Eigen::Vector3d::UnitZ()))
      .toRotationMatrix()
      .transpose();
}

class Converter {
 public:
  Converter(const BlockT& block, const ImageBlockT& measured)
      : block_(block), targets_(*block.targets), measured_(measured) {
    for (const auto& camera : measured.cameras) given_[camera->id] = camera.get();
    for (const auto& camera : targets_.cameras) cameras_[camera->id] = camera.get();
    for (const auto& image : targets_.images) images_[image->id] = image.get();
    for (const auto& point : targets_.points) points_[point->id] = point.get();
    for (const auto& finding : targets_.findings) findings_[{finding->image, finding->point}] = finding.get();
    for (const SensorMeasurement& m : measured.measurements) observe(m);
    judge_checks();
  }

  Json json() const {
    Json result = head_json(block_);
    const double scale = targets_.image_sigma_px / targets_.image_sigma;
    result["statistics"]["rms_px"] = scale * targets_.image_rms;
    result["cameras"] = cameras();
    result["images"] = images();
    result["points"] = points();
    if (!checks_.points.empty()) result["check_points"] = check_points();
    result["observations"] = observations_;
    result["rejected"] = Json::array();
    return result;
  }

 private:
  /// As the adjuster judges them: together where the artifact has what they have in common, else each by its own
  /// covariance and that of its survey.
  void judge_checks() {
    std::vector<std::string> names;
    std::vector<Eigen::Matrix3d> covariances;
    std::vector<Eigen::Vector3d> differences;
    for (const auto& known : targets_.control) {
      const auto point = points_.find(known->id);
      if (known->use != "check" || point == points_.end() || point->second->covariance.size() != 6) continue;
      const auto& c = point->second->covariance;
      covariances.push_back(Eigen::Matrix3d{{c[0], c[1], c[2]}, {c[1], c[3], c[4]}, {c[2], c[4], c[5]}});
      if (known->given_sigma.allFinite()) covariances.back().diagonal() += known->given_sigma.cwiseAbs2();
      names.push_back(known->id), differences.push_back(known->residual);
    }
    const auto n = 3 * static_cast<Eigen::Index>(names.size());
    Eigen::VectorXd difference(n);
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n, n);
    for (std::size_t k = 0; k < names.size(); ++k) {
      const Eigen::Index at = 3 * static_cast<Eigen::Index>(k);
      difference.segment<3>(at) = differences[k], covariance.block<3, 3>(at, at) = covariances[k];
    }
    const bool joint = targets_.check_covariance.size() == packed_size(static_cast<std::size_t>(n));
    if (joint)
      covariance = unpack_symmetric(targets_.check_covariance, static_cast<std::size_t>(n), "the check points");
    if (!names.empty()) checks_ = block::judge_check_points(names, difference, covariance, joint);
    for (const auto& check : checks_.points) check_of_[check.name] = &check;
  }

  Json check_points() const {
    Json points = Json::array();
    double largest = 0;
    for (const auto& check : checks_.points) {
      largest = std::max(largest, check.nees);
      points.push_back({{"id", check.name},
                        {"difference", triple(check.difference)},
                        {"w", triple(check.w)},
                        {"nees", check.nees},
                        {"contradicts", check.contradicts}});
    }
    return {{"holds", checks_.holds},
            {"largest_nees", largest},
            {"degrees_of_freedom_of_a_point", 3},
            {"limit_of_a_point", checks_.limit},
            {"nees", checks_.nees},  // of all that agree one by one; no degrees of freedom: not known together
            {"degrees_of_freedom", checks_.freedom},
            {"limit", checks_.joint_limit},
            {"points", points},
            {"words", checks_.words}};
  }

  double pitch_of(int camera) const {  // [mm]
    const auto given = given_.find(camera);
    return given == given_.end() ? std::nan("") : given->second->sensor_width / given->second->width;
  }
  const AdjustedSensorImageT* adjusted_image(int index) const {
    const auto found = images_.find(measured_.images.at(index)->id);
    return found == images_.end() ? nullptr : found->second;
  }

  /// Takes in one measurement; those that were left out before the adjustment have no image or point.
  void observe(const SensorMeasurement& m) {
    const AdjustedSensorImageT* image = adjusted_image(m.image());
    const auto point = points_.find(measured_.points.at(m.point())->id);
    if (!image || point == points_.end()) return;
    centres_[point->first].push_back(image->centre);
    const auto given = given_.find(image->camera);
    const auto camera = cameras_.find(image->camera);
    if (given == given_.end() || camera == cameras_.end()) return;
    const bool from_corner = camera->second->model == "correcting";
    const double pitch = pitch_of(image->camera);
    Eigen::Vector2d at(m.x() / pitch - 0.5, (from_corner ? m.y() : -m.y()) / pitch - 0.5);
    if (!from_corner) at += 0.5 * Eigen::Vector2d(given->second->width, given->second->height);
    if (at.allFinite()) boxes_[image->id].extend(at);
    const Eigen::Vector2d residual = residual_of(*image, *camera->second, point->second->position, m) / pitch;
    if (!at.allFinite() || !residual.allFinite()) return;
    Json entry = {{"image", name_of("image", image->id)},
                  {"point", point->first},
                  {"corners", {{at.x(), at.y()}}},
                  {"residuals", {{residual.x(), residual.y()}}},
                  {"rms_px", residual.norm() / std::sqrt(2.0)}};
    const auto finding = findings_.find({image->id, point->first});
    if (finding != findings_.end()) entry["largest_w"] = finding->second->w.cwiseAbs().maxCoeff();
    observations_.push_back(entry);
  }

  /// Measured minus computed, x right and y down [mm].
  static Eigen::Vector2d residual_of(const AdjustedSensorImageT& image, const AdjustedSensorCameraT& camera,
                                     const Eigen::Vector3d& position, const SensorMeasurement& m) {
    const bundle::Lens lens = camera.model == "correcting" ? bundle::Lens::correcting : bundle::Lens::balanced;
    double values[bundle::max_interior] = {};
    const auto& names = bundle::value_names(lens);
    Eigen::Vector2d observed(m.x(), m.y());
    for (const auto& p : camera.interior_orientation) {
      const auto at = std::find(names.begin(), names.end(), p->name);
      if (p->image.empty() && at != names.end()) values[at - names.begin()] = p->value;
      if (p->image == std::to_string(image.id)) observed(p->name == "x0" ? 0 : 1) -= p->value;
    }
    bundle::LensRows rows;
    const Eigen::Vector3d v = cam_from_block(image.angles) * (position - image.centre);
    if (!bundle::evaluate_lens(lens, values, camera.balance_radius, 0, v, observed, false, rows))
      return Eigen::Vector2d::Constant(std::nan(""));
    return {-rows.misclosure.x(), rows.misclosure.y()};
  }

  Json cameras() const {
    Json list = Json::array();
    for (const auto& camera : targets_.cameras) {
      Json parameters = Json::array();
      std::vector<std::string> estimated;
      for (const auto& p : camera->interior_orientation) {
        if (!p->image.empty()) continue;
        if (p->estimated) estimated.push_back(p->name);
        parameters.push_back({{"name", p->name},
                              {"value", p->value},
                              {"sigma", p->sigma},
                              {"estimated", p->estimated},
                              {"unit", "mm and its powers"}});
      }
      double squares = 0;
      int measurements = 0;
      long images = 0;
      for (const auto& image : targets_.images) {
        if (image->camera != camera->id) continue;
        squares += image->measurements * image->rms * image->rms, measurements += image->measurements, ++images;
      }
      const double pitch = pitch_of(camera->id);
      const auto given = given_.find(camera->id);
      list.push_back({{"id", name_of("camera", camera->id)},
                      {"source", "lens: " + camera->model},
                      {"width", given == given_.end() ? 0 : given->second->width},
                      {"height", given == given_.end() ? 0 : given->second->height},
                      {"images", images},
                      {"pixel_pitch_um", 1000 * pitch},
                      {"rms_px", std::sqrt(squares / std::max(1, measurements)) / pitch},
                      {"interior_orientation", parameters},
                      {"correlations", correlations_json(estimated, camera->correlations)}});
    }
    return list;
  }

  Json images() const {
    Json list = Json::array();
    for (const auto& image : targets_.images) {
      // As the page has it: x right, y down, z forward; here y goes up and the scene is at negative z.
      Eigen::Matrix3d turned = cam_from_block(image->angles);
      turned.bottomRows<2>() *= -1;
      const Eigen::Quaterniond q(turned);
      Json entry = {{"path", name_of("image", image->id)},
                    {"oriented", true},
                    {"reason", ""},
                    {"camera", name_of("camera", image->camera)},
                    {"centre", triple(image->centre)},
                    {"sigma", triple(image->centre_sigma)},
                    {"rotation", {q.w(), q.x(), q.y(), q.z()}},
                    {"tags", image->measurements},
                    {"rms_px", image->rms / pitch_of(image->camera)},
                    {"interior_correlation", image->largest_interior_correlation}};
      const auto box = boxes_.find(image->id);
      const auto given = given_.find(image->camera);
      if (box != boxes_.end() && given != given_.end())
        entry["coverage"] = box->second.volume() / (1.0 * given->second->width * given->second->height);
      list.push_back(entry);
    }
    return list;
  }

  Json points() const {
    std::map<std::string, const AdjustedControlT*> control;
    for (const auto& known : targets_.control) control[known->id] = known.get();
    Json list = Json::array();
    for (const auto& point : targets_.points) {
      const auto centres = centres_.find(point->id);
      Json entry = point_json(point->id, point->position, point->sigma,
                              centres == centres_.end() ? std::vector<Eigen::Vector3d>{} : centres->second);
      entry["rays"] = point->rays;
      if (const auto known = control.find(point->id); known != control.end()) {
        const AdjustedControlT& c = *known->second;
        entry["role"] = c.use == "check" ? "check" : "control, " + c.use;
        entry["surveyed"] = triple(c.given), entry["surveyed_sigma"] = triple(c.given_sigma);
        entry["difference"] = triple(c.residual), entry["w"] = triple(c.w);
        if (const auto check = check_of_.find(point->id); check != check_of_.end())
          entry["nees"] = check->second->nees, entry["contradicts"] = check->second->contradicts;
      }
      list.push_back(entry);
    }
    return list;
  }

  const BlockT& block_;
  const TargetBlockT& targets_;
  const ImageBlockT& measured_;
  std::map<int, const SensorCameraT*> given_;
  std::map<int, const AdjustedSensorCameraT*> cameras_;
  std::map<int, const AdjustedSensorImageT*> images_;
  std::map<std::string, const AdjustedPointT*> points_;
  std::map<std::pair<int, std::string>, const SensorFindingT*> findings_;
  std::map<std::string, std::vector<Eigen::Vector3d>> centres_;  ///< of the images that show a point
  std::map<int, Eigen::AlignedBox2d> boxes_;                     ///< of the measurements in an image [px]
  block::CheckJudgement checks_;                                 ///< no points where none was withheld
  std::map<std::string, const block::JudgedCheckPoint*> check_of_;
  Json observations_ = Json::array();
};

}  // namespace

Json target_block_json(const BlockT& block, const ImageBlockT& measured) {
  if (!block.targets) throw std::runtime_error("the block is none of measured targets; connect what it was made of");
  return Converter(block, measured).json();
}

}  // namespace plumbline::report

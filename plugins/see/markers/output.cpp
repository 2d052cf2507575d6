#include "output.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/text/csv_table.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::markers {
namespace {

using Json = nlohmann::ordered_json;  // keeps our order, 17 significant digits, nan as null

Json triple(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Json pixel(const Eigen::Vector2d& v) { return {v.x(), v.y()}; }
Json quaternion(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }
Json matrix(const Eigen::Matrix3d& m) {
  return {{m(0, 0), m(0, 1), m(0, 2)}, {m(1, 0), m(1, 1), m(1, 2)}, {m(2, 0), m(2, 1), m(2, 2)}};
}

std::string text_of(const Json& json) { return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"; }

Eigen::Vector3d sigma_of(const Eigen::Matrix3d& covariance) { return covariance.diagonal().cwiseMax(0).cwiseSqrt(); }

std::string label(const MarkerBlock& block, int marker) { return block.markers[marker].name(); }

/// Markers by family and id.
std::vector<const AdjustedMarker*> ordered(const MarkerBlock& block, const MarkerResult& result) {
  std::vector<const AdjustedMarker*> list;
  for (const auto& marker : result.markers) list.push_back(&marker);
  std::sort(list.begin(), list.end(), [&](const auto* a, const auto* b) {
    const Marker &x = block.markers[a->marker], &y = block.markers[b->marker];
    return std::tie(x.family, x.id) < std::tie(y.family, y.id);
  });
  return list;
}

Json camera_json(const MarkerCamera& given, const AdjustedMarkerCamera& camera) {
  Json parameters = Json::array(), correlations = Json::array();
  const auto values = camera.camera.parameters();
  const auto names = camera.camera.names();
  for (size_t k = 0; k < names.size(); ++k) {
    const Eigen::Index i = static_cast<Eigen::Index>(k);
    parameters.push_back({{"name", names[k]},
                          {"value", values[k]},
                          {"sigma", std::sqrt(camera.covariance(i, i))},
                          {"estimated", camera.covariance(i, i) > 0}});
    for (Eigen::Index j = 0; j < i; ++j) {
      const double scale = std::sqrt(camera.covariance(i, i) * camera.covariance(j, j));
      if (scale > 0)
        correlations.push_back(
            {{"of", names[j]}, {"with", names[k]}, {"correlation", camera.covariance(i, j) / scale}});
    }
  }
  return {{"id", given.id},
          {"source", given.source},
          {"width", camera.camera.width},
          {"height", camera.camera.height},
          {"lens", name_of(camera.camera.lens)},
          {"pixel_pitch_um", 1e6 * given.pixel_pitch},
          {"interior_orientation", parameters},
          {"correlations", correlations},
          {"scatter_of_photographs",
           {{"judged", camera.truth.empirical.judged},
            {"photographs", camera.truth.empirical.photographs},
            {"factor", camera.truth.empirical.factor}}},
          {"corner_inset", camera.inset},
          {"corner_inset_sigma", camera.inset_sigma},
          {"images", camera.images},
          {"tags", camera.views},
          {"rms_px", camera.rms}};
}

/// Largest angle between two rays to a tag [rad].
std::map<int, double> largest_angles(const MarkerBlock& block, const MarkerResult& result) {
  std::map<int, std::vector<Eigen::Vector3d>> rays;
  for (const auto& seen : result.views) {
    const MarkerView& view = block.views[seen.view];
    const auto marker = std::find_if(result.markers.begin(), result.markers.end(),
                                     [&](const auto& m) { return m.marker == view.marker; });
    if (marker == result.markers.end()) continue;
    rays[view.marker].push_back((result.images[view.image].centre - marker->world_from_tag.translation).normalized());
  }
  std::map<int, double> angles;
  for (const auto& [marker, list] : rays) {
    double smallest = 1;
    for (size_t i = 0; i < list.size(); ++i)
      for (size_t j = i + 1; j < list.size(); ++j) smallest = std::min(smallest, list[i].dot(list[j]));
    angles[marker] = std::acos(std::clamp(smallest, -1.0, 1.0));
  }
  return angles;
}

/// Part of the photograph that its tags cover, as the area of their bounding box over the image's.
std::vector<double> coverages(const MarkerBlock& block, const MarkerResult& result) {
  std::vector<Eigen::AlignedBox2d> boxes(block.images.size());
  for (const auto& seen : result.views) {
    const MarkerView& view = block.views[seen.view];
    for (const auto& c : view.corners) boxes[view.image].extend(c);
  }
  std::vector<double> parts;
  for (size_t i = 0; i < boxes.size(); ++i) {
    const BrownCamera& camera = result.cameras[block.images[i].camera].camera;
    parts.push_back(boxes[i].isEmpty() ? 0 : boxes[i].volume() / (static_cast<double>(camera.width) * camera.height));
  }
  return parts;
}

Json image_json(const MarkerBlock& block, const AdjustedMarkerImage& image) {
  const MarkerImage& given = block.images[image.image];
  Json entry = {{"path", given.path}, {"oriented", image.oriented}, {"reason", image.reason}};
  if (!image.oriented) return entry;
  entry["camera"] = block.cameras[given.camera].id;
  entry["centre"] = triple(image.centre);
  entry["sigma"] = triple(sigma_of(image.covariance.topLeftCorner<3, 3>()));
  entry["rotation"] = quaternion(image.cam_from_world.rotation);
  entry["rotation_matrix"] = matrix(image.cam_from_world.rotation.toRotationMatrix());
  entry["rotation_sigma"] = triple(sigma_of(image.covariance.bottomRightCorner<3, 3>()));
  entry["tags"] = image.tags;
  entry["rms_px"] = image.rms;
  if (image.other_centre) {
    entry["other_centre"] = triple(*image.other_centre);
    entry["ambiguity"] = image.ambiguity;
  }
  return entry;
}

Json halves_json(const MarkerHalves& halves) {
  return {{"by", halves.by == HalvesBy::turns  ? "turns"
                 : halves.by == HalvesBy::time ? "time"
                                               : "place"},
          {"tags", halves.tags},
          {"rms", halves.rms},
          {"variance_factor", halves.variance},
          {"degrees_of_freedom", halves.freedom},
          {"camera_variance_factor", halves.camera_variance},
          {"camera_degrees_of_freedom", halves.camera_freedom}};
}

Json statistics_json(const MarkerResult& result, const std::vector<MarkerHalves>& halves) {
  Json entry = {{"sigma0", result.sigma0},
                {"degrees_of_freedom", result.degrees_of_freedom},
                {"weighted_sum_of_squares", result.weighted_sum_of_squares},
                {"observations", result.observations},
                {"unknowns", result.unknowns},
                {"datum_defect", result.datum_defect},
                {"rms_px", result.rms}};
  if (halves.empty()) return entry;
  entry["halves"] = halves_json(halves.front());
  entry["parts"] = Json::array();
  for (const MarkerHalves& each : halves) entry["parts"].push_back(halves_json(each));
  return entry;
}

Json left_out_json(const BlockInput& input, const MarkerResult& result) {
  Json list = Json::array();
  for (const auto& image : input.left_out) list.push_back(image.path + ": " + image.reason);
  for (const auto& text : result.left_out) list.push_back(text);
  return list;
}

Json warnings_json(const BlockInput& input, const MarkerResult& result) {
  Json list = Json::array();
  for (const auto& text : result.warnings) list.push_back(text);
  for (const auto& text : input.warnings) list.push_back(text);
  return list;
}

std::string csv_number(double value, int decimals) {
  const std::string text = fmt::format("{:.{}f}", value, decimals);
  return std::isfinite(value) ? text : "";
}

}  // namespace

FileT file_of(const std::string& name, const std::string& media_type, const std::string& text) {
  FileT file;
  file.name = name, file.media_type = media_type;
  file.content.assign(text.begin(), text.end());
  return file;
}

std::string tags_json(const MarkerBlock& block, const MarkerResult& result) {
  Json tags = Json::array();
  for (const AdjustedMarker* marker : ordered(block, result)) {
    const Marker& m = block.markers[marker->marker];
    Json corners = Json::array();
    for (const auto& corner : marker->corners) corners.push_back(triple(corner));
    tags.push_back({{"id", m.id},
                    {"family", m.family},
                    {"centre", triple(marker->world_from_tag.translation)},
                    {"corners", corners},
                    {"sigma", triple(sigma_of(marker->centre_covariance))},
                    {"rotation", quaternion(marker->world_from_tag.rotation)},
                    {"rotation_sigma", triple(sigma_of(marker->rotation_covariance))},
                    {"size", m.size * marker->scale},
                    {"size_sigma", m.size * marker->scale_sigma},
                    {"images", marker->images}});
  }
  return text_of({{"unit", "m"},
                  {"frame", result.datum},
                  {"scale_sigma", result.scale_sigma},
                  {"sigma_is",
                   "standard deviation of the centre in the network's own scale; scale_sigma, relative, "
                   "holds for all lengths together"},
                  {"corner_order", "bottom left, bottom right, top right, top left of the upright tag"},
                  {"rotation_is", "frame from tag, quaternion w, x, y, z"},
                  {"tags", tags}});
}

namespace {

Json points_json(const MarkerBlock& block, const MarkerResult& result) {
  Json points = Json::array();
  const auto angles = largest_angles(block, result);
  for (const AdjustedMarker* marker : ordered(block, result)) {
    const auto angle = angles.find(marker->marker);
    Json entry = {{"id", label(block, marker->marker)},
                  {"position", triple(marker->world_from_tag.translation)},
                  {"sigma", triple(sigma_of(marker->centre_covariance))},
                  {"rays", marker->images},
                  {"largest_angle_deg", angle == angles.end() ? 0.0 : angle->second * 180 / M_PI},
                  {"size_ratio", marker->scale},
                  {"size_ratio_sigma", marker->scale_sigma}};
    Json corners = Json::array();
    for (const auto& corner : marker->corners) corners.push_back(triple(corner));
    entry["corners"] = corners;
    points.push_back(entry);
  }
  return points;
}

Json observations_json(const MarkerBlock& block, const MarkerResult& result) {
  Json observations = Json::array();
  for (const auto& seen : result.views) {
    const MarkerView& view = block.views[seen.view];
    Json corners = Json::array(), residuals = Json::array();
    for (size_t k = 0; k < 4; ++k)
      corners.push_back(pixel(view.corners[k])), residuals.push_back(pixel(seen.residuals[k]));
    observations.push_back({{"image", block.images[view.image].path},
                            {"point", label(block, view.marker)},
                            {"corners", corners},
                            {"residuals", residuals},
                            {"rms_px", seen.rms},
                            {"largest_w", seen.largest_w},
                            {"smallest_redundancy_number", seen.smallest_redundancy},
                            {"refined", view.refined}});
  }
  return observations;
}

Json rejected_json(const MarkerBlock& block, const MarkerResult& result) {
  Json rejected = Json::array();
  for (const int v : result.rejected) {
    const MarkerView& view = block.views[v];
    Json corners = Json::array();
    for (const auto& c : view.corners) corners.push_back(pixel(c));
    rejected.push_back({{"image", block.images[view.image].path},
                        {"point", label(block, view.marker)},
                        {"corners", corners},
                        {"reason", "its residuals are more than 5 times those of the median tag"}});
  }
  return rejected;
}

}  // namespace

std::string block_json(const BlockInput& input, const MarkerResult& result, const std::vector<MarkerHalves>& halves) {
  const MarkerBlock& block = input.block;
  Json groups = Json::array(), cameras = Json::array(), images = Json::array();
  for (const auto& group : result.groups)
    groups.push_back({{"name", group.name},
                      {"observations", group.rows},
                      {"weighted_sum_of_squares", group.sum_of_squares},
                      {"redundancy", group.redundancy},
                      {"variance_factor", group.factor}});
  for (size_t c = 0; c < block.cameras.size(); ++c) cameras.push_back(camera_json(block.cameras[c], result.cameras[c]));
  const std::vector<double> covered = coverages(block, result);
  for (const auto& image : result.images) {
    Json entry = image_json(block, image);
    if (image.oriented) entry["coverage"] = covered[image.image];
    images.push_back(entry);
  }
  return text_of({{"kind", "block of tags"},
                  {"unit", "m"},
                  {"datum", result.datum},
                  {"scale_sigma", result.scale_sigma},
                  {"statistics", statistics_json(result, halves)},
                  {"groups", groups},
                  {"cameras", cameras},
                  {"images", images},
                  {"points", points_json(block, result)},
                  {"observations", observations_json(block, result)},
                  {"scale_bars", Json::array()},
                  {"rejected", rejected_json(block, result)},
                  {"left_out", left_out_json(input, result)},
                  {"warnings", warnings_json(input, result)}});
}

std::string poses_json(const BlockInput& input, const MarkerResult& result) {
  std::map<std::string, Json> by_path;
  for (const auto& image : result.images)
    by_path[input.block.images[image.image].path] = image_json(input.block, image);
  for (const auto& image : input.left_out)
    by_path[image.path] = {{"path", image.path}, {"oriented", false}, {"reason", image.reason}};
  Json images = Json::array();
  for (auto& [path, entry] : by_path) images.push_back(entry);
  return text_of({{"unit", "m"},
                  {"rotation_is", "camera from world, quaternion w, x, y, z; camera x right, y down, z forward"},
                  {"datum", result.datum},
                  {"images", images}});
}

std::string points_csv(const MarkerBlock& block, const MarkerResult& result) {
  std::string text =
      "id,family,x_m,y_m,z_m,sigma_x_m,sigma_y_m,sigma_z_m,images,from_layout_x_m,from_layout_y_m,"
      "from_layout_z_m\n";
  for (const AdjustedMarker* marker : ordered(block, result)) {
    const Marker& m = block.markers[marker->marker];
    text += text::csv_field(m.name()) + "," + text::csv_field(m.family);
    const Eigen::Vector3d sigma = sigma_of(marker->centre_covariance), at = marker->world_from_tag.translation;
    for (int k = 0; k < 3; ++k) text += "," + csv_number(at(k), 6);
    for (int k = 0; k < 3; ++k) text += "," + csv_number(sigma(k), 6);
    text += "," + std::to_string(marker->images);
    for (int k = 0; k < 3; ++k)
      text += "," + (m.world_from_tag ? csv_number(at(k) - m.world_from_tag->translation(k), 6) : "");
    text += "\n";
  }
  return text;
}

PointsT points_of(const MarkerBlock& block, const MarkerResult& result) {
  PointsT points;
  for (const auto& marker : result.markers) {
    auto point = std::make_unique<PointT>();
    point->id = label(block, marker.marker);
    point->position = marker.world_from_tag.translation;
    point->sigma = sigma_of(marker.centre_covariance);
    points.points.push_back(std::move(point));
  }
  points.covariance = pack_symmetric(result.centre_covariance);
  return points;
}

PosesT poses_of(const MarkerBlock& block, const MarkerResult& result) {
  PosesT poses;
  for (const auto& image : result.images) {
    if (!image.oriented) continue;
    auto pose = std::make_unique<PoseT>();
    pose->path = block.images[image.image].path;
    pose->cam_from_world = image.cam_from_world;
    // (C, δ) to (δ, t): t = −exp(δ) R C, dt = −R dC − [t]× δ.
    Eigen::Matrix<double, 6, 6> jacobian = Eigen::Matrix<double, 6, 6>::Zero();
    jacobian.topRightCorner<3, 3>().setIdentity();
    jacobian.bottomLeftCorner<3, 3>() = -image.cam_from_world.rotation.toRotationMatrix();
    jacobian.bottomRightCorner<3, 3>() = -skew(image.cam_from_world.translation);
    pose->covariance = pack_symmetric((jacobian * image.covariance * jacobian.transpose()).eval());
    pose->inliers = 4 * image.tags;
    pose->correspondences = 4 * image.tags;
    pose->rms = image.rms;
    poses.poses.push_back(std::move(pose));
  }
  return poses;
}

CameraT camera_artifact(const MarkerCamera& camera, const AdjustedMarkerCamera& adjusted) {
  CameraT artifact;
  artifact.id = camera.id;
  set_interior(adjusted.camera, adjusted.covariance, artifact);
  artifact.source = camera.source;
  return artifact;
}

}  // namespace plumbline::markers

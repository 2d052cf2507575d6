#include "colmap_node.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "base/text/whole_file.hpp"
#include "control/points/control_files.hpp"
#include "control/points/image_points.hpp"
#include "exchange_nodes.hpp"
#include "output.hpp"
#include "photo/markers/control_block.hpp"
#include "read_nodes.hpp"

namespace plumbline::markers {
namespace {

using Json = nlohmann::ordered_json;

Json vector(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json cameras_json(const ControlResult& result) {
  Json cameras = Json::array();
  for (const auto& [id, camera] : result.model.cameras) {
    const Eigen::MatrixXd& c = result.camera_covariance.at(id);
    Json parameters = Json::array(), correlations = Json::array();
    const auto values = camera.camera.parameters();
    const auto names = camera.camera.names();
    for (size_t k = 0; k < names.size(); ++k) {
      const Eigen::Index i = static_cast<Eigen::Index>(k);
      parameters.push_back(
          {{"name", names[k]}, {"value", values[k]}, {"sigma", std::sqrt(c(i, i))}, {"estimated", c(i, i) > 0}});
      for (Eigen::Index j = 0; j < i; ++j)
        if (c(i, i) * c(j, j) > 0)
          correlations.push_back(
              {{"of", names[j]}, {"with", names[k]}, {"correlation", c(i, j) / std::sqrt(c(i, i) * c(j, j))}});
    }
    double squares = 0;
    int images = 0, points = 0;
    for (const auto& [image_id, image] : result.model.images) {
      if (image.camera != id || !result.image_rms.count(image_id)) continue;
      const int n = result.image_points.at(image_id);
      squares += std::pow(result.image_rms.at(image_id), 2) * n, points += n, ++images;
    }
    cameras.push_back({{"id", "camera " + std::to_string(id)},
                       {"source", "COLMAP, " + camera.model},
                       {"width", camera.camera.width},
                       {"height", camera.camera.height},
                       {"interior_orientation", parameters},
                       {"correlations", correlations},
                       {"images", images},
                       {"rms_px", points ? std::sqrt(squares / points) : 0}});
  }
  return cameras;
}

/// Part of each photograph that its points cover, as the area of their bounding box over the image's.
std::map<std::string, double> coverages(const ControlResult& result) {
  std::map<std::string, Eigen::AlignedBox2d> boxes;
  for (const auto& o : result.observations) boxes[o.image].extend(o.pixel);
  std::map<std::string, double> parts;
  for (const auto& [id, image] : result.model.images) {
    const BrownCamera& camera = result.model.cameras.at(image.camera).camera;
    const auto box = boxes.find(image.name);
    parts[image.name] = box == boxes.end() || camera.width <= 0 || camera.height <= 0
                            ? 0
                            : box->second.volume() / (static_cast<double>(camera.width) * camera.height);
  }
  return parts;
}

Json images_json(const ControlResult& result) {
  Json images = Json::array();
  const auto covered = coverages(result);
  for (const auto& [id, image] : result.model.images) {
    const auto covariance = result.pose_covariance.find(id);
    Json entry = {
        {"path", image.name},
        {"oriented", true},
        {"reason",
         covariance == result.pose_covariance.end() ? "too few points took part: it kept its place in the model" : ""},
        {"camera", "camera " + std::to_string(image.camera)},
        {"centre", vector(image.cam_from_world.inverse().translation)}};
    if (covariance != result.pose_covariance.end())
      entry["sigma"] = vector(covariance->second.diagonal().head<3>().cwiseSqrt());
    const Eigen::Quaterniond& q = image.cam_from_world.rotation;
    entry["rotation"] = {q.w(), q.x(), q.y(), q.z()};
    if (result.image_rms.count(id))
      entry["tags"] = result.image_points.at(id), entry["rms_px"] = result.image_rms.at(id);
    entry["coverage"] = covered.at(image.name);
    images.push_back(entry);
  }
  return images;
}

Json points_json(const ControlResult& result) {
  Json points = Json::array();
  for (const auto& p : result.points) {
    if (!p.used) continue;
    points.push_back({{"id", p.name},
                      {"role", role_of(p)},
                      {"contradicts", p.contradicts || p.aside},
                      {"position", vector(p.position)},
                      {"sigma", vector(p.covariance.diagonal().cwiseSqrt())},
                      {"surveyed", vector(p.surveyed)},
                      {"surveyed_sigma", vector(p.surveyed_sigma)},
                      {"difference", vector(p.position - p.surveyed)},
                      {"w", vector(p.w)},
                      {"nees", std::isfinite(p.nees) ? Json(p.nees) : Json()},
                      {"rays", p.rays},
                      {"largest_angle_deg", p.largest_angle * 180 / M_PI},
                      {"rms_px", p.rms}});
  }
  return points;
}

Json observations_json(const ControlResult& result) {
  Json observations = Json::array();
  for (const auto& o : result.observations)
    observations.push_back({{"image", o.image},
                            {"point", o.point},
                            {"control", o.control},
                            {"corners", {{o.pixel.x(), o.pixel.y()}}},
                            {"residuals", {{o.residual.x(), o.residual.y()}}},
                            {"rms_px", o.residual.norm() / std::sqrt(2.0)},
                            {"largest_w", o.w}});
  return observations;
}

std::string block_text(const ControlResult& result) {
  Json groups = Json::array(), warnings = Json::array(), left_out = Json::array();
  for (const auto& g : result.groups)
    groups.push_back({{"name", g.name},
                      {"observations", g.rows},
                      {"weighted_sum_of_squares", g.sum_of_squares},
                      {"redundancy", g.redundancy},
                      {"variance_factor", g.factor}});
  for (const auto& w : result.warnings) warnings.push_back(w);
  for (const auto& l : result.left_out) left_out.push_back(l);
  Json checks;
  if (result.checks)
    checks = {{"points", result.checks->points.size()},
              {"holds", result.checks->holds},
              {"limit_of_a_point", result.checks->limit},
              {"nees", result.checks->nees},
              {"degrees_of_freedom", result.checks->freedom},
              {"limit", result.checks->joint_limit},
              {"words", result.checks->words}};
  const Json root = {
      {"kind", "COLMAP model with control"},
      {"unit", "m"},
      {"datum", "the surveyed control points with their standard deviations; one unit of the model was " +
                    std::to_string(result.scale) + " m"},
      {"statistics",
       {{"sigma0", result.sigma0},
        {"degrees_of_freedom", result.degrees_of_freedom},
        {"weighted_sum_of_squares", result.weighted_sum_of_squares},
        {"observations", result.n_observations},
        {"unknowns", result.unknowns},
        {"datum_defect", 0},
        {"rms_px", result.rms},
        {"tie_points", result.tie_points},
        {"rejected_tie_observations", result.rejected}}},
      {"groups", groups},
      {"cameras", cameras_json(result)},
      {"images", images_json(result)},
      {"points", points_json(result)},
      {"observations", observations_json(result)},
      {"check_points", checks},
      {"scale_bars", Json::array()},
      {"rejected", Json::array()},
      {"left_out", left_out},
      {"warnings", warnings}};
  return root.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// How far control was moved; without check points it is all there is, and no evidence.
void tell_control(const ControlResult& result, Context& context) {
  double squares = 0, largest = 0;
  int count = 0;
  for (const auto& point : result.points) {
    if (!point.used || point.check || point.aside) continue;
    const double square = (point.position - point.surveyed).squaredNorm();
    squares += square, largest = std::max(largest, square), ++count;
  }
  context.metric("control_points", count, "1");
  context.metric("control_scatter", result.control_scatter, "1");
  if (count) {
    context.metric("control_rms_3d", std::sqrt(squares / count), "m");
    context.metric("control_largest_3d", std::sqrt(largest), "m");
  }
  if (!result.checks)
    context.warn(
        "no check points: what control points were moved by says how well they fit, not how accurate the "
        "model is. A control point with the role check takes no part and judges it");
}

}  // namespace

void AdjustColmapControl::run(Context& context) {
  if (sparse ? !model->path.empty() : model->path.empty())
    throw std::runtime_error("give the model either as the folder 'model' or as the input 'sparse'");
  const std::string model_folder = sparse ? context.resolve(sparse.unpack().uri) : model->path;
  ControlOptions options;
  options.control_sigma = *control_sigma, options.measured_sigma = *measured_sigma, options.tie_sigma = *tie_sigma;
  options.self_calibration = *self_calibration, options.max_tie_points = static_cast<int>(*max_tie_points),
  options.reject_above = *reject_above, options.robust_control = *robust_control;
  if (static_cast<bool>(measured) == !observations->path.empty())
    throw std::runtime_error("give either 'observations', a file, or connect 'measured'");
  const FileT table_of = measured ? measured.unpack() : FileT();
  const std::vector<ImagePoint> pixels =
      measured ? control::parse_image_points({table_of.content.begin(), table_of.content.end()}, table_of.name, false)
               : control::parse_image_points(text::read_whole(observations->path), observations->path,
                                             *pixel_origin == "corner");
  const control::ControlTable known = control::parse_control(text::read_whole(control->path), control->path);
  control::require_whole(known, control->path, "adjust.colmap_control");
  tell(known, control->path, context);
  const std::vector<ControlPoint>& surveyed = known.points;
  ControlResult result;
  try {
    adjust_with_control(cameras::read_colmap(model_folder), surveyed, pixels, options, result);
  } catch (const std::exception&) {  // what was noticed before may be why
    for (const auto& text : result.warnings) context.warn(text);
    throw;
  }
  for (const auto& text : result.warnings) context.warn(text);
  for (const auto& text : result.left_out) context.warn("left out: " + text);
  context.metric("rms", result.rms, "px");
  context.metric("sigma0", result.sigma0, "1");
  context.metric("degrees_of_freedom", result.degrees_of_freedom, "1");
  tell_control(result, context);
  if (result.checks) {
    double squares = 0;
    for (const auto& point : result.checks->points) squares += point.difference.squaredNorm();
    context.metric("check_points", static_cast<double>(result.checks->points.size()), "1");
    context.metric("check_rmse_3d", std::sqrt(squares / static_cast<double>(result.checks->points.size())), "m");
    context.metric("check_nees", result.checks->nees, "1");
    context.metric("check_freedom", result.checks->freedom, "1");
    context.metric("invalid", result.checks->holds ? 0 : 1, "1");
  }
  block.commit(file_of("block.json", "application/json", block_text(result)));
  table.commit(file_of("points.csv", "text/csv", control_table(result)));
  const auto folder = adjusted.make_folder();
  adjusted.commit(write_model(result.model, folder.uri, folder.path, context));
  for (const CameraT& camera : camera_artifacts(result.model)) cameras.commit(camera);
  poses.commit(pose_artifacts(result.model));
  points.commit(point_artifacts(surveyed));
}

}  // namespace plumbline::markers

#include "photo/markers/control_block.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "base/text/csv_table.hpp"
#include "geometry/statistics.hpp"
#include "photo/block/control_words.hpp"
#include "photo/markers/control_adjustment.hpp"
#include "photo/markers/robust_similarity.hpp"

namespace plumbline::markers {
namespace {

/// Three digits, as many as anybody reads.
std::string short_number(double value) { return fmt::format("{:.3g}", value); }

void transform(cameras::ColmapModel& model, const SimilarityMotion& motion) {
  for (auto& [id, image] : model.images) {
    const Eigen::Vector3d centre = motion * image.cam_from_world.inverse().translation;
    image.cam_from_world.rotation = (image.cam_from_world.rotation * motion.rotation.conjugate()).normalized();
    image.cam_from_world.translation = -(image.cam_from_world.rotation * centre);
  }
  for (auto& [id, point] : model.points) point.position = motion * point.position;
}

/// The model into the survey's frame (minus `origin`) by its control points, without those that disagree grossly.
void align(cameras::ColmapModel& model, std::vector<Target>& targets, ControlResult& result) {
  std::vector<Eigen::Vector3d> from, to;
  std::vector<Target*> used;
  for (Target& t : targets) {
    if (!t.control) continue;
    const auto at = intersect(model, t.rays);
    if (!at) continue;
    t.position = *at;
    if (t.control->check) continue;
    from.push_back(*at), to.push_back(t.control->position - result.origin), used.push_back(&t);
  }
  if (from.size() < 3)
    throw std::runtime_error(std::to_string(from.size()) +
                             " control points are measured in two photographs or more; at least 3 are needed that "
                             "are not on one line, better 5 or more spread over the object");
  block::require_same_hand(from, to);
  RobustSimilarity fit;
  try {
    fit = fit_similarity_robustly(from, to, 0.05);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error("the model cannot be brought to the control points: " + std::string(error.what()));
  }
  for (size_t m = 0; m < used.size(); ++m) {
    if (fit.agrees[m]) continue;
    result.warnings.push_back("control point " + used[m]->name + " lies " + short_number(fit.distances[m]) +
                              " m from where the model and the other control points have it: it is left out. Is "
                              "its name or a measurement wrong?");
    used[m]->rays.clear();
  }
  result.scale = fit.motion.scale;
  transform(model, fit.motion);
  for (Target& t : targets) t.position = fit.motion * t.position;
}

/// All control points together: standard deviations that nobody stated, or stated too small.
void warn_about_control(const std::vector<ControlPoint>& control, const ControlOptions& options,
                        ControlResult& result) {
  const bool assumed =
      std::any_of(control.begin(), control.end(), [](const ControlPoint& p) { return std::isnan(p.sigma.sum()); });
  const std::string whose =
      assumed ? ", which their file does not state (" + short_number(options.control_sigma) + " m is assumed): say them"
              : ": they are too small, or points are confused";
  if (result.control_scatter > 1) {
    result.warnings.push_back("the control points scatter " + short_number(result.control_scatter) +
                              " times as much as their standard deviations say" + whose +
                              ". They are taken as so much larger, and with them those of the result grow");
    return;
  }
  for (const auto& group : result.groups)
    if (group.name == "control" && group.redundancy > 2 &&
        group.factor > chi_squared_quantile(0.999, group.redundancy) / group.redundancy)
      result.warnings.push_back("the control points fit " + short_number(std::sqrt(group.factor)) +
                                " times worse than their standard deviations" + whose +
                                ". All standard deviations of the result are too small by that");
}

std::string millimetres(const Eigen::Vector3d& v) {
  return fmt::format("{:.1f}, {:.1f}, {:.1f} mm", 1e3 * v.x(), 1e3 * v.y(), 1e3 * v.z());
}

void warn_about_points(ControlResult& result) {
  const auto holding = std::count_if(result.points.begin(), result.points.end(),
                                     [](const auto& p) { return p.used && !p.check && !p.aside; });
  const double critical = critical_w(static_cast<size_t>(holding));
  for (auto& p : result.points) {
    if (!p.used || p.check) continue;
    const double w = p.w.cwiseAbs().maxCoeff();
    if (p.aside)
      result.warnings.push_back("control point " + p.name +
                                " contradicts the photographs and the other control points, " + "which have it " +
                                millimetres(p.position - p.surveyed) + " off (|w| = " + short_number(w) +
                                "): it is set aside. Check its coordinates, its name and its measurements");
    else if (w > critical)
      p.contradicts = true,
      result.warnings.push_back("control point " + p.name + " contradicts the photographs: |w| = " + short_number(w) +
                                ". Check its coordinates, its name and its measurements");
  }
  if (result.checks)
    result.warnings.insert(result.warnings.end(), result.checks->words.begin(), result.checks->words.end());
}

}  // namespace

std::string role_of(const AdjustedControlPoint& p) {
  return p.check ? "check" : p.aside ? "control, set aside" : "control";
}

std::string control_table(const ControlResult& result) {
  std::string text =
      "name,role,x_m,y_m,z_m,sigma_x_m,sigma_y_m,sigma_z_m,dx_m,dy_m,dz_m,w_x,w_y,w_z,rays,rms_px,reason\n";
  for (const auto& p : result.points) {
    text += text::csv_field(p.name) + "," + text::csv_field(role_of(p));
    const auto add = [&](double value) {
      const std::string number = fmt::format(",{:.6f}", value);
      text += std::isfinite(value) && p.used ? number : ",";
    };
    for (int k = 0; k < 3; ++k) add(p.position(k));
    for (int k = 0; k < 3; ++k) add(std::sqrt(p.covariance(k, k)));
    for (int k = 0; k < 3; ++k) add(p.position(k) - p.surveyed(k));
    for (int k = 0; k < 3; ++k) add(p.w(k));
    text += "," + std::to_string(p.rays);
    add(p.rms);
    text += "," + text::csv_field(p.reason) + "\n";
  }
  return text;
}

ControlResult adjust_with_control(const cameras::ColmapModel& model, const std::vector<ControlPoint>& control,
                                  const std::vector<ImagePoint>& measured, const ControlOptions& options) {
  ControlResult result;
  adjust_with_control(model, control, measured, options, result);
  return result;
}

void adjust_with_control(const cameras::ColmapModel& model, const std::vector<ControlPoint>& control,
                         const std::vector<ImagePoint>& measured, const ControlOptions& options,
                         ControlResult& result) {
  result.model = model;
  // Coordinates of a site may have seven digits: computed near the origin of the control.
  for (const auto& p : control) result.origin += p.position / static_cast<double>(control.size());
  result.origin = result.origin.array().round();
  std::vector<Target> targets = targets_of(model, control, measured, options, result);
  set_wrong_measurements_aside(result.model, targets, result);
  align(result.model, targets, result);
  const size_t controls = targets.size();
  add_ties(result.model, options, targets);
  std::set<std::int64_t> chosen;
  for (size_t j = controls; j < targets.size(); ++j) chosen.insert(targets[j].tie);
  adjust_targets(result.model, std::move(targets), options, result);
  for (auto& [id, point] : result.model.points) {  // the others follow the cameras
    if (chosen.count(id)) continue;
    std::vector<Measured> rays;
    for (const auto& [image, feature] : point.track)
      rays.push_back({image, result.model.images.at(image).features[feature].pixel, 1});
    if (const auto at = intersect(result.model, rays)) point.position = *at;
  }
  for (auto& [id, image] : result.model.images)
    image.cam_from_world.translation -= image.cam_from_world.rotation * result.origin;
  for (auto& [id, point] : result.model.points) point.position += result.origin;
  for (const auto& p : control) {
    const bool there =
        std::any_of(result.points.begin(), result.points.end(), [&](const auto& q) { return q.name == p.name; });
    if (there) continue;
    AdjustedControlPoint unused;
    unused.name = p.name, unused.check = p.check, unused.surveyed = p.position, unused.surveyed_sigma = p.sigma;
    unused.position.setConstant(std::nan(""));
    unused.reason = "it is not measured in two photographs of the model, or disagrees with the others";
    result.points.push_back(unused);
    result.left_out.push_back((p.check ? "check point " : "control point ") + p.name + ": " + unused.reason);
  }
  warn_about_control(control, options, result);
  warn_about_points(result);
}

}  // namespace plumbline::markers

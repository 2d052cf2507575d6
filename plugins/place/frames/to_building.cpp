#include "place/frames/to_building.hpp"

#include <fmt/core.h>

#include <cmath>
#include <complex>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "artifacts/fitted_datum.hpp"
#include "artifacts/frame_artifact.hpp"
#include "artifacts/joint_memory.hpp"
#include "base/text/words.hpp"
#include "building/ifc/georeference.hpp"
#include "geometry/geodesy/map_projection.hpp"
#include "geometry/median.hpp"
#include "geometry/packed_symmetric.hpp"
#include "place/frames/fitted_frame.hpp"
#include "plumbline/failure.hpp"

namespace plumbline::frames {
namespace {

using ifc::CommonPoints;
using ifc::PlanTransform;

/// Beyond this the survey is in another frame, not badly built [m].
constexpr double kFarthest = 1;

CommonPoints common_points(const PointsT& survey, const PointsT& design) {
  std::map<std::string, const PointT*> known;
  for (const auto& point : design.points) known[point->id] = point.get();
  CommonPoints common;
  for (const auto& point : survey.points) {
    const auto found = known.find(point->id);
    if (found == known.end() || !point->position.allFinite() || !found->second->position.allFinite()) continue;
    common.ids.push_back(point->id);
    common.survey.push_back(point->position), common.design.push_back(found->second->position);
  }
  return common;
}

std::vector<ifc::Reading> readings(const DesignT& design) {
  if (!design.map_conversion) return {};
  const DesignMapConversionT& map = *design.map_conversion;
  return ifc::readings_of({map.eastings, map.northings, map.orthogonal_height, map.x_axis_abscissa, map.x_axis_ordinate,
                           map.scale, map.scale_given, map.crs_name, map.map_unit},
                          design.length_unit);
}

bool is_fitted(const std::string& how) { return how == "fitted" || how == "fitted_in_space"; }

/// What is applied, from what was given: survey_from_design and the covariance of (angle, translation).
struct Choice {
  PlanTransform transform;
  Eigen::Matrix4d covariance = Eigen::Matrix4d::Zero();
  std::string origin;
};

/// The way back: building_from_survey. Its covariance is, to first order, that of the turn reversed and the shift
/// turned back.
FrameLink link_of(const Choice& choice) {
  FrameLink link;
  link.to = "building", link.from = "survey", link.origin = choice.origin;
  const double angle = 0 - choice.transform.angle;  // and not -0
  link.to_from_from.rotation = Eigen::Quaterniond(std::cos(angle / 2), 0, 0, std::sin(angle / 2));
  link.to_from_from.translation = ifc::design_from_survey(choice.transform, Eigen::Vector3d::Zero());
  link.scale = 1 / choice.transform.scale;
  link.plan_only = true;
  const Eigen::Vector3d& t = link.to_from_from.translation;
  Eigen::Matrix<double, 6, 4> rows = Eigen::Matrix<double, 6, 4>::Zero();
  rows(2, 0) = -1;
  rows.block<3, 1>(3, 0) = Eigen::Vector3d(t.y(), -t.x(), 0);
  rows.block<3, 3>(3, 1) = -link.linear();
  link.covariance.topLeftCorner<6, 6>() = rows * choice.covariance * rows.transpose();
  return link;
}

/// Positions and their covariance; what all have in common through the transform is added to it.
PointsT moved(const PointsT& points, const FrameLink& link) {
  PointsT out = points;
  const auto n = static_cast<Eigen::Index>(points.points.size());
  FramePoints given;
  for (const auto& point : points.points) given.positions.push_back(point->position);
  const bool uncertain = link.covariance.cwiseAbs().maxCoeff() > 0;
  if (!points.covariance.empty()) {
    given.covariance = unpack_symmetric(points.covariance, static_cast<std::size_t>(3 * n), "input 'points'");
  } else if (uncertain) {
    given.covariance = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    for (Eigen::Index i = 0; i < n; ++i)
      given.covariance.block<3, 3>(3 * i, 3 * i) = points.points[i]->sigma.cwiseAbs2().asDiagonal();
  }
  FrameGraph graph;
  graph.add(link);
  const FramePoints result = graph.express(given, link.to, link.from);
  const Eigen::Matrix3d linear = link.linear();
  for (Eigen::Index i = 0; i < n; ++i) {
    PointT& point = *out.points[i];
    point.position = result.positions[i];
    point.sigma = result.covariance.size() > 0
                      ? Eigen::Vector3d(result.covariance.diagonal().segment<3>(3 * i).cwiseMax(0).cwiseSqrt())
                      : Eigen::Vector3d((linear.cwiseAbs2() * point.sigma.cwiseAbs2()).cwiseSqrt());
  }
  if (result.covariance.size() > 0) out.covariance = pack_symmetric(result.covariance);
  return out;
}

/// How much larger than the design the survey is in plan once it is in the building frame, with its standard deviation
/// by what is left over; the best similarity in the sense of least squares.
struct PlanScale {
  double value = 1, sigma = std::numeric_limits<double>::infinity();
};
PlanScale plan_scale(const CommonPoints& common, const PlanTransform& transform) {
  const auto n = common.ids.size();
  if (n < 4) return {};
  std::vector<std::complex<double>> survey, design;
  std::complex<double> survey_mean, design_mean;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d p = ifc::design_from_survey(transform, common.survey[i]);
    survey.emplace_back(p.x(), p.y()), design.emplace_back(common.design[i].x(), common.design[i].y());
    survey_mean += survey.back() / static_cast<double>(n), design_mean += design.back() / static_cast<double>(n);
  }
  std::complex<double> product;
  double extent = 0, left = 0;
  for (std::size_t i = 0; i < n; ++i) {
    product += std::conj(design[i] - design_mean) * (survey[i] - survey_mean);
    extent += std::norm(design[i] - design_mean);
  }
  if (!(extent > 0)) return {};
  const std::complex<double> factor = product / extent;
  for (std::size_t i = 0; i < n; ++i) left += std::norm(survey[i] - survey_mean - factor * (design[i] - design_mean));
  constexpr double smallest = 1e-6;  // no survey knows its scale better
  return {std::abs(factor), std::max(smallest, std::sqrt(left / static_cast<double>(2 * n - 4) / extent))};
}

/// A survey on the ground divided by a map's scale is out by hundreds of ppm, which looks like anchors out of place.
void require_map_scale(const CommonPoints& common, const PlanTransform& transform, const std::string& how) {
  const double k = transform.scale;
  const PlanScale scale = plan_scale(common, transform);
  if (std::abs(k - 1) < 20e-6 || std::abs(scale.value - 1) < 4 * scale.sigma ||
      std::abs(scale.value * k - 1) > 3 * scale.sigma)
    return;
  const std::string text = fmt::format(
      "with frames.with.use={} the survey is {:.0f} +- {:.0f} ppm larger than the design, which is the map's scale of "
      "{:.6f}: its coordinates are at ground scale, not reduced to the map; take frames.with.use=fitted, "
      "frames.with.use=given with grid_scale=1, or reduce the survey's distances to the map",
      how, 1e6 * (scale.value - 1), 1e6 * scale.sigma, k);
  throw std::runtime_error(text);
}

/// Largest distance of an anchor from the first, in plan [m].
double extent_of(const CommonPoints& common) {
  double extent = 0;
  for (const Eigen::Vector3d& p : common.design)
    extent = std::max(extent, (p - common.design.front()).head<2>().norm());
  return extent;
}

/// Length on the map over length on the ground at the design's origin; nothing where the file names no map that is
/// known. Its height is taken as that above the ellipsoid: 50 m of geoid are 8 ppm.
std::optional<double> scale_of_map(const DesignT& design) {
  if (!design.map_conversion || design.map_conversion->crs_name.empty()) return std::nullopt;
  const DesignMapConversionT& given = *design.map_conversion;
  const double unit = std::isfinite(given.map_unit) && given.map_unit > 0 ? given.map_unit : 1;
  try {
    const geodesy::MapProjection map(given.crs_name);
    const Eigen::Vector2d at = unit * Eigen::Vector2d(given.eastings, given.northings);
    const double radius = map.radius(map.inverse(at));
    return map.factors(at).scale * radius / (radius + unit * given.orthogonal_height);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

/// A map conversion without its grid scale beside a survey that is reduced to the map: all anchors look out of place.
void check_design_scale(const CommonPoints& common, const PlanTransform& transform, const DesignT& design,
                        const std::string& how, Context& context) {
  constexpr double kHeights = 30e-6;  // what a height above another surface may change
  const auto drawn = scale_of_map(design);
  if (!drawn || how == "same" || how == "given") return;
  const double missing = *drawn / transform.scale;
  const std::string& map = design.map_conversion->crs_name;
  if (std::abs(missing - 1) < kHeights) {
    constexpr double kTold = 1e-3;  // [m]
    const double off = extent_of(common) * std::abs(missing - 1);
    if (off > kTold)
      context.warn(fmt::format(
          "the map conversion of {} has the scale {:.6f}, and its map {} draws lengths there at {:.6f} if its height "
          "is "
          "above the ellipsoid: {:.0f} ppm, {:.1f} mm over the anchors. A geoid makes as much (50 m of it 8 ppm), and "
          "nothing here says which height it is; take frames.with.use=given with the grid_scale of the survey's map if "
          "it matters",
          design.file_name, transform.scale, map, *drawn, 1e6 * std::abs(missing - 1), 1e3 * off));
    return;
  }
  const PlanScale scale = plan_scale(common, transform);
  if (std::abs(missing - 1) > 4 * scale.sigma) {
    if (std::abs(scale.value - missing) > 3 * scale.sigma + kHeights) return;
    throw std::runtime_error(fmt::format(
        "with frames.with.use={} the survey is {:.0f} +- {:.0f} ppm larger than the design: it is reduced to the map "
        "{}, which draws lengths there at {:.6f}, and the map conversion of {} has the scale {:.6f}; take "
        "frames.with.use=given with grid_scale={:.6f}, or have the design exported with its grid scale",
        how, 1e6 * (scale.value - 1), 1e6 * scale.sigma, map, *drawn, design.file_name, transform.scale, *drawn));
  }
  context.warn(fmt::format(
      "the map conversion of {} has the scale {:.6f}, and its map {} draws lengths there at {:.6f}: if the survey is "
      "reduced to the map, take frames.with.use=given with grid_scale={:.6f}; the anchors do not tell",
      design.file_name, transform.scale, map, *drawn, *drawn));
}

/// Median distance of the anchors from their design [m]; nan without any.
double misfit_of(const CommonPoints& common, const FrameLink& link) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < common.ids.size(); ++i)
    distances.push_back((link.apply(common.survey[i]) - common.design[i]).norm());
  return median(distances);
}

/// The points at those indices, with their covariance.
PointsT only(const PointsT& points, const std::vector<Eigen::Index>& kept) {
  PointsT out = points;
  out.points.clear();
  for (const Eigen::Index i : kept) out.points.push_back(std::make_unique<PointT>(*points.points[i]));
  if (points.covariance.empty()) return out;
  const Eigen::MatrixXd all = unpack_symmetric(points.covariance, 3 * points.points.size(), "input 'points'");
  std::vector<Eigen::Index> rows;
  for (const Eigen::Index i : kept)
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(3 * i + c);
  out.covariance = pack_symmetric(Eigen::MatrixXd(all(rows, rows)));
  return out;
}

/// "3 points (A, B, C)"
std::string counted(const std::vector<std::string>& names) {
  return std::to_string(names.size()) + (names.size() == 1 ? " point (" : " points (") + text::join(names, 5) + ")";
}

/// Points of a plan network have no height, bench marks that were levelled only no plan: the frame of the design cannot
/// be had of them. Throws where no anchor is left, else names them.
PointsT with_all_coordinates(const PointsT& survey, const PointsT& designed, Context& context) {
  std::set<std::string> anchors;
  for (const auto& point : designed.points) anchors.insert(point->id);
  std::vector<Eigen::Index> kept;
  std::vector<std::string> flat, without_plan;
  std::size_t anchors_kept = 0, anchors_left_out = 0;
  for (std::size_t i = 0; i < survey.points.size(); ++i) {
    const PointT& point = *survey.points[i];
    const bool anchor = anchors.count(point.id) > 0;
    if (point.position.allFinite()) {
      kept.push_back(static_cast<Eigen::Index>(i));
      anchors_kept += anchor;
      continue;
    }
    (std::isfinite(point.position.z()) ? without_plan : flat).push_back(point.id);
    anchors_left_out += anchor;
  }
  std::vector<std::string> told;
  if (!flat.empty()) told.push_back(counted(flat) + " without a height (a network in plan alone has none)");
  if (!without_plan.empty()) told.push_back(counted(without_plan) + " without east and north");
  if (anchors_left_out > 0 && anchors_kept == 0)
    throw BadInput("no anchor has all of east, north and height: " + text::join(told) +
                   ". Anchors are judged in space: measure what is missing, too");
  for (const std::string& what : told) context.warn("left out: " + what);
  return flat.empty() && without_plan.empty() ? survey : only(survey, kept);
}

}  // namespace

void ToBuilding::run(Context& context) {
  announce_joint(context, joint_size(points), 12);
  const PointsT design_points = designed.unpack();
  const PointsT survey = with_all_coordinates(points.unpack(), design_points, context);
  const DesignT read = design.unpack();
  const CommonPoints common = common_points(survey, design_points);
  FrameLink link = is_fitted(*use) ? fitted(common, context) : told(common, read, context);
  if (!is_fitted(*use)) add_datum(common, Freedom::level, *datum_sigma, link);
  if (common.ids.empty())
    context.warn("survey and design name no anchor alike, so nothing shows that they share a frame");
  else
    context.metric("misfit_of_survey_and_design", misfit_of(common, link), "m");
  PointsT in_building = moved(survey, link);
  if (is_fitted(*use)) {
    in_building.fitted_to_design.reset();  // where it lay before counts no more
    mark_fitted(in_building, link.origin, *datum_sigma);
  } else if (in_building.fitted_to_design && std::isfinite(*datum_sigma)) {
    in_building.fitted_to_design->datum_sigma = *datum_sigma;
  }
  building.commit(in_building);
  PlatesT turned = plates.unpack();
  for (auto& plate : turned.plates)
    plate->nominal_rotation = (link.to_from_from.rotation * plate->nominal_rotation).normalized();
  building_plates.commit(turned);
  TransformT applied = transform_artifact(link);
  applied.fitted_to_design = is_fitted(*use), applied.datum_sigma = *datum_sigma;
  transform.commit(applied);
}

/// The anchors themselves, which are to be judged: evaluate.deviation is told by `transform`, and by the points.
FrameLink ToBuilding::fitted(const CommonPoints& common, Context& context) const {
  FrameLink link = fit_frame(common, *use == "fitted" ? Freedom::level : Freedom::space, *datum_sigma);
  const double left = misfit_of(common, link);
  if (left > kFarthest)
    throw std::runtime_error("with frames.with.use=" + *use + " the survey is " + std::to_string(left) +
                             " m from the design (median): do the names in the plate table mean the same anchors?");
  context.warn("the measurement was " + link.origin +
               " (shift and turn): that all stand together elsewhere, or are turned, cannot be seen");
  return link;
}

/// What the parameters or the design say.
FrameLink ToBuilding::told(const CommonPoints& common, const DesignT& read, Context& context) const {
  const auto known = readings(read);
  const std::string& how = *use;
  Choice choice;
  choice.origin = "survey and design share one frame";
  if (how == "given") {
    if (translation->size() != 3)
      throw std::runtime_error("parameter 'translation' has " + std::to_string(translation->size()) +
                               " numbers, expected E N H of the design's origin with use=given");
    choice.transform = {*rotation, *grid_scale, Eigen::Vector3d(translation->data())};
    choice.origin = "given in the pipeline";
    if (!sigmas->empty() && sigmas->size() != 4)
      throw std::runtime_error("parameter 'sigmas' has " + std::to_string(sigmas->size()) +
                               " numbers, expected four: rotation, E, N, H");
    for (std::size_t i = 0; i < sigmas->size(); ++i)
      choice.covariance(static_cast<int>(i), static_cast<int>(i)) = (*sigmas)[i] * (*sigmas)[i];
  } else if (how != "same") {
    const auto reading = std::find_if(known.begin(), known.end(), [&](const ifc::Reading& r) { return r.use == how; });
    if (reading == known.end())
      throw std::runtime_error(known.empty() ? read.file_name +
                                                   " has no map conversion; frames.with.use=given takes numbers, "
                                                   "frames.with.use=fitted the anchors"
                                             : "the map conversion of " + read.file_name +
                                                   " reads the same with use=map_conversion: take that");
    choice.transform = reading->transform;
    choice.origin = reading->words + " (" + read.file_name + ")";
  }
  const double left = ifc::misfit(common, choice.transform);
  if (how == "same") {
    if (const std::string gap = ifc::explain_gap(common, known, read.file_name); !gap.empty())
      throw std::runtime_error(gap);
  } else if (left > kFarthest) {
    const std::string gap = ifc::explain_gap(common, known, read.file_name);
    throw std::runtime_error("with frames.with.use=" + how + " the survey is " + std::to_string(left) +
                             " m from the design (median)" + (gap.empty() ? "; without it, it is not" : "; " + gap));
  }
  require_map_scale(common, choice.transform, how);
  check_design_scale(common, choice.transform, read, how, context);
  return link_of(choice);
}

}  // namespace plumbline::frames

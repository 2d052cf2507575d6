#include "building/ifc/georeference.hpp"

#include <fmt/core.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "geometry/median.hpp"

namespace plumbline::ifc {
namespace {

/// Beyond this the survey is in another frame, not badly built [m].
constexpr double kOtherFrame = 1.0;
/// What explains a gap leaves less than this: as-built deviations of the worst buildings [m].
constexpr double kExplained = 0.1;

Eigen::Vector3d turned(double angle, const Eigen::Vector3d& p) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x() - s * p.y(), s * p.x() + c * p.y(), p.z()};
}

std::string length_words(double metres) {
  if (metres >= 10000) return fmt::format("{:.0f} km", metres / 1000);
  return metres >= 1 ? fmt::format("{:.1f} m", metres) : fmt::format("{:.0f} mm", 1000 * metres);
}

CommonPoints changed(const CommonPoints& points, double factor, bool swap) {
  CommonPoints out = points;
  for (Eigen::Vector3d& p : out.survey) {
    p *= factor;
    if (swap) std::swap(p.x(), p.y());
  }
  return out;
}

/// The standard: Scale is project unit over map unit, times a grid scale near 1. What is left after the units is the
/// grid scale; a rest far from 1 is a unit that the exporter forgot or inverted.
double grid_scale(double scale, double map_unit, double length_unit) {
  for (const double candidate : {scale * map_unit / length_unit, scale, scale * length_unit / map_unit})
    if (std::abs(candidate - 1) < 0.01) return candidate;
  return 1;
}

/// Median misfit after the best shift and turn; nan where it cannot be fitted.
double misfit_of_fit(const CommonPoints& points) {
  try {
    Eigen::Matrix4d covariance;
    return misfit(points, fit_plan(points, covariance));
  } catch (const std::runtime_error&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

}  // namespace

Eigen::Vector3d survey_from_design(const PlanTransform& t, const Eigen::Vector3d& p) {
  return turned(t.angle, {t.scale * p.x(), t.scale * p.y(), p.z()}) + t.translation;
}

Eigen::Vector3d design_from_survey(const PlanTransform& t, const Eigen::Vector3d& p) {
  const Eigen::Vector3d q = turned(-t.angle, p - t.translation);
  return {q.x() / t.scale, q.y() / t.scale, q.z()};
}

std::vector<Reading> readings_of(const MapConversion& map, double length_unit) {
  const double map_unit = std::isfinite(map.map_unit) ? map.map_unit : length_unit;
  const double angle = std::atan2(map.x_axis_ordinate, map.x_axis_abscissa);
  const auto with = [&](const char* use, const std::string& words, double unit, double turn) {
    return Reading{use,
                   words,
                   {turn, grid_scale(map.scale, unit, length_unit),
                    unit * Eigen::Vector3d(map.eastings, map.northings, map.orthogonal_height)}};
  };
  std::vector<Reading> readings{with("map_conversion", "its map conversion", map_unit, angle)};
  const auto add = [&](Reading reading) {
    for (const Reading& known : readings)
      if ((known.transform.translation - reading.transform.translation).norm() < 1e-6 &&
          std::abs(known.transform.angle - reading.transform.angle) < 1e-12)
        return;
    readings.push_back(std::move(reading));
  };
  add(with("map_conversion_in_metres", "its map conversion with its numbers taken as metres", 1, angle));
  add(with("map_conversion_in_project_units", "its map conversion with its numbers taken in the project's unit",
           length_unit, angle));
  add(with("map_conversion_turned_back", "its map conversion with the rotation reversed", map_unit, -angle));
  return readings;
}

double misfit(const CommonPoints& points, const PlanTransform& t) {
  std::vector<double> distances;
  for (std::size_t i = 0; i < points.ids.size(); ++i)
    distances.push_back((design_from_survey(t, points.survey[i]) - points.design[i]).norm());
  return upper_median(std::move(distances));
}

PlanTransform fit_plan(const CommonPoints& points, Eigen::Matrix4d& covariance) {
  const std::size_t n = points.ids.size();
  if (n < 3)
    throw std::runtime_error("a shift and turn needs three points that survey and design both name, found " +
                             std::to_string(n));
  Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < n; ++i)
    from += points.design[i] / static_cast<double>(n), to += points.survey[i] / static_cast<double>(n);
  double cosine = 0, sine = 0, spread = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d a = points.design[i] - from, b = points.survey[i] - to;
    cosine += a.x() * b.x() + a.y() * b.y(), sine += a.x() * b.y() - a.y() * b.x();
    spread += a.head<2>().squaredNorm();
  }
  if (spread < 0.25 * static_cast<double>(n))
    throw std::runtime_error("the points that survey and design both name lie in one vertical line: the turn is open");
  PlanTransform t;
  t.angle = std::atan2(sine, cosine);
  t.translation = to - turned(t.angle, from);
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i)
    squares += (survey_from_design(t, points.design[i]) - points.survey[i]).squaredNorm();
  const double variance = squares / static_cast<double>(3 * n - 4);
  // About the centroid angle and shift are independent; the translation at the origin moves with the angle.
  const Eigen::Vector3d arm = turned(t.angle, from);
  Eigen::Matrix<double, 3, 4> rows;
  rows << arm.y(), 1, 0, 0, -arm.x(), 0, 1, 0, 0, 0, 0, 1;
  const Eigen::Vector4d own(variance / spread, variance / static_cast<double>(n), variance / static_cast<double>(n),
                            variance / static_cast<double>(n));
  Eigen::Matrix4d jacobian = Eigen::Matrix4d::Zero();
  jacobian(0, 0) = 1;
  jacobian.bottomRows<3>() = rows;
  covariance = jacobian * own.asDiagonal() * jacobian.transpose();
  return t;
}

std::string explain_gap(const CommonPoints& points, const std::vector<Reading>& readings,
                        const std::string& design_file) {
  const double gap = misfit(points, {});
  if (!(gap > kOtherFrame)) return "";
  std::string text = "the survey is " + length_words(gap) + " from " + design_file + " (median of " +
                     std::to_string(points.ids.size()) + " anchors that both name; '" + points.ids[0] + "' is at E " +
                     std::to_string(points.survey[0].x()) + " N " + std::to_string(points.survey[0].y()) + " H " +
                     std::to_string(points.survey[0].z()) + " in the survey, at " +
                     std::to_string(points.design[0].x()) + " " + std::to_string(points.design[0].y()) + " " +
                     std::to_string(points.design[0].z()) + " in the design)";
  for (const Reading& reading : readings)
    if (const double left = misfit(points, reading.transform); left < kExplained)
      return text + "; " + reading.words + " would explain it to " + length_words(left) +
             ": frames.with.use=" + reading.use;
  struct Change {
    const char* words;
    double factor;
    bool swap;
  };
  // Plain first: a shift and turn of what was measured; then what should not have happened.
  for (const Change& change :
       {Change{"", 1, false}, Change{"with east and north swapped in the survey", 1, true},
        Change{"with the survey in feet", 0.3048, false}, Change{"with the survey in millimetres", 1e-3, false},
        Change{"with the survey in feet, east and north swapped", 0.3048, true}}) {
    const CommonPoints as_meant = changed(points, change.factor, change.swap);
    const bool plain = change.words[0] == '\0';
    if (!plain) {
      if (misfit(as_meant, {}) < kExplained)
        return text + "; " + change.words + " it fits: mend the survey's files" +
               (change.factor == 1e-3 ? ", or the unit of the design if that is written in metres and declares "
                                        "millimetres (IfcUnitAssignment)"
                                      : "");
      for (const Reading& reading : readings)
        if (misfit(as_meant, reading.transform) < kExplained)
          return text + "; " + change.words + ", " + reading.words +
                 " explains it: mend the survey's files, then frames.with.use=" + reading.use;
    }
    const double left = misfit_of_fit(as_meant);
    if (!(left < kExplained)) continue;
    if (plain)
      return text + "; a shift and a turn about the vertical would explain it to " + length_words(left) +
             ": the survey is in a site grid. frames.with.use=fitted takes the anchors themselves for it, "
             "frames.with.use=given "
             "the numbers of the site's grid" +
             (readings.empty() ? "" : "; the design's map conversion does not explain it");
    return text + "; " + change.words + " a shift and a turn would explain it to " + length_words(left) +
           ": mend the survey's files";
  }
  // The design's numbers may be of another unit than its file declares.
  for (const auto& [words, factor] : {std::pair{"millimetres", 1000.0}, {"centimetres", 100.0}, {"feet", 1 / 0.3048}}) {
    const CommonPoints as_meant = changed(points, factor, false);
    const bool moved = !(misfit(as_meant, {}) < factor * kExplained);
    if (moved && !(misfit_of_fit(as_meant) < factor * kExplained)) continue;
    return text + "; if the numbers of the design are " + words + ", it fits" +
           (moved ? " after a shift and a turn about the vertical" : "") +
           ": the file declares another length unit than it is written in; mend its unit (IfcUnitAssignment), or "
           "export it "
           "again";
  }
  return text + "; neither " + (readings.empty() ? "" : "its map conversion nor ") +
         "a shift and turn, swapped axes, feet or millimetres explain it: check whether the names in the plate table "
         "mean the same "
         "anchors in survey and design";
}

}  // namespace plumbline::ifc

// Where the survey stands with respect to the design: the readings of a map conversion, and what else would explain a
// gap.
//
// Files disagree about what IfcMapConversion means (units of Eastings, sense and size of Scale; Autodesk/revit-ifc #290
// #464 #784), so every reading is a candidate that is held against surveyed points, and none is chosen in silence.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "building/ifc/design.hpp"

namespace plumbline::ifc {

/// p_survey = scale · Rz(angle) · p_design + translation; heights are not scaled.
struct PlanTransform {
  double angle = 0;  ///< [rad], counter-clockwise
  double scale = 1;
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();  ///< [m]
};
Eigen::Vector3d survey_from_design(const PlanTransform& t, const Eigen::Vector3d& p);
Eigen::Vector3d design_from_survey(const PlanTransform& t, const Eigen::Vector3d& p);

/// One way to read the georeference of a file.
struct Reading {
  std::string use;    ///< value of the parameter `use` that takes it
  std::string words;  ///< "its map conversion", "its map conversion with its numbers in metres"
  PlanTransform transform;
};
/// The standard's reading first. `length_unit`: metres in one unit of the project.
std::vector<Reading> readings_of(const MapConversion& map, double length_unit);

/// Points that survey and design both name [m].
struct CommonPoints {
  std::vector<std::string> ids;
  std::vector<Eigen::Vector3d> survey, design;
};

/// Median distance [m] between the survey and the design as `t` brings it there; nan without points.
double misfit(const CommonPoints& points, const PlanTransform& t);

/// Shift and turn about the vertical that fit best (least squares), without scale; three or more points that do not lie
/// in one vertical line. `covariance` (4 x 4: angle, translation) follows from the residuals. Throws
/// std::runtime_error.
PlanTransform fit_plan(const CommonPoints& points, Eigen::Matrix4d& covariance);

/// Why the survey is not where the design is, in the survey's words, and what to do: the readings, swapped axes, feet,
/// millimetres, a shift and turn. Empty if the median distance is below a metre, or nothing can be compared.
std::string explain_gap(const CommonPoints& points, const std::vector<Reading>& readings,
                        const std::string& design_file);

}  // namespace plumbline::ifc

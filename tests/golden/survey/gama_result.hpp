// The results that GNU Gama's test suite stores beside its networks (gama-local-adjustment XML).
#pragma once

#include <Eigen/Core>
#include <cctype>
#include <filesystem>
#include <map>
#include <pugixml.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "survey/model/survey_observations.hpp"

namespace plumbline::survey {

struct GamaPoint {
  double x = kNotGiven, y = kNotGiven, z = kNotGiven;
};

/// What gama-local stores of an adjustment; coordinates in m in the axes of the file, covariances in mm and cc.
struct GamaResult {
  std::map<std::string, GamaPoint> points;
  std::vector<std::pair<std::string, char>>
      order;                   // point and axis of the rows of the covariance matrix; orientations behind
  Eigen::MatrixXd covariance;  // mm, cc
  double a_priori = 0, a_posteriori = 0, sum_of_squares = 0;
  int degrees_of_freedom = 0, defect = 0;
};

inline GamaResult read_result(const std::filesystem::path& path) {
  pugi::xml_document document;
  if (!document.load_file(path.c_str())) throw std::runtime_error("cannot read " + path.string());
  const auto root = document.child("gama-local-adjustment");
  GamaResult r;
  const auto equations = root.child("network-processing-summary").child("project-equations");
  r.degrees_of_freedom = equations.child("degrees-of-freedom").text().as_int();
  r.defect = equations.child("defect").text().as_int();
  r.sum_of_squares = equations.child("sum-of-squares").text().as_double();
  const auto deviation = root.child("network-processing-summary").child("standard-deviation");
  r.a_priori = deviation.child("apriori").text().as_double();
  r.a_posteriori = deviation.child("aposteriori").text().as_double();
  for (const auto& node : root.child("coordinates").child("adjusted").children("point")) {
    GamaPoint p;
    const std::string id = node.child("id").text().as_string();
    for (const auto& c : node.children()) {
      const char axis = static_cast<char>(std::tolower(c.name()[0]));
      if (std::string(c.name()) == "id") continue;
      (axis == 'x' ? p.x : axis == 'y' ? p.y : p.z) = c.text().as_double();
      r.order.emplace_back(id, axis);
    }
    r.points[id] = p;
  }
  const auto matrix = root.child("coordinates").child("cov-mat");
  const int dimension = matrix.child("dim").text().as_int(), band = matrix.child("band").text().as_int();
  r.covariance = Eigen::MatrixXd::Zero(dimension, dimension);
  auto value = matrix.child("flt");
  for (int i = 0; i < dimension; ++i)
    for (int j = i; j < dimension && j <= i + band; ++j, value = value.next_sibling("flt"))
      r.covariance(i, j) = r.covariance(j, i) = value.text().as_double();
  return r;
}

}  // namespace plumbline::survey

#include "show/report/block_json_parts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace plumbline::report {

using Json = nlohmann::ordered_json;

Json triple(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json head_json(const BlockT& block) {
  const auto& s = *block.statistics;
  Json groups = Json::array(), warnings = block.warnings, left_out = block.left_out;
  for (const auto& group : block.groups) {
    // Corners were weighted by their component already; what their detector said of them is what is to be judged.
    const double factor = group->name == "images" && !block.targets ? block.image_variance_factor : 1;
    groups.push_back({{"name", group->name},
                      {"observations", group->observations},
                      {"weighted_sum_of_squares", group->weighted_sum_of_squares},
                      {"redundancy", group->redundancy},
                      {"variance_factor", factor * group->variance_factor}});
  }
  for (const auto& test : block.tests)
    if (!test->passed && std::find(block.warnings.begin(), block.warnings.end(), test->words) == block.warnings.end())
      warnings.push_back(test->words);
  for (const std::string& motion : block.weak_datum) warnings.push_back("weak geometry: " + motion);
  std::string datum = block.datum;
  if (std::isfinite(block.lambda)) {
    datum += fmt::format(", λ {:.4g} px²/m², which believes σ {:.3g} mm of a surveyed coordinate", block.lambda,
                         1e3 * block.lambda_control_sigma);
  }
  return {{"datum", datum},
          {"statistics",
           {{"sigma0", s.sigma0},
            {"degrees_of_freedom", s.degrees_of_freedom},
            {"observations", s.observations},
            {"unknowns", s.unknowns}}},
          {"groups", groups},
          {"left_out", left_out},
          {"warnings", warnings}};
}

Json correlations_json(const std::vector<std::string>& names, const std::vector<double>& triangle) {
  Json list = Json::array();
  if (triangle.size() != names.size() * (names.size() + 1) / 2) return list;
  for (size_t i = 0; i < names.size(); ++i)
    for (size_t j = 0; j < i; ++j)
      list.push_back({{"of", names[j]}, {"with", names[i]}, {"correlation", triangle[i * (i + 1) / 2 + j]}});
  return list;
}

void add_interior(const BlockT& block, const std::string& camera, Json& entry) {
  Json parameters = Json::array(), correlations = Json::array();
  std::vector<const InteriorParameterT*> estimated;
  for (const auto& p : block.interior_orientation) {
    if (!p->image.empty()) continue;
    if (p->estimated) estimated.push_back(p.get());
    if (p->camera != camera) continue;
    parameters.push_back({{"name", p->name}, {"value", p->value}, {"sigma", p->sigma}, {"estimated", p->estimated}});
  }
  // Those with parameters of other cameras stand with the second of them.
  if (block.interior_correlations.size() == estimated.size() * (estimated.size() + 1) / 2)
    for (size_t i = 0; i < estimated.size(); ++i)
      for (size_t j = 0; j < i && estimated[i]->camera == camera; ++j) {
        const InteriorParameterT& other = *estimated[j];
        correlations.push_back({{"of", other.camera == camera ? other.name : other.name + " of " + other.camera},
                                {"with", estimated[i]->name},
                                {"correlation", block.interior_correlations[i * (i + 1) / 2 + j]}});
      }
  entry["interior_orientation"] = parameters;
  entry["correlations"] = correlations;
}

Json point_json(const std::string& id, const Eigen::Vector3d& position, const Eigen::Vector3d& sigma,
                const std::vector<Eigen::Vector3d>& centres) {
  double smallest = 1;
  for (size_t i = 0; i < centres.size(); ++i)
    for (size_t j = i + 1; j < centres.size(); ++j)
      smallest = std::min(smallest, (centres[i] - position).normalized().dot((centres[j] - position).normalized()));
  return {{"id", id},
          {"position", triple(position)},
          {"sigma", triple(sigma)},
          {"rays", centres.size()},
          {"largest_angle_deg", std::acos(std::clamp(smallest, -1.0, 1.0)) * 180 / M_PI}};
}

}  // namespace plumbline::report

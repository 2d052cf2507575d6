// Parts of a block.json that a block of tags and one of targets have in common.
#pragma once

#include <Eigen/Core>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "artifacts/block.hpp"

namespace plumbline::report {

nlohmann::ordered_json triple(const Eigen::Vector3d& v);

/// datum, statistics, groups, left_out and warnings, failed tests among them.
nlohmann::ordered_json head_json(const BlockT& block);

/// interior_orientation and correlations of one camera; `camera` is its name where there are several, else empty.
void add_interior(const BlockT& block, const std::string& camera, nlohmann::ordered_json& entry);

/// The correlations in a lower triangle of the estimated parameters, by name.
nlohmann::ordered_json correlations_json(const std::vector<std::string>& names, const std::vector<double>& triangle);

/// id, position, sigma, rays and the largest angle under which the rays from `centres` meet.
nlohmann::ordered_json point_json(const std::string& id, const Eigen::Vector3d& position, const Eigen::Vector3d& sigma,
                                  const std::vector<Eigen::Vector3d>& centres);

}  // namespace plumbline::report

// evaluate.withhold and evaluate.lengths.
#include "build/evaluate/crossval_nodes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>

#include "artifacts/fitted_datum.hpp"
#include "geometry/packed_symmetric.hpp"
#include "geometry/random.hpp"

namespace plumbline::judgement {

namespace {

/// Control points in an order that has nothing to do with their places: a fold is no corner of the building.
std::vector<std::string> scattered_order(const PointsT& control, const std::map<std::string, std::string>& roles) {
  std::vector<std::pair<std::uint64_t, std::string>> order;
  for (const auto& point : control.points) {
    const auto role = roles.find(point->id);
    if (role == roles.end() || role->second == "check" || point->role == "check") continue;
    order.emplace_back(derive_seed(0, point->id), point->id);
  }
  std::sort(order.begin(), order.end());
  std::vector<std::string> ids;
  for (const auto& [hash, id] : order) ids.push_back(id);
  return ids;
}

/// Of the points with these indices, with their covariance.
PointsT part_of(const PointsT& points, const std::vector<std::size_t>& indices) {
  PointsT part;
  take_datum(points, part);
  std::vector<Eigen::Index> rows;
  for (const std::size_t i : indices) {
    part.points.push_back(std::make_unique<PointT>(*points.points[i]));
    part.points.back()->role = "check";
    for (int c = 0; c < 3; ++c) rows.push_back(static_cast<Eigen::Index>(3 * i) + c);
  }
  const Eigen::MatrixXd covariance = unpack_symmetric(points.covariance, 3 * points.points.size(), "input 'control'");
  if (covariance.size() > 0) part.covariance = pack_symmetric(covariance(rows, rows));
  return part;
}

}  // namespace

void EvaluateWithhold::run(Context& context) {
  PlatesT table = plates.unpack();
  PointsT points = control.unpack();
  std::map<std::string, std::string> roles;
  std::map<std::string, int> floors;
  for (const auto& plate : table.plates) roles[plate->anchor] = plate->role, floors[plate->anchor] = plate->floor;
  const std::vector<std::string> ids = scattered_order(points, roles);
  std::set<std::string> chosen;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const bool here = *by == "floor" ? floors[ids[i]] == *fold
                                     : static_cast<int64_t>(i % static_cast<std::size_t>(*folds)) + 1 == *fold;
    if (here) chosen.insert(ids[i]);
  }
  if (chosen.empty() || chosen.size() == ids.size())
    throw std::runtime_error((chosen.empty() ? "nothing is withheld: " : "everything would be withheld: ") +
                             std::string(*by == "floor" ? "floor " : "fold ") + std::to_string(*fold) + " of " +
                             std::to_string(ids.size()) + " control points; choose another fold");
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < points.points.size(); ++i)
    if (chosen.count(points.points[i]->id)) indices.push_back(i);
  withheld.commit(part_of(points, indices));
  for (const auto& plate : table.plates)
    if (chosen.count(plate->anchor)) plate->role = "check";
  for (const auto& point : points.points)
    if (chosen.count(point->id)) point->role = "check";
  context.metric("withheld", static_cast<double>(chosen.size()), "1");
  plates_out.commit(table);
  control_out.commit(points);
}

void EvaluateLengths::run(Context& context) {
  const PointsT known = reference.unpack(), found = model.unpack();
  std::map<std::string, const PointT*> by_id;
  for (const auto& point : found.points) by_id[point->id] = point.get();
  PointsT out;
  std::vector<Eigen::Vector3d> measured;
  for (const auto& point : known.points) {
    const auto place = by_id.find(point->id);
    if ((*use != "all" && point->role != *use) || place == by_id.end() || !place->second->position.allFinite())
      continue;
    out.points.push_back(std::make_unique<PointT>(*point));
    out.points.back()->sigma.setConstant(std::numeric_limits<double>::quiet_NaN());
    out.points.back()->sigma.x() = 0;
    measured.push_back(place->second->position);
  }
  double squares = 0, sum = 0, largest = 0, longest = 0, share = 0, count = 0, exceeded = 0;
  for (std::size_t i = 0; i < measured.size(); ++i)
    for (std::size_t j = i + 1; j < measured.size(); ++j) {
      const double length = (out.points[i]->position - out.points[j]->position).norm();
      if (length < *shortest || length == 0) continue;
      const double error = (measured[i] - measured[j]).norm() - length, allowed = *a + *k * length;
      ++count, sum += error, squares += error * error;
      largest = std::max(largest, std::abs(error));
      longest = std::max(longest, length);
      exceeded += std::abs(error) > allowed;
      if (allowed > 0) share = std::max(share, std::abs(error) / allowed);
      for (const std::size_t end : {i, j})
        out.points[end]->sigma.x() = std::max(out.points[end]->sigma.x(), std::abs(error));
    }
  if (measured.empty()) throw std::runtime_error("no reference point with the role '" + *use + "' is in the model");
  context.metric("lengths", count, "1");
  if (count == 0) {  // one withheld at a time, as when each is left out once
    context.warn(measured.size() < 2 ? "no two reference points with the role '" + *use +
                                           "' are in the model: there is no length to compare"
                                     : "none of the lengths between the " + std::to_string(measured.size()) +
                                           " reference points with the role '" + *use +
                                           "' that are in the model is as long as shortest says: there is no length "
                                           "to compare");
    return errors.commit(out);
  }
  context.metric("longest", longest, "m");
  context.metric("mean_error", sum / count, "m");
  context.metric("rms_error", std::sqrt(squares / count), "m");
  context.metric("max_error", largest, "m");
  context.metric("largest_share", share, "1");
  context.metric("exceeded", exceeded, "1");
  errors.commit(out);
}

}  // namespace plumbline::judgement

#include "plan_survey.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>

namespace plumbline::survey {

namespace {

std::string join(const std::vector<std::string>& ids) {
  std::string text;
  for (size_t i = 0; i < ids.size() && i < 10; ++i) text += (i ? ", " : "") + ids[i];
  if (ids.size() > 10) text += " and " + std::to_string(ids.size() - 10) + " more";
  return text;
}

std::string millimetres(double metres) {
  std::ostringstream text;
  text.precision(2);
  text << std::fixed << metres * 1000 << " mm";
  return text.str();
}

class Planner {
 public:
  Planner(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
          const PlanOptions& options)
      : markers_(markers), set_ups_(set_ups), options_(options) {
    if (markers.empty() || set_ups.empty())
      throw std::runtime_error("a plan needs markers and set-ups; there are " + std::to_string(markers.size()) +
                               " and " + std::to_string(set_ups.size()));
    std::set<int> floors;
    for (const auto& m : markers) floors.insert(m.floor);
    result_.floors.assign(floors.begin(), floors.end());
  }

  PlanResult run() {
    find_sights();
    check_set_ups_per_marker();
    check_shared_markers();
    check_column();
    predict();
    check_precision();
    return std::move(result_);
  }

 private:
  double incidence(const PlannedMarker& m, const Eigen::Vector3d& from) const {
    return std::acos(std::clamp((from - m.position).normalized().dot(m.normal.normalized()), -1.0, 1.0));
  }

  bool allowed(const PlannedMarker& m, const Eigen::Vector3d& from) const {
    const Eigen::Vector3d d = m.position - from;
    if (d.norm() > options_.largest_range || d.head<2>().norm() < 0.5) return false;
    if (std::atan2(std::abs(d.z()), d.head<2>().norm()) > options_.steepest_sight) return false;
    const double angle = incidence(m, from);
    return std::isnan(angle) || angle <= options_.largest_incidence;
  }

  void find_sights() {
    for (size_t s = 0; s < set_ups_.size(); ++s)
      for (size_t m = 0; m < markers_.size(); ++m) {
        const Eigen::Vector3d& from = set_ups_[s].position;
        if (!allowed(markers_[m], from)) continue;
        seen_by_[m].insert(s);
        result_.sights.push_back(
            {set_ups_[s].id, markers_[m].id, (markers_[m].position - from).norm(), incidence(markers_[m], from)});
      }
  }

  void add_rule(const std::string& name, bool holds, const std::string& text, std::vector<std::string> points = {}) {
    result_.rules.push_back({name, holds, text, std::move(points)});
  }

  /// A set-up in front of the middle of some markers, as far off as their height asks.
  std::string new_set_up_before(const std::vector<size_t>& which) const {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
    double lowest = 1e300, highest = -1e300;
    for (size_t m : which) {
      centre += markers_[m].position / static_cast<double>(which.size());
      if (markers_[m].normal.allFinite()) normal += markers_[m].normal;
      lowest = std::min(lowest, markers_[m].position.z());
      highest = std::max(highest, markers_[m].position.z());
    }
    if (normal.norm() < 1e-9) return "add a set-up with a view of these markers";
    const double distance = std::max(8.0, (highest - lowest) / std::tan(0.8 * options_.steepest_sight));
    const Eigen::Vector3d place = centre + distance * normal.normalized();
    std::ostringstream text;
    text.precision(1);
    text << std::fixed << "add a set-up near E " << place.x() << ", N " << place.y() << ", H " << lowest
         << " m or higher";
    return text.str();
  }

  void check_set_ups_per_marker() {
    std::vector<std::string> ids;
    std::vector<size_t> poor;
    for (size_t m = 0; m < markers_.size(); ++m)
      if (static_cast<int>(seen_by_[m].size()) < options_.set_ups_per_marker) {
        ids.push_back(markers_[m].id);
        poor.push_back(m);
      }
    const std::string wanted = std::to_string(options_.set_ups_per_marker) + " set-ups";
    add_rule("set-ups per marker", poor.empty(),
             poor.empty() ? "every marker is seen from at least " + wanted
                          : "seen from fewer than " + wanted + " within range, incidence and elevation: " + join(ids),
             ids);
    if (!poor.empty()) result_.remedies.push_back("for " + join(ids) + ": " + new_set_up_before(poor));
  }

  std::vector<size_t> on_floor(int floor) const {
    std::vector<size_t> which;
    for (size_t m = 0; m < markers_.size(); ++m)
      if (markers_[m].floor == floor) which.push_back(m);
    return which;
  }

  /// Markers of a floor that some of these set-ups see.
  int seen_from(const std::vector<size_t>& markers, const std::set<size_t>& from) {
    return static_cast<int>(std::count_if(markers.begin(), markers.end(), [&](size_t m) {
      return std::any_of(seen_by_[m].begin(), seen_by_[m].end(), [&](size_t s) { return from.contains(s); });
    }));
  }

  void check_shared_markers() {
    for (size_t k = 0; k + 1 < result_.floors.size(); ++k) {
      const auto lower = on_floor(result_.floors[k]), upper = on_floor(result_.floors[k + 1]);
      std::set<size_t> both;
      for (size_t s = 0; s < set_ups_.size(); ++s)
        if (seen_from(lower, {s}) > 0 && seen_from(upper, {s}) > 0) both.insert(s);
      const int shared = std::min(seen_from(lower, both), seen_from(upper, both));
      const bool holds = shared >= options_.shared_markers;
      const std::string pair =
          "floors " + std::to_string(result_.floors[k]) + " and " + std::to_string(result_.floors[k + 1]);
      add_rule("shared markers, " + pair, holds,
               std::to_string(both.size()) + " set-ups see both; through them " + std::to_string(shared) +
                   " markers of each floor are joined, wanted " + std::to_string(options_.shared_markers));
      if (holds) continue;
      std::vector<size_t> all = lower;
      all.insert(all.end(), upper.begin(), upper.end());
      result_.remedies.push_back("to join " + pair + ": " + new_set_up_before(all));
    }
  }

  void check_column() {
    std::map<int, std::set<int>> floors_of;
    for (const auto& m : markers_)
      if (m.column > 0) floors_of[m.column].insert(m.floor);
    const bool holds = std::any_of(floors_of.begin(), floors_of.end(),
                                   [&](const auto& column) { return column.second.size() == result_.floors.size(); });
    add_rule("vertical marker column", holds,
             holds ? "a column has a marker on every floor" : "no column has a marker on every floor");
    if (!holds) result_.remedies.push_back("mount one marker above the other on every floor in one column");
  }

  /// Exact readings of all sights; their values do not matter for the covariance.
  SurveyObservations readings() const {
    SurveyObservations s;
    const auto add_point = [&](const std::string& id, const Eigen::Vector3d& p) {
      Point point;
      point.id = id;
      point.coordinates = p;
      s.points.push_back(point);
    };
    for (const auto& m : markers_) add_point(m.id, m.position);
    for (size_t i = 0; i < set_ups_.size(); ++i) {
      add_point(set_ups_[i].id, set_ups_[i].position);
      s.set_ups.push_back({set_ups_[i].id, set_ups_[i].id, kNotGiven, {}});
      for (size_t m = 0; m < markers_.size(); ++m) {
        if (!seen_by_.contains(m) || !seen_by_.at(m).contains(i)) continue;
        add_sighting(s, static_cast<int>(i), markers_[m], markers_[m].position - set_ups_[i].position);
      }
    }
    return s;
  }

  void add_sighting(SurveyObservations& s, int set_up, const PlannedMarker& m, const Eigen::Vector3d& d) const {
    const double h = d.head<2>().norm(), length = d.norm();
    const double values[] = {std::atan2(d.x(), d.y()), std::atan2(h, d.z()), length};
    const double sigmas[] = {options_.profile.direction(h, options_.sets, false),
                             options_.profile.zenith_angle(length, options_.sets, false),
                             options_.profile.distance(length, options_.sets)};
    const ObservationKind kinds[] = {ObservationKind::direction, ObservationKind::zenith_angle,
                                     ObservationKind::slope_distance};
    for (int k = 0; k < 3; ++k) {
      Observation o;
      o.kind = kinds[k];
      o.set_up = set_up;
      o.from = set_ups_[static_cast<size_t>(set_up)].id;
      o.to = m.id;
      o.value = values[k];
      o.sigma = sigmas[k];
      s.observations.push_back(std::move(o));
    }
  }

  void predict() {
    AdjustOptions options;
    options.curvature = Switch::off;
    options.datum = DatumMode::inner;
    for (size_t m : on_floor(result_.floors.front()))
      if (!seen_by_[m].empty()) options.datum_points.push_back(markers_[m].id);
    try {
      if (options.datum_points.empty()) throw NetworkError("no marker of the lowest floor is seen");
      result_.predicted = adjust_network(readings(), options);
      result_.adjustable = true;
      add_rule("determined", true,
               "the network is determined with redundancy " + std::to_string(result_.predicted.degrees_of_freedom));
    } catch (const NetworkError& error) {
      add_rule("determined", false, error.what());
    }
  }

  /// Standard deviation of a linear function of marker heights.
  double height_sigma(const std::vector<std::pair<size_t, double>>& weights) const {
    double variance = 0;
    for (const auto& [a, wa] : weights)
      for (const auto& [b, wb] : weights)
        variance += wa * wb *
                    result_.predicted.covariance(result_.predicted.point(markers_[a].id),
                                                 result_.predicted.point(markers_[b].id))(2, 2);
    return std::sqrt(std::max(0.0, variance));
  }

  /// Fewest sets that bring the transfer of floor k to the wanted sigma; 0 if centring keeps even eight from it.
  int sets_for_transfer(size_t k, double wanted) const {
    for (int sets = options_.sets + 1; sets <= 8; ++sets) {
      PlanOptions more = options_;
      more.sets = sets;
      Planner planner(markers_, set_ups_, more);
      planner.find_sights();
      planner.predict();
      if (planner.result_.adjustable && planner.transfer_sigma(k) <= wanted) return sets;
    }
    return 0;
  }

  double transfer_sigma(size_t k) const {
    std::vector<std::pair<size_t, double>> transfer;
    const auto here = seen_on_floor(result_.floors[k]), above = seen_on_floor(result_.floors[k + 1]);
    for (size_t m : here) transfer.emplace_back(m, -1.0 / static_cast<double>(here.size()));
    for (size_t m : above) transfer.emplace_back(m, 1.0 / static_cast<double>(above.size()));
    return height_sigma(transfer);
  }

  std::vector<size_t> seen_on_floor(int floor) const {
    std::vector<size_t> which;
    for (size_t m : on_floor(floor))
      if (seen_by_.contains(m) && !seen_by_.at(m).empty()) which.push_back(m);
    return which;
  }

  void check_precision() {
    if (!result_.adjustable) return;
    std::vector<std::pair<size_t, double>> drift;
    const double wanted = options_.tolerance / 5;  // control should be five times better than what it judges
    for (size_t k = 0; k < result_.floors.size(); ++k) {
      const auto here = seen_on_floor(result_.floors[k]);
      for (size_t m : here) drift.emplace_back(m, 1.0 / static_cast<double>(here.size()));
      result_.drift_sigma.push_back(height_sigma(drift));
      if (k + 1 == result_.floors.size()) break;
      const double sigma = transfer_sigma(k);
      result_.transfer_sigma.push_back(sigma);
      const std::string pair =
          "floor " + std::to_string(result_.floors[k]) + " to " + std::to_string(result_.floors[k + 1]);
      add_rule(
          "height transfer, " + pair, sigma <= wanted,
          "predicted sigma " + millimetres(sigma) + ", wanted " + millimetres(wanted) + " (a fifth of the tolerance)");
      if (sigma <= wanted) continue;
      const int sets = sets_for_transfer(k, wanted);
      result_.remedies.push_back("for the height transfer " + pair + ": " +
                                 (sets > 0 ? "measure " + std::to_string(sets) + " sets"
                                           : "more sets do not suffice, add a set-up that sees both floors"));
    }
  }

  const std::vector<PlannedMarker>& markers_;
  const std::vector<PlannedSetUp>& set_ups_;
  const PlanOptions& options_;
  std::map<size_t, std::set<size_t>> seen_by_;
  PlanResult result_;
};

}  // namespace

PlanResult plan_survey(const std::vector<PlannedMarker>& markers, const std::vector<PlannedSetUp>& set_ups,
                       const PlanOptions& options) {
  return Planner(markers, set_ups, options).run();
}

}  // namespace plumbline::survey

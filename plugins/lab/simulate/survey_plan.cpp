#include "survey_plan.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>
#include <stdexcept>

#include "geometry/random.hpp"
#include "survey/model/instrument_profile.hpp"

namespace plumbline::simulate {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kSecond = kPi / 180 / 3600;
// Instrument errors that two faces cancel; present so that a reader which forgets to average is found out.
constexpr double kCollimationSigma = 4 * kSecond, kIndexSigma = 4 * kSecond;

double wrap(double angle) {
  const double turn = 2 * kPi;
  const double wrapped = angle - turn * std::floor(angle / turn);
  return wrapped < turn ? wrapped : 0.0;
}

std::vector<GroundPoint> plan_ground_points(const Building& building, const SurveyOptions& options,
                                            std::uint64_t seed) {
  const double w = building.width, d = options.distance;
  // Around the set-ups, so that sights to them meet at good angles.
  const Eigen::Vector3d places[] = {
      {-3.0, -0.4 * d, 0.05}, {w + 3.0, -0.4 * d, 0.02}, {w + 4.0, -1.8 * d, -0.06}, {-4.0, -1.8 * d, 0.03}};
  std::vector<GroundPoint> points;
  for (const Eigen::Vector3d& place : places) {
    GroundPoint point;
    point.id = "G" + std::to_string(points.size() + 1);
    Random random(seed, point.id);
    point.truth = place + random.normal3(0.05);
    point.sigma = options.control_sigma;
    point.given = point.truth + random.normal3(point.sigma);
    point.target_height = 1.3 + 0.001 * std::floor(random.uniform(0, 100));  // a pole is read to the millimetre
    points.push_back(point);
  }
  return points;
}

double round_to(double value, double step) { return step * std::round(value / step); }

double incidence(const Eigen::Vector3d& axis, const Eigen::Vector3d& target) {
  const Eigen::Vector3d sight = axis - target;
  return std::acos(std::clamp(-sight.y() / sight.norm(), -1.0, 1.0));
}

std::set<double> common_rows(const Building& building, const StationPlan& plan, int lower, int upper) {
  std::set<std::size_t> seen_from_lower, shared;
  for (const auto& s : plan.set_ups) {
    if (s.floor == lower) seen_from_lower.insert(s.anchors.begin(), s.anchors.end());
  }
  for (const auto& s : plan.set_ups) {
    if (s.floor != upper) continue;
    for (const std::size_t a : s.anchors) {
      if (seen_from_lower.count(a)) shared.insert(a);
    }
  }
  std::set<double> rows;
  for (const std::size_t a : shared) {
    if (building.anchors[a].role == AnchorRole::control) rows.insert(building.anchors[a].design.z());
  }
  return rows;
}

/// Draws the readings of one set-up and appends them.
class Observer {
 public:
  Observer(const SurveyOptions& options, const PlannedSetUp& set_up, std::uint64_t seed,
           survey::SurveyObservations& out)
      : instrument_(survey::built_in_profile(options.instrument)),
        scale_(options.noise_scale),
        set_up_(set_up),
        random_(seed, "observations " + set_up.id),
        out_(out) {
    collimation_ = random_.normal(scale_ * kCollimationSigma);
    zenith_index_ = random_.normal(scale_ * kIndexSigma);
    survey::SetUp record;
    record.id = record.station = set_up.id;
    record.instrument_height = round_to(set_up.instrument_height + random_.normal(options.set_up_height_sigma), 1e-3);
    out_.set_ups.push_back(record);
  }

  /// The target as this set-up meets it: centring is one error for all its pointings.
  Eigen::Vector3d centred(const Eigen::Vector3d& target) {
    return target + random_.normal3(scale_ * instrument_.target_centring);
  }

  void point_at(const std::string& id, const Eigen::Vector3d& target, double target_height, int face, int set_number) {
    const Eigen::Vector3d d = target - set_up_.axis;
    const double distance = d.norm(), zenith = std::atan2(d.head<2>().norm(), d.z());
    const double single = scale_ * std::numbers::sqrt2;  // the profile speaks of the mean of two faces
    const double sign = face == 1 ? 1.0 : -1.0;
    const double direction = std::atan2(d.x(), d.y()) - set_up_.orientation + sign * collimation_ / std::sin(zenith) +
                             (face == 1 ? 0.0 : kPi) + random_.normal(single * instrument_.direction_sigma);
    const double circle =
        (face == 1 ? zenith : 2 * kPi - zenith) + zenith_index_ + random_.normal(single * instrument_.zenith_sigma);
    const double length =
        distance +
        random_.normal(single * (instrument_.distance_constant + 1e-6 * instrument_.distance_ppm * distance));

    survey::Observation o;
    o.set_up = static_cast<int>(out_.set_ups.size()) - 1;
    o.pointing = out_.observations.empty() ? 0 : out_.observations.back().pointing + 1;
    o.from = set_up_.id;
    o.to = id;
    o.target_height = target_height;
    o.face = face;
    o.set_number = set_number;
    const std::pair<survey::ObservationKind, double> readings[] = {
        {survey::ObservationKind::direction, wrap(direction)},
        {survey::ObservationKind::zenith_angle, wrap(circle)},
        {survey::ObservationKind::slope_distance, length}};
    for (const auto& [kind, value] : readings) {
      o.kind = kind;
      o.value = value;
      out_.observations.push_back(o);
    }
  }

 private:
  survey::InstrumentProfile instrument_;
  double scale_;
  const PlannedSetUp& set_up_;
  Random random_;
  survey::SurveyObservations& out_;
  double collimation_ = 0, zenith_index_ = 0;
};

}  // namespace

StationPlan plan_set_ups(const Building& building, const SurveyOptions& options, std::uint64_t seed) {
  if (options.sets < 1 || options.sets > 20) {
    throw std::invalid_argument("sets is " + std::to_string(options.sets) + ", it must be 1 to 20");
  }
  if (!(options.distance >= 4 && options.distance <= 100)) {
    throw std::invalid_argument("distance of the set-ups is " + std::to_string(options.distance) +
                                " m, it must be 4 to 100 m");
  }
  StationPlan plan;
  plan.ground_points = plan_ground_points(building, options, seed);
  for (int floor = 1; floor <= building.options.floors; ++floor) {
    for (int k = 0; k < 2; ++k) {
      const std::string id = fmt::format("S{:02}-{}", floor, k + 1);
      PlannedSetUp s;
      s.id = id;
      s.floor = floor;
      Random random(seed, s.id);
      s.axis = Eigen::Vector3d((k == 0 ? 0.2 : 0.8) * building.width, -options.distance,
                               building.storey_height * (floor - 1) + 1.6) +
               random.normal3(0.1);
      s.instrument_height = round_to(1.45 + random.uniform(0, 0.25), 1e-3);  // read on a tape
      s.orientation = random.uniform(0, 2 * kPi);
      s.given_mark = s.axis - Eigen::Vector3d(0, 0, s.instrument_height) + random.normal3(options.control_sigma);
      for (std::size_t a = 0; a < building.anchors.size(); ++a) {
        const int of = building.anchors[a].floor;
        // A single storey has nothing below it; each set-up sees its own storey and the one below.
        if (of == floor || of == floor - 1) s.anchors.push_back(a);
      }
      if (floor <= 2) {
        for (std::size_t g = 0; g < plan.ground_points.size(); ++g) s.ground_points.push_back(g);
      }
      plan.set_ups.push_back(std::move(s));
    }
  }
  return plan;
}

std::vector<std::string> broken_station_rules(const Building& building, const StationPlan& plan,
                                              double largest_incidence) {
  std::vector<std::string> broken;
  std::map<std::size_t, int> times_seen;
  std::set<std::size_t> ground;
  for (const PlannedSetUp& s : plan.set_ups) {
    ground.insert(s.ground_points.begin(), s.ground_points.end());
    for (const std::size_t a : s.anchors) {
      ++times_seen[a];
      const double angle = incidence(s.axis, building.anchors[a].built);
      if (angle > largest_incidence) {
        broken.push_back(s.id + " sees " + building.anchors[a].id + " " + std::to_string(angle * 180 / kPi) +
                         " degrees off the facade's normal, more than " +
                         std::to_string(largest_incidence * 180 / kPi));
      }
    }
  }
  for (std::size_t a = 0; a < building.anchors.size(); ++a) {
    const int n = times_seen.count(a) ? times_seen.at(a) : 0;
    if (n < 2) broken.push_back(building.anchors[a].id + " is seen from " + std::to_string(n) + " set-ups, not two");
  }
  for (int floor = 1; floor < building.options.floors; ++floor) {
    const auto rows = common_rows(building, plan, floor, floor + 1);
    if (rows.size() < 2) {
      broken.push_back("floors " + std::to_string(floor) + " and " + std::to_string(floor + 1) + " share " +
                       std::to_string(rows.size()) + " rows of markers, not two");
    }
  }
  std::map<int, std::set<int>> floors_of_column;
  for (const Anchor& a : building.anchors) {
    if (a.role == AnchorRole::control) floors_of_column[a.column].insert(a.floor);
  }
  if (std::none_of(floors_of_column.begin(), floors_of_column.end(), [&](const auto& column) {
        return static_cast<int>(column.second.size()) == building.options.floors;
      })) {
    broken.push_back("no vertical column of markers runs through all floors");
  }
  if (ground.size() < 3) {
    broken.push_back(std::to_string(ground.size()) + " control points are seen, three are needed");
  }
  return broken;
}

survey::SurveyObservations observe(const Building& building, const StationPlan& plan, const SurveyOptions& options,
                                   std::uint64_t seed) {
  survey::SurveyObservations out;
  out.info.format = "simulated";
  out.info.instrument = options.instrument;
  for (const PlannedSetUp& s : plan.set_ups) {
    Observer observer(options, s, seed, out);
    struct Target {
      std::string id;
      Eigen::Vector3d position;
      double height;
    };
    std::vector<Target> targets;
    for (const std::size_t g : s.ground_points) {
      const GroundPoint& point = plan.ground_points[g];
      targets.push_back(
          {point.id, observer.centred(point.truth + Eigen::Vector3d(0, 0, point.target_height)), point.target_height});
    }
    for (const std::size_t a : s.anchors) {
      targets.push_back({building.anchors[a].id, observer.centred(building.anchors[a].target()), 0.0});
    }
    for (int set = 1; set <= options.sets; ++set) {
      for (const Target& t : targets) observer.point_at(t.id, t.position, t.height, 1, set);
      for (auto t = targets.rbegin(); t != targets.rend(); ++t)
        observer.point_at(t->id, t->position, t->height, 2, set);
    }
  }
  return out;
}

}  // namespace plumbline::simulate

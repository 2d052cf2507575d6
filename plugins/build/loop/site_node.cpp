// simulate.site: set-ups and control marks before a simulated facade, so that the site can be measured again.
#include <algorithm>

#include "build/loop/job_nodes.hpp"
#include "geometry/random.hpp"
#include "loop/simulate/robot.hpp"

namespace plumbline::loop {
namespace {

std::unique_ptr<PointT> make_point(const std::string& id, const Eigen::Vector3d& place, double sigma,
                                   const std::string& role) {
  auto point = std::make_unique<PointT>();
  point->id = id, point->position = place, point->sigma.setConstant(sigma), point->role = role;
  return point;
}

void add_set_up(SurveyObservationsT& plan, const std::string& id, const Eigen::Vector3d& place, const PointsT& markers,
                double range) {
  auto point = std::make_unique<SurveyPointT>();
  point->id = id, point->position = place, point->roles = "fff";
  plan.points.push_back(std::move(point));
  for (const auto& marker : markers.points) {
    if ((marker->position - place).norm() > range) continue;
    auto sight = std::make_unique<SurveyObservationT>();
    sight->kind = SurveyKind::slope_distance, sight->from = id, sight->to = marker->id;
    plan.observations.push_back(std::move(sight));
  }
}

/// The same for places that differ by millimetres: on a grid whose lines are where no design has anchors.
Eigen::Vector3d steady(const Eigen::Vector3d& place) {
  constexpr double width = 0.5, line = 0.137;  // [m]
  return width * ((place.array() - line) / width).floor() + line;
}

/// Whether something that happens with this share in each round has happened by `round`, counted from 0.
bool has_happened(double share, std::int64_t round, std::uint64_t seed, const std::string& what) {
  Random luck(seed, what);
  bool happened = false;
  for (std::int64_t r = 0; r <= round && share > 0; ++r) happened = luck.uniform() < share || happened;
  return happened;
}

}  // namespace

void SimulateSite::bump_plates(PointsT& site, std::int64_t round, Context& context) {
  int bumped = 0;
  for (auto& point : site.points)
    if (has_happened(*bump_share, round, static_cast<std::uint64_t>(*fault_seed), "bump " + point->id))
      point->position += kPlateBump, ++bumped;
  context.metric("plates_bumped", bumped, "1");
}

void SimulateSite::run(Context& context) {
  PointsT site = truth.unpack();
  site.covariance.clear();
  if (site.points.empty()) throw std::runtime_error("the truth has no points");
  Eigen::Vector3d low = site.points[0]->position, high = low;
  for (const auto& point : site.points) low = low.cwiseMin(point->position), high = high.cwiseMax(point->position);
  // Marks stay where they are when a bracket is set that lies outermost.
  low = steady(low), high = steady(high);
  const std::int64_t round = state ? state->round() : 0;
  bump_plates(site, round, context);
  PointsT known;
  const double before = low.y() - 2, beside = 6;
  int number = 0;
  for (const double z : {low.z() - 1, high.z() + 1})
    for (const double x : {low.x() - beside, 0.5 * (low.x() + high.x()), high.x() + beside}) {
      const std::string id = "K" + std::to_string(++number);
      const double y = number == 2 || number == 5 ? low.y() - *distance - 8 : before;
      const bool is_named = std::count(knocked->begin(), knocked->end(), id) > 0;
      const bool is_knocked = (is_named && round >= *knocked_from) ||
                              has_happened(*knock_share, round, static_cast<std::uint64_t>(*fault_seed), "knock " + id);
      const Eigen::Vector3d place(x, y, z);
      site.points.push_back(
          make_point(id, place + Eigen::Vector3d(0, 0, is_knocked ? kControlKnock : 0), 0, "control"));
      known.points.push_back(make_point(id, place, *control_sigma, "control"));
    }
  const std::size_t n = 3 * known.points.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = 0; j <= i; ++j) known.covariance.push_back(i == j ? *control_sigma * *control_sigma : 0.0);
  for (const std::string& mark : *knocked)
    if (std::none_of(known.points.begin(), known.points.end(), [&](const auto& point) { return point->id == mark; }))
      throw std::runtime_error("'knocked' names " + mark + ", and the control marks are K1 to K6");
  SurveyObservationsT plan;
  plan.info = std::make_unique<SurveyInfoT>();
  const double width = high.x() - low.x(), at = low.y() - *distance;
  add_set_up(plan, "S1", {low.x() + 0.2 * width, at, low.z() + 1.2}, site, *range);
  add_set_up(plan, "S2", {low.x() + 0.8 * width, at - 1, low.z() + 1.4}, site, *range);
  add_set_up(plan, "S3", {low.x() + 0.5 * width, at + 2, low.z() + 1.3}, site, *range);
  markers.commit(site), set_ups.commit(plan), control.commit(known);
}

}  // namespace plumbline::loop

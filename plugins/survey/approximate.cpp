// Two levels. A Frame places as much as it can from the points it knows. Where it is stuck, a figure that is not placed
// yet starts a Frame of its own, which grows without any known point and is then fitted onto the first one by the
// points both have. Networks of angles, where no figure has distances, grow from one side of assumed length.
#include "approximate.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "approximate_figure.hpp"
#include "approximate_frame.hpp"

namespace plumbline::survey {

namespace {

/// The figure with the most complete sights to points that are not placed; -1 if none has any.
int best_seed(const Figures& figures, const Frame& frame, const std::vector<char>& tried) {
  int best = -1;
  size_t most = 0;
  for (size_t f = 0; f < figures.figures.size(); ++f) {
    if (tried[f]) continue;
    size_t count = 0, open = frame.has_plan(figures.figures[f].station) ? 0 : 1;
    for (const PolarSight& s : figures.figures[f].sights) {
      if (std::isnan(s.direction) || (std::isnan(s.horizontal) && std::isnan(s.slope))) continue;
      ++count;
      if (!frame.has_plan(s.to)) ++open;
    }
    if (open == 0 || count <= most) continue;
    most = count;
    best = static_cast<int>(f);
  }
  return best;
}

/// Figures with distances, each grown as far as it goes, one after another fitted onto the frame.
void chain_figures(const SurveyObservations& survey, const Figures& figures, bool guess, Frame& frame) {
  std::vector<char> tried(figures.figures.size(), 0);
  for (int f = best_seed(figures, frame, tried); f >= 0; f = best_seed(figures, frame, tried)) {
    tried[f] = 1;
    Frame local(survey, figures);
    local.seed(static_cast<size_t>(f));
    local.grow(guess);
    local.settle_north();
    if (frame.adopt(local, guess)) {
      frame.grow(guess);
      std::fill(tried.begin(), tried.end(), 0);
      tried[f] = 1;
    }
  }
}

/// Triangulation: what directions place between two points without a length.
void chain_triangles(const SurveyObservations& survey, const Figures& figures, bool guess, Frame& frame) {
  std::set<std::string> seen;
  for (size_t f = 0; f < figures.figures.size(); ++f)
    for (const PolarSight& s : figures.figures[f].sights) {
      const std::string& station = figures.figures[f].station;
      if (std::isnan(s.direction) || frame.has_plan(station) || seen.contains(station)) continue;
      Frame local(survey, figures);
      local.seed_shape(f, s.to);
      local.grow(guess);
      if (local.plan().size() < 3) continue;  // not a triangle
      for (const auto& [id, p] : local.plan()) seen.insert(id);
      local.settle_scale(frame);
      local.grow(guess);
      local.settle_north();
      if (frame.adopt(local, guess)) frame.grow(guess);
    }
}

/// Heights of networks that have nothing but height differences.
void seed_height(const Figures& figures, Frame& frame) {
  if (!frame.height().empty()) return;
  if (!figures.height_differences.empty()) {
    frame.set_height(figures.height_differences.front().from, 0);
  } else {
    for (const Figure& f : figures.figures)
      if (!f.sights.empty()) {
        frame.set_height(f.station, 0);
        break;
      }
  }
  frame.grow(true);
}

}  // namespace

Approximation approximate_coordinates(const SurveyObservations& survey,
                                      const std::vector<MeanObservation>& observations,
                                      const std::map<std::string, Eigen::Vector3d>& points) {
  const Figures figures = make_figures(survey, observations);
  Frame frame(survey, figures);
  for (const auto& [id, p] : points) {
    if (!std::isnan(p.x()) && !std::isnan(p.y())) frame.set_plan(id, p.head<2>());
    if (!std::isnan(p.z())) frame.set_height(id, p.z());
  }
  for (const CoordinateGroup& group : survey.coordinates)
    for (size_t k = 0; k + 1 < group.components.size(); ++k) {
      const auto& c = group.components[k];
      const auto at = static_cast<Eigen::Index>(k);
      if (c.axis == 0 && group.components[k + 1].point == c.point && group.components[k + 1].axis == 1)
        frame.set_plan(c.point, group.values.segment<2>(at));
    }
  for (const CoordinateGroup& group : survey.coordinates)
    for (size_t k = 0; k < group.components.size(); ++k)
      if (group.components[k].axis == 2)
        frame.set_height(group.components[k].point, group.values[static_cast<Eigen::Index>(k)]);
  for (const bool guess : {false, true}) {
    frame.grow(guess);
    chain_figures(survey, figures, guess, frame);
    chain_triangles(survey, figures, guess, frame);
  }
  seed_height(figures, frame);

  Approximation result;
  result.points = points;
  for (const auto& [id, p] : frame.plan()) {
    auto& q = result.points.try_emplace(id, Eigen::Vector3d::Constant(kNotGiven)).first->second;
    if (std::isnan(q.x())) q.head<2>() = p;
  }
  for (const auto& [id, h] : frame.height()) {
    auto& q = result.points.try_emplace(id, Eigen::Vector3d::Constant(kNotGiven)).first->second;
    if (std::isnan(q.z())) q.z() = h;
  }
  for (size_t i = 0; i < survey.set_ups.size(); ++i) result.orientations.push_back(frame.orientation(i));
  return result;
}

}  // namespace plumbline::survey

// What rays, circles and spheres place in a frame.
#include <cmath>
#include <limits>
#include <numbers>

#include "survey/model/observation_equations.hpp"
#include "survey/start/approximate_frame.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector2d;

}  // namespace

bool Frame::grow_by_intersection(bool accept_ambiguous) {
  std::map<std::string, std::vector<Locus>> loci;
  for (size_t f = 0; f < figures_.figures.size(); ++f) collect_loci(f, loci);
  for (const DistanceLine& d : figures_.distances) {
    const double horizontal = horizontal_of(d.from, d.to, d.horizontal, d.slope, d.heights);
    add_circle(d.from, d.to, horizontal, loci);
    add_circle(d.to, d.from, horizontal, loci);
  }
  for (const auto& [id, lines] : loci) {
    const std::vector<Vector2d> places = best_intersections(lines);
    if (places.empty() || (places.size() > 1 && !accept_ambiguous)) continue;
    const int count = static_cast<int>(places.size());
    set_plan(id, places[count > 1 ? choices_.choose(name_ + id, count) : 0]);
    return true;
  }
  for (size_t f = 0; f < figures_.figures.size(); ++f)
    if (place_by_resection(f)) return true;
  return place_by_slope_distances(accept_ambiguous) ||
         (accept_ambiguous && (place_height_by_slope_distances() || place_by_conditions()));
}

void Frame::add_circle(const std::string& known, const std::string& unknown, double radius,
                       std::map<std::string, std::vector<Locus>>& loci) const {
  if (!has_plan(known) || has_plan(unknown) || std::isnan(radius)) return;
  loci[unknown].push_back({plan_.at(known), kNotGiven, radius});
}

void Frame::collect_loci(size_t f, std::map<std::string, std::vector<Locus>>& loci) const {
  const Figure& figure = figures_.figures[f];
  const bool to_north = figure.oriented_to_north && !seeded_;
  const bool oriented = !std::isnan(orientation_[f]) || to_north;
  const double turn = std::isnan(orientation_[f]) ? 0 : orientation_[f];
  if (!oriented && !has_plan(figure.station)) collect_angle_loci(figure, loci[figure.station]);
  for (const PolarSight& s : figure.sights) {
    const double horizontal = horizontal_of(figure.station, s.to, s.horizontal, s.slope, s.heights);
    add_circle(figure.station, s.to, horizontal, loci);
    add_circle(s.to, figure.station, horizontal, loci);
    if (std::isnan(s.direction) || !oriented) continue;
    if (has_plan(figure.station) && !has_plan(s.to))
      loci[s.to].push_back({plan_.at(figure.station), s.direction + turn, kNotGiven});
    if (has_plan(s.to) && !has_plan(figure.station))
      loci[figure.station].push_back({plan_.at(s.to), s.direction + turn + std::numbers::pi, kNotGiven});
  }
}

void Frame::collect_angle_loci(const Figure& figure, std::vector<Locus>& loci) const {
  constexpr size_t kMost = 8;
  std::vector<const PolarSight*> known;
  for (const PolarSight& s : figure.sights)
    if (!std::isnan(s.direction) && has_plan(s.to) && known.size() < kMost) known.push_back(&s);
  for (size_t i = 0; i < known.size(); ++i)
    for (size_t j = i + 1; j < known.size(); ++j) {
      const auto locus = locus_of_angle(plan_.at(known[i]->to), plan_.at(known[j]->to),
                                        wrap_angle(known[j]->direction - known[i]->direction));
      if (locus) loci.push_back(*locus);
    }
}

bool Frame::place_by_resection(size_t f) {
  const Figure& figure = figures_.figures[f];
  if (has_plan(figure.station)) return false;
  std::vector<const PolarSight*> known;
  for (const PolarSight& s : figure.sights)
    if (!std::isnan(s.direction) && has_plan(s.to)) known.push_back(&s);
  if (known.size() > 8) known.resize(8);
  double best = std::numeric_limits<double>::infinity();
  std::optional<Vector2d> place;
  for (size_t i = 0; i < known.size(); ++i)
    for (size_t j = i + 1; j < known.size(); ++j)
      for (size_t k = j + 1; k < known.size(); ++k) {
        const Vector2d points[3] = {plan_.at(known[i]->to), plan_.at(known[j]->to), plan_.at(known[k]->to)};
        const double directions[3] = {known[i]->direction, known[j]->direction, known[k]->direction};
        const auto p = resection(points, directions);
        if (!p) continue;
        const double score = resection_misfit(*p, known);
        if (score >= best) continue;
        best = score;
        place = p;
      }
  if (!place) return false;
  set_plan(figure.station, *place);
  return true;
}

double Frame::resection_misfit(const Vector2d& p, const std::vector<const PolarSight*>& known) const {
  const double o = azimuth_between(p, plan_.at(known[0]->to)) - known[0]->direction;
  double sum = 0;
  for (const PolarSight* s : known) sum += std::abs(wrap_angle(azimuth_between(p, plan_.at(s->to)) - s->direction - o));
  return sum;
}

}  // namespace plumbline::survey

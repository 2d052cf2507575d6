#include "survey/start/approximate_frame.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "geometry/median.hpp"
#include "plumbline/stop.hpp"
#include "survey/model/observation_equations.hpp"

namespace plumbline::survey {

using Eigen::Vector2d;

double azimuth_between(const Vector2d& from, const Vector2d& to) {
  return std::atan2(to.x() - from.x(), to.y() - from.y());
}

void Frame::grow(bool guess) {
  while (grow_well_determined() || grow_by_intersection(false) || (guess && grow_by_intersection(true))) {
    stop_point();
  }
}

void Frame::seed(size_t figure) {
  const Figure& f = figures_.figures[figure];
  seeded_ = true;
  set_plan(f.station, Vector2d::Zero());
  set_height(f.station, 0);
  orientation_[figure] = 0;
  place_polar(figure);
}

void Frame::seed_shape(size_t figure, const std::string& target) {
  constexpr double kSide = 1000.0;  // [m]
  const Figure& f = figures_.figures[figure];
  seeded_ = scale_open_ = true;
  orientation_[figure] = 0;
  set_plan(f.station, Vector2d::Zero());
  for (const PolarSight& s : f.sights)
    if (s.to == target) set_plan(target, kSide * Vector2d(std::sin(s.direction), std::cos(s.direction)));
}

double Frame::misfit() const {
  double sum = 0;
  const auto add = [&](double misclosure, double length) {
    if (!std::isnan(misclosure)) sum += std::min(1.0, 10 * std::abs(misclosure) / std::max(length, 0.1));
  };
  const auto add_distance = [&](const std::string& a, const std::string& b, const DistanceLine& d) {
    if (!has_plan(a) || !has_plan(b)) return;
    const double own = (plan_.at(b) - plan_.at(a)).norm();
    add(horizontal_of(a, b, d.horizontal, d.slope, d.heights) - own, own);
    if (!std::isnan(d.slope) && has_height(a) && has_height(b))
      add(std::hypot(own, height_.at(b) - height_.at(a) - d.heights) - d.slope, d.slope);
  };
  for (const DistanceLine& d : figures_.distances) add_distance(d.from, d.to, d);
  for (const HeightDifference& d : figures_.height_differences)
    if (has_height(d.from) && has_height(d.to)) add(height_.at(d.to) - height_.at(d.from) - d.value, 10);
  for (const Figure& f : figures_.figures) {
    const double orientation = f.oriented_to_north && !seeded_ ? 0 : mean_orientation(f).value_or(kNotGiven);
    for (const PolarSight& s : f.sights) {
      add_distance(f.station, s.to, {f.station, s.to, s.horizontal, s.slope, s.heights});
      const bool heights = has_height(f.station) && has_height(s.to);
      if (heights && !std::isnan(s.height_difference))
        add(height_.at(s.to) - height_.at(f.station) - s.height_difference, 10);
      if (!has_plan(f.station) || !has_plan(s.to)) continue;
      const double turn = azimuth_between(plan_.at(f.station), plan_.at(s.to)) - s.direction - orientation;
      add(std::isnan(turn) ? kNotGiven : wrap_angle(turn), 1);
    }
  }
  return sum;
}

std::vector<double> Frame::scales_of_distances() const {
  std::vector<double> scales;
  const auto add = [&](const std::string& a, const std::string& b, double measured) {
    if (std::isnan(measured) || !has_plan(a) || !has_plan(b)) return;
    const double own = (plan_.at(b) - plan_.at(a)).norm();
    if (own > 0) scales.push_back(measured / own);
  };
  for (const DistanceLine& d : figures_.distances)
    add(d.from, d.to, horizontal_of(d.from, d.to, d.horizontal, d.slope, d.heights));
  for (const Figure& f : figures_.figures)
    for (const PolarSight& s : f.sights)
      add(f.station, s.to, horizontal_of(f.station, s.to, s.horizontal, s.slope, s.heights));
  return scales;
}

bool Frame::settle_scale(const Frame& known) {
  scale_open_ = false;
  std::vector<double> scales = scales_of_distances();
  if (scales.empty())
    for (auto a = plan_.begin(); a != plan_.end(); ++a)
      for (auto b = std::next(a); b != plan_.end(); ++b) {
        const double own = (b->second - a->second).norm();
        if (own > 0 && known.has_plan(a->first) && known.has_plan(b->first))
          scales.push_back((known.plan_.at(b->first) - known.plan_.at(a->first)).norm() / own);
      }
  if (scales.empty()) return false;
  const double scale = upper_median(std::move(scales));
  for (auto& [id, p] : plan_) p *= scale;
  return true;
}

void Frame::settle_north() {
  if (!seeded_) return;
  std::vector<double> turns;
  const auto add = [&](const std::string& from, const std::string& to, double azimuth) {
    if (std::isnan(azimuth) || !has_plan(from) || !has_plan(to)) return;
    const double turn = azimuth - azimuth_between(plan_.at(from), plan_.at(to));
    turns.push_back(turns.empty() ? turn : turns.front() + wrap_angle(turn - turns.front()));
  };
  for (const Figure& f : figures_.figures)
    for (const PolarSight& s : f.sights)
      if (f.oriented_to_north) add(f.station, s.to, s.direction);
  for (const VectorGroup& group : survey_.vectors)
    for (size_t k = 0; k < group.vectors.size(); ++k) {
      const Eigen::Vector3d d = group.values.segment<3>(static_cast<Eigen::Index>(3 * k));
      if (d.head<2>().norm() > 0) add(group.vectors[k].from, group.vectors[k].to, std::atan2(d.x(), d.y()));
    }
  if (turns.empty()) return;
  PlaneMotion motion;
  motion.rotation = upper_median(std::move(turns));
  for (auto& [id, p] : plan_) p = motion(p);
  for (double& orientation : orientation_) orientation += motion.rotation;
  seeded_ = false;
}

void Frame::seed_vector(const std::string& from) {
  set_plan(from, Vector2d::Zero());
  set_height(from, 0);
}

bool Frame::adopt(const Frame& other, bool guess) {
  const bool plan_taken = adopt_plan(other, guess);
  const bool height_taken = adopt_height(other);
  settle_north();
  return plan_taken || height_taken;
}

bool Frame::adopt_unrelated(const Frame& other) {
  for (const auto& [id, p] : other.plan_)
    if (has_plan(id) || has_height(id)) return false;
  // Beside the others: two frames whose origins coincide would give an observation between them no direction.
  constexpr double kBeside = 1234.5;  // [m]
  const Vector2d shift(kBeside * static_cast<double>(plan_.size()), 0);
  for (const auto& [id, p] : other.plan_) plan_.emplace(id, p + shift);
  for (const auto& [id, h] : other.height_) height_.emplace(id, h);
  return !other.plan_.empty();
}

bool Frame::grow_well_determined() {
  bool any = false;
  for (bool changed = true; changed;) {
    changed = false;
    for (size_t f = 0; f < figures_.figures.size(); ++f) {
      changed |= place_free_station(f);
      changed |= orient(f);
      changed |= place_polar(f);
      changed |= carry_heights(f);
    }
    changed |= carry_height_differences();
    changed |= carry_vectors();
    any |= changed;
  }
  return any;
}

std::optional<Vector2d> Frame::local_position(const Figure& figure, const PolarSight& s) const {
  const double horizontal = horizontal_of(figure.station, s.to, s.horizontal, s.slope, s.heights);
  if (std::isnan(s.direction) || std::isnan(horizontal)) return std::nullopt;
  return Vector2d(horizontal * std::sin(s.direction), horizontal * std::cos(s.direction));
}

double Frame::horizontal_of(const std::string& a, const std::string& b, double horizontal, double slope,
                            double heights) const {
  if (scale_open_) return kNotGiven;
  if (!std::isnan(horizontal) || std::isnan(slope)) return horizontal;
  if (!height_.contains(a) || !height_.contains(b)) return heightless(a) || heightless(b) ? slope : kNotGiven;
  const double rise = height_.at(b) - height_.at(a) - heights;
  return std::sqrt(std::max(0.0, slope * slope - rise * rise));
}

bool Frame::place_free_station(size_t f) {
  const Figure& figure = figures_.figures[f];
  if (has_plan(figure.station)) return false;
  std::vector<Vector2d> from, to;
  for (const PolarSight& s : figure.sights) {
    const auto p = local_position(figure, s);
    if (!p || !has_plan(s.to)) continue;
    from.push_back(*p);
    to.push_back(plan_.at(s.to));
  }
  const auto motion = fit_plane(from, to);
  if (!motion) return false;
  set_plan(figure.station, motion->translation);
  orientation_[f] = motion->rotation;
  return true;
}

bool Frame::orient(size_t f) {
  const Figure& figure = figures_.figures[f];
  if (!std::isnan(orientation_[f])) return false;
  if (figure.oriented_to_north && !seeded_) {
    orientation_[f] = 0;
    return true;
  }
  if (!has_plan(figure.station)) return orient_by_neighbour(f) || orient_by_reverse_sight(f);
  const auto orientation = mean_orientation(figure);
  if (!orientation) return orient_by_neighbour(f);
  orientation_[f] = *orientation;
  return true;
}

std::optional<double> Frame::mean_orientation(const Figure& figure) const {
  if (!has_plan(figure.station)) return std::nullopt;
  const Vector2d& station = plan_.at(figure.station);
  Vector2d sum = Vector2d::Zero();  // longer sights orient better
  for (const PolarSight& s : figure.sights) {
    if (std::isnan(s.direction) || !has_plan(s.to)) continue;
    const Vector2d& target = plan_.at(s.to);
    const double o = azimuth_between(station, target) - s.direction;
    sum += (target - station).norm() * Vector2d(std::sin(o), std::cos(o));
  }
  if (sum.norm() < 1e-6) return std::nullopt;
  return std::atan2(sum.x(), sum.y());
}

bool Frame::orient_by_neighbour(size_t f) {
  const Figure& figure = figures_.figures[f];
  for (size_t g = 0; g < figures_.figures.size(); ++g) {
    const Figure& other = figures_.figures[g];
    if (g == f || other.station != figure.station || std::isnan(orientation_[g])) continue;
    for (const PolarSight& a : figure.sights)
      for (const PolarSight& b : other.sights) {
        if (a.to != b.to || std::isnan(a.direction) || std::isnan(b.direction)) continue;
        orientation_[f] = orientation_[g] + b.direction - a.direction;
        return true;
      }
  }
  return false;
}

bool Frame::orient_by_reverse_sight(size_t f) {
  const Figure& figure = figures_.figures[f];
  for (size_t g = 0; g < figures_.figures.size(); ++g) {
    const Figure& other = figures_.figures[g];
    if (std::isnan(orientation_[g])) continue;
    for (const PolarSight& there : other.sights) {
      if (there.to != figure.station || std::isnan(there.direction)) continue;
      for (const PolarSight& back : figure.sights) {
        if (back.to != other.station || std::isnan(back.direction)) continue;
        orientation_[f] = orientation_[g] + there.direction + std::numbers::pi - back.direction;
        return true;
      }
    }
  }
  return false;
}

bool Frame::place_polar(size_t f) {
  const Figure& figure = figures_.figures[f];
  if (std::isnan(orientation_[f]) || !has_plan(figure.station)) return false;
  bool changed = false;
  for (const PolarSight& s : figure.sights) {
    const auto p = local_position(figure, s);
    if (!p || has_plan(s.to)) continue;
    PlaneMotion motion;
    motion.rotation = orientation_[f];
    motion.translation = plan_.at(figure.station);
    set_plan(s.to, motion(*p));
    changed = true;
  }
  return changed;
}

bool Frame::carry_heights(size_t f) {
  const Figure& figure = figures_.figures[f];
  bool changed = false;
  for (const PolarSight& s : figure.sights) {
    double difference = s.height_difference;
    if (std::isnan(difference) && !std::isnan(s.zenith) && has_plan(figure.station) && has_plan(s.to) &&
        std::abs(std::sin(s.zenith)) > 1e-3)
      difference = (plan_.at(s.to) - plan_.at(figure.station)).norm() / std::tan(s.zenith) + s.heights;
    changed |= carry_height(figure.station, s.to, difference);
  }
  return changed;
}

bool Frame::carry_height(const std::string& from, const std::string& to, double difference) {
  if (scale_open_ || std::isnan(difference) || has_height(from) == has_height(to)) return false;
  if (has_height(from))
    set_height(to, height_.at(from) + difference);
  else
    set_height(from, height_.at(to) - difference);
  return true;
}

bool Frame::carry_height_differences() {
  bool changed = false;
  for (const HeightDifference& d : figures_.height_differences) changed |= carry_height(d.from, d.to, d.value);
  return changed;
}

bool Frame::carry_vectors() {
  if (scale_open_) return false;
  bool changed = false;
  for (const VectorGroup& group : survey_.vectors)
    for (size_t k = 0; k < group.vectors.size(); ++k) {
      const auto& v = group.vectors[k];
      const Eigen::Vector3d d = group.values.segment<3>(static_cast<Eigen::Index>(3 * k));
      changed |= carry_height(v.from, v.to, d.z() + v.from_height - v.to_height);
      if (seeded_ || has_plan(v.from) == has_plan(v.to)) continue;  // its axes are east and north
      if (has_plan(v.from))
        set_plan(v.to, plan_.at(v.from) + d.head<2>());
      else
        set_plan(v.from, plan_.at(v.to) - d.head<2>());
      changed = true;
    }
  return changed;
}

double Frame::stated_turn() const {
  const auto turn_to = [&](size_t f, double orientation) { return wrap_angle(orientation - orientation_[f]); };
  for (size_t f = 0; f < figures_.figures.size(); ++f) {
    const int set_up = figures_.figures[f].set_up;
    if (set_up < 0 || std::isnan(orientation_[f])) continue;
    const double stated = survey_.set_ups[set_up].stated_orientation;
    if (!std::isnan(stated)) return turn_to(f, stated);
  }
  for (size_t f = 0; f < figures_.figures.size(); ++f)
    if (figures_.figures[f].set_up >= 0 && !std::isnan(orientation_[f])) return turn_to(f, 0);
  return 0;
}

bool Frame::adopt_plan(const Frame& other, bool guess) {
  std::vector<Vector2d> from, to;
  for (const auto& [id, p] : other.plan_)
    if (has_plan(id)) {
      from.push_back(p);
      to.push_back(plan_.at(id));
    }
  PlaneMotion motion;
  // Points above one another are one in the plane.
  const auto coincide = [&](const Vector2d& p) { return (p - to.front()).norm() < 0.01; };
  if (const auto fit = fit_plane(from, to)) {
    motion = *fit;
  } else if (!from.empty() && std::all_of(to.begin(), to.end(), coincide) && (guess || !other.seeded_)) {
    // A sight to another known point may decide how it turns, in two ways even: it starts in several. Without another
    // known point nothing decides but what the file states.
    constexpr int kTurns = 8;
    const bool decided_by_sights =
        std::any_of(plan_.begin(), plan_.end(), [&](const auto& known) { return !coincide(known.second); });
    if (other.seeded_) motion.rotation = other.stated_turn();
    if (other.seeded_ && decided_by_sights)
      motion.rotation += choices_.choose(other.name_ + "north", kTurns) * 2 * std::numbers::pi / kTurns;
    motion.translation = to[0] - motion(from[0]);
  } else if (!plan_.empty()) {
    return false;
  } else if (other.seeded_) {
    motion.rotation = other.stated_turn();
  }
  bool changed = false;
  if (plan_.empty()) seeded_ = other.seeded_;
  for (const auto& [id, p] : other.plan_) changed |= plan_.emplace(id, motion(p)).second;
  for (size_t f = 0; f < orientation_.size(); ++f)
    if (std::isnan(orientation_[f]) && !std::isnan(other.orientation_[f]))
      orientation_[f] = other.orientation_[f] + motion.rotation;
  return changed;
}

bool Frame::adopt_height(const Frame& other) {
  double lift = 0;
  int shared = 0;
  for (const auto& [id, h] : other.height_)
    if (has_height(id)) {
      lift += height_.at(id) - h;
      ++shared;
    }
  if (shared == 0 && !height_.empty()) return false;
  if (shared > 0) lift /= shared;
  bool changed = false;
  for (const auto& [id, h] : other.height_) changed |= height_.emplace(id, h + lift).second;
  return changed;
}

}  // namespace plumbline::survey

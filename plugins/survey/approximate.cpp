// Two levels. A Frame places as much as it can from the points it knows. Where it is stuck, a figure that is not placed
// yet starts a Frame of its own, which grows without any known point and is then fitted onto the first one by the
// points both have.
#include "approximate.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "approximate_figure.hpp"
#include "observation_equations.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector2d;

double azimuth_between(const Vector2d& from, const Vector2d& to) {
  return std::atan2(to.x() - from.x(), to.y() - from.y());
}

class Frame {
 public:
  Frame(const SurveyObservations& survey, const Figures& figures)
      : survey_(survey), figures_(figures), orientation_(figures.figures.size(), kNotGiven) {}

  void set_plan(const std::string& id, const Vector2d& p) { plan_.emplace(id, p); }
  void set_height(const std::string& id, double h) { height_.emplace(id, h); }
  bool has_plan(const std::string& id) const { return plan_.contains(id); }
  bool has_height(const std::string& id) const { return height_.contains(id); }
  const std::map<std::string, Vector2d>& plan() const { return plan_; }
  const std::map<std::string, double>& height() const { return height_; }
  double orientation(size_t figure) const { return orientation_[figure]; }

  /// Places everything that follows from what is known.
  void grow() {
    while (grow_well_determined() || grow_by_intersection(false) || grow_by_intersection(true)) {
    }
  }

  /// Starts a frame without known points: the station is the origin, the zero of the circle is north.
  void seed(size_t figure) {
    const Figure& f = figures_.figures[figure];
    seeded_ = true;
    set_plan(f.station, Vector2d::Zero());
    set_height(f.station, 0);
    orientation_[figure] = 0;
    place_polar(figure);
  }

  /// Takes over the points of another frame. False if the two share too little.
  bool adopt(const Frame& other) {
    const bool plan_taken = adopt_plan(other);
    const bool height_taken = adopt_height(other);
    return plan_taken || height_taken;
  }

 private:
  bool grow_well_determined() {
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

  /// Plane position of a sight's target seen from the station with the circle's zero as north; nullopt without
  /// distance.
  std::optional<Vector2d> local_position(const Figure& figure, const PolarSight& s) const {
    const double horizontal = horizontal_of(figure.station, s.to, s.horizontal, s.slope, s.heights);
    if (std::isnan(s.direction) || std::isnan(horizontal)) return std::nullopt;
    return Vector2d(horizontal * std::sin(s.direction), horizontal * std::cos(s.direction));
  }

  /// A slope distance becomes horizontal with the heights of both ends; in a network without heights it is taken as it
  /// is.
  double horizontal_of(const std::string& a, const std::string& b, double horizontal, double slope,
                       double heights) const {
    if (!std::isnan(horizontal) || std::isnan(slope)) return horizontal;
    if (!height_.contains(a) || !height_.contains(b)) return heightless(a) || heightless(b) ? slope : kNotGiven;
    const double rise = height_.at(b) - height_.at(a) - heights;
    return std::sqrt(std::max(0.0, slope * slope - rise * rise));
  }

  bool heightless(const std::string& id) const {
    for (const Point& p : survey_.points)
      if (p.id == id) return p.roles[2] == CoordinateRole::unused;
    return false;
  }

  /// Station and orientation from >= 2 known targets with direction and distance.
  bool place_free_station(size_t f) {
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

  bool orient(size_t f) {
    const Figure& figure = figures_.figures[f];
    if (!std::isnan(orientation_[f])) return false;
    if (figure.oriented_to_north && !seeded_) {
      orientation_[f] = 0;
      return true;
    }
    if (!has_plan(figure.station)) return orient_by_neighbour(f) || orient_by_reverse_sight(f);
    const Vector2d& station = plan_.at(figure.station);
    Vector2d sum = Vector2d::Zero();  // longer sights orient better
    for (const PolarSight& s : figure.sights) {
      if (std::isnan(s.direction) || !has_plan(s.to)) continue;
      const Vector2d& target = plan_.at(s.to);
      const double o = azimuth_between(station, target) - s.direction;
      sum += (target - station).norm() * Vector2d(std::sin(o), std::cos(o));
    }
    if (sum.norm() < 1e-6) return orient_by_neighbour(f);
    orientation_[f] = std::atan2(sum.x(), sum.y());
    return true;
  }

  /// Another figure on the same station (an azimuth, another round) that is oriented and sights a common target.
  bool orient_by_neighbour(size_t f) {
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

  /// A figure whose station is not placed yet, sighted from an oriented one that it sights itself.
  bool orient_by_reverse_sight(size_t f) {
    const Figure& figure = figures_.figures[f];
    for (size_t g = 0; g < figures_.figures.size(); ++g) {
      const Figure& other = figures_.figures[g];
      if (std::isnan(orientation_[g])) continue;
      for (const PolarSight& there : other.sights) {
        if (there.to != figure.station || std::isnan(there.direction)) continue;
        for (const PolarSight& back : figure.sights) {
          if (back.to != other.station || std::isnan(back.direction)) continue;
          orientation_[f] = orientation_[g] + there.direction + std::acos(-1.0) - back.direction;
          return true;
        }
      }
    }
    return false;
  }

  bool place_polar(size_t f) {
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

  bool carry_heights(size_t f) {
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

  bool carry_height(const std::string& from, const std::string& to, double difference) {
    if (std::isnan(difference) || has_height(from) == has_height(to)) return false;
    if (has_height(from))
      set_height(to, height_.at(from) + difference);
    else
      set_height(from, height_.at(to) - difference);
    return true;
  }

  bool carry_height_differences() {
    bool changed = false;
    for (const HeightDifference& d : figures_.height_differences) changed |= carry_height(d.from, d.to, d.value);
    return changed;
  }

  bool carry_vectors() {
    bool changed = false;
    for (const VectorGroup& group : survey_.vectors)
      for (size_t k = 0; k < group.vectors.size(); ++k) {
        const auto& v = group.vectors[k];
        const Eigen::Vector3d d = group.values.segment<3>(static_cast<Eigen::Index>(3 * k));
        changed |= carry_height(v.from, v.to, d.z() + v.from_height - v.to_height);
        if (has_plan(v.from) == has_plan(v.to)) continue;
        if (has_plan(v.from))
          set_plan(v.to, plan_.at(v.from) + d.head<2>());
        else
          set_plan(v.from, plan_.at(v.to) - d.head<2>());
        changed = true;
      }
    return changed;
  }

  /// One point at a time, so that what it determines well comes before the next intersection.
  bool grow_by_intersection(bool accept_ambiguous) {
    std::map<std::string, std::vector<Locus>> loci;
    for (size_t f = 0; f < figures_.figures.size(); ++f) collect_loci(f, loci);
    for (const DistanceLine& d : figures_.distances) {
      const double horizontal = horizontal_of(d.from, d.to, d.horizontal, d.slope, d.heights);
      add_circle(d.from, d.to, horizontal, loci);
      add_circle(d.to, d.from, horizontal, loci);
    }
    for (const auto& [id, lines] : loci) {
      const auto p = best_intersection(lines, accept_ambiguous);
      if (!p) continue;
      set_plan(id, *p);
      return true;
    }
    for (size_t f = 0; f < figures_.figures.size(); ++f)
      if (place_by_resection(f)) return true;
    return place_by_slope_distances();
  }

  void add_circle(const std::string& known, const std::string& unknown, double radius,
                  std::map<std::string, std::vector<Locus>>& loci) const {
    if (!has_plan(known) || has_plan(unknown) || std::isnan(radius)) return;
    loci[unknown].push_back({plan_.at(known), kNotGiven, radius});
  }

  void collect_loci(size_t f, std::map<std::string, std::vector<Locus>>& loci) const {
    const Figure& figure = figures_.figures[f];
    const bool to_north = figure.oriented_to_north && !seeded_;
    const bool oriented = !std::isnan(orientation_[f]) || to_north;
    const double turn = std::isnan(orientation_[f]) ? 0 : orientation_[f];
    for (const PolarSight& s : figure.sights) {
      const double horizontal = horizontal_of(figure.station, s.to, s.horizontal, s.slope, s.heights);
      add_circle(figure.station, s.to, horizontal, loci);
      add_circle(s.to, figure.station, horizontal, loci);
      if (std::isnan(s.direction) || !oriented) continue;
      if (has_plan(figure.station) && !has_plan(s.to))
        loci[s.to].push_back({plan_.at(figure.station), s.direction + turn, kNotGiven});
      if (has_plan(s.to) && !has_plan(figure.station))
        loci[figure.station].push_back({plan_.at(s.to), s.direction + turn + std::acos(-1.0), kNotGiven});
    }
  }

  bool place_by_resection(size_t f) {
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

  double resection_misfit(const Vector2d& p, const std::vector<const PolarSight*>& known) const {
    const double o = azimuth_between(p, plan_.at(known[0]->to)) - known[0]->direction;
    double sum = 0;
    for (const PolarSight* s : known)
      sum += std::abs(wrap_angle(azimuth_between(p, plan_.at(s->to)) - s->direction - o));
    return sum;
  }

  /// Four spheres: differences of their equations are linear in the centre (height included).
  bool place_by_slope_distances() {
    struct Sphere {
      Eigen::Vector3d centre;
      double radius;
    };
    std::map<std::string, std::vector<Sphere>> spheres;
    const auto add = [&](const std::string& known, const std::string& unknown, double slope, double lift) {
      if (std::isnan(slope) || has_plan(unknown) || !has_plan(known) || !has_height(known)) return;
      const Vector2d& p = plan_.at(known);
      spheres[unknown].push_back({{p.x(), p.y(), height_.at(known) + lift}, slope});
    };
    for (const DistanceLine& d : figures_.distances) {
      add(d.from, d.to, d.slope, d.heights);
      add(d.to, d.from, d.slope, -d.heights);
    }
    for (const Figure& figure : figures_.figures)
      for (const PolarSight& s : figure.sights) {
        add(figure.station, s.to, s.slope, s.heights);
        add(s.to, figure.station, s.slope, -s.heights);
      }
    for (const auto& [id, list] : spheres) {
      if (list.size() < 4) continue;
      Eigen::MatrixXd a(list.size() - 1, 3);
      Eigen::VectorXd b(list.size() - 1);
      for (size_t k = 1; k < list.size(); ++k) {
        const auto row = static_cast<Eigen::Index>(k - 1);
        const Eigen::Vector3d d = list[k].centre - list[0].centre;
        a.row(row) = 2 * d.transpose();
        b[row] = d.squaredNorm() + list[0].radius * list[0].radius - list[k].radius * list[k].radius;
      }
      // Normal equations suffice for approximate values; a flat configuration leaves the height near the known points.
      const Eigen::Matrix3d n = a.transpose() * a + 1e-6 * Eigen::Matrix3d::Identity();
      const Eigen::Vector3d p = list[0].centre + n.inverse() * (a.transpose() * b);
      set_plan(id, p.head<2>());
      set_height(id, p.z());
      return true;
    }
    return false;
  }

  bool adopt_plan(const Frame& other) {
    std::vector<Vector2d> from, to;
    for (const auto& [id, p] : other.plan_)
      if (has_plan(id)) {
        from.push_back(p);
        to.push_back(plan_.at(id));
      }
    PlaneMotion motion;
    if (const auto fit = fit_plane(from, to)) {
      motion = *fit;
    } else if (from.size() == 1) {
      motion.translation = to[0] - from[0];
    } else if (!plan_.empty()) {
      return false;
    }
    bool changed = false;
    for (const auto& [id, p] : other.plan_) changed |= plan_.emplace(id, motion(p)).second;
    for (size_t f = 0; f < orientation_.size(); ++f)
      if (std::isnan(orientation_[f]) && !std::isnan(other.orientation_[f]))
        orientation_[f] = other.orientation_[f] + motion.rotation;
    return changed;
  }

  bool adopt_height(const Frame& other) {
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

  const SurveyObservations& survey_;
  const Figures& figures_;
  std::map<std::string, Vector2d> plan_;
  std::map<std::string, double> height_;
  std::vector<double> orientation_;
  bool seeded_ = false;  // its north is arbitrary
};

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
  frame.grow();
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
  frame.grow();
  std::vector<char> tried(figures.figures.size(), 0);
  for (int f = best_seed(figures, frame, tried); f >= 0; f = best_seed(figures, frame, tried)) {
    tried[f] = 1;
    Frame local(survey, figures);
    local.seed(static_cast<size_t>(f));
    local.grow();
    if (frame.adopt(local)) {
      frame.grow();
      std::fill(tried.begin(), tried.end(), 0);
      tried[f] = 1;
    }
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

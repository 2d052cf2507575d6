#include "survey/start/approximate_figure.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "survey/model/observation_equations.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector2d;

Vector2d polar(double azimuth, double length) { return {length * std::sin(azimuth), length * std::cos(azimuth)}; }

/// Adds an angle to the figure that has one of its arms, or to a new one.
void add_angle(const Observation& o, std::vector<Figure>& figures) {
  for (Figure& figure : figures) {
    if (figure.set_up >= 0 || figure.oriented_to_north || figure.station != o.from) continue;
    for (const PolarSight& sight : figure.sights) {
      const double direction = sight.direction;
      if (sight.to == o.to) {
        figure.sight_to(o.second_to).direction = direction + o.value;
        return;
      }
      if (sight.to == o.second_to) {
        figure.sight_to(o.to).direction = direction - o.value;
        return;
      }
    }
  }
  Figure figure;
  figure.station = o.from;
  figure.sight_to(o.to).direction = 0;
  figure.sight_to(o.second_to).direction = o.value;
  figures.push_back(std::move(figure));
}

void add_azimuth(const Observation& o, std::vector<Figure>& figures) {
  for (Figure& figure : figures)
    if (figure.oriented_to_north && figure.station == o.from) {
      figure.sight_to(o.to).direction = o.value;
      return;
    }
  Figure figure;
  figure.station = o.from;
  figure.oriented_to_north = true;
  figure.sight_to(o.to).direction = o.value;
  figures.push_back(std::move(figure));
}

/// Horizontal distance and height difference where zenith angle and distance give them.
void complete(PolarSight& s) {
  if (std::isnan(s.zenith)) return;
  if (std::isnan(s.horizontal) && !std::isnan(s.slope)) s.horizontal = s.slope * std::sin(s.zenith);
  if (!std::isnan(s.slope))
    s.height_difference = s.slope * std::cos(s.zenith) + s.heights;
  else if (!std::isnan(s.horizontal) && std::sin(s.zenith) > 1e-3)
    s.height_difference = s.horizontal / std::tan(s.zenith) + s.heights;
}

/// Sights whose distance stands on its own in the file (another cluster, or the other direction) get it; a difference
/// in instrument and target heights does not matter for approximate values.
void lend_distances(Figures& figures) {
  std::map<std::pair<std::string, std::string>, const DistanceLine*> lines;
  for (const DistanceLine& d : figures.distances) {
    lines.try_emplace({d.from, d.to}, &d);
    lines.try_emplace({d.to, d.from}, &d);
  }
  for (Figure& figure : figures.figures)
    for (PolarSight& s : figure.sights) {
      const auto line = lines.find({figure.station, s.to});
      if (line == lines.end() || !std::isnan(s.horizontal) || !std::isnan(s.slope)) continue;
      s.horizontal = line->second->horizontal;
      s.slope = line->second->slope;
    }
}

}  // namespace

PolarSight& Figure::sight_to(const std::string& target) {
  for (PolarSight& sight : sights)
    if (sight.to == target) return sight;
  sights.push_back({});
  sights.back().to = target;
  return sights.back();
}

Figures make_figures(const SurveyObservations& survey, const std::vector<MeanObservation>& observations) {
  Figures result;
  std::set<std::string> seen;  // of a name that stands twice the first counts
  for (const Point& p : survey.points)
    if (seen.insert(p.id).second && p.roles[2] == CoordinateRole::unused) result.heightless.insert(p.id);
  for (int i = 0; i < static_cast<int>(survey.set_ups.size()); ++i) {
    result.figures.emplace_back();
    result.figures.back().set_up = i;
    result.figures.back().station = survey.set_ups[i].station;
  }
  for (const MeanObservation& mean : observations) {
    const Observation& o = mean.observation;
    const double own_height = o.set_up >= 0 ? or_else(survey.set_ups[o.set_up].instrument_height, 0) : 0.0;
    const double heights = or_else(o.instrument_height, own_height) - or_else(o.target_height, 0);
    if (o.kind == ObservationKind::angle) {
      add_angle(o, result.figures);
    } else if (o.kind == ObservationKind::azimuth) {
      add_azimuth(o, result.figures);
    } else if (o.kind == ObservationKind::height_difference) {
      result.height_differences.push_back({o.from, o.to, o.value + heights});
    } else if (o.set_up >= 0 && o.from == survey.set_ups[o.set_up].station) {
      PolarSight& s = result.figures[o.set_up].sight_to(o.to);
      if (o.kind == ObservationKind::direction) s.direction = o.value;
      if (o.kind == ObservationKind::horizontal_distance) s.horizontal = o.value;
      if (o.kind == ObservationKind::slope_distance) s.slope = o.value;
      if (o.kind == ObservationKind::zenith_angle) s.zenith = o.value;
      s.heights = heights;
    } else if (o.kind == ObservationKind::horizontal_distance) {
      result.distances.push_back({o.from, o.to, o.value, kNotGiven, 0});
    } else if (o.kind == ObservationKind::slope_distance) {
      result.distances.push_back({o.from, o.to, kNotGiven, o.value, heights});
    } else {  // a zenith angle of its own: a figure with one sight
      Figure figure;
      figure.station = o.from;
      PolarSight& s = figure.sight_to(o.to);
      s.zenith = o.value;
      s.heights = heights;
      result.figures.push_back(std::move(figure));
    }
  }
  for (const LocalCoordinate& c : survey.local_coordinates) {
    const SetUp& set_up = survey.set_ups.at(c.set_up);
    PolarSight& s = result.figures[c.set_up].sight_to(c.point);
    s.heights = or_else(set_up.instrument_height, 0) - or_else(c.target_height, 0);
    s.direction = std::atan2(c.position.x(), c.position.y());
    s.horizontal = std::hypot(c.position.x(), c.position.y());
    s.slope = c.position.norm();
    s.zenith = std::atan2(s.horizontal, c.position.z());
  }
  lend_distances(result);
  for (Figure& figure : result.figures)
    for (PolarSight& s : figure.sights) complete(s);
  return result;
}

Vector2d PlaneMotion::operator()(const Vector2d& p) const {
  const double c = std::cos(rotation), s = std::sin(rotation);
  return Vector2d(c * p.x() + s * p.y(), -s * p.x() + c * p.y()) + translation;
}

std::optional<PlaneMotion> fit_plane(const std::vector<Vector2d>& from, const std::vector<Vector2d>& to) {
  const auto n = static_cast<double>(from.size());
  if (from.size() < 2) return std::nullopt;
  Vector2d a = Vector2d::Zero(), b = Vector2d::Zero();
  for (size_t i = 0; i < from.size(); ++i) {
    a += from[i] / n;
    b += to[i] / n;
  }
  double sine = 0, cosine = 0, spread = 0;
  for (size_t i = 0; i < from.size(); ++i) {
    const Vector2d p = from[i] - a, q = to[i] - b;
    sine += q.x() * p.y() - q.y() * p.x();
    cosine += p.dot(q);
    spread += p.squaredNorm();
  }
  if (spread < 1e-6 || std::hypot(sine, cosine) < 1e-9) return std::nullopt;
  PlaneMotion motion;
  motion.rotation = std::atan2(sine, cosine);
  motion.translation = b - motion(a);
  double squares = 0;
  for (size_t i = 0; i < from.size(); ++i) squares += (motion(from[i]) - to[i]).squaredNorm();
  motion.rms = std::sqrt(squares / n);
  return motion;
}

double Locus::misfit(const Vector2d& p) const {
  const Vector2d d = p - origin;
  if (!std::isnan(angle)) {
    const Vector2d a = left - p, b = right - p;
    const double nearer = std::min(a.norm(), b.norm()), chord = (right - left).norm();
    if (nearer < 1e-3 * chord) return chord;  // on one of the two itself: every such circle passes through them
    const double seen = std::atan2(b.x(), b.y()) - std::atan2(a.x(), a.y());
    return nearer * std::abs(wrap_angle(seen - angle));
  }
  if (std::isnan(azimuth)) return std::abs(d.norm() - radius);
  const Vector2d u = polar(azimuth, 1);
  const double along = d.dot(u);
  return along > 0 ? std::abs(d.x() * u.y() - d.y() * u.x()) : d.norm();
}

std::optional<Locus> locus_of_angle(const Vector2d& left, const Vector2d& right, double angle) {
  const Vector2d chord = right - left;
  const double sine = std::sin(angle);
  if (std::abs(sine) < 0.02 || chord.norm() < 1e-3) return std::nullopt;
  Locus locus;
  // Inscribed angle: the centre sees the chord under twice the angle; the point is to the right of left -> right.
  locus.origin = 0.5 * (left + right) + 0.5 * std::cos(angle) / sine * Vector2d(chord.y(), -chord.x());
  locus.radius = 0.5 * chord.norm() / std::abs(sine);
  locus.angle = angle;
  locus.left = left;
  locus.right = right;
  return locus;
}

std::vector<Vector2d> intersect(const Locus& first, const Locus& second) {
  const bool first_is_ray = !std::isnan(first.azimuth), second_is_ray = !std::isnan(second.azimuth);
  if (!first_is_ray && second_is_ray) return intersect(second, first);
  const Vector2d d = second.origin - first.origin;
  std::vector<Vector2d> points;
  if (first_is_ray) {
    const Vector2d u = polar(first.azimuth, 1);
    if (second_is_ray) {
      const Vector2d v = polar(second.azimuth, 1);
      const double cross = u.x() * v.y() - u.y() * v.x();
      if (std::abs(cross) < 0.02) return points;  // rays closer to parallel than one degree
      const double along = (d.x() * v.y() - d.y() * v.x()) / cross;
      if (along > 0) points.push_back(first.origin + along * u);
      return points;
    }
    const double middle = d.dot(u), offset2 = d.squaredNorm() - middle * middle;
    const double half2 = second.radius * second.radius - offset2;
    const double half = std::sqrt(std::max(0.0, half2));
    if (half2 < -0.01 * second.radius * second.radius) return points;
    if (middle + half > 0) points.push_back(first.origin + (middle + half) * u);
    if (middle - half > 0 && half > 0) points.push_back(first.origin + (middle - half) * u);
    return points;
  }
  const double distance = d.norm();
  if (distance < 1e-6 || distance > 1.05 * (first.radius + second.radius)) return points;
  const double along =
      (first.radius * first.radius - second.radius * second.radius + distance * distance) / (2 * distance);
  const double across2 = first.radius * first.radius - along * along;
  if (across2 < -0.05 * first.radius * first.radius) return points;
  const double across = std::sqrt(std::max(0.0, across2));
  const Vector2d u = d / distance, v(-u.y(), u.x());
  points.push_back(first.origin + along * u + across * v);
  if (across > 0) points.push_back(first.origin + along * u - across * v);
  return points;
}

std::vector<Vector2d> best_intersections(const std::vector<Locus>& loci) {
  constexpr double kCap = 10.0;  // [m]: one wrong line must not decide
  std::vector<std::pair<double, Vector2d>> candidates;
  for (size_t i = 0; i < loci.size(); ++i)
    for (size_t j = i + 1; j < loci.size(); ++j)
      for (const Vector2d& p : intersect(loci[i], loci[j])) {
        double score = 0;
        for (const Locus& locus : loci) score += std::min(kCap, locus.misfit(p));
        candidates.emplace_back(score, p);
      }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<Vector2d> places;
  if (candidates.empty()) return places;
  const double best = candidates.front().first;
  double length = 0;  // of the sights: small networks are known to centimetres, large ones to decimetres
  for (const Locus& locus : loci) length = std::max(length, (candidates.front().second - locus.origin).norm());
  const double slack = std::clamp(0.02 * length, 0.02, 0.5);
  for (const auto& [score, p] : candidates) {
    if (score >= best + slack && !places.empty()) break;
    const auto near = [&, s = score](const Vector2d& q) { return (p - q).norm() <= 5 * (s + best) + 2 * slack; };
    if (std::none_of(places.begin(), places.end(), near)) places.push_back(p);
  }
  return places;
}

std::optional<Vector2d> resection(const Vector2d known[3], const double directions[3]) {
  // In the source angles are counter-clockwise from x; clockwise from north is the same with x = N, y = E.
  const double x1 = known[0].y() - known[1].y(), y1 = known[0].x() - known[1].x();
  const double x3 = known[2].y() - known[1].y(), y3 = known[2].x() - known[1].x();
  const double s12 = std::sin(directions[1] - directions[0]), s23 = std::sin(directions[2] - directions[1]);
  const double s31 = std::sin(directions[0] - directions[2]);
  if (std::abs(s12) < 1e-3 || std::abs(s23) < 1e-3 || std::abs(s31) < 1e-3) return std::nullopt;
  const double t12 = std::cos(directions[1] - directions[0]) / s12, t23 = std::cos(directions[2] - directions[1]) / s23;
  const double t31 = (1 - t12 * t23) / (t12 + t23);
  const double x12 = x1 + t12 * y1, y12 = y1 - t12 * x1;
  const double x23 = x3 - t23 * y3, y23 = y3 + t23 * x3;
  const double x31 = (x3 + x1) + t31 * (y3 - y1), y31 = (y3 + y1) - t31 * (x3 - x1);
  const double k31 = x1 * x3 + y1 * y3 + t31 * (x1 * y3 - x3 * y1);
  const double determinant = (x12 - x23) * (y23 - y31) - (y12 - y23) * (x23 - x31);
  const double size = std::max(x1 * x1 + y1 * y1, x3 * x3 + y3 * y3);
  if (std::abs(determinant) < 1e-4 * size) return std::nullopt;
  const double north = known[1].y() + k31 * (y12 - y23) / determinant;
  const double east = known[1].x() + k31 * (x23 - x12) / determinant;
  return Vector2d(east, north);
}

}  // namespace plumbline::survey

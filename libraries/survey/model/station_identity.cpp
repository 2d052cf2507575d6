#include "survey/model/station_identity.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <vector>

#include "survey/model/observation_equations.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector2d;
using SeenFigure = std::map<std::string, Vector2d>;  // target seen from the station, zero of the circle as y [m]

constexpr double kSameFigure = 0.015;      // [m]: centring twice, and what targets may move
constexpr double kCentring = 0.005;        // [m]; beyond that, and beyond doubt, it is another mark
constexpr double kSameCoordinates = 0.01;  // [m]

bool is_face_2(const Observation& o) { return o.face == 2; }

/// One sighting of the station with what it measured.
struct NamedSight {
  std::string to;
  double direction = kNotGiven, zenith = kNotGiven, slope = kNotGiven, horizontal = kNotGiven;
};

std::vector<NamedSight> named_sights_of(const SurveyObservations& s, int set_up) {
  std::map<int, NamedSight> by_pointing;
  for (const Observation& o : s.observations) {
    if (o.set_up != set_up || o.pointing < 0) continue;
    NamedSight& sight = by_pointing[o.pointing];
    sight.to = o.to;
    if (o.kind == ObservationKind::direction)
      sight.direction = is_face_2(o) ? o.value - std::numbers::pi : o.value;
    else if (o.kind == ObservationKind::zenith_angle)
      sight.zenith = is_face_2(o) && o.value > std::numbers::pi ? 2 * std::numbers::pi - o.value : o.value;
    else if (o.kind == ObservationKind::slope_distance)
      sight.slope = o.value;
    else if (o.kind == ObservationKind::horizontal_distance)
      sight.horizontal = o.value;
  }
  std::vector<NamedSight> sights;
  for (auto& [pointing, sight] : by_pointing) sights.push_back(std::move(sight));
  return sights;
}

/// The first complete sighting of each target decides: means are not needed to tell millimetres from metres.
SeenFigure figure_of(const SurveyObservations& s, int set_up) {
  SeenFigure figure;
  for (const NamedSight& sight : named_sights_of(s, set_up)) {
    const double horizontal = std::isnan(sight.horizontal) ? sight.slope * std::sin(sight.zenith) : sight.horizontal;
    if (std::isnan(sight.direction) || std::isnan(horizontal)) continue;
    figure.try_emplace(sight.to, horizontal * std::sin(sight.direction), horizontal * std::cos(sight.direction));
  }
  for (const LocalCoordinate& c : s.local_coordinates)
    if (c.set_up == set_up) figure.try_emplace(c.point, c.position.head<2>());
  return figure;
}

struct Agreement {
  size_t shared = 0, within = 0;
  double apart = 0, apart_sigma = 0;  ///< how far the stations stand apart by what agrees [m]
};

/// Turning alone hides some of the way between two stations: targets that lie in one direction from there agree after a
/// small turn. Turn and shift over all that agree tell how far they are apart.
void add_distance_apart(const std::vector<std::pair<Vector2d, Vector2d>>& pairs, Agreement& agreement) {
  constexpr double kLeastSpread = 0.002;  // [m]
  const auto n = static_cast<double>(pairs.size());
  if (pairs.size() < 3) return;
  Vector2d from = Vector2d::Zero(), to = Vector2d::Zero();
  for (const auto& [p, q] : pairs) from += p / n, to += q / n;
  double along = 0, across = 0, extent = 0;
  for (const auto& [p, q] : pairs) {
    const Vector2d a = p - from, b = q - to;
    along += a.dot(b), across += a.x() * b.y() - a.y() * b.x(), extent += a.squaredNorm();
  }
  if (!(extent > 0)) return;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(std::atan2(across, along)).toRotationMatrix();
  double squares = 0;
  for (const auto& [p, q] : pairs) squares += (turn * (p - from) - (q - to)).squaredNorm();
  const double sigma = std::max(kLeastSpread, std::sqrt(squares / (2 * n - 3)));
  agreement.apart = (to - turn * from).norm();
  agreement.apart_sigma = sigma * std::sqrt(1 / n + from.squaredNorm() / extent);
}

/// The turn that the shared target decides which brings most others onto each other.
Agreement agreement(const SeenFigure& a, const SeenFigure& b) {
  std::vector<std::pair<Vector2d, Vector2d>> pairs;
  for (const auto& [id, p] : a)
    if (const auto at = b.find(id); at != b.end()) pairs.push_back({p, at->second});
  Agreement best{pairs.size(), 0, 0, 0};
  for (const auto& [from, to] : pairs) {
    const double turn = std::atan2(to.x(), to.y()) - std::atan2(from.x(), from.y());
    std::vector<std::pair<Vector2d, Vector2d>> within;
    for (const auto& [p, q] : pairs) {
      const Vector2d turned(std::cos(turn) * p.x() + std::sin(turn) * p.y(),
                            -std::sin(turn) * p.x() + std::cos(turn) * p.y());
      if ((turned - q).norm() < kSameFigure) within.emplace_back(p, q);
    }
    if (within.size() <= best.within) continue;
    best.within = within.size();
    add_distance_apart(within, best);
  }
  return best;
}

/// Those that agree after the turn and shift that two of them decide, for the two that most others agree with.
std::vector<std::pair<Vector2d, Vector2d>> one_figure(const std::vector<std::pair<Vector2d, Vector2d>>& pairs) {
  constexpr double kLeastApart = 1.0;  // [m]: two targets closer than that decide no turn
  std::vector<std::pair<Vector2d, Vector2d>> best;
  for (size_t i = 0; i < pairs.size(); ++i)
    for (size_t j = i + 1; j < pairs.size(); ++j) {
      const Vector2d from = pairs[j].first - pairs[i].first, to = pairs[j].second - pairs[i].second;
      if (from.norm() < kLeastApart || std::abs(from.norm() - to.norm()) > kSameFigure) continue;
      const Eigen::Matrix2d turn =
          Eigen::Rotation2Dd(std::atan2(to.y(), to.x()) - std::atan2(from.y(), from.x())).toRotationMatrix();
      std::vector<std::pair<Vector2d, Vector2d>> agree;
      for (const auto& [p, q] : pairs)
        if ((turn * (p - pairs[i].first) - (q - pairs[i].second)).norm() < kSameFigure) agree.emplace_back(p, q);
      if (agree.size() > best.size()) best = std::move(agree);
    }
  return best;
}

const Point* point_of(const SurveyObservations& s, const std::string& id) {
  for (const Point& p : s.points)
    if (p.id == id) return &p;
  return nullptr;
}

bool sights_it(const SurveyObservations& s, const std::string& id) {
  return std::any_of(s.observations.begin(), s.observations.end(), [&](const Observation& o) { return o.to == id; });
}

bool is_datum(const Point& p) { return p.roles[0] >= CoordinateRole::constrained; }

bool is_round(double value) { return std::abs(value - std::round(value)) < 5e-4; }

}  // namespace

StationEvidence compare_figures(const SurveyObservations& a, const SurveyObservations& b, const std::string& station) {
  Agreement best;
  for (size_t i = 0; i < a.set_ups.size(); ++i) {
    if (a.set_ups[i].station != station) continue;
    const SeenFigure seen = figure_of(a, static_cast<int>(i));
    for (size_t j = 0; j < b.set_ups.size(); ++j) {
      if (b.set_ups[j].station != station) continue;
      const Agreement found = agreement(seen, figure_of(b, static_cast<int>(j)));
      if (found.within > best.within || best.shared == 0) best = found;
    }
  }
  if (best.shared < 2) return {false, "they share fewer than two targets", false};
  const std::string targets = std::to_string(best.within) + " of " + std::to_string(best.shared) + " shared targets";
  if (best.apart > kCentring + 3 * best.apart_sigma)
    return {false, "what they see puts them " + std::to_string(std::lround(best.apart * 1e3)) + " mm apart", true};
  if (best.within >= 2 && 2 * best.within > best.shared) return {true, targets + " are seen at the same places", true};
  return {false, "the shared targets are seen at other places from there", true};
}

StationEvidence compare_marks(const SurveyObservations& a, const SurveyObservations& b, const std::string& station) {
  const Point* p = point_of(a, station);
  const Point* q = point_of(b, station);
  if (p && q && is_datum(*p) && is_datum(*q)) return {true, "it is a datum point in both"};
  if (sights_it(a, station) && sights_it(b, station)) return {true, "it is sighted as a target in both"};
  if (p && q) {
    const Eigen::Vector2d d = (p->coordinates - q->coordinates).head<2>();
    const bool round = is_round(p->coordinates[0]) && is_round(p->coordinates[1]);
    if (d.norm() < kSameCoordinates && !round) return {true, "it has the same coordinates in both"};
    if (d.norm() < kSameCoordinates) return {false, "its coordinates, round to the metre, look like an assumed origin"};
    if (d.norm() >= kSameCoordinates) return {false, "it has other coordinates"};
  }
  return {false, "they share fewer than two targets"};
}

Apart how_far_apart(const SurveyObservations& survey, int set_up, int other) {
  constexpr size_t kMost = 40;  // targets are enough
  const SeenFigure a = figure_of(survey, set_up), b = figure_of(survey, other);
  std::vector<std::pair<Vector2d, Vector2d>> pairs;
  for (const auto& [id, p] : a)
    if (const auto at = b.find(id); at != b.end() && pairs.size() < kMost) pairs.emplace_back(p, at->second);
  const auto agree = one_figure(pairs);
  if (agree.size() < 3 || 2 * agree.size() <= pairs.size()) return {};
  Agreement found;
  add_distance_apart(agree, found);
  return {found.apart, found.apart_sigma};
}

}  // namespace plumbline::survey

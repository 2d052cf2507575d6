#include "survey/doctor/control_causes.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>

#include "plumbline/stop.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector3d;
using Undo = std::function<Vector3d(const Vector3d&)>;

constexpr double kFoot = 0.3048;

Vector3d exchanged(const Vector3d& p) { return {p.y(), p.x(), p.z()}; }
Vector3d from_feet(const Vector3d& p) { return kFoot * p; }
Vector3d from_millimetres(const Vector3d& p) { return 1e-3 * p; }
Vector3d with_zone(const Vector3d& p, double zone) { return {p.x() + 1e6 * zone, p.y(), p.z()}; }

/// Points that somebody knew, E, N, H; NaN where one is not known.
std::map<std::string, Vector3d> known_points(const SurveyObservations& survey, const ControlPoints& control) {
  std::map<std::string, Vector3d> known;
  const auto at = [&](const std::string& id) -> Vector3d& {
    return known.try_emplace(id, Vector3d::Constant(kNotGiven)).first->second;
  };
  for (size_t i = 0; i < control.ids.size(); ++i)
    at(control.ids[i]) = control.coordinates.segment<3>(static_cast<Eigen::Index>(3 * i));
  if (!known.empty()) return known;
  for (const CoordinateGroup& g : survey.coordinates)
    for (size_t k = 0; k < g.components.size() && g.is_control; ++k)
      at(g.components[k].point)[g.components[k].axis] = g.values[static_cast<Eigen::Index>(k)];
  for (const Point& p : survey.points)
    for (size_t k = 0; k < 3; ++k)
      if (p.known[k] || p.roles[k] == CoordinateRole::fixed)
        at(p.id)[static_cast<Eigen::Index>(k)] = p.coordinates[static_cast<Eigen::Index>(k)];
  return known;
}

/// The coordinates of some points as they would be, wherever they stand.
void mend(const std::set<std::string>& points, const Undo& undo, SurveyObservations& survey, ControlPoints& control) {
  for (size_t i = 0; i < control.ids.size(); ++i)
    if (auto p = control.coordinates.segment<3>(static_cast<Eigen::Index>(3 * i)); points.contains(control.ids[i]))
      p = undo(Vector3d(p)).eval();
  for (Point& p : survey.points)
    if (points.contains(p.id)) p.coordinates = undo(p.coordinates);
  for (CoordinateGroup& g : survey.coordinates) {
    std::map<std::string, Vector3d> before;
    for (size_t k = 0; k < g.components.size(); ++k)
      before.try_emplace(g.components[k].point, Vector3d::Constant(kNotGiven)).first->second[g.components[k].axis] =
          g.values[static_cast<Eigen::Index>(k)];
    for (size_t k = 0; k < g.components.size() && g.is_control; ++k) {
      const auto& [point, axis] = g.components[k];
      const double value = undo(before.at(point))[axis];
      if (points.contains(point) && !std::isnan(value)) g.values[static_cast<Eigen::Index>(k)] = value;
    }
  }
}

class ControlCauses {
 public:
  ControlCauses(const SurveyObservations& survey, const ControlPoints& control, const SetUpChain& chain)
      : survey_(survey), control_(control), known_(known_points(survey, control)) {
    for (const auto& [id, at] : known_) {
      const auto place = at.head<2>().allFinite() ? chain.place_of(id) : std::nullopt;
      if (!place) continue;
      LocalSight& sight = seen_.emplace_back();
      sight.point = id;
      sight.ray = place->position;
    }
    for (const LocalSight& s : seen_) extent_ = std::max(extent_, (s.ray - seen_.front().ray).head<2>().norm());
    tolerance_ = tolerance(1);
  }

  std::vector<ControlCause> run() {
    if (seen_.size() < 3) return of_two_points();
    const auto as_it_is = fit_with([](const Vector3d& p) { return p; });
    if (as_it_is && as_it_is->agree == static_cast<int>(seen_.size())) return {};
    // Two of any figure agree with it, also of three.
    if (!as_it_is || as_it_is->agree <= std::max(2, static_cast<int>(seen_.size() / 2)))
      of_all(as_it_is ? as_it_is->agree : 0);
    if (found_.empty()) of_distances(as_it_is ? as_it_is->agree : 0);
    if (found_.empty() && as_it_is && as_it_is->agree >= 2) of_some(*as_it_is);
    if (found_.empty()) of_exchanged(as_it_is);
    return std::move(found_);
  }

 private:
  /// What is read as metres and is in another unit spans `scale` of what it seems to. A map's scale is in it [m].
  double tolerance(double scale) const { return 0.05 + 1e-3 * extent_ * scale; }

  std::optional<FigureFit> fit_with(const Undo& undo, double scale = 1) const {
    std::vector<FigurePair> pairs;
    for (const LocalSight& s : seen_) {
      pairs.push_back({&s, undo(known_.at(s.point)), tolerance(scale)});
      if (scale != 1) pairs.back().target.z() = kNotGiven;  // the earth's curve of 80 km is in what is 80 m away
    }
    return fit_robustly(pairs, scale);
  }

  /// Two say nothing but how far they are apart: that fits a unit, or wrong coordinates of one of them by chance.
  std::vector<ControlCause> of_two_points() {
    constexpr double kClose = 0.002;  // a map's scale, readings of a centimetre over 5 m
    if (seen_.size() != 2) return {};
    const double seen = (seen_[0].ray - seen_[1].ray).head<2>().norm(),
                 known = (known_.at(seen_[0].point) - known_.at(seen_[1].point)).head<2>().norm();
    for (const LengthUnit& unit : kLengthUnits)
      if (seen > 0 && std::abs(known / seen / unit.metres - 1) < kClose)
        add_distances(unit, "so " + seen_[0].point + " and " + seen_[1].point + " are " + fixed_digits(known, 2) +
                                " m apart as known, as they are, " + fixed_digits(seen, 2) +
                                " m (nothing else tests it: two points are known, and wrong coordinates of one of them "
                                "would look the same)");
    return std::move(found_);
  }

  /// Nothing but known points has a scale: with all distances in another unit the set-ups agree as well.
  void of_distances(int agree_now) {
    for (const LengthUnit& unit : kLengthUnits) {
      const auto fit = fit_with([](const Vector3d& p) { return p; }, unit.metres);
      if (!fit || fit->agree <= agree_now || 5 * fit->agree < 4 * static_cast<int>(seen_.size())) continue;
      add_distances(unit, "so " + std::to_string(fit->agree) + " of " + std::to_string(seen_.size()) +
                              " known points lie where the readings see them, as they are, " +
                              std::to_string(agree_now));
    }
  }

  void add_distances(const LengthUnit& unit, const std::string& tried) {
    ControlCause cause{"all distances are in " + std::string(unit.name) + " and were read as metres: " + tried,
                       {},
                       survey_,
                       control_,
                       true};
    for (Observation& o : cause.survey.observations)
      if (o.kind == ObservationKind::slope_distance || o.kind == ObservationKind::horizontal_distance)
        o.value *= unit.metres;
    found_.push_back(std::move(cause));
  }

  void add(const std::string& text, const std::set<std::string>& points, const Undo& undo) {
    ControlCause cause{text, {points.begin(), points.end()}, survey_, control_};
    mend(points, undo, cause.survey, cause.control);
    found_.push_back(std::move(cause));
  }

  void of_all(int agree_now) {
    std::set<std::string> all;
    for (const auto& [id, at] : known_) all.insert(id);
    const std::pair<const char*, Undo> mistakes[] = {
        {"E and N of the known points are exchanged, or one of them has the wrong sign", exchanged},
        {"the coordinates of the known points are in feet", from_feet},
        {"the coordinates of the known points are in millimetres", from_millimetres}};
    for (const auto& [what, undo] : mistakes) {
      const auto fit = fit_with(undo);
      if (!fit || fit->agree <= agree_now || 5 * fit->agree < 4 * static_cast<int>(seen_.size())) continue;
      add(std::string(what) + ": so " + std::to_string(fit->agree) + " of " + std::to_string(seen_.size()) +
              " lie where the readings see them, as they are, " + std::to_string(agree_now),
          all, undo);
    }
  }

  /// Points that do not lie where the readings and the other known points put them, and would after one mistake is
  /// undone.
  void of_some(const FigureFit& fit) {
    std::map<std::string, std::set<std::string>> points;  // by what is wrong
    std::map<std::string, Undo> undo;
    for (const LocalSight& s : seen_) {
      const Vector3d known = known_.at(s.point);
      if (agrees(fit, {&s, known, tolerance_})) continue;
      const auto would_fit = [&](const Undo& u) { return agrees(fit, {&s, u(known), tolerance_}); };
      const Vector3d off = known - fit(s);
      const double zone = std::round(off.x() / 1e6);
      const auto consider = [&](const std::string& what, const Undo& u) {
        if (!would_fit(u)) return false;
        points[what].insert(s.point);
        undo.try_emplace(what, u);
        return true;
      };
      if (consider("E and N are exchanged", exchanged) || consider("coordinates in feet", from_feet) ||
          consider("coordinates in millimetres", from_millimetres))
        continue;
      if (zone != 0 && consider(zone > 0 ? "the zone's number stands before E, and not with the others"
                                         : "the zone's number before E is missing, which the others have",
                                [zone](const Vector3d& p) { return with_zone(p, -zone); }))
        continue;
      const Vector3d front(kRound * std::round(off.x() / kRound), kRound * std::round(off.y() / kRound), 0);
      if (!front.isZero(0) && consider(in_front(front), [front](const Vector3d& p) { return Vector3d(p - front); }))
        continue;
      if (off.head<2>().norm() < tolerance_ && std::abs(off.z()) > kAnotherLevel) {
        const double step = std::round(off.z() * 10) / 10;  // those off by the same amount are named together
        const auto level = [step](const Vector3d& p) { return Vector3d(p.x(), p.y(), p.z() - step); };
        consider("heights " + fixed_digits(std::abs(step), 1) + " m " + (step > 0 ? "above" : "below") +
                     " what the others say: above the ellipsoid in place of the geoid, or of another level",
                 level);
      }
    }
    for (const auto& [what, ids] : points)
      add("of the known point" + std::string(ids.size() > 1 ? "s " : " ") + join({ids.begin(), ids.end()}, 6) + " " +
              what + " (the other " + std::to_string(fit.agree) + " agree with the readings)",
          ids, undo.at(what));
  }

  /// Two known points of which each has the other's coordinates: with them exchanged back all lie where the readings
  /// see them, and with no other two. Where most agree as they are, it can only be the two that do not.
  void of_exchanged(const std::optional<FigureFit>& as_it_is) {
    constexpr size_t kMost = 40;  // of which each is tried with each
    std::vector<const LocalSight*> tried;
    const bool most_agree = as_it_is && 2 * as_it_is->agree > static_cast<int>(seen_.size());
    for (const LocalSight& s : seen_)
      if (!most_agree || !agrees(*as_it_is, {&s, known_.at(s.point), tolerance_})) tried.push_back(&s);
    if (most_agree ? tried.size() != 2 : tried.size() > kMost) return;
    std::vector<std::pair<std::string, std::string>> pairs;
    for (size_t i = 0; i < tried.size(); ++i) {
      stop_point();
      for (size_t j = i + 1; j < tried.size(); ++j) {
        const auto fit = fit_with(each_others(tried[i]->point, tried[j]->point));
        if (fit && fit->agree == static_cast<int>(seen_.size())) pairs.emplace_back(tried[i]->point, tried[j]->point);
      }
    }
    if (pairs.size() != 1) return;
    const auto& [one, other] = pairs.front();
    add("the known points " + one + " and " + other + " have each other's coordinates: so all " +
            std::to_string(seen_.size()) + " lie where the readings see them, as they are, " +
            std::to_string(as_it_is ? as_it_is->agree : 0),
        {one, other}, each_others(one, other));
  }

  Undo each_others(const std::string& one, const std::string& other) const {
    // Anchors of one column have the same E and N in a design.
    const auto same = [](const Vector3d& p, const Vector3d& q) {
      return (p.array() == q.array() || (p.array().isNaN() && q.array().isNaN())).all();
    };
    return [a = known_.at(one), b = known_.at(other), same](const Vector3d& p) -> Vector3d {
      return same(p, a) ? b : same(p, b) ? a : p;
    };
  }

  /// Where the digits that all points have in front were left out, of some of them.
  static std::string in_front(const Vector3d& off) {
    const auto axis = [](const char* name, double by) {
      return by == 0 ? "" : std::string(by > 0 ? " +" : " -") + fixed_digits(std::abs(by), 0) + " m in " + name;
    };
    const std::string east = axis("E", off.x()), north = axis("N", off.y());
    return "the leading digits are not those of the others:" + east + (east.empty() || north.empty() ? "" : ",") +
           north;
  }

  static constexpr double kAnotherLevel = 1;  // [m]
  static constexpr double kRound = 1000;      // [m], of the digits in front
  const SurveyObservations& survey_;
  const ControlPoints& control_;
  const std::map<std::string, Vector3d> known_;
  std::vector<LocalSight> seen_;  ///< known points where the chain sees them
  double extent_ = 0;             ///< of the known points, as seen [m]
  double tolerance_ = 0;          ///< of that extent [m]
  std::vector<ControlCause> found_;
};

}  // namespace

std::vector<ControlCause> control_causes(const SurveyObservations& survey, const ControlPoints& control,
                                         const SetUpChain& chain) {
  return ControlCauses(survey, control, chain).run();
}

}  // namespace plumbline::survey

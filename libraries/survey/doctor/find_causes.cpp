#include "survey/doctor/find_causes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <set>

#include "plumbline/stop.hpp"
#include "survey/doctor/control_causes.hpp"
#include "survey/doctor/survey_sample.hpp"
#include "survey/model/observation_equations.hpp"
#include "survey/start/set_up_chain.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kMostFit = 0.85;  ///< share of sights that agree where a cause is undone
constexpr double kMisfits = 0.75;  ///< and that do at most as the file is

double circle(double angle) { return angle - 2 * kPi * std::floor(angle / (2 * kPi)); }

/// Degrees, minutes and seconds packed as D.MMSS, that were read as decimal degrees.
double unpacked(double angle) {
  const double packed = std::round(angle * 180 / kPi * 1e6) / 1e6, degrees = std::floor(packed + 1e-7),
               rest = 100 * (packed - degrees), minutes = std::floor(rest + 1e-5), seconds = 100 * (rest - minutes);
  return (degrees + minutes / 60 + seconds / 3600) * kPi / 180;
}

/// A mistake of angles, undone in one reading.
struct AngleMistake {
  const char *angles, *are;
  bool directions, zenith_angles;
  double (*undo)(double);
};

double from_zenith(double a) { return circle(kPi / 2 - a); }
double clockwise(double a) { return circle(-a); }
double gon_as_degrees(double a) { return a * 10 / 9; }
double degrees_as_gon(double a) { return a * 9 / 10; }

constexpr AngleMistake kAngleMistakes[] = {
    {"zenith angles", " are counted from the horizon", false, true, from_zenith},
    {"directions", " are counted counter-clockwise", true, false, clockwise},
    {"directions", " are in degrees and were read as gon", true, false, gon_as_degrees},
    {"zenith angles", " are in degrees and were read as gon", false, true, gon_as_degrees},
    {"directions and zenith angles", " are in degrees and were read as gon", true, true, gon_as_degrees},
    {"directions", " are in gon and were read as degrees", true, false, degrees_as_gon},
    {"zenith angles", " are in gon and were read as degrees", false, true, degrees_as_gon},
    {"directions and zenith angles", " are in gon and were read as degrees", true, true, degrees_as_gon},
    {"directions and zenith angles", " are degrees, minutes and seconds (D.MMSS) and were read as decimal degrees",
     true, true, unpacked},
};

/// In the readings of one set-up, -1: of all. Faces follow from the zenith angles again.
SurveyObservations without_mistake(SurveyObservations survey, const AngleMistake& mistake, int set_up) {
  std::set<int> second_face;  // pointings: their circle stands turned by 200 gon
  for (const Observation& o : survey.observations)
    if (mistake.undo == from_zenith && o.kind == ObservationKind::zenith_angle && o.pointing >= 0 &&
        from_zenith(o.value) > kPi)
      second_face.insert(o.pointing);
  for (Observation& o : survey.observations) {
    if (o.set_up < 0 || (set_up >= 0 && o.set_up != set_up)) continue;
    const bool direction = o.kind == ObservationKind::direction, zenith = o.kind == ObservationKind::zenith_angle;
    if ((direction && mistake.directions) || (zenith && mistake.zenith_angles)) o.value = mistake.undo(o.value);
    if (mistake.undo == from_zenith && zenith && o.value > kPi) o.value = 2 * kPi - o.value;
    if (mistake.undo == from_zenith && direction && second_face.contains(o.pointing)) o.value = circle(o.value - kPi);
    if (mistake.undo == from_zenith && (direction || zenith)) o.face = 0;
  }
  return survey;
}

/// How far the set-ups agree on where their common points lie.
struct Agreement {
  int compared = 0, agreeing = 0;
  std::vector<std::pair<int, int>> of_set_up;  ///< compared, agreeing
  double share() const { return compared > 0 ? static_cast<double>(agreeing) / compared : 1; }
};

SetUpChain chain_of(const SurveyObservations& survey, const AdjustOptions& options) {
  return SetUpChain(survey, mean_observations(survey).observations, options.profile);
}

Agreement agreement_of(const SurveyObservations& survey, const SetUpChain& chain) {
  Agreement all;
  all.of_set_up.resize(survey.set_ups.size());
  std::map<std::string, int> views;
  for (const SetUpFigure& f : chain.figures())
    for (const LocalSight& s : f.sights) ++views[s.point];
  for (size_t f = 0; f < chain.figures().size(); ++f) {
    const SetUpFigure& figure = chain.figures()[f];
    auto& [compared, agreeing] = all.of_set_up[figure.set_up];
    for (const LocalSight& s : figure.sights) compared += s.order >= 0 && views.at(s.point) > 1;
    if (chain.placed(f))
      for (const FigurePair& p : chain.pairs_of(f)) agreeing += p.sight->order >= 0 && agrees(chain.fit(f), p);
    all.compared += compared;
    all.agreeing += agreeing;
  }
  return all;
}

std::string percent(double share) { return fixed_digits(100 * share, 0) + " %"; }

class Causes {
 public:
  Causes(const SurveyObservations& survey, const AdjustOptions& options, const ControlPoints& control)
      : survey_(survey), options_(options), control_(control) {}

  std::vector<Cause> run() {
    const SetUpChain chain = chain_of(survey_, options_);
    if (chain.figures().empty()) return {};
    as_it_is_ = agreement_of(survey_, chain);
    if (as_it_is_.share() < kMisfits && as_it_is_.compared >= 4) of_angles(-1);
    if (found_.empty()) of_single_set_ups();
    std::vector<Cause> of_control;
    bool of_all_distances = false;
    if (found_.empty())
      for (ControlCause& c : control_causes(survey_, control_, chain)) {
        of_all_distances = of_all_distances || (of_control.empty() && c.of_all_distances);
        of_control.push_back({c.text, c.points, std::move(c.survey), std::move(c.control)});
      }
    // Noise in another unit of length looks like names on two marks.
    if (!of_all_distances) names_on_two_marks(chain);
    if (found_.empty()) found_ = std::move(of_control);
    return std::move(found_);
  }

 private:
  bool of_angles(int set_up) {
    // Each trial lays out all set-ups anew: of a large job those that hang together most closely are enough, and what
    // they say is tried on the whole by the caller.
    const SurveySample sample = sample_of(survey_, set_up, kMostReadings);
    const double as_it_is = sample.is_whole() ? share_of(as_it_is_, set_up) : share_with(sample.survey, sample.set_up);
    const AngleMistake* best = nullptr;
    double most = 0;
    for (const AngleMistake& mistake : kAngleMistakes) {
      stop_point();
      const double share = share_with(without_mistake(sample.survey, mistake, sample.set_up), sample.set_up);
      if (share >= kMostFit && share > most) most = share, best = &mistake;
    }
    if (!best) return false;
    const std::string owner = set_up < 0 ? "all " : "the ";
    const std::string of = set_up < 0 ? "" : " of set-up " + survey_.set_ups[set_up].id;
    found_.push_back(Cause{owner + best->angles + of + best->are + ": so " + percent(most) +
                               " of the sights to common points agree, as they are, " + percent(as_it_is) +
                               sample.in_words(),
                           {},
                           without_mistake(survey_, *best, set_up),
                           control_});
    return true;
  }

  static double share_of(const Agreement& a, int set_up) {
    if (set_up < 0) return a.share();
    const auto& [compared, agreeing] = a.of_set_up[set_up];
    return compared > 0 ? static_cast<double>(agreeing) / compared : 1;
  }
  double share_with(const SurveyObservations& mended, int set_up) const {
    try {
      return share_of(agreement_of(mended, chain_of(mended, options_)), set_up);
    } catch (const std::runtime_error&) {
      return 0;
    }
  }

  /// Those that fit least: a mistake of one set-up leaves the others in agreement.
  void of_single_set_ups() {
    constexpr int kMost = 3;
    std::vector<int> order;
    for (int s = 0; s < static_cast<int>(survey_.set_ups.size()); ++s)
      if (as_it_is_.of_set_up[s].first >= 3 && share_of(as_it_is_, s) < kMisfits) order.push_back(s);
    std::stable_sort(order.begin(), order.end(),
                     [&](int a, int b) { return share_of(as_it_is_, a) < share_of(as_it_is_, b); });
    for (int k = 0; k < std::min(kMost, static_cast<int>(order.size())); ++k) of_angles(order[k]);
  }

  /// A point that some set-ups see at one place and the others at another, both more than once.
  struct TwoMarks {
    std::string point;
    std::vector<int> first, second;  ///< set-ups
    double apart = 0;                ///< [m]
  };

  void names_on_two_marks(const SetUpChain& chain) {
    // One mended alone leaves the others wrong, and each is an adjustment of the whole.
    constexpr size_t kSingly = 3;
    const std::vector<TwoMarks> marks = two_marks(chain);
    if (marks.size() > kSingly) return add_together(marks);
    for (const TwoMarks& m : marks)
      add_marks({m}, m.point + " is the name of two marks " + fixed_digits(m.apart, 2) +
                         " m apart: " + names({m.first.begin(), m.first.end()}) + " see the one, " +
                         names({m.second.begin(), m.second.end()}) + " the other");
  }

  std::vector<TwoMarks> two_marks(const SetUpChain& chain) const {
    std::map<std::string, std::vector<std::pair<int, Eigen::Vector3d>>> places;  // set-up, place
    for (size_t f = 0; f < chain.figures().size(); ++f)
      for (const LocalSight& s : chain.figures()[f].sights)
        if (s.order >= 0 && chain.placed(f)) places[s.point].emplace_back(chain.figures()[f].set_up, chain.fit(f)(s));
    std::vector<TwoMarks> found;
    for (const auto& [point, seen] : places) {
      stop_point();
      if (seen.size() < 4) continue;
      TwoMarks marks{point, {}, {}, 0};
      std::optional<Eigen::Vector3d> other;
      for (const auto& [set_up, at] : seen) {
        const auto near = [&](const Eigen::Vector3d& b) { return (at - b).head<2>().norm() < kSamePlace; };
        if (near(seen.front().second))
          marks.first.push_back(set_up);
        else if (!other || near(*other))
          other = other.value_or(at), marks.second.push_back(set_up);
      }
      if (marks.first.size() < 2 || marks.second.size() < 2 || marks.first.size() + marks.second.size() != seen.size())
        continue;
      marks.apart = (seen.front().second - *other).head<2>().norm();
      found.push_back(std::move(marks));
    }
    return found;
  }

  /// So many are no names taken twice: the job is of two campaigns, or marks were moved during it.
  void add_together(const std::vector<TwoMarks>& marks) {
    std::set<int> first, second;
    std::vector<std::string> points;
    double least = marks.front().apart, most = least;
    for (const TwoMarks& m : marks) {
      first.insert(m.first.begin(), m.first.end()), second.insert(m.second.begin(), m.second.end());
      points.push_back(m.point);
      least = std::min(least, m.apart), most = std::max(most, m.apart);
    }
    const bool apart = std::none_of(first.begin(), first.end(), [&](int s) { return second.contains(s); });
    add_marks(marks, std::to_string(points.size()) + " points (" + join(points, 6) + ") are each seen at two places, " +
                         fixed_digits(least, 2) + " to " + fixed_digits(most, 2) + " m apart" +
                         (apart ? ": " + names(first) + " see the one, " + names(second) +
                                      " the other. Two campaigns in one job, or marks that were moved in between"
                                : ""));
  }

  void add_marks(const std::vector<TwoMarks>& marks, std::string text) {
    Cause cause{std::move(text), {}, survey_, control_};
    std::map<std::string, std::set<int>> moved;
    for (const TwoMarks& m : marks) {
      cause.points.push_back(m.point);
      moved[m.point].insert(m.second.begin(), m.second.end());
    }
    for (Observation& o : cause.mended.observations)
      if (const auto at = moved.find(o.to); at != moved.end() && at->second.contains(o.set_up)) o.to += " (2)";
    found_.push_back(std::move(cause));
  }

  std::string names(const std::set<int>& set_ups) const {
    std::vector<std::string> ids;
    for (const int s : set_ups) ids.push_back(survey_.set_ups[s].id);
    return join(ids, 4);
  }

  static constexpr double kSamePlace = 0.05;  // [m]
  static constexpr size_t kMostReadings = 4000;
  const SurveyObservations& survey_;
  const AdjustOptions& options_;
  const ControlPoints& control_;
  Agreement as_it_is_;
  std::vector<Cause> found_;
};

}  // namespace

std::vector<Cause> find_causes(const SurveyObservations& survey, const AdjustOptions& options,
                               const ControlPoints& control) {
  try {
    return Causes(survey, options, control).run();
  } catch (const std::runtime_error&) {
    return {};  // what cannot even be laid out has no such cause
  }
}

}  // namespace plumbline::survey

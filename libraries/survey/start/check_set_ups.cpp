#include "survey/start/check_set_ups.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "plumbline/stop.hpp"
#include "survey/model/observation_equations.hpp"
#include "survey/model/observation_words.hpp"
#include "survey/words/network_words.hpp"

namespace plumbline::survey {

namespace {

using Eigen::Vector3d;
using Kind = SetUpProblem::Kind;

std::string in_gon(double angle) { return fixed_digits(angle * 200 / std::numbers::pi, 4) + " gon"; }

/// A sight that does not lie where the others see its point.
struct Stray {
  const LocalSight* sight = nullptr;
  Vector3d seen, expected;  ///< as this set-up puts it, as the others do
  double tolerance = 0;
  bool certain = false;  ///< two others at least agree on where the point is
};

class SetUpCheck {
 public:
  SetUpCheck(const SurveyObservations& survey, const std::vector<MeanObservation>& observations,
             const SetUpChain& chain)
      : survey_(survey), observations_(observations), chain_(chain) {}

  std::vector<SetUpProblem> run() {
    for (size_t f = 0; f < chain_.figures().size(); ++f) {
      stop_point();
      if (chain_.placed(f)) check(f);
    }
    drop_doubtful();
    return std::move(problems_);
  }

 private:
  const std::string& name() const { return survey_.set_ups[set_up_].id; }

  void check(size_t figure) {
    figure_ = figure;
    set_up_ = chain_.figures()[figure].set_up;
    fit_ = chain_.fit(figure);
    const std::vector<FigurePair> pairs = chain_.pairs_of(figure);
    const auto outside = std::count_if(pairs.begin(), pairs.end(), [&](const auto& p) { return !agrees(fit_, p); });
    if (outside >= 3) fit_ = with_constant(pairs, fit_);
    strays_.clear();
    inside_.clear();
    station_ = fit_.shift;  // the mark's local place is the origin
    for (const FigurePair& pair : pairs) {
      if (pair.sight->order < 0) continue;  // the station's mark: instrument heights are for the adjustment
      if (agrees(fit_, pair)) {
        inside_.push_back(pair.sight->order);
        continue;
      }
      const auto place = chain_.place_of(pair.sight->point, static_cast<int>(figure));
      strays_.push_back({pair.sight, fit_(*pair.sight), pair.target, pair.tolerance, place->agree >= 2});
    }
    std::sort(inside_.begin(), inside_.end());
    std::sort(strays_.begin(), strays_.end(),
              [](const Stray& a, const Stray& b) { return a.sight->order < b.sight->order; });
    check_unit();
    check_names();
    check_circle();
    check_place();
    check_readings();
  }

  SetUpProblem& add(Kind kind, const std::vector<const Stray*>& strays) {
    SetUpProblem& p = problems_.emplace_back();
    p.kind = kind;
    p.set_up = set_up_;
    for (const Stray* s : strays) {
      p.points.push_back(s->sight->point);
      p.orders.push_back(s->sight->order);
      p.observations.insert(p.observations.end(), s->sight->observations.begin(), s->sight->observations.end());
    }
    return p;
  }

  void settle(const std::vector<const Stray*>& settled) {
    std::set<const LocalSight*> done;
    for (const Stray* s : settled) done.insert(s->sight);
    std::erase_if(strays_, [&](const Stray& s) { return done.contains(s.sight); });
  }

  void check_unit() {
    if (fit_.scale == 1) return;
    int others = 0;
    for (size_t f = 0; f < chain_.figures().size(); ++f)
      others += f != figure_ && chain_.placed(f) && chain_.fit(f).scale == 1;
    SetUpProblem& p = add(Kind::unit, {});
    p.size = fit_.scale;
    p.certain = others >= 2;
    const char* unit = "another unit";
    bool inverse = false;
    for (const LengthUnit& u : kLengthUnits)
      if (u.metres == fit_.scale || 1 / u.metres == fit_.scale) unit = u.name, inverse = u.metres != fit_.scale;
    p.text =
        "the distances of set-up " + name() + " are " + fixed_digits(1 / fit_.scale, 4) +
        " times what the other set-ups give: " +
        (inverse ? std::string("they are in metres and the others in ") + unit : std::string("they are in ") + unit);
    if (!p.certain) p.text += ", or it is the other set-up that is wrong";
  }

  /// The point that a stray lies at; empty if none, or if it cannot be told from its neighbours. `sure`: two others at
  /// least see it there.
  std::string who_is_at(const Stray& stray, bool& sure) const {
    std::string nearest;
    double least = 1e300, second = 1e300, tolerance = 0;
    int agree = 0;
    for (const std::string& id : chain_.points()) {
      if (id == stray.sight->point) continue;
      const auto place = chain_.place_of(id, static_cast<int>(figure_));
      if (!place) continue;
      Vector3d d = place->position - stray.seen;
      if (std::isnan(d.z())) d.z() = 0;
      if (d.norm() >= least) {
        second = std::min(second, d.norm());
        continue;
      }
      second = least, least = d.norm();
      nearest = id, tolerance = place->sigma, agree = place->agree;
    }
    sure = agree >= 2;
    // As much as two gross checks allow, and clearly nearer than any other.
    const double allowed = stray.tolerance + 6 * tolerance;
    return least <= allowed && second > 3 * allowed ? nearest : "";
  }

  void check_names() {
    std::map<std::string, const Stray*> by_name;
    std::map<std::string, std::string> lies_at;
    std::map<std::string, bool> sure;  // that the point is misnamed here: others see the two points apart
    for (const Stray& s : strays_) {
      by_name[s.sight->point] = &s;
      bool there = false;
      const std::string at = who_is_at(s, there);
      if (at.empty()) continue;
      lies_at[s.sight->point] = at;
      sure[s.sight->point] = there || s.certain;
    }
    std::vector<const Stray*> settled;
    for (const auto& [id, at] : lies_at) {
      const Stray* stray = by_name.at(id);
      if (std::find(settled.begin(), settled.end(), stray) != settled.end()) continue;
      const auto back = lies_at.find(at);
      if (back != lies_at.end() && back->second == id) {
        const Stray* other = by_name.at(at);
        SetUpProblem& p = add(Kind::swapped_names, {stray, other});
        p.certain = sure[id] || sure[at];
        p.text = "set-up " + name() + ": " + id + " and " + at +
                 " have each other's name (each lies where the other set-up" + (p.certain ? "s see" : " sees") +
                 " the other one)" + (p.certain ? "" : "; it may be the other set-up that swapped them");
        settled.insert(settled.end(), {stray, other});
      } else {
        SetUpProblem& p = add(Kind::wrong_name, {stray});
        p.certain = sure[id];
        p.points.push_back(at);
        p.text = "set-up " + name() + ": what is noted as " + id + " is " + at + " (" +
                 fixed_digits((stray->seen - stray->expected).norm(), 3) + " m from where " + id + " is)" +
                 (p.certain ? "" : ", or the other set-up has the wrong name");
        settled.push_back(stray);
      }
    }
    settle(settled);
  }

  /// What a turn about the station would bring where it belongs, and by which angle.
  std::optional<double> turn_of(const Stray& s) const {
    const Vector3d a = s.seen - station_, b = s.expected - station_;
    if (std::abs(a.head<2>().norm() - b.head<2>().norm()) > s.tolerance) return std::nullopt;
    if (std::abs(a.z() - b.z()) > s.tolerance) return std::nullopt;
    return wrap_angle(std::atan2(b.x(), b.y()) - std::atan2(a.x(), a.y()));
  }

  void check_circle() {
    std::vector<const Stray*> most;
    double turn = 0;
    for (const Stray& centre : strays_) {
      const auto angle = turn_of(centre);
      if (!angle) continue;
      std::vector<const Stray*> same;
      double sum = 0;
      for (const Stray& s : strays_) {
        const auto own = turn_of(s);
        const double reach = (s.seen - station_).head<2>().norm();
        if (!own || reach * std::abs(wrap_angle(*own - *angle)) > s.tolerance) continue;
        same.push_back(&s);
        sum += wrap_angle(*own - *angle);
      }
      if (same.size() <= most.size()) continue;
      most = same;
      turn = *angle + sum / static_cast<double>(same.size());
    }
    // A circle is turned at a time; what does not follow each other is left to the adjustment.
    std::vector<int> orders;
    for (const Stray* s : most) orders.push_back(s->sight->order);
    if (most.size() < 3 || !without_others(orders)) return;
    // An instrument that moved also turns some sights alike: the simpler mistake must explain as much.
    std::vector<FigurePair> pairs;
    for (const Stray& s : strays_) pairs.push_back({s.sight, s.expected, s.tolerance});
    const auto moved = fit_robustly(pairs, fit_.scale);
    if (moved && moved->agree > static_cast<int>(most.size()) + 1) return;
    SetUpProblem& p = add(Kind::turned_circle, most);
    p.size = turn;
    p.text = "set-up " + name() + ": the circle was turned by " + in_gon(-turn) + " " + when(p.orders);
    finish_group(most, p);
  }

  /// Up or down alone, and all with other target heights noted than the sights that agree: no instrument moves like
  /// that at such a time. Which height is wrong the adjustment tells, up to what it takes for one.
  bool is_of_a_pole(const std::vector<const Stray*>& group, const Vector3d& moved) const {
    constexpr double kInPlan = 0.2, kLargest = 5;  // of the height; [m], a pole of 2 m in feet
    if (moved.head<2>().norm() > kInPlan * std::abs(moved.z()) || std::abs(moved.z()) > kLargest) return false;
    const auto height = [&](int order) { return or_zero(survey_.observations[order].target_height); };
    std::set<double> noted;
    for (const int order : inside_) noted.insert(height(order));
    return !noted.empty() && std::none_of(group.begin(), group.end(),
                                          [&](const Stray* s) { return noted.contains(height(s->sight->order)); });
  }

  /// Strays that fit each other, but elsewhere.
  void check_place() {
    std::vector<FigurePair> pairs;
    for (const Stray& s : strays_) pairs.push_back({s.sight, s.expected, s.tolerance});
    const auto fit = pairs.size() >= 3 ? fit_robustly(pairs, fit_.scale) : std::nullopt;
    if (!fit || fit->agree < 3) return;
    std::vector<const Stray*> group;
    std::vector<int> orders;
    for (size_t i = 0; i < pairs.size(); ++i)
      if (agrees(*fit, pairs[i])) group.push_back(&strays_[i]), orders.push_back(pairs[i].sight->order);
    // An instrument moves at a time and never moves back; and two set-ups that contradict each other do not say which.
    const auto certain = std::count_if(group.begin(), group.end(), [](const Stray* s) { return s->certain; });
    if (!without_others(orders) || certain < 3) return;
    const Vector3d moved = fit->shift - fit_.shift;
    if (is_of_a_pole(group, moved)) return settle(group);
    SetUpProblem& p = add(Kind::moved_instrument, group);
    p.text = "set-up " + name() + ": the instrument stood elsewhere " + when(p.orders) + " (" +
             fixed_digits(1000 * moved.head<2>().norm(), 0) + " mm in plan, " + fixed_digits(1000 * moved.z(), 0) +
             " mm in height" +
             (moved.head<2>().norm() < 0.01 * std::abs(moved.z()) ? "; or heights of targets are noted wrongly)" : ")");
    finish_group(group, p);
    // Which of the two parts stood on the mark, where others see it?
    const std::string& station = survey_.set_ups[set_up_].station;
    const auto mark = chain_.place_of(station, static_cast<int>(figure_));
    if (!mark || (fit->shift - mark->position).head<2>().norm() > (fit_.shift - mark->position).head<2>().norm())
      return;
    std::vector<int> rest;
    for (const LocalSight& s : chain_.figures()[figure_].sights)
      if (s.order >= 0 && std::find(p.orders.begin(), p.orders.end(), s.order) == p.orders.end())
        rest.push_back(s.order);
    p.orders = rest;
  }

  /// A group of sights with a fault of its own; points that only this set-up has seen between them go with it.
  void finish_group(const std::vector<const Stray*>& group, SetUpProblem& p) {
    if (without_others(p.orders)) {
      const int first = p.orders.front(), last = tail_of(p.orders) ? 1 << 30 : p.orders.back();
      for (const LocalSight& s : chain_.figures()[figure_].sights)
        if (s.order >= first && s.order <= last &&
            std::find(p.orders.begin(), p.orders.end(), s.order) == p.orders.end())
          p.orders.push_back(s.order);
    }
    settle(group);
  }

  bool without_others(const std::vector<int>& orders) const {
    const auto [first, last] = std::minmax_element(orders.begin(), orders.end());
    return std::none_of(inside_.begin(), inside_.end(), [&](int o) { return o > *first && o < *last; });
  }
  bool tail_of(const std::vector<int>& orders) const {
    return inside_.empty() || inside_.back() < *std::min_element(orders.begin(), orders.end());
  }
  std::string when(const std::vector<int>& orders) const {
    std::vector<std::string> ids;
    for (const LocalSight& s : chain_.figures()[figure_].sights)
      if (std::find(orders.begin(), orders.end(), s.order) != orders.end()) ids.push_back(s.point);
    const Observation& first = survey_.observations[*std::min_element(orders.begin(), orders.end())];
    const std::string at = place(first.source);
    if (without_others(orders) && tail_of(orders))
      return "before " + first.to + " was sighted" + (at.empty() ? "" : " (" + at + ")");
    return "for " + join(ids, 6);
  }

  /// Which of direction, zenith angle and distance is off.
  void check_readings() {
    for (const Stray& s : strays_) {
      if (!s.certain) continue;
      const Vector3d axis = station_ + Vector3d(0, 0, s.sight->heights), seen = s.seen - axis,
                     expected = s.expected - axis;
      const double h = seen.head<2>().norm(), reach = expected.norm();
      const double across = expected.head<2>().norm() *
                            wrap_angle(std::atan2(seen.x(), seen.y()) - std::atan2(expected.x(), expected.y()));
      const double up =
          reach * wrap_angle(std::atan2(h, seen.z()) - std::atan2(expected.head<2>().norm(), expected.z()));
      const double along = seen.norm() - reach;
      SetUpProblem p;
      p.set_up = set_up_;
      p.points = {s.sight->point};
      double largest = 0;
      for (int i : s.sight->observations) {
        const ObservationKind kind = observations_[i].observation.kind;
        const double off = kind == ObservationKind::direction      ? across
                           : kind == ObservationKind::zenith_angle ? up
                                                                   : along;
        if (!(std::abs(off) > s.tolerance)) continue;
        p.observations.push_back(i);
        if (std::abs(off) < largest) continue;
        largest = std::abs(off);
        p.text = "set-up " + name() + ": " + kind_words(kind) + " to " + s.sight->point + at(i) + " is off by " +
                 amount(kind, off, reach) + "; the other set-ups agree on where " + s.sight->point + " is";
      }
      if (!p.observations.empty()) problems_.push_back(std::move(p));
    }
  }

  static std::string kind_words(ObservationKind kind) {
    std::string words = kind_name(kind);
    std::replace(words.begin(), words.end(), '_', ' ');
    return words;
  }
  static std::string amount(ObservationKind kind, double off, double reach) {
    if (kind == ObservationKind::direction || kind == ObservationKind::zenith_angle) return in_gon(off / reach);
    return fixed_digits(off, 3) + " m";
  }
  std::string at(int observation) const {
    const std::string text = place(observations_[observation].observation.source);
    return text.empty() ? "" : " (" + text + ")";
  }

  /// Two set-ups that contradict each other are both told of the same mistake: once is enough, and neither is sure.
  void drop_doubtful() {
    std::set<std::vector<std::string>> named;
    std::vector<SetUpProblem> kept;
    for (const bool certain : {true, false})
      for (const SetUpProblem& p : problems_) {
        if (p.certain != certain) continue;
        std::vector<std::string> points = p.points;
        std::sort(points.begin(), points.end());
        const bool first = p.points.empty() || named.insert(points).second;
        if (certain || first) kept.push_back(p);
      }
    problems_ = std::move(kept);
  }

  const SurveyObservations& survey_;
  const std::vector<MeanObservation>& observations_;
  const SetUpChain& chain_;
  size_t figure_ = 0;
  int set_up_ = 0;
  FigureFit fit_;
  Vector3d station_ = Vector3d::Zero();
  std::vector<Stray> strays_;
  std::vector<int> inside_;  ///< orders of sights that agree
  std::vector<SetUpProblem> problems_;
};

}  // namespace

std::vector<SetUpProblem> check_set_ups(const SurveyObservations& survey,
                                        const std::vector<MeanObservation>& observations, const SetUpChain& chain) {
  return SetUpCheck(survey, observations, chain).run();
}

}  // namespace plumbline::survey

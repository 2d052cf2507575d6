// Step, width and shift of one joint against a limit, at all of its places.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "building/judgement/surface_verdict.hpp"
#include "building/judgement/tolerance.hpp"

namespace plumbline::judgement {
namespace {

/// Errors of edges of a scan, which are exponential, lie for one place in 200 to 800 1.5 to 1.7 times as far out as
/// normal ones.
constexpr double kTailOfEdges = 1.7;

class JointVerdict {
 public:
  JointVerdict(const SurfacesT& surfaces, double risk) : surfaces_(surfaces), risk_(risk) {}

  void judge(const JointFiguresT& joint, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    if (!joint.not_measured.empty()) {
      verdict.not_judged = joint.not_measured;
      return;
    }
    const std::vector<PlaceValue> places = values_along(joint, limit.quantity);
    verdict.places = static_cast<int>(places.size());
    if (places.empty()) {
      verdict.not_judged = limit.quantity == SurfaceQuantity::step ? "one of its panels was not measured"
                           : limit.quantity == SurfaceQuantity::shift
                               ? "nobody said how well the place of the points as a whole "
                                 "is known"
                               : "no place along it was measured";
      return;
    }
    double least = std::numeric_limits<double>::infinity(), at_worst = 1;
    for (const PlaceValue& place : places) {
      at_worst = std::min(at_worst, limit_probability(place.value, place.sigma_of_tail, limit));
      // The way to the nearer limit, as probabilities of many places are all 0, or 1.
      const double way = std::min(limit.upper - place.value, place.value - limit.lower) / std::max(place.sigma, 1e-9);
      if (way >= least) continue;
      least = way, verdict.value = place.value, verdict.sigma = place.sigma, verdict.along = place.along;
    }
    verdict.probability = kept_everywhere(places, limit);
    decide(verdict, verdict.probability, at_worst, risk_ / verdict.places, risk_);
    // An error that the places share is no chance of each.
    if (verdict.verdict == ToleranceVerdict::undecided && limit.quantity == SurfaceQuantity::shift &&
        is_beyond(places, limit))
      verdict.verdict = ToleranceVerdict::fail;
    if (verdict.verdict == ToleranceVerdict::pass) name_extreme(places, limit.quantity, verdict);
    if (verdict.verdict == ToleranceVerdict::pass) doubt(joint, limit, verdict);
  }

 private:
  /// A quantity at a place of a joint.
  struct PlaceValue {
    double along, value, sigma;
    double random, common;  ///< of sigma: the place's own, and that of a single error that all places share
    double sigma_of_tail;   ///< by which a value beyond its limit is told
  };

  std::vector<PlaceValue> values_along(const JointFiguresT& joint, SurfaceQuantity quantity) const {
    std::vector<PlaceValue> values;
    for (const auto& place : joint.places) {
      PlaceValue at{place->along, place->width, place->width_sigma, place->width_sigma, 0, place->width_sigma};
      if (quantity == SurfaceQuantity::step) {
        at.value = place->step, at.sigma = at.random = at.sigma_of_tail = place->step_sigma;
      } else if (quantity == SurfaceQuantity::shift) {
        at.value = place->shift, at.sigma = at.sigma_of_tail = place->shift_sigma;
        take_parts_of_shift(*place, at);
      } else {
        if (quantity == SurfaceQuantity::joint) at.value -= joint.nominal_width;
        take_parts_of_width(*place, at);
      }
      if (std::isfinite(at.value) && std::isfinite(at.sigma)) values.push_back(at);
    }
    return values;
  }

  /// Of a scan: its beam is one error of all places, and the way from the last point to an edge has an exponential's
  /// tail, of both edges together that of a gamma distribution (kTailOfEdges).
  void take_parts_of_width(const JointPlaceT& place, PlaceValue& at) const {
    if (place.views > 0 || !(place.width_random > 0)) return;
    const double common = std::sqrt(std::max(0.0, at.sigma * at.sigma - place.width_random * place.width_random));
    at.sigma_of_tail = std::hypot(common, kTailOfEdges * place.width_random);
    if (surfaces_.joint_rank == 1 && place.width_factor.size() == 1)
      at.random = place.width_random, at.common = place.width_factor[0];
  }

  /// How far the measurement as a whole lies beside its place moves all places of a joint alike, and is one error;
  /// those of the edges differ from place to place.
  static void take_parts_of_shift(const JointPlaceT& place, PlaceValue& at) {
    at.random = at.sigma;
    double variance = place.width_random * place.width_random;
    for (const double of_edge : place.width_by_edge) variance += of_edge * of_edge;
    if (!std::isfinite(variance) || !std::isfinite(at.sigma)) return;
    at.random = std::min(at.sigma, 0.5 * std::sqrt(variance));
    at.common = std::sqrt(at.sigma * at.sigma - at.random * at.random);
    at.sigma_of_tail = std::hypot(at.common, (place.views > 0 ? 1 : kTailOfEdges) * at.random);
  }

  /// Whether a place lies further beyond the limit than errors carry any of the joint's places, but for the risk: the
  /// common one once, their own each. One place's error is asked for, so of two limits one is.
  bool is_beyond(std::vector<PlaceValue> places, SurfaceLimit limit) const {
    double furthest = 0;
    for (const PlaceValue& at : places) furthest = std::max({furthest, at.value - limit.upper, limit.lower - at.value});
    if (furthest <= 0) return false;
    limit.upper = furthest, limit.lower = -std::numeric_limits<double>::infinity();
    for (PlaceValue& at : places) {
      at.value = 0;
      at.random = std::sqrt(std::max(0.0, at.sigma_of_tail * at.sigma_of_tail - at.common * at.common));
    }
    return kept_everywhere(places, limit) >= 1 - risk_;
  }

  /// That all places keep the limit: misses added up (Boole), under each value of the error that they share.
  static double kept_everywhere(const std::vector<PlaceValue>& places, const SurfaceLimit& limit) {
    constexpr double furthest = 4, step = 0.1;  // [sigma]
    const bool shared = std::any_of(places.begin(), places.end(), [](const PlaceValue& at) { return at.common != 0; });
    double kept = 0, weights = 0;
    for (double z = shared ? -furthest : 0; z <= (shared ? furthest : 0); z += step) {
      double missed = 0;
      for (const PlaceValue& at : places) missed += 1 - limit_probability(at.value - z * at.common, at.random, limit);
      const double weight = std::exp(-0.5 * z * z);
      kept += weight * std::max(0.0, 1 - missed), weights += weight;
    }
    return kept / weights;
  }

  /// Where all places keep the limit, the narrowest (widest) place is the narrowest one, and not the one known least
  /// surely.
  static void name_extreme(const std::vector<PlaceValue>& places, SurfaceQuantity quantity, SurfaceVerdictT& verdict) {
    if (quantity != SurfaceQuantity::narrowest && quantity != SurfaceQuantity::widest) return;
    const auto less = [](const PlaceValue& a, const PlaceValue& b) { return a.value < b.value; };
    const auto at = quantity == SurfaceQuantity::narrowest ? std::min_element(places.begin(), places.end(), less)
                                                           : std::max_element(places.begin(), places.end(), less);
    verdict.value = at->value, verdict.sigma = at->sigma, verdict.along = at->along;
  }

  /// What passes where it was measured, and is not known where it was not.
  static void doubt(const JointFiguresT& joint, const SurfaceLimit& limit, SurfaceVerdictT& verdict) {
    // Steps are those of the panels' surfaces, of which as much was seen already.
    constexpr double of_steps = 0.3;
    const bool of_width = limit.quantity != SurfaceQuantity::step && limit.quantity != SurfaceQuantity::shift;
    const double needed = limit.quantity == SurfaceQuantity::step ? of_steps : kSeenEnough;
    if (of_width && joint.closed > 0)
      verdict.not_judged = "it keeps the limit where it was measured, and at " + std::to_string(joint.closed) + " of " +
                           std::to_string(joint.looked_at) +
                           " places along it no gap is to be seen between its panels: filled flush there, closed, or "
                           "hidden by what stands before it";
    else if (verdict.places < needed * joint.looked_at)
      verdict.not_judged = fmt::format(
          "it was measured at {} of {} places along it, where it keeps the limit; to pass it needs {:.0f} %",
          verdict.places, joint.looked_at, 100 * needed);
    if (!verdict.not_judged.empty()) verdict.verdict = ToleranceVerdict::not_measured;
  }

  const SurfacesT& surfaces_;
  double risk_;
};

}  // namespace

void judge_joint(const SurfacesT& surfaces, const JointFiguresT& joint, const SurfaceLimit& limit, double risk,
                 SurfaceVerdictT& verdict) {
  JointVerdict(surfaces, risk).judge(joint, limit, verdict);
}

}  // namespace plumbline::judgement

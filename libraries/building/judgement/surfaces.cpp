#include "building/judgement/surfaces.hpp"

#include <fmt/core.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <stdexcept>

#include "building/judgement/conformance.hpp"
#include "building/judgement/tolerance.hpp"
#include "geometry/packed_symmetric.hpp"

namespace plumbline::judgement {
namespace {

/// Share of a panel that has to have points before it passes, and of a joint that has to show its edges. What is beyond
/// its limit is so wherever it is.
constexpr double kSeenEnough = 0.75;

/// Errors of edges of a scan, which are exponential, lie for one place in 200 to 800 1.5 to 1.7 times as far out as
/// normal ones.
constexpr double kTailOfEdges = 1.7;

constexpr double kInf = std::numeric_limits<double>::infinity();

/// What became of one limit of a rule.
struct Followed {
  int selected = 0, taken = 0;    ///< panels or joints it selects; verdicts by it, others have those of later rules
  std::vector<std::string> open;  ///< which of these are not judged
  std::string why;                ///< the first of them
};

/// A limit with the rule that sets it.
struct Asked {
  SurfaceLimit limit;
  const SurfaceRule* rule;
  Followed* followed;  ///< what becomes of it
};

/// Limits as a middle and how far a value may lie from it.
struct Shifted {
  double centre, half;
};
Shifted shifted(const SurfaceLimit& limit) {
  constexpr double far = 1e3;  // stands for no limit [m]
  const double upper = std::min(limit.upper, far), lower = std::max(limit.lower, -far);
  return {0.5 * (upper + lower), 0.5 * (upper - lower)};
}

double probability_of(double value, double sigma, const SurfaceLimit& limit) {
  const Shifted at = shifted(limit);
  return judgement::conformance_probability(value - at.centre, sigma, at.half);
}

class Judge {
 public:
  Judge(const SurfacesT& surfaces, const std::map<std::string, ifc::ElementFacts>& facts,
        const std::vector<SurfaceRule>& rules, double risk, double within)
      : surfaces_(surfaces),
        facts_(facts),
        rules_(rules),
        risk_(risk),
        selected_(rules.size()),
        doubts_(doubts_of_panels(surfaces, within)) {}

  SurfaceJudgementT all() {
    result_.risk = risk_;
    for (const SurfaceRule& rule : rules_) asked_.emplace_back(rule.limits.size());
    std::vector<std::vector<char>> selecting_panel;  // which rules select it
    for (size_t p = 0; p < surfaces_.panels.size(); ++p) {
      selecting_panel.push_back(selecting(*surfaces_.panels[p]));
      for (const Asked& asked : asked_of(selecting_panel[p], false))
        take(of_panel(p, asked), asked, static_cast<int>(p));
    }
    take_panels_without_a_face();
    for (size_t j = 0; j < surfaces_.joints.size(); ++j) {
      const JointFiguresT& joint = *surfaces_.joints[j];
      std::vector<char> either(rules_.size());
      const std::vector<std::vector<size_t>> ends = {panels_of(joint.first, joint.first_panel),
                                                     panels_of(joint.second, joint.second_panel)};
      bool shared = false;
      for (const std::vector<size_t>& end : ends) {
        shared = shared || end.size() > 1;
        for (const size_t p : end)
          for (size_t r = 0; r < either.size(); ++r) either[r] = either[r] || selecting_panel[p][r];
      }
      for (const Asked& asked : asked_of(either, true)) {
        const std::string doubt =
            shared ? "its panels share their names with others, and nobody says which it lies between" : doubt_of(ends);
        auto verdict = doubt.empty() ? of_joint(joint, asked) : started(asked, joint);
        if (!doubt.empty()) verdict->not_judged = doubt;
        take(std::move(verdict), asked, static_cast<int>(j));
      }
    }
    for (size_t r = 0; r < rules_.size(); ++r) {
      auto request = std::make_unique<JudgementRequestT>();
      request->asked = rules_[r].text, request->by = "rule", request->panels = selected_[r];
      request->not_judged = open_of(r);
      result_.requests.push_back(std::move(request));
    }
    return std::move(result_);
  }

 private:
  /// Numbers of the panel at an end of a joint: one, or all of that name.
  std::vector<size_t> panels_of(const std::string& name, int number) const {
    if (number >= 0 && static_cast<size_t>(number) < surfaces_.panels.size()) return {static_cast<size_t>(number)};
    std::vector<size_t> panels;
    for (size_t p = 0; p < surfaces_.panels.size(); ++p)
      if (surfaces_.panels[p]->face->id == name) panels.push_back(p);
    return panels;
  }

  /// Why what was measured at a joint may not be its panels'; empty where nothing says so.
  std::string doubt_of(const std::vector<std::vector<size_t>>& ends) const {
    if (!surfaces_.place_doubt.empty()) return surfaces_.place_doubt;
    for (const std::vector<size_t>& end : ends)
      for (const size_t p : end)
        if (!doubts_[p].empty()) return "of " + surfaces_.panels[p]->face->id + ": " + doubts_[p];
    return "";
  }
  /// What of a rule is not judged, quantity by quantity; empty if all is.
  std::string open_of(size_t r) const {
    if (selected_[r] == 0) return "it selects no panel that was looked at";
    std::string text;
    for (size_t l = 0; l < asked_[r].size(); ++l) {
      const Followed& followed = asked_[r][l];
      std::string why;
      if (followed.selected == 0) {
        why = surfaces_.joints.empty()
                  ? "no joint was looked at, surface.joints does that in photographs, surface.scan_joints in a scan"
                  : "no joint lies at a panel that it selects";
      } else if (!followed.open.empty()) {
        constexpr size_t most = 20;
        why = std::to_string(followed.open.size()) + " of " + std::to_string(followed.taken) + " are not judged: ";
        for (size_t i = 0; i < std::min(most, followed.open.size()); ++i) why += (i ? ", " : "") + followed.open[i];
        if (followed.open.size() > most) why += " and more";
        why += (followed.open.size() > 1 ? " (the first: " : " (") + followed.why + ")";
      }
      if (!why.empty()) text += (text.empty() ? "" : "; ") + words_of(rules_[r].limits[l]) + ": " + why;
    }
    return text;
  }

  static std::string words_of(const SurfaceLimit& limit) {
    return name_of(limit.quantity) + (std::isfinite(limit.length) ? fmt::format("({:g}m)", limit.length) : "");
  }

  std::vector<char> selecting(const PanelSurfaceFiguresT& panel) {
    ifc::ElementFacts element;
    const auto found = facts_.find(panel.face->guid);
    if (found != facts_.end())
      element = found->second;
    else
      element.name = panel.face->id, element.guid = panel.face->guid;
    return selecting(element);
  }

  /// Panels of the design of which the measurement has no face: asked for, and nobody looked at them, nor at the joints
  /// of those that were left out.
  void take_panels_without_a_face() {
    std::set<std::string> with_face;
    for (const auto& panel : surfaces_.panels) with_face.insert(panel->face->guid);
    for (const auto& [guid, element] : facts_) {
      if (with_face.contains(guid)) continue;
      std::string why;
      for (const auto& panel : surfaces_.left_out)
        if (panel->guid == guid) why = panel->reason;
      const std::vector<char> selects = selecting(element);
      for (const bool of_joints : {false, true}) {
        // Between which panels joints would be nobody knows then; where none at all was looked at the rule says so.
        if (of_joints && (why.empty() || surfaces_.joints.empty())) continue;
        for (const Asked& asked : asked_of(selects, of_joints)) {
          auto verdict = started(asked);
          verdict->panel = element.name.empty() ? guid : element.name, verdict->guid = guid;
          verdict->not_judged = of_joints     ? "none of its joints was looked at: " + why
                                : why.empty() ? "no face of it was looked at"
                                              : why;
          take(std::move(verdict), asked, -1);
        }
      }
    }
  }

  std::vector<char> selecting(const ifc::ElementFacts& element) {
    std::vector<char> selects;
    for (size_t r = 0; r < rules_.size(); ++r) {
      selects.push_back(rules_[r].selection.matches(element));
      selected_[r] += selects.back();
    }
    return selects;
  }

  /// Later rules go before earlier ones, quantity by quantity.
  std::vector<Asked> asked_of(const std::vector<char>& selects, bool of_joints) {
    std::vector<Asked> asked;
    for (size_t r = 0; r < selects.size(); ++r) {
      if (!selects[r]) continue;
      for (const SurfaceLimit& limit : rules_[r].limits) {
        if (is_of_joints(limit.quantity) != of_joints) continue;
        Followed& followed = asked_[r][&limit - rules_[r].limits.data()];
        ++followed.selected;
        std::erase_if(asked, [&](const Asked& before) { return same_question(before.limit, limit); });
        asked.push_back({limit, &rules_[r], &followed});
      }
    }
    refuse_contradictions(asked);
    return asked;
  }

  /// Two rules together may ask for what no joint is.
  static void refuse_contradictions(const std::vector<Asked>& asked) {
    for (const Asked& narrow : asked)
      for (const Asked& wide : asked)
        if (narrow.limit.quantity == SurfaceQuantity::narrowest && wide.limit.quantity == SurfaceQuantity::widest &&
            narrow.limit.lower > wide.limit.upper)
          throw std::runtime_error(
              fmt::format("the rules '{}' and '{}' select the same joint: it would have to be at "
                          "least {:g} mm and at most {:g} mm wide; change one of them",
                          narrow.rule->text, wide.rule->text, 1e3 * narrow.limit.lower, 1e3 * wide.limit.upper));
  }

  static std::unique_ptr<SurfaceVerdictT> started(const Asked& asked) {
    auto verdict = std::make_unique<SurfaceVerdictT>();
    verdict->quantity = name_of(asked.limit.quantity), verdict->rule = asked.rule->text;
    verdict->length = asked.limit.length, verdict->lower = asked.limit.lower, verdict->upper = asked.limit.upper;
    return verdict;
  }
  std::unique_ptr<SurfaceVerdictT> started(const Asked& asked, const JointFiguresT& joint) const {
    auto verdict = started(asked);
    if (joint.first_panel >= 0 && static_cast<size_t>(joint.first_panel) < surfaces_.panels.size())
      verdict->guid = surfaces_.panels[joint.first_panel]->face->guid;
    verdict->panel = joint.first, verdict->second = joint.second, verdict->looked_at = joint.looked_at;
    return verdict;
  }

  std::unique_ptr<SurfaceVerdictT> of_panel(size_t p, const Asked& asked) const {
    const PanelSurfaceFiguresT& panel = *surfaces_.panels[p];
    auto verdict = started(asked);
    verdict->panel = panel.face->id, verdict->guid = panel.face->guid;
    verdict->not_judged = panel.not_measured.empty() ? doubts_[p] : panel.not_measured;
    if (!verdict->not_judged.empty()) return verdict;
    if (asked.limit.quantity == SurfaceQuantity::flatness)
      flatness(panel, asked.limit, *verdict);
    else if (asked.limit.quantity == SurfaceQuantity::offset)
      stands_out(panel, asked.limit, *verdict);
    else
      bend(panel, asked.limit, *verdict);
    if (verdict->verdict == ToleranceVerdict::pass && panel.coverage < kSeenEnough) {
      verdict->verdict = ToleranceVerdict::not_measured;
      verdict->not_judged = half_seen(panel);
    }
    return verdict;
  }

  static std::string apart(const PanelSurfaceFiguresT& panel) {
    return fmt::format("they are {:.0f} mm apart, and with 'cell' of surface.panels = {:.0f} mm all cells have points",
                       1e3 * panel.spacing, 1e3 * panel.covering_cell);
  }
  static std::string half_seen(const PanelSurfaceFiguresT& panel) {
    if (std::isfinite(panel.covering_cell))
      return fmt::format("its limit is kept where points are, and they cover {:.0f} % of its cells: {}",
                         100 * panel.coverage, apart(panel));
    return fmt::format("its limit is kept where points are, and they cover {:.0f} % of it: what the rest is nobody saw",
                       100 * panel.coverage);
  }

  void flatness(const PanelSurfaceFiguresT& panel, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    const auto gap = std::find_if(panel.flatness.begin(), panel.flatness.end(),
                                  [&](const auto& g) { return std::abs(g->length - limit.length) < 1e-6; });
    if (gap == panel.flatness.end()) {
      verdict.not_judged = "no straightedge of that length was laid; add it to 'straightedges' of surface.panels";
    } else if ((*gap)->positions == 0 || !std::isfinite((*gap)->gap)) {
      verdict.not_judged = std::isfinite(panel.covering_cell)
                               ? fmt::format("no straightedge of that length has points all along it: {}", apart(panel))
                               : "the panel has no place for a straightedge of that length with points all along it";
    } else {
      verdict.value = (*gap)->gap, verdict.sigma = (*gap)->sigma;
      verdict.probability = probability_of(verdict.value, verdict.sigma, limit);
      // The largest of many noisy gaps is above the true one by up to the largest that noise makes by itself, whose
      // distribution is an extreme value's (Gumbel); without it the risk is shared among the positions.
      const double noise = (*gap)->noise_mean + gumbel_quantile() * (*gap)->noise_sigma;
      const bool beyond =
          std::isfinite(noise) ? verdict.value - limit.upper > noise : verdict.probability <= risk_ / (*gap)->positions;
      decide(verdict, verdict.probability, beyond ? 0 : 1, risk_);
      if (verdict.verdict == ToleranceVerdict::pass && std::isfinite((*gap)->with_outlying))
        doubt(**gap, limit, verdict);
      if (verdict.verdict == ToleranceVerdict::pass && verdict.value + panel.hidden > limit.upper)
        verdict.verdict = ToleranceVerdict::not_measured, verdict.not_judged = hidden_in(panel);
    }
  }

  static std::string hidden_in(const PanelSurfaceFiguresT& panel) {
    return fmt::format(
        "its limit is kept by the means of cells of {:.0f} mm, and within one its points scatter beyond their noise as "
        "on waves of {:.1f} mm from valley to crest: grooves, a dent or a corrugation smaller than the cells, or noise "
        "that neighbouring points share or that is larger than stated; with a smaller 'cell' of surface.panels it "
        "shows",
        1e3 * panel.cell, 1e3 * panel.hidden);
  }

  /// A dent that is deep beside the noise looks like something in front of the panel: it does not pass by being left
  /// out.
  void doubt(const SurfaceGapT& gap, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    if (verdict_of(probability_of(gap.with_outlying, gap.sigma, limit), risk_) == ToleranceVerdict::pass) return;
    const std::string text = fmt::format(
        "places on it lie off the surface together, a dent or something in front of it: the largest gap is {:.1f} mm "
        "without them and {:.1f} mm with them",
        1e3 * gap.gap, 1e3 * gap.with_outlying);
    verdict.verdict = ToleranceVerdict::not_measured, verdict.not_judged = text;
  }

  /// Of the probability 1 - risk, in standard deviations from the mean.
  double gumbel_quantile() const {
    constexpr double euler = 0.5772156649015329;
    return -std::sqrt(6.0) / M_PI * (euler + std::log(-std::log(1 - risk_)));
  }

  /// Both bows at once, or the twist, from the covariance of the panel's form.
  void bend(const PanelSurfaceFiguresT& panel, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    Eigen::MatrixXd covariance = unpack_symmetric(panel.coefficients_random, 6, "panel '" + panel.face->id + "'");
    if (covariance.size() == 0 || panel.coefficients_factor.size() != 6 * static_cast<size_t>(surfaces_.rank))
      throw std::runtime_error("the figures of panel '" + panel.face->id + "' lack their covariance");
    const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> factor(
        panel.coefficients_factor.data(), 6, surfaces_.rank);
    covariance += factor * factor.transpose();
    const bool twist = limit.quantity == SurfaceQuantity::twist;
    const Eigen::VectorXd form = twist ? Eigen::VectorXd(panel.form.tail<1>()) : Eigen::VectorXd(panel.form.head<2>());
    const Eigen::MatrixXd own =
        twist ? Eigen::MatrixXd(covariance.block(5, 5, 1, 1)) : Eigen::MatrixXd(covariance.block(3, 3, 2, 2));
    std::vector<Limited> quantities;
    for (Eigen::Index i = 0; i < form.size(); ++i) {
      Limited one;
      one.rows = Eigen::MatrixXd::Identity(form.size(), form.size()).row(i), one.above = one.below = limit.upper;
      quantities.push_back(one);
    }
    Eigen::Index larger = 0;
    form.cwiseAbs().maxCoeff(&larger);
    verdict.value = form(larger), verdict.sigma = std::sqrt(own(larger, larger));
    verdict.probability = conformance(form, own, quantities, risk_, limit.upper).probability;
    decide(verdict, verdict.probability, verdict.probability, risk_);
  }

  /// The four corners of the best plane at once, by its covariance with what the whole measurement's place is off by.
  void stands_out(const PanelSurfaceFiguresT& panel, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    if (surfaces_.rank == 0) {
      verdict.not_judged =
          "nobody said how well the place of the points as a whole is known: a scan needs a 'registration' or "
          "'place_sigma', photographs the joint covariance of their orientations";
      return;
    }
    const Eigen::MatrixXd covariance = unpack_symmetric(panel.covariance, 3, "panel '" + panel.face->id + "'");
    if (covariance.size() == 0)
      throw std::runtime_error("the figures of panel '" + panel.face->id + "' lack their covariance");
    const Eigen::Vector3d plane(panel.offset, panel.tilt.x(), panel.tilt.y());
    std::vector<Limited> corners;
    double least = kInf;
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5}) {
        const Eigen::RowVector3d row(1, x * panel.face->width, y * panel.face->height);
        corners.push_back({row, limit.upper, -limit.lower});
        const double value = row.dot(plane), sigma = std::sqrt((row * covariance * row.transpose())(0));
        const double probability = probability_of(value, sigma, limit);
        // Where all are as sure, the furthest.
        if (probability > least || (probability == least && std::abs(value) <= std::abs(verdict.value))) continue;
        least = probability, verdict.value = value, verdict.sigma = sigma;
      }
    verdict.probability = conformance(plane, covariance, corners, risk_, limit.upper).probability;
    decide(verdict, verdict.probability, verdict.probability, risk_);
  }

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
    limit.upper = furthest, limit.lower = -kInf;
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
      for (const PlaceValue& at : places) missed += 1 - probability_of(at.value - z * at.common, at.random, limit);
      const double weight = std::exp(-0.5 * z * z);
      kept += weight * std::max(0.0, 1 - missed), weights += weight;
    }
    return kept / weights;
  }

  std::unique_ptr<SurfaceVerdictT> of_joint(const JointFiguresT& joint, const Asked& asked) const {
    auto verdict = started(asked, joint);
    if (!joint.not_measured.empty()) {
      verdict->not_judged = joint.not_measured;
      return verdict;
    }
    const std::vector<PlaceValue> places = values_along(joint, asked.limit.quantity);
    verdict->places = static_cast<int>(places.size());
    if (places.empty()) {
      verdict->not_judged = asked.limit.quantity == SurfaceQuantity::step ? "one of its panels was not measured"
                            : asked.limit.quantity == SurfaceQuantity::shift
                                ? "nobody said how well the place of the points as a whole "
                                  "is known"
                                : "no place along it was measured";
      return verdict;
    }
    double least = kInf, at_worst = 1;
    for (const PlaceValue& place : places) {
      at_worst = std::min(at_worst, probability_of(place.value, place.sigma_of_tail, asked.limit));
      // The way to the nearer limit, as probabilities of many places are all 0, or 1.
      const double way =
          std::min(asked.limit.upper - place.value, place.value - asked.limit.lower) / std::max(place.sigma, 1e-9);
      if (way >= least) continue;
      least = way, verdict->value = place.value, verdict->sigma = place.sigma, verdict->along = place.along;
    }
    verdict->probability = kept_everywhere(places, asked.limit);
    decide(*verdict, verdict->probability, at_worst, risk_ / verdict->places);
    // An error that the places share is no chance of each.
    if (verdict->verdict == ToleranceVerdict::undecided && asked.limit.quantity == SurfaceQuantity::shift &&
        is_beyond(places, asked.limit))
      verdict->verdict = ToleranceVerdict::fail;
    if (verdict->verdict == ToleranceVerdict::pass) name_extreme(places, asked.limit.quantity, *verdict);
    if (verdict->verdict == ToleranceVerdict::pass) doubt(joint, asked.limit, *verdict);
    return verdict;
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
                           " places along it no gap is to be seen between its panels: filled flush there, or closed";
    else if (verdict.places < needed * joint.looked_at)
      verdict.not_judged = fmt::format(
          "it was measured at {} of {} places along it, where it keeps the limit; to pass it needs {:.0f} %",
          verdict.places, joint.looked_at, 100 * needed);
    if (!verdict.not_judged.empty()) verdict.verdict = ToleranceVerdict::not_measured;
  }

  void decide(SurfaceVerdictT& verdict, double kept, double at_worst, double fails_at) const {
    verdict.verdict = ToleranceVerdict::undecided;
    if (verdict_of(kept, risk_) == ToleranceVerdict::pass)
      verdict.verdict = ToleranceVerdict::pass;
    else if (at_worst <= fails_at)
      verdict.verdict = ToleranceVerdict::fail;
  }

  void take(std::unique_ptr<SurfaceVerdictT> verdict, const Asked& asked, int item) {
    verdict->item = item;
    ++asked.followed->taken;
    if (!verdict->not_judged.empty()) {
      ++result_.not_judged;
      asked.followed->open.push_back(verdict->second.empty() ? verdict->panel
                                                             : verdict->panel + " | " + verdict->second);
      if (asked.followed->why.empty()) asked.followed->why = verdict->not_judged;
    } else if (verdict->verdict == ToleranceVerdict::pass)
      ++result_.passed;
    else if (verdict->verdict == ToleranceVerdict::fail)
      ++result_.failed;
    else
      ++result_.undecided;
    result_.verdicts.push_back(std::move(verdict));
  }

  const SurfacesT& surfaces_;
  const std::map<std::string, ifc::ElementFacts>& facts_;
  const std::vector<SurfaceRule>& rules_;
  double risk_;
  std::vector<int> selected_;
  std::vector<std::string> doubts_;           ///< by panel: why what was measured may not be its surface
  std::vector<std::vector<Followed>> asked_;  ///< by rule and limit
  SurfaceJudgementT result_;
};

}  // namespace

SurfaceJudgementT judge_surfaces(const SurfacesT& surfaces, const std::map<std::string, ifc::ElementFacts>& facts,
                                 const std::vector<SurfaceRule>& rules, double risk, double within) {
  return Judge(surfaces, facts, rules, risk, within).all();
}

}  // namespace plumbline::judgement

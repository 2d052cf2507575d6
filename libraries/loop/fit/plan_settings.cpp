#include "loop/fit/plan_settings.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <set>
#include <stdexcept>

#include "base/text/text.hpp"
#include "base/text/words.hpp"
#include "loop/fit/limit_dual.hpp"

namespace plumbline::loop {

namespace {

/// Of a tolerance, what the guard band may take before it says nothing any more.
constexpr double kLargestGuard = 0.9;
/// Limits broken by less are kept [mm].
constexpr double kBroken = 1e-5;
/// Limits that the last optimum kept by more [mm] are forgotten: the first solutions break thousands of which hundreds
/// hold at the end. So many solutions may forget: each optimum is above the one before, because all that holds is kept,
/// but where settings cost next to nothing not by much.
constexpr double kNear = 0.1;
constexpr int kForgetful = 20;
/// Up to so many limits their multipliers are the unknowns: dense, a program of more of them takes longer than the
/// sparse one of all settings. Few solutions matter less then than few limits.
constexpr std::size_t kFew = 400;
/// An excess above this is told [mm].
constexpr double kTold = 0.01;

std::string millimetres(double metres) { return text::format_fixed(1e3 * metres, 1); }

/// Every limit there is: ranges of brackets, then judged values less their guard band.
std::vector<Limit> limits_of(const Facade& facade, const SettingsProgram& program, const Fit& fit) {
  std::vector<Limit> limits;
  for (std::size_t b = 0; b < facade.brackets.size(); ++b)
    for (int k = 0; program.is_set(b) && k < 3; ++k)
      limits.push_back(
          {static_cast<int>(b), k, -1, 1e3 * facade.brackets[b].type.low[k], 1e3 * facade.brackets[b].type.high[k]});
  for (std::size_t v = 0; v < fit.judged.size(); ++v) {
    const JudgedValue& value = fit.judged[v];
    const double half = 0.5 * (value.high - value.low);
    const double guard = std::min(facade.errors.guard_factor * fit.values[v].u, kLargestGuard * half);
    limits.push_back({-1, -1, static_cast<int>(v), 1e3 * (value.low + guard), 1e3 * (value.high - guard), value.panel});
  }
  return limits;
}

/// Limits that the solver knows, one side each; which of all there are is chosen anew after each solution.
class WorkingLimits {
 public:
  WorkingLimits(const std::vector<Limit>& all, std::size_t panels)
      : all_(all), panels_(panels), known_(all.size(), {false, false}) {}

  const std::vector<Limit>& limits() const { return limits_; }

  /// What the solution breaks comes in, of each panel (bracket) only the worst if `worst_alone`; what it keeps by more
  /// than kNear is forgotten if `forget`. False: nothing is broken that was not known.
  bool choose(const SettingsProgram& program, const Eigen::VectorXd& x, bool worst_alone, bool forget) {
    struct Broken {
      double by = 0;
      std::size_t limit = 0;
      int side = 0;
    };
    std::map<std::size_t, Broken> worst;
    bool complete = true;
    for (std::size_t i = 0; i < all_.size(); ++i) {
      const double at = program.at(all_[i], x);
      for (const int side : {0, 1}) {
        const double by = side == 0 ? all_[i].low - at : at - all_[i].high;
        if (known_[i][side]) {
          known_[i][side] = by > -kNear || !forget;
        } else if (by > kBroken) {
          complete = false;
          known_[i][side] = !worst_alone;
          Broken& of_panel = worst[panel_of(i)];
          if (by > of_panel.by) of_panel = {by, i, side};
        }
      }
    }
    for (const auto& [panel, broken] : worst) known_[broken.limit][broken.side] = true;
    if (!complete) gather();
    return !complete;
  }

 private:
  std::size_t panel_of(std::size_t i) const {
    return all_[i].value < 0 ? panels_ + static_cast<std::size_t>(all_[i].bracket) : all_[i].panel;
  }
  void gather() {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    limits_.clear();
    for (std::size_t i = 0; i < all_.size(); ++i)
      for (const int side : {0, 1}) {
        if (!known_[i][side]) continue;
        limits_.push_back(all_[i]);
        (side == 0 ? limits_.back().high : limits_.back().low) = side == 0 ? infinity : -infinity;
      }
  }

  const std::vector<Limit>& all_;
  std::size_t panels_;
  std::vector<std::array<bool, 2>> known_;
  std::vector<Limit> limits_;
};

/// The optimum; `working` are the limits that it knows at the end, one side each, with their excess in the last
/// unknowns.
ConvexOptimum optimum_of(const SettingsProgram& program, const std::vector<Limit>& limits, std::size_t panels,
                         std::vector<Limit>& working, int& solves) {
  WorkingLimits chosen(limits, panels);
  LimitDual dual(program);
  for (bool few = dual.is_regular();; few = few && chosen.limits().size() <= kFew) {
    ConvexOptimum optimum = few ? dual.optimum(chosen.limits()) : minimise(program.with(chosen.limits()));
    ++solves;
    if (chosen.choose(program, optimum.x, few, solves <= kForgetful)) continue;
    working = chosen.limits();
    return optimum;
  }
}

std::string panels_on(const Facade& facade, std::size_t bracket) {
  std::string names;
  for (const Panel& panel : facade.panels)
    for (const Hook& hook : panel.hooks)
      if (hook.bracket == bracket) names += (names.empty() ? "" : " or ") + panel.id;
  return names;
}

const char* way_of(std::size_t direction, bool is_plus) {
  static constexpr const char* kPlus[] = {"to the right", "up", "outward"};
  static constexpr const char* kMinus[] = {"to the left", "down", "inward"};
  return is_plus ? kPlus[direction] : kMinus[direction];
}

std::string range_words(const Facade& facade, const Relaxation& relaxed) {
  const auto& bracket = facade.brackets[relaxed.bracket];
  const auto k = static_cast<std::size_t>(relaxed.direction);
  const double excess = std::abs(relaxed.needed - relaxed.limit);
  return "bracket " + bracket.id + " would have to move " + millimetres(std::abs(relaxed.needed)) + " mm " +
         way_of(k, relaxed.needed > 0) + ", it has " + millimetres(std::abs(relaxed.limit)) +
         ": re-drill, or trim panel " + panels_on(facade, static_cast<std::size_t>(relaxed.bracket)) + " by " +
         millimetres(excess) + " mm at this hook";
}

std::string range_topic(const Facade& facade, const Relaxation& relaxed) {
  static constexpr const char* kAxes[] = {"right", "up", "out"};
  return "bracket " + facade.brackets[relaxed.bracket].id + ", " + kAxes[relaxed.direction];
}

std::string value_words(const Facade& facade, const JudgedValue& value, const Relaxation& relaxed) {
  const std::string by = millimetres(std::abs(relaxed.needed - relaxed.limit));
  if (value.quantity == Quantity::gap) {
    const bool wide = relaxed.needed > relaxed.limit;
    return "the " + value.words(facade) + " would be " + millimetres(relaxed.needed) + " mm, it may be " +
           millimetres(relaxed.limit) + " with the guard band: " +
           (wide ? "a wider seal, or a panel that is " + by + " mm larger"
                 : "trim one of the two panels by " + by + " mm");
  }
  return "the " + value.words(facade) + " would be off by " + millimetres(relaxed.needed) + " mm, it may be " +
         millimetres(relaxed.limit) + " with the guard band: a more precise measurement, or a tolerance wider by " +
         by + " mm";
}

/// Brackets of these panels that are asked for all that they have one way: who mends one of them finds the next. Those
/// that are asked for more have a relaxation of their own.
std::string ends_words(const Facade& facade, const SettingsProgram& program, const Eigen::VectorXd& x,
                       const std::set<std::size_t>& panels) {
  std::set<std::size_t> brackets;
  for (const std::size_t j : panels)
    for (const Hook& hook : facade.panels[j].hooks)
      if (program.is_set(hook.bracket)) brackets.insert(hook.bracket);
  std::vector<std::string> ends;
  for (const std::size_t b : brackets) {
    const Eigen::Vector3d asked = program.setting(b, x);
    for (std::size_t k = 0; k < 3; ++k)
      for (const bool is_plus : {true, false}) {
        const auto along = static_cast<Eigen::Index>(k);
        const double sign = is_plus ? 1 : -1,
                     end = is_plus ? facade.brackets[b].type.high[along] : -facade.brackets[b].type.low[along];
        // At zero nothing tells that it is asked for more.
        if (1e3 * std::abs(sign * asked[along] - end) < kTold && end > 0)
          ends.push_back(facade.brackets[b].id + " with " + millimetres(end) + " mm " + way_of(k, is_plus));
      }
  }
  return ends.empty() ? std::string() : "; at the end of their ranges beside it: " + text::join(ends, 8);
}

std::set<std::size_t> panels_of(const Facade& facade, const Fit& fit, const Relaxation& relaxed) {
  std::set<std::size_t> panels;
  if (relaxed.value >= 0)
    for (const auto& [panel, row] : fit.judged[relaxed.value].rows) panels.insert(panel);
  for (std::size_t j = 0; relaxed.value < 0 && j < facade.panels.size(); ++j)
    for (const Hook& hook : facade.panels[j].hooks)
      if (static_cast<int>(hook.bracket) == relaxed.bracket) panels.insert(j);
  return panels;
}

void gather_relaxations(const Facade& facade, const SettingsProgram& program, const std::vector<Limit>& working,
                        const ConvexOptimum& optimum, Fit& fit) {
  const Eigen::Index excess = optimum.x.size() - static_cast<Eigen::Index>(working.size());
  for (std::size_t i = 0; i < working.size(); ++i) {
    if (optimum.x[excess + static_cast<Eigen::Index>(i)] < kTold) continue;
    Relaxation relaxed{working[i].bracket, working[i].direction, working[i].value, 0, 0, {}, {}};
    relaxed.needed = 1e-3 * program.at(working[i], optimum.x);
    relaxed.limit = 1e-3 * (std::isfinite(working[i].high) ? working[i].high : working[i].low);
    relaxed.words = working[i].value < 0 ? range_words(facade, relaxed)
                                         : value_words(facade, fit.judged[working[i].value], relaxed);
    relaxed.topic = working[i].value < 0 ? range_topic(facade, relaxed) : fit.judged[working[i].value].words(facade);
    relaxed.words += ends_words(facade, program, optimum.x, panels_of(facade, fit, relaxed));
    fit.relaxations.push_back(std::move(relaxed));
  }
}

/// With the precision that it would take.
void note_what_is_too_uncertain(const Facade& facade, Fit& fit) {
  std::size_t unguarded = 0, worst = 0;
  double most = 0, needed = 0;
  for (std::size_t v = 0; v < fit.values.size(); ++v) {
    if (fit.values[v].guarded) continue;
    ++unguarded;
    const double enough = kLargestGuard * 0.5 * (fit.judged[v].high - fit.judged[v].low) / facade.errors.guard_factor;
    if (fit.values[v].u > most * enough) most = fit.values[v].u / enough, worst = v, needed = enough;
  }
  if (!(needed > 0)) return;
  fit.notes.push_back(std::to_string(unguarded) + " of " + std::to_string(fit.values.size()) +
                      " judged lengths have a tolerance that k u takes nine tenths of or more: no setting can be "
                      "shown to be good enough there; worst is the " +
                      fit.judged[worst].words(facade) + ": u is " + text::format_fixed(1e3 * fit.values[worst].u, 2) +
                      " mm, and " + text::format_fixed(1e3 * needed, 2) + " mm or less would do");
}

/// Nobody sets a sill: what it holds.
std::string sill_words(const Facade& facade, std::size_t sill) {
  std::vector<std::string> held;
  for (const Panel& panel : facade.panels)
    if (panel.below)
      for (const auto& [place, part] : panel.below->sills)
        if (place == sill) held.push_back(panel.id);
  return "sill " + facade.brackets[sill].id +
         (held.empty() ? " holds no bottom edge that is planned by it"
                       : " holds the bottom edge of " + text::join(held, 8)) +
         ": nothing is to be set on it";
}

void note_what_is_missing(const Facade& facade, Fit& fit) {
  std::vector<bool> used(facade.brackets.size(), false);
  for (std::size_t j = 0; j < facade.panels.size(); ++j) {
    const Panel& panel = facade.panels[j];
    if (panel.hooks.empty()) fit.notes.push_back("panel " + panel.id + " hangs on no bracket: it is not planned");
    if (panel.hooks.size() == 1)
      fit.notes.push_back("panel " + panel.id + " hangs on one bracket, " + facade.brackets[panel.hooks[0].bracket].id +
                          ": how it turns is open");
    for (const Hook& hook : panel.hooks) {
      used[hook.bracket] = true;
      if (!facade.brackets[hook.bracket].measured())
        fit.notes.push_back("panel " + panel.id + ": bracket " + facade.brackets[hook.bracket].id +
                            " was not measured: measure it before the panel is set");
    }
  }
  for (std::size_t b = 0; b < used.size(); ++b)
    if (!used[b] && facade.brackets[b].is_sill)
      fit.notes.push_back(sill_words(facade, b));
    else if (!used[b])
      fit.notes.push_back("bracket " + facade.brackets[b].id +
                          (facade.brackets[b].holds_unplanned
                               ? " holds a panel that is not planned: it has no setting before that is"
                               : " holds no panel of the design: nothing is to be set on it"));
  note_what_is_too_uncertain(facade, fit);
}

/// Values of one panel's corners or of one joint rest on the same brackets: their covariance is made together.
void add_uncertainties(const Facade& facade, Fit& fit) {
  fit.values.resize(fit.judged.size());
  std::vector<std::size_t> begins;
  for (std::size_t v = 0; v < fit.judged.size(); ++v)
    if (v == 0 || fit.judged[v].panel != fit.judged[v - 1].panel || fit.judged[v].joint != fit.judged[v - 1].joint)
      begins.push_back(v);
  begins.push_back(fit.judged.size());
  tbb::parallel_for(std::size_t{0}, begins.size() - 1, [&](std::size_t g) {
    std::vector<const JudgedValue*> group;
    for (std::size_t v = begins[g]; v < begins[g + 1]; ++v) group.push_back(&fit.judged[v]);
    const Eigen::MatrixXd covariance = errors_of(group, facade, fit.poses).covariance();
    for (std::size_t v = begins[g]; v < begins[g + 1]; ++v) {
      const auto i = static_cast<Eigen::Index>(v - begins[g]);
      fit.values[v].u = std::sqrt(std::max(0.0, covariance(i, i)));
      fit.values[v].guarded = facade.errors.guard_factor * fit.values[v].u <=
                              kLargestGuard * 0.5 * (fit.judged[v].high - fit.judged[v].low);
    }
  });
}

Eigen::VectorXd movements(const Facade& facade, const PanelPose& pose, const std::vector<Eigen::Vector3d>& settings) {
  Eigen::VectorXd moved(pose.solve.cols());
  for (Eigen::Index i = 0; i < moved.size(); ++i) {
    const PanelPose::Held& held = pose.held[i];
    const Bracket& bracket = facade.brackets[held.bracket];
    moved[i] = held.direction.dot(bracket.deviation + bracket.axes * settings[held.bracket]);
  }
  return moved;
}

/// What is judged, with its uncertainty; nothing is set yet.
Fit judged_fit(const Facade& facade) {
  Fit fit;
  fit.poses = poses_of(facade);
  fit.judged = judged_values(facade, fit.poses, fit.notes);
  add_uncertainties(facade, fit);
  return fit;
}

/// Settings, twists and values from what is asked for.
void take_settings(const Facade& facade, Fit& fit) {
  for (std::size_t b = 0; b < facade.brackets.size(); ++b) {
    const Bracket& bracket = facade.brackets[b];
    fit.settings.push_back(bracket.measured() && !bracket.stays() ? settable(bracket.type, fit.asked[b])
                                                                  : Eigen::Vector3d::Zero());
  }
  for (const PanelPose& pose : fit.poses) fit.twists.push_back(pose.solve * movements(facade, pose, fit.settings));
  const std::vector<double> values = values_of(facade, fit, fit.settings);
  for (std::size_t v = 0; v < values.size(); ++v) fit.values[v].value = values[v];
}

}  // namespace

Eigen::Vector3d settable(const BracketType& type, const Eigen::Vector3d& setting) {
  Eigen::Vector3d set = setting.cwiseMax(type.low).cwiseMin(type.high);
  for (int k = 0; k < 3; ++k) {
    if (!(type.step[k] > 0)) continue;
    const double least = std::ceil(type.low[k] / type.step[k] - 1e-9);
    const double most = std::floor(type.high[k] / type.step[k] + 1e-9);
    set[k] = type.step[k] * std::clamp(std::round(set[k] / type.step[k]), least, std::max(least, most));
  }
  return set;
}

std::vector<double> values_of(const Facade& facade, const Fit& fit, const std::vector<Eigen::Vector3d>& settings) {
  std::vector<Eigen::Matrix<double, 6, 1>> twists;
  for (const PanelPose& pose : fit.poses) twists.push_back(pose.solve * movements(facade, pose, settings));
  std::vector<double> values;
  for (const JudgedValue& judged : fit.judged) {
    values.push_back(judged.constant);
    for (const auto& [panel, row] : judged.rows) values.back() += row.dot(twists[panel]);
  }
  return values;
}

Fit plan_settings(const Facade& facade, const FitWeights& weights) {
  Fit fit = judged_fit(facade);
  const SettingsProgram program(facade, fit.poses, fit.judged, weights);
  const std::vector<Limit> limits = limits_of(facade, program, fit);
  note_what_is_missing(facade, fit);
  std::vector<Limit> working;
  const ConvexOptimum optimum = optimum_of(program, limits, facade.panels.size(), working, fit.solves);
  fit.objective = 1e-6 * optimum.value;
  gather_relaxations(facade, program, working, optimum, fit);
  for (std::size_t b = 0; b < facade.brackets.size(); ++b)
    fit.asked.push_back(facade.brackets[b].measured() ? program.setting(b, optimum.x)
                                                      : Eigen::Vector3d::Constant(kUnknown));
  take_settings(facade, fit);
  return fit;
}

Fit fit_of_settings(const Facade& facade, const std::vector<Eigen::Vector3d>& asked) {
  if (asked.size() != facade.brackets.size())
    throw std::invalid_argument(std::to_string(asked.size()) + " settings for " +
                                std::to_string(facade.brackets.size()) + " brackets");
  Fit fit = judged_fit(facade);
  note_what_is_missing(facade, fit);
  for (std::size_t b = 0; b < asked.size(); ++b) {
    const Bracket& bracket = facade.brackets[b];
    const bool is_set = bracket.measured() && !bracket.stays();
    fit.asked.push_back(is_set               ? asked[b]
                        : bracket.measured() ? Eigen::Vector3d::Zero()
                                             : Eigen::Vector3d::Constant(kUnknown));
    for (int k = 0; is_set && k < 3; ++k) {
      const double limit = std::clamp(asked[b][k], bracket.type.low[k], bracket.type.high[k]);
      if (1e3 * std::abs(asked[b][k] - limit) < kTold) continue;
      Relaxation relaxed{static_cast<int>(b), k, -1, asked[b][k], limit, {}, {}};
      relaxed.words = range_words(facade, relaxed), relaxed.topic = range_topic(facade, relaxed);
      fit.relaxations.push_back(std::move(relaxed));
    }
  }
  take_settings(facade, fit);
  return fit;
}

}  // namespace plumbline::loop

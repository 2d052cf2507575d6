#include "loop/gate/gate.hpp"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "loop/gate/inside_probability.hpp"

namespace plumbline::loop {

const char* name_of(GateVerdict verdict) {
  return verdict == GateVerdict::go ? "GO" : verdict == GateVerdict::hold ? "HOLD" : "NO_GO";
}

namespace {

/// Of what is told for the reader, and not decided by.
constexpr double kAdvicePrecision = 0.01;
/// Of more brackets than that, only so many are asked what their measurement would give, and none that would take less
/// of every variance.
constexpr std::size_t kMostAsked = 16;
constexpr double kLeastShare = 5e-4;

/// The judged region of one panel.
struct Region {
  std::vector<std::size_t> values;  ///< indices into Fit::judged
  Eigen::VectorXd mean, low, high;
  ValueErrors errors;
  double inside(const Eigen::MatrixXd& covariance, double precision = 0.001) const {
    return inside_probability(mean, covariance, low, high, precision);
  }
};

Region region_of(const Facade& facade, const Fit& fit, std::vector<std::size_t> values) {
  Region region;
  const auto m = static_cast<Eigen::Index>(values.size());
  region.mean.resize(m), region.low.resize(m), region.high.resize(m);
  std::vector<const JudgedValue*> judged;
  for (Eigen::Index i = 0; i < m; ++i) {
    const std::size_t v = values[i];
    judged.push_back(&fit.judged[v]);
    region.mean[i] = fit.values[v].value, region.low[i] = fit.judged[v].low, region.high[i] = fit.judged[v].high;
  }
  region.errors = errors_of(judged, facade, fit.poses);
  region.values = std::move(values);
  return region;
}

/// The value that is most likely outside.
Eigen::Index worst_of(const Region& region, const Eigen::MatrixXd& covariance) {
  Eigen::Index worst = 0;
  double most = -1;
  for (Eigen::Index i = 0; i < region.mean.size(); ++i) {
    const double u = std::max(1e-12, std::sqrt(std::max(0.0, covariance(i, i))));
    const double a = (region.low[i] - region.mean[i]) / u, b = (region.mean[i] - region.high[i]) / u;
    const double outside = normal_below(a) + normal_below(b) + 1e-30 * std::max(a, b);
    if (outside > most) most = outside, worst = i;
  }
  return worst;
}

/// By which rare events lower the probability that all is inside: p when none happens is multiplied by what each one
/// leaves of it. True to the first order of their share; where two happen at once, as if they lay apart.
/// A normal distribution of the same variance says more than is true: they are few and large.
double slip_factor(const Region& region, double inside) {
  const ValueErrors& errors = region.errors;
  double factor = 1;
  for (std::size_t i = 0; i < errors.rare.size() && inside > 1e-6; ++i) {
    const double after = region.inside(errors.covariance_when(static_cast<int>(i)), kAdvicePrecision);
    factor *= 1 - errors.rare[i].share * (1 - std::min(1.0, after / inside));
  }
  return factor;
}

/// What one more measurement of a bracket on the same control takes off the covariance of the values (conditioning;
/// nothing else changes).
Eigen::MatrixXd taken_by_measuring(const Region& region, std::size_t bracket, double sigma) {
  const ValueErrors& errors = region.errors;
  const Eigen::MatrixXd column = errors.with_own.middleCols<3>(3 * static_cast<Eigen::Index>(bracket));
  const Eigen::Matrix3d innovation = errors.own_alone[bracket] + sigma * sigma * Eigen::Matrix3d::Identity();
  const Eigen::MatrixXd taken = column * innovation.ldlt().solve(column.transpose());
  return 0.5 * (taken + taken.transpose());
}

/// p_in when no campaign adds an error of its own any more.
double after_many_campaigns(const Region& region, double slips) {
  const Eigen::MatrixXd after = region.errors.covariance_when(-1) - region.errors.own;
  return slips * region.inside(0.5 * (after + after.transpose()), kAdvicePrecision);
}

/// Brackets, as places among those that the values rest on, whose measurement takes most off their variances: of a high
/// column many have next to no part in its uppermost panel.
std::vector<std::size_t> worth_measuring(const Region& region, const Eigen::MatrixXd& covariance, double sigma) {
  std::vector<std::pair<double, std::size_t>> by_share;
  for (std::size_t b = 0; b < region.errors.brackets.size(); ++b) {
    const Eigen::VectorXd taken = taken_by_measuring(region, b, sigma).diagonal();
    const double share = (taken.array() / covariance.diagonal().array().max(1e-18)).maxCoeff();
    if (share > kLeastShare || region.errors.brackets.size() <= kMostAsked) by_share.emplace_back(-share, b);
  }
  std::sort(by_share.begin(), by_share.end());
  if (by_share.size() > kMostAsked) by_share.resize(kMostAsked);
  std::vector<std::size_t> brackets;
  for (const auto& [share, b] : by_share) brackets.push_back(b);
  std::sort(brackets.begin(), brackets.end());
  return brackets;
}

Advice best_measurement(const Region& region, const Eigen::MatrixXd& covariance, Eigen::Index worst,
                        const PanelGate& gate, double sigma) {
  Advice best;
  best.p_in = gate.p_in, best.u_now = best.u = std::sqrt(covariance(worst, worst));
  for (const std::size_t b : worth_measuring(region, covariance, sigma)) {
    const Eigen::MatrixXd after = covariance - taken_by_measuring(region, b, sigma);
    const double p = gate.slips * region.inside(after, kAdvicePrecision);
    // Towards a decision: away from even odds.
    if (std::abs(p - 0.5) <= std::abs(best.p_in - 0.5) + 1e-4) continue;
    best.bracket = static_cast<int>(region.errors.brackets[b]), best.p_in = p;
    best.u = std::sqrt(std::max(0.0, after(worst, worst)));
  }
  return best;
}

/// The largest standard deviation of a setting that gives GO; nan if it is not the robot's precision that lacks.
double robot_that_would_do(const Region& region, double sigma, double slips, const GateOptions& options) {
  const auto inside_with = [&](double factor) {
    const ValueErrors& errors = region.errors;
    const Eigen::MatrixXd covariance =
        errors.measured + errors.made + factor * factor * (errors.setting + errors.station);
    return slips * region.inside(0.5 * (covariance + covariance.transpose()), kAdvicePrecision);
  };
  if (!(sigma > 0) || inside_with(0) < options.go) return 0;
  double low = 0, high = 1;
  for (int i = 0; i < 7; ++i) (inside_with(0.5 * (low + high)) >= options.go ? low : high) = 0.5 * (low + high);
  return low * sigma;
}

/// "top left corner of F01-P02, out: 3.4 mm of -5.0 to 5.0, u 1.2 mm".
std::string value_words(const Facade& facade, const Fit& fit, std::size_t value, double u) {
  const JudgedValue& judged = fit.judged[value];
  return judged.words(facade) + ": " + fmt::format("{:.1f}", 1e3 * fit.values[value].value) + " mm, limits " +
         fmt::format("{:.1f}", 1e3 * judged.low) + " and " + fmt::format("{:.1f} mm", 1e3 * judged.high) + ", u " +
         fmt::format("{:.2f} mm", 1e3 * u);
}

/// Whether a panel with this probability would be GO or NO_GO.
bool decides(double p_in, const GateOptions& options) { return p_in >= options.go || 1 - p_in >= options.no_go; }

/// What nobody who measures once, measures again or sets better decides: how precise the length that decides would have
/// to be known and set at least; empty: it is outside, or something decides.
std::string precision_words(const JudgedValue& judged, double value, const PanelGate& gate,
                            const GateOptions& options) {
  const double room = std::min(value - judged.low, judged.high - value);
  if (!(room > 0) || decides(gate.measure.p_in, options) || gate.p_repeated >= options.go || gate.robot_sigma > 0)
    return {};
  // The quantile of `go`: with less room than that for its u a length is outside too often, whatever the others do.
  double low = 0, high = 10;
  for (int i = 0; i < 40; ++i)
    (0.5 * std::erfc(-0.5 * (low + high) / std::sqrt(2.0)) < options.go ? low : high) = 0.5 * (low + high);
  return "; of that length u would have to be " + fmt::format("{:.2f} mm or less", 1e3 * room / low);
}

std::string hold_words(const Facade& facade, const PanelGate& gate, const GateOptions& options) {
  std::string words;
  const bool helps = gate.measure.bracket >= 0;
  const std::string what = helps ? facade.brackets[gate.measure.bracket].id + " once more to " +
                                       fmt::format("{:.1f} mm", 1e3 * options.measurement_sigma)
                                 : std::string();
  if (helps && decides(gate.measure.p_in, options))
    words += "; measuring " + what + " takes u to " + fmt::format("{:.2f} mm", 1e3 * gate.measure.u) + " and p to " +
             fmt::format("{:.2f}", gate.measure.p_in) + " if the estimate stays";
  else
    words += "; no single measurement decides it" +
             (helps ? " (the best, " + what + ", takes p to " + fmt::format("{:.2f}", gate.measure.p_in) + ")" : "");
  if (gate.p_repeated >= options.go) words += "; more campaigns take p to " + fmt::format("{:.2f}", gate.p_repeated);
  if (gate.robot_sigma > 0)
    words += "; a robot that sets to " + fmt::format("{:.2f} mm", 1e3 * gate.robot_sigma) + " would do";
  else if (gate.slips < options.go)
    words += "; brackets that slip on tightening, and what is knocked, take p to " + fmt::format("{:.2f}", gate.slips) +
             " of what it would be";
  else if (gate.robot_sigma == 0)
    words += "; no robot is precise enough";
  return words;
}

bool all_hang(const Facade& facade, const JudgedValue& judged) {
  return std::all_of(judged.rows.begin(), judged.rows.end(),
                     [&](const auto& row) { return facade.panels[row.first].installed; });
}

/// "up and out": along which some corner moves in a way that the hooks do not tell.
std::string untold_directions(const Panel& panel, const PanelPose& pose) {
  std::string words;
  for (int k = 2; k >= 0; --k)
    if (std::any_of(panel.corners.begin(), panel.corners.end(), [&](const Eigen::Vector3d& corner) {
          return !pose.tells(pose.movement(panel, corner, panel.axes.col(k)));
        }))
      words += (words.empty() ? "" : " and ") + std::string(kDirections[k]);
  return words;
}

/// What would tell it.
std::string way_to_tell(const Facade& facade, const Panel& panel) {
  if (!panel.below_unknown.empty()) return panel.below_unknown;
  if (panel.below && panel.below->panel >= 0)
    return "its bottom edge is held by panel " + facade.panels[static_cast<std::size_t>(panel.below->panel)].id +
           ", and how far out the top edge of that is is not known";
  return "a hook more, one that holds more, or held_below of evaluate.deviation where the panel below or a sill holds "
         "its bottom edge";
}

/// The obstacle, and its words; none and empty if there is none.
std::pair<Obstacle, std::string> obstacle_of(const Facade& facade, const Fit& fit, std::size_t j) {
  const Panel& panel = facade.panels[j];
  if (panel.hooks.empty()) return {Obstacle::no_bracket, "hangs on no bracket"};
  std::string missing;
  for (const Hook& hook : panel.hooks)
    if (!facade.brackets[hook.bracket].measured())
      missing += (missing.empty() ? "" : ", ") + facade.brackets[hook.bracket].id;
  if (!missing.empty()) return {Obstacle::not_measured, "not measured: " + missing + "; measure it, then plan again"};
  if (panel.hooks.size() == 1) return {Obstacle::one_bracket, "hangs on one bracket: how it turns is open"};
  if (const std::string untold = untold_directions(panel, fit.poses[j]); !untold.empty())
    return {Obstacle::not_told,
            "its hooks do not tell how far its corners move " + untold + ": " + way_to_tell(facade, panel)};
  if (!panel.open.empty()) return {Obstacle::not_judged, panel.open};
  return {};
}

PanelGate judge_region(const Facade& facade, const Fit& fit, const Region& region, const GateOptions& options) {
  PanelGate gate;
  const Eigen::MatrixXd covariance = region.errors.covariance();
  const Eigen::Index worst = worst_of(region, covariance);
  gate.decided_by = static_cast<int>(region.values[worst]);
  const Eigen::MatrixXd unslipped = region.errors.covariance_when(-1);
  gate.p_in = region.inside(unslipped);
  gate.slips = slip_factor(region, gate.p_in);
  gate.p_in *= gate.slips;
  gate.verdict = gate.p_in >= options.go          ? GateVerdict::go
                 : 1 - gate.p_in >= options.no_go ? GateVerdict::no_go
                                                  : GateVerdict::hold;
  gate.reason = "p " + fmt::format("{:.3f}", gate.p_in) + "; " +
                value_words(facade, fit, region.values[worst], std::sqrt(covariance(worst, worst)));
  if (gate.verdict == GateVerdict::hold) {
    gate.measure = best_measurement(region, unslipped, worst, gate, options.measurement_sigma);
    if (facade.own.size() > 0) gate.p_repeated = after_many_campaigns(region, gate.slips);
    gate.robot_sigma = robot_that_would_do(region, facade.errors.setting, gate.slips, options);
    gate.reason += hold_words(facade, gate, options);
    const std::size_t value = region.values[worst];
    gate.reason += precision_words(fit.judged[value], fit.values[value].value, gate, options);
  }
  return gate;
}

/// Whether a limit that gives way is that of a bracket of the panel, or of a length of its own.
bool concerns(const Panel& panel, std::size_t j, const Fit& fit, const Relaxation& relaxed) {
  if (relaxed.value < 0)
    return std::any_of(panel.hooks.begin(), panel.hooks.end(),
                       [&](const Hook& hook) { return static_cast<int>(hook.bracket) == relaxed.bracket; });
  const auto& rows = fit.judged[relaxed.value].rows;
  return std::any_of(rows.begin(), rows.end(), [&](const auto& row) { return row.first == j; });
}

/// `values`: that are judged of panel j.
PanelGate judge_panel(const Facade& facade, const Fit& fit, std::size_t j, std::vector<std::size_t> values,
                      const GateOptions& options) {
  const auto [obstacle, why_not] = obstacle_of(facade, fit, j);
  PanelGate gate;
  if (!values.empty()) gate = judge_region(facade, fit, region_of(facade, fit, std::move(values)), options);
  gate.obstacle = obstacle;
  if (obstacle != Obstacle::none) {
    if (gate.verdict == GateVerdict::go) gate.verdict = GateVerdict::hold;
    gate.p_repeated = kUnknown;
    gate.reason = why_not + (gate.reason.empty() ? "" : "; " + gate.reason);
  }
  for (std::size_t r = 0; r < fit.relaxations.size(); ++r)
    if (concerns(facade.panels[j], j, fit, fit.relaxations[r]))
      gate.relaxed.push_back(r), gate.reason += "; " + fit.relaxations[r].words;
  return gate;
}

}  // namespace

std::vector<PanelGate> judge_plan(const Facade& facade, const Fit& fit, const GateOptions& options) {
  std::vector<std::vector<std::size_t>> values(facade.panels.size());
  for (std::size_t v = 0; v < fit.judged.size(); ++v)
    for (const auto& [panel, row] : fit.judged[v].rows)
      // What hangs is right or wrong by what hangs: a neighbour that cannot hang yet says nothing against it.
      if (!facade.panels[panel].installed || all_hang(facade, fit.judged[v])) values[panel].push_back(v);
  std::vector<PanelGate> gates(facade.panels.size());
  tbb::parallel_for(std::size_t{0}, gates.size(),
                    [&](std::size_t j) { gates[j] = judge_panel(facade, fit, j, std::move(values[j]), options); });
  return gates;
}

}  // namespace plumbline::loop

#include "judgement/surfaces.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "geometry/packed_symmetric.hpp"
#include "judgement/conformance.hpp"
#include "judgement/tolerance.hpp"

namespace plumbline::judgement {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

/// A limit with the rule that sets it.
struct Asked {
  SurfaceLimit limit;
  const SurfaceRule* rule;
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
  return evaluate::conformance_probability(value - at.centre, sigma, at.half);
}

class Judge {
 public:
  Judge(const SurfacesT& surfaces, const std::map<std::string, bim::ElementFacts>& facts,
        const std::vector<SurfaceRule>& rules, double risk)
      : surfaces_(surfaces), facts_(facts), rules_(rules), risk_(risk), selected_(rules.size()) {}

  SurfaceJudgementT all() {
    result_.risk = risk_;
    std::map<std::string, std::vector<char>> by_panel;  // which rules select it
    for (const auto& panel : surfaces_.panels) {
      const std::vector<char> selects = selecting(*panel);
      for (const Asked& asked : asked_of(selects, false)) take(of_panel(*panel, asked));
      by_panel[panel->face->id] = selects;
    }
    for (const auto& joint : surfaces_.joints) {
      std::vector<char> either = by_panel[joint->first];
      const std::vector<char>& second = by_panel[joint->second];
      either.resize(rules_.size()), std::transform(second.begin(), second.end(), either.begin(), either.begin(),
                                                   [](char a, char b) { return a || b; });
      for (const Asked& asked : asked_of(either, true)) take(of_joint(*joint, asked));
    }
    for (size_t r = 0; r < rules_.size(); ++r) {
      auto request = std::make_unique<JudgementRequestT>();
      request->asked = rules_[r].text, request->by = "rule", request->panels = selected_[r];
      if (selected_[r] == 0) request->not_judged = "it selects no panel that was looked at";
      result_.requests.push_back(std::move(request));
    }
    return std::move(result_);
  }

 private:
  std::vector<char> selecting(const PanelSurfaceFiguresT& panel) {
    bim::ElementFacts element;
    const auto found = facts_.find(panel.face->guid);
    if (found != facts_.end())
      element = found->second;
    else
      element.name = panel.face->id, element.guid = panel.face->guid;
    std::vector<char> selects;
    for (size_t r = 0; r < rules_.size(); ++r) {
      selects.push_back(rules_[r].selection.matches(element));
      selected_[r] += selects.back();
    }
    return selects;
  }

  /// Later rules go before earlier ones, quantity by quantity.
  std::vector<Asked> asked_of(const std::vector<char>& selects, bool of_joints) const {
    std::vector<Asked> asked;
    for (size_t r = 0; r < selects.size(); ++r) {
      if (!selects[r]) continue;
      for (const SurfaceLimit& limit : rules_[r].limits) {
        if (is_of_joints(limit.quantity) != of_joints) continue;
        std::erase_if(asked, [&](const Asked& before) {
          const bool same_edge = std::isnan(limit.length) || std::abs(before.limit.length - limit.length) < 1e-9;
          return before.limit.quantity == limit.quantity && same_edge;
        });
        asked.push_back({limit, &rules_[r]});
      }
    }
    return asked;
  }

  static std::unique_ptr<SurfaceVerdictT> started(const Asked& asked) {
    auto verdict = std::make_unique<SurfaceVerdictT>();
    verdict->quantity = name_of(asked.limit.quantity), verdict->rule = asked.rule->text;
    verdict->length = asked.limit.length, verdict->lower = asked.limit.lower, verdict->upper = asked.limit.upper;
    return verdict;
  }

  std::unique_ptr<SurfaceVerdictT> of_panel(const PanelSurfaceFiguresT& panel, const Asked& asked) const {
    auto verdict = started(asked);
    verdict->panel = panel.face->id, verdict->guid = panel.face->guid;
    if (!panel.not_measured.empty()) {
      verdict->not_judged = panel.not_measured;
      return verdict;
    }
    if (asked.limit.quantity == SurfaceQuantity::flatness)
      flatness(panel, asked.limit, *verdict);
    else
      bend(panel, asked.limit, *verdict);
    return verdict;
  }

  void flatness(const PanelSurfaceFiguresT& panel, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    const auto gap = std::find_if(panel.flatness.begin(), panel.flatness.end(),
                                  [&](const auto& g) { return std::abs(g->length - limit.length) < 1e-6; });
    if (gap == panel.flatness.end()) {
      verdict.not_judged = "no straightedge of that length was laid; add it to 'straightedges' of surface.panels";
    } else if ((*gap)->positions == 0 || !std::isfinite((*gap)->gap)) {
      verdict.not_judged = "the panel has no place for a straightedge of that length with points all along it";
    } else {
      verdict.value = (*gap)->gap, verdict.sigma = (*gap)->sigma;
      verdict.probability = probability_of(verdict.value, verdict.sigma, limit);
      decide(verdict, verdict.probability, verdict.probability, risk_);
    }
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

  std::unique_ptr<SurfaceVerdictT> of_joint(const JointFiguresT& joint, const Asked& asked) const {
    auto verdict = started(asked);
    verdict->panel = joint.first, verdict->second = joint.second, verdict->looked_at = joint.looked_at;
    if (!joint.not_measured.empty()) {
      verdict->not_judged = joint.not_measured;
      return verdict;
    }
    double missed = 0, least = kInf;
    for (const auto& place : joint.places) {
      const bool step = asked.limit.quantity == SurfaceQuantity::step;
      const double nominal = asked.limit.quantity == SurfaceQuantity::joint ? joint.nominal_width : 0;
      const double value = step ? place->step : place->width - nominal,
                   sigma = step ? place->step_sigma : place->width_sigma;
      if (!std::isfinite(value) || !std::isfinite(sigma)) continue;
      const double probability = probability_of(value, sigma, asked.limit);
      ++verdict->places;
      missed += 1 - probability;
      if (probability >= least) continue;
      least = probability;
      verdict->value = value, verdict->sigma = sigma, verdict->along = place->along;
    }
    if (verdict->places == 0) {
      verdict->not_judged = asked.limit.quantity == SurfaceQuantity::step ? "one of its panels was not measured"
                                                                          : "no place along it was measured";
      return verdict;
    }
    verdict->probability = std::max(0.0, 1 - missed);
    decide(*verdict, verdict->probability, least, risk_ / verdict->places);
    return verdict;
  }

  void decide(SurfaceVerdictT& verdict, double kept, double at_worst, double fails_at) const {
    verdict.verdict = ToleranceVerdict::undecided;
    if (verdict_of(kept, risk_) == ToleranceVerdict::pass)
      verdict.verdict = ToleranceVerdict::pass;
    else if (at_worst <= fails_at)
      verdict.verdict = ToleranceVerdict::fail;
  }

  void take(std::unique_ptr<SurfaceVerdictT> verdict) {
    if (!verdict->not_judged.empty())
      ++result_.not_judged;
    else if (verdict->verdict == ToleranceVerdict::pass)
      ++result_.passed;
    else if (verdict->verdict == ToleranceVerdict::fail)
      ++result_.failed;
    else
      ++result_.undecided;
    result_.verdicts.push_back(std::move(verdict));
  }

  const SurfacesT& surfaces_;
  const std::map<std::string, bim::ElementFacts>& facts_;
  const std::vector<SurfaceRule>& rules_;
  double risk_;
  std::vector<int> selected_;
  SurfaceJudgementT result_;
};

}  // namespace

SurfaceJudgementT judge_surfaces(const SurfacesT& surfaces, const std::map<std::string, bim::ElementFacts>& facts,
                                 const std::vector<SurfaceRule>& rules, double risk) {
  return Judge(surfaces, facts, rules, risk).all();
}

}  // namespace plumbline::judgement

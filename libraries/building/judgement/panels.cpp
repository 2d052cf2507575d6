#include "building/judgement/panels.hpp"

#include <fmt/core.h>

#include <cmath>
#include <map>

#include "building/ifc/facade_artifact.hpp"
#include "building/ifc/limit_words.hpp"
#include "building/judgement/figures.hpp"
#include "building/judgement/panel_joints.hpp"
#include "building/judgement/panel_stack.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::judgement {
namespace {

void fill_fixings(const PanelCase& panel, const DeviationInputs& inputs,
                  const std::vector<std::unique_ptr<AnchorDeviationT>>& judged, const ifc::FacadeFrame& axes,
                  PanelDeviationT& out) {
  // An order that may be the wrong way round is none.
  const double order = axes.confirmed ? 1 : nan;
  for (const std::size_t anchor : panel.anchors) {
    const AnchorDeviationT& verdict = *judged[anchor];
    if (!verdict.deviation.allFinite()) {
      out.missing.push_back(verdict.id);
      continue;
    }
    auto fixing = std::make_unique<PanelFixingT>();
    fixing->anchor = verdict.id, fixing->guid = verdict.guid;
    fixing->shim = -order * axes.out.dot(verdict.deviation);
    fixing->sideways = -order * axes.right.dot(verdict.deviation);
    fixing->upward = -axes.up.dot(verdict.deviation);
    if (verdict.covariance.size() == 9) {
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> s(verdict.covariance.data());
      fixing->u_shim = std::sqrt(std::max(0.0, axes.out.dot(s * axes.out)));
    }
    const int floor = inputs.anchors[anchor].floor;
    if (floor > 0) out.floor = out.floor == 0 ? floor : std::min(out.floor, floor);
    out.fixings.push_back(std::move(fixing));
  }
}

void fill_limits(const Tolerances& tolerances, PanelDeviationT& out) {
  for (const auto& [axis, tolerance] : tolerances) {
    auto limit = std::make_unique<PanelLimitT>();
    limit->axis = name_of(axis), limit->above = tolerance.value, limit->below = tolerance.lower();
    limit->source = tolerance.source;
    out.limits.push_back(std::move(limit));
  }
}

/// A panel that faces nowhere that is known is not left out: it is listed, and undecided.
void fill_unknown(PanelDeviationT& out) {
  out.shift.setConstant(nan), out.rotation.setConstant(nan);
  for (std::unique_ptr<JudgedLengthT>* length :
       {&out.out_of_plane, &out.sideways, &out.vertical, &out.tilt, &out.warp, &out.misfit, &out.corner})
    *length = std::make_unique<JudgedLengthT>();
}

/// Share of a tolerance that a value uses; 0 where there is none.
double share_of(double value, double tolerance) {
  const double share = std::abs(value) / tolerance;
  return std::isnan(share) ? 0 : share;
}

/// The worst decides; of equal verdicts that which uses most of its tolerance.
class Decision {
 public:
  explicit Decision(PanelDeviationT& out) : out_(out) {}
  void consider(const char* by, ToleranceVerdict verdict, double usage, const std::string& reason) {
    if (verdict == ToleranceVerdict::not_measured || verdict < out_.verdict) return;
    if (verdict == out_.verdict && !(usage > usage_)) return;
    out_.verdict = verdict, out_.decided_by = by, out_.reason = reason, usage_ = usage;
  }
  void consider(const char* by, const char* words, const JudgedLengthT& length) {
    if (std::isfinite(length.value))
      consider(by, length.verdict, share_of(length.value, length.tolerance),
               words_of_length(words, length.value, length.tolerance));
  }

 private:
  PanelDeviationT& out_;
  double usage_ = -1;
};

/// At best UNDECIDED, at no tolerance better: something that it is held against nobody measured.
void hold(PanelDeviationT& out, const char* by, const std::string& why) {
  if (out.verdict < ToleranceVerdict::undecided)
    out.verdict = ToleranceVerdict::undecided, out.decided_by = by, out.reason = why;
  out.tau_pass = std::numeric_limits<double>::infinity();
}

/// Its anchors are in one line, and how it is turned about that moves corners that are judged.
void hold_open_turn(PanelDeviationT& out) {
  if (out.below)
    hold(out, "held_below", out.below->why);
  else
    hold(out, "anchors_in_line",
         "its " + std::to_string(out.fixings.size()) +
             " anchors are in one line: how it is turned about that is not known, nor how far its corners are out; "
             "where the panel below or a sill holds its bottom edge, held_below says so");
  out.pass_probability = nan;
}

/// What is found besides the panel itself.
struct Finding {
  bool open_turn = false;
  std::string doubt;  ///< of what holds it below; empty: none
};

void decide(PanelDeviationT& out, const std::map<std::string, const AnchorDeviationT*>& anchors,
            const Finding& finding) {
  // All its lengths at once, and the one that speaks for it.
  const ToleranceVerdict together = out.verdict;
  out.verdict = ToleranceVerdict::not_measured;
  Decision decision(out);
  decision.consider("out_of_plane", "out of plane", *out.out_of_plane);
  decision.consider("sideways", "sideways", *out.sideways);
  decision.consider("vertical", "height", *out.vertical);
  if (out.in_plane) decision.consider("in_plane", "in plane", *out.in_plane);
  decision.consider("tilt", "tilt at an anchor", *out.tilt);
  decision.consider("warp", "warp", *out.warp);
  decision.consider("misfit", "slots of the anchors", *out.misfit);
  decision.consider("corner", "corner out of plane", *out.corner);
  if (together != ToleranceVerdict::not_measured) out.verdict = std::max(out.verdict, together);
  for (const auto& joint : out.joints)
    decision.consider("joint", ("joint to " + (joint->name.empty() ? joint->panel : joint->name)).c_str(),
                      *joint->change);
  for (const auto& fixing : out.fixings) {
    const AnchorDeviationT& anchor = *anchors.at(fixing->anchor);
    if (anchor.verdict != ToleranceVerdict::not_measured)  // else it is held against nothing, or told as missing
      out.pass_probability = least_known(out.pass_probability, anchor.pass_probability);
    double usage = 0;
    std::string words;
    for (const auto& axis : anchor.axes)
      if (axis->axis == anchor.decided_by)
        usage = ifc::share_of_limits(*axis),
        words = words_of_length("anchor " + anchor.id + " " + axis->axis, axis->value, axis->tolerance);
    if (words.empty()) words = "anchor " + anchor.id + (anchor.note.empty() ? " is not decided" : ": " + anchor.note);
    if (anchor.verdict > ToleranceVerdict::pass) decision.consider("anchor", anchor.verdict, usage, words);
  }
  const bool confirmed = out.facade && out.facade->confirmed;
  if (!confirmed && out.verdict < ToleranceVerdict::undecided)
    out.verdict = ToleranceVerdict::undecided, out.decided_by = "facade",
    out.reason = out.facade && out.facade->out.allFinite() ? "not decided: " + out.facade->note
                                                           : "not judged: nothing says which way it faces";
  if (!out.missing.empty()) hold(out, "missing_anchor", "anchor " + out.missing.front() + " was not measured");
  // Its tilt, and what its corners do, nobody measured.
  if (!out.fixings.empty() && out.tilt && std::isnan(out.tilt->value)) {
    hold(out, "one_anchor",
         "its place is known from anchor " + out.fixings.front()->anchor +
             " alone, three of the six ways in which it can be off: how it is turned about that anchor is not known, "
             "nor where its corners are");
    out.pass_probability = nan;
  }
  if (finding.open_turn) hold_open_turn(out);
  if (!finding.doubt.empty()) hold(out, "held_below", finding.doubt);
}

}  // namespace

std::string words_of_length(const std::string& what, double value, double limit) {
  return fmt::format("{} {:.1f} mm (limit {:.3g} mm)", what, 1e3 * value, 1e3 * limit);
}

std::vector<std::unique_ptr<PanelDeviationT>> judge_panels(const DeviationInputs& inputs,
                                                           const judgement::DifferenceSet& deviations,
                                                           const std::vector<std::unique_ptr<AnchorDeviationT>>& judged,
                                                           const DeviationOptions& options) {
  std::vector<std::unique_ptr<PanelDeviationT>> result;
  std::map<std::size_t, std::size_t> position;
  for (std::size_t i = 0; i < deviations.size(); ++i) position[deviations.anchors[i]] = i;
  std::vector<std::unique_ptr<PanelDeviationT>> nowhere;  // face nowhere that is known
  std::vector<JudgedPanel> panels;
  panels.reserve(inputs.panels.size());
  for (const PanelCase& panel : inputs.panels) {
    stop_point();
    std::vector<std::size_t> own;
    for (const std::size_t anchor : panel.anchors)
      if (const auto found = position.find(anchor); found != position.end()) own.push_back(found->second);
    if (own.empty()) continue;
    auto out = std::make_unique<PanelDeviationT>();
    out->guid = panel.guid, out->name = panel.name, out->instance = panel.instance;
    out->storey_guid = panel.storey_guid, out->facade = ifc::to_artifact(panel.facade);
    fill_limits(panel.tolerances, *out);
    fill_fixings(panel, inputs, judged, panel.facade, *out);
    if (panel.facade.known()) {
      panels.emplace_back(panel, inputs, deviations, own, options);
      result.push_back(std::move(out));
    } else {
      fill_unknown(*out);
      nowhere.push_back(std::move(out));
    }
  }
  LengthBasis basis{deviations, {}};
  std::vector<Support> supports = hold_panels(panels, inputs, basis);
  std::vector<Finding> findings(panels.size());
  for (std::size_t i = 0; i < panels.size(); ++i) {
    stop_point();
    panels[i].fill(*result[i]);
    findings[i].open_turn = panels[i].turn_is_open();
    if (supports[i].told.by == "panel") findings[i].doubt = supports[i].doubt;
    if (!supports[i].told.by.empty()) result[i]->below = std::make_unique<PanelSupportT>(std::move(supports[i].told));
  }
  judge_joints(panels, basis, options, result);
  std::map<std::string, const AnchorDeviationT*> anchors;
  for (const auto& anchor : judged) anchors[anchor->id] = anchor.get();
  for (std::size_t i = 0; i < panels.size(); ++i) decide(*result[i], anchors, findings[i]);
  for (auto& panel : nowhere) decide(*panel, anchors, {}), result.push_back(std::move(panel));
  return result;
}

}  // namespace plumbline::judgement

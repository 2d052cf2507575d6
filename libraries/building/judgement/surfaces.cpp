#include "building/judgement/surfaces.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <set>
#include <stdexcept>

#include "building/judgement/surface_verdict.hpp"

namespace plumbline::judgement {
namespace {

/// What became of one limit of a rule.
struct Followed {
  int selected = 0, taken = 0;    ///< panels or joints it selects; verdicts by it, others have those of later rules
  std::vector<std::string> open;  ///< which of these are not judged
  std::string why;                ///< the first of them
  std::vector<const JointFiguresT*> by_design;  ///< which it is not asked of: the design has them outside of it
};

const char* const kBesideItsPlace =
    "what was measured of a facade lies beside its place alike, by more than is stated of that place: either the "
    "building does, or the place of the scan is known less well than was stated, and surveyed points tell which";

/// What all of the facade that looks there lie off by alike, that way [m]; 0: nothing stands out; nan: by what nobody
/// says.
double common_of(const SurfacesT& surfaces, const Eigen::Vector3d* out, double BesidePlaceT::*way) {
  const double same = std::cos(10 * M_PI / 180);
  if (surfaces.beside_its_place.empty()) return 0;
  if (surfaces.beside.empty() || !out) return std::numeric_limits<double>::quiet_NaN();
  for (const auto& beside : surfaces.beside)
    if (beside->facade.dot(*out) > same) return std::isfinite((*beside).*way) ? (*beside).*way : 0;
  return 0;
}

/// What an offset is judged from, further out by so much.
std::unique_ptr<PanelSurfaceFiguresT> moved(const PanelSurfaceFiguresT& panel, double out) {
  auto result = std::make_unique<PanelSurfaceFiguresT>();
  result->face = std::make_unique<SurfaceFaceT>(*panel.face);
  result->offset = panel.offset + out, result->tilt = panel.tilt, result->covariance = panel.covariance;
  result->coverage = panel.coverage, result->spacing = panel.spacing, result->covering_cell = panel.covering_cell;
  return result;
}

/// Either the building lies beside its place or the scan does, or both in part: a verdict holds that is the same at
/// both ends, of a failure on the same side. Between them the probability of keeping limits is no smaller than at one
/// of them, for it is logarithmically concave.
void decide_either_way(const SurfaceVerdictT& without, SurfaceVerdictT& verdict) {
  if (!verdict.not_judged.empty()) return;
  const bool same = verdict.verdict == without.verdict && without.not_judged.empty() &&
                    std::signbit(verdict.value) == std::signbit(without.value);
  if (same || (verdict.verdict == without.verdict && verdict.verdict == ToleranceVerdict::pass)) return;
  verdict.not_judged = kBesideItsPlace, verdict.verdict = ToleranceVerdict::not_measured;
}

/// An absolute limit that the design itself does not keep, of an expansion joint for one, says nothing of the building.
bool outside_by_design(const JointFiguresT& joint, const SurfaceLimit& limit) {
  constexpr double written = 5e-4;   // no design is meant to miss a limit by less [m]
  constexpr double no_joint = 2e-3;  // panels drawn up to each other: the design says nothing of their joint [m]
  if (!(joint.nominal_width > no_joint)) return false;
  if (limit.quantity != SurfaceQuantity::narrowest && limit.quantity != SurfaceQuantity::widest) return false;
  return joint.nominal_width < limit.lower - written || joint.nominal_width > limit.upper + written;
}

/// A limit with the rule that sets it.
struct Asked {
  SurfaceLimit limit;
  const SurfaceRule* rule;
  Followed* followed;  ///< what becomes of it
};

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
    for (size_t j = 0; j < surfaces_.joints.size(); ++j) take_joint(j, selecting_panel);
    for (size_t r = 0; r < rules_.size(); ++r) {
      auto request = std::make_unique<JudgementRequestT>();
      request->asked = rules_[r].text, request->by = "rule", request->panels = selected_[r];
      request->not_judged = open_of(r);
      result_.requests.push_back(std::move(request));
      tell_what_is_not_asked(r);
    }
    return std::move(result_);
  }

 private:
  /// Against the rules that select either of its panels.
  void take_joint(size_t j, const std::vector<std::vector<char>>& selecting_panel) {
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
    for (const Asked& asked : asked_of(either, true, &joint)) {
      const std::string doubt =
          shared ? "its panels share their names with others, and nobody says which it lies between" : doubt_of(ends);
      auto verdict = started(asked, joint);
      if (!doubt.empty())
        verdict->not_judged = doubt;
      else
        judge_joint_either_way(joint, asked.limit, *verdict);
      take(std::move(verdict), asked, static_cast<int>(j));
    }
  }

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
      } else if (followed.taken == 0 && !followed.by_design.empty()) {
        why = "the design has all of its joints outside of it";
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

  void tell_what_is_not_asked(size_t r) {
    for (size_t l = 0; l < asked_[r].size(); ++l) {
      const auto& joints = asked_[r][l].by_design;
      if (joints.empty() || asked_[r][l].taken == 0) continue;
      const SurfaceLimit& limit = rules_[r].limits[l];
      const double bound = limit.quantity == SurfaceQuantity::narrowest ? limit.lower : limit.upper;
      result_.remarks.push_back(fmt::format(
          "{} = {:g} mm is not asked of {} joint{} which the design itself has outside of it, {} | {} with {:.0f} mm "
          "for "
          "one: what is to hold there a rule of the width against the design's says (joint), or one for its panels",
          words_of(limit), 1e3 * bound, joints.size(), joints.size() > 1 ? "s" : "", joints[0]->first,
          joints[0]->second, 1e3 * joints[0]->nominal_width));
    }
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

  /// Later rules go before earlier ones, quantity by quantity; one that the design of the joint does not keep goes
  /// before none.
  std::vector<Asked> asked_of(const std::vector<char>& selects, bool of_joints, const JointFiguresT* joint = nullptr) {
    std::vector<Asked> asked, stated;
    for (size_t r = 0; r < selects.size(); ++r) {
      if (!selects[r]) continue;
      for (const SurfaceLimit& limit : rules_[r].limits) {
        const auto is_same = [&](const Asked& before) { return same_question(before.limit, limit); };
        if (is_of_joints(limit.quantity) != of_joints) continue;
        Followed& followed = asked_[r][&limit - rules_[r].limits.data()];
        ++followed.selected;
        std::erase_if(stated, is_same);
        stated.push_back({limit, &rules_[r], &followed});
        if (joint && outside_by_design(*joint, limit)) {
          followed.by_design.push_back(joint);
          continue;
        }
        std::erase_if(asked, is_same);
        asked.push_back(stated.back());
      }
    }
    refuse_contradictions(stated);
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
    judge_panel(surfaces_, panel, asked.limit, risk_, *verdict);
    const double common = asked.limit.quantity == SurfaceQuantity::offset
                              ? common_of(surfaces_, &panel.face->out, &BesidePlaceT::out)
                              : 0;
    if (common == 0) return verdict;
    SurfaceVerdictT without;
    if (std::isfinite(common)) judge_panel(surfaces_, *moved(panel, -common), asked.limit, risk_, without);
    decide_either_way(without, *verdict);
    return verdict;
  }

  void judge_joint_either_way(const JointFiguresT& joint, const SurfaceLimit& limit, SurfaceVerdictT& verdict) const {
    judge_joint(surfaces_, joint, limit, risk_, verdict);
    if (limit.quantity != SurfaceQuantity::shift) return;
    const bool numbered = joint.first_panel >= 0 && static_cast<size_t>(joint.first_panel) < surfaces_.panels.size();
    const double common = common_of(surfaces_, numbered ? &surfaces_.panels[joint.first_panel]->face->out : nullptr,
                                    joint.upright ? &BesidePlaceT::right : &BesidePlaceT::up);
    if (common == 0) return;
    SurfaceVerdictT without;
    SurfaceLimit moved = limit;  // as if all places lay by so much less
    moved.lower += common, moved.upper += common;
    if (std::isfinite(common)) judge_joint(surfaces_, joint, moved, risk_, without);
    without.value -= common;  // the limits were moved: the side on which it fails is that of the shift that is left
    decide_either_way(without, verdict);
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

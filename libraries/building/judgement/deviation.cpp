#include "building/judgement/deviation.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "building/ifc/doubt_words.hpp"
#include "building/ifc/facade_artifact.hpp"
#include "building/ifc/findings.hpp"
#include "building/judgement/deviation_shifts.hpp"
#include "building/judgement/difference.hpp"
#include "building/judgement/figures.hpp"
#include "building/judgement/panel_stack.hpp"
#include "building/judgement/panels.hpp"
#include "geometry/exchanged_places.hpp"
#include "geometry/median.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::judgement {
namespace {

using judgement::DifferenceSet;

/// Beyond this the points are in another frame, not badly built [m].
constexpr double kFarthestAnchor = 1.0;

/// A common tolerance at which nothing passes [m].
constexpr double kAtNone = std::numeric_limits<double>::infinity();

struct Work {
  const DeviationInputs& inputs;
  const DeviationOptions& options;
  DeviationT out;
  DifferenceSet deviations;
  /// What the design asks for in vain, by the request and the reason.
  std::map<std::pair<std::string, std::string>, Request> refused;
};

std::unique_ptr<AnchorDeviationT> row_of(const AnchorCase& anchor) {
  auto row = std::make_unique<AnchorDeviationT>();
  row->id = anchor.id, row->guid = anchor.element.guid, row->name = anchor.element.name, row->tag = anchor.element.tag;
  row->class_ = anchor.element.ifc_class, row->instance = anchor.instance, row->storey_guid = anchor.storey_guid;
  row->found_by = anchor.found_by, row->reference_point_rule = anchor.reference_point_rule;
  row->floor = anchor.floor, row->column = anchor.column, row->use = anchor.use;
  if (!anchor.element.guid.empty()) row->facade = ifc::to_artifact(anchor.facade);
  row->design = anchor.design, row->target_offset = anchor.target_offset, row->note = anchor.note;
  row->as_built.setConstant(AnchorCase::nan), row->deviation.setConstant(AnchorCase::nan);
  return row;
}

/// `model`: of the inputs; its covariance goes to the deviations.
void judge_anchors(Work& work, PointSet& model) {
  const auto index = judgement::index_points(model, "model");
  std::vector<std::size_t> places;
  std::set<std::string> ids;
  for (std::size_t i = 0; i < work.inputs.anchors.size(); ++i) {
    const AnchorCase& anchor = work.inputs.anchors[i];
    stop_point();
    if (!ids.insert(anchor.id).second)
      throw std::runtime_error("the anchor '" + anchor.id + "' occurs twice; ids must be unique");
    auto row = row_of(anchor);
    const auto found = index.find(anchor.id);
    const bool measured = found != index.end() && model.positions[found->second].allFinite();
    Eigen::MatrixXd covariance;
    if (measured) {
      row->as_built = model.positions[found->second];
      covariance = block_of(model.covariance, found->second);
      if (covariance.size() > 0) covariance += anchor.mounting;
    }
    const Eigen::Vector3d deviation = row->as_built - anchor.design;
    judge_anchor(deviation, covariance, anchor.facade, anchor.tolerances, work.options, *row);
    if (deviation.allFinite()) {
      work.deviations.anchors.push_back(i);
      places.push_back(found->second);
    } else if (row->note.empty()) {
      row->note = measured ? "no element of the design fits" : "not measured";
    }
    work.out.anchors.push_back(std::move(row));
  }
  const auto n = static_cast<Eigen::Index>(places.size());
  work.deviations.difference.resize(3 * n);
  for (Eigen::Index i = 0; i < n; ++i)
    work.deviations.difference.segment<3>(3 * i) = work.out.anchors[work.deviations.anchors[i]]->deviation;
  if (model.covariance.size() == 0) return;
  work.deviations.covariance = std::move(model.covariance).subset(places);
  model.covariance = {};
  if (work.inputs.common_unknown && n > 0) {
    Eigen::Matrix3d common = Eigen::Matrix3d::Zero();
    for (Eigen::Index i = 0; i < n; ++i) common += work.deviations.covariance.block(i, i) / static_cast<double>(n);
    work.deviations.covariance.set_common(common);
  }
  for (Eigen::Index i = 0; i < n; ++i)
    work.deviations.covariance.add(i, work.inputs.anchors[work.deviations.anchors[i]].mounting);
}

/// Neither in order nor out of tolerance, at whatever tolerance.
template <typename Judged>
void leave_open(Judged& judged) {
  if (judged.verdict != ToleranceVerdict::not_measured) judged.verdict = ToleranceVerdict::undecided;
}

template <typename Row>
void leave_row_open(Row& row) {
  leave_open(row);
  row.tau_pass = kAtNone, row.tau_fail = 0;
}

/// A measurement that contradicts itself shows no anchor to be in order, and none to be out of tolerance; no axis
/// either.
void take_doubts(Work& work) {
  for (const MeasurementDoubtT& doubt : work.inputs.doubts)
    work.out.doubts.push_back(std::make_unique<MeasurementDoubtT>(doubt));
  if (work.out.doubts.empty()) return;
  const std::string why = "not decided: " + ifc::in_words(*work.out.doubts.front());
  for (auto& anchor : work.out.anchors) {
    if (anchor->verdict == ToleranceVerdict::not_measured) continue;
    leave_row_open(*anchor);
    for (auto& axis : anchor->axes) leave_open(*axis);
    anchor->note += (anchor->note.empty() ? "" : "; ") + why;
  }
}

/// The same of panels, their lengths and joints; an order that rests on it is none.
void take_doubts_of_panels(Work& work) {
  if (work.out.doubts.empty()) return;
  for (auto& panel : work.out.panels) {
    panel->verdict = ToleranceVerdict::undecided;
    leave_row_open(*panel);
    panel->decided_by = "doubt", panel->reason = "not decided: " + ifc::in_words(*work.out.doubts.front());
    for (auto* length : {panel->out_of_plane.get(), panel->sideways.get(), panel->vertical.get(), panel->tilt.get(),
                         panel->warp.get(), panel->misfit.get(), panel->corner.get()})
      leave_open(*length);
    if (panel->in_plane) leave_open(*panel->in_plane);
    for (auto& joint : panel->joints) leave_open(*joint->change);
    for (auto& fixing : panel->fixings) fixing->shim = fixing->sideways = fixing->upward = AnchorCase::nan;
  }
}

/// What was asked for an anchor or a panel and cannot be judged leaves it undecided at best, at any tolerance.
template <typename Case, typename Row>
void refuse(const Case& asked, Row& row, std::map<std::pair<std::string, std::string>, Request>& requests, bool panel) {
  for (const ifc::NotApplied& refusal : asked.refused) {
    Request& request = requests[{refusal.asked, refusal.reason}];
    request.asked = refusal.asked, request.by = refusal.by, request.not_judged = refusal.reason;
    ++(panel ? request.panels : request.anchors);
  }
  if (asked.refused.empty()) return;
  row.tau_pass = kAtNone;
  if (row.verdict == ToleranceVerdict::pass) row.verdict = ToleranceVerdict::undecided, row.decided_by = "not_judged";
}

std::string in_words(const ifc::NotApplied& refusal) { return "not judged: " + refusal.asked + ": " + refusal.reason; }

/// Before panels are judged: none is better than its anchors.
void refuse_anchors(Work& work) {
  for (std::size_t i = 0; i < work.inputs.anchors.size(); ++i) {
    AnchorDeviationT& row = *work.out.anchors[i];
    refuse(work.inputs.anchors[i], row, work.refused, false);
    for (const ifc::NotApplied& refusal : work.inputs.anchors[i].refused)
      row.note += (row.note.empty() ? "" : "; ") + in_words(refusal);
  }
}

/// Everything that was asked for, judged or not.
void list_requests(Work& work) {
  std::map<std::string, const PanelCase*> panels;
  for (const PanelCase& panel : work.inputs.panels) panels[panel.guid] = &panel;
  std::set<std::string> judged;
  for (auto& row : work.out.panels) {
    const PanelCase& panel = *panels.at(row->guid);
    refuse(panel, *row, work.refused, true);
    if (row->decided_by == "not_judged") row->reason = in_words(panel.refused.front());
    judged.insert(row->guid);
  }
  std::vector<Request> all = work.inputs.requests;
  for (auto& [text, request] : work.refused) all.push_back(std::move(request));
  std::vector<std::string> names;
  for (const PanelCase& panel : work.inputs.panels)
    if (!judged.contains(panel.guid)) names.push_back(panel.name.empty() ? panel.guid : panel.name);
  if (!names.empty()) {
    all.push_back({"panels " + list_of(names, 4), ifc::kUnmeasuredPanels, 0, static_cast<int>(names.size()),
                   "none of their anchors was measured"});
  }
  const std::size_t unbuilt = work.options.grows && !names.empty() ? all.size() - 1 : all.size();
  for (const Request& request : all) {
    auto to = std::make_unique<JudgementRequestT>();
    to->asked = request.asked, to->by = request.by, to->not_judged = request.not_judged;
    to->anchors = request.anchors, to->panels = request.panels;
    work.out.not_judged += !request.not_judged.empty() && &request != all.data() + unbuilt;
    work.out.requests.push_back(std::move(to));
  }
}

/// Anchors that were measured where the design has another one: plates or names were exchanged.
void find_exchanged(Work& work) {
  std::vector<Eigen::Vector3d> found, expected;
  for (const std::size_t i : work.deviations.anchors)
    found.push_back(work.out.anchors[i]->as_built), expected.push_back(work.out.anchors[i]->design);
  for (const ExchangedPlace& pair : exchanged_places(found, expected)) {
    const auto id = [&](std::size_t k) -> const std::string& {
      return work.out.anchors[work.deviations.anchors[k]]->id;
    };
    const std::string &one = id(pair.thing), &other = id(pair.place);
    work.out.warnings.push_back(pair.mutual ? one + " and " + other +
                                                  " were measured in each other's place: their plates are exchanged in "
                                                  "the plate table, or on the facade."
                                            : one + " was measured where the design has " + other +
                                                  ": check which plate is which.");
  }
}

void require_same_frame(const Work& work) {
  std::vector<double> lengths;
  for (const auto& anchor : work.out.anchors)
    if (anchor->deviation.allFinite()) lengths.push_back(anchor->deviation.norm());
  if (lengths.empty()) return;
  const double median = upper_median(std::move(lengths));
  if (median < kFarthestAnchor) return;
  throw std::runtime_error("the measured anchors lie " + std::to_string(median) +
                           " m (median) from their design positions in " + work.inputs.design_file +
                           ": they are not in the frame of the design; 'frames.to_building' brings a survey there");
}

/// The lowest floor of a panel's anchors, which the plate table or their storeys tell; else that of its own storey.
void set_floors_of_panels(Work& work, const std::map<std::string, int>& floor_of) {
  std::map<std::string, int> floor_of_anchor;
  for (const auto& anchor : work.out.anchors) floor_of_anchor[anchor->id] = anchor->floor;
  for (auto& panel : work.out.panels) {
    const auto consider = [&](const std::string& anchor) {
      const int floor = floor_of_anchor[anchor];
      if (floor > 0) panel->floor = panel->floor == 0 ? floor : std::min(panel->floor, floor);
    };
    for (const auto& fixing : panel->fixings) consider(fixing->anchor);
    for (const std::string& missing : panel->missing)
      if (panel->floor == 0) consider(missing);
    if (panel->floor != 0) continue;
    if (const auto floor = floor_of.find(panel->storey_guid); floor != floor_of.end()) panel->floor = floor->second;
  }
}

/// What is missed at most, as a probability that nothing is; nan stays nan.
double at_least(double missed) { return missed > 1 ? 0 : 1 - missed; }

/// The storey of each floor by their numbers. Floors are numbers in the plate table and storeys in the design: each
/// anchor that has both votes. `names`: of the storeys, by GlobalId.
std::map<int, std::string> storeys_of_floors(Work& work, std::map<std::string, std::string>& names) {
  std::map<int, std::map<std::string, int>> votes;
  for (std::size_t i = 0; i < work.inputs.anchors.size(); ++i) {
    const AnchorCase& anchor = work.inputs.anchors[i];
    names[anchor.storey_guid] = anchor.element.storey;
    if (!anchor.use.empty() && anchor.floor > 0 && !anchor.storey_guid.empty())
      ++votes[anchor.floor][anchor.storey_guid];
  }
  std::map<std::string, std::vector<int>> floors_of_storey;
  std::map<int, std::string> storey_of;
  for (const auto& [floor, storeys] : votes) {
    const auto winner = std::max_element(storeys.begin(), storeys.end(),
                                         [](const auto& a, const auto& b) { return a.second < b.second; });
    storey_of[floor] = winner->first;
    floors_of_storey[winner->first].push_back(floor);
  }
  for (const auto& [storey, floors] : floors_of_storey) {
    if (floors.size() < 2) continue;
    work.out.warnings.push_back(
        std::to_string(floors.size()) + " floors of the plate table have their anchors in one storey of " +
        work.inputs.design_file + " ('" + names[storey] +
        "'): the statistics of these floors are in the report, not in the storeys of the as-built IFC.");
    for (const int floor : floors) storey_of.erase(floor);
  }
  return storey_of;
}

void count(const AnchorDeviationT& anchor, FloorDeviationT& floor) {
  ++(anchor.verdict == ToleranceVerdict::pass        ? floor.passed
     : anchor.verdict == ToleranceVerdict::fail      ? floor.failed
     : anchor.verdict == ToleranceVerdict::undecided ? floor.undecided
                                                     : floor.not_measured);
}

void count(const PanelDeviationT& panel, FloorDeviationT& floor) {
  ++(panel.verdict == ToleranceVerdict::pass   ? floor.panels_passed
     : panel.verdict == ToleranceVerdict::fail ? floor.panels_failed
                                               : floor.panels_undecided);
}

void set_verdict(FloorDeviationT& floor) {
  if (floor.failed + floor.panels_failed > 0)
    floor.verdict = ToleranceVerdict::fail;
  else if (floor.undecided + floor.panels_undecided > 0 || (floor.not_measured > 0 && floor.passed > 0))
    floor.verdict = ToleranceVerdict::undecided;
  else if (floor.passed > 0)
    floor.verdict = ToleranceVerdict::pass;
}

void judge_floors(Work& work) {
  std::map<std::string, std::string> names;
  const std::map<int, std::string> storey_of = storeys_of_floors(work, names);
  // Anchors that the plate table does not list stand on the floor of their storey.
  std::map<std::string, int> floor_of;
  for (const auto& [floor, storey] : storey_of) floor_of[storey] = floor;
  std::map<int, std::unique_ptr<FloorDeviationT>> floors;
  const auto floor_at = [&](int number) -> FloorDeviationT& {
    auto& entry = floors[number];
    if (!entry) {
      entry = std::make_unique<FloorDeviationT>();
      entry->floor = number;
      if (const auto storey = storey_of.find(number); storey != storey_of.end())
        entry->storey_guid = storey->second, entry->storey = names[storey->second];
    }
    return *entry;
  };
  std::map<int, double> missed;  // bound of the probability that one of the floor is out of tolerance
  for (auto& anchor : work.out.anchors) {
    if (anchor->floor == 0)
      if (const auto floor = floor_of.find(anchor->storey_guid); floor != floor_of.end()) anchor->floor = floor->second;
    FloorDeviationT& floor = floor_at(anchor->floor);
    missed[anchor->floor] += 1 - anchor->pass_probability;
    count(*anchor, floor);
  }
  set_floors_of_panels(work, floor_of);
  for (const auto& panel : work.out.panels) {
    FloorDeviationT& floor = floor_at(panel->floor);
    missed[panel->floor] += 1 - panel->pass_probability;
    count(*panel, floor);
  }
  for (auto& [number, floor] : floors) {
    set_verdict(*floor);
    if (work.out.doubts.empty()) floor->pass_together = at_least(missed[number]);
    work.out.floors.push_back(std::move(floor));
  }
}

void summarise(Work& work) {
  DeviationT& out = work.out;
  int panels_failed = 0, panels_open = 0;
  double missed = 0;
  for (const auto& anchor : out.anchors) missed += 1 - anchor->pass_probability;
  for (const auto& panel : out.panels) missed += 1 - panel->pass_probability;
  if (!out.anchors.empty() && out.doubts.empty()) out.pass_together = at_least(missed);
  for (const auto& floor : out.floors) {
    out.passed += floor->passed, out.undecided += floor->undecided, out.failed += floor->failed;
    out.not_measured += floor->not_measured;
    panels_failed += floor->panels_failed, panels_open += floor->panels_undecided;
  }
  if (out.failed + panels_failed > 0)
    out.verdict = ToleranceVerdict::fail;
  else if (out.undecided + panels_open > 0 ||
           ((out.not_measured > 0 || out.not_judged > 0 || out.panels.size() < work.inputs.panels.size()) &&
            out.passed > 0))
    out.verdict = ToleranceVerdict::undecided;
  else if (out.passed > 0)
    out.verdict = ToleranceVerdict::pass;
  for (const auto& anchor : out.anchors)
    if (anchor->verdict == ToleranceVerdict::pass && !(anchor->pass_probability >= out.weakest_pass))
      out.weakest_pass = anchor->pass_probability;
}

void warn_of_facades(Work& work) {
  std::vector<ifc::FacadeMember> members;
  for (const AnchorCase& anchor : work.inputs.anchors)
    if (!anchor.element.guid.empty()) members.push_back({anchor.facade.facade, anchor.element, &anchor.facade});
  for (const PanelCase& panel : work.inputs.panels) {
    ifc::FacadeMember member{panel.facade.facade, {}, &panel.facade};
    member.element.guid = panel.guid, member.element.name = panel.name;
    members.push_back(std::move(member));
  }
  for (std::string& warning : ifc::facade_warnings(work.inputs.facades, members))
    work.out.warnings.push_back(std::move(warning));
}

void warn_of_gaps(Work& work) {
  std::vector<std::string> homeless;
  for (const auto& anchor : work.out.anchors)
    if (anchor->guid.empty()) homeless.push_back(anchor->id);
  if (!homeless.empty()) {
    std::string names;
    for (std::size_t i = 0; i < std::min<std::size_t>(homeless.size(), 5); ++i) names += (i ? ", " : "") + homeless[i];
    work.out.warnings.push_back(std::to_string(homeless.size()) + " anchors of the plate table are no element of " +
                                work.inputs.design_file + " and were not judged: " + names +
                                (homeless.size() > 5 ? ", …" : "") + ".");
  }
  std::vector<std::string> unlisted;
  bool any_listed = false;
  for (std::size_t i = 0; i < work.inputs.anchors.size(); ++i) {
    any_listed |= work.inputs.anchors[i].listed;
    if (!work.inputs.anchors[i].listed && work.out.anchors[i]->deviation.allFinite())
      unlisted.push_back(work.out.anchors[i]->id);
  }
  if (any_listed && !unlisted.empty())
    work.out.warnings.push_back(fmt::format(
        "Measured and not in the plate table: {}. Judged on no floor, with what is said of mountings and no "
        "plate's own.",
        list_of(unlisted, 5)));
  if (work.deviations.size() > 0 && work.deviations.covariance.size() == 0)
    work.out.warnings.push_back(
        "The model has no covariance: without uncertainty nothing can pass or fail, every verdict is undecided.");
}

}  // namespace

DeviationT judge_deviations(DeviationInputs inputs, const DeviationOptions& options) {
  if (!(options.tau > 0) || !(options.risk > 0 && options.risk < 0.5))
    throw std::runtime_error("the tolerance must be positive and the risk between 0 and 0.5");
  Work work{inputs, options, {}, {}, {}};
  work.out.tau = options.tau, work.out.risk = options.risk;
  work.out.mounting = inputs.mounting;
  work.out.misfit_factor = inputs.misfit_factor;
  for (const MeasurementDoubtT& misfit : inputs.misfits)
    work.out.misfits.push_back(std::make_unique<MeasurementDoubtT>(misfit));
  work.out.design_file = inputs.design_file;
  for (const ifc::Facade& facade : inputs.facades) work.out.facades.push_back(ifc::to_artifact(facade));
  judge_anchors(work, inputs.model);
  require_same_frame(work);
  refuse_anchors(work);
  take_doubts(work);
  find_exchanged(work);
  work.out.panels = judge_panels(inputs, work.deviations, work.out.anchors, options);
  work.out.warnings.insert(work.out.warnings.end(), inputs.warnings.begin(), inputs.warnings.end());
  for (std::string& warning : support_warnings(work.out.panels)) work.out.warnings.push_back(std::move(warning));
  take_doubts_of_panels(work);
  list_requests(work);
  judge_floors(work);
  summarise(work);
  warn_of_facades(work);
  warn_of_gaps(work);
  tell_shifts(inputs, options, work.deviations, work.out);
  return std::move(work.out);
}

}  // namespace plumbline::judgement

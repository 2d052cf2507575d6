// The first screen: can we install, where not and what to do, how sure.
#include <algorithm>
#include <cmath>

#include "building/ifc/doubt_words.hpp"
#include "building/ifc/facade_artifact.hpp"
#include "building/ifc/limit_words.hpp"
#include "building/ifc/surface_words.hpp"
#include "building/judgement/deviation.hpp"
#include "building/judgement/epochs.hpp"
#include "show/report/exact_lengths.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// What fits on the first screen; the rest is folded.
constexpr std::size_t kFirstRows = 8;
/// Of thousands, what is listed with words of what to do.
constexpr std::size_t kMostTasks = 308;

/// "+7.6 ± 0.4 mm, limit 5.0"; only up and outward have a sign, and outward where it is confirmed.
std::string found_on(const JudgedAxisT& axis, bool outward_known) {
  const bool directed = axis.axis == "vertical" || (axis.axis == "out_of_plane" && outward_known);
  const int decimals = decimals_beside(std::abs(axis.value), axis.tolerance, 1);
  std::string text = directed ? signed_mm(axis.value, decimals) : mm(axis.value, decimals);
  if (std::isfinite(axis.u)) text += " ± " + mm(axis.u, decimals);
  return text + "\u00A0mm, limit " + ifc::limits_in_words(axis, [&](double limit) { return mm(limit, decimals); });
}

/// "6.9 mm inward, 2.1 mm to the right, 1.2 mm down": the way back to the design. Where which way is outward is not
/// confirmed, along the axes of the design: nobody is sent the wrong way.
std::string way_back(const AnchorDeviationT& anchor) {
  std::string text;
  const Eigen::Vector3d back = -anchor.deviation;
  const auto part = [&](double length, const char* positive, const char* negative) {
    if (!(std::abs(length) >= 0.5e-3)) return;
    text += (text.empty() ? "" : ", ") + to_set(length) + " " + (length > 0 ? positive : negative);
  };
  const FacadeFrameT* frame = anchor.facade && anchor.facade->confirmed ? anchor.facade.get() : nullptr;
  const bool steep = frame && std::abs(frame->out.z()) > 0.7;  // a soffit or a roof
  if (frame && !steep) {
    part(frame->out.dot(back), "outward", "inward");
    part(frame->right.dot(back), "to the right", "to the left");
    part(frame->up.dot(back), "up", "down");
  } else {
    part(back.x(), "in +x", "in −x");
    part(back.y(), "in +y", "in −y");
    part(back.z(), "up", "down");
  }
  return text;
}

/// The uncertainty of an axis [mm] below which the anchor is decided if all of its covariance shrinks alike; 0 if it is
/// not decided so. Found by halving the range of the factor: the verdict goes by all axes at once.
double deciding_u(const AnchorDeviationT& anchor, const JudgedAxisT& axis, const DeviationT& deviation) {
  if (anchor.covariance.size() != 9) return 0;
  const Eigen::Matrix3d covariance =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(anchor.covariance.data());
  judgement::Tolerances tolerances;
  for (const auto& judged : anchor.axes)
    for (const judgement::Axis kind : judgement::kAxes)
      if (judged->axis == judgement::name_of(kind) && std::isfinite(judged->above))
        tolerances[kind] = {judged->above, judged->source, judged->below};
  const ifc::FacadeFrame frame = ifc::frame_or_none(anchor.facade);
  const auto decided = [&](double factor) {
    AnchorDeviationT judged;
    judgement::judge_anchor(anchor.deviation, factor * factor * covariance, frame, tolerances,
                            {deviation.tau, deviation.risk}, judged);
    return judged.verdict != ToleranceVerdict::undecided;
  };
  double least = 0.02, most = 1;  // less than a fiftieth of what it is no other measurement brings
  if (!decided(least) || decided(most)) return 0;
  for (int i = 0; i < 10; ++i) {  // to a thousandth: what is told has two digits, and there may be thousands of anchors
    const double middle = 0.5 * (least + most);
    (decided(middle) ? least : most) = middle;
  }
  return std::floor(1e5 * least * axis.u) / 100;  // never more than it takes
}

/// A line of the work list.
struct Task {
  int floor;
  ToleranceVerdict verdict;
  std::string what, found, todo, facade = {}, of_facade = {};  ///< the second also of the only one
};

Task task_of(const AnchorDeviationT& anchor, const DeviationT& deviation) {
  Task task{anchor.floor, anchor.verdict, "Anchor " + anchor.id, "", ""};
  const JudgedAxisT* axis = deciding_axis(anchor);
  if (!axis) {
    task.found = anchor.note.empty() ? "not measured" : anchor.note;
    task.todo = anchor.decided_by == "not_judged" ? "Give what it asks for as a length with its unit, or a rule for it."
                                                  : "Measure it.";
    return task;
  }
  const bool lost = !anchor.facade || !anchor.facade->confirmed;
  task.found = words_of(axis->axis) + " " + found_on(*axis, !lost);
  const std::string way = way_back(anchor);
  if (!deviation.doubts.empty()) {
    task.todo = "Nothing before the measurement is mended: it decides nothing.";
    return task;
  }
  if (anchor.verdict == ToleranceVerdict::fail && lost) {
    task.todo = "Not decided which way is outward: confirm the facade first. Back to the design along its axes: " +
                (way.empty() ? "nowhere" : way) + ".";
  } else if (lost && (axis->axis == "in_plane" || axis->axis == "out_of_plane")) {
    task.todo = "Say which way its facade faces" +
                (anchor.facade && !anchor.facade->note.empty() ? ": " + anchor.facade->note : "") + ".";
  } else if (anchor.verdict == ToleranceVerdict::fail) {
    task.todo = "Reset or shim: " + (way.empty() ? "back to design" : way) + ".";
  } else if (!std::isfinite(axis->u)) {
    task.todo = "Its uncertainty is not known: measure with one.";
  } else {
    const double needed = deciding_u(anchor, *axis, deviation);
    if (needed > 0) task.todo = "Measure again: decided once u is below " + mm(1e-3 * needed) + "\u00A0mm";
    if (!way.empty()) task.todo += (task.todo.empty() ? "Set it " : "; or set it ") + way;
    task.todo += task.todo.empty() ? "At the limit: no better measurement decides it." : ".";
  }
  return task;
}

Task task_of(const PanelDeviationT& panel, const DeviationT& deviation) {
  Task task{panel.floor, panel.verdict, "Panel " + (panel.name.empty() ? panel.guid : panel.name),
            reason_of(panel, deviation), ""};
  if (!deviation.doubts.empty()) {
    task.todo = "Nothing before the measurement is mended: it decides nothing.";
    return task;
  }
  if (!panel.missing.empty() && panel.decided_by == "missing_anchor") {
    task.todo = "Measure " + panel.missing.front() + ".";
    return task;
  }
  if (panel.decided_by == "one_anchor") {
    task.todo = "Measure a second place of it, or see with a level how it is turned.";
    return task;
  }
  if (panel.decided_by == "anchors_in_line") {
    task.todo = "Measure a place of it beside the line of its anchors, or see with a level how it is turned about it.";
    return task;
  }
  if (panel.decided_by == "held_below") {
    task.todo = panel.below && !panel.below->panel.empty()
                    ? "First measure what it stands on."
                    : "Say what holds its bottom edge and how well, or see with a level how it is turned about the "
                      "line of its anchors.";
    return task;
  }
  if (!panel.facade || !panel.facade->confirmed) {
    task.todo = "Say which way its facade faces before anything is shimmed.";
    return task;
  }
  std::string outward, inward;
  for (const auto& fixing : panel.fixings) {
    if (!(std::abs(fixing->shim) >= 0.5e-3)) continue;
    std::string& list = fixing->shim > 0 ? outward : inward;
    list += (list.empty() ? "" : ", ") + fixing->anchor + "\u00A0" + mm(std::abs(fixing->shim), 1) +
            in_fractions(fixing->shim);
  }
  if (!outward.empty()) task.todo = "Shim outward " + outward + "\u00A0mm";
  if (!inward.empty()) task.todo += std::string(outward.empty() ? "Set" : "; set") + " inward " + inward + "\u00A0mm";
  task.todo = task.todo.empty() ? "Its anchors are in plane: adjust along the facade." : task.todo + ".";
  return task;
}

Task task_of(const SurfaceVerdictT& verdict, const DeviationT& deviation) {
  Task task{0, verdict.verdict, (verdict.second.empty() ? "Surface " : "Joint ") + surface_name(verdict), "", ""};
  for (const auto& panel : deviation.panels)
    if (panel->guid == verdict.guid) task.floor = panel->floor;
  task.found = ifc::quantity_of(verdict) + " " + mm(verdict.value, 1) + " ± " + mm(verdict.sigma, 1) +
               "\u00A0mm, limit " + surface_limit(verdict);
  if (std::isfinite(verdict.along) && !verdict.second.empty())
    task.found += ", " + fixed(std::abs(verdict.along), 2) + "\u00A0m " + (verdict.along < 0 ? "before" : "behind") +
                  " the joint's middle";
  if (!deviation.doubts.empty())
    task.todo = "Nothing before the measurement is mended: it decides nothing.";
  else if (verdict.verdict == ToleranceVerdict::undecided)
    task.todo = "Too close to call: measure again, from nearer or in more photographs.";
  else if (verdict.second.empty())
    task.todo = "The panel itself is out of shape: replace it or have it accepted.";
  else
    task.todo = "Set one of the two panels anew.";
  return task;
}

std::vector<Task> tasks_of(const ReportInput& input) {
  const DeviationT& deviation = *input.deviation;
  std::vector<Task> tasks;
  const auto open = [](ToleranceVerdict verdict) { return verdict != ToleranceVerdict::pass; };
  // Of a building of several facades whoever is sent somewhere is told to which.
  const auto add = [&](const auto& element) {
    tasks.push_back(task_of(element, deviation));
    tasks.back().of_facade = facade_of(element.facade);
    if (deviation.facades.size() > 1 && element.facade)
      tasks.back().facade = element.facade->facade.empty() ? unknown : element.facade->facade;
  };
  for (const ToleranceVerdict wanted :
       {ToleranceVerdict::fail, ToleranceVerdict::undecided, ToleranceVerdict::not_measured}) {
    for (const AnchorDeviationT* anchor : worst_first(deviation))
      if (anchor->verdict == wanted && open(wanted)) {
        add(*anchor);
        if (const std::string place = place_in_grid(input, anchor->design); !place.empty())
          tasks.back().what += " at " + place;
      }
    for (const PanelDeviationT* panel : worst_panels_first(deviation))
      if (panel->verdict == wanted && open(wanted)) add(*panel);
    if (deviation.surfaces)
      for (const SurfaceVerdictT* verdict : worst_surfaces_first(*deviation.surfaces))
        if (verdict->verdict == wanted) tasks.push_back(task_of(*verdict, deviation));
  }
  return tasks;
}

void write_tasks(Markup& html, const std::vector<Task>& tasks, std::size_t from, std::size_t to) {
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", from == 0 ? "tasks" : "tasks sortable"}});
  const bool facades = std::any_of(tasks.begin(), tasks.end(), [](const Task& t) { return !t.facade.empty(); });
  std::vector<Cell> heads = {left("Where"), "Floor", left("Verdict"), left("Found"), left("To do")};
  if (facades) heads.insert(heads.begin() + 1, left("Facade"));
  table_head(html, heads);
  Scope body(html, "tbody");
  for (std::size_t i = from; i < to; ++i) {
    const Task& task = tasks[i];
    const PlacedRow row(html, task.floor, task.of_facade, task.verdict);
    html.element("th", {{"scope", "row"}}, task.what);
    if (facades) html.element("td", {{"class", "words"}}, task.facade.empty() ? unknown : verbatim(task.facade));
    html.element("td", {{"data-head", "Floor"}}, task.floor > 0 ? std::to_string(task.floor) : unknown);
    {
      Scope td(html, "td", {{"class", "text"}});
      verdict_badge(html, task.verdict);
    }
    html.element("td", {{"class", "words"}}, task.found);
    html.element("td", {{"class", "words todo"}}, task.todo);
  }
}

/// How sure: the guard band, the weakest pass, and whether the model itself stands.
std::vector<std::string> confidence_of(const ReportInput& input) {
  const DeviationT& d = *input.deviation;
  std::vector<std::string> lines;
  for (const auto& doubt : d.doubts) lines.push_back("Not to be trusted, " + ifc::in_words(*doubt) + ".");
  if (!d.datum.empty()) lines.push_back(d.datum);
  std::string sure = "Pass means that all that is judged of it is within tolerance at once, with a probability of " +
                     percent(1 - d.risk) + " or more; fail, with one of " + percent(d.risk) + " or less.";
  sure +=
      d.mounting.empty()
          ? " Plates are taken to sit on their anchors without error."
          : " Its uncertainty holds where the plate sits on its anchor, which nothing measures: " + d.mounting + ".";
  if (std::isfinite(d.weakest_pass))
    sure += " The weakest pass is in order with a probability of " + percent(d.weakest_pass) + ".";
  if (d.pass_together > 0)
    sure +=
        " Each anchor and panel is judged by itself, and a floor by its worst: that all of them are within "
        "tolerance at once has a probability of at least " +
        percent(d.pass_together) + ".";
  lines.push_back(sure);
  const AccuracyComparisonT* c = comparison(input.accuracy, AnchorUse::check, AccuracyReference::survey);
  if (c && c->anchors > 0)
    lines.push_back("The measurement behind it: " + std::to_string(c->passed) + " of " +
                    std::to_string(c->anchors_listed) + " check anchors agree with the survey in height within ±" +
                    tolerance(input.accuracy.tau) +
                    (c->failed > 0 ? ", " + std::to_string(c->failed) + " do not" : "") + "; RMSE " + mm(c->rmse_z) +
                    "\u00A0mm, expected " + mm(c->predicted_rmse_z) + ".");
  else
    lines.push_back("No check anchor was evaluated: nothing shows how good the measurement behind this is.");
  return lines;
}

void write_count(Markup& html, const char* what, std::initializer_list<std::pair<int, ToleranceVerdict>> counts) {
  Scope list(html, "div", {{"class", "tally"}});
  html.element("b", what);
  for (const auto& [n, verdict] : counts) {
    if (verdict == ToleranceVerdict::not_measured && n == 0) continue;
    Scope span(html, "span");
    html.text(std::to_string(n) + "\u00A0");
    verdict_badge(html, verdict);
  }
}

}  // namespace

std::string what_to_do(const AnchorDeviationT& anchor, const DeviationT& deviation) {
  return task_of(anchor, deviation).todo;
}

std::string what_to_do(const PanelDeviationT& panel, const DeviationT& deviation) {
  return task_of(panel, deviation).todo;
}

void write_installation(Markup& html, const ReportInput& input) {
  if (!input.deviation) return;
  const DeviationT& d = *input.deviation;
  int panels_failed = 0, panels_open = 0;
  for (const auto& panel : d.panels)
    panels_failed += panel->verdict == ToleranceVerdict::fail,
        panels_open += panel->verdict == ToleranceVerdict::undecided;
  {
    Scope box(html, "div", {{"class", std::string("verdict ") + verdict_class(d.verdict)}, {"id", "install"}});
    {
      Scope svg(html, "svg", {{"viewBox", "0 0 44 44"}, {"width", "44"}, {"height", "44"}, {"aria-hidden", "true"}});
      verdict_symbol(html, 22, 23, 16, d.verdict, false);
    }
    Scope words(html, "div");
    html.element("strong", installation_heading(d, panels_failed, panels_open));
    write_count(html, "Anchors",
                {{d.passed, ToleranceVerdict::pass},
                 {d.undecided, ToleranceVerdict::undecided},
                 {d.failed, ToleranceVerdict::fail},
                 {d.not_measured, ToleranceVerdict::not_measured}});
    if (!d.panels.empty())
      write_count(html, "Panels",
                  {{static_cast<int>(d.panels.size()) - panels_failed - panels_open, ToleranceVerdict::pass},
                   {panels_open, ToleranceVerdict::undecided},
                   {panels_failed, ToleranceVerdict::fail}});
    if (d.surfaces)
      write_count(html, "Surfaces and joints",
                  {{d.surfaces->passed, ToleranceVerdict::pass},
                   {d.surfaces->undecided, ToleranceVerdict::undecided},
                   {d.surfaces->failed, ToleranceVerdict::fail},
                   {d.surfaces->not_judged, ToleranceVerdict::not_measured}});
    for (const auto& request : d.requests)
      if (!request->not_judged.empty())
        html.element("p", "Not judged: " + request->asked + ": " + request->not_judged + ".");
    for (const auto& facade : d.facades)
      if (!facade->confirmed)
        html.element("p", "Which way facade " + facade->name +
                              " faces is not confirmed, and nobody may be sent outward " +
                              "or inward there: " + facade->note + ". The notes below say how to confirm it.");
    if (d.common_shift && d.common_shift->significant) html.element("p", words_of(*d.common_shift));
    for (const auto& group : d.group_shifts)
      if (group->significant) html.element("p", words_of(*group, d));
    if (input.changes && input.changes->compared)
      html.element("p", since(*input.changes) + ": " + judgement::words_of_changes(*input.changes) + ".");
    for (const std::string& line : confidence_of(input)) html.element("p", line);
  }
  write_filter(html, d);
  const std::vector<Task> tasks = tasks_of(input);
  if (!tasks.empty()) {
    html.element("h3", "Where not, and what to do: first to mend first");
    write_tasks(html, tasks, 0, std::min(kFirstRows, tasks.size()));
    if (tasks.size() > kFirstRows) {
      const std::size_t listed = many(d) ? std::min(kMostTasks, tasks.size()) : tasks.size();
      folded(html,
             std::to_string(listed - kFirstRows) + " more" +
                 (listed < tasks.size() ? " of " + std::to_string(tasks.size() - kFirstRows) +
                                              "; the tables of panels and anchors below and stake_out.csv hold all"
                                        : ""),
             [&] { write_tasks(html, tasks, kFirstRows, listed); });
    }
  }
  write_overview(html, d);
}

}  // namespace plumbline::report

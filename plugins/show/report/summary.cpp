#include "show/report/summary.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "building/ifc/doubt_words.hpp"
#include "building/ifc/surface_words.hpp"
#include "building/judgement/epochs.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// Millimetres with two decimals, right-aligned in `width`; "-" where there is no value.
std::string mm(double metres, int width) {
  return std::isfinite(metres) ? fmt::format("{:{}.2f}", 1000 * metres, width) : fmt::format("{:>{}}", "-", width);
}

/// "8.23 +- 0.30", or "8.23" where no uncertainty is known.
std::string with_u(double metres, double u) {
  return std::isfinite(u) ? mm(metres, 0) + " +- " + mm(u, 0) : mm(metres, 0);
}

template <typename... Values>
std::string row(fmt::format_string<const Values&...> format, const Values&... values) {
  return fmt::format(format, values...) + "\n";
}

std::string name_of(const AccuracyComparisonT& comparison) {
  std::string name = comparison.use == AnchorUse::control ? "control" : "check";
  name += comparison.reference == AccuracyReference::truth ? " against truth" : " against survey";
  return comparison.evidence ? name : name + " *";
}

const char* verdict_of(ToleranceVerdict verdict) {
  switch (verdict) {
    case ToleranceVerdict::pass:
      return "pass";
    case ToleranceVerdict::fail:
      return "FAIL";
    case ToleranceVerdict::undecided:
      return "undecided";
    default:
      return "-";
  }
}

std::string comparisons_text(const AccuracyT& accuracy) {
  std::string text = row("{:<25} {:>7} {:>5} {:>9} {:>5} {:>8} {:>9} {:>8}", "anchors [mm]", "number", "pass",
                         "undecided", "fail", "RMSE_z", "predicted", "max|dz|");
  bool starred = false;
  for (const auto& comparison : accuracy.comparisons) {
    text += row("{:<25} {:7} {:5} {:9} {:5} {} {} {}", name_of(*comparison), comparison->anchors, comparison->passed,
                comparison->undecided, comparison->failed, mm(comparison->rmse_z, 8),
                mm(comparison->predicted_rmse_z, 9), mm(comparison->max_abs_dz, 8));
    starred = starred || !comparison->evidence;
  }
  if (starred) text += "* no evidence of accuracy: these anchors took part in the adjustment\n";
  return text;
}

std::string floors_text(const AccuracyComparisonT& comparison) {
  std::string text = row("{:<25} {:>7} {:>8} {:>8} {:>8}  {:<10} {}", name_of(comparison), "anchors", "r_f", "D(F)",
                         "u(D)", "verdict", "transfer to the floor above");
  for (const auto& floor : comparison.floors) {
    std::string transfer;
    for (const auto& candidate : comparison.transfers)
      if (candidate->column == 0 && candidate->lower_floor == floor->floor)
        transfer = with_u(candidate->error, candidate->u);
    text += row("floor {:<19} {:7} {} {} {}  {:<10} {}", floor->floor, floor->anchors, mm(floor->mean_dz, 8),
                mm(floor->drift, 8), mm(floor->u_drift, 8), verdict_of(floor->drift_verdict), transfer);
  }
  return text;
}

std::string counts(int passed, int undecided, int failed, int not_measured) {
  std::string text = row("{} pass, {} undecided, {} fail", passed, undecided, failed);
  text.pop_back();
  return not_measured > 0 ? text + ", " + std::to_string(not_measured) + " not measured" : text;
}

/// What of surfaces and joints is out of its limits, or too close to call; what is not judged stands with its rule.
std::string surfaces_text(const SurfaceJudgementT& surfaces) {
  std::string text;
  int listed = 0;
  for (const SurfaceVerdictT* verdict : worst_surfaces_first(surfaces)) {
    if (++listed > 5) continue;
    text += row("  {:<20.60} {:<10} {} {} mm (limit {})", surface_name(*verdict), verdict_of(verdict->verdict),
                ifc::quantity_of(*verdict), with_u(verdict->value, verdict->sigma), mm(ifc::limit_of(*verdict), 0));
  }
  if (listed > 5) text += "  … and " + std::to_string(listed - 5) + " more of surfaces; the report lists them all\n";
  return text;
}

/// Can we install, and what first.
std::string installation_text(const DeviationT& deviation, const AsBuiltChangesT* changes) {
  int panels[4] = {};
  for (const auto& panel : deviation.panels) ++panels[static_cast<int>(panel->verdict)];
  const auto at = [&](ToleranceVerdict verdict) { return panels[static_cast<int>(verdict)]; };
  std::string text;
  for (const auto& doubt : deviation.doubts) text += "NOT TO BE TRUSTED, " + ifc::in_words(*doubt) + "\n";
  text += std::string("Installation: ") + verdict_of(deviation.verdict) + ". Anchors against the design: " +
          counts(deviation.passed, deviation.undecided, deviation.failed, deviation.not_measured);
  if (!deviation.panels.empty())
    text += "; panels: " +
            counts(at(ToleranceVerdict::pass), at(ToleranceVerdict::undecided), at(ToleranceVerdict::fail), 0);
  if (deviation.surfaces) text += "; surfaces and joints: " + surface_counts(*deviation.surfaces);
  text += ".\n";
  if (changes && changes->compared) {
    text += since(*changes) + ": " + judgement::words_of_changes(*changes) + ".\n";
    for (const std::string& warning : changes->warnings) text += "Note: " + warning + ".\n";
  }
  for (const auto& misfit : deviation.misfits) text += "LESS CERTAIN, " + ifc::in_words(*misfit) + "\n";
  for (const auto& request : deviation.requests)
    if (!request->not_judged.empty()) text += "NOT JUDGED: " + request->asked + ": " + request->not_judged + "\n";
  int listed = 0;
  for (const AnchorDeviationT* anchor : worst_first(deviation)) {
    const JudgedAxisT* axis = deciding_axis(*anchor);
    if (!axis || anchor->verdict < ToleranceVerdict::undecided) break;
    if (++listed > 10) continue;
    text += row("  {:<20.40} {:<10} {} {} mm (limit {})", anchor->id, verdict_of(anchor->verdict), words_of(axis->axis),
                with_u(axis->value, axis->u), mm(axis->tolerance, 0));
  }
  if (listed > 10) text += "  … and " + std::to_string(listed - 10) + " more anchors; the report lists them all\n";
  int shown = 0;
  for (const PanelDeviationT* panel : worst_panels_first(deviation)) {
    if (panel->verdict < ToleranceVerdict::undecided) break;
    if (++shown > 5) continue;
    text += row("  panel {:<14.40} {:<10} {:.120}", (panel->name.empty() ? panel->guid : panel->name),
                verdict_of(panel->verdict), panel->reason);
  }
  if (shown > 5) text += "  … and " + std::to_string(shown - 5) + " more panels; the report lists them all\n";
  if (deviation.surfaces) text += surfaces_text(*deviation.surfaces);
  for (const std::string& warning : deviation.warnings) text += "Note: " + warning + "\n";
  text += row("Anchors and panels pass from a probability of {:.4g} % on that all judged of them is within tolerance.",
              100 * (1 - deviation.risk));
  if (deviation.pass_together > 0)
    text +=
        row("Each is judged by itself, a floor by its worst: all of them are within tolerance at once with a "
            "probability of at least {:.1f} %.",
            std::floor(1000 * deviation.pass_together) / 10);
  return text;
}

}  // namespace

std::string summary_text(const AccuracyT& accuracy, const DeviationT* deviation, const AsBuiltChangesT* changes) {
  std::string text = deviation ? installation_text(*deviation, changes) : "";
  text +=
      row("Tolerance {} mm, for comparisons with a guard band of {:.3g} u; u and what stands behind +- are standard "
          "uncertainties (1 sigma).",
          mm(accuracy.tau, 0), accuracy.guard_factor);
  if (!accuracy.comparisons.empty()) text += comparisons_text(accuracy) + floors_text(*accuracy.comparisons.front());
  for (const std::string& warning : accuracy.warnings) text += "Note: " + warning + "\n";
  return text;
}

}  // namespace plumbline::report

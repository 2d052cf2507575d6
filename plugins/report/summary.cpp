#include "report/summary.hpp"

#include <cmath>
#include <cstdio>

namespace plumbline::report {

namespace {

/// Millimetres with two decimals, right-aligned in `width`; "-" where there is no value.
std::string mm(double metres, int width) {
  char text[32];
  if (std::isfinite(metres))
    std::snprintf(text, sizeof text, "%*.2f", width, 1000 * metres);
  else
    std::snprintf(text, sizeof text, "%*s", width, "-");
  return text;
}

std::string row(const char* format, auto... values) {
  char text[200];
  std::snprintf(text, sizeof text, format, values...);
  return std::string(text) + "\n";
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
  std::string text = row("%-25s %7s %5s %9s %5s %8s %9s %8s", "anchors [mm]", "number", "pass", "undecided", "fail",
                         "RMSE_z", "predicted", "max|dz|");
  bool starred = false;
  for (const auto& comparison : accuracy.comparisons) {
    text += row("%-25s %7d %5d %9d %5d %s %s %s", name_of(*comparison).c_str(), comparison->anchors, comparison->passed,
                comparison->undecided, comparison->failed, mm(comparison->rmse_z, 8).c_str(),
                mm(comparison->predicted_rmse_z, 9).c_str(), mm(comparison->max_abs_dz, 8).c_str());
    starred = starred || !comparison->evidence;
  }
  if (starred) text += "* no evidence of accuracy: these anchors took part in the adjustment\n";
  return text;
}

std::string floors_text(const AccuracyComparisonT& comparison) {
  std::string text = row("%-25s %7s %8s %8s %8s  %-10s %s", name_of(comparison).c_str(), "anchors", "r_f", "D(F)",
                         "u(D)", "verdict", "transfer to the floor above");
  for (const auto& floor : comparison.floors) {
    std::string transfer;
    for (const auto& candidate : comparison.transfers)
      if (candidate->column == 0 && candidate->lower_floor == floor->floor)
        transfer = mm(candidate->error, 0) + " +- " + mm(candidate->u, 0);
    text += row("floor %-19d %7d %s %s %s  %-10s %s", floor->floor, floor->anchors, mm(floor->mean_dz, 8).c_str(),
                mm(floor->drift, 8).c_str(), mm(floor->u_drift, 8).c_str(), verdict_of(floor->drift_verdict),
                transfer.c_str());
  }
  return text;
}

std::string panels_text(const AccuracyT& accuracy) {
  if (accuracy.panels.empty()) return "";
  int count[4] = {};
  const PanelAccuracyT* worst = accuracy.panels.front().get();
  for (const auto& panel : accuracy.panels) {
    ++count[static_cast<int>(panel->verdict)];
    if (panel->verdict > worst->verdict) worst = panel.get();
  }
  std::string text =
      row("Panels on their anchors: %zu, %d within tolerance, %d undecided, %d not", accuracy.panels.size(),
          count[static_cast<int>(ToleranceVerdict::pass)], count[static_cast<int>(ToleranceVerdict::undecided)],
          count[static_cast<int>(ToleranceVerdict::fail)]);
  if (worst->verdict < ToleranceVerdict::undecided) return text;
  text.pop_back();
  return text + "; first " + worst->name + " (" + worst->decided_by + ")\n";
}

}  // namespace

std::string summary_text(const AccuracyT& accuracy) {
  std::string text = row("Tolerance %s mm, guard band %.3g u.", mm(accuracy.tau, 0).c_str(), accuracy.guard_factor);
  text += comparisons_text(accuracy);
  if (!accuracy.comparisons.empty()) text += floors_text(*accuracy.comparisons.front());
  if (accuracy.design && accuracy.design->anchors > 0)
    text += row(
        "As built against design: %d anchors, %d within tolerance in height, %d undecided, %d not; worst %s mm (%s)",
        accuracy.design->anchors, accuracy.design->passed, accuracy.design->undecided, accuracy.design->failed,
        mm(accuracy.design->max_distance, 0).c_str(), accuracy.design->worst_anchor.c_str());
  text += panels_text(accuracy);
  for (const std::string& warning : accuracy.warnings) text += "Note: " + warning + "\n";
  return text;
}

}  // namespace plumbline::report

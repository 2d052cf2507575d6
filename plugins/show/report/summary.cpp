#include "show/report/summary.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <sstream>

#include "building/ifc/doubt_words.hpp"
#include "building/ifc/limit_words.hpp"
#include "building/ifc/shift_words.hpp"
#include "building/ifc/surface_words.hpp"
#include "building/ifc/temperature_words.hpp"
#include "building/judgement/epochs.hpp"
#include "show/report/exact_lengths.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/sections.hpp"
#include "show/report/spoken_texts.hpp"

namespace plumbline::report {

namespace {

/// A length with the decimals of 0.01 mm, right-aligned in `width`; "-" where there is no value.
std::string length(double metres, int width) {
  if (!std::isfinite(metres)) return fmt::format("{:>{}}", "-", width);
  std::string text = fmt::format("{:{}.{}f}", in_units(metres), width, speech().units == Units::inches ? 4 : 2);
  if (speech().language == Language::german) std::replace(text.begin(), text.end(), '.', ',');
  return in_units_spoken(text);
}

std::size_t letters(const std::string& word) {
  return static_cast<std::size_t>(std::count_if(word.begin(), word.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

/// A head of a table, and how wide its column is: `width`, or more where the word in another language is longer. Other
/// languages may have a shorter word for it, so that a table fits 80 columns.
struct Head {
  Head(const std::string& english, std::size_t least)
      : word(speech().language == Language::english ? english : spoken(english + ", as a head")),
        width(std::max(least, letters(word))) {}
  std::string word;
  std::size_t width = 0;
};

/// "8.23 +- 0.30", or "8.23" where no uncertainty is known.
std::string with_u(double metres, double u) {
  return std::isfinite(u) ? length(metres, 0) + " +- " + length(u, 0) : length(metres, 0);
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

std::string verdict_in_english(ToleranceVerdict verdict) {
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

std::string verdict_of(ToleranceVerdict verdict) { return spoken(verdict_in_english(verdict)); }

/// In a column of a table.
std::string verdict_cell_of(ToleranceVerdict verdict) {
  return fmt::format("{:<{}}", verdict_of(verdict), std::max<std::size_t>(10, letters(spoken("undecided"))));
}

std::string comparisons_text(const AccuracyT& accuracy) {
  const Head of_number("number", 7), of_pass("pass", 5), of_undecided("undecided", 9), of_fail("fail", 5);
  std::string text = row("{:<26} {:>{}} {:>{}} {:>{}} {:>{}} {:>8} {:>9} {:>8}", spoken("anchors [mm]"), of_number.word,
                         of_number.width, of_pass.word, of_pass.width, of_undecided.word, of_undecided.width,
                         of_fail.word, of_fail.width, "RMSE_z", spoken("predicted"), "max|dz|");
  bool starred = false;
  for (const auto& comparison : accuracy.comparisons) {
    text += row("{:<26} {:{}} {:{}} {:{}} {:{}} {} {} {}", spoken(name_of(*comparison)), comparison->anchors,
                of_number.width, comparison->passed, of_pass.width, comparison->undecided, of_undecided.width,
                comparison->failed, of_fail.width, length(comparison->rmse_z, 8),
                length(comparison->predicted_rmse_z, 9), length(comparison->max_abs_dz, 8));
    starred = starred || !comparison->evidence;
  }
  if (starred) text += "* no evidence of accuracy: these anchors took part in the adjustment\n";
  return text;
}

std::string floors_text(const AccuracyComparisonT& comparison) {
  const Head of_number("number", 7);
  std::string text =
      row("{:<26} {:>7} {:>8} {:>8} {:>8}  {:<{}} {}", spoken(name_of(comparison)), of_number.word, "r_f", "D(F)",
          "u(D)", spoken("verdict"), letters(verdict_cell_of(ToleranceVerdict::pass)), spoken("to the floor above"));
  for (const auto& floor : comparison.floors) {
    std::string transfer;
    for (const auto& candidate : comparison.transfers)
      if (candidate->column == 0 && candidate->lower_floor == floor->floor)
        transfer = with_u(candidate->error, candidate->u);
    text += row("{:<26} {:7} {} {} {}  {} {}", spoken("floor " + std::to_string(floor->floor)), floor->anchors,
                length(floor->mean_dz, 8), length(floor->drift, 8), length(floor->u_drift, 8),
                verdict_cell_of(floor->drift_verdict), transfer);
  }
  return text;
}

/// `unasked`: of those without a verdict, which were measured and are held against nothing.
std::string counts(int passed, int undecided, int failed, int without, int unasked = 0) {
  std::string text = row("{} pass, {} undecided, {} fail", passed, undecided, failed);
  text.pop_back();
  if (without > unasked) text += ", " + std::to_string(without - unasked) + " not measured";
  return unasked > 0 ? text + ", " + std::to_string(unasked) + " measured and held against nothing" : text;
}

/// What of surfaces and joints is out of its limits, or too close to call; what is not judged stands with its rule.
std::string surfaces_text(const SurfaceJudgementT& surfaces) {
  std::string text;
  int listed = 0;
  for (const SurfaceVerdictT* verdict : worst_surfaces_first(surfaces)) {
    if (++listed > 5) continue;
    text += row("  {:<20.60} {} {} {} mm (limit {})", surface_name(*verdict), verdict_cell_of(verdict->verdict),
                spoken(ifc::quantity_of(*verdict)), with_u(verdict->value, verdict->sigma),
                length(ifc::limit_of(*verdict), 0));
  }
  if (listed > 5) text += "  … and " + std::to_string(listed - 5) + " more of surfaces; report.html lists them all\n";
  return text;
}

/// Can we install, and what first.
std::string installation_text(const DeviationT& deviation, const AsBuiltChangesT* changes) {
  int panels[4] = {};
  for (const auto& panel : deviation.panels) ++panels[static_cast<int>(panel->verdict)];
  const auto at = [&](ToleranceVerdict verdict) { return panels[static_cast<int>(verdict)]; };
  std::string text;
  for (const auto& doubt : deviation.doubts) text += "NOT TO BE TRUSTED, " + ifc::in_words(*doubt) + "\n";
  text +=
      spoken("Installation: " + verdict_in_english(deviation.verdict)) + ". Anchors against the design: " +
      counts(deviation.passed, deviation.undecided, deviation.failed, deviation.not_measured,
             static_cast<int>(std::count_if(deviation.anchors.begin(), deviation.anchors.end(), [](const auto& anchor) {
               return anchor->verdict == ToleranceVerdict::not_measured && anchor->deviation.allFinite();
             })));
  if (!deviation.panels.empty())
    text += "; panels: " +
            counts(at(ToleranceVerdict::pass), at(ToleranceVerdict::undecided), at(ToleranceVerdict::fail), 0);
  if (deviation.surfaces) text += "; surfaces and joints: " + surface_counts(*deviation.surfaces);
  text += ".\n";
  const std::vector<std::string> shifts = ifc::shift_words(deviation);  // one cause in place of many lines below
  for (const std::string& words : shifts) text += words + "\n";
  if (changes && changes->compared) {
    text += since(*changes) + ": " + judgement::words_of_changes(*changes) + ".\n";
    for (const std::string& warning : changes->warnings) text += "Note: " + warning + ".\n";
  }
  if (!deviation.datum.empty()) text += "Note: " + deviation.datum + "\n";
  for (const auto& misfit : deviation.misfits) text += "LESS CERTAIN, " + ifc::in_words(*misfit) + "\n";
  for (const auto& request : deviation.requests)
    if (!request->not_judged.empty()) text += "NOT JUDGED: " + request->asked + ": " + request->not_judged + "\n";
  int listed = 0;
  for (const AnchorDeviationT* anchor : worst_first(deviation)) {
    const JudgedAxisT* axis = deciding_axis(*anchor);
    if (!axis || anchor->verdict < ToleranceVerdict::undecided) break;
    if (++listed > 10) continue;
    text += row("  {:<20.40} {} {} {} mm (limit {})", anchor->id, verdict_cell_of(anchor->verdict),
                spoken(words_of(axis->axis)), with_u(axis->value, axis->u),
                ifc::limits_in_words(*axis, [](double limit) { return length(limit, 0); }));
  }
  if (listed > 10) text += "  … and " + std::to_string(listed - 10) + " more anchors; report.html lists them all\n";
  int shown = 0;
  for (const PanelDeviationT* panel : worst_panels_first(deviation)) {
    if (panel->verdict < ToleranceVerdict::undecided) break;
    if (++shown > 5) continue;
    const std::string noun = spoken("panel");
    text += row("  {} {:<{}.40} {} {:.120}", noun, (panel->name.empty() ? panel->guid : panel->name),
                std::max<std::size_t>(1, 19 - std::min<std::size_t>(18, noun.size())), verdict_cell_of(panel->verdict),
                spoken(reason_of(*panel, deviation)));  // below the anchors' column of 20
  }
  if (shown > 5) text += "  … and " + std::to_string(shown - 5) + " more panels; report.html lists them all\n";
  if (deviation.surfaces) text += surfaces_text(*deviation.surfaces);
  for (const std::string& warning : deviation.warnings)
    if (std::find(shifts.begin(), shifts.end(), warning) == shifts.end()) text += "Note: " + warning + "\n";
  if (const std::string words = ifc::temperature_words(deviation); !words.empty()) text += "Note: " + words + "\n";
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
          length(accuracy.tau, 0), accuracy.guard_factor);
  if (!accuracy.comparisons.empty()) text += comparisons_text(accuracy) + floors_text(*accuracy.comparisons.front());
  for (const std::string& warning : accuracy.warnings) text += "Note: " + warning + "\n";
  return spoken_lines(text);
}

}  // namespace plumbline::report

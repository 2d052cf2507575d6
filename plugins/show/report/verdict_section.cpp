// What a reader must know first: the verdict, the warnings, the key numbers; and at the end how to read them.
#include <algorithm>
#include <cmath>

#include "building/ifc/doubt_words.hpp"
#include "building/ifc/temperature_words.hpp"
#include "show/report/format.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

/// Counts of verdicts over a set of anchors.
struct Tally {
  int passed = 0, undecided = 0, failed = 0, not_measured = 0;
  int measured() const { return passed + undecided + failed; }
  ToleranceVerdict overall() const {
    if (measured() == 0) return ToleranceVerdict::not_measured;
    if (failed > 0) return ToleranceVerdict::fail;
    return undecided + not_measured > 0 ? ToleranceVerdict::undecided : ToleranceVerdict::pass;
  }
};

void write_tally(Markup& html, const Tally& tally) {
  Scope list(html, "div", {{"class", "tally"}});
  const auto item = [&](int n, ToleranceVerdict verdict) {
    Scope span(html, "span");
    html.text(std::to_string(n) + "\u00A0");
    verdict_badge(html, verdict);
  };
  item(tally.passed, ToleranceVerdict::pass);
  item(tally.undecided, ToleranceVerdict::undecided);
  item(tally.failed, ToleranceVerdict::fail);
  if (tally.not_measured > 0) item(tally.not_measured, ToleranceVerdict::not_measured);
}

void write_verdict_box(Markup& html, const Tally& tally, const std::string& heading,
                       const std::vector<std::string>& more) {
  const ToleranceVerdict overall = tally.overall();
  Scope box(html, "div", {{"class", std::string("verdict ") + verdict_class(overall)}});
  {
    Scope svg(html, "svg", {{"viewBox", "0 0 44 44"}, {"width", "44"}, {"height", "44"}, {"aria-hidden", "true"}});
    verdict_symbol(html, 22, 23, 16, overall, false);
  }
  Scope words(html, "div");
  html.element("strong", heading);
  write_tally(html, tally);
  for (const std::string& paragraph : more) html.element("p", paragraph);
}

/// "± 0.47 mm; more", or what is known of it.
std::string with_u(double u, const std::string& more) {
  return (std::isfinite(u) ? "± " + mm(u) + " mm; " : "uncertainty unknown; ") + more;
}

std::string of_total(int part, int total) { return std::to_string(part) + " of " + std::to_string(total); }

std::string model_heading(const Tally& tally, double tau, bool uncertainty_known) {
  const std::string limit = "±" + tolerance(tau);
  const int n = tally.measured();
  switch (tally.overall()) {
    case ToleranceVerdict::pass:
      return (n == 1 ? "The check anchor is" : "All " + std::to_string(n) + " check anchors are") + " within " + limit +
             " of the survey in height, measuring uncertainty included.";
    case ToleranceVerdict::fail:
      return of_total(tally.failed, n) + " check anchors " + (tally.failed == 1 ? "is" : "are") + " outside " + limit +
             " of the survey in height.";
    case ToleranceVerdict::undecided:
      if (!uncertainty_known)
        return "Undecided: the uncertainty of the measurement is not known, so nothing can be judged.";
      if (tally.undecided > 0)
        return "Undecided: " + of_total(tally.undecided, n) + " check anchors " +
               (tally.undecided == 1 ? "is" : "are") + " too close to ±" + tolerance(tau) + " to call.";
      return "Undecided: all measured check anchors pass, but " + std::to_string(tally.not_measured) +
             " could not be measured.";
    case ToleranceVerdict::not_measured:
      break;
  }
  return "No verdict: no check anchor was evaluated.";
}

/// Ids of the anchors with this verdict, largest deviation first, a few of them.
std::string ids_with(const AccuracyT& accuracy, ToleranceVerdict verdict,
                     std::unique_ptr<AnchorDifferenceT> AnchorAccuracyT::*member, bool check, bool control) {
  std::vector<std::pair<double, std::string>> found;
  for (const auto& a : accuracy.anchors) {
    const AnchorDifferenceT* d = ((*a).*member).get();
    if (d && d->verdict == verdict && (a->use == AnchorUse::check ? check : control))
      found.emplace_back(-std::abs(d->dz), a->id + " (" + signed_mm(d->dz, 1) + "\u00A0mm)");
  }
  std::sort(found.begin(), found.end());
  std::string text;
  for (std::size_t i = 0; i < found.size() && i < 8; ++i) text += (i ? ", " : "") + found[i].second;
  return found.size() > 8 ? text + " and " + std::to_string(found.size() - 8) + " more" : text;
}

std::string pass_rate_sentence(const AccuracyT& accuracy, const AccuracyComparisonT& c) {
  for (const auto& rate : c.pass_rates) {
    if (std::abs(rate->tolerance - accuracy.tau) > 1e-9 || rate->evaluated == 0) continue;
    std::string text = of_total(rate->passed, rate->evaluated) + " within ±" + tolerance(accuracy.tau) + " shows, at " +
                       percent(accuracy.confidence, 0) + " confidence, that at least " + percent(rate->exact_lower) +
                       " of all such anchors would be.";
    if (rate->exact_lower < 0.95)
      text += " To show 95\u00A0%, " + std::to_string(accuracy.anchors_needed) +
              " anchors would have to be tested and all pass.";
    return text;
  }
  return "";
}

void write_model_verdict(Markup& html, const AccuracyT& accuracy) {
  Tally tally;
  bool uncertainty_known = true;
  std::vector<std::string> more;
  const AccuracyComparisonT* c = comparison(accuracy, AnchorUse::check, AccuracyReference::survey);
  if (c) {
    tally = {c->passed, c->undecided, c->failed, c->anchors_listed - c->anchors};
    const std::string failing = ids_with(accuracy, ToleranceVerdict::fail, &AnchorAccuracyT::survey, true, false);
    const std::string open = ids_with(accuracy, ToleranceVerdict::undecided, &AnchorAccuracyT::survey, true, false);
    if (!failing.empty())
      more.push_back("Outside: " + failing + ". Measure these again before anything is set to them.");
    uncertainty_known = std::isfinite(c->u_mean_dz);
    if (!open.empty() && uncertainty_known)
      more.push_back("Too close to call: " + open +
                     ". A more precise measurement, or a wider tolerance, decides them.");
    if (c->anchors > 0) more.push_back(pass_rate_sentence(accuracy, *c));
  } else {
    more.push_back(
        "Every anchor served as control. Withhold some, at least one on every floor, to learn how accurate the model "
        "is.");
  }
  const std::string control = ids_with(accuracy, ToleranceVerdict::fail, &AnchorAccuracyT::survey, false, true);
  if (!control.empty())
    more.push_back("Control anchors that contradict their own survey: " + control +
                   ". Look for a mix-up or a blunder there first; it pulls at the whole model.");
  write_verdict_box(html, tally, model_heading(tally, accuracy.tau, uncertainty_known), more);
}

void card(Markup& html, const std::string& name, const std::string& value, const std::string& more) {
  Scope box(html, "div", {{"class", "card"}});
  html.element("div", {{"class", "name"}}, name);
  html.element("div", {{"class", "value"}}, value);
  html.element("div", {{"class", "more"}}, more);
}

void write_drift_cards(Markup& html, const AccuracyT& accuracy, const AccuracyComparisonT& c) {
  const FloorAccuracyT* top = nullptr;
  const FloorAccuracyT *first = nullptr, *last = nullptr;  // with anchors
  for (const auto& floor : c.floors) {
    if (std::isfinite(floor->drift)) top = floor.get();
    if (floor->anchors == 0) continue;
    if (!first) first = floor.get();
    last = floor.get();
  }
  if (top)
    card(html, "Cumulative drift D(" + std::to_string(top->floor) + ")", signed_mm(top->drift) + "\u00A0mm",
         with_u(top->u_drift, "against ±" + tolerance(accuracy.tau) + ": " + verdict_word(top->drift_verdict)));
  else
    card(html, "Cumulative drift D(F)", unknown,
         c.use == AnchorUse::control ? "says nothing on control anchors" : "a floor has no anchors");
  if (last != first)
    card(html, "Drift of floor " + std::to_string(last->floor) + " against floor " + std::to_string(first->floor),
         signed_mm(last->relative_drift) + "\u00A0mm", with_u(last->u_relative_drift, "free of a common offset"));
  if (c.slope)
    card(html, "Trend from floor to floor", signed_mm(c.slope->per_floor) + "\u00A0mm",
         std::isfinite(c.slope->u_per_floor)
             ? percent(accuracy.confidence, 0) + " interval " + signed_mm(c.slope->lower) + " to " +
                   signed_mm(c.slope->upper) + " mm; p = " + probability(c.slope->p_value)
             : "uncertainty unknown");
}

const HeightTransferT* worst_transfer(const AccuracyComparisonT& c) {
  const HeightTransferT* worst = nullptr;
  for (const auto& t : c.transfers)
    if (t->column == 0 && (!worst || t->error > worst->error)) worst = t.get();
  return worst;
}

}  // namespace

void write_verdict(Markup& html, const ReportInput& input) { write_model_verdict(html, input.accuracy); }

void write_warnings(Markup& html, const ReportInput& input) {
  // A datum that does not fit explains what follows; then the design, then the measurement.
  std::vector<std::string> warnings;
  if (input.deviation) {
    warnings = ifc::in_words(input.deviation->misfits);
    const auto& told = input.deviation->warnings;
    warnings.insert(warnings.end(), told.begin(), told.end());
    const CommonShiftT* shift = input.deviation->common_shift.get();
    if (shift && shift->significant) {
      std::erase(warnings, shift->words);
      warnings.insert(warnings.begin(), shift->words);
    }
  }
  warnings.insert(warnings.end(), input.accuracy.warnings.begin(), input.accuracy.warnings.end());
  if (input.deviation)
    if (const std::string words = ifc::temperature_words(*input.deviation); !words.empty()) warnings.push_back(words);
  if (warnings.empty()) return;
  Scope box(html, "div", {{"class", "warnings"}});
  html.element("h2", "Before you rely on this");
  Scope list(html, "ul");
  for (const std::string& warning : warnings) html.element("li", warning);
}

void write_key_numbers(Markup& html, const AccuracyT& accuracy) {
  const AccuracyComparisonT* c = headline(accuracy);
  Scope part(html, "section", {{"id", "numbers"}});
  html.element("h2", "Key numbers");
  if (!c || c->anchors == 0) {
    html.element("p", "Nothing could be compared.");
    return;
  }
  html.element("p", {{"class", "note"}},
               "Model minus survey on " + count(c->anchors, "anchor", "anchors") + " (" + anchors_of(*c) + ")" +
                   (c->evidence ? "." : ": not evidence of accuracy, see “How to read this”."));
  Scope cards(html, "div", {{"class", "cards"}});
  card(html, "Heights, RMSE", mm_unit(c->rmse_z),
       std::isfinite(c->predicted_rmse_z)
           ? "expected " + mm(c->predicted_rmse_z) + " (" + mm(c->predicted_rmse_z_lower) + " to " +
                 mm(c->predicted_rmse_z_upper) + ") mm"
           : "no uncertainty known");
  card(html, "Largest height error", mm_unit(c->max_abs_dz), "at " + c->worst_anchor);
  write_drift_cards(html, accuracy, *c);
  if (const HeightTransferT* worst = worst_transfer(*c))
    card(html, "Worst height transfer", mm_unit(worst->error),
         with_u(worst->u, "floor " + std::to_string(worst->lower_floor) + " to " + std::to_string(worst->upper_floor)));
  card(html, "In space, RMSE", mm_unit(c->rmse_3d), "largest " + mm(c->max_distance) + " mm");
  if (const auto* truth = comparison(accuracy, c->use, AccuracyReference::truth); truth && truth->anchors > 0)
    card(html, "Heights against the truth, RMSE", mm_unit(truth->rmse_z),
         "simulation; expected " + mm(truth->predicted_rmse_z) + " mm");
}

namespace {

std::string consistency_words(const ErrorConsistencyT* test) {
  if (!test) return unknown;
  const std::string ratio = fixed(test->statistic / test->degrees_of_freedom, 2);
  if (test->statistic > test->upper) return ratio + ": errors larger than stated";
  if (test->statistic < test->lower) return ratio + ": errors smaller than stated";
  return ratio + ": consistent";
}

}  // namespace

void write_method(Markup& html, const AccuracyT& accuracy) {
  Scope part(html, "section", {{"id", "method"}});
  html.element("h2", "How to read this");
  html.element("h3", "Control and check anchors");
  html.element(
      "p",
      "Control anchors tie the model to the survey: their surveyed coordinates went into it. Check anchors were "
      "surveyed as "
      "well, but withheld. Only they show how accurate the model is where nothing was surveyed. On control anchors the "
      "cumulative drift vanishes by construction, because the fit makes their vertical residuals sum to zero; their "
      "numbers stand "
      "in the table below for comparison only.");
  {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table");
    table_head(html, {"Anchors", left("Compared with"), left("Evidence"), "Number", "Mean Δz ± u [mm]", "RMSE Δz [mm]",
                      "expected [mm]", "RMSE in space [mm]", left("χ²/f in space, and what it says")});
    Scope body(html, "tbody");
    for (const auto& c : accuracy.comparisons)
      table_row(html, {c->use == AnchorUse::check ? "check" : "control",
                       left(c->reference == AccuracyReference::truth ? "truth (simulation)" : "survey"),
                       left(c->evidence ? "yes" : "no"), of_total(c->anchors, c->anchors_listed),
                       mm_with_u(c->mean_dz, c->u_mean_dz), mm(c->rmse_z), mm(c->predicted_rmse_z), mm(c->rmse_3d),
                       left(consistency_words(c->consistency_3d.get()))});
  }
  html.element("h3", "Pass, fail, undecided");
  html.element(
      "p",
      "Against the survey a check anchor passes when its deviation and " + fixed(accuracy.guard_factor, 3) +
          " times its standard uncertainty u stay within the tolerance, fails when the deviation less that margin is "
          "still outside, and is undecided in between (guard band, JCGM 106). “Within” in the anchor table is the "
          "probability that the true deviation is inside the tolerance.");
  html.element("h3", "Uncertainty");
  html.element("p", accuracy.correlation_note +
                        " The values of u are standard uncertainties (1 sigma); intervals and tests hold at " +
                        percent(accuracy.confidence, 0) + ".");
  html.element("h3", "Drift");
  html.element("p",
               "r is the mean height residual of a floor; D(F) adds r up from the lowest floor to floor F. D(F) also "
               "adds up an offset "
               "that all floors share, so the drift against the lowest floor and the trend from floor to floor stand "
               "beside it.");
}

}  // namespace plumbline::report

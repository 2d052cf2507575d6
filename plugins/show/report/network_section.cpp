// The survey network: is it sound, what was removed and why, every observation with its tests.
#include <algorithm>
#include <cctype>
#include <cmath>

#include "base/text/words.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/network_drawing.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

std::string kind_words(const std::string& kind) {
  std::string words = kind;
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

/// Angles in mgon, lengths in mm, as a surveyor reads them.
std::string size_of(const NetworkPage::Observation& o, double value, bool with_unit) {
  if (!std::isfinite(value)) return std::isinf(value) ? "∞" : unknown;
  return (o.angular ? signed_fixed(value * 200e3 / M_PI, 2) : signed_mm(value)) +
         (with_unit ? (o.angular ? "\u00A0mgon" : "\u00A0mm") : "");
}

std::string positive_size_of(const NetworkPage::Observation& o, double value) {
  if (!std::isfinite(value)) return std::isinf(value) ? "∞" : unknown;
  return o.angular ? fixed(value * 200e3 / M_PI, 2) : mm(value);
}

/// An observed value as it is read off: gon with 0.1 mgon, metres with 0.1 mm.
std::string reading_of(const NetworkPage::Observation& o) {
  if (!std::isfinite(o.value)) return unknown;
  if (!o.angular) return fixed(o.value, 4);
  const double gon = o.value * 200 / M_PI;
  return fixed(gon < 0 ? gon + 400 : gon, 4);
}

std::string name_of(const NetworkPage::Observation& o) {
  std::string name = kind_words(o.kind) + " ";
  name += o.from.empty() ? o.to : o.from + " → " + o.to;
  return o.source.empty() ? name : name + " (" + o.source + ")";
}

std::string datum_in_words(const NetworkPage& n) {
  if (n.without_readings) return "the coordinates themselves";
  if (n.datum == "inner") return "free network, nothing outside is trusted";
  if (n.datum == "fixed") return "control points held as if free of error";
  if (n.datum == "weighted") return "control points with their standard deviations";
  if (n.datum == "file") return "as the file says";
  return n.datum;
}

void write_global_test(Markup& html, const NetworkPage& n) {
  const std::string bounds = fixed(n.statistic, 1) + " against " + fixed(n.lower, 1) + " to " + fixed(n.upper, 1) +
                             " with " + std::to_string(n.degrees_of_freedom) +
                             " degrees of freedom, error of the first kind " + percent(n.alpha) + ".";
  if (n.verdict == "pass") {
    html.element("p",
                 "The network fits its instruments: the observations contradict each other by as much as their stated "
                 "precision allows. Global test "
                 "passed: " +
                     bounds);
  } else if (n.verdict == "high" && n.validity == "sound") {
    html.element(
        "p",
        "The observations contradict each other a little more than their stated precision allows, as one sound "
        "network in forty does; no reading fails its own test. Global test failed narrowly: " +
            bounds);
  } else if (n.verdict == "high") {
    html.element("p",
                 "The observations contradict each other more than their stated precision allows: there are blunders "
                 "left, or the instrument is worse "
                 "than its profile. Global test failed, too high: " +
                     bounds);
  } else if (n.verdict == "low") {
    html.element("p",
                 "The observations agree better than their stated precision: the instrument profile is too "
                 "pessimistic, and so are the ellipses. Global "
                 "test too low: " +
                     bounds);
  } else if (!n.without_readings) {
    html.element("p", "There is no redundancy to test the network with: blunders would stay unseen.");
  }
}

/// "12.3 ± 0.4", or a dash.
std::string with_sigma(double value, double sigma, double factor, int digits) {
  if (!std::isfinite(value)) return unknown;
  const std::string text = signed_fixed(factor * value, digits);
  return std::isfinite(sigma) ? text + " ± " + fixed(factor * sigma, digits) : text;
}

/// The same of lengths [m].
std::string length_with_sigma(double value, double sigma, int digits) {
  if (!std::isfinite(value)) return unknown;
  return std::isfinite(sigma) ? signed_mm(value, digits) + " ± " + mm(sigma, digits) : signed_mm(value, digits);
}

/// The verdict first, in the words that the terminal has: a result must not be taken for one where it is none.
void write_banner(Markup& html, const NetworkPage& n) {
  if (n.outcome.empty()) return;
  static const std::string none = "not a result";
  std::string words = n.outcome;
  if (words.starts_with(none))
    words.replace(0, none.size(), "NOT A RESULT");
  else
    words[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(words[0])));
  const bool invalid = n.validity == "invalid";
  const char* kind = invalid ? "verdict fail" : n.validity == "doubtful" ? "verdict undecided" : "verdict pass";
  Scope banner(html, "div", {{"class", kind}, {"role", invalid ? "alert" : "status"}});
  html.element("strong", words + ".");
}

/// First rows open, more of them behind a click: `row(i)` writes one. A page grows with what is found, not with what
/// was measured: of a large network those behind `most` stand `elsewhere`.
struct LongTable {
  std::vector<Cell> head;
  std::size_t rows;
  std::string noun;  ///< of a row
  std::size_t most;
  std::string elsewhere;
};

template <typename Row>
void write_long_table(Markup& html, const LongTable& table_of, const Row& row) {
  constexpr std::size_t shown = 25;
  const auto& [head, all, noun, most, elsewhere] = table_of;
  const std::size_t rows = std::min(all, most);
  const auto write_rows = [&](std::size_t first, std::size_t last) {
    Scope wide(html, "div", {{"class", "wide"}});
    Scope table(html, "table", {{"class", "sortable"}});
    table_head(html, head);
    Scope body(html, "tbody");
    for (std::size_t i = first; i < last; ++i) row(i);
  };
  write_rows(0, std::min(shown, rows));
  if (rows <= shown) return;
  Scope details(html, "details");
  const std::string of_all = rows < all ? "The next " : "The other ";
  html.element("summary", of_all + count(static_cast<long>(rows - shown), noun, noun + "s"));
  write_rows(shown, rows);
  if (rows < all)
    html.element("p", {{"class", "note"}},
                 count(static_cast<long>(all - rows), "further " + noun + " is", "further " + noun + "s are") + " in " +
                     elsewhere + ".");
}

constexpr std::size_t kMostRows = 250;

void write_set_ups(Markup& html, const NetworkPage& n) {
  if (n.set_ups.empty()) return;
  html.element("h3", "Set-ups");
  html.element("p",
               "Collimation: from readings in two faces, whose means are free of it. Index, constant and ppm: what the "
               "network says the zenith angles and distances of the set-up have in "
               "common, each estimated alone; beyond three times its ± it is a mistake or belongs into the instrument. "
               "A dash: the network cannot tell it.");
  constexpr double mgon = 200e3 / M_PI;
  write_long_table(
      html,
      {{"Set-up", left("Station"), "Orientation [gon]", "Instrument height [m]", "Correction [mm]",
        "Collimation [mgon]", "Index [mgon]", "Constant [mm]", "ppm"},
       n.set_ups.size(),
       "set-up",
       kMostRows,
       "network.json"},
      [&](std::size_t i) {
        const auto& s = n.set_ups[i];
        const double turn = s.orientation * 200 / M_PI;
        table_row(html,
                  {s.id, left(s.station), std::isfinite(turn) ? fixed(turn < 0 ? turn + 400 : turn, 4) : unknown,
                   std::isfinite(s.instrument_height) ? fixed(s.instrument_height, 3) : unknown,
                   length_with_sigma(s.height_correction, std::nan(""), 1),
                   with_sigma(s.collimation, s.collimation_sigma, mgon, 2), with_sigma(s.index, s.index_sigma, mgon, 1),
                   length_with_sigma(s.constant, s.constant_sigma, 1), with_sigma(s.scale, s.scale_sigma, 1e6, 0)});
      });
}

/// What is to be mended stands first; notes are folded away where they are many.
void write_findings(Markup& html, const NetworkPage& n) {
  constexpr long shown_notes = 4;
  const auto is_note = [](const auto& finding) { return finding.severity == "note"; };
  const long notes = std::count_if(n.findings.begin(), n.findings.end(), is_note);
  const auto list = [&](bool of_notes) {
    Scope items(html, "ul");
    for (const auto& f : n.findings) {
      if (is_note(f) != of_notes) continue;
      Scope item(html, "li");
      html.element("strong", spoken(f.severity) + ": ").text(f.text);
    }
  };
  if (notes < static_cast<long>(n.findings.size())) list(false);
  if (notes == 0) return;
  if (notes <= shown_notes) return list(true);
  Scope details(html, "details");
  html.element("summary", count(notes, "note", "notes"));
  list(true);
}

void write_removed(Markup& html, const NetworkPage& n) {
  html.element("h3", "What was removed, and why");
  if (n.steps.empty()) {
    const auto suspects =
        std::count_if(n.observations.begin(), n.observations.end(), [](const auto& o) { return o.flagged; });
    html.element("p", suspects == 0 ? std::string("Nothing: no observation failed its test.")
                                    : "Nothing. " +
                                          count(suspects, "observation fails its test and is",
                                                "observations fail their test and are") +
                                          " flagged in the table below, but kept in the network.");
    return;
  }
  html.element("p", "An observation is removed when its normalised residual |w| is the largest and exceeds " +
                        fixed(n.critical_w, 2) + " (error of the first kind " + percent(n.alpha0) +
                        "); then the network is adjusted again.");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Step", left("What"), left("Observation"), "w", "Estimated blunder"});
  Scope body(html, "tbody");
  for (std::size_t i = 0; i < n.steps.size(); ++i) {
    const NetworkPage::Step& s = n.steps[i];
    if (s.observation >= n.observations.size()) continue;
    const NetworkPage::Observation& o = n.observations[s.observation];
    table_row(html, {std::to_string(i + 1), left(s.action), left(name_of(o)), signed_fixed(s.w, 2),
                     size_of(o, s.estimated_blunder, true)});
  }
}

std::string flags_of(const NetworkPage::Observation& o) {
  std::string flags;
  const auto add = [&](const char* flag) { flags += (flags.empty() ? "" : ", ") + std::string(flag); };
  if (o.removed) add("removed");
  if (o.flagged && !o.removed) add("suspect");
  if (o.redundancy_number < 0.1)
    add("uncontrolled");
  else if (o.redundancy_number < 0.3)
    add("weak");
  return flags;
}

void write_observations(Markup& html, const NetworkPage& n) {
  html.element("h3", "Observations, most suspect first");
  html.element("p",
               "Residual v and precision σ: angles in mgon, lengths in mm. r: share of a blunder that shows in its own "
               "residual (below 0.1 "
               "uncontrolled, below 0.3 weak). w: residual in units of its own standard deviation, suspect beyond ±" +
                   fixed(n.critical_w, 2) + ". MDB: smallest blunder that is found with a probability of " +
                   percent(n.power, 0) + "; effect: how far an undetected one of that size moves a point.");
  std::vector<const NetworkPage::Observation*> order;
  for (const auto& o : n.observations) order.push_back(&o);
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
    const auto size = [](const auto* o) { return std::isfinite(o->w) ? std::abs(o->w) : -1; };
    return a->removed != b->removed ? a->removed : size(a) > size(b);
  });
  const auto suspect =
      std::count_if(order.begin(), order.end(), [](const auto* o) { return o->removed || o->flagged; });
  write_long_table(html,
                   {{"Observation", "Observed [gon, m]", "v", "σ", "r", "w", "MDB", "Effect [mm]", left("Flags")},
                    order.size(),
                    "observation",
                    std::max(kMostRows, static_cast<std::size_t>(suspect)),
                    "observations.csv"},
                   [&](std::size_t i) {
                     const NetworkPage::Observation& o = *order[i];
                     table_row(html, {name_of(o), reading_of(o), size_of(o, o.residual, false),
                                      positive_size_of(o, o.sigma), fixed(o.redundancy_number, 2), signed_fixed(o.w, 2),
                                      positive_size_of(o, o.mdb), mm(o.external_effect), left(flags_of(o))});
                   });
}

void write_points(Markup& html, const NetworkPage& n) {
  if (n.coordinates.empty()) return;
  html.element("h3", "Coordinates");
  const auto& [x, y, z] = n.axis_names;
  const bool own = x != "E";
  html.element(
      "p",
      "σ: one standard deviation. Plan 95 %: largest semi-axis of the confidence ellipse; height 95 %: half "
      "the confidence interval. " +
          std::string(own ? "In the axes of the file: " + x + ", " + y + ", " + z + "; the drawings have north up."
                          : "E east, N north, H height.") +
          (n.coordinates.size() > kMostRows ? " The weakest stand first." : ""));
  std::vector<const NetworkPage::Coordinates*> order;
  for (const auto& p : n.coordinates) order.push_back(&p);
  const auto weakness = [](const NetworkPage::Coordinates* p) {
    const auto or_none = [](double v) { return std::isfinite(v) ? v : -1; };
    return std::max(or_none(p->plan_95), or_none(p->height_95));
  };
  if (order.size() > kMostRows)
    std::stable_sort(order.begin(), order.end(),
                     [&](const auto* a, const auto* b) { return weakness(a) > weakness(b); });
  write_long_table(
      html,
      {{"Point", x + " [m]", y + " [m]", z + " [m]", "σ " + x.substr(0, 1) + " [mm]", "σ " + y.substr(0, 1) + " [mm]",
        "σ " + z.substr(0, 1) + " [mm]", "Plan 95\u00A0% [mm]", "Height 95\u00A0% [mm]"},
       n.coordinates.size(),
       "point",
       kMostRows,
       "coordinates.csv"},
      [&](std::size_t i) {
        const NetworkPage::Coordinates& p = *order[i];
        table_row(html, {verbatim(p.id), fixed(p.position.x(), 4), fixed(p.position.y(), 4), fixed(p.position.z(), 4),
                         mm(p.sigma.x()), mm(p.sigma.y()), mm(p.sigma.z()), mm(p.plan_95), mm(p.height_95)});
      });
}

void write_relative(Markup& html, const NetworkPage& n) {
  if (n.relative.empty()) return;
  constexpr std::size_t shown = 10;
  html.element("h3", "Neighbouring markers relative to each other");
  html.element("p", "How well the step from a marker to one of its four nearest is known, weakest in height first" +
                        std::string(n.relative.size() > shown
                                        ? " (" + std::to_string(shown) + " of " +
                                              count(static_cast<long>(n.relative.size()), "pair", "pairs") +
                                              "; all of them, and any other pair, in relative.csv)"
                                        : "") +
                        ". Floor to floor this is what counts, not the ellipses above: they depend on the datum.");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html, {"From", left("To"), "Distance [m]", "σ H [mm]", "Height 95\u00A0% [mm]", "Plan 95\u00A0% [mm]"});
  Scope body(html, "tbody");
  for (std::size_t i = 0; i < std::min(shown, n.relative.size()); ++i) {
    const NetworkPage::Relative& r = n.relative[i];
    table_row(html, {r.from, left(r.to), fixed(r.distance, 2), mm(r.sigma_height), mm(r.height_95), mm(r.plan_95)});
  }
}

void write_groups(Markup& html, const NetworkPage& n) {
  if (n.groups.empty()) return;
  html.element("h3", "Precision by kind of observation");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Kind", "Observations", "Redundancy", "Stated precision × ", "Found / used precision"});
  Scope body(html, "tbody");
  for (const auto& g : n.groups) {
    if (g.observations == 0) continue;
    table_row(html, {kind_words(g.name), std::to_string(g.observations), fixed(g.redundancy, 1),
                     fixed(g.applied_factor, 2), fixed(g.ratio, 2)});
  }
}

/// A sighting whose three readings together fail: typical of a wrong target, where no single reading stands out.
void write_pointings(Markup& html, const NetworkPage& n) {
  if (n.pointings.empty()) return;
  html.element("h3", "Sightings tested as a whole");
  std::vector<const NetworkPage::Pointing*> flagged;
  for (const auto& p : n.pointings)
    if (p.flagged) flagged.push_back(&p);
  const auto tested = std::count_if(n.pointings.begin(), n.pointings.end(), [](const auto& p) { return p.rank > 0; });
  html.element("p", "Direction, zenith angle and distance of " + count(tested, "sighting", "sightings") +
                        " were tested together (chi-squared, error of the first kind " + percent(n.alpha0) + "): " +
                        (flagged.empty() ? "all pass." : count(static_cast<long>(flagged.size()), "fails.", "fail.")));
  if (flagged.empty()) return;
  std::stable_sort(flagged.begin(), flagged.end(), [](const auto* a, const auto* b) {
    return a->statistic / a->critical > b->statistic / b->critical;
  });
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Set-up", left("Target"), "Statistic", "Critical value", "Degrees of freedom"});
  Scope body(html, "tbody");
  for (const auto* p : flagged)
    table_row(html, {p->set_up, left(p->to), fixed(p->statistic, 1), fixed(p->critical, 1), std::to_string(p->rank)});
}

}  // namespace

void write_network(Markup& html, const NetworkPage& network, const SurveyComparisonT* control) {
  Scope part(html, "section", {{"id", "network"}});
  html.element("h2", "Survey network");
  write_banner(html, network);
  html.element("p", {{"class", "note"}},
               count(static_cast<long>(network.points.size()), "point", "points") + ", " +
                   count(static_cast<long>(network.observations.size()), "observation", "observations") + ", " +
                   count(network.unknowns, "unknown", "unknowns") + ", " +
                   count(network.degrees_of_freedom, "degree of freedom", "degrees of freedom") +
                   "; standard deviation of unit weight " + fixed(network.sigma0, 3) +
                   ". Datum: " + datum_in_words(network) + ".");
  if (!network.stochastic_model.empty())
    html.element("p", {{"class", "note"}}, "Precision assumed, " + network.stochastic_model + ".");
  const std::string about = (network.instrument.empty() ? "" : "Instrument: " + network.instrument + ". ") +
                            (network.date.empty() ? "" : "Date: " + network.date + ". ") +
                            (network.files.empty() ? "" : "Files: " + text::join(network.files) + ".");
  if (!about.empty()) html.element("p", {{"class", "note"}}, about);
  write_global_test(html, network);
  write_findings(html, network);
  if (control) write_control_check(html, *control);
  write_network_drawings(html, network);
  write_points(html, network);
  write_relative(html, network);
  write_set_ups(html, network);
  write_removed(html, network);
  write_pointings(html, network);
  write_groups(html, network);
  write_observations(html, network);
}

}  // namespace plumbline::report

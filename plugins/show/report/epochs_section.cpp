// Two epochs of a network: are they congruent, which points have moved; and control points tested the same way.
#include <algorithm>
#include <cmath>

#include "base/text/words.hpp"
#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/network_drawing.hpp"
#include "show/report/network_page.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

std::vector<std::string> moved_points(const SurveyComparisonT& c) {
  std::vector<std::string> ids;
  for (const auto& p : c.points)
    if (p->moved) ids.push_back(p->id);
  return ids;
}

std::string test_in_words(const SurveyComparisonT& c) {
  return "test statistic " + fixed(c.statistic, 1) + " against " + fixed(c.critical, 1) + ", " +
         count(c.rank, "degree of freedom", "degrees of freedom") + ", error of the first kind " + percent(c.alpha);
}

std::string datum_in_words(int motions) {
  switch (motions) {
    case 0:
      return "Both are in one fixed frame.";
    case 3:
      return "They may be shifted against each other.";
    case 4:
      return "They may be shifted against each other and turned about the vertical: free networks say nothing of that.";
    case 5:
      return "They may be shifted, turned about the vertical and scaled against each other.";
    default:
      return "They may be shifted, turned and tilted against each other.";
  }
}

void write_box(Markup& html, bool good, const std::string& heading, const std::string& more) {
  const auto verdict = good ? ToleranceVerdict::pass : ToleranceVerdict::fail;
  Scope box(html, "div", {{"class", std::string("verdict ") + verdict_class(verdict)}});
  {
    Scope svg = drawing(html, 44, 46, heading);
    verdict_symbol(html, 22, 23, 16, verdict, false);
  }
  Scope words(html, "div");
  html.element("strong", heading);
  html.element("p", more);
}

void write_exclusions(Markup& html, const SurveyComparisonT& c, const std::string& what) {
  if (c.excluded.empty()) return;
  html.element("h3", "How they were found");
  html.element("p", "One after another, " + what +
                        " without which the others fit each other best is taken out, until the rest passes the test.");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Step", left("Taken out"), "Statistic of the rest", "Critical value", left("Not told apart from")});
  Scope body(html, "tbody");
  for (std::size_t i = 0; i < c.excluded.size(); ++i) {
    const PointExclusionT& e = *c.excluded[i];
    table_row(html, {std::to_string(i + 1), left(verbatim(e.id)), fixed(e.statistic, 1), fixed(e.critical, 1),
                     left(e.alternatives.empty() ? unknown : text::join(e.alternatives))});
  }
}

void write_movements(Markup& html, const SurveyComparisonT& c, const std::string& found) {
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html,
             {"Point", "E [mm]", "N [mm]", "H [mm]", "σE [mm]", "σN [mm]", "σH [mm]",
              "Test (critical " + fixed(c.critical_point, 1) + ")", "Detectable in height [mm]", left("Verdict")});
  std::vector<const PointMovementT*> order;
  for (const auto& p : c.points) order.push_back(p.get());
  std::stable_sort(order.begin(), order.end(), [](const auto* a, const auto* b) {
    return a->moved != b->moved ? a->moved : a->statistic > b->statistic;
  });
  Scope body(html, "tbody");
  for (const auto* p : order)
    table_row(html, {verbatim(p->id), signed_mm(p->movement.x()), signed_mm(p->movement.y()),
                     signed_mm(p->movement.z()), mm(p->sigma.x()), mm(p->sigma.y()), mm(p->sigma.z()),
                     fixed(p->statistic, 1), mm(p->detectable_height), left(p->moved ? found : "")});
}

NetworkPage drawing_of(const SurveyComparisonT& c) {
  NetworkPage page;
  page.shown = "the movements";
  page.ellipses = "95\u00A0% confidence of the movement, at the head of its arrow";
  page.rings = "points that have moved";
  for (const auto& p : c.points) {
    NetworkPage::Point& point = page.points.emplace_back();
    point.id = p->id, point.position = p->position;
    point.movement = p->movement, point.moved = p->moved, point.datum = p->moved;
    if (p->ellipsoid) point.covariance = covariance_of(*p->ellipsoid);
  }
  return page;
}

void write_left_out(Markup& html, const SurveyComparisonT& c) {
  const auto tell = [&](const char* what, const std::vector<std::string>& ids) {
    if (!ids.empty()) html.element("p", {{"class", "note"}}, what + text::join(ids) + ".");
  };
  tell("In the first epoch only: ", c.only_first);
  tell("In the second epoch only: ", c.only_second);
  tell("Not compared (free instrument stations, incomplete coordinates, held without error): ", c.left_out);
}

}  // namespace

void write_epochs(Markup& html, const SurveyComparisonT& c) {
  Scope part(html, "section", {{"id", "epochs"}});
  html.element("h2", "Movement between two epochs");
  const auto moved = moved_points(c);
  const std::string heading =
      moved.empty()
          ? (c.congruent ? "No point has moved significantly." : "The epochs differ, but no single point explains it.")
          : count(static_cast<long>(moved.size()), "point has", "points have") + " moved: " + text::join(moved) + ".";
  write_box(html, moved.empty() && c.congruent, heading,
            count(static_cast<long>(c.points.size()), "common point", "common points") + ", global congruency test " +
                (c.congruent ? "passed: " : "failed: ") + test_in_words(c) + ". " + datum_in_words(c.free_motions));
  for (const std::string& note : c.notes) html.element("p", {{"class", "note"}}, "Note: " + note + ".");
  write_network_drawings(html, drawing_of(c));
  html.element("h3", "Movement of every point, most significant first");
  html.element("p",
               "Second epoch minus first, in the datum of the points that have not moved. A point has moved if it "
               "had to be taken out of the datum, or if its own test exceeds the critical value (error of the "
               "first kind " +
                   percent(c.alpha0) + "). Detectable: the smallest movement in height found with a probability of " +
                   percent(c.power, 0) + ".");
  write_movements(html, c, "moved");
  write_exclusions(html, c, "the point");
  write_left_out(html, c);
}

void write_control_warning(Markup& html, const SurveyComparisonT& c) {
  if (c.rank == 0 || (c.congruent && moved_points(c).empty())) return;
  Scope box(html, "div", {{"class", "warnings"}});
  html.element("h2", "The control points do not all fit the observations");
  const auto bad = moved_points(c);
  std::string test = test_in_words(c);
  test[0] = 'T';
  html.element("p", (bad.empty() ? std::string("No single point explains it")
                                 : "Look at " + text::join(bad) + ": moved, or coordinates of another point") +
                        "; all results below lean on them. " + test + ".");
}

void write_control_check(Markup& html, const SurveyComparisonT& c) {
  html.element("h3", "Control points");
  if (c.rank == 0) {
    html.element("p", "Not tested: " + c.remark + ".");
    return;
  }
  html.element("p", std::string(c.congruent ? "The given coordinates fit the observations: "
                                            : "The given coordinates do not fit the observations: ") +
                        test_in_words(c) +
                        ". The observations were adjusted without control, as a free network, and compared with it.");
  Scope details(html, "details");
  if (!c.congruent)
    html.element("summary", "Measured minus given, point by point");
  else
    html.element("summary", "Measured minus given: nothing significant");
  write_movements(html, c, "does not fit");
  write_exclusions(html, c, "the control point");
}

}  // namespace plumbline::report

// A planned survey: does it keep the rules, what will it be able to say, and what mends it.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "show/report/format.hpp"
#include "show/report/language.hpp"
#include "show/report/network_drawing.hpp"
#include "show/report/network_page.hpp"
#include "show/report/plot.hpp"
#include "show/report/sections.hpp"

namespace plumbline::report {

namespace {

NetworkPage drawing_of(const SurveyPlanT& plan) {
  NetworkPage page;
  page.shown = "the planned survey";
  page.ellipses = "predicted, 95\u00A0% confidence";
  page.rings = "markers of the lowest floor, which the prediction refers to";
  std::set<std::string> stations;
  for (const auto& s : plan.sights) stations.insert(s->set_up);
  const std::set<std::string> datum(plan.datum_points.begin(), plan.datum_points.end());
  std::map<std::string, const NetworkEllipsoidT*> ellipsoids;
  for (const auto& e : plan.ellipsoids) ellipsoids[e->id] = e.get();
  for (const auto& p : plan.points) {
    NetworkPage::Point& point = page.points.emplace_back();
    point.id = p->id, point.position = p->position;
    if (const auto e = ellipsoids.find(p->id); e != ellipsoids.end()) point.covariance = covariance_of(*e->second);
    point.station = stations.contains(p->id), point.datum = datum.contains(p->id);
  }
  for (const auto& s : plan.sights) {
    NetworkPage::Observation& o = page.observations.emplace_back();
    o.from = s->set_up, o.to = s->marker;
  }
  return page;
}

void write_verdict_box(Markup& html, const SurveyPlanT& plan) {
  const auto broken = std::count_if(plan.rules.begin(), plan.rules.end(), [](const auto& r) { return !r->holds; });
  const auto verdict = broken == 0 ? ToleranceVerdict::pass : ToleranceVerdict::fail;
  Scope box(html, "div", {{"class", std::string("verdict ") + verdict_class(verdict)}});
  {
    Scope svg = drawing(html, 44, 46, broken == 0 ? "plan holds" : "plan does not hold");
    verdict_symbol(html, 22, 23, 16, verdict, false);
  }
  Scope words(html, "div");
  html.element("strong", broken == 0 ? std::string("The plan keeps all rules.")
                                     : count(broken, "rule is broken.", "rules are broken."));
  html.element(
      "p", count(static_cast<long>(plan.sights.size()), "sight", "sights") +
               (plan.profile.empty() ? std::string() : " with the instrument profile " + verbatim(plan.profile)) +
               ", " + count(plan.sets, "set", "sets") + " in both faces. Nothing was measured yet: precision is what " +
               "the adjustment will have if the instrument keeps its profile.");
}

void write_rules(Markup& html, const SurveyPlanT& plan) {
  html.element("h3", "Rules of marker and station placement");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Rule", left("Held"), left("What was found")});
  Scope body(html, "tbody");
  for (const auto& rule : plan.rules) {
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}}, rule->name);
    {
      Scope cell(html, "td", {{"class", "text"}});
      Scope badge(html, "span", {{"class", rule->holds ? "badge pass" : "badge fail"}});
      html.text(rule->holds ? "✓ held" : "✗ violated");
    }
    html.element("td", {{"class", "words"}}, rule->text);
  }
}

void write_remedies(Markup& html, const SurveyPlanT& plan) {
  html.element("h3", "What would mend it");
  if (plan.remedies.empty()) {
    const bool holds = std::all_of(plan.rules.begin(), plan.rules.end(), [](const auto& r) { return r->holds; });
    html.element("p", holds ? "Nothing to mend." : "Nothing was found that one more set-up or more sights would mend.");
    return;
  }
  html.element(
      "p",
      "Cheapest first; each was tried out on the plan and makes its rule hold. Cost in sightings; a new set-up "
      "counts as ten more. Several for one rule are alternatives. A dash: it costs markers or a decision, not "
      "sightings.");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  table_head(html, {"Rule", left("What to do"), "Cost"});
  Scope body(html, "tbody");
  for (const auto& remedy : plan.remedies) {
    Scope row(html, "tr");
    html.element("th", {{"scope", "row"}}, remedy->rule);
    html.element("td", {{"class", "words"}}, remedy->text);
    html.element("td", remedy->sightings > 0 ? std::to_string(remedy->sightings) : unknown);
  }
}

void write_transfer_table(Markup& html, const SurveyPlanT& plan) {
  if (plan.drifts.size() < 2) return;
  html.element("h3", "Predicted precision of heights");
  html.element(
      "p",
      "σ of the step from floor to floor (E_transfer, equation 13), between the means of the floors and within "
      "each vertical column, and σ of the cumulative drift D(F) (equation 2) by the survey alone. Heights refer "
      "to the markers of the lowest floor.");
  std::set<int> columns;
  std::map<std::pair<int, int>, double> sigma;  // upper floor, column
  for (const auto& t : plan.transfers) {
    columns.insert(t->column);
    sigma[{t->to_floor, t->column}] = t->sigma;
  }
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table");
  std::vector<Cell> head = {"Floor", "D(F) [mm]"};
  for (int c : columns)
    head.emplace_back(c == 0 ? std::string("Step from below, floor means [mm]")
                             : "Step in column " + std::to_string(c) + " [mm]");
  table_head(html, head);
  Scope body(html, "tbody");
  for (const auto& d : plan.drifts) {
    std::vector<Cell> cells = {std::to_string(d->floor), mm(d->sigma)};
    for (int c : columns) {
      const auto at = sigma.find({d->floor, c});
      cells.emplace_back(at == sigma.end() ? unknown : mm(at->second));
    }
    table_row(html, cells);
  }
}

void write_markers(Markup& html, const SurveyPlanT& plan) {
  std::map<std::string, std::vector<const PlannedSightT*>> sights;
  for (const auto& s : plan.sights) sights[s->marker].push_back(s.get());
  Scope details(html, "details");
  html.element("summary", "Predicted precision of every marker");
  Scope wide(html, "div", {{"class", "wide"}});
  Scope table(html, "table", {{"class", "sortable"}});
  table_head(html, {"Marker", "σE [mm]", "σN [mm]", "σH [mm]", "Set-ups", "Longest [m]", "Most oblique [°]"});
  Scope body(html, "tbody");
  for (const auto& p : plan.points) {
    const auto seen = sights.find(p->id);
    if (seen == sights.end()) continue;
    double length = 0, incidence = 0;
    for (const PlannedSightT* s : seen->second)
      length = std::max(length, s->length), incidence = std::max(incidence, s->incidence);
    table_row(html, {verbatim(p->id), mm(p->sigma.x()), mm(p->sigma.y()), mm(p->sigma.z()),
                     std::to_string(seen->second.size()), fixed(length, 1), fixed(incidence * 180 / M_PI, 0)});
  }
}

}  // namespace

void write_plan(Markup& html, const SurveyPlanT& plan) {
  Scope part(html, "section", {{"id", "plan"}});
  html.element("h2", "Rules, remedies and predicted precision");
  write_verdict_box(html, plan);
  write_rules(html, plan);
  write_remedies(html, plan);
  write_transfer_table(html, plan);
  write_network_drawings(html, drawing_of(plan));
  write_markers(html, plan);
}

}  // namespace plumbline::report

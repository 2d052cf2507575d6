#include "judge_node.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "base/text/text.hpp"
#include "building/ifc/doubt_words.hpp"
#include "building/ifc/enlarged_surfaces.hpp"
#include "building/ifc/surface_words.hpp"
#include "building/judgement/surfaces.hpp"
#include "building/judgement/trust.hpp"
#include "faces.hpp"
#include "surface_artifacts.hpp"

namespace plumbline::surface {
namespace {

std::map<std::string, ifc::ElementFacts> facts_of(const DesignT& design,
                                                  std::vector<std::vector<ifc::Property>>& properties) {
  std::map<std::string, ifc::ElementFacts> facts;
  properties.reserve(design.elements.size());  // facts point into it
  const std::set<std::string> wholes = wholes_of_panels(design);
  for (const auto& element : design.elements) {
    if (!element->is_panel || wholes.contains(element->guid)) continue;
    properties.emplace_back();
    for (const auto& property : element->properties)
      properties.back().push_back({property->set, property->name, property->text, property->number, property->measure,
                                   property->lower, property->upper, property->holder});
    facts[element->guid] = {element->class_,      element->guid,      element->name,   element->tag,
                            element->object_type, element->type_name, element->storey, &properties.back()};
  }
  return facts;
}

const char* word_of(const SurfaceVerdictT& verdict) {
  if (!verdict.not_judged.empty()) return "NOT JUDGED";
  if (verdict.verdict == ToleranceVerdict::pass) return "PASS";
  return verdict.verdict == ToleranceVerdict::fail ? "FAIL" : "UNDECIDED";
}

std::string millimetres(double metres) { return std::isfinite(metres) ? text::format_fixed(1e3 * metres, 3) : ""; }

std::string name_of(const SurfaceVerdictT& verdict) {
  return verdict.second.empty() ? verdict.panel : verdict.panel + " | " + verdict.second;
}

std::string table_of(const SurfaceJudgementT& judgement) {
  std::string text =
      "panel,second,quantity,verdict,value_mm,sigma_mm,lower_mm,upper_mm,probability,along_mm,places,looked_at,not_"
      "judged,rule\n";
  for (const auto& verdict : judgement.verdicts) {
    std::string probability;
    if (std::isfinite(verdict->probability)) probability = fmt::format("{:.4f}", verdict->probability);
    const bool of_joint = !verdict->second.empty();
    text += csv_text(verdict->panel) + "," + csv_text(verdict->second) + "," + ifc::quantity_of(*verdict) + "," +
            word_of(*verdict) + "," + millimetres(verdict->value) + "," + millimetres(verdict->sigma) + "," +
            millimetres(verdict->lower) + "," + millimetres(verdict->upper) + "," + probability + "," +
            millimetres(verdict->along) + "," + (of_joint ? std::to_string(verdict->places) : "") + "," +
            (of_joint ? std::to_string(verdict->looked_at) : "") + "," + csv_text(verdict->not_judged) + "," +
            csv_text(verdict->rule) + "\n";
  }
  return text;
}

}  // namespace

void JudgeSurfaces::run(Context& context) {
  std::vector<judgement::SurfaceRule> parsed;
  for (const std::string& rule : *rules) parsed.push_back(judgement::parse_surface_rule(rule));
  if (parsed.empty()) context.warn("there are no 'rules': nothing is judged");
  std::vector<std::vector<ifc::Property>> properties;
  std::map<std::string, ifc::ElementFacts> facts;
  if (design) facts = facts_of(design.unpack(), properties);
  const judgement::Trust trust =
      judgement::trust_of(block ? &*block : nullptr, network ? &*network : nullptr, judgement::Judged::surfaces);
  SurfacesT measured = surfaces.unpack();
  ifc::enlarge(measured, trust.factor);
  SurfaceJudgementT result = judgement::judge_surfaces(measured, facts, parsed, *risk, *within);
  result.covariance_factor = trust.factor;
  if (!trust.doubts.empty()) judgement::leave_open(result);
  for (const MeasurementDoubtT& doubt : trust.doubts)
    context.warn("not to be trusted, and nothing is decided: " + ifc::in_words(doubt));
  for (const MeasurementDoubtT& misfit : trust.misfits) context.warn(ifc::in_words(misfit));
  for (const std::string& remark : result.remarks) context.warn(remark);
  int open = 0;
  for (const auto& request : result.requests)
    if (!request->not_judged.empty())
      ++open, context.warn("the rule '" + request->asked + "' is not judged: " + request->not_judged);
  for (const auto& verdict : result.verdicts) {
    if (!verdict->not_judged.empty())
      context.warn(name_of(*verdict) + ", " + ifc::quantity_of(*verdict) + ": NOT JUDGED, " + verdict->not_judged);
    if (verdict->not_judged.empty() && verdict->verdict == ToleranceVerdict::fail)
      context.warn(name_of(*verdict) + ", " + ifc::quantity_of(*verdict) + ": FAIL, " + millimetres(verdict->value) +
                   " mm with a standard deviation of " + millimetres(verdict->sigma) + " mm");
  }
  context.info(std::to_string(result.passed) + " pass, " + std::to_string(result.undecided) + " undecided, " +
               std::to_string(result.failed) + " fail, " + std::to_string(result.not_judged) + " not judged");
  context.metric("surfaces_passed", result.passed, "1");
  context.metric("surfaces_undecided", result.undecided, "1");
  context.metric("surfaces_failed", result.failed, "1");
  context.metric("surfaces_not_judged", result.not_judged, "1");
  context.metric("surface_rules_not_judged", open, "1");
  if (open > 0 || !trust.doubts.empty())
    context.metric("invalid", 1, "1");  // a question without an answer: exit code 3
  judgement.commit(result);
  FileT file;
  file.name = "surface_verdicts.csv", file.media_type = "text/csv";
  const std::string text = table_of(result);
  file.content.assign(text.begin(), text.end());
  table.commit(file);
}

}  // namespace plumbline::surface

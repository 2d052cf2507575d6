// metrics.json: what was judged, as a file, from the artifacts of the judgement. No library: it knows artifacts.
#include <nlohmann/json.hpp>

#include "build/evaluate/long_lists.hpp"
#include "build/evaluate/metrics.hpp"
#include "building/ifc/doubt_words.hpp"

namespace plumbline::judgement {

namespace {

using Json = nlohmann::ordered_json;  // keeps our order; prints nan as null

Json to_json(const AnchorDifferenceT* d) {
  if (!d) return nullptr;
  return {{"dx", d->dx},
          {"dy", d->dy},
          {"dz", d->dz},
          {"distance", d->distance},
          {"u_dz", d->u_dz},
          {"u_distance", d->u_distance},
          {"covariance", d->covariance},
          {"verdict", EnumNameToleranceVerdict(d->verdict)},
          {"conformance_probability", d->conformance_probability},
          {"verdict_distance", EnumNameToleranceVerdict(d->verdict_distance)}};
}

Json to_json(const AnchorAccuracyT& a) {
  return {{"id", a.id},
          {"floor", a.floor},
          {"column", a.column},
          {"row", a.row},
          {"use", EnumNameAnchorUse(a.use)},
          {"position", {a.x, a.y, a.z}},
          {"verdict", EnumNameToleranceVerdict(a.survey ? a.survey->verdict : ToleranceVerdict::not_measured)},
          {"note", a.note},
          {"survey", to_json(a.survey.get())},
          {"truth", to_json(a.truth.get())}};
}

Json to_json(const FloorAccuracyT& f) {
  return {{"floor", f.floor},
          {"anchors", f.anchors},
          {"mean_dz", f.mean_dz},
          {"u_mean_dz", f.u_mean_dz},
          {"drift", f.drift},
          {"u_drift", f.u_drift},
          {"drift_verdict", EnumNameToleranceVerdict(f.drift_verdict)},
          {"smallest_tolerance_met", f.smallest_tolerance_met},
          {"relative_drift", f.relative_drift},
          {"u_relative_drift", f.u_relative_drift},
          {"rmse_z", f.rmse_z},
          {"max_abs_dz", f.max_abs_dz}};
}

Json to_json(const DriftSlopeT* s) {
  if (!s) return nullptr;
  return {{"per_floor", s->per_floor}, {"u_per_floor", s->u_per_floor}, {"lower", s->lower},
          {"upper", s->upper},         {"p_value", s->p_value},         {"scatter_per_floor", s->scatter_per_floor}};
}

Json to_json(const PassRateT& p) {
  return {{"tolerance", p.tolerance}, {"passed", p.passed}, {"evaluated", p.evaluated},    {"rate", p.rate},
          {"lower", p.lower},         {"upper", p.upper},   {"exact_lower", p.exact_lower}};
}

Json to_json(const HeightTransferT& t) {
  return {{"lower_floor", t.lower_floor},
          {"upper_floor", t.upper_floor},
          {"column", t.column == 0 ? Json(nullptr) : Json(t.column)},
          {"anchors", t.anchors},
          {"difference", t.difference},
          {"error", t.error},
          {"u", t.u},
          {"verdict", EnumNameToleranceVerdict(t.verdict)}};
}

Json to_json(const ColumnDriftT& c) {
  return {{"column", c.column},
          {"lowest_floor", c.lowest_floor},
          {"highest_floor", c.highest_floor},
          {"anchors", c.anchors},
          {"drift", c.drift},
          {"u_drift", c.u_drift},
          {"drift_verdict", EnumNameToleranceVerdict(c.drift_verdict)},
          {"relative_drift", c.relative_drift},
          {"u_relative_drift", c.u_relative_drift},
          {"relative_verdict", EnumNameToleranceVerdict(c.relative_verdict)},
          {"slope", to_json(c.slope.get())}};
}

Json to_json(const ErrorConsistencyT* c) {
  if (!c) return nullptr;
  return {{"statistic", c->statistic},
          {"degrees_of_freedom", c->degrees_of_freedom},
          {"lower", c->lower},
          {"upper", c->upper},
          {"probability", c->probability},
          {"consistent", c->statistic >= c->lower && c->statistic <= c->upper}};
}

Json to_json(const AccuracyComparisonT& c);
Json to_json(const PanelDeviationT& p);
Json to_json(const JudgedAxisT& a);
Json to_json(const AnchorDeviationT& a);
Json to_json(const FloorDeviationT& f);
Json to_json(const PanelFixingT& f);
Json to_json(const PanelJointT& j);
Json to_json(const JudgementRequestT& r);
Json to_json(const MeasurementDoubtT& d);

template <typename T>
Json list(const std::vector<std::unique_ptr<T>>& items) {
  Json out = Json::array();
  for (const auto& item : items) out.push_back(to_json(*item));
  return out;
}

Json to_json(const AccuracyComparisonT& c) {
  return {{"use", EnumNameAnchorUse(c.use)},
          {"reference", EnumNameAccuracyReference(c.reference)},
          {"evidence", c.evidence},
          {"evidence_note", c.evidence_note},
          {"anchors", c.anchors},
          {"anchors_listed", c.anchors_listed},
          {"pass", c.passed},
          {"undecided", c.undecided},
          {"fail", c.failed},
          {"mean_dz", c.mean_dz},
          {"u_mean_dz", c.u_mean_dz},
          {"deviation_dz", c.deviation_dz},
          {"rmse_z", c.rmse_z},
          {"max_abs_dz", c.max_abs_dz},
          {"worst_anchor", c.worst_anchor},
          {"rmse_3d", c.rmse_3d},
          {"max_distance", c.max_distance},
          {"predicted_rmse_z", c.predicted_rmse_z},
          {"predicted_rmse_z_range", {c.predicted_rmse_z_lower, c.predicted_rmse_z_upper}},
          {"predicted_rmse_3d", c.predicted_rmse_3d},
          {"drift_computed", c.drift_computed},
          {"floors", list(c.floors)},
          {"slope", to_json(c.slope.get())},
          {"pass_rates", list(c.pass_rates)},
          {"transfers", list(c.transfers)},
          {"columns", list(c.columns)},
          {"consistency_z", to_json(c.consistency_z.get())},
          {"consistency_3d", to_json(c.consistency_3d.get())}};
}

Json to_json(const StatisticsT& s) {
  return {{"sigma0", s.sigma0},
          {"degrees_of_freedom", s.degrees_of_freedom},
          {"weighted_sum_of_squares", s.weighted_sum_of_squares},
          {"observations", s.observations},
          {"unknowns", s.unknowns},
          {"datum_defect", s.datum_defect}};
}

Json to_json(const AdjustmentSummaryT* a) {
  if (!a) return nullptr;
  return {
      {"datum", a->datum}, {"weighting", a->weighting}, {"lambda", a->lambda}, {"statistics", to_json(*a->statistics)}};
}

Json to_json(const RegistrationSummaryT* r) {
  if (!r) return nullptr;
  return {{"statistics", to_json(*r->statistics)},
          {"down_weighted", r->down_weighted},
          {"residual_covariance", r->residual_covariance},
          {"residual_covariance_unbiased", r->residual_covariance_unbiased}};
}

Json to_json(const JudgedLengthT& length) {
  return {{"value", length.value},
          {"u", length.u},
          {"tolerance", length.tolerance},
          {"verdict", EnumNameToleranceVerdict(length.verdict)}};
}

Json to_json(const PanelFixingT& f) {
  return {{"anchor", f.anchor}, {"shim", f.shim}, {"u_shim", f.u_shim}, {"sideways", f.sideways}, {"upward", f.upward}};
}

Json to_json(const PanelJointT& j) {
  return {{"panel", j.panel},         {"side", j.side},     {"design", j.design},
          {"narrowest", j.narrowest}, {"widest", j.widest}, {"change", to_json(*j.change)}};
}

Json to_json(const PanelDeviationT& p) {
  return {{"guid", p.guid},
          {"name", p.name},
          {"floor", p.floor},
          {"anchors", list(p.fixings)},
          {"missing", p.missing},
          {"out_of_plane", to_json(*p.out_of_plane)},
          {"sideways", to_json(*p.sideways)},
          {"vertical", to_json(*p.vertical)},
          {"lean", p.lean},
          {"u_lean", p.u_lean},
          {"turn", p.turn},
          {"u_turn", p.u_turn},
          {"roll", p.roll},
          {"u_roll", p.u_roll},
          {"tilt", to_json(*p.tilt)},
          {"warp", to_json(*p.warp)},
          {"misfit", to_json(*p.misfit)},
          {"corner", to_json(*p.corner)},
          {"joints", list(p.joints)},
          {"verdict", EnumNameToleranceVerdict(p.verdict)},
          {"decided_by", p.decided_by},
          {"reason", p.reason}};
}

Json to_json(const FacadeFrameT* f) {
  if (!f) return nullptr;
  return {{"name", f->facade},
          {"source", f->source},
          {"confirmed", f->confirmed},
          {"out", {f->out.x(), f->out.y(), f->out.z()}},
          {"note", f->note}};
}

Json to_json(const MeasurementDoubtT& d) {
  return {{"part", EnumNameMeasurementPart(d.part)},
          {"grade", EnumNameDoubtGrade(d.grade)},
          {"reason", d.reason},
          {"factor", d.factor},
          {"mend", d.mend},
          {"mend_note", d.mend_note}};
}

Json to_json(const JudgementRequestT& r) {
  return {{"asked", r.asked}, {"by", r.by}, {"anchors", r.anchors}, {"panels", r.panels}, {"not_judged", r.not_judged}};
}

Json to_json(const JudgedAxisT& a) {
  return {{"axis", a.axis},
          {"value", a.value},
          {"u", a.u},
          {"tolerance", a.tolerance},
          {"below", a.below},
          {"above", a.above},
          {"verdict", verdict_word(a)},
          {"probability", a.probability},
          {"source", a.source}};
}

Json to_json(const AnchorDeviationT& a) {
  return {{"id", a.id},
          {"guid", a.guid},
          {"floor", a.floor},
          {"use", a.use},
          {"deviation", {a.deviation.x(), a.deviation.y(), a.deviation.z()}},
          {"facade", to_json(a.facade.get())},
          {"axes", list(a.axes)},
          {"verdict", EnumNameToleranceVerdict(a.verdict)},
          {"decided_by", a.decided_by},
          {"pass_probability", a.pass_probability},
          {"note", a.note}};
}

Json to_json(const FloorDeviationT& f) {
  return {{"floor", f.floor},
          {"storey", f.storey},
          {"pass", f.passed},
          {"undecided", f.undecided},
          {"fail", f.failed},
          {"not_measured", f.not_measured},
          {"panels_pass", f.panels_passed},
          {"panels_undecided", f.panels_undecided},
          {"panels_fail", f.panels_failed},
          {"pass_together", f.pass_together},
          {"verdict", EnumNameToleranceVerdict(f.verdict)}};
}

Json to_json(const DeviationT* d) {
  if (!d) return nullptr;
  return {{"verdict", EnumNameToleranceVerdict(d->verdict)},
          {"pass", d->passed},
          {"undecided", d->undecided},
          {"fail", d->failed},
          {"not_measured", d->not_measured},
          {"risk", d->risk},
          {"pass_together", d->pass_together},
          {"not_judged", d->not_judged},
          {"requests", list(d->requests)},
          {"doubts", list(d->doubts)},
          {"misfits", list(d->misfits)},
          {"datum", d->datum},
          {"common_shift", d->common_shift ? d->common_shift->words : ""},
          {"floors", list(d->floors)},
          {"anchors", place_of_list("anchors")}};
}

const AccuracyComparisonT* headline(const AccuracyT& accuracy) {
  for (const auto& c : accuracy.comparisons)
    if (c->use == AnchorUse::check && c->reference == AccuracyReference::survey) return c.get();
  return nullptr;
}

}  // namespace

std::string overall_verdict(const AccuracyT& accuracy) {
  const AccuracyComparisonT* c = headline(accuracy);
  if (!c || c->anchors == 0) return "no_evidence";
  if (c->failed > 0) return "fail";
  // What agrees in height and not in space has not been built where it should be.
  for (const auto& anchor : accuracy.anchors)
    if (anchor->use == AnchorUse::check && anchor->survey && anchor->survey->verdict_distance == ToleranceVerdict::fail)
      return "fail";
  return c->undecided > 0 || c->anchors < c->anchors_listed ? "undecided" : "pass";
}

std::string metrics_json(const AccuracyT& accuracy, const DeviationT* deviation) {
  const AccuracyComparisonT* c = headline(accuracy);
  const Json verdict = {{"overall", overall_verdict(accuracy)},
                        {"anchors", c ? c->anchors : 0},
                        {"pass", c ? c->passed : 0},
                        {"undecided", c ? c->undecided : 0},
                        {"fail", c ? c->failed : 0},
                        {"not_measured", c ? c->anchors_listed - c->anchors : 0}};
  std::vector<std::string> warnings = accuracy.warnings;
  if (deviation) {
    for (const auto& doubt : deviation->doubts)
      warnings.insert(warnings.begin(), "Not to be trusted, " + ifc::in_words(*doubt));
    for (const auto& misfit : deviation->misfits) warnings.push_back(ifc::in_words(*misfit));
    warnings.insert(warnings.end(), deviation->warnings.begin(), deviation->warnings.end());
  }
  const Json document = {{"format", "plumbline-metrics/2"},
                         {"units", {{"length", "m"}, {"angle", "rad"}, {"covariance", "m2"}, {"probability", "1"}}},
                         {"tau", accuracy.tau},
                         {"guard_factor", accuracy.guard_factor},
                         {"confidence", accuracy.confidence},
                         {"anchors_needed", accuracy.anchors_needed},
                         {"verdict", verdict},
                         {"comparisons", list(accuracy.comparisons)},
                         {"anchors", place_of_list("anchors")},
                         {"deviation", to_json(deviation)},
                         {"panels", place_of_list("panels")},
                         {"adjustment", to_json(accuracy.adjustment.get())},
                         {"registration", to_json(accuracy.registration.get())},
                         {"correlation_note", accuracy.correlation_note},
                         {"warnings", warnings}};
  // Ids come from files in any encoding: an invalid byte becomes U+FFFD instead of an exception.
  std::string text = document.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
  const auto item = [](const auto& one) { return to_json(*one); };
  put_list(text, "anchors", accuracy.anchors, item);  // in the order of the document
  if (deviation) put_list(text, "anchors", deviation->anchors, item);
  const std::vector<std::unique_ptr<PanelDeviationT>> none;
  put_list(text, "panels", deviation ? deviation->panels : none, item);
  return text;
}

}  // namespace plumbline::judgement

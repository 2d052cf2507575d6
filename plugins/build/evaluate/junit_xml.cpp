// Verdicts as JUnit XML and as a stake-out table.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <vector>

#include "base/text/text.hpp"
#include "base/text/xml_text.hpp"
#include "build/evaluate/metrics.hpp"
#include "building/ifc/doubt_words.hpp"
#include "building/ifc/limit_words.hpp"
#include "building/ifc/shift_words.hpp"
#include "building/ifc/surface_words.hpp"
#include "building/judgement/facade_order.hpp"
#include "building/judgement/worst_first.hpp"

namespace plumbline::judgement {

namespace {

std::string fixed(double value, int decimals) {
  return std::isfinite(value) ? text::format_fixed(value, decimals) : "";
}

using text::xml_escaped;

struct Case {
  std::string name, message;
  ToleranceVerdict verdict;
};

/// `said`: of all cases together, a line each.
std::string suite(const std::string& name, const std::vector<Case>& cases, const std::string& said = "") {
  int failures = 0, skipped = 0;
  for (const Case& c : cases) {
    failures += c.verdict == ToleranceVerdict::fail || c.verdict == ToleranceVerdict::undecided;
    skipped += c.verdict == ToleranceVerdict::not_measured;
  }
  std::string text = "  <testsuite name=\"" + name + "\" tests=\"" + std::to_string(cases.size()) + "\" failures=\"" +
                     std::to_string(failures) + "\" errors=\"0\" skipped=\"" + std::to_string(skipped) + "\">\n";
  for (const Case& c : cases) {
    text += "    <testcase classname=\"" + name + "\" name=\"" + xml_escaped(c.name) + "\"";
    if (c.verdict == ToleranceVerdict::pass) {
      text += "/>\n";
    } else if (c.verdict == ToleranceVerdict::not_measured) {
      text += "><skipped message=\"" + xml_escaped(c.message) + "\"/></testcase>\n";
    } else {
      const std::string type = EnumNameToleranceVerdict(c.verdict);
      text += "><failure type=\"" + type + "\" message=\"" + xml_escaped(c.message) + "\"/></testcase>\n";
    }
  }
  if (!said.empty()) text += "    <system-out>" + xml_escaped(said) + "</system-out>\n";
  return text + "  </testsuite>\n";
}

/// Why all of it is less certain, and what anchors have in common.
std::string said_of(const DeviationT& deviation) {
  std::string said;
  for (const auto& misfit : deviation.misfits) said += "Less certain, " + ifc::in_words(*misfit) + "\n";
  for (const std::string& words : ifc::shift_words(deviation)) said += words + "\n";
  return said;
}

std::string words_of(const AnchorDeviationT& anchor) {
  for (const auto& axis : anchor.axes)
    if (axis->axis == anchor.decided_by)
      return axis->axis + " " + fixed(1e3 * axis->value, 1) + " mm, u " + fixed(1e3 * axis->u, 1) + " mm, limit " +
             ifc::limits_in_words(*axis, [](double length) { return fixed(1e3 * length, 1); }) + " mm" +
             (anchor.note.empty() ? "" : "; " + anchor.note);
  return anchor.note;
}

std::string words_of(const SurfaceVerdictT& verdict) {
  if (!verdict.not_judged.empty()) return "not judged: " + verdict.not_judged;
  return fixed(1e3 * verdict.value, 2) + " mm, u " + fixed(1e3 * verdict.sigma, 2) + " mm, limit " +
         fixed(1e3 * ifc::limit_of(verdict), 2) + " mm (" + verdict.rule + ")";
}

}  // namespace

std::string junit_xml(const AccuracyT& accuracy, const DeviationT* deviation) {
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<testsuites name=\"plumbline\">\n";
  if (deviation) {
    std::vector<Case> anchors, panels, doubts;
    for (const auto& doubt : deviation->doubts)
      doubts.push_back(
          {ifc::name_of(doubt->part), "not to be trusted, " + ifc::in_words(*doubt), ToleranceVerdict::undecided});
    if (!doubts.empty()) text += suite("measurement", doubts);
    for (const auto& a : deviation->anchors) anchors.push_back({a->id, words_of(*a), a->verdict});
    for (const auto& p : deviation->panels)
      panels.push_back({p->name.empty() ? p->guid : p->name, p->reason, p->verdict});
    std::vector<Case> surfaces, requests;
    if (deviation->surfaces)
      for (const auto& v : deviation->surfaces->verdicts)
        surfaces.push_back({(v->second.empty() ? v->panel : v->panel + " | " + v->second) + ", " + ifc::quantity_of(*v),
                            words_of(*v), v->verdict});
    for (const auto& r : deviation->requests)
      requests.push_back({r->asked, "not judged: " + r->not_judged,
                          r->not_judged.empty() ? ToleranceVerdict::pass : ToleranceVerdict::undecided});
    text += suite("anchors_against_design", anchors, said_of(*deviation)) + suite("panels", panels);
    if (!surfaces.empty()) text += suite("surfaces", surfaces);
    if (!requests.empty()) text += suite("asked_for", requests);
  }
  std::vector<Case> checks;
  for (const auto& a : accuracy.anchors) {
    if (a->use != AnchorUse::check) continue;
    const ToleranceVerdict verdict = a->survey ? a->survey->verdict : ToleranceVerdict::not_measured;
    const std::string words = a->survey ? "dz " + fixed(1e3 * a->survey->dz, 1) + " mm, u " +
                                              fixed(1e3 * a->survey->u_dz, 1) + " mm, limit " +
                                              fixed(1e3 * accuracy.tau, 1) + " mm"
                                        : a->note;
    checks.push_back({a->id, words, verdict});
  }
  return text + suite("check_anchors_against_survey", checks) + "</testsuites>\n";
}

std::string stake_out_csv(const DeviationT& deviation, const FrameLink& building_from_survey) {
  std::vector<const AnchorDeviationT*> anchors;
  for (const AnchorDeviationT* anchor : judgement::worst_first(deviation))
    if (anchor->design.allFinite()) anchors.push_back(anchor);
  by_facade(deviation, anchors);
  const std::map<std::string, std::string> codes = facade_codes(deviation);
  const Eigen::Matrix3d survey_from_building = building_from_survey.linear().inverse();
  std::string text;
  for (const AnchorDeviationT* anchor : anchors) {
    std::string id = anchor->id;
    for (char& c : id)
      if (c == ';' || static_cast<unsigned char>(c) < 0x20 || c == '"') c = '_';
    if (!id.empty() && std::string("=+-@").find(id[0]) != std::string::npos) id = "'" + id;
    text += id;
    const Eigen::Vector3d place = building_from_survey.apply_inverse(anchor->design);
    // Plan and height by themselves: one of them may be unknown, and the frames differ by a turn about the vertical.
    Eigen::Vector3d correction;
    correction << survey_from_building.topLeftCorner<2, 2>() * -anchor->deviation.head<2>(),
        -survey_from_building(2, 2) * anchor->deviation.z();
    for (int k = 0; k < 3; ++k) text += ";" + fixed(place[k], 4);
    if (!deviation.doubts.empty()) correction.setConstant(NAN);  // no order rests on a measurement that proves nothing
    for (int k = 0; k < 3; ++k) text += ";" + fixed(correction[k], 4);
    text += std::string(";") + EnumNameToleranceVerdict(anchor->verdict);
    if (const auto code = codes.find(facade_name(anchor->facade)); !codes.empty())
      text += ";" + (code == codes.end() ? std::string() : code->second);
    text += "\n";
  }
  return text;
}

}  // namespace plumbline::judgement

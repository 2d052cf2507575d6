// An evaluation as files for people and programs. Nothing is computed here: every verdict is the artifact's.
#pragma once

#include <cmath>
#include <string>

#include "artifacts/deviation.hpp"
#include "building/judgement/accuracy.hpp"
#include "geometry/frame_graph.hpp"

namespace plumbline::judgement {

/// The verdict on an axis in the files: not_judged where it was measured and no tolerance holds for it.
inline std::string verdict_word(const JudgedAxisT& axis) {
  if (axis.verdict == ToleranceVerdict::not_measured && std::isfinite(axis.value) && !(axis.tolerance > 0))
    return "not_judged";
  return EnumNameToleranceVerdict(axis.verdict);
}

/// metrics.json after schemas/metrics.schema.json: lengths in m, unknown numbers null, 17 digits. `deviation` may be
/// null.
std::string metrics_json(const AccuracyT& accuracy, const DeviationT* deviation = nullptr);

/// metrics.csv: one row an anchor in the order of the anchor table, lengths in mm, unknown cells empty. RFC 4180, LF,
/// decimal point; an id that a spreadsheet would take for a formula has an apostrophe before it.
std::string metrics_csv(const AccuracyT& accuracy, const DeviationT* deviation = nullptr);

/// metrics.xml in the format of JUnit, as CI servers read it: a suite of the anchors against the design, one of the
/// panels, one of the check anchors against the survey. A fail is a failure, what is not measured is skipped, what is
/// undecided is a failure of type `undecided`: it has not been shown to be in order.
std::string junit_xml(const AccuracyT& accuracy, const DeviationT* deviation = nullptr);

/// Stake-out table: `PtID;E;N;H;dE;dN;dH;code` with the design positions of the anchors in m and the corrections to
/// what is there, in the order of the work list, in the frame of the survey, in which the instrument stands. No header:
/// site instruments import it as it is.
std::string stake_out_csv(const DeviationT& deviation, const FrameLink& building_from_survey = {});

/// Verdict over the check anchors against the survey: "pass" if all pass in height, "fail" if one fails in height or in
/// space, "undecided" in between or when some were not measured, "no_evidence" without a check anchor.
std::string overall_verdict(const AccuracyT& accuracy);

}  // namespace plumbline::judgement

// An evaluation as files for people and programs.
#pragma once

#include <string>

#include "judgement/accuracy.hpp"

namespace plumbline::evaluate {

/// metrics.json after schemas/metrics.schema.json: lengths in m, unknown numbers null, 17 digits.
std::string metrics_json(const AccuracyT& accuracy);

/// metrics.csv: one row an anchor in the order of the anchor table, lengths in mm, unknown cells empty. RFC 4180, LF,
/// decimal point.
std::string metrics_csv(const AccuracyT& accuracy);

/// Verdict over the check anchors against the survey: "pass" if all pass, "fail" if one fails, "undecided" in between
/// or when some were not measured, "no_evidence" without a check anchor.
std::string overall_verdict(const AccuracyT& accuracy);

}  // namespace plumbline::evaluate

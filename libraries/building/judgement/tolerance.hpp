// Verdicts against a tolerance and pass rates with their confidence bounds.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "building/judgement/accuracy.hpp"

namespace plumbline::judgement {

/// Decision by conformance probability (JCGM 106:2012, 8.3): pass if P(|D| <= tau) is at least Φ(k), fail if it is at
/// most 1 - Φ(k), else undecided; with u far below tau that is |d| + k·u <= tau and |d| - k·u >= tau. `u` nan:
/// undecided, unless d itself is not finite: not measured. Lengths in m.
ToleranceVerdict verdict_of(double d, double u, double tau, double guard_factor);

/// P(|D| <= tau) for a true difference D that is normal about the estimate d with standard uncertainty u
/// (JCGM 106:2012, 7.2). u = 0 gives 0 or 1; nan for an unknown u.
double conformance_probability(double d, double u, double tau);

/// Pass rate (10) of the vertical residuals at each tolerance, with Wilson's interval and the exact one-sided lower
/// bound.
std::vector<std::unique_ptr<PassRateT>> pass_rates(const Eigen::VectorXd& heights,
                                                   const std::vector<double>& tolerances, double confidence);

/// Smallest number of anchors that, all passing, show a pass rate above `rate` at the confidence level: the least n
/// with rate^n <= 1 - confidence. 59 for 0.95 and 0.95.
int anchors_needed(double rate, double confidence);

}  // namespace plumbline::judgement

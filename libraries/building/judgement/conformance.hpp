// Conformance probability (JCGM 106:2012, 7): how likely the true values lie within their tolerances, all of them at
// once, and the verdict that follows from it and a chosen risk (8.3). Decided here for anchors, panels and whoever else
// holds a measured vector against limits.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <vector>

#include "artifacts/judgement_common.hpp"

namespace plumbline::judgement {

/// A quantity of a vector x that is held against limits: the signed value of one row, or the length of rows · x.
struct Limited {
  Eigen::MatrixXd rows;  ///< 1 x n: signed, m x n: a length
  double above = 0;      ///< [m] largest value
  double below = 0;      ///< [m] of a signed value: how far it may lie below zero; 0 or more
  bool moves = false;    ///< `above` and `below` are the common tolerance, with which they move
};

struct Conformance {
  double probability;           ///< of all quantities within their limits at once; nan: the covariance is not known
  std::vector<double> of_each;  ///< of each by itself
  double tau_pass,
      tau_fail;  ///< [m] verdict at a common tolerance: pass from tau_pass on (inf: at none), fail below tau_fail
};

/// For a true x that is normal about `mean` (n) with `covariance` (n x n, or 0 x 0: not known). By 4096 points that are
/// the same on every machine, to 0.3 %; one signed quantity alone by the normal distribution itself. `tau` is the
/// common tolerance as it stands, `risk` gives tau_pass and tau_fail.
Conformance conformance(const Eigen::VectorXd& mean, const Eigen::MatrixXd& covariance,
                        const std::vector<Limited>& quantities, double risk, double tau);

/// Pass if P >= 1 - risk, fail if P <= risk, else undecided; undecided too where P is not known.
ToleranceVerdict verdict_of(double probability, double risk);

/// The smaller of two probabilities of parts of a whole; nan where one of them is not known.
inline double least_known(double a, double b) { return std::isnan(a) || std::isnan(b) ? a + b : std::min(a, b); }

/// The verdict at another common tolerance `tau` [m] of what has the verdict `given` and turns at tau_pass and tau_fail
/// [m] (nan: nobody knows); `doubtful`: a measurement that contradicts itself lets nothing pass. The report's
/// verdict.js is the same in JavaScript.
ToleranceVerdict verdict_at(ToleranceVerdict given, double tau_pass, double tau_fail, double tau, bool doubtful);

}  // namespace plumbline::judgement

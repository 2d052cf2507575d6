// What the trials of one alternative say of it: errors with intervals, failures, distance from the bound, and whether
// its covariance states what is found.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/statistics/by_seed.hpp"

namespace plumbline::statistics {

/// What is found and what was stated of one part of the errors (heights, scale, …) in one trial; nan if unknown.
struct StatedError {
  double found = 0;      ///< root mean square [m]
  double predicted = 0;  ///< root mean square that the result's own covariance predicts [m]
  double nees = 0;       ///< eᵀ Σ⁻¹ e with the result's own covariance
  double freedom = 0;    ///< its degrees of freedom
};

/// One finished trial; nan where the pipeline does not measure a quantity. Each trial is another seed.
struct Trial {
  double rms;        ///< root mean square error of the trial's points [m]
  double bias;       ///< mean error [m]
  double worst;      ///< largest absolute error [m]
  double predicted;  ///< root mean square error that the result's own covariance predicts [m]
  double bound;      ///< root of the mean Cramér-Rao bound of the same geometry [m]
  double nees;       ///< eᵀ Σ⁻¹ e with the result's own covariance
  double freedom;    ///< its degrees of freedom
  std::map<std::string, StatedError> modes;
};

/// Share of trials that miss a tolerance.
struct FailureRate {
  double tau = 0;          ///< [m]
  std::size_t failed = 0;  ///< trials without a result, or whose worst error is above tau
  double share = 0;
  Interval interval;  ///< Wilson
};

/// A covariance against the errors of many trials. NEES of all coordinates together hides one bad mode among many good
/// ones: a scale stated 4 times too large gives 0.97 where 15 coordinates are counted, with the band from 0.91 to 1.09.
struct Calibration {
  std::string mode;    ///< "heights", "scale", …; empty: what the bench measures
  Estimate ratio;      ///< predicted / found, of the roots of the mean squares over the trials
  double nees = 0;     ///< mean per degree of freedom; nan: not known
  double freedom = 0;  ///< of all trials together
  Interval nees_band;  ///< where an honest covariance puts it with the given confidence
  std::size_t trials = 0;
  Interval strict{0, 0};  ///< of the ratio, with 99.9 %: by it many parts of many rows are judged
};

enum class Honesty { honest, too_much, too_little, unknown };
/// Too much or too little where the whole interval of the ratio is more than a tenth away from 1, and so is that
/// of 99.9 % or, of a part of one or two values a trial (scale, tilt) whose NEES is known, that lies where an honest
/// covariance puts it once in a thousand times: many parts of many rows are judged. Of more values NEES says little:
/// one that is stated badly, such as a shift that ten heights have in common, is one of ten.
Honesty honesty(const Calibration& calibration);
/// "4.0 times too much in scale (3.4 to 4.7)"; "what is found in heights (0.98, 0.93 to 1.04)"; empty where nothing is
/// known.
std::string in_words(const Calibration& calibration);

struct TrialSummary {
  std::size_t trials = 0;                ///< asked for and run, finished or not
  std::size_t failures = 0;              ///< of those, without a result
  Estimate rmse;                         ///< root of the mean of the trials' squares [m]
  Estimate mean;                         ///< of the trials' rms [m]
  Estimate bias;                         ///< mean of the trials' mean errors [m]
  Estimate predicted;                    ///< root of the mean predicted square [m]
  Estimate efficiency;                   ///< bound² / MSE: 1 is the best an unbiased estimator can do
  double nees = 0;                       ///< mean per degree of freedom
  Interval nees_band;                    ///< where a consistent covariance puts it with the given confidence
  std::vector<Calibration> calibration;  ///< of what is measured, then of each mode; only where something was stated
  std::vector<FailureRate> failure_rates;
};

/// `failures` are trials that gave no result: they count as failed at every tolerance, and nowhere else.
TrialSummary summarise(const std::vector<Trial>& finished, std::size_t failures, const std::vector<double>& tolerances,
                       double confidence);

}  // namespace plumbline::statistics

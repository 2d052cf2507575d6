// Variances of many small groups: each by itself is poorly known, and all as one is wrong where groups differ.
#pragma once

#include <vector>

namespace plumbline::judgement {

struct SampleVariance {
  double variance = 0;  ///< above zero
  double freedom = 0;   ///< its degrees of freedom; 0: not known
};

/// What the groups' variances have in common: a scaled inverse chi-square distribution. Its freedom is as large as they
/// are alike, at most 1000; 0 with fewer than two groups.
SampleVariance variance_prior(const std::vector<SampleVariance>& groups);

/// The mean of both, weighted with their degrees of freedom, and those together: what a test of Student's is to take.
SampleVariance moderated(const SampleVariance& group, const SampleVariance& prior);

}  // namespace plumbline::judgement

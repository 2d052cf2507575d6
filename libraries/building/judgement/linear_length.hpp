// A length as a linear function of what the anchors of several panels are off by, and of what nobody measured.
#pragma once

#include <map>
#include <vector>

#include "building/judgement/difference.hpp"

namespace plumbline::judgement {

struct LinearLength {
  std::map<std::size_t, Eigen::RowVector3d> anchors;  ///< by position in the DifferenceSet
  std::map<std::size_t, double> unmeasured;           ///< by number among LengthBasis::variances

  /// Adds `factor` times another. What is left below a nanometre for a metre is nothing: of a high column the panels
  /// far below have no part in the uppermost.
  void add(const LinearLength& other, double factor);
};

/// What lengths are made of.
struct LengthBasis {
  const DifferenceSet& deviations;
  std::vector<double> variances;  ///< of each that was not measured [m²]; its value is zero, and it is its own

  double value(const LinearLength& length) const;
  /// Covariance of two lengths [m²]; nan where that of the deviations is not known.
  double covariance(const LinearLength& a, const LinearLength& b) const;
};

}  // namespace plumbline::judgement

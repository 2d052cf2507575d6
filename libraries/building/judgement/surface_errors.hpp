// Measured panels and joints against the true ones.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "artifacts/surfaces.hpp"

namespace plumbline::judgement {

/// One quantity of one panel, or one place of a joint; a tilt is the height that it makes over one metre.
struct SurfaceError {
  std::string where;  ///< "P01-02", "P01-01 | P01-02 at +0.30 m"
  /// offset, tilt, bow, twist, width, step, shift; width_beside_unmeasured where the truth has a panel that nobody can
  /// measure
  std::string quantity;
  double found = 0, truth = 0, sigma = 0;  ///< [m]
};

/// One kind of quantity, all panels or joints together.
struct SurfaceErrorsOf {
  std::string quantity;
  double rms = 0, bias = 0, largest = 0;  ///< of the errors [m]
  double predicted = 0;                   ///< root of the mean of the stated variances [m]
  /// eᵀ Σ⁻¹ e with the whole covariance of all panels or joints, and how many of its directions have an error of more
  /// than 2 µm: of steps along a joint three at most, as both surfaces are of second degree. Of shifts the mean over
  /// all places, as one.
  double nees = 0, freedom = 0;
  /// Nobody said what the widths have in common: `nees` is the mean square over what is stated times the number of
  /// joints, and a factor in common to all of them would make it look untrue.
  bool one_by_one = false;
};

struct SurfaceErrors {
  std::vector<SurfaceError> all;
  std::vector<SurfaceErrorsOf> of;             ///< by quantity; without those that nobody measured
  int wanted = 0, measured = 0;                ///< panels that can be measured, and those of them that were
  int invented = 0;                            ///< panels that cannot be, and have figures
  int joints_wanted = 0, joints_measured = 0;  ///< joints of the truth between panels that can be measured
  int joints_beside = 0;                       ///< measured ones beside a panel that cannot be
  double coverage = 0;                         ///< share of the panels that can be measured that has points
  double beyond_3_sigma = 0;                   ///< share of `all`
};

/// Coefficients of the true panel about the middle of the measured one's face and over its size, which may differ along
/// the face: c0 … c5 as in PanelSurfaceFigures. Throws std::runtime_error for faces whose axes differ by more than
/// 1e-6.
Eigen::Matrix<double, 6, 1> coefficients_on(const SurfaceFaceT& face, const PanelSurfaceFiguresT& truth);

/// Panels are found by name, joints by the names of both. Throws std::runtime_error if no panel has a truth, and for
/// two panels of one name: which of them is which nobody could tell.
SurfaceErrors surface_errors(const SurfacesT& measured, const SurfacesT& truth);

}  // namespace plumbline::judgement

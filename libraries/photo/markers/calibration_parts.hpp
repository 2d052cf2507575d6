// Parts of the photographs of a board calibrated by themselves, against each other.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "photo/markers/calibration.hpp"

namespace plumbline::markers {

struct CalibrationParts {
  std::string split;                                          ///< "every second photograph and the others"
  double difference = std::nan(""), expected = std::nan("");  ///< medians over the image [px]
  double statistic =
      0;  ///< d' (Σ₁ + Σ₂)⁻¹ d of all parameters that both estimate: chi-squared if the covariances are true
  int freedom = 0;
};

constexpr int map_columns = 25, map_rows = 19;  ///< of maps over the image

/// Every second photograph, the first half by name, and those from one side, each against the rest. Parts of fewer than
/// four photographs, and those that cannot be calibrated, are left out. Takes three times as long as the calibration.
std::vector<CalibrationParts> compare_parts(const std::vector<CalibrationView>& views,
                                            const CalibrationOptions& options, const Calibration& all);

/// The parts whose parameters differ most, in units of what their covariances allow, if that is twice as much or more:
/// from half of the photographs the covariances themselves are rough. Null: none.
const CalibrationParts* contradiction_of(const std::vector<CalibrationParts>& all);

/// What the standard deviations of the whole are too small by, as these parts show: 1 if there are none.
double shown_too_small_by(const std::vector<CalibrationParts>& all);

/// Where the photographs are of two cameras (all.truth.change): "as two cameras, fx ..., they fit to ..."; empty where
/// there is no such change, or a part cannot be calibrated by itself.
std::string as_two_cameras(const std::vector<CalibrationView>& views, const CalibrationOptions& options,
                           const Calibration& all);

/// A board that is wider than its file has it, against its height: printed by a program that fits pages, or a printer
/// that feeds paper too fast. Photographs that are held otherwise then tell cameras of other fx and fy.
struct BoardAspect {
  double by = 0, sigma = 0;         ///< width over height, less 1, against the file
  double scatter = 1, without = 1;  ///< EmpiricalCovariance::factor with it, and without it
};

/// Where the photographs are of two cameras, or scatter: whether a board of another aspect explains it, so that with it
/// they do neither. Takes four calibrations. Nothing: it does not.
std::optional<BoardAspect> board_aspect(const std::vector<CalibrationView>& views, const CalibrationOptions& options,
                                        const Calibration& all);
std::string in_words(const BoardAspect& aspect);

/// A calibration as camera.yaml has it.
struct JudgedCalibration {
  Calibration calibration;  ///< its covariance made larger by shown_too_small_by()
  LensComparison lenses;
  std::vector<CalibrationParts> parts;
  std::string as_two;  ///< see as_two_cameras()
  std::optional<BoardAspect> aspect;
};

/// Calibrates, compares parts of the photographs, and enlarges the covariance by what they contradict. Without `lens`
/// the photographs tell it. Throws as calibrate().
JudgedCalibration calibrate_and_judge(const std::vector<CalibrationView>& views, int width, int height,
                                      const CalibrationOptions& options, std::optional<LensModel> lens = std::nullopt);

}  // namespace plumbline::markers

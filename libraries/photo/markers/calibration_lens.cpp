// Which lens took the photographs of a board: each is asked to foretell photographs it was not fitted to.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "photo/markers/calibration.hpp"

namespace plumbline::markers {
namespace {

/// A calibration whose failure is an answer, too.
std::optional<Calibration> attempt(const std::vector<CalibrationView>& views, int width, int height,
                                   const CalibrationOptions& options) {
  try {
    return calibrate(views, width, height, options);
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

/// Sum of squares of both coordinates over all points, and their number.
struct Residuals {
  double squares = 0, points = 0;
  /// nan of no points: such residuals prefer no lens.
  double rms() const { return points > 0 ? std::sqrt(squares / points) : std::nan(""); }
  void add(const Calibration& c) {
    for (const CalibratedView& view : c.views) {
      const auto n = static_cast<double>(view.points.size());
      squares += view.rms * view.rms * n, points += n;
    }
  }
};

/// Of photographs that only got a pose; nan if one half cannot be calibrated, or does not orient the other.
double held_out(const std::vector<CalibrationView>& views, const Calibration& all, const CalibrationOptions& options) {
  std::vector<CalibrationView> halves[2];
  for (size_t v = 0; v < views.size(); ++v) halves[v % 2].push_back(views[v]);
  Residuals residuals;
  for (int fitted = 0; fitted < 2; ++fitted) {
    const auto half = attempt(halves[fitted], all.camera.width, all.camera.height, options);
    if (!half) return std::nan("");
    CalibrationOptions only_poses = options;
    only_poses.known = half->camera;
    const auto other = attempt(halves[1 - fitted], all.camera.width, all.camera.height, only_poses);
    if (!other) return std::nan("");
    residuals.add(*other);
  }
  return residuals.rms();
}

double fitted(const std::vector<CalibrationView>& views, const Calibration& all, const CalibrationOptions& options) {
  const auto found = attempt(views, all.camera.width, all.camera.height, options);
  return found ? found->rms : std::nan("");
}

}  // namespace

LensComparison compare_lenses(const std::vector<CalibrationView>& views, const CalibrationOptions& options,
                              const Calibration& all) {
  constexpr double wide = 35 * std::numbers::pi / 180;
  constexpr size_t fewest_to_divide = 8;
  LensComparison lenses;
  for (const CalibratedView& view : all.views)
    for (const CalibrationPoint& point : views[view.view].points) {
      const Eigen::Vector3d ray = view.cam_from_board * point.board;
      lenses.widest = std::max(lenses.widest, std::atan2(ray.head<2>().norm(), ray.z()));
    }
  if (lenses.widest < wide) return lenses;
  CalibrationOptions brown = options;
  brown.reject_above = 0, brown.lens = LensModel::brown;
  CalibrationOptions fisheye = brown;
  fisheye.lens = LensModel::fisheye;
  for (lenses.held_out = views.size() >= fewest_to_divide;; lenses.held_out = false) {
    const auto residuals = lenses.held_out ? held_out : fitted;
    lenses.brown = residuals(views, all, brown), lenses.fisheye = residuals(views, all, fisheye);
    if (std::isfinite(lenses.brown) && std::isfinite(lenses.fisheye)) return lenses;
    if (lenses.held_out) continue;
    lenses.only_fisheye = std::isfinite(lenses.fisheye);
    lenses.brown = lenses.fisheye = 0;  // one of them fits nothing
    return lenses;
  }
}

CalibrationOfLens calibrate_lens_and_camera(const std::vector<CalibrationView>& views, int width, int height,
                                            CalibrationOptions options) {
  CalibrationOfLens result;
  const double good = 1e-3 * std::max(width, height);
  try {
    result.calibration = calibrate(views, width, height, options);
  } catch (const std::runtime_error&) {  // a circle of 180 degrees is none of Brown's
    options.lens = LensModel::fisheye;
    const auto as_fisheye = attempt(views, width, height, options);
    if (!as_fisheye || as_fisheye->rms > good) throw;
    result.calibration = *as_fisheye;
    result.lenses.only_fisheye = true;
    return result;
  }
  result.lenses = compare_lenses(views, options, result.calibration);
  if (!result.lenses.is_fisheye()) return result;
  options.lens = LensModel::fisheye;
  result.calibration = calibrate(views, width, height, options);
  return result;
}

}  // namespace plumbline::markers

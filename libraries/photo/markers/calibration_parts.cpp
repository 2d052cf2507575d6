#include "photo/markers/calibration_parts.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <stdexcept>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/median.hpp"
#include "photo/markers/marker_truth.hpp"

namespace plumbline::markers {
namespace {

double median_of_finite(std::vector<double> values) {
  std::erase_if(values, [](double v) { return !std::isfinite(v); });
  return upper_median(std::move(values));
}

/// The parts calibrated, first and second; nothing if one is too small or cannot be.
std::optional<std::array<Calibration, 2>> calibrate_parts(const std::vector<CalibrationView>& views,
                                                          const std::vector<bool>& second,
                                                          const CalibrationOptions& options, const BrownCamera& size,
                                                          std::size_t fewest) {
  std::array<std::vector<CalibrationView>, 2> parts;
  for (std::size_t i = 0; i < views.size(); ++i) parts[second[i] ? 1 : 0].push_back(views[i]);
  if (parts[0].size() < fewest || parts[1].size() < fewest) return std::nullopt;
  try {
    return std::array{calibrate(parts[0], size.width, size.height, options),
                      calibrate(parts[1], size.width, size.height, options)};
  } catch (const std::runtime_error&) {
    return std::nullopt;  // part of the photographs may be too few
  }
}

CalibrationParts compare(const std::string& split, const Calibration& a, const Calibration& b) {
  CalibrationParts parts;
  parts.split = split;
  const Eigen::MatrixXd ca = a.own_covariance(), cb = b.own_covariance();
  const auto ua = projection_uncertainty(a.camera, ca, map_columns, map_rows),
             ub = projection_uncertainty(b.camera, cb, map_columns, map_rows);
  std::vector<double> expected;
  for (std::size_t i = 0; i < ua.size(); ++i) expected.push_back(std::hypot(ua[i], ub[i]));
  parts.difference = median_of_finite(projection_difference(a.camera, b.camera, map_columns, map_rows));
  parts.expected = median_of_finite(expected);
  const auto first = a.camera.parameters(), other = b.camera.parameters();
  std::vector<int> both;
  for (int k = 0; k < BrownCamera::parameter_count; ++k)
    if (a.covariance(k, k) > 0 && b.covariance(k, k) > 0) both.push_back(k);
  parts.freedom = static_cast<int>(both.size());
  Eigen::VectorXd d(parts.freedom);
  for (std::size_t i = 0; i < both.size(); ++i) {
    const auto k = static_cast<std::size_t>(both[i]);
    d(static_cast<Eigen::Index>(i)) = other[k] - first[k];
  }
  // Both are of one camera, which draws edges in alike.
  const Eigen::VectorXd apart = a.by_inset - b.by_inset;
  const Eigen::MatrixXd sum = (ca + cb + apart * apart.transpose())(both, both);
  parts.statistic = d.dot(linear_algebra::solve_symmetric(sum, d));
  return parts;
}

/// Places along the longest axis of all: whether each lies beyond the middle one.
std::vector<bool> from_one_side(const Calibration& all) {
  std::vector<Eigen::Vector3d> centres;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const CalibratedView& view : all.views) {
    centres.push_back(view.cam_from_board.inverse().translation);
    mean += centres.back() / static_cast<double>(all.views.size());
  }
  Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& c : centres) spread += (c - mean) * (c - mean).transpose();
  const Eigen::Vector3d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(2);
  std::vector<double> along;
  for (const Eigen::Vector3d& c : centres) along.push_back(axis.dot(c - mean));
  const double middle = upper_median(along);
  std::vector<bool> second;
  for (const double value : along) second.push_back(value >= middle);
  return second;
}

/// The same photographs of a board that is wider by a share and as high.
std::vector<CalibrationView> stretched(std::vector<CalibrationView> views, double by) {
  for (CalibrationView& view : views)
    for (CalibrationPoint& point : view.points) point.board.x() *= 1 + by;
  return views;
}

}  // namespace

std::vector<CalibrationParts> compare_parts(const std::vector<CalibrationView>& views,
                                            const CalibrationOptions& options, const Calibration& all) {
  constexpr std::size_t fewest = 4;
  std::vector<bool> every_second(views.size()), late(views.size());
  const std::vector<int>& by_name = all.truth.evidence.members;
  for (std::size_t k = 0; k < by_name.size(); ++k) {
    every_second[by_name[k]] = k % 2 == 1;
    late[by_name[k]] = k >= by_name.size() / 2;
  }
  std::vector<CalibrationParts> result;
  for (const auto& [split, second] : {std::pair("every second photograph and the others", every_second),
                                      std::pair("the first and the second half of the photographs", late),
                                      std::pair("the photographs from either side", from_one_side(all))})
    if (const auto parts = calibrate_parts(views, second, options, all.camera, fewest))
      result.push_back(compare(split, (*parts)[0], (*parts)[1]));
  return result;
}

const CalibrationParts* contradiction_of(const std::vector<CalibrationParts>& all) {
  constexpr double told = 4;  // of chi-squared over its freedom
  const auto ratio = [](const CalibrationParts& parts) { return parts.statistic / std::max(1, parts.freedom); };
  const CalibrationParts* worst = nullptr;
  for (const CalibrationParts& parts : all)
    if (ratio(parts) > told && (!worst || ratio(parts) > ratio(*worst))) worst = &parts;
  return worst;
}

double shown_too_small_by(const std::vector<CalibrationParts>& all) {
  const CalibrationParts* worst = contradiction_of(all);
  return worst ? std::sqrt(worst->statistic / worst->freedom) : 1;
}

JudgedCalibration calibrate_and_judge(const std::vector<CalibrationView>& views, int width, int height,
                                      const CalibrationOptions& options, std::optional<LensModel> lens) {
  JudgedCalibration result;
  CalibrationOptions as_found = options;
  if (lens) {
    as_found.lens = *lens;
    result.calibration = calibrate(views, width, height, as_found);
    result.lenses = compare_lenses(views, as_found, result.calibration);
  } else {
    CalibrationOfLens found = calibrate_lens_and_camera(views, width, height, options);
    result.calibration = std::move(found.calibration), result.lenses = found.lenses;
    as_found.lens = result.calibration.camera.lens;
  }
  Calibration& all = result.calibration;
  result.parts = compare_parts(views, as_found, all);
  all.covariance += (std::pow(shown_too_small_by(result.parts), 2) - 1) * all.own_covariance();
  result.aspect = board_aspect(views, as_found, all);
  result.as_two = as_two_cameras(views, as_found, all);
  return result;
}

std::optional<BoardAspect> board_aspect(const std::vector<CalibrationView>& views, const CalibrationOptions& options,
                                        const Calibration& all) {
  constexpr double told = 1.5;     // of a scatter that has a cause
  constexpr double step = 0.004;   // relative
  constexpr double least = 1e-3;   // of prints that nobody calls wrong
  constexpr double certain = 100;  // of chi-squared with one degree of freedom: corners err with their photographs
  const CameraTruth& truth = all.truth;
  if (options.known || !truth.empirical.judged || (!truth.change && !(truth.empirical.factor > told)))
    return std::nullopt;
  try {
    const auto squares = [](const Calibration& c) { return c.sigma * c.sigma * c.degrees_of_freedom; };
    const auto with = [&](double by) {
      return calibrate(stretched(views, by), all.camera.width, all.camera.height, options);
    };
    const double here = squares(all), wider = squares(with(step)), higher = squares(with(-step));
    const double bend = wider - 2 * here + higher;
    if (!(bend > 0)) return std::nullopt;
    BoardAspect aspect;
    aspect.by = 0.5 * step * (higher - wider) / bend;
    if (!(std::abs(aspect.by) > least && std::abs(aspect.by) < 0.1)) return std::nullopt;
    const Calibration best = with(aspect.by);
    const double gain = (here - squares(best)) / (best.sigma * best.sigma);
    aspect.scatter = best.truth.empirical.factor, aspect.without = truth.empirical.factor;
    if (!(gain > certain) || best.truth.change || !(aspect.scatter < std::max(told, 0.5 * aspect.without)))
      return std::nullopt;
    aspect.sigma = aspect.scatter * std::abs(aspect.by) / std::sqrt(gain);
    return aspect;
  } catch (const std::runtime_error&) {
    return std::nullopt;
  }
}

std::string in_words(const BoardAspect& aspect) {
  return fmt::format(
      "the board is {:.2f} \u00b1 {:.2f} % {} than its file has it, against its height: a print that a program or a "
      "printer stretched. With it the photographs scatter {:.1f} times as far as their corners allow, without it "
      "{:.1f} "
      "times. The camera is calibrated as if the board were as its file has it, and fx and fy are wrong by a part of "
      "that: measure width and height of the board, and print it again",
      100 * std::abs(aspect.by), 100 * aspect.sigma, aspect.by > 0 ? "wider" : "narrower", aspect.scatter,
      aspect.without);
}

std::string as_two_cameras(const std::vector<CalibrationView>& views, const CalibrationOptions& options,
                           const Calibration& all) {
  const auto& change = all.truth.change;
  if (!change || !divides(*change)) return "";
  std::vector<bool> second(views.size());
  for (const int k : change->second) second[all.truth.evidence.members[k]] = true;
  const auto parts = calibrate_parts(views, second, options, all.camera, 3);
  if (!parts) return "";
  const auto& [a, b] = *parts;
  const double rms =
      std::sqrt((a.rms * a.rms * a.observations + b.rms * b.rms * b.observations) / (a.observations + b.observations));
  return as_two_cameras(a.camera, std::sqrt(a.covariance(0, 0)), b.camera, std::sqrt(b.covariance(0, 0)), rms, all.rms);
}

}  // namespace plumbline::markers

#include "photo/block/point_block_words.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "geometry/statistics.hpp"
#include "photo/block/point_block_robust.hpp"
#include "photo/block/read_block.hpp"

namespace plumbline::block {

namespace {

/// Whose error would explain what the control contradicts; empty where the points' joint covariance is not known, or
/// nobody's would.
std::string suspects_in_words(const PointBlockResult& result) {
  const TestedControl test = test_control(result);
  const ControlSuspects& found = test.found;
  std::vector<std::string> names;
  for (const size_t k : test.tested) names.push_back(result.block.points[result.control[k].point].name);
  const auto in_mm = [&](const SuspectedControl& point) {
    const Eigen::Vector3d off = 1e3 * point.off;
    return fmt::format("{} by {:.1f}, {:.1f}, {:.1f} mm", names[point.point], off.x(), off.y(), off.z());
  };
  std::string words;
  for (const RivalControl& group : found.rivals) {
    std::vector<std::string> all{names[group.worst.point]};
    for (const size_t k : group.others) all.push_back(names[k]);
    words += "; an error of any of " + few_of(all) + " would explain it alike (" + in_mm(group.worst) +
             "), and which is wrong the others do not tell";
  }
  if (!found.worst) return words;
  return words + "; an error of " + in_mm(*found.worst) + " would explain most" +
         (found.rivals.empty() ? "" : " of the rest");
}

}  // namespace

std::string control_against_images(const PointBlockResult& result) {
  const least_squares::VarianceComponent *images = nullptr, *control = nullptr;
  for (const auto& group : result.groups) {
    if (group.name == "image coordinates") images = &group;
    if (group.name == "control") control = &group;
  }
  constexpr double controlled = 1e-3;  // else all of it is needed to hold the block
  if (!images || !control || control->redundancy < controlled || images->redundancy < 1 || !(images->factor > 0))
    return "";
  const double ratio = control->factor / images->factor;
  const double limit = fisher_f_quantile(0.999, control->redundancy, images->redundancy);
  double squares = 0, largest = 0;
  std::string worst;
  int count = 0;
  for (const ControlResult& c : result.control) {
    if (c.check || c.fixed || c.aside) continue;
    squares += c.residual.squaredNorm(), ++count;
    if (const double w = c.w.cwiseAbs().maxCoeff(); w > largest) largest = w, worst = result.block.points[c.point].name;
  }
  // The largest w may be an innocent point's, which a wrong one bends. A single wrong point among many that hardly
  // control each other does not show in the factor of all.
  std::string suspects = suspects_in_words(result);
  if (!(ratio > limit) && suspects.empty()) return "";
  if (suspects.empty()) suspects = fmt::format(", most at {} (w {:.1f})", worst, largest);
  return fmt::format(
      "control and images contradict each other: the control's variance factor is {:.3g} times that of the images (at "
      "most {:.3g} by chance), its residuals {:.3g} mm rms{}. Its standard deviations are too "
      "small, a point of it is another one in the images, or the camera is not what the file says{}",
      ratio, limit, 1e3 * std::sqrt(squares / count), suspects,
      result.block.cameras.at(0).lens == bundle::Lens::correcting
          ? " (block.with.free=[c, xp, yp, K1, K2, P1, P2] estimates it)"
          : "");
}

std::string scale_bars_against_images(const PointBlockResult& result) {
  const least_squares::VarianceComponent *images = nullptr, *bars = nullptr;
  for (const auto& group : result.groups) {
    if (group.name == "image coordinates") images = &group;
    if (group.name == "scale bars") bars = &group;
  }
  constexpr double controlled = 0.5;  // of two bars of one block each has half of the one redundancy
  if (!images || !bars || !(bars->redundancy >= controlled) || images->redundancy < 1) return "";
  // Bars are calibrated by themselves: images that are better than stated make them no worse.
  const double unit = std::max(1.0, images->factor), ratio = bars->factor / unit;
  const double limit = fisher_f_quantile(0.999, bars->redundancy, images->redundancy);
  if (!(ratio > limit)) return "";
  double squares = 0;
  for (const auto& group : result.groups) squares += group.sum_of_squares;
  const double own = squares / result.degrees_of_freedom;  // what w were divided by
  std::vector<std::string> wrong;
  double largest = 0;
  for (size_t i = 0; i < result.block.scale_bars.size(); ++i)
    largest = std::max(largest, std::abs(result.scale_bar_reliability[i].w));
  for (size_t i = 0; i < result.block.scale_bars.size(); ++i) {
    const ScaleBar& bar = result.block.scale_bars[i];
    const auto& row = result.scale_bar_reliability[i];
    if (std::abs(row.w) < 0.9 * largest) continue;  // those that could be the wrong one alike
    wrong.push_back(fmt::format("{} of {:.6g} m (off by {:.3g} mm, w {:.1f})", bar.name, bar.length, 1e3 * row.residual,
                                row.w * std::sqrt(own / unit)));
  }
  return fmt::format(
      "scale bars contradict {}: their variance factor is {:.3g}, at most {:.3g} by chance; most {}. A length or a "
      "standard deviation in the file is wrong, or an end is another point; no length is to be trusted until that "
      "is mended",
      result.block.scale_bars.size() > 1 ? "each other or the control" : "the control", ratio, limit, few_of(wrong));
}

std::string blunders_in_words(const PointBlockResult& result) {
  constexpr double beyond_chance = 12;
  double largest = 0;
  size_t worst = 0, count = 0;
  for (size_t m = 0; m < result.measurement_reliability.size(); ++m) {
    const auto& [x, y] = result.measurement_reliability[m];
    const double w = std::max(std::abs(x.w), std::abs(y.w));
    count += w > beyond_chance;
    if (w > largest) largest = w, worst = m;
  }
  if (count == 0) return "";
  const BlockMeasurement& measured = result.block.measurements[worst];
  const auto& [x, y] = result.measurement_reliability[worst];
  return fmt::format(
      "{} image point{} of {} contradict{} all the others, most point {} in image {} (off by {:.3g} mm in the sensor, "
      "w {:.0f}): it is another point there, or its control is wrong; Block.targets.findings lists them",
      count, count == 1 ? "" : "s", result.measurement_reliability.size(), count == 1 ? "s" : "",
      result.block.points[measured.point].name, result.block.images[measured.image].id,
      std::hypot(x.residual, y.residual), largest);
}

std::string turned_images(const PointBlock& given, const PointBlockResult& result) {
  const size_t n = given.images.size();
  const double alike = std::cos(10 * M_PI / 180), other = std::cos(45 * M_PI / 180);
  if (n < 4) return "";
  std::vector<Eigen::Matrix3d> turns;  // from the approximate to the adjusted block frame, as each image has it
  for (size_t i = 0; i < n; ++i)
    turns.push_back(rotation_from_angles(result.block.images[i].angles) *
                    rotation_from_angles(given.images[i].angles).transpose());
  const auto cosine = [&](size_t i, size_t j) { return 0.5 * ((turns[i].transpose() * turns[j]).trace() - 1); };
  for (size_t i = 0; i < std::min<size_t>(n, 5); ++i) {  // one of five is as the most are
    std::vector<std::string> names;
    size_t same = 0;
    for (size_t j = 0; j < n; ++j) {
      same += cosine(i, j) > alike;
      if (cosine(i, j) < other) names.push_back(std::to_string(given.images[j].id));
    }
    if (names.empty() || 5 * same < 4 * n) continue;
    return (names.size() == 1 ? "image " : "images ") + few_of(names) + (names.size() == 1 ? " has" : " have") +
           " turned by more than 45 degrees against the approximate orientation, all the others have not: its image "
           "coordinates are exchanged or mirrored, its points are others, or the approximate orientation was wrong";
  }
  return "";
}

}  // namespace plumbline::block

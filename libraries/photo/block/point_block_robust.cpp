#include "photo/block/point_block_robust.hpp"

#include <fmt/core.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>
#include <stdexcept>
#include <utility>

#include "photo/block/check_covariance.hpp"
#include "photo/block/check_points.hpp"
#include "photo/block/point_block_words.hpp"

namespace plumbline::block {
namespace {

using Indices = std::vector<std::size_t>;  // of control points

bool is_in(const Indices& points, std::size_t k) { return std::find(points.begin(), points.end(), k) != points.end(); }

/// The control but the points that are set aside.
BlockControl without(const BlockControl& control, const Indices& aside) {
  BlockControl rest;
  std::vector<Eigen::Index> rows;
  for (std::size_t k = 0; k < control.points.size(); ++k) {
    if (is_in(aside, k)) continue;
    rest.points.push_back(control.points[k]);
    rest.is_check.push_back(control.is_check[k]);
    for (Eigen::Index c = 0; c < 3; ++c) rows.push_back(3 * static_cast<Eigen::Index>(k) + c);
  }
  rest.position = control.position(rows);
  rest.covariance = control.covariance(rows, rows);
  return rest;
}

/// Sum of squares over degrees of freedom: what covariances are scaled by.
double unit_of(const PointBlockResult& result) {
  double squares = 0;
  for (const auto& group : result.groups) squares += group.sum_of_squares;
  return squares / result.degrees_of_freedom;
}

ControlResult aside_result(const PointBlockResult& result, const BlockControl& control, const Indices& aside,
                           std::size_t k) {
  const Eigen::Index at = 3 * static_cast<Eigen::Index>(k);
  ControlResult entry;
  entry.point = control.points[k];
  entry.aside = true;
  entry.given = control.position.segment<3>(at);
  entry.given_sigma = control.covariance.diagonal().segment<3>(at).cwiseMax(0).cwiseSqrt();
  const auto point = static_cast<std::size_t>(entry.point);
  entry.residual = result.block.points[point].position - entry.given;
  entry.w = entry.residual.cwiseQuotient(
      covariance_of_difference(result, control, aside, k, unit_of(result)).diagonal().cwiseSqrt());
  entry.redundancy_number.setOnes();
  entry.rays = result.rays[point];
  return entry;
}

/// Started from what is there already.
PointBlockResult adjust_beside(const PointBlock& given, const PointBlockOptions& options,
                               const PointBlockResult& adjusted, const Indices& aside) {
  PointBlock block = adjusted.block;
  block.control = without(given.control, aside);
  PointBlockResult result = adjust_point_block(block, options);
  std::vector<ControlResult> all;
  auto next = result.control.begin();
  for (std::size_t k = 0; k < given.control.points.size(); ++k)
    all.push_back(is_in(aside, k) ? aside_result(result, given.control, aside, k) : *next++);
  result.control = std::move(all);
  result.block.control = given.control;
  return result;
}

/// Nothing where single points are no answer.
std::optional<PointBlockResult> search(const PointBlock& given, const PointBlockOptions& options,
                                       const PointBlockResult& with_all) {
  constexpr std::size_t part = 3;
  Indices aside;
  std::optional<PointBlockResult> result;
  std::size_t all = 0;
  for (;;) {
    const PointBlockResult& now = result ? *result : with_all;
    const TestedControl test = test_control(now);
    if (aside.empty()) all = test.tested.size();
    if (!test.found.worst) break;
    aside.push_back(test.tested[test.found.worst->point]);
    if (part * aside.size() > all) return std::nullopt;
    result = adjust_beside(given, options, now, aside);
  }
  if (!result) return std::nullopt;
  // What agrees after all, once the worse ones are gone, takes part again.
  const std::size_t before = aside.size();
  const Indices all_aside = aside;
  const double unit = unit_of(*result);
  std::erase_if(aside, [&](std::size_t k) {
    const Eigen::Vector3d off = result->control[k].residual;
    return off.dot(covariance_of_difference(*result, given.control, all_aside, k, unit).ldlt().solve(off)) <=
           check_limit(all);
  });
  if (aside.size() < before) result = adjust_beside(given, options, *result, aside);
  if (!control_against_images(*result).empty() && test_control(*result).found.rivals.empty()) return std::nullopt;
  return result;
}

}  // namespace

TestedControl test_control(const PointBlockResult& result) {
  TestedControl test;
  const auto images = std::find_if(result.groups.begin(), result.groups.end(),
                                   [](const auto& group) { return group.name == "image coordinates"; });
  if (result.point_covariance.size() == 0 || images == result.groups.end()) return test;
  std::vector<Eigen::Index> in_control, in_points;
  std::vector<double> residuals;
  for (std::size_t k = 0; k < result.control.size(); ++k) {
    const ControlResult& c = result.control[k];
    if (c.check || c.fixed || c.aside) continue;
    test.tested.push_back(k);
    for (int axis = 0; axis < 3; ++axis) {
      in_control.push_back(3 * static_cast<Eigen::Index>(k) + axis);
      in_points.push_back(3 * static_cast<Eigen::Index>(c.point) + axis);
      residuals.push_back(c.residual(axis));
    }
  }
  const auto n = static_cast<Eigen::Index>(in_control.size());
  const Eigen::LLT<Eigen::MatrixXd> survey(result.block.control.covariance(in_control, in_control));
  if (n == 0 || survey.info() != Eigen::Success) return test;
  const double unit = unit_of(result);
  const Eigen::MatrixXd weight = survey.solve(Eigen::MatrixXd::Identity(n, n));
  const Eigen::MatrixXd seen = weight - weight * (result.point_covariance(in_points, in_points) / unit) * weight;
  test.found =
      suspects_of(seen, weight, weight * Eigen::Map<const Eigen::VectorXd>(residuals.data(), n), images->factor);
  return test;
}

PointBlockResult adjust_without_wrong_control(const PointBlock& given, const PointBlockOptions& options) {
  PointBlockResult with_all = adjust_point_block(given, options);
  if (!options.estimate_image_variance || options.by_gradients) return with_all;
  try {
    if (auto mended = search(given, options, with_all)) return std::move(*mended);
  } catch (const std::runtime_error&) {  // without the point the rest does not hold the block, and all is told of all
  }
  return with_all;
}

std::vector<std::string> set_aside_in_words(const PointBlockResult& result) {
  std::vector<std::string> words;
  for (const ControlResult& c : result.control) {
    if (!c.aside) continue;
    const Eigen::Vector3d off = (-1e4 * c.residual).array().round() / 10 + 0.0;  // no -0.0
    words.push_back("the control of " + result.block.points[static_cast<std::size_t>(c.point)].name +
                    fmt::format(", which contradicts the images and the other control by {:.1f}, {:.1f}, {:.1f} mm",
                                off.x(), off.y(), off.z()));
  }
  return words;
}

}  // namespace plumbline::block

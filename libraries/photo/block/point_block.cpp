#include "photo/block/point_block.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "geometry/linear_algebra/decompositions.hpp"
#include "geometry/similarity.hpp"
#include "least_squares/problem/defects.hpp"
#include "photo/block/check_covariance.hpp"
#include "photo/block/control_words.hpp"
#include "photo/block/point_block_by_gradients.hpp"
#include "photo/block/point_block_checks.hpp"
#include "plumbline/rigid_transform.hpp"
#include "plumbline/stop.hpp"

namespace plumbline::block {
namespace {

constexpr double held_sigma = 1e-7;  ///< [m] of a single coordinate that is held while others of its point are not

enum Group { group_images, group_bars, group_control, group_principal_points };

/// Where the points end and the block begins: coordinates of a site may have seven digits.
Eigen::Vector3d origin_of(const PointBlock& block) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const auto& point : block.points) sum += point.position;
  return (sum / std::max<double>(1.0, static_cast<double>(block.points.size()))).array().round();
}

double sigma_of(const BlockMeasurement& measurement, const PointBlockOptions& options) {
  return measurement.sigma > 0 ? measurement.sigma : options.image_sigma;
}

std::vector<bool> free_values(const SensorCamera& camera, const std::vector<std::string>& wanted) {
  static const std::vector<std::string> balanced = {"Ck", "xh", "yh", "A1", "A2", "B1", "B2"};
  std::vector<std::string> chosen;
  for (const auto& name : wanted)
    if (name != "auto")
      chosen.push_back(name);
    else if (!camera.estimated.empty())
      chosen.insert(chosen.end(), camera.estimated.begin(), camera.estimated.end());
    else if (camera.lens == bundle::Lens::balanced)
      chosen.insert(chosen.end(), balanced.begin(), balanced.end());
  std::vector<bool> free;
  for (const auto& name : camera.names()) free.push_back(std::find(chosen.begin(), chosen.end(), name) != chosen.end());
  return free;
}

void require_known_names(const PointBlock& block, const std::vector<std::string>& wanted) {
  for (const auto& name : wanted) {
    bool found = name == "auto";
    std::string known;
    for (const auto& camera : block.cameras) {
      found = found || std::find(camera.names().begin(), camera.names().end(), name) != camera.names().end();
      if (known.empty())
        for (const auto& n : camera.names()) known += (known.empty() ? "" : ", ") + n;
    }
    if (!found) throw std::runtime_error("unknown interior parameter '" + name + "'; known are " + known);
  }
}

bool is_fixed(const BlockControl& control, size_t k) {
  return control.covariance.diagonal().segment<3>(3 * static_cast<Eigen::Index>(k)).maxCoeff() <= 0;
}

Eigen::MatrixXd whitening_of(Eigen::MatrixXd covariance) {
  for (Eigen::Index i = 0; i < covariance.rows(); ++i)
    if (covariance(i, i) <= 0) covariance(i, i) = held_sigma * held_sigma;
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  if (factor.info() != Eigen::Success || !covariance.allFinite())
    throw std::runtime_error("the covariance of the control points is not positive definite");
  return factor.matrixL().solve(Eigen::MatrixXd::Identity(covariance.rows(), covariance.cols()));
}

struct Built {
  bundle::Problem problem;
  bundle::State state;
  std::vector<std::pair<size_t, Eigen::Index>> control_row;  ///< by control point: index into known, first row
};

/// Known points: those that share a covariance with others in one term, the rest each on its own, so that they do not
/// tie the block together.
void add_control(const PointBlock& block, const Eigen::Vector3d& origin, Built& built) {
  const BlockControl& control = block.control;
  built.control_row.assign(control.points.size(), {SIZE_MAX, 0});
  std::vector<size_t> weighted;
  for (size_t k = 0; k < control.points.size(); ++k) {
    if (control.is_check[k]) continue;
    const Eigen::Vector3d position = control.position.segment<3>(3 * static_cast<Eigen::Index>(k));
    if (is_fixed(control, k)) {
      built.problem.points[control.points[k]].fixed = true;
      built.state.points[control.points[k]] = position - origin;
    } else {
      weighted.push_back(k);
    }
  }
  const auto add = [&](const std::vector<size_t>& together) {
    if (together.empty()) return;
    bundle::Known term;
    std::vector<Eigen::Index> rows;
    term.target.resize(3 * static_cast<Eigen::Index>(together.size()));
    for (size_t k : together) {
      term.refs.push_back({bundle::Kind::point, control.points[k]});
      built.control_row[k] = {built.problem.known.size(), static_cast<Eigen::Index>(rows.size())};
      for (Eigen::Index c = 0; c < 3; ++c) {
        term.target(static_cast<Eigen::Index>(rows.size())) =
            control.position(3 * static_cast<Eigen::Index>(k) + c) - origin(c);
        rows.push_back(3 * static_cast<Eigen::Index>(k) + c);
      }
    }
    term.whitening = whitening_of(control.covariance(rows, rows));
    term.group = group_control;
    built.problem.known.push_back(std::move(term));
  };
  std::vector<size_t> tied;
  for (size_t k : weighted) {
    bool alone = true;
    for (size_t other : weighted)
      if (other != k) alone = alone && control.covariance.block(3 * k, 3 * other, 3, 3).isZero(0);
    if (alone)
      add({k});
    else
      tied.push_back(k);
  }
  add(tied);
}

Built build(const PointBlock& block, const PointBlockOptions& options, const Eigen::Vector3d& origin) {
  Built built;
  bundle::Problem& problem = built.problem;
  problem.groups = {{"image coordinates"}, {"scale bars"}, {"control"}, {"principal points of images"}};
  for (const auto& camera : block.cameras) {
    problem.cameras.push_back(
        {std::to_string(camera.id), camera.lens, camera.balance_radius, free_values(camera, options.free_parameters)});
    built.state.interiors.push_back(camera.values);
  }
  for (const auto& image : block.images) {
    problem.images.push_back({std::to_string(image.id), image.camera});
    built.state.images.emplace_back();
    built.state.images.back().set(Eigen::Quaterniond(rotation_from_angles(image.angles).transpose()),
                                  image.centre - origin);
    if (!(options.principal_point_sigma > 0)) continue;
    problem.images.back().shift_free = true;
    built.state.shifts.emplace_back(0, 0);
    problem.known.push_back({{{bundle::Kind::shift, static_cast<int>(problem.images.size()) - 1}},
                             Eigen::Vector2d::Zero(),
                             Eigen::Matrix2d::Identity() / options.principal_point_sigma,
                             group_principal_points});
  }
  for (const auto& point : block.points) {
    problem.points.push_back({point.name});
    built.state.points.push_back(point.position - origin);
  }
  for (const auto& m : block.measurements)
    stop_point(), problem.image_points.push_back(
                      {m.image, m.point, m.position, Eigen::Matrix2d::Identity() / sigma_of(m, options), group_images});
  for (const auto& bar : block.scale_bars)
    problem.distances.push_back(
        {bar.name, {bundle::Kind::point, bar.from}, {bundle::Kind::point, bar.to}, bar.length, bar.sigma, group_bars});
  add_control(block, origin, built);
  return built;
}

/// d(ω, φ, κ)/d(rotation vector in the camera frame). With Rᵀ = camera_from_block, a turn δ there is the spatial turn
/// −R δ of R, and ω, φ, κ turn about x, Rx y and Rx Ry z.
Eigen::Matrix3d angles_by_turn(const Eigen::Vector3d& angles, const Eigen::Matrix3d& block_from_camera) {
  const Eigen::AngleAxisd x(angles.x(), Eigen::Vector3d::UnitX()), y(angles.y(), Eigen::Vector3d::UnitY());
  Eigen::Matrix3d axes;
  axes << Eigen::Vector3d::UnitX(), x * Eigen::Vector3d::UnitY(), x * (y * Eigen::Vector3d::UnitZ());
  return -axes.inverse() * block_from_camera;
}

/// Inverses of standard deviations, 0 for what is held.
Eigen::VectorXd weights_of(const Eigen::MatrixXd& covariance) {
  return covariance.diagonal().unaryExpr([](double variance) { return variance > 0 ? 1 / std::sqrt(variance) : 0; });
}

/// `held`: unknowns of images that are the datum; their variance is 0 where the inverse has rounding.
void fill_covariances(const Built& built, const bundle::Layout& layout, const bundle::Adjusted& adjusted, double factor,
                      const std::vector<int>& held, PointBlockResult& result) {
  const bundle::Cofactors& cofactors = *adjusted.cofactors;
  const auto block_of = [&](bundle::Kind kind, size_t i) { return layout.block({kind, static_cast<int>(i)}); };
  const auto own = cofactors.all_own();
  std::vector<int> points;
  for (size_t j = 0; j < built.problem.points.size(); ++j) {
    points.push_back(block_of(bundle::Kind::point, j));
    const auto& q = own[points.back()];
    result.point_covariances.push_back(q.size() > 0 ? Eigen::Matrix3d(factor * q) : Eigen::Matrix3d::Zero());
  }
  if (points.size() <= max_joint_points) {
    const Eigen::Index size = 3 * static_cast<Eigen::Index>(points.size());
    result.point_covariance = Eigen::MatrixXd::Zero(size, size);
    std::vector<Eigen::Index> unknown;
    for (size_t j = 0; j < points.size(); ++j)
      for (int c = 0; c < layout.size(points[j]); ++c) unknown.push_back(3 * static_cast<Eigen::Index>(j) + c);
    result.point_covariance(unknown, unknown) = factor * cofactors.joint(points);
  }
  for (size_t c = 0; c < built.problem.cameras.size(); ++c) {
    result.free_parameters.push_back(layout.free_values(static_cast<int>(c)));
    const auto& q = own[block_of(bundle::Kind::camera, c)];
    result.interior_covariance.push_back(factor * q);
  }
  for (size_t i = 0; i < built.problem.images.size(); ++i) {
    const size_t camera = static_cast<size_t>(built.problem.images[i].camera);
    const int image = block_of(bundle::Kind::image, i), interior = block_of(bundle::Kind::camera, camera);
    Eigen::MatrixXd joint = factor * cofactors.joint({image, interior});
    for (const int unknown : held) {
      const int row = unknown - layout.offset(image);
      if (row >= 0 && row < 6) joint.row(row).setZero(), joint.col(row).setZero();
    }
    result.pose_covariance.push_back(joint.topLeftCorner<6, 6>());
    if (built.problem.images[i].shift_free) {
      result.principal_point_covariance.push_back(factor * own[block_of(bundle::Kind::shift, i)]);
    }
    Matrix6 turn = Matrix6::Identity();
    turn.bottomRightCorner<3, 3>() =
        angles_by_turn(result.block.images[i].angles, adjusted.state.images[i].matrix.transpose());
    result.orientation_covariance.push_back(turn * joint.topLeftCorner<6, 6>() * turn.transpose());
    const Eigen::VectorXd scale = weights_of(joint);
    result.pose_interior_correlation.push_back(
        (scale.asDiagonal() * joint * scale.asDiagonal()).topRightCorner(6, layout.size(interior)));
  }
}

void fill_control(const PointBlock& given, const Built& built, const bundle::Reliability& reliability, double factor,
                  PointBlockResult& result) {
  Eigen::Index check_row = 0;
  for (size_t k = 0; k < given.control.points.size(); ++k) {
    const Eigen::Index at = 3 * static_cast<Eigen::Index>(k);
    const size_t point = static_cast<size_t>(given.control.points[k]);
    ControlResult entry;
    entry.point = given.control.points[k];
    entry.check = given.control.is_check[k];
    entry.fixed = !entry.check && is_fixed(given.control, k);
    entry.given = given.control.position.segment<3>(at);
    entry.given_sigma = given.control.covariance.diagonal().segment<3>(at).cwiseMax(0).cwiseSqrt();
    entry.residual = result.block.points[point].position - entry.given;
    entry.rays = result.rays[point];
    const auto& [term, row] = built.control_row[k];
    for (Eigen::Index c = 0; c < 3; ++c) {
      if (term != SIZE_MAX) {
        const auto& q = reliability.known[term][row + c];
        entry.w(c) = q.w / std::sqrt(factor);
        entry.redundancy_number(c) = q.redundancy_number;
      } else if (entry.check) {
        const double variance = result.check_covariance.size() > 0
                                    ? result.check_covariance(check_row + c, check_row + c)
                                    : result.point_covariances[point](c, c) + given.control.covariance(at + c, at + c);
        entry.w(c) = entry.residual(c) / std::sqrt(variance);
        entry.redundancy_number(c) = 1;
      }
    }
    if (entry.check) check_row += 3;
    result.control.push_back(entry);
  }
}

void fill_reliability(bundle::Reliability reliability, double factor, PointBlockResult& result) {
  result.measurement_reliability = std::move(reliability.points);
  result.scale_bar_reliability = std::move(reliability.distances);
  const auto rescale = [&](least_squares::RowStatistics& row) {
    row.w /= std::sqrt(factor);
    row.mdb *= std::sqrt(factor);
  };
  for (auto& rows : result.measurement_reliability)
    for (auto& row : rows) rescale(row);
  for (auto& row : result.scale_bar_reliability) rescale(row);
  result.groups = std::move(reliability.groups);
  std::erase_if(result.groups, [](const auto& group) { return group.rows == 0; });
}

void store_values(const bundle::State& state, const Eigen::Vector3d& origin, PointBlock& block) {
  for (size_t j = 0; j < state.points.size(); ++j) block.points[j].position = state.points[j] + origin;
  for (size_t c = 0; c < state.interiors.size(); ++c) block.cameras[c].values = state.interiors[c];
  for (size_t i = 0; i < state.images.size(); ++i) {
    block.images[i].centre = state.images[i].position + origin;
    block.images[i].angles = angles_from_rotation(state.images[i].matrix.transpose());
  }
}

/// Carries approximate values over to the frame of the control, if they are in another one.
void align_to_control(PointBlock& block) {
  std::vector<std::string> names;
  std::vector<Eigen::Vector3d> from, to;
  for (size_t k = 0; k < block.control.points.size(); ++k) {
    if (block.control.is_check[k]) continue;
    names.push_back(block.points[block.control.points[k]].name);
    from.push_back(block.points[block.control.points[k]].position);
    to.emplace_back(block.control.position.segment<3>(3 * static_cast<Eigen::Index>(k)));
  }
  require_same_figure(names, from, to);
  if (from.size() < 3) return;
  Eigen::Matrix3Xd spread(3, static_cast<Eigen::Index>(to.size()));
  for (size_t k = 0; k < to.size(); ++k) spread.col(static_cast<Eigen::Index>(k)) = to[k] - to[0];
  const linear_algebra::SingularValues svd(spread.colwise() - spread.rowwise().mean());
  if (svd.singularValues()(1) < 1e-3 * svd.singularValues()(0)) return;  // a line does not tell the rotation
  require_same_hand(from, to);
  const SimilarityMotion move = fit_similarity(from, to, true);
  for (auto& point : block.points) point.position = move * point.position;
  for (auto& image : block.images) {
    image.centre = move * image.centre;
    image.angles = angles_from_rotation(move.rotation.toRotationMatrix() * rotation_from_angles(image.angles));
  }
}

}  // namespace

Eigen::Matrix3d rotation_from_angles(const Eigen::Vector3d& angles) {
  return (Eigen::AngleAxisd(angles.x(), Eigen::Vector3d::UnitX()) *
          Eigen::AngleAxisd(angles.y(), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(angles.z(), Eigen::Vector3d::UnitZ()))
      .toRotationMatrix();
}

Eigen::Vector3d angles_from_rotation(const Eigen::Matrix3d& r) {
  return {std::atan2(-r(1, 2), r(2, 2)), std::asin(std::clamp(r(0, 2), -1.0, 1.0)), std::atan2(-r(0, 1), r(0, 0))};
}

static PointBlockResult adjust_as_stated(const PointBlock& given, const PointBlockOptions& options) {
  require_enough_observations(given);
  require_enough_control(given);
  require_coordinates(given);
  require_known_names(given, options.free_parameters);
  PointBlock block = given;
  align_to_control(block);
  const Eigen::Vector3d origin = origin_of(block);
  const Built built = build(block, options, origin);
  const bundle::Layout layout(built.problem);
  bundle::AdjustOptions how;
  how.announce = options.announce;
  how.minimise.max_iterations = options.max_iterations;
  how.minimise.threads = options.threads;
  how.minimise.side = options.side;
  how.minimiser = options.minimiser;
  const int motions = bundle::free_motions(built.problem);
  how.datum = options.free_datum == PointBlockOptions::FreeDatum::inner
                  ? bundle::inner_datum(built.problem, layout, motions)
                  : bundle::first_image_datum(built.problem, layout, built.state, motions);
  const bundle::Adjusted adjusted =
      (options.by_gradients ? bundle::adjust_by_gradients : bundle::adjust)(built.problem, layout, built.state, how);
  if (adjusted.redundancy() < 1)
    throw std::runtime_error("the block has no redundancy: nothing checks its observations");
  const double factor = adjusted.sum_of_squares / adjusted.redundancy();
  PointBlockResult result;
  result.block = block;
  result.observations = adjusted.rows;
  result.unknowns = adjusted.unknowns;
  result.constraints = adjusted.defect;
  result.degrees_of_freedom = adjusted.redundancy();
  result.iterations = adjusted.iterations;
  result.sigma0 = options.image_sigma * std::sqrt(factor);
  result.weighted_sum_of_squares = options.image_sigma * options.image_sigma * adjusted.sum_of_squares;
  result.rays.resize(block.points.size());
  for (const auto& m : block.measurements) stop_point(), ++result.rays[m.point];
  store_values(adjusted.state, origin, result.block);
  for (size_t i = 0; i < built.problem.images.size(); ++i)
    if (built.problem.images[i].shift_free)
      result.principal_points.push_back(adjusted.state.shift(static_cast<int>(i)));
  const bool by_image = options.free_datum == PointBlockOptions::FreeDatum::first_image;
  if (options.by_gradients)
    fill_unknown_covariances(built.problem, layout, result);
  else
    fill_covariances(built, layout, adjusted, factor, by_image ? how.datum.held : std::vector<int>{}, result),
        fill_check_covariance(given.control, layout, *adjusted.cofactors, factor, result);
  bundle::Reliability reliability = options.by_gradients ? residuals_of(built.problem, layout, adjusted.state)
                                                         : bundle::reliability_of(built.problem, adjusted);
  fill_control(given, built, reliability, factor, result);
  fill_reliability(std::move(reliability), factor, result);
  return result;
}

/// By which the images' standard deviations are to be multiplied; 1: nothing else is observed, or nothing checks them.
static double image_scale_of(const PointBlockResult& result) {
  constexpr double enough = 10;  // of fewer the factor is mostly chance
  double factor = 1, others = 0;
  for (const auto& group : result.groups)
    if (group.name != "image coordinates")
      others += group.redundancy;
    else if (group.redundancy >= enough && group.factor > 0)
      factor = group.factor;
  constexpr double nothing = 1e-6;
  return others > nothing ? std::sqrt(factor) : 1;
}

PointBlockResult adjust_point_block(const PointBlock& given, const PointBlockOptions& options) {
  PointBlockResult result = adjust_as_stated(given, options);
  if (!options.estimate_image_variance || options.by_gradients) return result;
  constexpr int max_steps = 8;
  constexpr double close = 0.01, smallest = 0.05, largest = 1000;  // a block without noise would run away
  double scale = 1;
  for (int step = 0; step < max_steps; ++step) {
    const double next = std::clamp(scale * image_scale_of(result), smallest, largest);
    if (std::abs(next / scale - 1) < close) break;
    scale = next;
    PointBlock weighted = result.block;  // near the minimum
    weighted.control = given.control;
    for (size_t m = 0; m < weighted.measurements.size(); ++m)
      weighted.measurements[m].sigma = scale * sigma_of(given.measurements[m], options);
    result = adjust_as_stated(weighted, options);
  }
  for (size_t m = 0; m < given.measurements.size(); ++m)
    result.block.measurements[m].sigma = given.measurements[m].sigma;
  result.sigma0 *= scale, result.weighted_sum_of_squares *= scale * scale;
  result.image_variance_factor = scale * scale;
  return result;
}

}  // namespace plumbline::block

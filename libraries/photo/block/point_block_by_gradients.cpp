#include "photo/block/point_block_by_gradients.hpp"

#include <Eigen/LU>
#include <limits>

#include "photo/bundle/terms.hpp"

namespace plumbline::block {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

}  // namespace

bundle::Reliability residuals_of(const bundle::Problem& problem, const bundle::Layout& layout,
                                 const bundle::State& state) {
  least_squares::RowStatistics unknown;
  for (double* value : {&unknown.sigma_adjusted, &unknown.redundancy_number, &unknown.controlled, &unknown.w,
                        &unknown.estimated_blunder, &unknown.mdb, &unknown.bias_to_noise, &unknown.external_effect})
    *value = kUnknown;
  bundle::Reliability result;
  for (const auto& group : problem.groups) result.groups.push_back({group.name, kUnknown, 0, kUnknown, 0});
  const auto add = [&](int group, double squares, Eigen::Index rows) {
    result.groups[group].sum_of_squares += squares;
    result.groups[group].rows += static_cast<int>(rows);
  };
  bundle::Rows rows;
  for (const auto& o : problem.image_points) {
    bundle::evaluate(problem, layout, state, o, false, rows);
    auto& statistics = result.points.emplace_back();
    statistics.fill(unknown);
    const Eigen::Matrix2d back = o.whitening.inverse();
    for (Eigen::Index k = 0; k < 2; ++k) {
      statistics[k].residual = back.row(k).dot(rows.values());
      statistics[k].sigma = back.row(k).norm();
    }
    add(o.group, rows.values().squaredNorm(), 2);
  }
  for (const auto& o : problem.distances) {
    bundle::evaluate(problem, layout, state, o, false, rows);
    result.distances.push_back(unknown);
    result.distances.back().residual = o.sigma * rows.values()(0), result.distances.back().sigma = o.sigma;
    add(o.group, rows.values().squaredNorm(), 1);
  }
  for (const auto& term : problem.known) {
    const Eigen::VectorXd residual = bundle::evaluate(problem, layout, state, term).residual;
    result.known.emplace_back(static_cast<size_t>(residual.size()), unknown);
    add(term.group, residual.squaredNorm(), residual.size());
  }
  return result;
}

void fill_unknown_covariances(const bundle::Problem& problem, const bundle::Layout& layout, PointBlockResult& result) {
  result.point_covariances.assign(problem.points.size(), Eigen::Matrix3d::Constant(kUnknown));
  for (size_t c = 0; c < problem.cameras.size(); ++c) {
    result.free_parameters.push_back(layout.free_values(static_cast<int>(c)));
    const auto size = static_cast<Eigen::Index>(result.free_parameters.back().size());
    result.interior_covariance.emplace_back(Eigen::MatrixXd::Constant(size, size, kUnknown));
  }
  const size_t images = problem.images.size();
  result.pose_covariance.assign(images, Matrix6::Constant(kUnknown));
  result.orientation_covariance = result.pose_covariance;
  result.pose_interior_correlation.assign(images, Eigen::MatrixXd::Constant(6, 1, kUnknown));
  for (const auto& image : problem.images)
    if (image.shift_free) result.principal_point_covariance.emplace_back(Eigen::Matrix2d::Constant(kUnknown));
}

}  // namespace plumbline::block

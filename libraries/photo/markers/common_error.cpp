#include "photo/markers/common_error.hpp"

#include <stdexcept>

#include "photo/bundle/elimination.hpp"

namespace plumbline::markers {

Eigen::VectorXd effect_of(const bundle::Problem& problem, const bundle::Layout& layout, const bundle::State& state,
                          const std::vector<Eigen::Vector2d>& moved) {
  bundle::Elimination elimination(problem, layout, bundle::Side::images);
  if (!elimination.build(state) || !elimination.factorise(Eigen::MatrixXd(elimination.kept_count(), 0)))
    throw std::runtime_error("the normal equations have no solution for the effect of a common error");
  bundle::Problem displaced = problem;
  for (std::size_t k = 0; k < moved.size(); ++k) displaced.image_points[k].observed += moved[k];
  const bundle::Elimination other(displaced, layout, bundle::Side::images);
  Eigen::VectorXd pull;
  double cost = 0;
  if (!other.gradient(state, pull, cost)) throw std::runtime_error("an image point cannot be computed at the minimum");
  return elimination.step(pull - elimination.right());
}

}  // namespace plumbline::markers

// A tower whose anchors are off, for tests: deviations drawn from their own covariance or larger.
#pragma once

#include <Eigen/Cholesky>

#include "geometry/random.hpp"
#include "loop/simulate/tower.hpp"

namespace plumbline::test {

/// Anchors off by `off` [m] on each axis; measured with `sigma` each and `common` on each axis for a whole floor [m].
inline loop::Facade random_facade(const loop::TowerOptions& options, std::uint64_t seed, double off = 0.004,
                                  double sigma = 0.0005, double common = 0.001) {
  loop::Facade facade = loop::make_tower(options);
  Random random(seed, "facade");
  for (loop::Bracket& bracket : facade.brackets) bracket.deviation = random.normal3(off);
  for (std::size_t i = 0; i < facade.brackets.size(); ++i)
    for (std::size_t j = 0; j < facade.brackets.size(); ++j)
      if (i == j || facade.brackets[i].floor == facade.brackets[j].floor)
        facade.covariance.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j)) =
            ((i == j ? sigma * sigma : 0.0) + common * common) * Eigen::Matrix3d::Identity();
  return facade;
}

}  // namespace plumbline::test

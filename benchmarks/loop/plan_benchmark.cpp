// How long a plan takes: settings of a facade whose anchors are off, and the gates of its panels.
//
//   plan_benchmark [PANELS [OFF_MM [SEEDS]]]
//
// Ten panels to a floor; each anchor measured to 0.5 mm, and 1 mm common to a floor. Prints processor time, the least
// of the seeds and the most: of the optimum, then of the gates; and of each seed how long both took by the clock.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

#include "geometry/random.hpp"
#include "loop/gate/gate.hpp"
#include "loop/simulate/tower.hpp"

using namespace plumbline;
using namespace plumbline::loop;

namespace {

Facade facade_of(const TowerOptions& options, std::uint64_t seed, double off) {
  constexpr double sigma = 0.0005, common = 0.001;
  Facade facade = make_tower(options);
  Random random(seed, "facade");
  for (Bracket& bracket : facade.brackets) bracket.deviation = random.normal3(off);
  for (std::size_t i = 0; i < facade.brackets.size(); ++i)
    for (std::size_t j = 0; j < facade.brackets.size(); ++j)
      if (facade.brackets[i].floor == facade.brackets[j].floor)
        facade.covariance.block<3, 3>(3 * static_cast<Eigen::Index>(i), 3 * static_cast<Eigen::Index>(j)) =
            ((i == j ? sigma * sigma : 0.0) + common * common) * Eigen::Matrix3d::Identity();
  return facade;
}

double seconds_since(std::clock_t start) { return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC; }

/// By a clock on the wall: the gates take all cores.
double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

int main(int argc, char** argv) {
  const int panels = argc > 1 ? std::atoi(argv[1]) : 1000, seeds = argc > 3 ? std::atoi(argv[3]) : 3;
  const double off = 1e-3 * (argc > 2 ? std::atof(argv[2]) : 6);
  TowerOptions options;
  options.bays = 10, options.floors = std::max(1, panels / 10);
  std::vector<double> fits, gates;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Facade facade = facade_of(options, static_cast<std::uint64_t>(seed), off);
    const auto begin = std::chrono::steady_clock::now();
    std::clock_t start = std::clock();
    const Fit fit = plan_settings(facade);
    fits.push_back(seconds_since(start));
    start = std::clock();
    judge_plan(facade, fit);
    gates.push_back(seconds_since(start));
    std::printf(
        "seed %d: settings %.2f s (%d solutions, %zu to be set by hand, objective %.9e), gates %.2f s; both %.2f s\n",
        seed, fits.back(), fit.solves, fit.relaxations.size(), fit.objective, gates.back(), seconds_since(begin));
  }
  std::printf("%zu panels, anchors off by %.0f mm: settings %.2f to %.2f s, gates %.2f to %.2f s of processor time\n",
              make_tower(options).panels.size(), 1e3 * off, *std::min_element(fits.begin(), fits.end()),
              *std::max_element(fits.begin(), fits.end()), *std::min_element(gates.begin(), gates.end()),
              *std::max_element(gates.begin(), gates.end()));
}

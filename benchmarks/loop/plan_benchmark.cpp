// How long a plan takes: settings of a facade whose anchors are off, and the gates of its panels.
//
//   plan_benchmark [PANELS [OFF_MM [SEEDS [STACKED]]]]
//
// Ten panels to a floor; each anchor measured to 0.5 mm, and 1 mm common to a floor. STACKED: each panel hangs on two
// brackets, so far up in its height (0.75; with 0.5 what an edge is off by is handed on undiminished), and stands on
// the one below; 0: on four. Prints processor time, the least of the seeds and the most: of the optimum, then of the
// gates; of each seed how long both took by the clock; and the most memory beside the covariance of the anchors.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <string>
#include <vector>

#include "geometry/random.hpp"
#include "loop/gate/gate.hpp"
#include "loop/simulate/tower.hpp"

using namespace plumbline;
using namespace plumbline::loop;

namespace {

/// Each panel on its upper two brackets, in the joint of the one below; the lowest on a sill that was not measured.
/// Brackets that carry nothing then are left out.
Facade stacked(Facade facade, const TowerOptions& options, double share) {
  std::vector<Bracket> kept;
  std::vector<std::size_t> place(facade.brackets.size());
  for (std::size_t b = 0; b < facade.brackets.size(); ++b) {
    const auto row = b / static_cast<std::size_t>(options.bays + 1) % 2;
    place[b] = kept.size();
    if (row == 0) continue;
    kept.push_back(facade.brackets[b]);
    kept.back().design.z() += (share - 0.75) * options.height;
  }
  facade.brackets = std::move(kept);
  for (std::size_t j = 0; j < facade.panels.size(); ++j) {
    Panel& panel = facade.panels[j];
    panel.hooks.resize(2);
    for (Hook& hook : panel.hooks) hook.bracket = place[hook.bracket];
    Support below;
    below.sigma = 0.0005;
    below.place = 0.5 * (panel.corners[0] + panel.corners[1]) - 0.5 * options.joint * panel.axes.col(1);
    below.panel = static_cast<int>(j) - options.bays;
    if (below.panel < 0) below.panel = -1;
    panel.below = below;
  }
  const auto n = static_cast<Eigen::Index>(3 * facade.brackets.size());
  facade.covariance = Eigen::MatrixXd::Zero(n, n);
  return facade;
}

Facade facade_of(const TowerOptions& options, std::uint64_t seed, double off, double share) {
  constexpr double sigma = 0.0005, common = 0.001;
  Facade facade = make_tower(options);
  if (share > 0) facade = stacked(std::move(facade), options, share);
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

/// Memory that is taken now, or the most since forget_most() [GB].
double memory(const std::string& which) {
  std::ifstream status("/proc/self/status");
  for (std::string name; status >> name;)
    if (double kilobytes = 0; name == which + ":" && status >> kilobytes) return 1e-6 * kilobytes;
  return 0;
}
void forget_most() { std::ofstream("/proc/self/clear_refs") << "5"; }

}  // namespace

int main(int argc, char** argv) {
  const int panels = argc > 1 ? std::atoi(argv[1]) : 1000, seeds = argc > 3 ? std::atoi(argv[3]) : 3;
  const double off = 1e-3 * (argc > 2 ? std::atof(argv[2]) : 6), share = argc > 4 ? std::atof(argv[4]) : 0;
  TowerOptions options;
  options.bays = 10, options.floors = std::max(1, panels / 10);
  std::vector<double> fits, gates;
  for (int seed = 1; seed <= seeds; ++seed) {
    const Facade facade = facade_of(options, static_cast<std::uint64_t>(seed), off, share);
    forget_most();
    const double before = memory("VmRSS");
    const auto begin = std::chrono::steady_clock::now();
    std::clock_t start = std::clock();
    const Fit fit = plan_settings(facade);
    fits.push_back(seconds_since(start));
    start = std::clock();
    judge_plan(facade, fit);
    gates.push_back(seconds_since(start));
    std::printf(
        "seed %d: settings %.2f s (%d solutions, %zu to be set by hand, objective %.9e), gates %.2f s; both %.2f s, "
        "%.2f GB more than before\n",
        seed, fits.back(), fit.solves, fit.relaxations.size(), fit.objective, gates.back(), seconds_since(begin),
        memory("VmHWM") - before);
  }
  std::printf("%zu panels, anchors off by %.0f mm: settings %.2f to %.2f s, gates %.2f to %.2f s of processor time\n",
              static_cast<std::size_t>(options.floors) * static_cast<std::size_t>(options.bays), 1e3 * off,
              *std::min_element(fits.begin(), fits.end()), *std::max_element(fits.begin(), fits.end()),
              *std::min_element(gates.begin(), gates.end()), *std::max_element(gates.begin(), gates.end()));
}

// A tower in a closed loop where everything goes wrong that a site can plant: nothing wrong becomes VERIFIED.
#include <gtest/gtest.h>

#include "loop/simulate/trial.hpp"

namespace plumbline::loop {
namespace test_trial {

/// What is stated of where a base stands is what its errors are, at the item that is worst off: of both simulators.
TEST(Robots, WhatIsStatedOfTheBaseIsWhatItIsOffBy) {
  RobotModel model;
  model.station = 0.0002, model.drift = 0.0003, model.tilt = 0.0001;
  std::vector<Eigen::Vector3d> from_first;
  for (int i = 0; i < 16; ++i) from_first.emplace_back(0.4 * i, 0, 0);
  Eigen::Vector3d squares = Eigen::Vector3d::Zero();
  constexpr int kTrials = 4000;
  for (int t = 0; t < kTrials; ++t)
    squares += off_by_base(model, from_first.back(), 16, Random(t, "station"), Random(t, "drift"), Random(t, "tilt"))
                   .cwiseAbs2();
  EXPECT_NEAR(std::sqrt(squares.maxCoeff() / kTrials), sigma_by_base(model, from_first), 0.00005);
  EXPECT_GT(sigma_by_base(model, from_first), 4 * model.drift) << "16 drifts add up";
}

/// A site whose robots tilt and drift is set off by it, and says so.
TEST(Robots, ASiteHasTheTiltAndTheDriftOfItsRobots) {
  SiteOptions options;
  SimulatedSite exact(options, 3);
  options.robot.drift = 0.001, options.robot.tilt = 0.001;
  SimulatedSite drifting(options, 3);
  EXPECT_GT(drifting.stated_errors().station, 2 * exact.stated_errors().station);
  for (SimulatedSite* site : {&exact, &drifting})
    for (std::size_t b = 0; b < 4; ++b) site->set(b, Eigen::Vector3d(0.002, 0, 0), 1);
  EXPECT_GT((drifting.true_deviations()[3] - exact.true_deviations()[3]).norm(), 0.0005);
}

TEST(Trial, NothingWrongBecomesVerifiedAmongFaultsOfAllKinds) {
  SiteOptions options;
  options.tower.floors = 3, options.tower.bays = 2, options.tower.facades = 2;
  options.faults = Faults::all(0.03);
  int planted = 0, verified = 0, brackets_wrong = 0, panels_wrong = 0;
  std::map<std::string, int> kinds;
  double worst = 0, stated = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    const TrialResult r = run_trial(options, Strategy::closed, seed);
    planted += r.planted, verified += r.verified, brackets_wrong += r.planted_verified;
    panels_wrong += r.verified_wrong, worst = std::max(worst, r.verified_worst), stated += r.panels;
    for (const auto& [kind, count] : r.planted_by_kind) kinds[kind] += count;
    for (const std::string& line : r.missed) std::printf("missed %s\n", line.c_str());
  }
  std::printf(
      "%d faults, %d brackets wrongly VERIFIED; %d of %.0f panels VERIFIED, %d of them outside, worst %.2f mm\n",
      planted, brackets_wrong, verified, stated, panels_wrong, 1e3 * worst);
  for (const auto& [kind, count] : kinds) std::printf("  %s: %d\n", kind.c_str(), count);
  for (const char* kind : {"hidden", "partial campaign", "other job", "did nothing"}) EXPECT_GT(kinds[kind], 0) << kind;
  EXPECT_GE(planted, 170) << "hardly a fault was planted";
  EXPECT_EQ(brackets_wrong, 0);
  EXPECT_EQ(panels_wrong, 0) << "worst " << 1e3 * worst << " mm outside";
  EXPECT_GT(verified, stated / 2);
}

}  // namespace test_trial
}  // namespace plumbline::loop

// A tower in a closed loop where everything goes wrong that a site can plant: nothing wrong becomes VERIFIED.
#include "loop/simulate/trial.hpp"

#include <gtest/gtest.h>

namespace plumbline::loop {
namespace trial_test {

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

}  // namespace trial_test
}  // namespace plumbline::loop

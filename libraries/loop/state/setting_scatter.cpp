#include "loop/state/setting_scatter.hpp"

#include <fmt/core.h>

#include <cmath>
#include <map>
#include <vector>

#include "geometry/median.hpp"
#include "loop/state/bracket_places.hpp"

namespace plumbline::loop {
namespace {

/// Of a normal distribution: its standard deviation over the median of absolute values.
constexpr double kNormal = 1.4826;
/// Of 18 independent lengths a scatter of twice what it should be is seen in one of some thousand rounds.
constexpr int kFewest = 6;
constexpr double kTooMuch = 2;

}  // namespace

double SettingScatter::setting() const { return std::sqrt(std::max(0.0, seen * seen - campaigns * campaigns)); }

SettingScatter setting_scatter(const LoopStateT& state, const InstallationPlanT& plan, const std::string& measured_at) {
  std::map<std::string, const BracketSettingT*> planned;
  for (const auto& bracket : plan.brackets) planned[bracket->id] = bracket.get();
  SettingScatter scatter;
  std::vector<double> off;
  double squares = 0;
  for (const auto& item : state.items) {
    const auto found = planned.find(item->id);
    if (item->kind != "bracket" || item->status != ItemStatus::executed || found == planned.end()) continue;
    const BracketSettingT& bracket = *found->second;
    if (!bracket.measured.allFinite() || !item->expected.allFinite() || !is_measured_anew(*item, bracket, measured_at))
      continue;
    const Eigen::Vector3d shift = along_axes(bracket, bracket.measured - place_of(*item, bracket));
    for (int k = 0; k < 3; ++k) off.push_back(std::abs(shift[k]));
    const bool is_told = (bracket.difference_sigma.array() > 0).all();
    squares += is_told ? bracket.difference_sigma.squaredNorm() : 2 * bracket.sigma.squaredNorm();
    ++scatter.brackets;
  }
  if (scatter.brackets == 0) return scatter;
  scatter.seen = kNormal * median(off);
  scatter.campaigns = std::sqrt(squares / (3 * scatter.brackets));
  return scatter;
}

std::string scatter_words(const SettingScatter& scatter, const InstallationPlanT& plan) {
  const double taken = std::hypot(plan.setting_sigma, plan.station_sigma);
  if (scatter.brackets < kFewest || !(scatter.seen > kTooMuch * std::hypot(taken, scatter.campaigns))) return {};
  return fmt::format(
      "{} brackets that were set stand {:.2f} mm from where they were to be (standard deviation, each direction), and "
      "two campaigns differ by {:.2f} mm: who sets does so to {:.2f} mm, the plan takes {:.2f} mm, and its "
      "probabilities are too high; give the planner setting_sigma={:.5f}",
      scatter.brackets, 1e3 * scatter.seen, 1e3 * scatter.campaigns, 1e3 * scatter.setting(), 1e3 * taken,
      scatter.setting());
}

}  // namespace plumbline::loop

#include "loop/state/setting_scatter.hpp"

#include <fmt/core.h>

#include <cmath>
#include <map>
#include <utility>

#include "geometry/median.hpp"
#include "loop/state/bracket_places.hpp"

namespace plumbline::loop {
namespace {

/// Of a normal distribution: its standard deviation over the median of absolute values.
constexpr double kNormal = 1.4826;
/// Variance of a median over that of a mean, of many.
constexpr double kMedian = M_PI / 2;
/// Of 18 independent lengths a scatter of twice what it should be is seen in one of some thousand rounds.
constexpr int kFewest = 6;
constexpr double kTooMuch = 2;
/// A station's shift in one direction, in its standard deviations: by chance one of some thousand.
constexpr double kShifted = 4;
constexpr int kLeastOfStation = 3;

struct SetBracket {
  const BracketSettingT* bracket;
  Eigen::Vector3d off;  ///< measured less where it was to be, in the frame [m]
  double variance;      ///< of the difference of two campaigns, mean of three directions
};

using Stations = std::map<std::pair<int, std::string>, std::vector<SetBracket>>;

Stations stations_of(const LoopStateT& state, const InstallationPlanT& plan, const std::string& measured_at) {
  std::map<std::string, const BracketSettingT*> planned;
  for (const auto& bracket : plan.brackets) planned[bracket->id] = bracket.get();
  Stations stations;
  for (const auto& item : state.items) {
    const auto found = planned.find(item->id);
    if (item->kind != "bracket" || item->status != ItemStatus::executed || found == planned.end()) continue;
    const BracketSettingT& bracket = *found->second;
    if (!bracket.measured.allFinite() || !item->expected.allFinite() || !is_measured_anew(*item, bracket, measured_at))
      continue;
    const bool is_told = (bracket.difference_sigma.array() > 0).all();
    stations[{item->floor, item->by}].push_back(
        {&bracket, bracket.measured - place_of(*item, bracket),
         is_told ? bracket.difference_sigma.squaredNorm() / 3 : 2 * bracket.sigma.squaredNorm() / 3});
  }
  return stations;
}

Eigen::Vector3d median_of(const std::vector<SetBracket>& brackets) {
  Eigen::Vector3d out;
  for (Eigen::Index k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const SetBracket& one : brackets) values.push_back(one.off[k]);
    out[k] = median(std::move(values));
  }
  return out;
}

/// Absolute lengths about `middle`, along the directions that each bracket is set by.
void add_lengths(const std::vector<SetBracket>& brackets, const Eigen::Vector3d& middle, double widened,
                 std::vector<double>& lengths) {
  for (const SetBracket& one : brackets) {
    const Eigen::Vector3d along = along_axes(*one.bracket, one.off - middle);
    for (int k = 0; k < 3; ++k) lengths.push_back(widened * std::abs(along[k]));
  }
}

std::string who(const StationShift& station) {
  return fmt::format("what {} set on floor {} ({} brackets)", station.by.empty() ? "somebody" : station.by,
                     station.floor, station.brackets);
}

}  // namespace

double SettingScatter::setting() const { return std::sqrt(std::max(0.0, seen * seen - campaigns * campaigns)); }

double SettingScatter::station() const {
  double squares = 0;
  for (const StationShift& one : stations) squares += one.shift.squaredNorm() - one.sigma.squaredNorm();
  return stations.empty() ? 0 : std::sqrt(std::max(0.0, squares / (3 * static_cast<double>(stations.size()))));
}

SettingScatter setting_scatter(const LoopStateT& state, const InstallationPlanT& plan, const std::string& measured_at) {
  const Stations stations = stations_of(state, plan, measured_at);
  SettingScatter scatter;
  std::vector<double> apart, together;
  double squares = 0;
  for (const auto& [which, brackets] : stations) {
    const auto n = static_cast<double>(brackets.size());
    scatter.brackets += static_cast<int>(brackets.size());
    for (const SetBracket& one : brackets) squares += one.variance;
    add_lengths(brackets, Eigen::Vector3d::Zero(), 1, together);
    if (static_cast<int>(brackets.size()) < kLeastOfStation) continue;
    const Eigen::Vector3d middle = median_of(brackets);
    scatter.stations.push_back({which.first, which.second, static_cast<int>(brackets.size()), middle, {}});
    // What is about its own middle scatters less.
    add_lengths(brackets, middle, std::sqrt(n / (n - 1)), apart);
  }
  if (scatter.brackets == 0) return scatter;
  scatter.campaigns = std::sqrt(squares / scatter.brackets);
  const bool parted = static_cast<int>(apart.size()) >= 3 * kFewest;
  if (!parted) scatter.stations.clear();
  scatter.seen = kNormal * median(parted ? apart : together);
  for (StationShift& station : scatter.stations)
    station.sigma.setConstant(scatter.seen * std::sqrt(kMedian / station.brackets));
  return scatter;
}

std::vector<std::string> scatter_words(const SettingScatter& scatter, const InstallationPlanT& plan) {
  std::vector<std::string> words;
  // What stations are off by is in what is seen where they were too few to be parted.
  const double taken =
      scatter.stations.empty() ? std::hypot(plan.setting_sigma, plan.station_sigma) : plan.setting_sigma;
  if (scatter.brackets >= kFewest && scatter.seen > kTooMuch * std::hypot(taken, scatter.campaigns))
    words.push_back(fmt::format(
        "{} brackets that were set stand {:.2f} mm from where they were to be (standard deviation, each direction{}), "
        "and two campaigns differ by {:.2f} mm: who sets does so to {:.2f} mm, the plan takes {:.2f} mm, and its "
        "probabilities are too high; give the planner setting_sigma={:.5f}",
        scatter.brackets, 1e3 * scatter.seen, scatter.stations.empty() ? "" : ", each station about its own middle",
        1e3 * scatter.campaigns, 1e3 * scatter.setting(), 1e3 * taken, scatter.setting()));
  for (const StationShift& station : scatter.stations) {
    // Two campaigns differ by what they do not share, and a station of the survey errs as one: not by its root.
    const Eigen::Vector3d may = (station.sigma.array().square() + plan.station_sigma * plan.station_sigma +
                                 scatter.campaigns * scatter.campaigns)
                                    .sqrt();
    if (!((station.shift.cwiseAbs() - kShifted * may).maxCoeff() > 0)) continue;
    words.push_back(fmt::format(
        "{} stands off as a whole, by {:.2f}, {:.2f} and {:.2f} mm (E, N, H), where the plan takes {:.2f} mm for the "
        "place of who sets (station_sigma): it is not how it sets, but where its station, the control of that floor or "
        "the survey's set-up there is; check these",
        who(station), 1e3 * station.shift.x(), 1e3 * station.shift.y(), 1e3 * station.shift.z(),
        1e3 * plan.station_sigma));
  }
  return words;
}

}  // namespace plumbline::loop

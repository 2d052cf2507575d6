#include "loop/state/copied_places.hpp"

#include <fmt/core.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "loop/state/report_order.hpp"

namespace plumbline::loop {
namespace {

/// What is nearer than this to the target is its own number, with all digits or with the four decimals of a file [m].
constexpr double kExact = 6e-5;
constexpr double kMillimetre = 1e-3;

/// Of the target, along the axes that the place was written along [m]; a rounded number is off by half a step at most.
double largest_difference(const ActualT& report, const Eigen::Vector3d& target) {
  const double turn = std::isfinite(report.written_turn) ? report.written_turn : 0;
  const Eigen::AngleAxisd to_written(-turn, Eigen::Vector3d::UnitZ());
  return (to_written * (report.measured - target)).cwiseAbs().maxCoeff();
}

/// Who reads a report notes its step; of one that comes from elsewhere its own numbers tell.
bool is_in_millimetres(const ActualT& report) {
  if (std::isfinite(report.step)) return report.step > 0.9 * kMillimetre;
  const Eigen::Vector3d rounded = kMillimetre * (report.measured / kMillimetre).array().round();
  return (report.measured - rounded).cwiseAbs().maxCoeff() < 1e-9;
}

/// Of a report in whole millimetres.
struct Rounded {
  int places = 0;
  std::vector<const ActualT*> of_target;
};

}  // namespace

CopiedPlaces::CopiedPlaces(const LoopStateT& state, const ActualsT& actuals) {
  std::map<std::string, const LoopItemT*> items;
  for (const auto& item : state.items) items.emplace(item->id, item.get());
  std::map<std::string, Rounded> reports;
  for (const auto& report : actuals.items) {
    const auto item = items.find(report->item);
    // Brackets are measured again; that a panel hangs its place alone shows.
    if (item == items.end() || item->second->kind != "panel") continue;
    if (!report->measured.allFinite() || !item->second->expected.allFinite()) continue;
    const double off = largest_difference(*report, item->second->expected);
    const bool rounded = is_in_millimetres(*report);
    if (off <= kExact && !rounded) words_[report.get()] = "is the number that was asked for";
    if (!rounded) continue;
    Rounded& file = reports[report_file(*report, actuals)];
    ++file.places;
    if (off <= 0.5 * kMillimetre + 1e-6) file.of_target.push_back(report.get());
  }
  for (const auto& [name, file] : reports) {
    const auto copies = static_cast<int>(file.of_target.size());
    if (2 * copies <= file.places) continue;
    for (const ActualT* report : file.of_target)
      words_[report] = fmt::format(
          "is the number that was asked for, in whole millimetres, and so are {} of the {} places of panels in this "
          "report: give them to a tenth of a millimetre",
          copies, file.places);
  }
}

}  // namespace plumbline::loop

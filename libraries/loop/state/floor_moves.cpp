#include "loop/state/floor_moves.hpp"

#include <algorithm>

#include "geometry/median.hpp"
#include "loop/state/bracket_places.hpp"

namespace plumbline::loop {
namespace {

Eigen::Vector3d median_move(const std::vector<Eigen::Vector3d>& moves) {
  Eigen::Vector3d out;
  for (Eigen::Index k = 0; k < 3; ++k) {
    std::vector<double> values;
    for (const Eigen::Vector3d& v : moves) values.push_back(v[k]);
    out[k] = median(std::move(values));
  }
  return out;
}

/// Three brackets, or half of a floor, that all moved alike: robots that did nothing are as likely as control that
/// moved.
bool share_a_movement(const FloorMoves& floor) {
  const std::size_t n = floor.explained.size();
  if (n < 2 || (n < 3 && 2 * n < floor.moves.size() + n)) return false;
  const Eigen::Vector3d middle = median_move(floor.explained);
  return std::all_of(floor.explained.begin(), floor.explained.end(), [&](const Eigen::Vector3d& v) {
    return ((v - middle).cwiseAbs().array() <= floor.doubt.array()).all();
  });
}

}  // namespace

bool FloorMoves::moved() const {
  return share_a_movement(*this) ||
         (moves.size() >= 3 && (median_move(moves).cwiseAbs().array() > doubt.array()).any());
}

std::map<int, FloorMoves> moves_of_floors(const LoopStateT& state, const InstallationPlanT& plan, double tolerance,
                                          const std::string& measured_at) {
  std::map<std::string, const LoopItemT*> items;
  for (const auto& item : state.items)
    if (item->kind == "bracket") items[item->id] = item.get();
  std::map<int, FloorMoves> floors;
  for (const auto& bracket : plan.brackets) {
    const LoopItemT& item = *items.at(bracket->id);
    const Eigen::Vector3d shift = bracket->measured - place_of(item, *bracket);
    if (!shift.allFinite() || !is_measured_anew(item, *bracket, measured_at)) continue;
    const Eigen::Vector3d most = doubt_of(*bracket, tolerance);
    FloorMoves& floor = floors[item.floor];
    floor.doubt = floor.doubt.cwiseMax(most);
    const bool mistake = item.status == ItemStatus::executed && (shift.cwiseAbs().array() > most.array()).any() &&
                         !explanation(item, *bracket, most.maxCoeff()).empty();
    (mistake ? floor.explained : floor.moves).push_back(shift);
  }
  return floors;
}

}  // namespace plumbline::loop

#include "building/judgement/place_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "building/ifc/facade_artifact.hpp"

namespace plumbline::judgement {
namespace {

struct Place {
  PlaceStatistics row;
  std::vector<Eigen::Vector3d> deviations;  ///< right, up, out
  double left_to_right = 0;                 ///< sum over the anchors
};

ifc::FacadeFrame frame_of(const AnchorDeviationT& anchor) {
  const ifc::FacadeFrame frame = ifc::frame_or_none(anchor.facade);
  return frame.known() ? frame : ifc::frame_facing(-Eigen::Vector3d::UnitY(), ifc::FacadeSource::none, false);
}

void count(const AnchorDeviationT& anchor, const ifc::FacadeFrame& frame, Place& place) {
  PlaceStatistics& row = place.row;
  ++row.anchors;
  row.confirmed = row.confirmed && frame.confirmed;
  row.passed += anchor.verdict == ToleranceVerdict::pass;
  row.undecided += anchor.verdict == ToleranceVerdict::undecided;
  row.failed += anchor.verdict == ToleranceVerdict::fail;
  place.left_to_right += frame.right.dot(anchor.design);
  if (!anchor.deviation.allFinite()) return;
  const Eigen::Vector3d& d = anchor.deviation;
  place.deviations.emplace_back(frame.right.dot(d), frame.up.dot(d), frame.out.dot(d));
}

PlaceStatistics finished(Place& place) {
  PlaceStatistics& row = place.row;
  const auto n = static_cast<double>(place.deviations.size());
  row.measured = static_cast<int>(place.deviations.size());
  const auto unknown = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  if (row.measured == 0) row.mean = unknown;
  for (const Eigen::Vector3d& d : place.deviations) row.mean += d / n;
  for (const Eigen::Vector3d& d : place.deviations) row.spread += (d - row.mean).cwiseAbs2() / (n - 1);
  row.spread = row.measured < 2 ? Eigen::Vector3d(unknown) : Eigen::Vector3d(row.spread.cwiseSqrt());
  return row;
}

}  // namespace

std::vector<PlaceStatistics> place_statistics(const DeviationT& deviation,
                                              const std::function<std::string(const AnchorDeviationT&)>& axis_of) {
  struct OfFacade {
    std::map<int, Place> floors;
    std::map<std::string, Place> axes;
  };
  std::vector<std::string> order;
  for (const auto& facade : deviation.facades) order.push_back(facade->name);
  std::map<std::string, OfFacade> facades;
  for (const auto& anchor : deviation.anchors) {
    if (!anchor->design.allFinite()) continue;
    const ifc::FacadeFrame frame = frame_of(*anchor);
    const std::string facade = anchor->facade ? anchor->facade->facade : "";
    if (std::find(order.begin(), order.end(), facade) == order.end()) order.push_back(facade);
    OfFacade& places = facades[facade];
    if (anchor->floor > 0) {
      Place& place = places.floors[anchor->floor];
      place.row.kind = "floor", place.row.name = std::to_string(anchor->floor), place.row.facade = facade;
      count(*anchor, frame, place);
    }
    if (const std::string axis = axis_of(*anchor); !axis.empty()) {
      Place& place = places.axes[axis];
      place.row.kind = "axis", place.row.name = axis, place.row.facade = facade;
      count(*anchor, frame, place);
    }
  }
  std::vector<PlaceStatistics> all;
  for (const std::string& facade : order) {
    OfFacade& places = facades[facade];
    for (auto& [floor, place] : places.floors) all.push_back(finished(place));
    std::vector<Place*> axes;
    for (auto& [tag, place] : places.axes) axes.push_back(&place);
    const auto from_left = [](const Place* p) { return p->left_to_right / p->row.anchors; };
    std::stable_sort(axes.begin(), axes.end(), [&](Place* a, Place* b) { return from_left(a) < from_left(b); });
    for (Place* place : axes) all.push_back(finished(*place));
  }
  return all;
}

}  // namespace plumbline::judgement

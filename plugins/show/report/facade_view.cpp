#include "show/report/facade_view.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "building/ifc/facade_frame.hpp"

namespace plumbline::report {

namespace {

/// Before a facade; unrolled where it bends by more than 5°.
Sight sight_of(const FacadeT& facade, const DeviationT& deviation) {
  Sight sight;
  const ifc::FacadeFrame frame = ifc::frame_facing(facade.out, ifc::FacadeSource::none, false);
  sight.right = frame.right, sight.up = frame.up;
  if (facade.bend < 0.087) return sight;
  std::vector<Eigen::Vector3d> places;
  for (const auto& anchor : deviation.anchors)
    if (anchor->facade && anchor->facade->facade == facade.name && anchor->design.allFinite())
      places.push_back(anchor->design);
  std::sort(places.begin(), places.end(),
            [&](const auto& a, const auto& b) { return sight.right.dot(a) < sight.right.dot(b); });
  for (const Eigen::Vector3d& place : places) {
    const double s = sight.right.dot(place);
    if (sight.unrolled.empty()) {
      sight.unrolled.emplace_back(s, s);
    } else if (s > sight.unrolled.back().first + 0.3) {
      const Eigen::Vector3d before = *std::find_if(places.begin(), places.end(), [&](const auto& p) {
        return sight.right.dot(p) >= sight.unrolled.back().first - 1e-9;
      });
      sight.unrolled.emplace_back(s, sight.unrolled.back().second + (place - before).head<2>().norm());
    }
  }
  return sight;
}

}  // namespace

FacadeView model_view(const AccuracyT& accuracy) {
  FacadeView view{"Is the model right?", "model minus survey", "height deviation", {}, {}, {}};
  for (const auto& a : accuracy.anchors) {
    Spot spot;
    spot.id = a->id, spot.floor = a->floor, spot.control = a->use == AnchorUse::control;
    spot.position = {a->x, a->y, a->z};
    spot.difference.setConstant(std::nan("")), spot.number = std::nan("");
    if (const auto* d = a->survey.get())
      spot.difference = {d->dx, d->dy, d->dz}, spot.number = d->dz, spot.verdict = d->verdict;
    view.spots.push_back(std::move(spot));
  }
  return view;
}

FacadeView built_view(const DeviationT& deviation, const FacadeT* facade, bool out_of_plane, std::optional<int> floor) {
  FacadeView view{
      out_of_plane ? "How far out of the facade's plane?" : "Are the anchors in place?",
      out_of_plane ? "as-built minus design out of the facade's plane, upward is outward" : "as-built minus design",
      out_of_plane ? "out of plane, outward positive," : "height deviation",
      {},
      {},
      {}};
  if (facade) {
    view.sight = sight_of(*facade, deviation);
    view.question =
        "Facade " + facade->name + ": " + (out_of_plane ? "how far out of its plane?" : "are the anchors in place?");
    if (out_of_plane && !facade->confirmed)
      view.name = "as-built minus design across the facade; which way is outward is not confirmed",
      view.number = "across the facade, without a sign,";
  }
  const std::string name = facade ? facade->name : "";
  const auto belongs = [&](const std::unique_ptr<FacadeFrameT>& frame) {
    return (frame ? frame->facade : std::string()) == name;
  };
  for (const auto& a : deviation.anchors) {
    if (!belongs(a->facade) || (floor && a->floor != *floor)) continue;
    Spot spot;
    spot.id = a->id, spot.floor = a->floor, spot.position = a->design, spot.difference = a->deviation;
    spot.number = a->deviation.z(), spot.verdict = a->verdict, spot.control = a->use == "control";
    if (out_of_plane && facade) {
      spot.number = a->deviation.dot(a->facade->out);
      spot.difference = spot.number * view.sight.up;
      if (!facade->confirmed) spot.number = std::abs(spot.number);
    }
    view.spots.push_back(std::move(spot));
  }
  for (const auto& panel : deviation.panels) {
    if (!belongs(panel->facade) || panel->corners.size() < 4 || (floor && panel->floor != *floor)) continue;
    Quad quad{panel->name, panel->verdict, std::vector<Eigen::Vector3d>(4, Eigen::Vector3d::Zero())};
    const char* order[] = {"bottom_left", "bottom_right", "top_right", "top_left"};
    for (const auto& corner : panel->corners)
      for (std::size_t i = 0; i < 4; ++i)
        if (corner->name == order[i]) quad.corners[i] = corner->design;
    view.panels.push_back(std::move(quad));
  }
  view.behind = out_of_plane ? Behind::heat : Behind::picture;
  return view;
}

FacadeView only_of(const FacadeView& all, const FacadeT& facade, const DeviationT& deviation) {
  std::map<std::string, std::string> facade_of;
  for (const auto& a : deviation.anchors)
    if (a->facade) facade_of[a->id] = a->facade->facade;
  FacadeView view = all;
  view.sight = sight_of(facade, deviation), view.question = "Facade " + facade.name + ": is the model right?";
  std::erase_if(view.spots, [&](const Spot& spot) {
    const auto found = facade_of.find(spot.id);
    return found == facade_of.end() || found->second != facade.name;
  });
  return view;
}

}  // namespace plumbline::report

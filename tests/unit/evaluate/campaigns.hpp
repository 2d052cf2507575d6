// What tests of epochs share: campaigns of a few anchors and panels.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "building/judgement/epochs.hpp"
#include "small_building.hpp"

namespace plumbline::judgement::test {

inline std::unique_ptr<AnchorDeviationT> anchor(const std::string& id, ToleranceVerdict verdict,
                                                const Eigen::Vector3d& at, double sigma = 0.3 * mm) {
  auto out = std::make_unique<AnchorDeviationT>();
  out->id = id, out->guid = "guid-" + id, out->floor = 1, out->verdict = verdict;
  out->design = Eigen::Vector3d(1, 2, 3);
  out->as_built = out->design + at;
  if (verdict == ToleranceVerdict::not_measured) out->as_built.setConstant(NAN);
  if (verdict != ToleranceVerdict::not_measured) {
    out->covariance.assign(9, 0);
    for (const std::size_t k : {0, 4, 8}) out->covariance[k] = sigma * sigma;
  }
  return out;
}

inline std::unique_ptr<PanelDeviationT> panel(const std::string& name, ToleranceVerdict verdict) {
  auto out = std::make_unique<PanelDeviationT>();
  out->guid = "guid-" + name, out->name = name, out->verdict = verdict;
  return out;
}

inline DeviationT campaign(std::vector<std::unique_ptr<AnchorDeviationT>> anchors) {
  DeviationT deviation;
  deviation.tau = 5 * mm, deviation.risk = 0.05, deviation.design_file = "tower.ifc";
  deviation.anchors = std::move(anchors);
  return deviation;
}

inline const AsBuiltChangeT& of(const AsBuiltChangesT& changes, const std::string& id) {
  for (const auto& change : changes.changes)
    if (change->id == id) return *change;
  throw std::runtime_error("no change of " + id);
}

inline constexpr auto kPass = ToleranceVerdict::pass, kFail = ToleranceVerdict::fail,
                      kOpen = ToleranceVerdict::undecided, kNone = ToleranceVerdict::not_measured;
inline const Eigen::Vector3d kThere(0.001, 0, 0);

}  // namespace plumbline::judgement::test

#include "building/judgement/worst_first.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "building/ifc/limit_words.hpp"

namespace plumbline::judgement {

const JudgedAxisT* deciding_axis(const AnchorDeviationT& anchor) {
  for (const auto& axis : anchor.axes)
    if (!anchor.decided_by.empty() && axis->axis == anchor.decided_by) return axis.get();
  return nullptr;
}

namespace {

/// Fail, undecided, not measured, pass.
int urgency(ToleranceVerdict verdict) {
  return verdict == ToleranceVerdict::fail        ? 3
         : verdict == ToleranceVerdict::undecided ? 2
         : verdict == ToleranceVerdict::pass      ? 0
                                                  : 1;
}

/// Share of its tolerance that the deciding length uses.
double usage(const AnchorDeviationT& anchor) {
  const JudgedAxisT* axis = deciding_axis(anchor);
  // What has no number has no share: nan would have no place in any order.
  return axis ? ifc::share_of_limits(*axis) : 0;
}

double usage(const PanelDeviationT& panel) {
  double most = 0;
  for (const auto* l : {panel.out_of_plane.get(), panel.sideways.get(), panel.vertical.get(), panel.tilt.get(),
                        panel.warp.get(), panel.misfit.get(), panel.corner.get(), panel.in_plane.get()})
    if (l && l->tolerance > 0 && std::isfinite(l->value)) most = std::max(most, std::abs(l->value) / l->tolerance);
  return most;
}

template <typename T>
std::vector<const T*> sorted(const std::vector<std::unique_ptr<T>>& items) {
  std::vector<const T*> list;
  for (const auto& item : items) list.push_back(item.get());
  std::stable_sort(list.begin(), list.end(), [](const T* a, const T* b) {
    if (urgency(a->verdict) != urgency(b->verdict)) return urgency(a->verdict) > urgency(b->verdict);
    return usage(*a) > usage(*b);
  });
  return list;
}

}  // namespace

std::vector<const AnchorDeviationT*> worst_first(const DeviationT& deviation) { return sorted(deviation.anchors); }
std::vector<const PanelDeviationT*> worst_panels_first(const DeviationT& deviation) { return sorted(deviation.panels); }

}  // namespace plumbline::judgement

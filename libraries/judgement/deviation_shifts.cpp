#include "judgement/deviation_shifts.hpp"

#include <algorithm>
#include <functional>

#include "judgement/common_shift.hpp"
#include "judgement/group_shifts.hpp"

namespace plumbline::judgement {
namespace {

struct ShiftWork {
  const DeviationInputs& inputs;
  const DeviationOptions& options;
  const evaluate::DifferenceSet& deviations;
  DeviationT& out;
};

/// The smallest tolerance that any measured anchor is held against. A side of zero ("never too far out") is none.
double smallest_tolerance(const ShiftWork& work) {
  double smallest = work.options.tau;
  for (const std::size_t i : work.deviations.anchors)
    for (const auto& [axis, tolerance] : work.inputs.anchors[i].tolerances)
      for (const double side : {tolerance.value, tolerance.lower()})
        if (side > 0) smallest = std::min(smallest, side);
  return smallest;
}

/// Whether the k-th measured anchor would pass with another deviation; empty where the measurement proves nothing.
WouldPass would_pass_of(const ShiftWork& work) {
  if (!work.out.doubts.empty()) return {};
  return [&work](std::size_t k, const Eigen::Vector3d& deviation) {
    AnchorDeviationT judged;
    const AnchorCase& anchor = work.inputs.anchors[work.deviations.anchors[k]];
    if (!anchor.refused.empty()) return false;
    judge_anchor(deviation, block_of(work.deviations.covariance, k), anchor.facade, anchor.tolerances, work.options,
                 judged);
    return judged.verdict == ToleranceVerdict::pass;
  };
}

void find_common_shift(const ShiftWork& work) {
  std::vector<Eigen::Vector3d> positions, deviations;
  for (const std::size_t i : work.deviations.anchors)
    positions.push_back(work.out.anchors[i]->design), deviations.push_back(work.out.anchors[i]->deviation);
  const double smallest = smallest_tolerance(work);
  std::function<int(const std::vector<Eigen::Vector3d>&)> would_pass;
  if (const WouldPass one = would_pass_of(work))
    would_pass = [one](const std::vector<Eigen::Vector3d>& corrected) {
      int passing = 0;
      for (std::size_t k = 0; k < corrected.size(); ++k) passing += one(k, corrected[k]);
      return passing;
    };
  work.out.common_shift = common_shift(positions, deviations, work.deviations.covariance, smallest, would_pass);
  if (work.out.common_shift && work.out.common_shift->significant)
    work.out.warnings.push_back(work.out.common_shift->words);
}

/// What single floors, facades, columns and batches have in common, beyond what all of them have.
void find_group_shifts(const ShiftWork& work) {
  const CommonShiftT* common =
      work.out.common_shift && work.out.common_shift->significant ? work.out.common_shift.get() : nullptr;
  std::vector<GroupMember> members;
  for (const std::size_t i : work.deviations.anchors) {
    const AnchorCase& anchor = work.inputs.anchors[i];
    const AnchorDeviationT& row = *work.out.anchors[i];
    Eigen::Vector3d deviation = row.deviation;
    if (common) deviation -= common->shift + common->rotation.cross(Eigen::Vector3d(row.design - common->centre));
    members.push_back({deviation, row.floor, anchor.column, anchor.facade.facade, anchor.element.batch, anchor.facade});
  }
  work.out.group_shifts =
      group_shifts(members, work.deviations.covariance, smallest_tolerance(work), would_pass_of(work));
  for (const auto& group : work.out.group_shifts)
    if (group->significant) work.out.warnings.push_back(group->words);
}

}  // namespace

void tell_shifts(const DeviationInputs& inputs, const DeviationOptions& options,
                 const evaluate::DifferenceSet& deviations, DeviationT& out) {
  const ShiftWork work{inputs, options, deviations, out};
  find_common_shift(work);
  find_group_shifts(work);
}

}  // namespace plumbline::judgement

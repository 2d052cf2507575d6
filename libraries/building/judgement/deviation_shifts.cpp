#include "building/judgement/deviation_shifts.hpp"

#include <algorithm>
#include <functional>

#include "building/judgement/common_shift.hpp"
#include "building/judgement/group_shifts.hpp"

namespace plumbline::judgement {
namespace {

struct ShiftWork {
  const DeviationInputs& inputs;
  const DeviationOptions& options;
  const judgement::DifferenceSet& deviations;
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

std::unique_ptr<CommonShiftT> find_common_shift(const ShiftWork& work, const std::vector<Eigen::Vector3d>& deviations) {
  std::vector<Eigen::Vector3d> positions;
  for (const std::size_t i : work.deviations.anchors) positions.push_back(work.out.anchors[i]->design);
  std::function<int(const std::vector<Eigen::Vector3d>&)> would_pass;
  if (const WouldPass one = would_pass_of(work))
    would_pass = [one](const std::vector<Eigen::Vector3d>& corrected) {
      int passing = 0;
      for (std::size_t k = 0; k < corrected.size(); ++k) passing += one(k, corrected[k]);
      return passing;
    };
  return common_shift(positions, deviations, work.deviations.covariance, smallest_tolerance(work), would_pass);
}

using GroupShifts = std::vector<std::unique_ptr<GroupShiftT>>;

/// What single floors, facades, columns and batches have in common, of these deviations.
GroupShifts find_group_shifts(const ShiftWork& work, const std::vector<Eigen::Vector3d>& deviations,
                              std::vector<Eigen::Vector3d>* remainder = nullptr, bool whole = false) {
  std::vector<GroupMember> members;
  for (std::size_t k = 0; k < deviations.size(); ++k) {
    const std::size_t i = work.deviations.anchors[k];
    const AnchorCase& anchor = work.inputs.anchors[i];
    members.push_back({deviations[k], work.out.anchors[i]->floor, anchor.column, anchor.facade.facade,
                       anchor.element.batch, anchor.axis, anchor.facade});
  }
  return group_shifts(members, work.deviations.covariance, smallest_tolerance(work), would_pass_of(work), remainder,
                      whole);
}

std::ptrdiff_t sentences(const GroupShifts& shifts) {
  return std::count_if(shifts.begin(), shifts.end(), [](const auto& shift) { return shift->significant; });
}

}  // namespace

/// One facade that stands out pulls the mean of the whole building after it, and everything else then seems to stand
/// back: of what explains the deviations, that with fewer sentences is told.
void tell_shifts(const DeviationInputs& inputs, const DeviationOptions& options,
                 const judgement::DifferenceSet& differences, DeviationT& out) {
  const ShiftWork work{inputs, options, differences, out};
  std::vector<Eigen::Vector3d> deviations, remainder;
  for (const std::size_t i : differences.anchors) deviations.push_back(out.anchors[i]->deviation);
  out.common_shift = find_common_shift(work, deviations);
  const bool together = out.common_shift && out.common_shift->significant;
  out.group_shifts = find_group_shifts(work, deviations, &remainder, !together);
  if (together) {
    CommonShiftT& common = *out.common_shift;
    std::vector<Eigen::Vector3d> beyond = deviations;
    for (std::size_t k = 0; k < beyond.size(); ++k) {
      const Eigen::Vector3d arm = out.anchors[differences.anchors[k]]->design - common.centre;
      beyond[k] -= common.shift + common.rotation.cross(arm);
    }
    GroupShifts then = find_group_shifts(work, beyond);
    const std::ptrdiff_t alone = sentences(out.group_shifts);
    const bool groups_tell =
        alone > 0 && alone < 1 + sentences(then) && !find_common_shift(work, remainder)->significant;
    if (groups_tell)
      common.significant = false, common.words.clear(), common.finding.clear(), common.members.clear();
    else
      out.group_shifts = std::move(then), out.warnings.push_back(common.words);
  }
  // They are numbered among the measured ones so far.
  const auto number = [&](std::vector<int>& members) {
    for (int& member : members) member = static_cast<int>(differences.anchors[static_cast<std::size_t>(member)]);
  };
  if (out.common_shift) number(out.common_shift->members);
  for (const auto& group : out.group_shifts) {
    number(group->members);
    if (group->significant) out.warnings.push_back(group->words);
  }
}

}  // namespace plumbline::judgement

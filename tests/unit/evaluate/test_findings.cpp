// Findings of a judgement are known again by the next campaign, whatever figures and names they have now.
#include <gtest/gtest.h>

#include "building/ifc/findings.hpp"
#include "building/judgement/epoch_findings.hpp"
#include "building/judgement/epochs.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_findings {

using enum ChangeKind;

DeviationT with_request(const std::string& panels) {
  DeviationT deviation;
  auto request = std::make_unique<JudgementRequestT>();
  request->asked = "panels " + panels, request->by = "unmeasured panels",
  request->not_judged = "none of their anchors was measured";
  deviation.requests.push_back(std::move(request));
  return deviation;
}

/// Five anchors that share a shift, all with this verdict.
DeviationT with_shift(ToleranceVerdict verdict) {
  DeviationT deviation;
  auto shift = std::make_unique<GroupShiftT>();
  shift->kind = "floor", shift->name = "Floor 2", shift->floor = 2, shift->significant = true;
  shift->finding = shift->words = "Floor 2 hangs 12.0 mm low";
  for (int i = 0; i < 5; ++i) {
    auto anchor = std::make_unique<AnchorDeviationT>();
    anchor->id = "A" + std::to_string(i), anchor->verdict = verdict, anchor->deviation.setZero();
    deviation.anchors.push_back(std::move(anchor));
    shift->members.push_back(i);
  }
  deviation.group_shifts.push_back(std::move(shift));
  return deviation;
}

AsBuiltChangesT compared(const DeviationT& before, const DeviationT& after) {
  EpochRecord record;
  record.findings = findings_kept(before, nullptr, nullptr);
  AsBuiltChangesT changes;
  changes.together.setZero();
  compare_findings(record, after, changes);
  return changes;
}

/// One of sixteen panels is measured: the same request closed under one topic and opened under another.
TEST(Findings, ARequestIsKnownByWhatItIsAboutAndNotByWhomItNames) {
  const AsBuiltChangesT changes =
      compared(with_request("P01, P02, P03, P04 and 12 more"), with_request("P02, P03, P04, P05 and 11 more"));
  ASSERT_EQ(changes.findings.size(), 1u);
  EXPECT_EQ(changes.findings[0]->change, still_open);
  EXPECT_EQ(changes.findings[0]->title, "Not judged: panels P02, P03, P04, P05 and 11 more");
}

/// The limit is wider now: the shift is told on the page as before, and its topic said "not found any more". It may
/// also be another one than was found then, which was mended: it is told with its figures.
TEST(Findings, AShiftThatIsThereAndPutsNothingOutIsSettledAndNotGone) {
  const AsBuiltChangesT changes = compared(with_shift(ToleranceVerdict::fail), with_shift(ToleranceVerdict::pass));
  ASSERT_EQ(changes.findings.size(), 1u);
  EXPECT_EQ(changes.findings[0]->change, settled);
  const std::string title = ifc::shift_title(with_shift(ToleranceVerdict::pass), changes.findings[0]->topic);
  EXPECT_NE(title, "");
  EXPECT_EQ(changes.findings[0]->note, "now: " + title + "; none of its anchors is out by it");
}

}  // namespace test_findings
}  // namespace plumbline::judgement

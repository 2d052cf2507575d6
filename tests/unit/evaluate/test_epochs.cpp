// Two campaigns of one building: what was mended, opened again, moved, and what nobody measured again.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "build/evaluate/epoch_json.hpp"
#include "building/judgement/epochs.hpp"
#include "building/judgement/kept_open.hpp"
#include "campaigns.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_epochs {

using namespace test;

/// As the next campaign reads it.
EpochRecord read_back(const EpochRecord& record) {
  const auto path = std::filesystem::temp_directory_path() / ("epochs_test_" + std::to_string(getpid()) + ".json");
  std::ofstream(path) << epoch_json(record, {});
  const EpochRecord read = read_epoch(path.string());
  std::filesystem::remove(path);
  return read;
}

TEST(AsBuiltEpochs, EveryWayFromOneVerdictToAnotherHasItsName) {
  struct Case {
    ToleranceVerdict before, after;
    ChangeKind change;
  };
  const std::vector<Case> cases = {
      {kFail, kPass, ChangeKind::mended},     {kOpen, kPass, ChangeKind::settled},
      {kNone, kPass, ChangeKind::settled},    {kPass, kPass, ChangeKind::in_order},
      {kPass, kFail, ChangeKind::opened},     {kPass, kOpen, ChangeKind::opened},
      {kNone, kFail, ChangeKind::opened},     {kFail, kFail, ChangeKind::still_open},
      {kFail, kOpen, ChangeKind::still_open}, {kFail, kNone, ChangeKind::unseen},
      {kPass, kNone, ChangeKind::unseen},     {kNone, kNone, ChangeKind::unseen},
  };
  std::vector<std::unique_ptr<AnchorDeviationT>> may, june;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    may.push_back(anchor("A" + std::to_string(i), cases[i].before, kThere));
    june.push_back(anchor("A" + std::to_string(i), cases[i].after, kThere));
  }
  may.push_back(anchor("gone", kFail, kThere)), june.push_back(anchor("added", kPass, kThere));
  const DeviationT first = campaign(std::move(may)), second = campaign(std::move(june));
  const AsBuiltChangesT changes = compare_epochs(record_of(first, "2026-05"), second, "2026-06");
  for (std::size_t i = 0; i < cases.size(); ++i)
    EXPECT_EQ(of(changes, "A" + std::to_string(i)).change, cases[i].change) << i;
  EXPECT_EQ(of(changes, "gone").change, ChangeKind::left_out);
  EXPECT_EQ(of(changes, "added").change, ChangeKind::added);
  EXPECT_EQ(words_of_changes(changes),
            "1 mended, 2 settled, 3 opened, 2 still open, 3 not measured again, 1 new, 1 left out");
}

/// Three campaigns: mended in June, failing in July. What June did not look at is still known in July.
/// Fitted to its own anchors a campaign cannot see that all of them sank.
TEST(AsBuiltEpochs, ACampaignThatIsFittedToItselfSaysWhatItDoesNotSee) {
  const auto one = [](const char* datum) {
    std::vector<std::unique_ptr<AnchorDeviationT>> anchors;
    anchors.push_back(anchor("A", kPass, kThere));
    DeviationT made = campaign(std::move(anchors));
    made.datum = datum;
    return made;
  };
  const auto told = [&](const char* datum) {
    std::string all;
    for (const std::string& warning : compare_epochs(record_of(one(""), "May"), one(datum), "June").warnings)
      all += warning + "\n";
    return all.find("what all of them moved by together is not seen") != std::string::npos;
  };
  EXPECT_TRUE(told("Judged about the best fit of the anchors, as agreed (datum_sigma)."));
  EXPECT_FALSE(told(""));
}

TEST(AsBuiltEpochs, WhatWasMendedAndFailsIsOpenedAgainAndNothingOpenIsForgotten) {
  const auto one = [](ToleranceVerdict a, ToleranceVerdict b) {
    std::vector<std::unique_ptr<AnchorDeviationT>> anchors;
    anchors.push_back(anchor("A", a, kThere)), anchors.push_back(anchor("B", b, kThere));
    return campaign(std::move(anchors));
  };
  DeviationT may = one(kFail, kFail);
  may.panels.push_back(panel("P", kFail));
  const EpochRecord first = record_of(may, "May");
  const DeviationT june = one(kPass, kNone);
  EXPECT_EQ(of(compare_epochs(first, june, "June"), "A").change, ChangeKind::mended);
  EXPECT_EQ(of(compare_epochs(first, june, "June"), "P").change, ChangeKind::unseen) << "no anchor of it was measured";
  const EpochRecord second = record_of(june, "June", &first);
  const DeviationT july = one(kFail, kPass);
  const AsBuiltChangesT changes = compare_epochs(second, july, "July");
  EXPECT_EQ(of(changes, "A").change, ChangeKind::opened_again);
  EXPECT_EQ(of(changes, "B").change, ChangeKind::mended) << "its failure is that of May";
  EXPECT_EQ(of(changes, "P").before, kFail) << "a panel that June could not judge is not forgotten";
  EXPECT_EQ(of(compare_epochs(record_of(one(kPass, kPass), "x"), july, "y"), "A").change, ChangeKind::opened)
      << "it had never been open";
}

TEST(AsBuiltEpochs, MovementsAreTestedAllTogether) {
  // Of 1000 sound anchors none is told in nineteen of twenty campaigns; one that moved by 4 mm is.
  test::Normal normal(7);
  int wrong = 0;
  for (int trial = 0; trial < 40; ++trial) {
    std::vector<std::unique_ptr<AnchorDeviationT>> may, june;
    for (int i = 0; i < 250; ++i) {
      const auto noise = [&] { return Eigen::Vector3d(0.3 * mm * Eigen::Vector3d(normal(), normal(), normal())); };
      may.push_back(anchor("A" + std::to_string(i), kPass, noise()));
      const Eigen::Vector3d moved = i == 17 ? Eigen::Vector3d(0, 4 * mm, 0) : Eigen::Vector3d::Zero();
      june.push_back(anchor("A" + std::to_string(i), kPass, moved + noise()));
    }
    const DeviationT second = campaign(std::move(june));
    const AsBuiltChangesT changes = compare_epochs(record_of(campaign(std::move(may)), ""), second, "");
    EXPECT_TRUE(of(changes, "A17").moved);
    EXPECT_NEAR(of(changes, "A17").movement.y(), 4 * mm, 2 * mm);
    EXPECT_NEAR(of(changes, "A17").u, std::sqrt(2) * 0.3 * mm, 1e-9);
    int told = -1;
    for (const auto& change : changes.changes) told += change->moved;
    wrong += told > 0;
  }
  EXPECT_LE(wrong, 6) << "5 % of 40 campaigns, and some";
}

TEST(AsBuiltEpochs, WhatAllHaveMovedByIsTheFrame) {
  std::vector<std::unique_ptr<AnchorDeviationT>> may, june, half;
  for (int i = 0; i < 20; ++i) {
    const std::string id = "A" + std::to_string(i);
    may.push_back(anchor(id, kPass, kThere));
    const Eigen::Vector3d own = i == 3 ? Eigen::Vector3d(0, 0, 6 * mm) : Eigen::Vector3d::Zero();
    june.push_back(anchor(id, kPass, kThere + Eigen::Vector3d(8 * mm, 0, 0) + own));
    half.push_back(anchor(id, kPass, kThere + Eigen::Vector3d(i < 10 ? 8 * mm : 0, 0, 0)));
  }
  const EpochRecord before = record_of(campaign(std::move(may)), "");
  const DeviationT all = campaign(std::move(june)), some = campaign(std::move(half));
  const AsBuiltChangesT together = compare_epochs(before, all, "");
  EXPECT_NEAR(together.together.x(), 8 * mm, 1e-9);
  ASSERT_EQ(together.warnings.size(), 1u);
  EXPECT_NE(together.warnings[0].find("19 of 20 anchors seem to have moved by the same, +8.0, +0.0, +0.0 mm"),
            std::string::npos)
      << together.warnings[0];
  EXPECT_TRUE(of(together, "A3").moved);
  EXPECT_FALSE(of(together, "A4").moved);
  const AsBuiltChangesT apart = compare_epochs(before, some, "");
  EXPECT_TRUE(of(apart, "A4").moved && !of(apart, "A14").moved);
  EXPECT_EQ(apart.together, Eigen::Vector3d::Zero());
}

/// Once everything was 10 mm low, rather by its control, and an anchor that had been 8 mm high was "mended".
TEST(AsBuiltEpochs, NothingIsMendedWhileAllSeemToHaveMovedByTheSame) {
  std::vector<std::unique_ptr<AnchorDeviationT>> may, june, july;
  for (int i = 0; i < 20; ++i) {
    const std::string id = "A" + std::to_string(i);
    const double own = i == 3 ? 8 * mm : 0;
    may.push_back(anchor(id, i == 3 ? kFail : i == 5 ? kOpen : kPass, {0, 0, own}));
    june.push_back(anchor(id, i == 3 || i == 5 ? kPass : kFail, {0, 0, own - 10 * mm}));
    july.push_back(anchor(id, kPass, {0, 0, -10 * mm}));
  }
  const EpochRecord before = record_of(campaign(std::move(may)), "May");
  const DeviationT low = campaign(std::move(june));
  const AsBuiltChangesT changes = compare_epochs(before, low, "June");
  EXPECT_EQ(of(changes, "A3").change, ChangeKind::still_open);
  EXPECT_EQ(of(changes, "A5").change, ChangeKind::still_open);
  EXPECT_NE(of(changes, "A3").note.find("nothing counts as mended"), std::string::npos);
  EXPECT_EQ(words_of_changes(changes).find("mended"), std::string::npos);
  const EpochRecord kept = record_of(low, "June", &before, nullptr, &changes);
  EXPECT_EQ(kept.items[3].verdict, kFail) << "what June could not close July has to";
  EXPECT_EQ(of(compare_epochs(kept, campaign(std::move(july)), "July"), "A3").change, ChangeKind::mended);
}

/// Sixteen anchors of two floors in four columns; F2-C3-R2 was 8 mm high in May. `moved`: what June has them elsewhere
/// by.
struct Facade {
  std::vector<std::unique_ptr<AnchorDeviationT>> may, june;
  std::unique_ptr<PanelDeviationT> panel_may = panel("P", kFail), panel_june = panel("P", kPass);

  explicit Facade(const std::function<Eigen::Vector3d(int floor, const Eigen::Vector3d& place)>& moved) {
    for (int floor = 1; floor <= 2; ++floor)
      for (int column = 1; column <= 4; ++column)
        for (int row = 1; row <= 2; ++row) {
          const std::string id =
              "F" + std::to_string(floor) + "-C" + std::to_string(column) + "-R" + std::to_string(row);
          const Eigen::Vector3d place(2.0 * column - 1, 0, 4.0 * floor + 2 * row - 5);
          const bool high = id == "F2-C3-R2";
          const Eigen::Vector3d was(0, 0, high ? 8 * mm : 0);
          may.push_back(anchor(id, high ? kFail : kPass, was));
          june.push_back(anchor(id, kPass, was + moved(floor, place)));
          for (auto* list : {&may, &june}) {
            AnchorDeviationT& one = *list->back();
            one.as_built += place - one.design, one.design = place, one.floor = floor, one.column = column;
          }
        }
    for (const char* id : {"F2-C2-R2", "F2-C3-R2"}) {
      auto fixing = std::make_unique<PanelFixingT>();
      fixing->anchor = id;
      panel_june->fixings.push_back(std::move(fixing));
    }
  }
  AsBuiltChangesT compared(EpochRecord* kept = nullptr) {
    DeviationT first = campaign(std::move(may)), second = campaign(std::move(june));
    first.panels.push_back(std::move(panel_may)), second.panels.push_back(std::move(panel_june));
    const EpochRecord before = record_of(first, "May");
    AsBuiltChangesT changes = compare_epochs(before, second, "June");
    if (kept) *kept = record_of(second, "June", &before, nullptr, &changes);
    return changes;
  }
};

/// Once the control of June leaned, or that of one floor had sunk: an anchor that nobody had touched was "mended", and
/// its topic closed.
TEST(AsBuiltEpochs, NothingIsMendedByAFrameThatTurnedOrByTheControlOfOneFloor) {
  for (const bool turned : {true, false}) {
    Facade facade([&](int floor, const Eigen::Vector3d& place) {
      return Eigen::Vector3d(0, 0, turned ? -1.6e-3 * place.x() : floor == 2 ? -9 * mm : 0.0);
    });
    EpochRecord kept;
    const AsBuiltChangesT changes = facade.compared(&kept);
    EXPECT_TRUE(changes.together.isZero()) << turned;
    EXPECT_EQ(of(changes, "F2-C3-R2").change, ChangeKind::still_open) << turned;
    EXPECT_NE(of(changes, "F2-C3-R2").note.find("that were in order before"), std::string::npos) << turned;
    EXPECT_EQ(of(changes, "P").change, ChangeKind::still_open) << turned << ": all its anchors moved so";
    EXPECT_NE(testing::PrintToString(changes.warnings).find("have moved alike, on average by"), std::string::npos);
    for (const EpochItem& item : kept.items)
      if (item.id == "F2-C3-R2" || item.id == "P") {
        EXPECT_EQ(item.verdict, kFail) << item.id << turned;
      }
  }
}

/// Who is out of tolerance is reset, alone or with all the others that are so; the others stay where they are.
TEST(AsBuiltEpochs, WhatWasResetIsMendedThoughANeighbourMovedToo) {
  Facade alone([](int floor, const Eigen::Vector3d& place) {
    return Eigen::Vector3d(0, 0, floor == 2 && place.x() == 5 && place.z() == 7 ? -8 * mm : 0);
  });
  const AsBuiltChangesT changes = alone.compared();
  EXPECT_EQ(of(changes, "F2-C3-R2").change, ChangeKind::mended);
  EXPECT_EQ(of(changes, "P").change, ChangeKind::mended);
  std::vector<std::unique_ptr<AnchorDeviationT>> may, june;  // a whole floor that hung low was lifted
  for (int i = 0; i < 16; ++i) {
    const std::string id = "A" + std::to_string(i);
    const Eigen::Vector3d low(0, 0, i < 8 ? -9 * mm : 0);
    may.push_back(anchor(id, i < 8 ? kFail : kPass, low)), june.push_back(anchor(id, kPass, {0, 0, 0}));
    may.back()->floor = june.back()->floor = i < 8 ? 1 : 2;
  }
  const DeviationT after = campaign(std::move(june));
  EXPECT_EQ(of(compare_epochs(record_of(campaign(std::move(may)), "May"), after, "June"), "A3").change,
            ChangeKind::mended);
}

/// Exported again, with other GlobalIds: once that was "another building", or an anchor with two open topics.
TEST(AsBuiltEpochs, WhatHasAnotherGlobalIdIsFoundByNameAndPlace) {
  const auto made = [](const std::string& export_, ToleranceVerdict a, double moved = 0) {
    std::vector<std::unique_ptr<AnchorDeviationT>> anchors;
    for (const char* id : {"A", "B"}) {
      anchors.push_back(anchor(id, *id == 'A' ? a : kPass, kThere));
      anchors.back()->guid += export_, anchors.back()->design.x() += moved;
    }
    DeviationT one = campaign(std::move(anchors));
    one.panels.push_back(panel("P", kPass));
    one.panels.back()->guid += export_;
    return one;
  };
  EpochRecord before = record_of(made("", kFail), "May");
  before.items[2].open_joints = {{"guid-P", kFail}};
  const DeviationT again = made("-new", kFail);
  find_again(again, before);
  EXPECT_EQ(before.items[0].guid, "guid-A-new");
  EXPECT_EQ(before.items[0].guid_before, "guid-A");
  EXPECT_TRUE(before.items[2].open_joints.contains("guid-P-new"));
  const AsBuiltChangesT changes = compare_epochs(before, again, "June");
  ASSERT_EQ(changes.warnings.size(), 1u);
  EXPECT_EQ(changes.warnings[0],
            "found again by name and place, because the design has other GlobalIds for them than in the campaign "
            "before: anchor A, anchor B, panel P");
  EXPECT_EQ(of(changes, "A").change, ChangeKind::still_open);
  const AsBuiltChangeT& former = *changes.changes.back();
  EXPECT_EQ(former.guid, "guid-A") << "its topic is to be closed";
  EXPECT_EQ(former.change, ChangeKind::left_out);
  EXPECT_EQ(words_of_changes(changes).find("left out"), std::string::npos);
  for (const EpochItem& item : record_of(again, "June", &before).items) EXPECT_NE(item.guid, "guid-A");

  EpochRecord elsewhere = record_of(made("", kFail), "May");
  find_again(made("-new", kFail, 1.0), elsewhere);
  EXPECT_EQ(elsewhere.items[0].guid, "guid-A") << "the same name a metre away is another anchor";
  EpochRecord same = record_of(made("", kFail), "May");
  const DesignElements design{{"guid-A", "guid-B", "guid-P"}, {}};
  find_again(again, same, &design);
  EXPECT_EQ(same.items[0].guid, "guid-A") << "the design still has the element";
}

TEST(AsBuiltEpochs, OtherTolerancesDesignsAndBuildingsAreTold) {
  std::vector<std::unique_ptr<AnchorDeviationT>> may, june, other;
  may.push_back(anchor("A", kPass, kThere)), june.push_back(anchor("A", kFail, kThere));
  other.push_back(anchor("Z", kPass, kThere));
  const EpochRecord before = record_of(campaign(std::move(may)), "May");
  DeviationT after = campaign(std::move(june));
  after.tau = 3 * mm, after.anchors[0]->design.x() += 0.02,
  after.doubts.push_back(std::make_unique<MeasurementDoubtT>(test::doubt("the block contradicts itself")));
  const AsBuiltChangesT changes = compare_epochs(before, after, "");
  ASSERT_EQ(changes.warnings.size(), 3u);
  EXPECT_NE(changes.warnings[1].find("judged by 5 mm and a risk of 0.05, this one by 3 mm"), std::string::npos);
  EXPECT_NE(changes.warnings[2].find("1 anchors have another place in the design"), std::string::npos);
  const DeviationT elsewhere = campaign(std::move(other));
  EXPECT_THROW(compare_epochs(before, elsewhere, ""), std::runtime_error);
}

/// A rule that was loosened closes nothing without a word.
TEST(AsBuiltEpochs, OtherLimitsOfARuleAreTold) {
  const auto with_limit = [](ToleranceVerdict verdict, double limit) {
    std::vector<std::unique_ptr<AnchorDeviationT>> anchors;
    anchors.push_back(anchor("A", verdict, kThere));
    anchors[0]->axes.push_back(std::make_unique<JudgedAxisT>());
    anchors[0]->axes[0]->axis = "vertical", anchors[0]->axes[0]->above = anchors[0]->axes[0]->below = limit;
    return campaign(std::move(anchors));
  };
  const EpochRecord before = record_of(with_limit(kFail, 3 * mm), "May");
  const DeviationT same = with_limit(kPass, 3 * mm), loosened = with_limit(kPass, 8 * mm);
  EXPECT_TRUE(compare_epochs(before, same, "June").warnings.empty());
  const AsBuiltChangesT changes = compare_epochs(before, loosened, "June");
  ASSERT_EQ(changes.warnings.size(), 1u);
  EXPECT_NE(changes.warnings[0].find("1 anchor is held against other tolerances"), std::string::npos);
  EXPECT_EQ(of(compare_epochs(before, same, "June"), "A").change, ChangeKind::mended);
  EXPECT_EQ(of(changes, "A").change, ChangeKind::settled) << "nobody mended it";
  EXPECT_EQ(of(changes, "A").note, "a limit is wider than in the campaign before")
      << "which one it passes by is not known";
}

/// A campaign of six anchors whose last five share a shift, or not; the last `unmeasured` of them are not measured.
DeviationT with_shift(bool shifted, int unmeasured = 0) {
  std::vector<std::unique_ptr<AnchorDeviationT>> anchors;
  for (int i = 0; i < 6; ++i) {
    const ToleranceVerdict verdict = i >= 6 - unmeasured ? kNone : shifted && i > 0 ? kFail : kPass;
    anchors.push_back(anchor("A" + std::to_string(i), verdict, kThere));
    anchors.back()->deviation = anchors.back()->as_built - anchors.back()->design;
  }
  DeviationT deviation = campaign(std::move(anchors));
  auto shift = std::make_unique<GroupShiftT>();
  shift->kind = "batch", shift->name = "Print batch 7", shift->significant = shifted;
  shift->shift.setZero(), shift->u.setZero(), shift->spread.setZero();
  if (shifted) shift->members = {1, 2, 3, 4, 5}, shift->finding = "Print batch 7 stands 8.1 mm ± 0.4 mm high";
  if (shifted) shift->words = shift->finding + " (5 of its 6 anchors share it).";
  deviation.group_shifts.push_back(std::move(shift));
  return deviation;
}

ChangeKind finding_of(const AsBuiltChangesT& changes, const std::string& topic) {
  for (const auto& change : changes.findings)
    if (change->topic == topic) return change->change;
  throw std::runtime_error("no finding " + topic);
}

/// Shifts, doubts and what was less certain had topics that nothing ever closed.
TEST(AsBuiltEpochs, FindingsOfTheCampaignBeforeAreSettledWhenTheyAreGone) {
  DeviationT may = with_shift(true);
  auto misfit = test::doubt("principal points, 1.7 px", MeasurementPart::image_block);
  misfit.about = "principal_points/one principal point";
  may.misfits.push_back(std::make_unique<MeasurementDoubtT>(misfit));
  may.doubts.push_back(std::make_unique<MeasurementDoubtT>(test::doubt("station 3 contradicts itself")));
  const std::string shift = "shift of Print batch 7",
                    block = "misfit: image_block/principal_points/one principal point",
                    station = "doubt: survey/station 3 contradicts itself";
  const EpochRecord first = read_back(record_of(may, "May"));
  const auto compared = [](const EpochRecord& before, const DeviationT& after) {
    AsBuiltChangesT changes = compare_epochs(before, after, "June");
    compare_findings(before, after, changes);
    return changes;
  };
  const AsBuiltChangesT gone = compared(first, with_shift(false));
  for (const std::string& topic : {shift, block, station}) EXPECT_EQ(finding_of(gone, topic), ChangeKind::settled);
  DeviationT still = with_shift(true);
  misfit.reason = "principal points, 1.8 px";
  still.misfits.push_back(std::make_unique<MeasurementDoubtT>(misfit));
  EXPECT_EQ(finding_of(compared(first, still), shift), ChangeKind::still_open);
  EXPECT_EQ(finding_of(compared(first, still), block), ChangeKind::still_open) << "its figures are others";
  const DeviationT in_part = with_shift(false, 3);
  const AsBuiltChangesT unseen = compared(first, in_part);
  EXPECT_EQ(finding_of(unseen, shift), ChangeKind::unseen) << "two of its five anchors were measured";
  EXPECT_EQ(finding_of(unseen, block), ChangeKind::settled);
  const EpochRecord second = read_back(record_of(in_part, "June", &first, nullptr, &unseen));
  EXPECT_EQ(finding_of(compared(second, with_shift(false)), shift), ChangeKind::settled) << "open since May";
  EXPECT_EQ(finding_of(compared(second, still), block), ChangeKind::opened_again);
  DeviationT doubted = with_shift(false);
  doubted.doubts.push_back(std::make_unique<MeasurementDoubtT>(test::doubt("station 3 contradicts itself")));
  EXPECT_EQ(finding_of(compared(first, doubted), shift), ChangeKind::unseen) << "what proves nothing closes nothing";
}

TEST(AsBuiltEpochs, AMeasurementInDoubtLeavesNoPlaceToCompareWith) {
  std::vector<std::unique_ptr<AnchorDeviationT>> may, june;
  may.push_back(anchor("A", kFail, kThere)), june.push_back(anchor("A", kOpen, kThere + Eigen::Vector3d(0.1, 0, 0)));
  DeviationT doubtful = campaign(std::move(june));
  doubtful.doubts.push_back(std::make_unique<MeasurementDoubtT>(test::doubt("the block contradicts itself")));
  const EpochRecord first = record_of(campaign(std::move(may)), "May"), second = record_of(doubtful, "June", &first);
  EXPECT_EQ(second.items[0].position, first.items[0].position);
  EXPECT_FALSE(record_of(doubtful, "June").items[0].position.allFinite());
}

}  // namespace test_epochs
}  // namespace plumbline::judgement

// Two campaigns of one building: what was mended, opened again, moved, and what nobody measured again.
#include "building/judgement/epochs.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>

#include "build/evaluate/epoch_json.hpp"
#include "building/judgement/kept_open.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace epochs_test {

using test::mm;

std::unique_ptr<AnchorDeviationT> anchor(const std::string& id, ToleranceVerdict verdict, const Eigen::Vector3d& at,
                                         double sigma = 0.3 * mm) {
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

std::unique_ptr<PanelDeviationT> panel(const std::string& name, ToleranceVerdict verdict) {
  auto out = std::make_unique<PanelDeviationT>();
  out->guid = "guid-" + name, out->name = name, out->verdict = verdict;
  return out;
}

DeviationT campaign(std::vector<std::unique_ptr<AnchorDeviationT>> anchors) {
  DeviationT deviation;
  deviation.tau = 5 * mm, deviation.risk = 0.05, deviation.design_file = "tower.ifc";
  deviation.anchors = std::move(anchors);
  return deviation;
}

const AsBuiltChangeT& of(const AsBuiltChangesT& changes, const std::string& id) {
  for (const auto& change : changes.changes)
    if (change->id == id) return *change;
  throw std::runtime_error("no change of " + id);
}

constexpr auto kPass = ToleranceVerdict::pass, kFail = ToleranceVerdict::fail, kOpen = ToleranceVerdict::undecided,
               kNone = ToleranceVerdict::not_measured;
const Eigen::Vector3d kThere(0.001, 0, 0);

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

std::unique_ptr<PanelJointT> joint(const std::string& to, ToleranceVerdict verdict) {
  auto out = std::make_unique<PanelJointT>();
  out->panel = "guid-" + to, out->name = to, out->side = "right";
  out->change = std::make_unique<JudgedLengthT>();
  out->change->verdict = verdict;
  return out;
}

/// Anchors of a panel alone say nothing of its joint: that is open until both sides were measured again.
TEST(AsBuiltEpochs, AJointOfWhichOneSideWasMeasuredAgainIsNotMended) {
  const auto facade = [](std::vector<std::pair<std::string, ToleranceVerdict>> panels, ToleranceVerdict between) {
    std::vector<std::unique_ptr<AnchorDeviationT>> anchors;
    anchors.push_back(anchor("A", kPass, kThere));
    DeviationT deviation = campaign(std::move(anchors));
    for (const auto& [name, verdict] : panels) {
      deviation.panels.push_back(panel(name, verdict));
      if (panels.size() == 2) deviation.panels.back()->joints.push_back(joint(name == "P" ? "Q" : "P", between));
    }
    return deviation;
  };
  const DeviationT may = facade({{"P", kFail}, {"Q", kFail}}, kFail), one_side = facade({{"P", kPass}}, kNone),
                   both = facade({{"P", kPass}, {"Q", kPass}}, kPass);
  const EpochRecord first = record_of(may, "May");
  const AsBuiltChangesT half = compare_epochs(first, one_side, "June");
  EXPECT_EQ(of(half, "P").change, ChangeKind::unseen);
  EXPECT_NE(of(half, "P").note.find("its joint to Q was open and not measured again"), std::string::npos)
      << of(half, "P").note;
  // Nor in the next campaign, if that looks at one side, too.
  const EpochRecord second = record_of(one_side, "June", &first);
  EXPECT_EQ(second.items[1].verdict, kFail);
  EXPECT_EQ(of(compare_epochs(second, one_side, "July"), "P").change, ChangeKind::unseen);
  EXPECT_EQ(of(compare_epochs(second, both, "July"), "P").change, ChangeKind::mended);
  EXPECT_EQ(record_of(both, "July", &second).items[1].verdict, kPass);
  // Nor for ever: a neighbour that the design has no more leaves no joint.
  DesignElements whole{{"guid-A", "guid-P", "guid-Q"}, {"A", "P", "Q"}}, without{{"guid-A", "guid-P"}, {"A", "P"}};
  EXPECT_EQ(of(compare_epochs(second, one_side, "July", &whole), "P").change, ChangeKind::unseen);
  const AsBuiltChangesT gone = compare_epochs(second, one_side, "July", &without);
  EXPECT_EQ(of(gone, "P").change, ChangeKind::mended);
  EXPECT_NE(of(gone, "P").note.find("its joint to Q was open and is none any more"), std::string::npos)
      << of(gone, "P").note;
  EXPECT_EQ(of(gone, "Q").change, ChangeKind::left_out);
  const EpochRecord third = record_of(one_side, "July", &second, &without);
  ASSERT_EQ(third.items.size(), 3u) << "A and P, and Q, which was open and which nobody has closed";
  EXPECT_EQ(third.items[2].id, "Q");
  EXPECT_TRUE(third.items[2].open());
  EXPECT_EQ(third.items[1].verdict, kPass);
  EXPECT_TRUE(third.items[1].open_joints.empty());
}

/// Once every campaign of other floors ended as not judged, as long as one panel of floor 1 was open.
TEST(AsBuiltEpochs, WhatIsStillOpenForbidsReadyAndNothingElse) {
  AsBuiltChangesT changes;
  changes.before = "May";
  const auto add = [&](const char* kind, const char* id, ToleranceVerdict before, ToleranceVerdict after) {
    auto change = std::make_unique<AsBuiltChangeT>();
    change->kind = kind, change->id = id, change->before = before, change->after = after;
    change->change = ChangeKind::unseen;
    changes.changes.push_back(std::move(change));
  };
  add("anchor", "A", kFail, kNone), add("panel", "P", kFail, kNone), add("panel", "Q", kPass, kNone);
  DeviationT whole;
  whole.verdict = kPass;
  EXPECT_EQ(leave_open(changes, whole),
            std::vector<std::string>{"Not judged: panel P: open since May and not measured again."});
  EXPECT_EQ(whole.verdict, kOpen);
  EXPECT_EQ(whole.not_judged, 1);
  ASSERT_EQ(whole.requests.size(), 1u);
  add("panel", "R", kFail, kPass);  // its anchors were measured; of its joint one side was
  for (const ToleranceVerdict verdict : {kOpen, kFail, kNone}) {
    DeviationT part;
    part.verdict = verdict;
    EXPECT_EQ(leave_open(changes, part),
              (std::vector<std::string>{
                  "Still open: panel P: open since May and not measured again.",
                  "Still open: panel R: open since May at a joint whose other panel was not measured again."}));
    EXPECT_EQ(part.verdict, verdict);
    EXPECT_EQ(part.not_judged, 0);
    EXPECT_TRUE(part.requests.empty());
  }
}

/// A model of one storey: what is open elsewhere is named, each time, and known again when the whole is judged.
TEST(AsBuiltEpochs, WhatIsOpenAndNotInAPartOfTheDesignIsNamedAndNotForgotten) {
  const auto part = [](const std::vector<std::string>& panels, ToleranceVerdict verdict) {
    std::vector<std::unique_ptr<AnchorDeviationT>> anchors;
    anchors.push_back(anchor("A", kPass, kThere));
    DeviationT deviation = campaign(std::move(anchors));
    for (const std::string& name : panels) deviation.panels.push_back(panel(name, verdict));
    return deviation;
  };
  const DesignElements whole{{"guid-A", "guid-P", "guid-Q"}, {"A", "P", "Q"}}, storey{{"guid-A", "guid-P"}, {"A", "P"}};
  const EpochRecord may = record_of(part({"P", "Q"}, kFail), "May");
  const DeviationT of_storey = part({"P"}, kPass);
  EpochRecord before = may;
  for (const char* month : {"June", "July"}) {
    const AsBuiltChangesT changes = compare_epochs(before, of_storey, month, &storey);
    EXPECT_EQ(of(changes, "Q").change, ChangeKind::left_out);
    ASSERT_EQ(changes.warnings.size(), 1u) << month;
    EXPECT_NE(changes.warnings[0].find("of this one: panel Q; they stay open"), std::string::npos)
        << changes.warnings[0];
    before = record_of(of_storey, month, &before, &storey);
  }
  EXPECT_EQ(of(compare_epochs(before, part({"P", "Q"}, kPass), "August", &whole), "Q").change, ChangeKind::mended);
  // What was in order and is gone is neither told nor kept.
  const EpochRecord sound = record_of(part({"P", "Q"}, kPass), "May");
  EXPECT_TRUE(compare_epochs(sound, of_storey, "June", &storey).warnings.empty());
  EXPECT_EQ(record_of(of_storey, "June", &sound, &storey).items.size(), 2u);
}

TEST(AsBuiltEpochs, OtherTolerancesOfPanelsAreTold) {
  const auto held_to = [](double limit) {
    std::vector<std::unique_ptr<AnchorDeviationT>> anchors;
    anchors.push_back(anchor("A", kPass, kThere));
    DeviationT deviation = campaign(std::move(anchors));
    deviation.panels.push_back(panel("P", kPass));
    deviation.panels[0]->limits.push_back(std::make_unique<PanelLimitT>());
    deviation.panels[0]->limits[0]->axis = "joint";
    deviation.panels[0]->limits[0]->above = deviation.panels[0]->limits[0]->below = limit;
    return deviation;
  };
  const DeviationT may = held_to(4 * mm), june = held_to(9 * mm);
  EXPECT_TRUE(compare_epochs(record_of(may, "May"), may, "June").warnings.empty());
  const AsBuiltChangesT changes = compare_epochs(record_of(may, "May"), june, "June");
  ASSERT_EQ(changes.warnings.size(), 1u);
  EXPECT_NE(changes.warnings[0].find("1 panel is held against other tolerances"), std::string::npos)
      << changes.warnings[0];
}

/// Surfaces and joints: each quantity by itself, neighbours that share a name apart, and what nobody looked at again.
TEST(AsBuiltEpochs, SurfacesAndJointsAreComparedQuantityByQuantity) {
  struct Seen {
    std::string second;
    int item;
    std::string quantity;
    ToleranceVerdict verdict;
    double value, upper;
  };
  const auto surfaces = [](const std::vector<Seen>& all) {
    std::vector<std::unique_ptr<AnchorDeviationT>> anchors;
    anchors.push_back(anchor("A", kPass, kThere));
    DeviationT deviation = campaign(std::move(anchors));
    deviation.surfaces = std::make_unique<SurfaceJudgementT>();
    for (const Seen& seen : all) {
      auto verdict = std::make_unique<SurfaceVerdictT>();
      verdict->panel = "P", verdict->guid = "guid-P", verdict->second = seen.second, verdict->item = seen.item;
      verdict->quantity = seen.quantity, verdict->verdict = seen.verdict, verdict->value = seen.value;
      verdict->upper = seen.upper, verdict->lower = -INFINITY;
      deviation.surfaces->verdicts.push_back(std::move(verdict));
    }
    return deviation;
  };
  const DeviationT may = surfaces({{"", 0, "flatness", kFail, 6 * mm, 3 * mm},
                                   {"", 0, "twist", kFail, 5 * mm, 3 * mm},
                                   {"Q", 4, "step", kPass, 1 * mm, 2 * mm},
                                   {"Q", 5, "step", kFail, 4 * mm, 2 * mm}});
  const DeviationT june = surfaces({{"", 0, "flatness", kPass, 2 * mm, 3 * mm},
                                    {"", 0, "twist", kNone, NAN, 3 * mm},
                                    {"Q", 4, "step", kFail, 3 * mm, 2 * mm},
                                    {"Q", 5, "step", kPass, 4 * mm, 5 * mm}});
  const EpochRecord first = record_of(may, "May");
  const AsBuiltChangesT changes = compare_epochs(first, june, "June");
  const auto at = [&](const std::string& topic, const std::string& id) -> const AsBuiltChangeT& {
    for (const auto& change : changes.changes)
      if (change->topic == topic && change->id == id) return *change;
    throw std::runtime_error(topic);
  };
  EXPECT_EQ(at("surface", "P, flatness").change, ChangeKind::mended);
  EXPECT_EQ(at("surface", "P, flatness").value_before, 6 * mm);
  EXPECT_EQ(at("surface", "P, flatness").value, 2 * mm);
  EXPECT_EQ(at("surface", "P, twist").change, ChangeKind::unseen);
  EXPECT_EQ(at("joint/Q", "P | Q, step").change, ChangeKind::opened);
  EXPECT_EQ(at("joint/Q/1", "P | Q, step").change, ChangeKind::settled) << "4 mm passes by 5 mm and not by 2 mm";
  ASSERT_EQ(changes.warnings.size(), 1u);
  EXPECT_NE(changes.warnings[0].find("1 limit of joints is held against other"), std::string::npos)
      << changes.warnings[0];
  const EpochRecord second = record_of(june, "June", &first);
  EXPECT_EQ(second.items[2].verdict, kFail) << "the twist that nobody measured again";
  EXPECT_EQ(second.items[2].value, 5 * mm);
  const DeviationT july = surfaces({});
  EXPECT_EQ(of(compare_epochs(second, july, "July"), "P, twist").change, ChangeKind::unseen);
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

TEST(AsBuiltEpochs, TheRecordIsReadBackAsItWasWritten) {
  std::vector<std::unique_ptr<AnchorDeviationT>> anchors;
  anchors.push_back(anchor("A", kFail, {1.0 / 3, -2e-7, 5})), anchors.push_back(anchor("B \xff", kNone, kThere));
  DeviationT may = campaign(std::move(anchors));
  may.panels.push_back(panel("P", kOpen));
  may.panels[0]->joints.push_back(joint("Q", kFail));
  may.anchors[0]->axes.push_back(std::make_unique<JudgedAxisT>());
  may.anchors[0]->axes[0]->axis = "vertical", may.anchors[0]->axes[0]->above = 3 * mm;
  may.anchors[0]->axes[0]->below = 1.0 / 3;
  const EpochRecord written = record_of(may, "2026-05");
  const auto folder = std::filesystem::temp_directory_path() / ("epochs-" + std::to_string(::getpid()));
  std::filesystem::create_directories(folder);
  const auto file = [&](const std::string& text) {
    std::ofstream(folder / "as_built.json") << text;
    return (folder / "as_built.json").string();
  };
  const EpochRecord read = read_epoch(file(epoch_json(written, {})));
  ASSERT_EQ(read.items.size(), 3u);
  EXPECT_EQ(read.epoch + read.design_file, "2026-05tower.ifc");
  EXPECT_EQ(read.items[0].position, written.items[0].position);
  EXPECT_EQ(read.items[0].covariance, written.items[0].covariance);
  EXPECT_EQ(read.items[0].limits, written.items[0].limits);
  EXPECT_TRUE(read.items[0].was_open && read.items[0].verdict == kFail && read.items[2].kind == "panel");
  EXPECT_FALSE(read.items[1].position.allFinite());
  EXPECT_EQ(read.items[2].open_joints, written.items[2].open_joints);
  EXPECT_EQ(read.items[2].open_joints.count("guid-Q"), 1u);
  const auto refused = [&](const std::string& text) {
    try {
      read_epoch(file(text));
    } catch (const std::exception& error) {
      return std::string(error.what());
    }
    return std::string("read");
  };
  EXPECT_NE(refused("IFC").find("is no JSON, expected as_built.json of the campaign before"), std::string::npos);
  EXPECT_NE(refused("{\"format\": \"plumbline-metrics/2\"}").find("is plumbline-metrics/2"), std::string::npos);
  EXPECT_NE(refused("[]").find("JSON of another kind"), std::string::npos);
  EXPECT_NE(refused("{\"format\": \"plumbline-as-built/1\", \"items\": [{\"kind\": \"anchor\", \"id\": \"A\", "
                    "\"verdict\": \"good\"}]}")
                .find("damaged: the verdict of 'A' is 'good'"),
            std::string::npos);
  std::filesystem::remove_all(folder);
}

/// What was in order and still is would bury what changed; what was in order and has moved is told.
TEST(AsBuiltEpochs, TheRecordTellsWhatChangedOrMovedAndNothingElse) {
  AsBuiltChangesT changes;
  changes.compared = true;
  const auto add = [&](const char* id, ChangeKind kind, bool moved) {
    auto change = std::make_unique<AsBuiltChangeT>();
    change->kind = "anchor", change->id = id, change->change = kind, change->moved = moved;
    changes.changes.push_back(std::move(change));
  };
  add("still in order", ChangeKind::in_order, false), add("in order, moved", ChangeKind::in_order, true);
  add("mended", ChangeKind::mended, false), add("opened", ChangeKind::opened, false);
  const std::string text = epoch_json({}, changes);
  for (const char* told : {"in order, moved", "mended", "opened"})
    EXPECT_NE(text.find("\"" + std::string(told) + "\""), std::string::npos) << told;
  EXPECT_EQ(text.find("still in order"), std::string::npos);
}

}  // namespace epochs_test
}  // namespace plumbline::judgement

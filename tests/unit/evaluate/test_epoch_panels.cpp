// Two campaigns of one building: panels, joints and surfaces, and what stays open.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "build/evaluate/epoch_json.hpp"
#include "building/judgement/epochs.hpp"
#include "building/judgement/kept_open.hpp"
#include "campaigns.hpp"
#include "small_building.hpp"

namespace plumbline::judgement {
namespace test_epoch_panels {

using namespace test;

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

}  // namespace test_epoch_panels
}  // namespace plumbline::judgement

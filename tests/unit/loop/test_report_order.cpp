// Several reports of one item: their dates decide, not the order of the files that they were read from.
#include <gtest/gtest.h>

#include <cmath>

#include "two_floors.hpp"

namespace plumbline::loop {
namespace test_report_order {

using namespace test;

struct Said {
  std::string outcome, at, file;
  double out = 0.0011;  ///< where the panel was measured
};

ActualsT reports_of(const std::string& id, const std::vector<Said>& all) {
  ActualsT reports;
  for (const Said& said : all) {
    ActualsT one = done({id}, 0);
    ActualT& actual = *one.items[0];
    actual.outcome = said.outcome, actual.at = said.at, actual.source = said.file + ":3";
    actual.revision = id == "p0" ? 2 : 1;
    if (id == "p0") actual.measured.x() = said.out;
    if (said.outcome != "done") actual.measured.setConstant(nan);
    reports.items.push_back(std::move(one.items[0]));
    if (std::count(reports.sources.begin(), reports.sources.end(), said.file) == 0)
      reports.sources.push_back(said.file);
  }
  return reports;
}

struct After {
  LoopStateT state;
  std::vector<std::string> refused;
};

/// After these reports on bracket b0, or on panel p0, which are released.
After after(const std::string& id, const std::vector<Said>& all) {
  After after;
  MachineOptions options;
  options.at = "2026-05-02T06:00:00Z";
  next_plan(after.state, make_plan("first"), options);
  if (id == "p0") {
    apply_actuals(after.state, done({"b0", "b1"}, 1));
    next_plan(after.state, plan_after_setting(0), options);
  }
  EXPECT_EQ(item(after.state, id).status, ItemStatus::released);
  after.refused = apply_actuals(after.state, reports_of(id, all));
  return after;
}

const char* const kEight = "2026-05-02T08:00:00Z";
const char* const kNine = "2026-05-02T11:00:00+02:00";

/// Who failed at eight and did it at nine has done it, whichever of the files comes first.
TEST(ReportOrder, TheLaterReportCountsWhateverTheOrderOfTheFiles) {
  for (const std::string id : {"b0", "p0"}) {
    const Said failed{"failed", kEight, "z.json"}, done{"done", kNine, "a.json"};
    for (const auto& files : {std::vector{done, failed}, {failed, done}}) {
      After late = after(id, files);
      EXPECT_EQ(item(late.state, id).status, ItemStatus::executed) << item(late.state, id).why;
      EXPECT_EQ(item(late.state, id).at, kNine);
      ASSERT_EQ(late.refused.size(), 1u);
      EXPECT_EQ(late.refused[0], "report on " + id + " by robot-1 (z.json:3): is of " + kEight +
                                     ", and a later one counts: done at " + kNine + " (a.json:3)");
    }
  }
  // Done at eight, and at nine it is said to have failed: somebody looks whether the panel hangs.
  const Said done{"done", kEight, "z.json"}, failed{"failed", kNine, "a.json"};
  for (const auto& files : {std::vector{done, failed}, {failed, done}}) {
    After doubt = after("p0", files);
    EXPECT_EQ(item(doubt.state, "p0").status, ItemStatus::rejected);
    EXPECT_EQ(item(doubt.state, "p0").why, "reported done, then failed, look whether it hangs");
    After bracket = after("b0", files);
    EXPECT_EQ(item(bracket.state, "b0").status, ItemStatus::executed);
    ASSERT_EQ(bracket.refused.size(), 1u);
    EXPECT_NE(bracket.refused[0].find("says failed, a report before it said done"), std::string::npos);
  }
}

/// The newer measurement of where a panel hangs is the one that counts.
TEST(ReportOrder, AnOlderPlaceDoesNotReplaceANewerOne) {
  const Said before{"done", kEight, "z.json", 0.030}, now{"done", kNine, "a.json", 0.002};
  for (const auto& files : {std::vector{before, now}, {now, before}}) {
    const ActualsT reports = reports_of("p0", files);
    LoopStateT state;
    MachineOptions options;
    options.at = "2026-05-02T06:00:00Z";
    next_plan(state, make_plan("first"), options);
    apply_actuals(state, done({"b0", "b1"}, 1));
    next_plan(state, plan_after_setting(0), options);
    for (const auto& report : reports.items) report->sigma.setConstant(0.001);
    apply_actuals(state, reports);
    ASSERT_EQ(item(state, "p0").place.size(), 6u);
    EXPECT_EQ(item(state, "p0").place[0], 0.002);
    EXPECT_EQ(item(state, "p0").at, kNine);
  }
}

TEST(ReportOrder, WhatContradictsAtOneTimeIsRefusedByName) {
  for (const std::string id : {"b0", "p0"}) {
    After same = after(id, {{"done", kEight, "a.json"}, {"failed", "2026-05-02T10:00:00+02:00", "z.json"}});
    EXPECT_EQ(item(same.state, id).status, ItemStatus::released) << item(same.state, id).why;
    ASSERT_EQ(same.refused.size(), 2u);
    EXPECT_EQ(same.refused[0],
              "report on " + id +
                  " by robot-1 (a.json:3): says done, and another one of the same time, 2026-05-02T10:00:00+02:00 "
                  "(z.json:3), says failed: none of them is taken; look at it and report it once");
    EXPECT_NE(same.refused[1].find("(a.json:3), says done"), std::string::npos) << same.refused[1];
  }
  After places = after("p0", {{"done", kEight, "a.json", 0.002}, {"done", kEight, "z.json", 0.030}});
  EXPECT_EQ(item(places.state, "p0").status, ItemStatus::released);
  ASSERT_EQ(places.refused.size(), 2u);
  EXPECT_NE(places.refused[0].find("28.0 mm elsewhere"), std::string::npos) << places.refused[0];
  // Without dates the order of one file is that in which they came; of two files it is none.
  After undated = after("b0", {{"failed", "", "a.json"}, {"done", "", "z.json"}});
  EXPECT_EQ(item(undated.state, "b0").status, ItemStatus::released);
  ASSERT_EQ(undated.refused.size(), 2u);
  EXPECT_NE(undated.refused[0].find("says failed, and another one (z.json:3) says done, and not both have a date"),
            std::string::npos)
      << undated.refused[0];
  After one_file = after("b0", {{"done", "", "a.json"}, {"failed", "", "a.json"}});
  EXPECT_EQ(item(one_file.state, "b0").status, ItemStatus::executed);
}

TEST(ReportOrder, OneThatIsNotTakenTakesNoOtherWithIt) {
  std::vector<Said> said = {{"done", kEight, "a.json"}, {"failed", kNine, "z.json"}};
  ActualsT reports = reports_of("b0", said);
  reports.items[1]->revision = 7;
  LoopStateT state;
  next_plan(state, make_plan("first"));
  EXPECT_EQ(apply_actuals(state, reports).size(), 1u);
  EXPECT_EQ(item(state, "b0").status, ItemStatus::executed);
  // Twice the same is said once more, as before.
  After twice = after("b0", {{"done", kEight, "a.json"}, {"done", kEight, "z.json"}});
  EXPECT_EQ(item(twice.state, "b0").status, ItemStatus::executed);
  ASSERT_EQ(twice.refused.size(), 1u);
  EXPECT_NE(twice.refused[0].find("was reported before; nothing changes"), std::string::npos);
}

}  // namespace test_report_order
}  // namespace plumbline::loop

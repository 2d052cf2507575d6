// The state between two rounds of a site: back bit for bit, and nothing that was changed is taken.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "loop/state/hash.hpp"
#include "loop/state/state_file.hpp"
#include "two_floors.hpp"

namespace plumbline::loop {
namespace test_state_file {

using namespace test;

LoopStateT some_state() {
  LoopStateT state;
  next_plan(state, make_plan("first"));
  apply_actuals(state, done({"b0", "b1"}, 1));
  next_plan(state, plan_after_setting(0.0004));
  recall(state, {"CP3"}, "control point CP3 moved");
  close_round(state);
  state.readings = {"00aa", "11bb"};
  note_refused(state, {"staked.csv:7: the coordinates of 'b2' are no numbers"});
  item(state, "p0").place = {1.5, 2.5, 3.25, 0.001, 0.001, 0.002}, item(state, "p0").told_from = 0.0051;
  item(state, "p1").gone = true;
  state.control.push_back(std::make_unique<ControlMarkT>());
  state.controls.push_back(std::make_unique<ControlSetT>());
  state.controls[0]->marks.push_back(std::make_unique<ControlMarkT>());
  state.controls[0]->marks[0]->id = "CP1", state.controls[0]->marks[0]->place = {1.25, 2.5, 3.0625};
  for (auto& item : state.items)
    if (item->status == ItemStatus::verified) item->control = 1;
  state.control[0]->id = "CP1", state.control[0]->place = {1.25, 2.5, 3.125}, state.control[0]->missing = true;
  return state;
}

std::string error_of(const std::string& text) {
  try {
    read_state_json(text, "state.json");
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "taken";
}

std::string changed(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  return at == std::string::npos ? "nothing to change" : text.replace(at, from.size(), to);
}

TEST(StateFile, ComesBackAndGoesOnAsIfNothingHadBeenBetween) {
  LoopStateT state = some_state(), read = read_state_json(state_json(state), "state.json");
  EXPECT_EQ(state_json(read), state_json(state));
  EXPECT_EQ(read.moved_control, state.moved_control);
  EXPECT_EQ(read.readings, state.readings);
  EXPECT_TRUE(item(read, "p1").gone);
  ASSERT_EQ(read.refused.size(), 1u);
  EXPECT_EQ(read.refused[0]->round, 2);
  EXPECT_EQ(read.refused[0]->report, "staked.csv:7");
  EXPECT_EQ(read.refused[0]->why, "the coordinates of 'b2' are no numbers");
  ASSERT_EQ(read.control.size(), 1u);
  EXPECT_EQ(read.control[0]->place, state.control[0]->place);
  ASSERT_EQ(read.controls.size(), 1u);
  EXPECT_EQ(read.controls[0]->marks[0]->place, state.controls[0]->marks[0]->place);
  EXPECT_EQ(read.items[0]->control, 1);
  EXPECT_EQ(item(read, "p0").place, item(state, "p0").place);
  EXPECT_EQ(item(read, "p0").told_from, 0.0051);
  EXPECT_EQ(read.items[0]->unset, state.items[0]->unset);
  EXPECT_EQ(read.items[0]->unset.size(), 3u);
  for (LoopStateT* s : {&state, &read}) accept_item(*s, "CP3"), next_plan(*s, plan_after_setting(0, "third"));
  EXPECT_EQ(read.journal, state.journal);
  for (std::size_t i = 0; i < state.items.size(); ++i) {
    EXPECT_EQ(read.items[i]->expected.allFinite(), state.items[i]->expected.allFinite());
    if (state.items[i]->expected.allFinite()) {
      EXPECT_EQ(read.items[i]->expected, state.items[i]->expected);
    }
    EXPECT_EQ(read.items[i]->status, state.items[i]->status);
  }
}

TEST(StateFile, WhatWasChangedIsNotTaken) {
  const std::string text = state_json(some_state());
  EXPECT_EQ(error_of(text), "taken");
  for (const auto& [from, to] : {std::pair{"\"PLANNED\"", "\"VERIFIED\""},
                                 {"\"reworks\": 0", "\"reworks\": 1"},
                                 {"gate of its panels is GO", "somebody said so"}})
    EXPECT_NE(error_of(changed(text, from, to)).find("was changed since it was written"), std::string::npos) << from;
  EXPECT_NE(error_of(text.substr(0, text.size() / 2)).find("state.json: is no state of a loop, or a torn one"),
            std::string::npos);
  EXPECT_NE(error_of("{\"items\": []}").find("expected state.json as a round"), std::string::npos);
}

/// As 0.1.0 wrote it: what rests on control rests on the last.
TEST(StateFile, AStateOfTheVersionBeforeIsRead) {
  auto json = nlohmann::ordered_json::parse(state_json(some_state()));
  json["plumbline_loop_state"] = 3;
  json.erase("controls"), json.erase("seal");
  for (auto& item : json["items"]) item.erase("control");
  json["seal"] = sha256_hex(json.dump(1));
  const LoopStateT read = read_state_json(json.dump(1), "state.json");
  ASSERT_EQ(read.control.size(), 1u);
  ASSERT_EQ(read.controls.size(), 1u);
  EXPECT_EQ(read.controls[0]->marks[0]->place, read.control[0]->place);
  for (const auto& item : read.items) EXPECT_EQ(item->control, item->status == ItemStatus::planned ? 0 : 1) << item->id;
}

TEST(StateFile, AnItemStandsWhereItsJournalSays) {
  LoopStateT state = some_state();
  item(state, "p1").status = ItemStatus::verified;  // and sealed
  EXPECT_NE(error_of(state_json(state)).find("panel p1 is VERIFIED, by the journal it is PLANNED"), std::string::npos)
      << error_of(state_json(state));
  state = some_state();
  state.journal.erase(state.journal.begin() + 1);
  EXPECT_NE(error_of(state_json(state)).find("line 2 of its journal"), std::string::npos);
}

}  // namespace test_state_file
}  // namespace plumbline::loop

// Files of reports: what is wrong in them is refused by name.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "loop/job/job.hpp"

namespace plumbline::loop {
namespace test_actuals {

using nlohmann::json;

TEST(Actuals, SingleEntriesThatAreWrongAreRefusedByName) {
  const ActualsT actuals = read_actuals_json(
      R"({"items": [{"item": "F01-C01-R1", "outcome": "done", "revision": 2, "measured": [1, 2, 3]}, {"item": 7}]})",
      "a.json");
  ASSERT_EQ(actuals.items.size(), 1u);
  EXPECT_EQ(actuals.items[0]->measured, Eigen::Vector3d(1, 2, 3));
  ASSERT_EQ(actuals.refused.size(), 1u);
  EXPECT_EQ(actuals.refused[0].substr(0, 17), "a.json: items[1]:");
  EXPECT_EQ(actuals.refused[0], "a.json: items[1]: 'item' is 7, expected text");
  const auto refused = [](const std::string& entry) {
    return read_actuals_json(R"({"items": [)" + entry + "]}", "a.json").refused.at(0);
  };
  EXPECT_EQ(refused(R"({"itme": "A", "outcome": "done"})"), "a.json: items[0]: has 'itme', which is no key; 'item' is");
  EXPECT_EQ(refused(R"({"outcome": "done"})"), "a.json: items[0]: has no 'item'");
  EXPECT_EQ(refused(R"({"item": "A", "outcome": "done", "revision": "1"})"),
            "a.json: items[0]: 'revision' is \"1\", expected a whole number");
  EXPECT_EQ(refused(R"({"item": "A", "outcome": "done", "measured": [1, 2]})"),
            "a.json: items[0]: 'measured' is [1,2], expected [E, N, H] in metres");
  EXPECT_NE(refused(R"({"item": "A", "outcome": "done", "setting": [1, 2, 3]})").find("\"right\""), std::string::npos);
  // No job has it, and none said would answer any job.
  for (const char* none : {"0", "-1"})
    EXPECT_EQ(refused(R"({"item": "A", "outcome": "done", "revision": )" + std::string(none) + "}"),
              "a.json: items[0]: 'revision' is " + std::string(none) + ", expected that of the job, 1 or more");
}

/// A key that nobody reads is named; one that seems to mean another key is not taken, because what it says would be
/// lost: a report without its revision answers any job.
TEST(Actuals, KeysThatNobodyReadsAreNamed) {
  const auto read = [](const std::string& entry, const std::string& beside = "") {
    return read_actuals_json("{" + beside + R"("items": [{"item": "A", "outcome": "done")" + entry + "}]}", "a.json");
  };
  EXPECT_TRUE(read(R"(, "revision": 2, "units": "m", "frame": "building")").ignored.empty());
  for (const auto& [wrong, meant] : {std::pair{"revison", "revision"},
                                     {"Revision", "revision"},
                                     {"sgima", "sigma"},
                                     {"mesured", "measured"},
                                     {"settings", "setting"},
                                     {"jobb", "job"},
                                     {"not", "note"}}) {
    const ActualsT actuals = read(", \"" + std::string(wrong) + "\": 1");
    ASSERT_EQ(actuals.refused.size(), std::string(meant).size() < 4 ? 0U : 1U) << wrong;
    if (actuals.refused.empty()) {
      EXPECT_EQ(actuals.ignored.at(0), "a.json: '" + std::string(wrong) + "' is not read") << "too short to guess";
    } else {
      EXPECT_EQ(actuals.refused[0],
                "a.json: items[0]: has '" + std::string(wrong) + "', which is no key; '" + meant + "' is");
    }
  }
  const ActualsT other = read(R"(, "temperature": 21, "robot": {"speed": 3})", R"("project": "tower", )");
  ASSERT_EQ(other.items.size(), 1U);
  ASSERT_EQ(other.ignored.size(), 1U);
  EXPECT_EQ(other.ignored[0], "a.json: 'project', 'robot' and 'temperature' are not read");
  EXPECT_THROW(read("", R"("unit": "in", )"), std::runtime_error);
  EXPECT_THROW(read("", R"("units": {"length": "ft", "angle": "rad"}, )"), std::runtime_error);
  EXPECT_THROW(read("", R"("frame": "floor 3", )"), std::runtime_error);
  EXPECT_NE(read(R"(, "units": "mm")").refused.at(0).find("lengths are in metres"), std::string::npos);
  EXPECT_NE(read(R"(, "measured": [1, 2, 3, 4])").refused.at(0).find("[E, N, H]"), std::string::npos);
  EXPECT_NE(read(R"(, "setting": {"right": 0, "up": 0, "out": 0, "turn": 1})").refused.at(0).find("'setting'"),
            std::string::npos);
  EXPECT_NE(read(R"(, "revision": 4294967298)").refused.at(0).find("expected that of the job"), std::string::npos);
  EXPECT_NE(read(R"(, "sigma": [0.001, 0, 0.001])").refused.at(0).find("each above 0"), std::string::npos);
  try {
    read(R"(, "outcome": "failed")");
    ADD_FAILURE() << "done or failed?";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("a.json: has 'outcome' twice"), std::string::npos) << error.what();
  }
}

TEST(Actuals, WhatIsNoFileOfReportsIsSaid) {
  const auto words = [](const std::string& text) {
    try {
      read_actuals_json(text, "a.json");
    } catch (const std::runtime_error& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_NE(words("").find("a.json: is empty"), std::string::npos);
  EXPECT_NE(words("[]").find("has no list 'items'"), std::string::npos);
  EXPECT_NE(words("{\"items\": [\n{\"item\": }]}").find("is no JSON: parse error at line 2, column 10"),
            std::string::npos)
      << words("{\"items\": [\n{\"item\": }]}");
  EXPECT_NE(words(R"({"jobId": "1", "items": []})").find("is a job"), std::string::npos);
}

}  // namespace test_actuals
}  // namespace plumbline::loop

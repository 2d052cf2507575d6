// What a node leaves changed in its process - rounding, signals, folder, locale - is named and reaches no other.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>

#include "isolated_run.hpp"

namespace plumbline::test {
namespace test_left_changed {

const std::pair<const char*, const char*> changes[] = {
    {"blocked", "the signals that its thread blocks"},
    {"umask", "the umask (0000 in place of "},
    {"folder", "the working folder"},
    {"locale", "the locale (C.UTF-8 in place of C)"},
    {"environment", "the environment (ACCIDENT_WAS_HERE, PATH)"},
    {"signals", "what signals do (SIGCHLD)"},
    // These last: after them all nodes of this process run apart.
    {"rounding", "the floating-point mode of its thread: rounding (upwards)"},
#if defined(__x86_64__)
    {"vector_rounding", "rounding of vector registers"},
    {"subnormals", "subnormal results (set to zero), subnormal operands (taken as zero)"},
    {"traps", "traps of floating-point exceptions"},
#endif
};

/// The sum as it is in the mode that IEEE 754 has by default.
double thirds() {
  volatile double one = 1, three = 3, sum = 0;
  for (int i = 0; i < 1000; ++i) sum = sum + one / three;
  return sum + 1;
}

/// One that puts the locale back harms only who read or wrote numbers meanwhile. (First, as long as nodes run in this
/// process.)
TEST_F(Isolation, WhoRunsBesideOneThatSetsTheLocaleForAWhileIsRunAgainApart) {
  const TemporaryFolder place;
  const std::string bad = "  bad: {use: accident.leaves_changed, with: {what: locale_for_a_while";
  run(bad + ", place: " + place.path().string() +
      "}}\n  good: {use: accident.thirds, with: {place: " + place.path().string() + "}}\n");
  EXPECT_EQ(node("bad").error, "");
  ASSERT_EQ(node("good").error, "");
  EXPECT_NE(node("good").metrics.at(0).value, getpid()) << "it was not run apart";
  run(bad + "}}\n  good: {use: accident.thirds, in: {after: bad.number}}\n");
  ASSERT_EQ(node("good").error, "");
  EXPECT_EQ(node("good").metrics.at(0).value, getpid()) << "nobody ran beside it";
}

/// Who ended meanwhile was taken to have changed what signals do, and both were run again apart.
TEST_F(Isolation, WhoEndsWhileACommandOfAnotherRunsHasChangedNothing) {
  const TemporaryFolder place;
  run("  waits: {use: accident.leaves_changed, with: {what: signals_for_a_while, place: " + place.path().string() +
      "}}\n  good: {use: accident.thirds, with: {place: " + place.path().string() + "}}\n");
  EXPECT_EQ(node("waits").error, "");
  ASSERT_EQ(node("good").error, "");
  EXPECT_EQ(node("good").metrics.at(0).value, getpid()) << "it was run apart";
}

/// What a node leaves changed is named, its result is not kept, and what runs afterwards knows nothing of it.
TEST_F(Isolation, WhatANodeLeavesChangedIsNamedAndReachesNoOther) {
  int salt = 0;
  for (const bool apart : {false, true})
    for (const auto& [what, words] : changes) {
      const std::string bad = "  bad: {use: accident.leaves_changed, with: {what: " + std::string(what) + "}}\n";
      run(bad, apart);
      EXPECT_EQ(node("bad").status, NodeStatus::failed) << what << apart;
      EXPECT_TRUE(contains(node("bad").error, "node 'bad' (accident.leaves_changed) failed: it left changed"))
          << node("bad").error;
      EXPECT_TRUE(contains(node("bad").error, words)) << node("bad").error;
      run("  next: {use: accident.thirds, with: {salt: " + std::to_string(++salt) + "}}\n", apart);
      ASSERT_EQ(node("next").error, "") << what << apart;
      EXPECT_EQ(Json::parse(value("next")).at("value").get<double>(), thirds()) << what << apart;
      run(bad, apart);
      EXPECT_EQ(node("bad").status, NodeStatus::failed) << what << ": it must not have been stored";
    }
}

/// Who ran beside it when the process changed may have suffered from it: it is run again apart, and is not blamed.
TEST_F(Isolation, WhoRunsBesideOneThatChangesTheProcessIsRunAgainApart) {
  const TemporaryFolder place;
  const fs::path before = fs::current_path();
  run("  bad: {use: accident.leaves_changed, with: {what: folder, place: " + place.path().string() +
      "}}\n  good: {use: accident.thirds, with: {place: " + place.path().string() + "}}\n");
  EXPECT_EQ(node("bad").status, NodeStatus::failed);
  EXPECT_TRUE(contains(node("bad").error, "it left changed what it must leave as it finds it: the working folder"))
      << node("bad").error;
  EXPECT_EQ(node("good").error, "");
  EXPECT_EQ(Json::parse(value("good")).at("value").get<double>(), thirds());
  EXPECT_EQ(fs::current_path(), before);
}

}  // namespace test_left_changed
}  // namespace plumbline::test

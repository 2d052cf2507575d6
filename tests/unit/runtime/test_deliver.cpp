#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "story.hpp"

namespace plumbline::test {
namespace {

namespace fs = std::filesystem;

std::vector<runtime::Delivery> deliver(Story& story) {
  return runtime::deliver(story.graph, story_registry(), *story.store, story.result, story.folder.path() / "out");
}

TEST(Deliver, ArtifactsAsJsonListsAsArraysFoldersAsTrees) {
  Story story("a: {use: story.constant, with: {value: 2.5}}\ns: {use: story.series}\nw: {use: story.folder}",
              "outputs: {one.json: a.number, sub/all.json: s.numbers, tree: w.folder, tree.json: w.folder}");
  story.run();
  for (const auto& delivery : deliver(story)) EXPECT_EQ(delivery.problem, "") << delivery.file;
  const fs::path out = story.folder.path() / "out";
  EXPECT_EQ(nlohmann::json::parse(read_file(out / "one.json")), (nlohmann::json{{"value", 2.5}}));
  EXPECT_EQ(nlohmann::json::parse(read_file(out / "sub/all.json")).size(), 3u);
  EXPECT_EQ(read_file(out / "tree" / "a.txt"), "hello");
  EXPECT_EQ(nlohmann::json::parse(read_file(out / "tree.json")).at("files").size(), 1u);
}

TEST(Deliver, ReplacesWhatAnEarlierRunLeft) {
  Story story("w: {use: story.folder}\na: {use: story.constant}", "outputs: {tree: w.folder, a.json: a.number}");
  story.run();
  deliver(story);
  std::ofstream(story.folder.path() / "out" / "tree" / "old.txt") << "old";
  story.run({"w.with.text=new", "a.with.value=7"});
  deliver(story);
  const fs::path out = story.folder.path() / "out";
  EXPECT_FALSE(fs::exists(out / "tree" / "old.txt"));
  EXPECT_EQ(read_file(out / "tree" / "a.txt"), "new");
  EXPECT_EQ(nlohmann::json::parse(read_file(out / "a.json")).at("value"), 7);
}

TEST(Deliver, WhatFailedIsAbsentAndTheRestIsThere) {
  Story story("a: {use: story.add, in: {a: c.number}}\nc: {use: story.constant}\nd: {use: story.constant}",
              "outputs: {a.json: a.sum, d.json: d.number}");
  story.run();
  deliver(story);
  ASSERT_TRUE(fs::exists(story.folder.path() / "out" / "a.json"));
  story.tell("c: {use: story.throws}\na: {use: story.add, in: {a: c.number}}\nd: {use: story.constant}",
             "outputs: {a.json: a.sum, d.json: d.number}");
  story.run();
  const auto deliveries = deliver(story);
  EXPECT_EQ(deliveries.at(0).problem, "'a' did not run because 'c' failed");
  EXPECT_EQ(deliveries.at(1).problem, "");
  EXPECT_FALSE(fs::exists(story.folder.path() / "out" / "a.json")) << "an old result would be taken for a new one";
  EXPECT_TRUE(fs::exists(story.folder.path() / "out" / "d.json"));
}

TEST(Deliver, LeavesAFolderThatIsThereAlready) {
  Story story("w: {use: story.folder}", "outputs: {tree: w.folder}");
  const fs::path file = story.folder.path() / "out" / "tree" / "a.txt";
  story.run();
  deliver(story);
  struct stat before {
  }, after{};
  stat(file.c_str(), &before);
  deliver(story);
  stat(file.c_str(), &after);
  EXPECT_EQ(before.st_ino, after.st_ino) << "it was copied again";
  std::ofstream(file) << "jello";
  deliver(story);
  EXPECT_EQ(read_file(file), "hello");
}

TEST(Deliver, LeavesNoTemporaryNames) {
  Story story("w: {use: story.folder}\na: {use: story.constant}", "outputs: {tree: w.folder, a.json: a.number}");
  story.run();
  deliver(story);
  for (const auto& entry : fs::recursive_directory_iterator(story.folder.path() / "out"))
    EXPECT_NE(entry.path().filename().string()[0], '.') << entry.path();
}

TEST(Deliver, AFileInTheWayIsAnError) {
  Story story("a: {use: story.constant}", "outputs: {a.json: a.number}");
  story.run();
  std::ofstream(story.folder.path() / "out") << "a file";
  EXPECT_THROW(deliver(story), std::runtime_error);
}

}  // namespace
}  // namespace plumbline::test

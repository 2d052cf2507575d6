#include <nlohmann/json.hpp>
#include <sstream>

#include "story.hpp"

namespace plumbline::test {
namespace {

TEST(Record, TellsWhatRan) {
  Story story("x: {use: story.throws}\ny: {use: story.add, in: {a: x.number}}\na: {use: story.constant}",
              "outputs: {a.json: a.number}");
  story.run({"a.with.value=4"});
  const auto out = story.folder.path() / "out";
  runtime::OutputFolder folder(out, story.store->file_hashes());
  runtime::Record record(folder, story.graph, {"0.0", {"a.with.value=4"}, story.store->folder(), 2, 1000});
  for (size_t i = 0; i < story.graph.nodes.size(); ++i) record.node(story.graph.nodes[i], story.result.nodes[i]);
  record.end(story.result, deliver(story.graph, story_registry(), *story.store, story.result, folder));

  std::istringstream lines(read_file(out / "run.jsonl"));
  std::vector<nlohmann::json> events;
  for (std::string line; std::getline(lines, line);) events.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(events.size(), 6u);
  EXPECT_EQ(events[0]["event"], "run_start");
  EXPECT_EQ(events[0]["pipeline_sha256"].get<std::string>().size(), 64u);
  EXPECT_EQ(events[0]["variables"]["seed"], "1");
  std::map<std::string, nlohmann::json> nodes;
  for (size_t i = 1; i < 4; ++i) nodes[events[i]["name"]] = events[i];
  EXPECT_EQ(nodes["a"]["status"], "executed");
  EXPECT_EQ(nodes["a"]["parameters"]["value"], "4");
  EXPECT_EQ(nodes["a"]["plugin"]["name"], "story");
  EXPECT_EQ(nodes["a"]["outputs"]["number"].size(), 1u);
  EXPECT_EQ(nodes["a"]["types"]["number"], "plumbline.Number/1");
  EXPECT_EQ(nodes["x"]["status"], "failed");
  EXPECT_NE(nodes["x"]["error"].get<std::string>().find("the bridge is out"), std::string::npos);
  EXPECT_EQ(nodes["y"]["status"], "skipped");
  EXPECT_EQ(events[4]["event"], "deliver");
  EXPECT_EQ(events[5]["status"], "failed");
  EXPECT_EQ(events[5]["executed"], 1);
  EXPECT_EQ(events[5]["outputs"]["a.json"], "written");
  EXPECT_EQ(events[5]["owned"]["files"]["a.json"], nlohmann::json::array({events[4]["files"]["a.json"]}));
  EXPECT_GT(events[5]["peak_memory"], 0);
}

TEST(Record, AFolderThatCannotBeWrittenIsNamed) {
  Story story("a: {use: story.constant}");
  story.run();
  const auto file = story.folder.path() / "file";
  std::ofstream(file) << "x";
  EXPECT_THROW(runtime::OutputFolder(file / "out", story.store->file_hashes()), std::runtime_error);
}

}  // namespace
}  // namespace plumbline::test

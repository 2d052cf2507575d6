#include <nlohmann/json.hpp>
#include <sstream>

#include "runtime/base/json_text.hpp"
#include "story.hpp"

namespace plumbline::test {
namespace test_record {

TEST(Record, TellsWhatRan) {
  Story story("x: {use: story.throws}\ny: {use: story.add, in: {a: x.number}}\na: {use: story.constant}",
              "outputs: {a.json: a.number}");
  story.run({"a.with.value=4"});
  const auto out = story.folder.path() / "out";
  runtime::OutputFolder folder(out, story.store->file_hashes());
  runtime::Record record(folder, story.graph, {"0.0", {"a.with.value=4"}, story.store->folder(), 2, 1000});
  for (size_t i = 0; i < story.graph.nodes.size(); ++i) record.node(story.graph.nodes[i], story.result.nodes[i]);
  record.end(story.result, deliver(story.graph, *story.store, story.result, folder));

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

TEST(JsonText, IsWhatAParserReadsBack) {
  runtime::JsonText json;
  json.open('{').field("text", "a \"quoted\" line\n\ttab \\ \xc3\xbc").field("no utf-8", std::string("a\xff") + "b");
  json.field("tenth", 0.1).field("whole", 2.0).field("nan", std::nan("")).field("big", ~std::uint64_t{0});
  json.field("list", std::vector<std::string>{"x", "y"}).name("empty").open('[').close(']').close('}');
  const auto read = nlohmann::json::parse(json.take());
  EXPECT_EQ(read["text"], "a \"quoted\" line\n\ttab \\ \xc3\xbc");
  EXPECT_EQ(read["no utf-8"],
            "a\xef\xbf\xbd"
            "b");
  EXPECT_EQ(read["tenth"], 0.1);
  EXPECT_TRUE(read["whole"].is_number_float());
  EXPECT_TRUE(read["nan"].is_null());
  EXPECT_EQ(read["big"], ~std::uint64_t{0});
  EXPECT_EQ(read["list"], (std::vector<std::string>{"x", "y"}));
  EXPECT_TRUE(read["empty"].empty());
}

}  // namespace test_record
}  // namespace plumbline::test

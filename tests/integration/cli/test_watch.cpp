// plumbline watch: one run for what is there, one for what comes, none for what the program wrote itself.
#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "program.hpp"

namespace plumbline::test {
namespace test_watch {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// The folder is read where the outputs go, too.
const std::string site =
    "plumbline: 1\nnodes:\n  f: {use: story.length, with: {folder: .}}\n"
    "  a: {use: story.constant, with: {value: 3}}\noutputs: {size.json: f.number, a.json: a.number}\n";

std::map<std::string, std::string> statuses(const fs::path& record) {
  std::map<std::string, std::string> found;
  std::istringstream stream(read_file(record));
  for (std::string line; std::getline(stream, line);) {
    const Json event = Json::parse(line);
    if (event["event"] == "node") found[event["name"]] = event["status"];
  }
  return found;
}

bool wait_until(const std::function<bool()>& there) {
  for (int i = 0; i < 1200; ++i, std::this_thread::sleep_for(std::chrono::milliseconds(50)))
    if (there()) return true;
  return false;
}

bool has_ended(const fs::path& record) { return contains(read_file(record), "\"event\":\"run_end\""); }

TEST(Watch, RunsAgainForWhatComesAndNotForItsOwnOutputs) {
  const Program plumbline;
  plumbline.write("p.yaml", site);
  plumbline.write("one.txt", "1");
  const pid_t child = plumbline.start({"watch", "p.yaml", "--runs", "2", "--quiet-for", "0.2"});
  const fs::path record = plumbline.work() / "out/p/run.jsonl";
  ASSERT_TRUE(wait_until([&] { return fs::exists(record) && has_ended(record); }));
  // What it waits for now is a change; its own outputs were none, or --runs 2 would end it.
  std::this_thread::sleep_for(std::chrono::seconds(2));
  ASSERT_EQ(kill(child, 0), 0);
  plumbline.write("two.txt", "22");
  const Answer answer = plumbline.finish(child);
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, "changed: ")) << answer.out;
  EXPECT_TRUE(contains(answer.out, "two.txt")) << answer.out;
  EXPECT_EQ(statuses(record), (std::map<std::string, std::string>{{"f", "executed"}, {"a", "reused"}}));
}

TEST(Watch, NamesWhatNeverComesToRest) {
  const Program plumbline;
  plumbline.write("p.yaml", site);
  const pid_t child = plumbline.start({"watch", "p.yaml", "--runs", "1", "--quiet-for", "0.2"});
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(4);
  for (int i = 0; std::chrono::steady_clock::now() < until; ++i) {
    plumbline.write("camera_sync.log", std::string(static_cast<size_t>(i + 1), 'x'));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const Answer answer = plumbline.finish(child);
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, "camera_sync.log changes still")) << answer.out;
}

/// A copy that paused for longer than the quiet time began a run, which failed of the half photograph.
TEST(Watch, WaitsForAPhotographThatHasNoEndYet) {
  const std::string photograph(
      "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x00\x3c\x00\x00\x00\x28\x08\x00\x00\x00"
      "\x00\x87\xd0\xc6\x23\x00\x00\x00\x00IEND\xae\x42\x60\x82",
      45);
  const Program plumbline;
  plumbline.write("p.yaml", site);
  plumbline.write("half.PNG", photograph.substr(0, 40));
  const pid_t child = plumbline.start({"watch", "p.yaml", "--runs", "1", "--quiet-for", "0.2"});
  std::this_thread::sleep_for(std::chrono::seconds(3));
  EXPECT_FALSE(fs::exists(plumbline.work() / "out/p/run.jsonl")) << "no run of half a photograph";
  plumbline.write("half.PNG", photograph);
  const Answer answer = plumbline.finish(child);
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, "half.PNG has no end yet")) << answer.out;
}

/// Half a survey file was a whole result of half the readings.
TEST(Watch, WaitsForASurveyFileWhoseLastLineHasNoEnd) {
  const Program plumbline;
  plumbline.write("p.yaml", site);
  std::string survey;
  for (int line = 0; line < 4; ++line) survey += "*110001+000000000000S100 84..10+0000000005000000 \n";
  plumbline.write("day1.gsi", survey + "*110002+0000000000");
  const pid_t child = plumbline.start({"watch", "p.yaml", "--runs", "1", "--quiet-for", "0.2"});
  std::this_thread::sleep_for(std::chrono::seconds(3));
  EXPECT_FALSE(fs::exists(plumbline.work() / "out/p/run.jsonl")) << "no run of half a survey";
  plumbline.write("day1.gsi", survey);
  const Answer answer = plumbline.finish(child);
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, "day1.gsi has no end yet")) << answer.out;
}

/// Cut where a line ends, the half of it looks whole, and gave a verdict on half of the readings.
TEST(Watch, WaitsForASurveyFileThatLostHalfOfItsLines) {
  const Program plumbline;
  plumbline.write("p.yaml", site);
  std::string survey;
  for (int line = 0; line < 40; ++line) survey += "*110001+000000000000S100 84..10+0000000005000000 \n";
  plumbline.write("day1.gsi", survey);
  const pid_t child = plumbline.start({"watch", "p.yaml", "--runs", "2", "--quiet-for", "0.2"});
  const fs::path record = plumbline.work() / "out/p/run.jsonl";
  while (!fs::exists(record)) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  const auto first = fs::last_write_time(record);
  plumbline.write("day1.gsi", survey.substr(0, survey.size() / 2));
  std::this_thread::sleep_for(std::chrono::seconds(3));
  EXPECT_EQ(fs::last_write_time(record), first) << "no run of half a survey";
  plumbline.write("day1.gsi", survey + "\n");
  const Answer answer = plumbline.finish(child);
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_TRUE(contains(answer.out, "day1.gsi is much shorter than it was, as while a copy")) << answer.out;
}

/// A TIFF whose directory, 8 bytes behind the mark, names one strip of 16 bytes behind it.
std::string a_tiff() {
  std::string tiff("II*\0\x08\0\0\0\x02\0", 10);
  tiff += std::string("\x11\x01\x04\0\x01\0\0\0\x26\0\0\0", 12);  // StripOffsets: 38
  tiff += std::string("\x17\x01\x04\0\x01\0\0\0\x10\0\0\0", 12);  // StripByteCounts: 16
  return tiff + std::string(4, '\0') + std::string(16, '\x7f');
}

/// Half a TIFF or a raw photograph was taken for a whole one, and so was half a HEIC.
TEST(Watch, WaitsForWhatOfATiffOrAHeicLiesBehindItsEnd) {
  const std::string heic = std::string("\0\0\0\x10", 4) + "ftypheic" + std::string(4, '\0') +
                           std::string("\0\0\0\x18", 4) + "mdat" + std::string(16, '\x7f');
  for (const auto& [name, whole] :
       {std::pair<std::string, std::string>{"half.tif", a_tiff()}, {"half.DNG", a_tiff()}, {"half.heic", heic}}) {
    const Program plumbline;
    plumbline.write("p.yaml", site);
    plumbline.write(name, whole.substr(0, whole.size() - 3));
    const pid_t child = plumbline.start({"watch", "p.yaml", "--runs", "1", "--quiet-for", "0.2"});
    std::this_thread::sleep_for(std::chrono::seconds(2));
    EXPECT_FALSE(fs::exists(plumbline.work() / "out/p/run.jsonl")) << name << ": no run of half a photograph";
    plumbline.write(name, whole);
    const Answer answer = plumbline.finish(child);
    EXPECT_EQ(answer.code, 0) << answer.err;
    EXPECT_TRUE(contains(answer.out, name + " has no end yet")) << answer.out;
  }
}

TEST(Watch, RunsAgainWhenANodeOfOnesOwnHasChanged) {
  Program plumbline;
  const std::string script = "#!/bin/sh\nprintf '{\"x\": [1, \"1\"]}' > \"$1/metrics.json\"\n";
  fs::create_directory(plumbline.work() / "nodes");
  plumbline.use_plugins(plumbline.work() / "nodes");
  plumbline.write("nodes/own.node.yaml",
                  "plumbline_node: 1\nkind: own.number\nversion: 1\nsummary: A number\nlicence: MIT\n"
                  "run: [/bin/sh, own.sh]\n");
  plumbline.write("nodes/own.sh", script);
  plumbline.write("p.yaml", "plumbline: 1\nnodes: {a: {use: own.number}}\n");
  const pid_t child = plumbline.start({"watch", "p.yaml", "--runs", "2", "--quiet-for", "0.2"});
  const fs::path record = plumbline.work() / "out/p/run.jsonl";
  ASSERT_TRUE(wait_until([&] { return fs::exists(record) && has_ended(record); }));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  ASSERT_EQ(kill(child, 0), 0);
  plumbline.write("nodes/own.sh", script + "# another\n");
  const Answer answer = plumbline.finish(child);
  EXPECT_TRUE(contains(answer.out, "own.sh")) << answer.out << answer.err;
  EXPECT_EQ(statuses(record), (std::map<std::string, std::string>{{"a", "executed"}}));
}

TEST(Watch, EndsWithTheSignalAndSaysSoByItsExitCode) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  const pid_t child = plumbline.start({"watch", "p.yaml", "--quiet-for", "0.2"});
  const fs::path record = plumbline.work() / "out/p/run.jsonl";
  ASSERT_TRUE(wait_until([&] { return fs::exists(record) && has_ended(record); }));
  kill(child, SIGTERM);
  EXPECT_EQ(plumbline.finish(child).code, 130);
}

TEST(Watch, APipelineThatIsWrongFromTheStartIsRefused) {
  const Program plumbline;
  plumbline.write("p.yaml", "plumbline: 1\nnodes: {a: {use: story.constnat}}\n");
  const Answer answer = plumbline({"watch", "p.yaml"});
  EXPECT_EQ(answer.code, 2);
  EXPECT_TRUE(contains(answer.err, "story.constant")) << answer.err;
}

}  // namespace test_watch
}  // namespace plumbline::test

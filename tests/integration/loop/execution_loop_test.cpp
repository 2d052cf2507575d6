// execution_loop.yaml as a whole: brackets are set, panels hang, and all are verified by measurement; what no number of
// campaigns tells ends in words, not in panels that only seem to be verified.
#include <nlohmann/json.hpp>

#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace {

using Json = nlohmann::json;

std::map<std::string, double> last_metrics(const std::filesystem::path& record, const std::string& node) {
  std::map<std::string, double> metrics;
  std::istringstream stream(read_file(record));
  for (std::string line; std::getline(stream, line);)
    if (const Json event = Json::parse(line); event["event"] == "node" && event["name"] == node)
      for (const Json& metric : event["metrics"]) metrics[metric["name"]] = metric["value"];
  return metrics;
}

Answer run(const Program& plumbline, std::vector<std::string> more) {
  more.insert(more.begin(), {"run", std::string(source_dir()) + "/pipelines/execution_loop.yaml", "--out", "out"});
  return plumbline(more);
}

TEST(ExecutionLoop, AllPanelsHangAndAreVerified) {
  for (const char* seed : {"seed=1", "seed=2"}) {
    const Program plumbline;
    const Answer answer = run(plumbline, {seed});
    ASSERT_EQ(answer.code, 0) << answer.err;
    const auto metrics = last_metrics(plumbline.work() / "out/run.jsonl", "release");
    EXPECT_EQ(metrics.at("panels"), 9);
    EXPECT_EQ(metrics.at("panels_verified"), 9) << seed;
    EXPECT_EQ(metrics.at("released"), 0);
    const Answer journal = plumbline({"journal", "out", "--check"});
    EXPECT_EQ(journal.code, 0) << journal.err;
    const std::string model = read_file(plumbline.work() / "out/as_built.ifc");
    EXPECT_TRUE(contains(model, "'ASB_InstallationState'") && contains(model, "IFCTASK(")) << seed;
    EXPECT_TRUE(contains(read_file(plumbline.work() / "out/loop.html"), "every panel hangs within its limits")) << seed;
  }
}

/// One set of readings, u about 1.5 mm at limits of 5 mm: campaigns are combined until they do.
TEST(ExecutionLoop, AWeakSurveyCostsRoundsAndNotPanels) {
  const Program plumbline;
  const Answer answer = run(plumbline, {"sets=1"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  EXPECT_EQ(last_metrics(plumbline.work() / "out/run.jsonl", "release").at("panels_verified"), 9);
}

/// Control that is off by 4 mm is off by that in every campaign: nothing is verified, and the loop ends and says why.
TEST(ExecutionLoop, WhatAllCampaignsShareIsNotMeasuredAway) {
  const Program plumbline;
  const Answer answer = run(plumbline, {"site.with.control_sigma=0.004"});
  ASSERT_EQ(answer.code, 0) << answer.err;
  const auto metrics = last_metrics(plumbline.work() / "out/run.jsonl", "release");
  EXPECT_EQ(metrics.at("panels_verified"), 0);
  EXPECT_EQ(metrics.at("done"), 1);
  const std::string next = read_file(plumbline.work() / "out/next.txt");
  EXPECT_TRUE(contains(next, "nothing may be hung as it stands")) << next;
}

}  // namespace
}  // namespace plumbline::test

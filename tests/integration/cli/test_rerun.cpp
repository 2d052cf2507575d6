// What a second run of the main job does: nothing, and after a change only what the change reaches. On a small
// simulated site, from photographs to the report.
#include <nlohmann/json.hpp>
#include <set>

#include "program.hpp"
#include "test_paths.hpp"

namespace plumbline::test {
namespace test_rerun {

using Json = nlohmann::json;

/// Names of the nodes of the last run by status, from its record.
std::set<std::string> nodes(const std::filesystem::path& out, const std::string& status) {
  std::set<std::string> names;
  std::istringstream lines(read_file(out / "run.jsonl"));
  for (std::string line; std::getline(lines, line);) {
    const Json json = Json::parse(line);
    if (json["event"] == "node" && json["status"] == status) names.insert(json["name"]);
  }
  return names;
}

TEST(Rerun, ExecutesNothingAndAfterAChangeOnlyWhatFollows) {
  Program plumbline(PLUMBLINE_PLUGIN_FOLDER);
  const std::string pipeline = std::string(plumbline::test::source_dir()) + "/pipelines/single_floor.yaml";
  const std::filesystem::path out = plumbline.work() / "out";
  const auto run = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments = {
        "run", pipeline, "columns=3", "camera=quick_6mp", "site.with.images_per_floor=6", "--out", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return plumbline(arguments);
  };
  Answer answer = run({});
  ASSERT_EQ(answer.code, 0) << answer.out << answer.err;
  const std::set<std::string> all = nodes(out, "executed");
  EXPECT_GE(all.size(), 10u);
  const std::string metrics = read_file(out / "metrics.json"), ifc = read_file(out / "as_built.ifc");

  answer = run({});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_EQ(nodes(out, "executed"), std::set<std::string>{});
  EXPECT_EQ(nodes(out, "reused"), all);
  EXPECT_TRUE(
      contains(answer.out, "single_floor.yaml: 0 executed, " + std::to_string(all.size()) + " reused, 0 failed"))
      << answer.out;
  EXPECT_EQ(read_file(out / "metrics.json"), metrics);
  EXPECT_EQ(read_file(out / "as_built.ifc"), ifc);

  answer = run({"poses.with.solver=epnp"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_EQ(nodes(out, "executed"),
            (std::set<std::string>{"poses", "block", "chain", "deviation", "accuracy", "drawing", "epochs", "ids",
                                   "ifc", "issues", "photographs", "report", "sheets", "summary", "table"}));

  run({});
  EXPECT_EQ(nodes(out, "executed"), std::set<std::string>{}) << "the first result is still there";
  EXPECT_EQ(read_file(out / "metrics.json"), metrics);

  // A simulator that was built anew: another binary, the same photographs.
  const std::filesystem::path rebuilt = plumbline.folder.path() / "rebuilt";
  std::filesystem::copy(PLUMBLINE_PLUGIN_FOLDER, rebuilt, std::filesystem::copy_options::recursive);
  for (const auto& entry : std::filesystem::directory_iterator(rebuilt))
    if (entry.path().filename().string().find("simulate") != std::string::npos)
      std::ofstream(entry.path(), std::ios::app | std::ios::binary) << "rebuilt";
  plumbline.use_plugins(rebuilt);
  answer = run({});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_EQ(nodes(out, "executed"), std::set<std::string>{"site"}) << "it detected the same tags again";
}

}  // namespace test_rerun
}  // namespace plumbline::test

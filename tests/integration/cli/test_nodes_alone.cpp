// The shipped pipelines with every node in a process of its own: the same bits, and no more memory than was announced.
#include <nlohmann/json.hpp>

#include "program.hpp"

namespace plumbline::test {
namespace test_nodes_alone {

namespace fs = std::filesystem;
using Json = nlohmann::json;

class NodesAlone : public testing::Test {
 protected:
  NodesAlone() {
    fs::create_directories(program_.folder.path() / "lib/plumbline");
    fs::copy_file(PLUMBLINE_WORKER, program_.folder.path() / "lib/plumbline/plumbline-worker");
  }
  static std::string pipeline(const std::string& name) {
    return std::string(source_dir()) + "/pipelines/" + name + ".yaml";
  }

  const Program program_{PLUMBLINE_PLUGIN_FOLDER};
};

/// What a node left behind in a process that ran others before it would be seen here, and nowhere else.
TEST_F(NodesAlone, GiveTheBitsOfTheStore) {
  for (const std::vector<std::string>& words : {std::vector<std::string>{pipeline("observations"), "floors=2"},
                                                {pipeline("observations_free"), "floors=2"},
                                                {pipeline("observations_joint"), "floors=2", "survey=readings"},
                                                {pipeline("plan_images"), "floors=1"},
                                                {pipeline("pose_breakdown"), "outliers=0.1"},
                                                {pipeline("registration_breakdown"), "floors=2"}}) {
    std::vector<std::string> all{"verify", "--each"};
    all.insert(all.end(), words.begin(), words.end());
    const Answer answer = program_(all);
    EXPECT_EQ(answer.code, 0) << words[0] << answer.out << answer.err;
    EXPECT_TRUE(contains(answer.out, "each run alone in a process of its own: the same bits")) << answer.out;
  }
}

/// A run keeps its limit of memory only if nodes say what they will take: all that takes more than 64 MiB.
TEST_F(NodesAlone, TakeNoMoreMemoryThanTheyAnnounce) {
  constexpr double unannounced = 64.0 * 1024 * 1024;
  for (const std::vector<std::string>& words : {std::vector<std::string>{pipeline("observations"), "floors=5"},
                                                {pipeline("single_floor"), "camera=quick_6mp"},
                                                {pipeline("rendered"), "images_per_floor=4", "camera=quick_6mp"}}) {
    std::vector<std::string> all{"run"};
    all.insert(all.end(), words.begin(), words.end());
    all.insert(all.end(), {"--isolate", "--threads", "1", "--out", "out"});
    const Answer answer = program_(all);
    ASSERT_EQ(answer.code, 0) << words[0] << answer.err;
    std::istringstream record(read_file(program_.work() / "out/run.jsonl"));
    size_t measured = 0;
    for (std::string line; std::getline(record, line);) {
      const Json node = Json::parse(line);
      if (node["event"] != "node" || !node["memory"].contains("taken")) continue;
      ++measured;
      EXPECT_LE(node["memory"]["taken"].get<double>(), node["memory"]["announced"].get<double>() + unannounced)
          << words[0] << ": " << node["name"] << " (" << node["kind"] << ")";
    }
    EXPECT_GT(measured, 0u);
  }
}

}  // namespace test_nodes_alone
}  // namespace plumbline::test

// Slurm for real: four virtual nodes on this machine, 1000 cells in one array, one node killed in the middle. Every
// cell has its result once the jobs are through, bit-equal to a local run, and the scheduler was called once.
#include <chrono>
#include <thread>

#include "bench_program.hpp"

namespace plumbline::test {
namespace test_slurm {

namespace fs = std::filesystem;

bool installed(const std::string& program) {
  return std::system(("command -v " + program + " >/dev/null").c_str()) == 0;
}

/// Where in PATH the real program is.
std::string path_of(const std::string& program) {
  std::string text;
  FILE* pipe = popen(("command -v " + program).c_str(), "r");
  char buffer[512];
  while (fgets(buffer, sizeof buffer, pipe)) text += buffer;
  pclose(pipe);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

class Cluster {
 public:
  explicit Cluster(int nodes) {
    up = script("start", std::to_string(nodes)) == 0;
    setenv("SLURM_CONF", (folder_.path() / "slurm.conf").c_str(), 1);
  }
  Cluster(const Cluster&) = delete;
  Cluster& operator=(const Cluster&) = delete;
  ~Cluster() { script("stop", ""); }
  int script(const std::string& action, const std::string& argument) const {
    return std::system(
        ("sh " PLUMBLINE_CLUSTER_SCRIPT " " + action + " " + folder_.path().string() + " " + argument).c_str());
  }
  bool up = false;

 private:
  TemporaryFolder folder_;
};

/// A thousand cells with PLUMBLINE_LONG.
TEST(Slurm, ManyCellsAndAKilledNode) {
  for (const char* program : {"slurmctld", "slurmd", "sbatch", "squeue", "python3"})
    if (!installed(program)) GTEST_SKIP() << program << " is not installed (scripts/setup --tests)";
  if (geteuid() != 0) GTEST_SKIP() << "slurmd must be root to start jobs";
  BenchProgram local, sent;
  const size_t seeds = std::getenv("PLUMBLINE_LONG") ? 250 : 75, cells = 4 * seeds;
  const std::string rest = "seeds: 1-" + std::to_string(seeds) +
                           "\nmatrix: {factor: [1, 2]}\n"
                           "alternatives: {method: {a: {}, b: {solver.with.milliseconds: 40}}}\n";
  for (const BenchProgram* program : {&local, &sent}) program->bench_file(rest);
  local.run();
  ASSERT_EQ(local.results().size(), cells);

  const Cluster cluster(4);
  ASSERT_TRUE(cluster.up);
  // In front of the real programs: each call is counted.
  const fs::path shims = sent.folder.path() / "shims", calls = sent.folder.path() / "calls";
  fs::create_directory(shims);
  for (const char* program : {"sbatch", "squeue", "srun", "sacct", "scontrol", "sinfo"}) {
    std::ofstream(shims / program) << "#!/bin/sh\necho " << program << " >> " << calls.string() << "\nexec "
                                   << path_of(program) << " \"$@\"\n";
    fs::permissions(shims / program, fs::perms::owner_all);
  }
  const std::string path = std::getenv("PATH");
  setenv("PATH", (shims.string() + ":" + path).c_str(), 1);
  const Answer answer = sent({"bench", "b.yaml", "--executor", "slurm", "--cells-per-task", "50"});
  ASSERT_EQ(answer.code, 0) << answer.out << answer.err;
  EXPECT_TRUE(contains(answer.out, std::to_string(cells) + " cells in " + std::to_string(cells / 50) + " tasks"))
      << answer.out;
  const auto done = [&] { return sent.results().size(); };
  const auto wait_for = [&](size_t wanted, int seconds) {
    for (int i = 0; i < 10 * seconds && done() < wanted; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    return done() >= wanted;
  };
  ASSERT_TRUE(wait_for(100, 120)) << done();
  ASSERT_LT(done(), cells) << "the node should die while there is work";
  EXPECT_EQ(cluster.script("kill-node", "2"), 0);
  const Answer status = sent({"bench", "b.yaml", "--status"});
  EXPECT_TRUE(contains(status.out, " of " + std::to_string(cells) + " cells"))
      << status.code << status.out << status.err;
  // Slurm holds what it requeues for two minutes; the test does not wait that long.
  setenv("PATH", path.c_str(), 1);
  for (int i = 0; i < 60 && !wait_for(cells, 3); ++i)
    if (std::system(
            "for job in $(squeue -h -t PD -o %i); do scontrol update jobid=$job starttime=now; done >/dev/null 2>&1"))
      continue;
  EXPECT_EQ(sent.results(), local.results());
  EXPECT_EQ(read_file(calls), "sbatch\n") << "one call of the scheduler, and none while waiting";
}

}  // namespace test_slurm
}  // namespace plumbline::test

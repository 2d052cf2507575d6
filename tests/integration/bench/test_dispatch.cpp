// Cells that run elsewhere: printed commands, GNU parallel, and tasks that run twice, late, or for another plan.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "bench_program.hpp"
#include "runtime/sweep/sweep_dispatch.hpp"

namespace plumbline::test {
namespace test_dispatch {

using testing::HasSubstr;
namespace fs = std::filesystem;

const std::string many = "seeds: 1-30\nalternatives: {method: {a: {}, b: {solver.with.factor: 2}}}\n";

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

/// Runs a printed command as a shell on another machine would.
int shell(const BenchProgram& program, const std::string& command) {
  return std::system(
      ("cd / && PLUMBLINE_PLUGIN_PATH=" + program.plugins().string() + " " + command + " >/dev/null").c_str());
}

TEST(Dispatch, PrintedCommandsDoTheWorkOfALocalRunBitByBit) {
  BenchProgram local, sent;
  for (const BenchProgram* program : {&local, &sent}) program->bench_file(many);
  local.run();
  const auto commands = lines_of(sent({"bench", "b.yaml", "--executor", "print", "--cells-per-task", "20"}).out);
  ASSERT_EQ(commands.size(), 3u);
  for (const std::string& command : commands) EXPECT_EQ(shell(sent, command), 0) << command;
  EXPECT_EQ(sent.results(), local.results());
  EXPECT_THAT(sent({"bench", "b.yaml", "--executor", "print"}).out, HasSubstr("nothing is left to do"));
  // A task that runs again changes nothing; one whose record got lost is the only one sent.
  EXPECT_EQ(shell(sent, commands[1]), 0);
  EXPECT_EQ(sent.results(), local.results());
  for (const auto& entry : fs::recursive_directory_iterator(sent.folder.path() / "store/cells"))
    if (entry.is_regular_file()) {
      fs::remove(entry.path());
      break;
    }
  EXPECT_EQ(lines_of(sent({"bench", "b.yaml", "--executor", "print", "--cells-per-task", "20"}).out).size(), 1u);
}

TEST(Dispatch, ATaskOfAnotherPlanIsRefused) {
  BenchProgram plumbline;
  plumbline.bench_file(many);
  const auto commands = lines_of(plumbline({"bench", "b.yaml", "--executor", "print"}).out);
  plumbline.bench_file("seeds: 1-30\nalternatives: {method: {a: {}, b: {solver.with.factor: 3}}}\n");
  EXPECT_NE(shell(plumbline, commands[0] + " 2>/dev/null"), 0);
  EXPECT_TRUE(plumbline.results().empty());
}

TEST(Dispatch, GnuParallelOnThisMachine) {
  if (std::system("parallel --version 2>/dev/null | grep -q 'GNU parallel'") != 0)
    GTEST_SKIP() << "GNU parallel is not installed (scripts/setup --tests)";
  BenchProgram local, sent;
  for (const BenchProgram* program : {&local, &sent}) program->bench_file(many);
  local.run();
  const Answer answer = sent({"bench", "b.yaml", "--executor", "ssh", "--hosts", ":", "--cells-per-task", "20"});
  EXPECT_EQ(answer.code, 0) << answer.out << answer.err;
  EXPECT_EQ(sent.results(), local.results());
}

TEST(Dispatch, AnArrayIsWrittenShort) {
  EXPECT_EQ(runtime::array_text({0, 1, 2, 5, 7, 8}), "0-2,5,7-8");
  EXPECT_EQ(runtime::array_text({4}), "4");
  EXPECT_EQ(runtime::shell_text({"a b", "it's", "plain=1"}), "'a b' 'it'\\''s' plain=1");
}

TEST(Dispatch, SshWithoutHostsAndSlurmWithoutSbatchSayWhatToDo) {
  BenchProgram plumbline;
  plumbline.bench_file(many);
  // A machine that has neither Slurm nor GNU parallel, and one that has the latter.
  const std::string path = std::getenv("PATH");
  const auto tools = plumbline.folder.path() / "tools";
  std::filesystem::create_directory(tools);
  setenv("PATH", tools.c_str(), 1);
  const Answer slurm = plumbline({"bench", "b.yaml", "--executor", "slurm"});
  const Answer ssh = plumbline({"bench", "b.yaml", "--executor", "ssh", "--hosts", ":"});
  std::ofstream(tools / "parallel") << "#!/bin/sh\necho GNU parallel\n";
  std::filesystem::permissions(tools / "parallel", std::filesystem::perms::owner_all);
  const Answer no_hosts = plumbline({"bench", "b.yaml", "--executor", "ssh"});
  setenv("PATH", path.c_str(), 1);
  for (const Answer& answer : {slurm, ssh, no_hosts}) EXPECT_EQ(answer.code, 1) << answer.out;
  EXPECT_THAT(slurm.err, HasSubstr("there is no program 'sbatch' here; install slurm-client, or use --executor print"));
  EXPECT_THAT(ssh.err, HasSubstr("install the package parallel, or use --executor print"));
  EXPECT_THAT(no_hosts.err, HasSubstr("--executor ssh needs --hosts"));
}

}  // namespace test_dispatch
}  // namespace plumbline::test

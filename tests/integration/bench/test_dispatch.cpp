// Cells that run elsewhere: printed commands, GNU parallel, and tasks that run twice, late, or for another plan.
#include "bench_program.hpp"
#include "runtime/sweep/sweep_dispatch.hpp"

namespace plumbline::test {
namespace {

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
  Answer answer = plumbline({"bench", "b.yaml", "--executor", "ssh"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_THAT(answer.err, testing::AnyOf(HasSubstr("--hosts"), HasSubstr("install the package parallel")));
}

}  // namespace
}  // namespace plumbline::test

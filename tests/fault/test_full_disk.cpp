// A disk that is full: a tmpfs of some kilobytes, in a mount namespace of its own.
#include <sched.h>
#include <sys/mount.h>
#include <sys/wait.h>

#include <fstream>

#include "../integration/cli/program.hpp"

namespace plumbline::test {
namespace test_full_disk {

namespace fs = std::filesystem;

/// Runs `body` in a child that may mount. False if this system does not allow it.
template <typename Body>
bool in_own_mounts(Body body) {
  const uid_t user = getuid();
  const gid_t group = getgid();
  const pid_t child = fork();
  if (child == 0) {
    const auto tell = [](const char* file, const std::string& text) { std::ofstream(file) << text; };
    if (unshare(CLONE_NEWUSER | CLONE_NEWNS) != 0) _exit(77);
    tell("/proc/self/setgroups", "deny");
    tell("/proc/self/uid_map", "0 " + std::to_string(user) + " 1");
    tell("/proc/self/gid_map", "0 " + std::to_string(group) + " 1");
    if (mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) _exit(77);
    body();
    _exit(testing::Test::HasFailure() ? 1 : 0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  if (WIFEXITED(status) && WEXITSTATUS(status) == 77) return false;
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << "see above";
  return true;
}

size_t entries(const fs::path& folder) {
  size_t count = 0;
  if (fs::exists(folder))
    for ([[maybe_unused]] const auto& entry : fs::directory_iterator(folder)) ++count;
  return count;
}

const std::string folder_pipeline =
    "plumbline: 1\nvars: {seed: 1}\nnodes:\n"
    "  s: {use: story.series, with: {values: [1, 2, 3, 4, 5, 6, 7, 8, 9]}}\n"
    "  q: {use: story.square, in: {number: s.numbers}}\n  w: {use: story.folder}\n"
    "outputs: {q.json: q.square, tree: w.folder}\n";

TEST(FullDisk, OfTheStoreIsNamedAndNothingHalfWrittenStays) {
  if (!in_own_mounts([] {
        for (const int kilobytes : {24, 48, 64, 96, 128}) {
          SCOPED_TRACE(kilobytes);
          const Program plumbline;
          plumbline.write("p.yaml", folder_pipeline);
          const fs::path disk = plumbline.folder.path() / "disk";
          fs::create_directory(disk);
          const auto size = [&](const std::string& text, unsigned long flags) {
            ASSERT_EQ(mount("none", disk.c_str(), "tmpfs", flags, ("mode=700,size=" + text).c_str()), 0);
          };
          size(std::to_string(kilobytes) + "k", 0);
          const std::vector<std::string> run = {"run", "p.yaml", "--store", (disk / "store").string()};
          Answer answer = plumbline(run);
          if (answer.code != 0) {
            EXPECT_EQ(answer.code, 1);
            EXPECT_TRUE(contains(answer.err, "No space left on device")) << answer.err;
            EXPECT_TRUE(contains(answer.err, "free some space or choose another store with --store")) << answer.err;
          }
          EXPECT_TRUE(kilobytes > 24 || answer.code == 1) << "this disk was to be too small";
          EXPECT_EQ(entries(disk / "store/tmp"), 0u);
          size("10m", MS_REMOUNT);
          answer = plumbline(run);
          EXPECT_EQ(answer.code, 0) << answer.err;
          EXPECT_TRUE(contains(read_file(plumbline.work() / "out/p/q.json"), "81"));
        }
      }))
    GTEST_SKIP() << "this system does not let tests mount a tmpfs";
}

TEST(FullDisk, OfTheOutputsIsNamedAndNothingHalfWrittenStays) {
  if (!in_own_mounts([] {
        const Program plumbline;
        plumbline.write("p.yaml",
                        "plumbline: 1\nnodes:\n  w: {use: story.folder, with: {text: " + std::string(50000, 'x') +
                            "}}\n  a: {use: story.constant}\noutputs: {a.json: a.number, tree: w.folder}\n");
        const fs::path disk = plumbline.folder.path() / "disk";
        fs::create_directory(disk);
        ASSERT_EQ(mount("none", disk.c_str(), "tmpfs", 0, "mode=700,size=128k"), 0);
        const std::vector<std::string> run = {"run", "p.yaml", "--out", (disk / "out").string()};
        const Answer answer = plumbline(run);
        EXPECT_EQ(answer.code, 1);
        EXPECT_TRUE(contains(answer.err, "No space left on device")) << answer.err;
        EXPECT_FALSE(fs::exists(disk / "out/tree"));
        for (const auto& entry : fs::directory_iterator(disk / "out"))
          EXPECT_TRUE(entry.path().filename() == "run.jsonl" || entry.path().filename() == "a.json") << entry.path();
      }))
    GTEST_SKIP() << "this system does not let tests mount a tmpfs";
}

/// The end of a run cannot be told, and a node does not listen: that is no reason to abort.
TEST(FullDisk, AnInterruptEndsTheProgramAllTheSame) {
  if (!in_own_mounts([] {
        const Program plumbline;
        const fs::path disk = plumbline.folder.path() / "disk", started = plumbline.work() / "started";
        plumbline.write("p.yaml", "plumbline: 1\nnodes:\n  d: {use: story.deaf, with: {started: " + started.string() +
                                      ", milliseconds: 60000}}\n");
        fs::create_directory(disk);
        ASSERT_EQ(mount("none", disk.c_str(), "tmpfs", 0, "mode=700,size=64k"), 0);
        const pid_t process = plumbline.start({"run", "p.yaml", "--out", (disk / "out").string()});
        for (int i = 0; i < 6000 && !fs::exists(started); ++i) usleep(5000);
        ASSERT_TRUE(fs::exists(started));
        const fs::path record = disk / "out/run.jsonl";
        // To the last byte: the record's own page as well.
        for (const fs::path& file : {disk / "full", record}) {
          std::ofstream stream(file, std::ios::app);
          while (stream.put(' ').flush()) continue;
        }
        kill(process, SIGINT);
        const Answer answer = plumbline.finish(process);
        EXPECT_EQ(answer.code, 130) << answer.err;
        EXPECT_TRUE(contains(answer.err, "No space left on device")) << answer.err;
      }))
    GTEST_SKIP() << "this system does not let tests mount a tmpfs";
}

TEST(FullDisk, AStoreThatCannotBeWrittenServesPlanAndShow) {
  if (!in_own_mounts([] {
        const Program plumbline;
        plumbline.write("p.yaml", chain);
        const fs::path disk = plumbline.folder.path() / "disk";
        fs::create_directory(disk);
        ASSERT_EQ(mount("none", disk.c_str(), "tmpfs", 0, "mode=700,size=10m"), 0);
        const std::string store = (disk / "store").string();
        ASSERT_EQ(plumbline({"run", "p.yaml", "--store", store}).code, 0);
        ASSERT_EQ(mount("none", disk.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, "mode=700,size=10m"), 0);
        Answer answer = plumbline({"plan", "p.yaml", "b.with.offset=3", "--store", store});
        EXPECT_EQ(answer.code, 0) << answer.err;
        EXPECT_TRUE(contains(answer.out, "parameter offset: 1 -> 3")) << answer.out;
        answer = plumbline({"show", "out/p/run.jsonl:b.sum", "--store", store});
        EXPECT_EQ(answer.code, 0) << answer.err;
        EXPECT_TRUE(contains(answer.out, "4")) << answer.out;
        EXPECT_EQ(plumbline({"cache", "--store", store}).code, 0);
        answer = plumbline({"run", "p.yaml", "--store", store});
        EXPECT_EQ(answer.code, 1);
        EXPECT_TRUE(contains(answer.err, "Read-only file system") && contains(answer.err, "--store")) << answer.err;
      }))
    GTEST_SKIP() << "this system does not let tests mount a tmpfs";
}

TEST(FullDisk, OfStandardOutputIsNoSuccess) {
  const Program plumbline;
  plumbline.write("p.yaml", chain);
  ASSERT_EQ(plumbline({"run", "p.yaml"}).code, 0);
  for (const std::string words : {"list", "show out/p/run.jsonl:b.sum", "describe story.add", "schema", "cache"}) {
    const std::string command = "cd '" + plumbline.work().string() + "' && PLUMBLINE_PLUGIN_PATH='" +
                                fs::path(PLUMBLINE_STORY_PLUGIN).parent_path().string() + "' PLUMBLINE_STORE='" +
                                (plumbline.folder.path() / "store").string() + "' '" +
                                (plumbline.folder.path() / "bin/plumbline").string() + "' " + words +
                                " > /dev/full 2> err";
    const int status = std::system(command.c_str());
    EXPECT_EQ(WEXITSTATUS(status), 1) << words;
    EXPECT_TRUE(contains(read_file(plumbline.work() / "err"), "cannot write to standard output")) << words;
  }
}

}  // namespace test_full_disk
}  // namespace plumbline::test

// Random faults over a pipeline with parallel branches: after each of them the next run ends in the results of a run
// that nothing happened to, nothing half-written is visible, and nothing temporary stays.
//
// Some twenty faults always, 420 with PLUMBLINE_LONG. PLUMBLINE_DRILL=seed repeats one drill.
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <map>
#include <random>
#include <thread>

#include "../integration/cli/program.hpp"

namespace plumbline::test {
namespace test_drill {

namespace fs = std::filesystem;

const char* const pipeline =
    "plumbline: 1\n"
    "vars: {seed: 4}\n"
    "nodes:\n"
    "  s: {use: story.series, with: {values: [1, 2, 3, 4, 5, 6, 7, 8]}}\n"
    "  q: {use: story.square, in: {number: s.numbers}}\n"
    "  d: {use: story.draw_each, in: {number: q.square}}\n"
    "  t: {use: story.sum, in: {numbers: d.number}}\n"
    "  w: {use: story.folder, with: {text: some text in a folder}}\n"
    "  r: {use: story.read, in: {folder: w.folder}}\n"
    "  l1: {use: story.logs, in: {after: s1.sum}, with: {log: /dev/null, milliseconds: 40, value: 5}}\n"
    "  l2: {use: story.logs, with: {log: /dev/null, milliseconds: 20, value: 6}}\n"
    "  s1: {use: story.add, in: {a: l2.number}}\n"
    "  sum: {use: story.add, in: {a: l1.number, b: r.number}}\n"
    "outputs: {t.json: t.sum, tree: w.folder, numbers/sum.json: sum.sum, numbers/squares.json: q.square}\n";

/// Content of every file of the outputs.
std::map<std::string, std::string> outputs(const fs::path& out) {
  std::map<std::string, std::string> all;
  if (!fs::exists(out)) return all;
  for (const auto& entry : fs::recursive_directory_iterator(out))
    if (entry.is_regular_file() && entry.path().filename() != "run.jsonl")
      all[entry.path().lexically_relative(out).string()] = read_file(entry.path());
  return all;
}

class Drill {
 public:
  explicit Drill(unsigned seed) : random_(seed) {
    program_.write("p.yaml", pipeline);
    const Answer answer = program_({"run", "p.yaml", "--out", "clean", "--store", (work() / "clean-store").string()});
    if (answer.code != 0) throw std::runtime_error(answer.err);
    clean_ = outputs(work() / "clean");
  }

  /// Makes one fault and mends nothing. Returns what it was.
  std::string fault() {
    switch (pick(7)) {
      case 0:
        return kill_it();
      case 1:
        return stop_it();
      case 2:
        return limit_files();
      case 3:
        return corrupt();
      case 4:
        return remove();
      case 5:
        return vanish();
      default:
        return late_file();
    }
  }

  void expect_clean_rerun(const std::string& fault) {
    SCOPED_TRACE(fault);
    const Answer answer = program_({"run", "p.yaml", "--out", "out", "--threads", std::to_string(1 + pick(3))});
    ASSERT_EQ(answer.code, 0) << answer.out << answer.err;
    EXPECT_EQ(outputs(work() / "out"), clean_);
    for (const auto& entry : fs::directory_iterator(work() / "out"))
      EXPECT_NE(entry.path().filename().string()[0], '.') << entry.path();
    EXPECT_TRUE(fs::is_empty(store() / "tmp")) << fs::directory_iterator(store() / "tmp")->path();
  }

 private:
  size_t pick(size_t count) { return random_() % count; }
  fs::path work() const { return program_.work(); }
  fs::path store() const { return program_.folder.path() / "store"; }
  void sleep_up_to(size_t milliseconds) { std::this_thread::sleep_for(std::chrono::milliseconds(pick(milliseconds))); }

  /// Half of the times there is something to do.
  void forget_results() {
    std::error_code ignored;
    if (pick(2)) fs::remove_all(store() / "runs", ignored);
  }
  pid_t start() { return program_.start({"run", "p.yaml", "--out", "out", "--threads", std::to_string(1 + pick(3))}); }

  std::string kill_it() {
    forget_results();
    const pid_t process = start();
    sleep_up_to(250);
    kill(process, SIGKILL);
    program_.finish(process);
    return "killed";
  }

  std::string stop_it() {
    forget_results();
    const pid_t process = start();
    sleep_up_to(250);
    kill(process, SIGSTOP);
    // Another run on the same store goes on meanwhile.
    const Program other;
    other.write("p.yaml", pipeline);
    const Answer answer = other({"run", "p.yaml", "--out", "out", "--store", store().string()});
    EXPECT_EQ(answer.code, 0) << answer.err;
    EXPECT_EQ(outputs(other.work() / "out"), clean_);
    kill(process, pick(2) ? SIGKILL : SIGCONT);
    program_.finish(process);
    return "stopped";
  }

  /// No file may grow beyond some bytes: writes fail in the middle, as on a full disk (a real one: test_full_disk.cpp).
  std::string limit_files() {
    forget_results();
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit tight{static_cast<rlim_t>(20 + pick(3000)), before.rlim_max};
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &tight);
    const pid_t process = start();
    setrlimit(RLIMIT_FSIZE, &before);
    signal(SIGXFSZ, SIG_DFL);
    const int code = program_.finish(process).code;
    EXPECT_TRUE(code == 0 || code == 1) << code;
    return "full";
  }

  fs::path some_file() {
    std::vector<fs::path> files;
    if (fs::exists(store()))
      for (const auto& entry : fs::recursive_directory_iterator(store()))
        if (entry.is_regular_file()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files.empty() ? fs::path() : files[pick(files.size())];
  }

  std::string corrupt() {
    const fs::path file = some_file();
    if (file.empty()) return "nothing to corrupt";
    std::string text = read_file(file);
    switch (pick(3)) {
      case 0:
        text.resize(pick(text.size() + 1));
        break;
      case 1:
        if (!text.empty()) text[pick(text.size())] = static_cast<char>(pick(256));
        break;
      default:
        text.insert(pick(text.size() + 1), std::string(1 + pick(40), static_cast<char>(pick(256))));
    }
    std::ofstream(file, std::ios::binary) << text;
    return "corrupted " + file.lexically_relative(store()).string();
  }

  std::string remove() {
    const fs::path file = some_file();
    if (file.empty()) return "nothing to remove";
    fs::remove(file);
    return "removed " + file.lexically_relative(store()).string();
  }

  /// Somebody clears up while a run is at work or begins; that one may fail, with words.
  std::string vanish() {
    const pid_t process = start();
    sleep_up_to(150);
    const fs::path places[] = {store() / "blobs",       store() / "runs",        store() / "folders",
                               store() / "file-hashes", work() / "out" / "tree", store()};
    const fs::path gone = places[pick(std::size(places))];
    std::error_code ignored;
    fs::remove_all(gone, ignored);
    const Answer answer = program_.finish(process);
    const bool told = (answer.code == 1 || answer.code == 2) && !answer.err.empty();
    EXPECT_TRUE(answer.code == 0 || told) << answer.code << answer.err;
    return "vanished: " + gone.filename().string();
  }

  std::string late_file() {
    const fs::path file = some_file();
    if (file.empty()) return "nothing to hide";
    const fs::path hidden = program_.folder.path() / "hidden";
    std::error_code gone;
    fs::rename(file, hidden, gone);
    const pid_t process = start();
    sleep_up_to(100);
    if (!gone && fs::exists(file.parent_path())) fs::rename(hidden, file, gone);
    EXPECT_EQ(program_.finish(process).code, 0);
    return "late: " + file.lexically_relative(store()).string();
  }

  std::mt19937 random_;
  const Program program_;
  std::map<std::string, std::string> clean_;
};

TEST(Drill, EveryRerunEndsInTheCleanResults) {
  const char* repeat = std::getenv("PLUMBLINE_DRILL");
  const unsigned first = repeat ? static_cast<unsigned>(std::stoul(repeat)) : 1;
  const unsigned drills = repeat ? 1 : std::getenv("PLUMBLINE_LONG") ? 42 : 2;
  for (unsigned seed = first; seed < first + drills; ++seed) {
    SCOPED_TRACE("PLUMBLINE_DRILL=" + std::to_string(seed));
    Drill drill(seed);
    for (int i = 0; i < 10 && !testing::Test::HasFailure(); ++i) drill.expect_clean_rerun(drill.fault());
  }
}

}  // namespace test_drill
}  // namespace plumbline::test

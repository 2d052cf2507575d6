#include <sys/stat.h>
#include <unistd.h>

#include <functional>
#include <nlohmann/json.hpp>
#include <random>
#include <sstream>

#include "runtime/base/digest.hpp"
#include "runtime/graph/output_name.hpp"
#include "runtime/record/journal_guard.hpp"
#include "story.hpp"

namespace plumbline::test {
namespace test_deliver {

namespace fs = std::filesystem;

std::string sha(const std::string& text) { return runtime::sha256_of(text.data(), text.size()); }

/// As `plumbline run` does it: refused is told by the one delivery "refused".
std::vector<runtime::Delivery> deliver(Story& story, bool overwrite = false) {
  runtime::OutputFolder out(story.folder.path() / "out", story.store->file_hashes(), overwrite);
  if (const auto obstacles = obstacles_to(story.graph, out); !obstacles.empty()) {
    std::string all;
    for (const std::string& text : obstacles) all += text + "\n";
    return {{"refused", all, ""}};
  }
  runtime::Record record(out, story.graph, {});
  auto deliveries = runtime::deliver(story.graph, *story.store, story.result, out);
  record.end(story.result, deliveries);
  return deliveries;
}

/// With the reports of both runs together one that was told first is the second to tell, and is taken otherwise: it is
/// there all the same.
TEST(JournalGuard, AReportThatIsTakenOtherwiseIsNotLost) {
  const auto line = [](const std::string& by, const std::string& at, const std::string& to) {
    return nlohmann::json{{"kind", "bracket"}, {"item", "b1"}, {"to", to}, {"by", by}, {"at", at}}.dump() + "\n";
  };
  const std::string first = line("robot-2", "t2", "PLANNED");
  std::istringstream there(first), both(line("robot-1", "t1", "INSTALLED") + line("robot-2", "t2", "REJECTED"));
  EXPECT_TRUE(runtime::missing_reports(there, both).empty());
  std::istringstream again(first), other(line("robot-1", "t1", "INSTALLED"));
  EXPECT_EQ(runtime::missing_reports(again, other), std::vector<std::string>{"b1 by robot-2 at t2"});
}

/// What has no date of its own has that of the run: run again a quarter of an hour later, a round has the same reports.
TEST(JournalGuard, AReportThatHasTheDateOfTheRunIsThereWhenTheRoundIsRunAgain) {
  const auto line = [](const std::string& at, const std::string& file) {
    return R"({"kind":"bracket","item":"b1","by":"a person","at":")" + at +
           R"(","round":2,"why":"accepted","rests_on":[")" + file + "\"]}\n";
  };
  std::istringstream there(line("16:00", "aa")), later(line("16:20", "aa")), again(line("16:00", "aa")),
      other(line("16:20", "bb"));
  EXPECT_TRUE(runtime::missing_reports(there, later).empty());
  EXPECT_EQ(runtime::missing_reports(again, other).size(), 1u) << "of another file";
}

TEST(Deliver, ArtifactsAsJsonListsAsArraysFoldersAsTrees) {
  Story story("a: {use: story.constant, with: {value: 2.5}}\ns: {use: story.series}\nw: {use: story.folder}",
              "outputs: {one.json: a.number, sub/all.json: s.numbers, tree: w.folder, tree.json: w.folder}");
  story.run();
  for (const auto& delivery : deliver(story)) EXPECT_EQ(delivery.problem, "") << delivery.file;
  const fs::path out = story.folder.path() / "out";
  EXPECT_EQ(nlohmann::json::parse(read_file(out / "one.json")), (nlohmann::json{{"value", 2.5}}));
  EXPECT_EQ(nlohmann::json::parse(read_file(out / "sub/all.json")).size(), 3u);
  EXPECT_EQ(read_file(out / "tree" / "a.txt"), "hello");
  EXPECT_EQ(nlohmann::json::parse(read_file(out / "tree.json")).at("files").size(), 1u);
}

TEST(Deliver, ReplacesWhatAnEarlierRunLeft) {
  Story story("w: {use: story.folder}\na: {use: story.constant}", "outputs: {tree: w.folder, sub/a.json: a.number}");
  story.run();
  deliver(story);
  story.run({"w.with.text=new", "a.with.value=7"});
  for (const auto& delivery : deliver(story)) EXPECT_EQ(delivery.problem + delivery.note, "") << delivery.file;
  const fs::path out = story.folder.path() / "out";
  EXPECT_EQ(read_file(out / "tree" / "a.txt"), "new");
  EXPECT_EQ(nlohmann::json::parse(read_file(out / "sub/a.json")).at("value"), 7);
}

TEST(Deliver, WhatIsNotProvedToBeItsOwnIsRefusedByName) {
  const std::string nodes = "w: {use: story.folder}\na: {use: story.constant}";
  const std::string outputs = "outputs: {tree: w.folder, sub/a.json: a.number}";
  const std::vector<std::pair<std::string, std::function<void(const fs::path&)>>> cases = {
      {"out/sub/a.json was not written by a run",
       [](const fs::path& out) {
         fs::remove_all(out);
         fs::create_directories(out / "sub");
         std::ofstream(out / "sub/a.json") << "mine";
       }},
      {"out/sub/a.json was changed", [](const fs::path& out) { std::ofstream(out / "sub/a.json") << "edited"; }},
      {"out/tree/a.txt was changed", [](const fs::path& out) { std::ofstream(out / "tree/a.txt") << "jello"; }},
      {"out/tree/b.txt was not written", [](const fs::path& out) { std::ofstream(out / "tree/b.txt") << "note"; }},
      {"out/tree/empty is a folder that no run made",
       [](const fs::path& out) { fs::create_directory(out / "tree/empty"); }},
      {"out/sub/a.json is a link",
       [](const fs::path& out) {
         fs::rename(out / "sub/a.json", out / "moved.json");
         fs::create_symlink("../moved.json", out / "sub/a.json");
       }},
      {"out/tree is a link",
       [](const fs::path& out) {
         fs::rename(out / "tree", out / "moved");
         fs::create_directory_symlink("moved", out / "tree");
       }},
      {"out/sub must be a folder",
       [](const fs::path& out) {
         fs::rename(out / "sub", out / "moved");
         fs::create_directory_symlink("moved", out / "sub");
       }},
      {"out/sub/a.json is a folder",
       [](const fs::path& out) {
         fs::remove(out / "sub/a.json");
         fs::create_directories(out / "sub/a.json/deep");
       }},
      {"out/sub/a.json is no regular file",
       [](const fs::path& out) {
         fs::remove(out / "sub/a.json");
         ASSERT_EQ(mkfifo((out / "sub/a.json").c_str(), 0600), 0);
       }},
  };
  for (const auto& [words, spoil] : cases) {
    SCOPED_TRACE(words);
    Story story(nodes, outputs);
    story.run();
    ASSERT_EQ(deliver(story).size(), 2u);
    spoil(story.folder.path() / "out");
    story.run({"w.with.text=new", "a.with.value=7"});
    const auto answer = deliver(story);
    ASSERT_EQ(answer.at(0).file, "refused");
    EXPECT_NE(answer[0].problem.find(words), std::string::npos) << answer[0].problem;
  }
}

TEST(Deliver, OverwriteReplacesWhatIsInTheWayAndNothingElse) {
  Story story("w: {use: story.folder}\na: {use: story.constant}", "outputs: {tree: w.folder, a.json: a.number}");
  story.run();
  const fs::path out = story.folder.path() / "out";
  fs::create_directories(out / "tree");
  std::ofstream(out / "tree/a.txt") << "mine";
  std::ofstream(out / "tree/notes.txt") << "notes";
  std::ofstream(story.folder.path() / "elsewhere") << "elsewhere";
  fs::create_symlink("../elsewhere", out / "a.json");
  EXPECT_EQ(deliver(story).at(0).file, "refused");
  const auto deliveries = deliver(story, true);
  EXPECT_EQ(deliveries.at(0).problem + deliveries.at(1).problem, "");
  EXPECT_EQ(deliveries[0].note,
            "1 file in " + (out / "tree").string() + " that no run wrote stays there beside the output's own");
  EXPECT_EQ(read_file(out / "tree/a.txt"), "hello");
  EXPECT_EQ(read_file(out / "tree/notes.txt"), "notes");
  EXPECT_EQ(read_file(story.folder.path() / "elsewhere"), "elsewhere") << "it wrote through a link";
  EXPECT_FALSE(fs::is_symlink(out / "a.json"));
}

TEST(Deliver, TheProofOutlivesAKilledRunAndARunOfAnotherPipeline) {
  Story story("w: {use: story.folder}\na: {use: story.constant}", "outputs: {tree: w.folder, a.json: a.number}");
  story.run();
  deliver(story);
  const fs::path out = story.folder.path() / "out";
  {  // killed before its end: no run_end
    runtime::OutputFolder folder(out, story.store->file_hashes());
    runtime::Record record(folder, story.graph, {});
  }
  story.tell("c: {use: story.constant}", "outputs: {c.json: c.number}");
  story.run();
  EXPECT_EQ(deliver(story).at(0).problem, "");
  story.tell("w: {use: story.folder, with: {text: new}}\na: {use: story.constant, with: {value: 2}}",
             "outputs: {tree: w.folder, a.json: a.number}");
  story.run();
  for (const auto& delivery : deliver(story)) EXPECT_EQ(delivery.problem, "");
  EXPECT_EQ(read_file(out / "tree/a.txt"), "new");
}

TEST(Deliver, WhatAKilledRunWasWritingIsPutAway) {
  Story story("w: {use: story.folder}", "outputs: {tree: w.folder}");
  story.run();
  deliver(story);
  const fs::path out = story.folder.path() / "out";
  fs::path staging;
  {
    runtime::OutputFolder folder(out, story.store->file_hashes());
    runtime::Record record(folder, story.graph, {});
    staging = out / folder.staging_name();
    folder.append(R"({"event":"deliver","output":"tree","number":1,"files":{"tree/a.txt":")" + std::string(64, 'a') +
                  R"("},"folders":[]})");
  }
  // As if killed between the two renames: the old tree is away, with a file that somebody wrote just then.
  fs::create_directories(staging / "new-1/sub");
  std::ofstream(staging / "new-1/sub/half") << "hal";
  fs::rename(out / "tree", staging / "old-1");
  std::ofstream(staging / "old-1/mine.txt") << "mine";
  std::ofstream(out / ".run.jsonl.new") << "";
  { const runtime::OutputFolder folder(out, story.store->file_hashes()); }
  std::vector<std::string> found;
  for (const auto& entry : fs::recursive_directory_iterator(out))
    found.push_back(entry.path().lexically_relative(out).string());
  std::sort(found.begin(), found.end());
  EXPECT_EQ(found, (std::vector<std::string>{"run.jsonl", "tree", "tree/mine.txt"}));
}

TEST(Deliver, TwoRunsIntoOneFolderAreRefused) {
  Story story("a: {use: story.constant}", "outputs: {a.json: a.number}");
  story.run();
  const fs::path out = story.folder.path() / "out";
  {
    runtime::OutputFolder first(out, story.store->file_hashes());
    runtime::Record record(first, story.graph, {});
    try {
      runtime::OutputFolder second(out, story.store->file_hashes());
      FAIL() << "both have the folder";
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find("process " + std::to_string(getpid())), std::string::npos)
          << error.what();
      EXPECT_NE(std::string(error.what()).find("--out"), std::string::npos) << error.what();
    }
  }
  EXPECT_EQ(deliver(story).at(0).problem, "");
}

TEST(Deliver, AFileNamedAsTheRecordIsNotReplaced) {
  Story story("a: {use: story.constant}", "outputs: {a.json: a.number}");
  story.run();
  const fs::path out = story.folder.path() / "out";
  fs::create_directories(out);
  std::ofstream(out / "run.jsonl") << "{\"my\": \"notes\"}\n";
  EXPECT_THROW(deliver(story), std::runtime_error);
  EXPECT_EQ(read_file(out / "run.jsonl"), "{\"my\": \"notes\"}\n");
  fs::remove(out / "run.jsonl");
  fs::create_symlink("nowhere", out / "run.jsonl");
  EXPECT_THROW(deliver(story), std::runtime_error);
  EXPECT_TRUE(fs::is_symlink(out / "run.jsonl"));
}

TEST(Deliver, NamesThatAreNoPlacesUnderTheFolderAreRefused) {
  for (const std::string name : {".", "./", "", "/", "/a", "..", "a/..", "../a", "a/./b", "a//b", "a/", "./a",
                                 "run.jsonl", "run.jsonl/a", ".run.jsonl.new", ".plumbline-0/a", "a\nb"})
    EXPECT_NE(runtime::output_name_problem(name), "") << name;
  for (const std::string name : {"a", "a..b.json", ".hidden", "a/b/c.csv", "été.json", "sub/run.jsonl"})
    EXPECT_EQ(runtime::output_name_problem(name), "") << name;
  Story story("w: {use: story.folder}\na: {use: story.constant}", "outputs: {tree: w.folder, tree/a.json: a.number}");
  EXPECT_THROW(story.run(), runtime::InvalidPipeline) << "one output inside another";
  story.tell("w: {use: story.folder}", "outputs: {.: w.folder}");
  EXPECT_THROW(story.run(), runtime::InvalidPipeline);
}

TEST(Deliver, WhatFailedIsAbsentAndTheRestIsThere) {
  Story story("a: {use: story.add, in: {a: c.number}}\nc: {use: story.constant}\nd: {use: story.constant}",
              "outputs: {a.json: a.sum, d.json: d.number}");
  story.run();
  deliver(story);
  ASSERT_TRUE(fs::exists(story.folder.path() / "out" / "a.json"));
  story.tell("c: {use: story.throws}\na: {use: story.add, in: {a: c.number}}\nd: {use: story.constant}",
             "outputs: {a.json: a.sum, d.json: d.number}");
  story.run();
  const auto deliveries = deliver(story);
  EXPECT_EQ(deliveries.at(0).problem, "'a' did not run because 'c' failed");
  EXPECT_EQ(deliveries.at(1).problem, "");
  EXPECT_FALSE(fs::exists(story.folder.path() / "out" / "a.json")) << "an old result would be taken for a new one";
  EXPECT_TRUE(fs::exists(story.folder.path() / "out" / "d.json"));
}

TEST(Deliver, LeavesAFolderThatIsThereAlready) {
  Story story("w: {use: story.folder}", "outputs: {tree: w.folder}");
  const fs::path file = story.folder.path() / "out" / "tree" / "a.txt";
  story.run();
  deliver(story);
  struct stat before {
  }, after{};
  stat(file.c_str(), &before);
  deliver(story);
  stat(file.c_str(), &after);
  EXPECT_EQ(before.st_ino, after.st_ino) << "it was copied again";
}

TEST(Deliver, AFileThatAnArtifactNamesIsCopiedAndHasToBeWhatItWas) {
  Story story("w: {use: story.file}", "outputs: {a.txt: w.file}");
  const fs::path file = story.folder.path() / "out" / "a.txt";
  story.run();
  for (const auto& delivery : deliver(story)) EXPECT_EQ(delivery.problem, "");
  EXPECT_EQ(read_file(file), "hello");
  story.run({"w.with.text=new"});
  for (const auto& entry : fs::recursive_directory_iterator(story.store->folder() / "folders"))
    if (entry.path().filename() == "inside") std::ofstream(entry.path()) << "tampered";
  EXPECT_NE(deliver(story).at(0).problem.find("inside has changed since it was read"), std::string::npos);
  EXPECT_FALSE(fs::exists(file)) << "what was delivered before is not of this run";
  story.run({"w.with.text=new"});
  EXPECT_EQ(story.executed(), "w") << "the store found out";
  deliver(story);
  EXPECT_EQ(read_file(file), "new");
}

TEST(Deliver, DoesNotWriteAgainWhatIsThere) {
  Story story("s: {use: story.series}\nw: {use: story.folder}", "outputs: {s.json: s.numbers, tree: w.folder}");
  const fs::path file = story.folder.path() / "out" / "s.json";
  story.run();
  deliver(story);
  struct stat before {
  }, after{};
  stat(file.c_str(), &before);
  story.run({"w.with.text=new"});
  deliver(story);
  stat(file.c_str(), &after);
  EXPECT_EQ(before.st_ino, after.st_ino) << "it was written again";
  story.run({"s.with.values=[4]"});
  deliver(story);
  EXPECT_EQ(nlohmann::json::parse(read_file(file)).size(), 1u);
}

/// Between two outputs there is time to stop; what is not written is left as it was, and the record says of whom.
TEST(Deliver, StoppedItBeginsNoOtherOutput) {
  Story story("a: {use: story.constant}\nb: {use: story.constant, with: {value: 2}}",
              "outputs: {a.json: a.number, b.json: b.number}");
  story.run();
  deliver(story);
  const std::string before = read_file(story.folder.path() / "out/b.json");
  story.run({"a.with.value=7", "b.with.value=8"});
  const std::atomic<bool> stop = true;
  runtime::OutputFolder out(story.folder.path() / "out", story.store->file_hashes(), false);
  runtime::Record record(out, story.graph, {"0.0", {"b.with.value=8"}, {}, 1, 0});
  for (const auto& delivery : runtime::deliver(story.graph, *story.store, story.result, out, &stop))
    EXPECT_EQ(delivery.problem, "the run was stopped before it was written") << delivery.file;
  EXPECT_EQ(read_file(story.folder.path() / "out/b.json"), before);
  EXPECT_TRUE(out.owned().origins.at("b.json").arguments.empty()) << "it is still of the run before";
  EXPECT_FALSE(out.is_of_this_run("b.json"));
}

TEST(Deliver, LeavesNoTemporaryNames) {
  Story story("w: {use: story.folder}\na: {use: story.constant}", "outputs: {tree: w.folder, a.json: a.number}");
  story.run();
  deliver(story);
  for (const auto& entry : fs::recursive_directory_iterator(story.folder.path() / "out"))
    EXPECT_NE(entry.path().filename().string()[0], '.') << entry.path();
}

TEST(Deliver, AFileInTheWayIsAnError) {
  Story story("a: {use: story.constant}", "outputs: {a.json: a.number}");
  story.run();
  std::ofstream(story.folder.path() / "out") << "a file";
  EXPECT_THROW(deliver(story), std::runtime_error);
}

/// Everything below a folder: path -> content of a file, target of a link, or "folder".
std::map<std::string, std::string> snapshot(const fs::path& folder) {
  std::map<std::string, std::string> all;
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    const std::string path = entry.path().lexically_relative(folder).string();
    all[path] = entry.is_symlink()     ? "link to " + fs::read_symlink(entry).string()
                : entry.is_directory() ? "folder"
                                       : "file of " + read_file(entry);
  }
  return all;
}

/// Property: whatever lies in the folder, and whatever pipelines are run into it one after the other, what the program
/// did not write is there afterwards, byte for byte, and nothing of its own is left lying about.
TEST(Deliver, WhatTheProgramDidNotWriteIsStillThere) {
  const char* paths[] = {"a.json", "tree",  "tree/a.txt", "tree/b.txt", "tree/sub/c.txt", "sub",   "sub/a.json",
                         "sub/b",  "other", "other/x",    "run.jsonl",  ".run.jsonl.new", "files", "files/a.txt"};
  const char* outputs[] = {"{a.json: a.number, tree: w.folder}",          "{sub/a.json: a.number, other: w.folder}",
                           "{tree: a.number, a.json: w.folder}",          "{sub: w.folder, tree/sub/c.txt: a.number}",
                           "{tree/sub: w.folder, files/a.txt: a.number}", "{sub/b: w.folder, other/x: x.number}"};
  const unsigned trials = std::getenv("PLUMBLINE_LONG") ? 1000 : 20;
  for (unsigned trial = 0; trial < trials; ++trial) {
    std::mt19937 random(trial);
    const auto pick = [&](size_t count) { return random() % count; };
    Story story("a: {use: story.constant}");
    const fs::path out = story.folder.path() / "out";
    fs::create_directories(out);
    for (int step = 0; step < 8; ++step) {
      if (pick(3) == 0) {  // the user puts something there or edits it
        const std::string path = paths[pick(std::size(paths))];
        std::error_code error;
        fs::create_directories((out / path).parent_path(), error);
        const bool is_folder = fs::is_directory(fs::symlink_status(out / path));
        switch (pick(3)) {
          case 0:
            if (!is_folder) std::ofstream(out / path) << "mine " << step;
            break;
          case 1:
            if (!fs::exists(fs::symlink_status(out / path))) fs::create_symlink("/nowhere", out / path, error);
            break;
          default:
            fs::create_directories(out / path, error);
        }
      }
      const auto before = snapshot(out);
      story.tell("a: {use: story.constant, with: {value: " + std::to_string(pick(3)) + "}}\nx: {use: story." +
                     (pick(3) ? "constant" : "throws") + "}\nw: {use: story.folder, with: {text: t" +
                     std::to_string(pick(3)) + "}}",
                 std::string("outputs: ") + outputs[pick(std::size(outputs))]);
      story.run();
      std::map<std::string, std::set<std::string>> proved;  // by the record that is there now
      bool refused = false;
      {
        std::set<std::string> folders;
        try {
          const runtime::OutputFolder folder(out, story.store->file_hashes());
          proved = folder.owned().files;
          folders = folder.owned().folders;
        } catch (const std::runtime_error&) {
        }
        try {
          refused = deliver(story).at(0).file == "refused";
        } catch (const std::runtime_error&) {  // the record's place is taken
          refused = true;
        }
        const auto after = snapshot(out);
        if (refused) {
          EXPECT_EQ(before, after) << "trial " << trial << " step " << step;
        }
        for (const auto& [path, content] : before) {
          if (path == "run.jsonl" && content.rfind("file of {\"event\":\"run_start\"", 0) == 0) continue;
          const bool own = content == "folder" ? folders.count(path) > 0
                                               : content.rfind("file of ", 0) == 0 && proved.count(path) > 0 &&
                                                     proved[path].count(sha(content.substr(8))) > 0;
          if (own) continue;
          const auto found = after.find(path);
          ASSERT_TRUE(found != after.end() && found->second == content)
              << "trial " << trial << " step " << step << ": " << path << " was " << content;
        }
        for (const auto& [path, content] : after)
          EXPECT_TRUE(path.find(".plumbline-") == std::string::npos) << "trial " << trial << ": " << path;
      }
    }
  }
}

}  // namespace test_deliver
}  // namespace plumbline::test

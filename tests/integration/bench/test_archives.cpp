// What a bench leaves for others: its record, its archive, and cells that are made again.
#include "bench_program.hpp"
#include "runtime/base/digest.hpp"
#include "runtime/sweep/sweep_archive.hpp"

namespace plumbline::test {
namespace test_archives {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;
using Json = nlohmann::json;

/// What ran is in the record, not only the file that asked for it.
TEST(Bench, TheRecordHasThePipelinesTheCommitAndTheLibraries) {
  BenchProgram plumbline;
  plumbline.write("part.yaml", "plumbline: 1\nnodes:\n  site: {use: story.draw}\n");
  plumbline.write(
      "other.yaml",
      "plumbline: 1\ninclude: [part.yaml]\nvars: {seed: 1}\nnodes:\n  solver: {use: trial.plain, in: {site: "
      "site.number}}\n");
  plumbline.bench_file("seeds: 1-2\nalternatives: {method: {plain: {}, other: {pipeline: other.yaml}}}\n");
  plumbline.run();
  const std::string record = read_file(plumbline.work() / "out/b/run.jsonl");
  const Json start = Json::parse(record.substr(0, record.find('\n')));
  std::set<std::string> names;
  for (const Json& source : start["sources"]) names.insert(fs::path(source["path"].get<std::string>()).filename());
  EXPECT_EQ(names, (std::set<std::string>{"b.yaml", "trial.yaml", "other.yaml", "part.yaml"}));
  const std::string machine = plumbline.summary()["machine"].dump();
  EXPECT_THAT(machine, HasSubstr(", commit "));
  EXPECT_THAT(machine, HasSubstr("GNU "));
  EXPECT_THAT(machine, HasSubstr("libtbb.so."));
}

/// Cells run in workers: what these load the program that submits them has not. Once a bench that ran Ceres named no
/// library of it.
TEST(Bench, TheLibrariesThatCellsComputeWithAreInTheRecordAndTheArchive) {
  BenchProgram plumbline(
      {PLUMBLINE_STORY_PLUGIN, PLUMBLINE_TRIAL_PLUGIN, PLUMBLINE_BENCH_PLUGIN, PLUMBLINE_OUTSIDE_PLUGIN});
  plumbline.bench_file("seeds: 1-2\nalternatives: {solver: [trial.plain, outside.solver]}\n");
  plumbline.run({"--archive", "both"});
  const auto machine_of = [&](const std::string& archive) {
    return Json::parse(read_file(plumbline.work() / archive / "archive.json"))["machine"];
  };
  EXPECT_THAT(machine_of("both")["libraries"].dump(), HasSubstr("\"libtrial_behind.so.1.2.3\""));
  EXPECT_THAT(machine_of("both")["plugins"].dump(), HasSubstr("\"libtrial_behind.so.1:"));
  EXPECT_THAT(plumbline.summary()["machine"].dump(), HasSubstr("libtrial_behind.so.1.2.3"));
  plumbline.bench_file("seeds: 1-2\nalternatives: {solver: [trial.plain]}\n");
  plumbline.run({"--archive", "one"});
  EXPECT_THAT(machine_of("one").dump(), Not(HasSubstr("libtrial_behind"))) << "nothing computed with it";
}

/// Of an archive alone nobody sees what it lacks, nor why a cell failed now that failed before.
TEST(Bench, AnArchiveSaysWhatItLacksAndVerifyWhatIsNotTheSame) {
  BenchProgram plumbline(
      {PLUMBLINE_STORY_PLUGIN, PLUMBLINE_TRIAL_PLUGIN, PLUMBLINE_BENCH_PLUGIN, PLUMBLINE_OUTSIDE_PLUGIN});
  plumbline.bench_file("seeds: 1-8\nalternatives: {solver: [trial.plain, outside.solver]}\n");
  plumbline.run({"--seeds", "1-3"});
  const Answer part = plumbline({"bench", "b.yaml", "--status", "--out", "out/s", "--archive", "part"});
  EXPECT_THAT(part.err, HasSubstr("part lacks 10 of 16 cells, which have not run"));
  EXPECT_THAT(plumbline({"bench", "verify", "part"}).out,
              HasSubstr("the bench has 16 cells: 10 had not run when it was archived"));
  // Without the plugin from outside its cells cannot be made again.
  const auto elsewhere = plumbline.folder.path() / "elsewhere";
  fs::create_directory(elsewhere);
  for (const std::string plugin : {PLUMBLINE_STORY_PLUGIN, PLUMBLINE_TRIAL_PLUGIN, PLUMBLINE_BENCH_PLUGIN})
    fs::create_symlink(plugin, elsewhere / fs::path(plugin).filename());
  fs::create_symlink(fs::path(PLUMBLINE_STORY_PLUGIN).parent_path() / "roles", elsewhere / "roles");
  plumbline.bench_file(
      "seeds: 1-3\nscenarios: {hard: {solver.with.fails: 1}}\nalternatives: {solver: [trial.plain, "
      "outside.solver]}\n");
  plumbline.run({"--archive", "whole"});
  plumbline.use_plugins(elsewhere);
  const Answer answer = plumbline({"bench", "verify", "whole", "--cells", "0"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_THAT(answer.out, HasSubstr("6 of 6 archived cells made again, 3 agree to 1e-09, 3 differ"));
  EXPECT_THAT(answer.out, HasSubstr("solver=outside.solver, seed 1: it failed for another reason: "));
}

/// An archive of some of the file's scenarios is one of those: verify planned all, and was refused by the others.
TEST(Bench, AnArchiveOfOneScenarioIsVerifiedAsThat) {
  BenchProgram plumbline;
  plumbline.bench_file(
      "seeds: 1-3\nscenarios: {near: {}, far: {solver.with.factor: 2}}\nalternatives: {solver: [trial.plain]}\n");
  plumbline.run({"--scenario", "near", "solver.with.factor=3", "--archive", "near"});
  const Answer answer = plumbline({"bench", "verify", "near", "--cells", "0"});
  EXPECT_EQ(answer.code, 0) << answer.out << answer.err;
  EXPECT_THAT(answer.out, HasSubstr("3 of 3 archived cells made again, 3 agree"));
}

TEST(Bench, VerifyTellsCellsThatItCannotPlanAndInputsThatChanged) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-3\nalternatives: {method: {a: {}, b: {solver.with.factor: 2}}}\n");
  plumbline.run({"--archive", "supplement"});
  // As an archive of a program that had more kinds of a role.
  const fs::path cells = plumbline.work() / "supplement/cells.jsonl",
                 file = plumbline.work() / "supplement/archive.json";
  std::string text = read_file(cells);
  for (size_t at; (at = text.find("method=b")) != std::string::npos;) text.replace(at, 8, "method=c");
  std::ofstream(cells) << text;
  Json archive = Json::parse(read_file(file));
  archive["cells_sha256"] = runtime::sha256_of(text.data(), text.size());
  archive["inputs"] = Json::array({{{"path", (plumbline.work() / "b.yaml").string()}, {"sha256", "00"}},
                                   {{"path", "/nowhere/at/all"}, {"sha256", "00"}}});
  std::ofstream(file) << archive.dump();
  const Answer answer = plumbline({"bench", "verify", "supplement", "--cells", "0"});
  EXPECT_EQ(answer.code, 1);
  EXPECT_THAT(answer.out, HasSubstr("differs: method=c, seed 1: it is archived, and no cell that this program makes"));
  EXPECT_THAT(answer.out, HasSubstr("b.yaml is not what the cells were made from: it has been changed"));
  EXPECT_THAT(answer.out, HasSubstr("differs: the input /nowhere/at/all is not there, and nothing"));
}

/// A disk under another name, a program in another folder: the bytes are the same, and so are the cells.
TEST(Bench, VerifyKnowsInputsAndProgramsByTheirBytes) {
  BenchProgram plumbline;
  const auto make = [&](const std::string& where, const std::string& content) {
    fs::create_directories(plumbline.work() / where / "data");
    plumbline.write(where + "/data/a.txt", content);
    plumbline.write(where + "/tell", "#!/bin/sh\n# " + content + "\nexit 3\n");
    fs::permissions(plumbline.work() / where / "tell", fs::perms::owner_all);
  };
  plumbline.bench_file("seeds: 1-2\n");
  for (const std::string from : {"story.length, with: {folder: ", "story.teller, with: {program: "}) {
    const std::string what = from.find("folder") != std::string::npos ? "data" : "tell";
    make("here", "a"), make("there", "a"), make("other", "b");
    plumbline.write("trial.yaml", "plumbline: 1\nvars: {seed: 1, place: none}\nnodes:\n  site: {use: " + from +
                                      "\"${place}\"}}\n  solver: {use: trial.plain, in: {site: site.number}}\n");
    const auto at = [&](const std::string& where) { return "place=" + (plumbline.work() / where / what).string(); };
    plumbline.run({at("here"), "--archive", "supplement"});
    fs::remove_all(plumbline.work() / "here");
    const Answer same = plumbline({"bench", "verify", "supplement", at("there")}),
                 other = plumbline({"bench", "verify", "supplement", at("other")});
    EXPECT_EQ(same.code, 0) << same.out << same.err;
    EXPECT_THAT(same.out, AllOf(HasSubstr("2 of 2 archived cells made again, 2 agree"), Not(HasSubstr("differs"))));
    EXPECT_EQ(other.code, 1) << other.out << other.err;
    EXPECT_THAT(other.out, HasSubstr("here/" + what +
                                     " is not there, and nothing that the cells are made from now has its bytes"));
  }
}

/// The last digit of what a reason rounds may fall to either side; what it counts may not.
TEST(Bench, VerifyTakesRoundedNumbersInReasonsForWhatTheyAre) {
  const auto failed = [](const std::string& reason) {
    return Json{{"status", "failed"}, {"failed_node", "solver"}, {"error", reason}, {"metrics", Json::object()}}.dump();
  };
  const auto differ = [&](const std::string& a, const std::string& b) {
    return !runtime::difference_of(failed(a), failed(b), 1e-9).empty();
  };
  EXPECT_FALSE(
      differ("may move by 0.012345 m (1 sigma), 2.34e+03 of 7", "may move by 0.012346 m (1 sigma), 2.35e+03 of 7"));
  EXPECT_FALSE(differ("w = -12.3", "w = -12.4"));
  EXPECT_TRUE(differ("w = -12.3", "w = 12.3"));
  EXPECT_TRUE(differ("may move by 0.012345 m", "may move by 0.012347 m"));
  EXPECT_TRUE(differ("2.34e+03 of 7", "2.34e+04 of 7"));
  EXPECT_TRUE(differ("3 of 16 points", "4 of 16 points"));
  EXPECT_TRUE(differ("point 3.1 of F1", "point 3.1 of F2"));
  const auto died = [](const std::string& code, const std::string& peak) {
    return "node 'n': its process ended by itself with exit code " + code + ", with a peak of " + peak +
           " MiB; it printed nothing";
  };
  EXPECT_FALSE(differ(died("1", "9.8"), died("1", "10.0"))) << "what a process takes is another each time";
  EXPECT_FALSE(differ(died("1", "9.8"), died("1", "104")));
  EXPECT_TRUE(differ(died("1", "9.8"), died("2", "9.8")));
}

/// Once `--archive .` removed the folder "files" that stood there.
TEST(Bench, AnArchiveReplacesNothingButAnArchive) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-2\n");
  fs::create_directories(plumbline.work() / "mine/files");
  plumbline.write("mine/files/thesis.txt", "years of work\n");
  const Answer answer = plumbline({"bench", "b.yaml", "--archive", "mine"});
  EXPECT_NE(answer.code, 0);
  EXPECT_THAT(answer.err, HasSubstr("mine is there and no archive of a bench"));
  EXPECT_TRUE(fs::exists(plumbline.work() / "mine/files/thesis.txt"));
  EXPECT_TRUE(plumbline.results().empty()) << "said before anything runs";
  for (int k = 0; k < 2; ++k) EXPECT_EQ(plumbline({"bench", "b.yaml", "--archive", "own"}).code, 0) << k;
}

TEST(Bench, AnArchiveMakesItsCellsAgainAndNoticesWhatWasChanged) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-8\nalternatives: {method: {a: {}, weak: {solver.with.fails: 0.5}}}\n");
  plumbline.run({"--archive", "supplement"});
  fs::rename(plumbline.work() / "b.yaml", plumbline.work() / "gone.yaml");
  fs::rename(plumbline.work() / "trial.yaml", plumbline.work() / "gone too.yaml");
  Answer answer = plumbline({"bench", "verify", "supplement", "--cells", "0"});
  EXPECT_EQ(answer.code, 0) << answer.err;
  EXPECT_THAT(answer.out, HasSubstr("16 of 16 archived cells made again, 16 agree to 1e-09, 0 differ"));
  EXPECT_THAT(plumbline({"bench", "verify", "supplement", "--cells", "5"}).out, HasSubstr("5 of 16 archived cells"));
  const Json archive = Json::parse(read_file(plumbline.work() / "supplement/archive.json"));
  for (const char* part : {"commit", "compiler", "libraries", "plugins"})
    EXPECT_TRUE(archive["machine"].contains(part)) << part;
  // Another pipeline than the one that was archived.
  std::ofstream(plumbline.work() / "supplement/files/trial.yaml", std::ios::app) << "# changed\n";
  answer = plumbline({"bench", "verify", "supplement"});
  EXPECT_NE(answer.code, 0);
  EXPECT_THAT(answer.err, HasSubstr("files/trial.yaml is not what was archived"));
}

/// What is changed together with its hash is noticed where it contradicts something else; a supplement of a paper is
/// not replaced by that of another bench.
TEST(Bench, AnArchiveThatContradictsItselfIsNoArchive) {
  BenchProgram plumbline;
  plumbline.bench_file("seeds: 1-3\n");
  plumbline.run({"--archive", "whole"});
  const fs::path cells = plumbline.work() / "whole/cells.jsonl", json = plumbline.work() / "whole/archive.json";
  const std::string text = read_file(cells), before = read_file(json);
  const std::string first = text.substr(0, text.find('\n') + 1);
  const auto with = [&](const std::string& changed) {
    Json archive = Json::parse(before);
    archive["cells_sha256"] = runtime::sha256_of(changed.data(), changed.size());
    std::ofstream(cells) << changed;
    std::ofstream(json) << archive.dump();
    return plumbline({"bench", "verify", "whole"});
  };
  EXPECT_EQ(with(text).code, 0);
  EXPECT_THAT(with(text + first).err, HasSubstr("twice"));
  EXPECT_THAT(with(text.substr(first.size())).err, HasSubstr("2 cells, and 3 were archived"));
  std::string other_unit = text;
  other_unit.replace(other_unit.find("\"unit\":\"m\""), 10, "\"unit\":\"mm\"");
  const Answer unit = with(other_unit);
  EXPECT_EQ(unit.code, 1);
  EXPECT_THAT(unit.out, HasSubstr("now it is in \"m\""));
  plumbline.write("c.yaml", "bench: 1\ntitle: another\npipeline: trial.yaml\nmeasure: {error: solver.rmse_z}\n");
  const Answer another = plumbline({"bench", "c.yaml", "--archive", "whole"});
  EXPECT_EQ(another.code, 1);
  EXPECT_THAT(another.err, HasSubstr("is the archive of another bench"));
}

}  // namespace test_archives
}  // namespace plumbline::test

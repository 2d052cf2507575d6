// What of a folder is content: the files of people, and not what runs left there.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "plumbline/folder_files.hpp"
#include "runtime/store/file_hashes.hpp"
#include "test_support.hpp"

namespace plumbline::test {
namespace test_folder_files {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

class Folder : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text = "x") const {
    fs::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name) << text;
  }
  FolderFiles list() const { return list_files(folder_.path()); }
  TemporaryFolder folder_;
};

const char* const record =
    "{\"event\":\"run_start\",\"owned\":{\"files\":{\"old.ifc\":[\"0\"]},\"made_from\":{},\"folders\":[]}}\n"
    "{\"event\":\"node\",\"name\":\"a\"}\n"
    "{\"event\":\"deliver\",\"output\":\"report.html\",\"number\":1,\"files\":{\"report.html\":\"1\"},\"folders\":[]}\n"
    "{\"event\":\"deliver\",\"output\":\"site\",\"number\":2,\"files\":{\"site/a.jpg\":\"2\"},\"folders\":[\"site\"]}\n"
    "{\"event\":\"deliver\",\"output\":\"cut o";

TEST_F(Folder, WhatARunLeftInItIsNoContent) {
  for (const char* name :
       {"plates.csv", "out/report.html", "out/old.ifc", "out/site/a.jpg", "out/mine.jpg", "out/.plumbline-ab/new-1"})
    write(name);
  write("out/run.jsonl", record);
  const FolderFiles found = list();
  EXPECT_EQ(found.files, (Names{"out/mine.jpg", "plates.csv"})) << "what people put there stays theirs";
  EXPECT_EQ(found.outputs,
            (Names{"out/.plumbline-ab/new-1", "out/old.ifc", "out/report.html", "out/run.jsonl", "out/site/a.jpg"}));
}

TEST_F(Folder, OutputsInTheFolderItselfAreNoneEither) {
  for (const char* name : {"plates.csv", "report.html", "site/a.jpg", "below/report.html"}) write(name);
  write("run.jsonl", record);
  EXPECT_EQ(list().files, (Names{"below/report.html", "plates.csv"}));
}

TEST_F(Folder, AnotherFileOfTheNameOfTheRecordHidesNothing) {
  for (const char* name : {"plates.csv", "out/report.html"}) write(name);
  write("out/run.jsonl", "{\"event\":\"marathon\"}\n");
  EXPECT_EQ(list().files, (Names{"out/report.html", "out/run.jsonl", "plates.csv"}));
}

TEST_F(Folder, TheHashOfATreeIsThatOfItsContent) {
  write("plates.csv");
  runtime::FileHashes hashes(folder_.path().string() + ".hashes");
  const std::string before = hashes.of_tree(folder_.path());
  write("out/report.html");
  EXPECT_NE(hashes.of_tree(folder_.path()), before);
  write("out/run.jsonl", record);
  EXPECT_EQ(hashes.of_tree(folder_.path()), before);
  fs::remove(folder_.path().string() + ".hashes");
}

/// `plumbline run ... > log.txt` in the folder itself.
TEST_F(Folder, WhatTheProgramPrintsToIsNoContent) {
  write("plates.csv"), write("log.txt"), write("log2.txt");
  const int saved = dup(1), log = open((folder_.path() / "log.txt").c_str(), O_WRONLY | O_APPEND);
  dup2(log, 1);
  announce_printed_files();
  dup2(saved, 1);
  EXPECT_EQ(list().files, (Names{"log2.txt", "plates.csv"}));
  EXPECT_EQ(list().outputs, Names{"log.txt"});
  announce_printed_files();
  close(saved), close(log);
  EXPECT_EQ(list().files.size(), 3u);
}

TEST_F(Folder, AFolderThatChangesNamesWhatWasWrittenLast) {
  write("plates.csv"), write("log.txt");
  runtime::FileHashes hashes(folder_.path().string() + ".hashes");
  const std::string tree = hashes.of_tree(folder_.path());
  fs::last_write_time(folder_.path() / "plates.csv", fs::file_time_type::clock::now() - std::chrono::hours(1));
  write("log.txt", "more");
  try {
    hashes.locate(tree);
    ADD_FAILURE() << "it has changed";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("has changed since it was read (last written: log.txt)"),
              std::string::npos)
        << error.what();
  }
  fs::remove(folder_.path().string() + ".hashes");
}

TEST_F(Folder, LinksAreFollowedAndDanglingOnesNamed) {
  const TemporaryFolder other;
  std::ofstream(other.path() / "a.jpg") << "x";
  fs::create_directory_symlink(other.path(), folder_.path() / "card");
  fs::create_symlink("nowhere.jpg", folder_.path() / "gone.jpg");
  EXPECT_EQ(list().files, Names{"card/a.jpg"});
  EXPECT_EQ(list().dangling, Names{"gone.jpg"});
}

TEST(SystemFile, IsToldByItsName) {
  for (const char* name :
       {"a/._b.jpg", "._b.jpg", ".DS_Store", "a/Thumbs.db", "DESKTOP.INI", "~$plan.xlsx", "__MACOSX/a/b.jpg",
        "a/.thumbnails/b.jpg", ".git/x", "a/@eaDir/b.jpg/SYNOPHOTO_THUMB_XL.jpg", "#recycle/b.jpg"})
    EXPECT_TRUE(is_system_file(name)) << name;
  for (const char* name :
       {"a.jpg", "_b.jpg", "thumbs.db.jpg", "a/__MACOSX.jpg", ".hidden.jpg", "./a.jpg", "../a/b.jpg", "a.b/c.jpg"})
    EXPECT_FALSE(is_system_file(name)) << name;
}

}  // namespace test_folder_files
}  // namespace plumbline::test

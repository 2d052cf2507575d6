// Artifacts that stand for files are identified by content, wherever the files lie and whoever made them.
#include "story.hpp"

namespace plumbline::test {
namespace test_references {

namespace fs = std::filesystem;

class References : public testing::Test {
 protected:
  References() {
    fs::create_directory(photographs());
    std::ofstream(photographs() / "1.jpg") << "seven b";
    story.tell(
        "p: {use: story.photograph, with: {folder: \"${folder}\"}}\nd: {use: story.develops, in: {folder: p.folder}}",
        "");
    std::string text = read_file(story.pipeline());
    text.insert(text.find("seed: 1"), "folder: photographs, ");
    std::ofstream(story.pipeline()) << text;
  }
  fs::path photographs() const { return story.folder.path() / "photographs"; }
  Story story{""};
};

TEST_F(References, AMovedFolderChangesNothing) {
  story.run();
  ASSERT_TRUE(story.result.ok()) << story.node("p").error << story.node("d").error;
  EXPECT_EQ(story.value("d", "number"), 7);
  const auto before = story.node("p").outputs;
  fs::rename(photographs(), story.folder.path() / "moved");
  story.run({"folder=" + (story.folder.path() / "moved").string()});
  EXPECT_EQ(story.executed(), "");
  EXPECT_EQ(story.node("p").outputs, before);
  // And what runs anew finds the files at their new place.
  story.run({"folder=" + (story.folder.path() / "moved").string(),
             "d.with.meanwhile=" + (story.folder.path() / "x").string()});
  EXPECT_EQ(story.value("d", "number"), 7) << story.node("d").error;
}

TEST_F(References, APhotographThatChangesDuringARunIsRefused) {
  story.run({"d.with.meanwhile=" + (photographs() / "1.jpg").string()});
  EXPECT_EQ(story.status("d"), "failed");
  EXPECT_NE(story.node("d").error.find("1.jpg changed while the node worked with it"), std::string::npos)
      << story.node("d").error;
  story.run();
  EXPECT_EQ(story.value("d", "number"), 11) << "what was found meanwhile was kept under the wrong hash";
}

TEST_F(References, AFolderThatChangedIsReadAgain) {
  story.tell("l: {use: story.length, with: {folder: photographs}}");
  story.run();
  EXPECT_EQ(story.value("l", "number"), 1);
  std::ofstream(photographs() / "2.jpg") << "two";
  story.run();
  EXPECT_EQ(story.value("l", "number"), 2);
}

TEST_F(References, AFileThatIsGoneIsNamed) {
  story.run();
  fs::rename(photographs() / "1.jpg", story.folder.path() / "gone");
  story.store = std::make_unique<runtime::Store>(story.folder.path() / "store");
  try {
    story.store->file_hashes().locate(std::string(64, '0'));
    FAIL();
  } catch (const std::runtime_error&) {
  }
  const std::string hash = story.store->file_hashes().of_file(story.folder.path() / "gone");
  EXPECT_EQ(story.store->file_hashes().locate(hash), story.folder.path() / "gone");
  std::ofstream(story.folder.path() / "gone") << "other";
  try {
    story.store->file_hashes().locate(hash);
    FAIL();
  } catch (const std::runtime_error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("gone has changed since it was read"), std::string::npos) << text;
    EXPECT_NE(text.find("1.jpg is not there any more"), std::string::npos) << text;
  }
}

TEST_F(References, AFolderThatANodeMakesIsNamedByItsContent) {
  story.tell("w: {use: story.folder}\nr: {use: story.read, in: {folder: w.folder}}");
  story.run();
  ASSERT_TRUE(story.result.ok()) << story.node("w").error << story.node("r").error;
  const auto before = story.node("w").outputs;
  // Another node with the same content: the artifact is the same, and what follows is reused.
  story.tell(
      "w: {use: story.folder, with: {fail: false, text: hello}}\nq: {use: story.constant}\n"
      "r: {use: story.read, in: {folder: w.folder}}");
  fs::remove_all(story.folder.path() / "store/runs");
  story.run();
  EXPECT_EQ(story.node("w").outputs, before);
  size_t folders = 0;
  for (const auto& entry : fs::directory_iterator(story.folder.path() / "store/folders")) {
    EXPECT_EQ(story.store->file_hashes().of_tree(entry.path()), entry.path().filename().string());
    ++folders;
  }
  EXPECT_EQ(folders, 1u);
}

}  // namespace test_references
}  // namespace plumbline::test

#include <sys/stat.h>
#include <unistd.h>

#include <cstdlib>

#include "runtime/base/digest.hpp"
#include "runtime/store/store.hpp"
#include "test_support.hpp"

namespace plumbline::test {
namespace test_store {

using runtime::Store;
using runtime::StoredRun;
using runtime::StoreError;
namespace fs = std::filesystem;

std::string text_of(const runtime::Blob& blob) {
  return {static_cast<const char*>(blob.bytes().data), blob.bytes().size};
}

std::string put(Store& store, const std::string& text) { return store.put(text.data(), text.size()); }

TEST(Store, GivesBackWhatItWasGiven) {
  const TemporaryFolder folder;
  const std::string small = "small", large(200'000, 'x'), empty;
  std::vector<std::string> hashes;
  {
    Store store(folder.path() / "store");
    for (const std::string& text : {small, large, empty}) hashes.push_back(put(store, text));
  }
  Store store(folder.path() / "store");
  EXPECT_EQ(text_of(store.get(hashes[0])), small);
  EXPECT_EQ(text_of(store.get(hashes[1])), large);
  EXPECT_EQ(text_of(store.get(hashes[2])), empty);
  EXPECT_EQ(hashes[0], runtime::sha256_of(small.data(), small.size()));
}

/// Several nodes read one blob where it lies: one that writes into its input changes it for none of them.
TEST(Store, BlobsCannotBeWritten) {
  const TemporaryFolder folder;
  Store store(folder.path());
  const auto overwrite = [](const runtime::Blob& blob) {
    *static_cast<volatile char*>(const_cast<void*>(blob.bytes().data)) = 'x';
  };
  const std::string small = "small", large(200'000, 'y');
  const std::string held = store.hold(small.data(), small.size());
  EXPECT_EXIT(overwrite(store.get(held)), testing::KilledBySignal(SIGSEGV), "");
  for (const std::string& text : {small, large})
    EXPECT_EXIT(overwrite(store.get(put(store, text))), testing::KilledBySignal(SIGSEGV), "") << text.size();
  EXPECT_EQ(text_of(store.get(held)), small);
}

/// A node may read thousands of small blobs at a time, and a process has a thousand descriptors.
TEST(Store, BlobsThatAreReadHoldNoDescriptors) {
  const TemporaryFolder folder;
  Store store(folder.path());
  const auto open_descriptors = [] {
    const fs::directory_iterator all("/proc/self/fd");
    return std::distance(begin(all), end(all));
  };
  const auto before = open_descriptors();
  std::vector<runtime::Blob> blobs;
  for (int i = 0; i < 200; ++i) blobs.push_back(store.get(put(store, std::string(60'000, 'a') + std::to_string(i))));
  EXPECT_LE(open_descriptors(), before + 1);
  EXPECT_EQ(text_of(blobs[7]), std::string(60'000, 'a') + "7");
}

TEST(Store, ABlobLivesAsLongAsItsReaders) {
  const TemporaryFolder folder;
  Store store(folder.path());
  const std::string text(100'000, 'y');
  const std::string hash = put(store, text);
  const runtime::Blob blob = store.get(hash);
  fs::remove_all(folder.path() / "blobs");
  EXPECT_EQ(text_of(blob), text);
}

TEST(Store, RefusesADamagedBlobAndPutMendsIt) {
  const TemporaryFolder folder;
  std::string hash;
  {
    Store store(folder.path());
    hash = put(store, "right");
  }
  const fs::path file = folder.path() / "blobs" / hash.substr(0, 2) / hash;
  std::ofstream(file, std::ios::trunc) << "wrong";
  {
    Store store(folder.path());
    put(store, "right");
    EXPECT_EQ(text_of(store.get(hash)), "right");
  }
  std::ofstream(file, std::ios::trunc) << "wrong";
  Store store(folder.path());
  try {
    store.get(hash);
    FAIL() << "the damage was not noticed";
  } catch (const StoreError& error) {
    EXPECT_NE(std::string(error.what()).find("blob " + hash), std::string::npos) << error.what();
  }
  EXPECT_FALSE(fs::exists(file));
}

TEST(Store, KeepsTheRunsOfNodes) {
  const TemporaryFolder folder;
  Store store(folder.path());
  runtime::StoredRun run;
  run.kind = "a.b";
  run.outputs["x"] = {put(store, "one"), put(store, "two")};
  run.outputs["none"] = {};
  run.metrics.push_back({"sigma", 0.1, "m"});
  run.warnings.push_back("not UTF-8: \xff");
  run.seconds = 1.5;
  const std::string key(64, 'a');
  store.put_run(key, run);
  std::string damage, outdated;
  const auto found = store.find_run(key, damage, outdated);
  ASSERT_TRUE(found) << damage;
  EXPECT_EQ(found->outputs, run.outputs);
  EXPECT_EQ(found->metrics.at(0).value, 0.1);
  EXPECT_EQ(found->warnings.size(), 1u);
  EXPECT_FALSE(store.find_run(std::string(64, 'b'), damage, outdated));
  EXPECT_EQ(damage, "");
}

/// A small output needs no file of its own, and is found by its run, by its hash alone, and by the first digits.
TEST(Store, SmallOutputsGoIntoTheRecordOfTheRun) {
  const TemporaryFolder folder;
  const std::string small(Store::inline_up_to, 's'), large(Store::inline_up_to + 1, 'l'), key(64, 'a');
  runtime::StoredRun run;
  run.kind = "a.b";
  {
    Store store(folder.path());
    run.outputs["x"] = {store.hold(small.data(), small.size()), store.hold(large.data(), large.size()),
                        store.hold("", 0)};
    EXPECT_EQ(text_of(store.get(run.outputs["x"][0])), small) << "before its run is there";
    store.put_run(key, run);
  }
  const auto file = [&](const std::string& hash) { return folder.path() / "blobs" / hash.substr(0, 2) / hash; };
  EXPECT_FALSE(fs::exists(file(run.outputs["x"][0])));
  EXPECT_TRUE(fs::exists(file(run.outputs["x"][1])));
  {
    Store store(folder.path());
    std::string damage, outdated;
    ASSERT_TRUE(store.find_run(key, damage, outdated)) << damage;
    EXPECT_EQ(text_of(store.get(run.outputs["x"][0])), small);
    EXPECT_EQ(text_of(store.get(run.outputs["x"][1])), large);
    EXPECT_EQ(text_of(store.get(run.outputs["x"][2])), "");
  }
  Store store(folder.path());
  EXPECT_EQ(text_of(store.get(run.outputs["x"][0])), small);
  EXPECT_EQ(store.blobs_starting_with(run.outputs["x"][0].substr(0, 6)), std::vector<std::string>{run.outputs["x"][0]});
  EXPECT_THROW(store.get(std::string(64, 'e')), StoreError);
}

/// A record is a text that anybody may have written: no name in it leads out of the store.
/// A record holds contents of several hashes; who asks for one, by all of its hash or by its beginning, gets no other.
TEST(Store, ContentsAreFoundByTheBeginningOfTheirHash) {
  const TemporaryFolder folder;
  const std::string texts[] = {"one content", "another content", "a third"};
  StoredRun run;
  {
    Store store(folder.path() / "store");
    for (const std::string& text : texts) run.outputs["number"].push_back(store.hold(text.data(), text.size()));
    store.put_run(std::string(64, 'a'), run);
  }
  for (int i = 0; i < 3; ++i) {
    Store store(folder.path() / "store");  // one that has only the record
    const std::string& hash = run.outputs["number"][i];
    EXPECT_EQ(store.blobs_starting_with(hash.substr(0, 8)), std::vector<std::string>{hash});
    EXPECT_EQ(text_of(store.get(hash)), texts[i]);
  }
  const Store store(folder.path() / "store");
  EXPECT_TRUE(store.blobs_starting_with(std::string(8, '0')).empty());
}

TEST(Store, ARecordThatNamesAFileElsewhereIsDamaged) {
  const TemporaryFolder folder;
  Store store(folder.path() / "store");
  std::ofstream(folder.path() / "mine") << "mine";
  runtime::StoredRun run;
  run.kind = "a.b";
  run.outputs["x"] = {"../../../mine"};
  store.put_run(std::string(64, 'a'), run);
  std::string damage, outdated;
  EXPECT_FALSE(store.find_run(std::string(64, 'a'), damage, outdated));
  EXPECT_NE(damage.find("no hash"), std::string::npos) << damage;
  EXPECT_EQ(read_file(folder.path() / "mine"), "mine");
}

TEST(Store, UrisDoNotLeadOut) {
  const TemporaryFolder folder;
  const Store store(folder.path());
  EXPECT_EQ(store.resolve("store:k-port/a/b.jpg"), folder.path() / "folders/k-port/a/b.jpg");
  EXPECT_EQ(store.resolve("/data/b.jpg"), "/data/b.jpg");
  for (const char* uri : {"store:../runs", "store:a/../../runs", "store:/etc/passwd", "store:"})
    EXPECT_EQ(store.resolve(uri), "") << uri;
  EXPECT_THROW(store.folder_path("../x"), StoreError);
}

TEST(Store, CannotBeWherePeopleMayNotWrite) {
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "file") << "a file";
  try {
    Store store(folder.path() / "file" / "store");
    FAIL();
  } catch (const StoreError& error) {
    EXPECT_NE(std::string(error.what()).find("--store"), std::string::npos) << error.what();
  }
}

TEST(Store, AFullDiskIsAnErrorThatSaysSo) {
  if (access("/dev/full", W_OK) != 0) GTEST_SKIP() << "no /dev/full here";
  const TemporaryFolder folder;
  Store store(folder.path());
  // Every temporary file of the store is now the device that is always full.
  const std::string text(100'000, 'z');
  fs::remove_all(folder.path() / "tmp");
  EXPECT_THROW(put(store, text), StoreError);
  EXPECT_FALSE(fs::exists(folder.path() / "blobs" / runtime::sha256_of(text.data(), text.size())));
}

/// A folder of the user's may be given as a store by mistake: nothing in it that has not the name of something stored
/// goes away, neither when it is opened nor when it is made smaller.
TEST(Store, RemovesNothingThatItDidNotWrite) {
  const TemporaryFolder folder;
  const std::vector<std::string> mine{"tmp/site-2024-photos/c.jpg",
                                      "tmp/holiday-99999999-7/d.jpg",
                                      "tmp/notes-3",
                                      "runs/monday.json",
                                      "folders/photos/a.jpg",
                                      "blobs/b.dat",
                                      "blobs/ab/c.dat"};
  for (const std::string& file : mine) {
    fs::create_directories((folder.path() / file).parent_path());
    std::ofstream(folder.path() / file) << "mine";
  }
  {
    runtime::Store store(folder.path());
    store.put("abc", 3);
  }
  runtime::Store store(folder.path());
  const auto pruned = store.prune(0, 0);
  EXPECT_EQ(pruned.blobs, 1u);
  EXPECT_EQ(pruned.runs + pruned.folders, 0u);
  for (const std::string& file : mine) EXPECT_EQ(read_file(folder.path() / file), "mine") << file;
}

TEST(Store, IsNotForOthersToWriteWhateverTheUmask) {
  const TemporaryFolder folder;
  const mode_t before = umask(0);
  {
    runtime::Store store(folder.path() / "store");
    store.put("abc", 3);
  }
  umask(before);
  for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
    EXPECT_EQ(entry.status().permissions() & (fs::perms::others_write | fs::perms::group_write), fs::perms::none)
        << entry.path();
  fs::permissions(folder.path() / "store" / "runs", fs::perms::others_write, fs::perm_options::add);
  EXPECT_THROW(runtime::Store(folder.path() / "store"), runtime::StoreError);
}

TEST(Store, DefaultFolderFollowsTheEnvironment) {
  const auto set = [](const char* name, const char* value) { value ? setenv(name, value, 1) : unsetenv(name); };
  const char* old_home = getenv("HOME");
  const std::string home = old_home ? old_home : "";
  const char* old_store = getenv("PLUMBLINE_STORE");
  const std::string kept = old_store ? old_store : "";
  set("PLUMBLINE_STORE", nullptr);
  set("XDG_CACHE_HOME", nullptr);
  set("HOME", "/home/nobody");
  EXPECT_EQ(Store::default_folder(), "/home/nobody/.cache/plumbline");
  set("XDG_CACHE_HOME", "/cache");
  EXPECT_EQ(Store::default_folder(), "/cache/plumbline");
  set("PLUMBLINE_STORE", "/store");
  EXPECT_EQ(Store::default_folder(), "/store");
  set("PLUMBLINE_STORE", nullptr);
  set("XDG_CACHE_HOME", nullptr);
  set("HOME", nullptr);
  EXPECT_THROW(Store::default_folder(), StoreError);
  if (old_home) set("HOME", home.c_str());
  if (old_store) set("PLUMBLINE_STORE", kept.c_str());
}

TEST(FileHashes, FollowTheContent) {
  const TemporaryFolder folder;
  runtime::FileHashes hashes(folder.path() / "hashes");
  const fs::path tree = folder.path() / "tree";
  fs::create_directories(tree / "sub");
  std::ofstream(tree / "sub" / "a") << "1";
  const std::string first = hashes.of_tree(tree);
  EXPECT_EQ(hashes.of_tree(tree), first);
  std::ofstream(tree / "sub" / "a") << "2";
  const std::string second = hashes.of_tree(tree);
  EXPECT_NE(second, first) << "same name, same size, same second";
  fs::rename(tree / "sub" / "a", tree / "sub" / "b");
  EXPECT_NE(hashes.of_tree(tree), second) << "the name counts";
  fs::rename(tree / "sub" / "b", tree / "sub" / "a");
  EXPECT_EQ(hashes.of_tree(tree), second);
  fs::rename(tree, folder.path() / "moved");
  EXPECT_EQ(hashes.of_tree(folder.path() / "moved"), second) << "the folder's own name does not";
}

TEST(FileHashes, ADeviceIsRefusedBecauseItHasNoEnd) {
  const TemporaryFolder folder;
  try {
    runtime::FileHashes(folder.path() / "hashes").of_file("/dev/zero");
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("no regular file"), std::string::npos) << error.what();
  }
}

TEST(FileHashes, AreRememberedOnceTheFileHasSettled) {
  const TemporaryFolder folder;
  const fs::path file = folder.path() / "a", log = folder.path() / "hashes";
  std::ofstream(file) << "1";
  const std::string before = runtime::FileHashes(log).of_file(file);
  std::ofstream(file) << "2";
  EXPECT_NE(runtime::FileHashes(log).of_file(file), before) << "written again within the same tick of the clock";
  fs::remove(log);
  const fs::path settled = PLUMBLINE_STORY_PLUGIN;
  const std::string hash = runtime::sha256_of_file(settled);
  runtime::FileHashes(log).of_file(settled);
  // What is remembered is believed: proof that the file is not read again.
  std::string text = read_file(log);
  ASSERT_NE(text.find(hash), std::string::npos);
  text.replace(text.find(hash), hash.size(), std::string(64, '0'));
  std::ofstream(log, std::ios::trunc) << text << "torn line";
  if (runtime::FileHashes(log).of_file(settled) == hash) GTEST_SKIP() << "the plugin was built this second";
  EXPECT_EQ(runtime::FileHashes(log).of_file(settled), std::string(64, '0'));
}

TEST(FileHashes, OfTheStoresOwnFilesAreKeptByTheProcessAlone) {
  const TemporaryFolder folder;
  const fs::path passing = folder.path() / "tmp", file = passing / "a", log = folder.path() / "hashes";
  fs::create_directory(passing);
  std::ofstream(file) << "1";
  runtime::FileHashes hashes(log, passing);
  const std::string hash = hashes.of_file(file);
  fs::rename(passing, folder.path() / "kept");
  EXPECT_EQ(hashes.of_file(folder.path() / "kept/a"), hash);
  // A power failure may leave another content under the same identity, so none is written down.
  EXPECT_EQ(read_file(log), "- " + hash + " " + (folder.path() / "kept/a").string() + "\n");
  std::ofstream(folder.path() / "kept/a") << "other";
  EXPECT_EQ(hashes.of_file(folder.path() / "kept/a"), runtime::sha256_of("other", 5));
}

TEST(FileHashes, NameWhatCannotBeRead) {
  const TemporaryFolder folder;
  runtime::FileHashes hashes(folder.path() / "hashes");
  EXPECT_THROW(hashes.of_file(folder.path() / "missing"), std::runtime_error);
  EXPECT_THROW(hashes.of_file(folder.path()), std::runtime_error);
  EXPECT_THROW(hashes.of_tree(folder.path() / "missing"), std::runtime_error);
  fs::create_directory(folder.path() / "loop");
  fs::create_directory_symlink("..", folder.path() / "loop" / "up");
  EXPECT_THROW(hashes.of_tree(folder.path() / "loop"), std::runtime_error);
}

/// With two links that lead back, everything stands 2^depth times behind them.
TEST(FileHashes, NameALinkThatLeadsBack) {
  const TemporaryFolder folder;
  const fs::path campaign = folder.path() / "campaign", images = campaign / "images";
  fs::create_directories(images);
  std::ofstream(images / "a.jpg") << "a";
  fs::create_directory_symlink(".", images / "loop");
  fs::create_directory_symlink("../images", images / "again");
  try {
    runtime::FileHashes(folder.path() / "hashes").of_tree(campaign);
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("leads back to a folder that holds it"), std::string::npos)
        << error.what();
  }
  fs::remove(images / "loop");
  fs::remove(images / "again");
  fs::create_directory_symlink("images", campaign / "photographs");  // the same twice is no circle
  EXPECT_EQ(runtime::FileHashes(folder.path() / "hashes").files_of(campaign).size(), 2u);
}

/// A tool that repairs or copies folders may leave one where a file was, and a file where a folder was.
TEST(Store, AFolderInThePlaceOfAFileHeals) {
  const TemporaryFolder folder;
  const std::string key(64, 'a');
  std::string damage, outdated;
  const auto put = [&](Store& store) {
    StoredRun run;
    run.kind = "story.constant";
    run.outputs["number"] = {store.put("blob", 4)};
    store.put_run(key, run);
    return run.outputs["number"][0];
  };
  std::string hash;
  {
    Store store(folder.path());
    hash = put(store);
  }
  const auto blob = folder.path() / "blobs" / hash.substr(0, 2) / hash;
  const auto record = folder.path() / "runs" / "aa" / (key + ".json");
  for (const auto& file : {blob, record}) {
    std::filesystem::remove(file);
    std::filesystem::create_directories(file / "with" / "something");
    Store store(folder.path());
    EXPECT_FALSE(store.find_run(key, damage, outdated));
    EXPECT_EQ(put(store), hash);
    EXPECT_TRUE(store.find_run(key, damage, outdated)) << damage;
  }
  std::filesystem::remove_all(folder.path() / "runs" / "aa");
  std::ofstream(folder.path() / "runs" / "aa") << "a file";
  Store store(folder.path());
  put(store);
  EXPECT_TRUE(store.find_run(key, damage, outdated)) << damage;
  EXPECT_TRUE(std::filesystem::is_empty(folder.path() / "tmp"));
}

/// Two containers of one name, with process numbers of their own, write to one store at the same time.
TEST(Store, TemporaryNamesOfTwoStoresOfOneProcessNumberDiffer) {
  const TemporaryFolder folder;
  Store one(folder.path()), other(folder.path());
  const auto first = one.new_folder(), second = other.new_folder();
  const auto drawn = [](const std::filesystem::path& path) {
    const std::string name = path.filename().string();
    return name.substr(0, name.rfind('-'));
  };
  EXPECT_NE(drawn(first), drawn(second));
}

}  // namespace test_store
}  // namespace plumbline::test

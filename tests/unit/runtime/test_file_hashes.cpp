// What is remembered of files, and what must not be.
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "runtime/base/digest.hpp"
#include "runtime/store/file_hashes.hpp"
#include "runtime/store/used_files.hpp"
#include "test_support.hpp"

namespace plumbline::test {
namespace test_file_hashes {

using runtime::FileHashes;
using runtime::sha256_of_file;

/// Files may have times of the fine clock, and the coarse one lags behind it by more than a step where ticks come late.
TEST(UsedFiles, TheNextTickComesAfterAllThatWasWritten) {
  for (int i = 0; i < 25; ++i) {
    timespec before{};
    clock_gettime(CLOCK_REALTIME, &before);
    const timespec tick = runtime::next_tick_of_files();
    EXPECT_GT(std::make_pair(tick.tv_sec, tick.tv_nsec), std::make_pair(before.tv_sec, before.tv_nsec));
  }
}

/// A second store into a page that is not written back yet moves no time of the file.
TEST(FileHashes, AFileThatIsOpenForWritingIsReadEachTime) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "data";
  std::ofstream(file) << std::string(4096, 'a');
  const timespec long_ago[2] = {{1'000'000'000, 0}, {1'000'000'000, 0}};
  utimensat(AT_FDCWD, file.c_str(), long_ago, 0);
  std::this_thread::sleep_for(std::chrono::milliseconds(3100));  // until it counts as settled
  FileHashes hashes(folder.path() / "log");
  const int open_file = open(file.c_str(), O_RDWR);
  auto* mapped = static_cast<char*>(mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_SHARED, open_file, 0));
  close(open_file);
  ASSERT_NE(mapped, MAP_FAILED);
  const std::string first = hashes.of_file(file);
  mapped[0] = 'b';
  const std::string second = hashes.of_file(file);
  EXPECT_NE(first, second);
  mapped[0] = 'c';
  EXPECT_NE(hashes.of_file(file), second);
  munmap(mapped, 4096);
  EXPECT_EQ(hashes.of_file(file), sha256_of_file(file)) << "what was read while it was open was not remembered";
}

/// Of a folder with several, one was told a run.
TEST(FileHashes, AllFilesOfAFolderThatCannotBeReadAreToldAtOnce) {
  const TemporaryFolder folder, log;
  std::ofstream(folder.path() / "sound") << "a";
  for (const char* name : {"b", "c"})  // a regular file that nobody can read, whoever runs this
    std::filesystem::create_symlink("/proc/self/mem", folder.path() / name);
  FileHashes hashes(log.path() / "log");
  std::string told;
  try {
    hashes.of(folder.path());
  } catch (const std::runtime_error& error) {
    told = error.what();
  }
  for (const char* name : {"b", "c"})
    EXPECT_NE(told.find("cannot read " + (folder.path() / name).string() + ": "), std::string::npos) << told;
  EXPECT_NE(told.find("check the rights"), std::string::npos) << told;
}

TEST(FileHashes, ReadsAllAgainIfTheMemoryIsDistrusted) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "data";
  std::ofstream(file) << "a";
  std::this_thread::sleep_for(std::chrono::milliseconds(3100));
  {
    FileHashes hashes(folder.path() / "log");
    hashes.of_file(file);
  }
  // What the log says is a lie about a file of the same identity, as a change without a trace would make it.
  std::string log = read_file(folder.path() / "log");
  const std::string hash = sha256_of_file(file), lie(64, '0');
  ASSERT_NE(log.find(hash), std::string::npos) << log;
  log.replace(log.find(hash), 64, lie);
  std::ofstream(folder.path() / "log") << log;
  FileHashes hashes(folder.path() / "log");
  EXPECT_EQ(hashes.of_file(file), lie);
  hashes.distrust_memory();
  EXPECT_EQ(hashes.of_file(file), hash);
}

}  // namespace test_file_hashes
}  // namespace plumbline::test

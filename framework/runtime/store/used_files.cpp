#include "runtime/store/used_files.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <stdexcept>

#include "runtime/base/trust.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

bool is_before(const timespec& a, const timespec& b) {
  return a.tv_sec < b.tv_sec || (a.tv_sec == b.tv_sec && a.tv_nsec < b.tv_nsec);
}

/// What was run with the user's rights must be nobody else's, as the node itself. And it must be what the node read:
/// the time of a file's last change, which no program can set, tells whether it was written since the node began.
void check_used_file(const std::string& file, const timespec& started, std::map<fs::path, std::string>& folders) {
  struct stat info {};
  if (!fs::path(file).is_absolute() || stat(file.c_str(), &info) != 0 || !S_ISREG(info.st_mode))
    throw std::runtime_error("it says that it used " + file + ", which is no file; it must say whole paths of files");
  if (!is_before(info.st_ctim, started))
    throw std::runtime_error(file + " changed while the node worked with it; run again");
  const auto [folder, fresh] = folders.try_emplace(fs::path(file).parent_path());
  if (fresh) folder->second = distrust(folder->first);
  const std::string problem = folder->second.empty() ? distrust(file) : folder->second;
  if (!problem.empty()) throw std::runtime_error("it used a file that is not believed: " + problem);
}

void check_absent_file(const std::string& file) {
  if (!fs::path(file).is_absolute())
    throw std::runtime_error("it says that it looked for " + file + "; it must say whole paths");
  if (fs::exists(fs::symlink_status(file)))
    throw std::runtime_error(file + " came while the node worked without it; run again");
}

}  // namespace

timespec next_tick_of_files() {
  // Files may be stamped by the fine clock, and a busy machine moves the coarse one late and several ticks at once: the
  // next of its values need not have come after what was stamped before.
  timespec called{}, now{};
  clock_gettime(CLOCK_REALTIME, &called);
  do {
    usleep(500);
    clock_gettime(CLOCK_REALTIME_COARSE, &now);
  } while (!is_before(called, now));
  return now;
}

std::map<std::string, std::string> hashes_of_used(const std::vector<std::string>& lines, const timespec& started,
                                                  FileHashes& hashes) {
  std::map<std::string, std::string> used;
  std::map<fs::path, std::string> folders;  // there are few, of hundreds of files
  for (const std::string& line : lines) {
    if (line.starts_with(absent_mark)) {
      const std::string file = line.substr(absent_mark.size());
      check_absent_file(file);
      used[file] = absent_hash;
      continue;
    }
    check_used_file(line, started, folders);
    used[line] = hashes.of_file(line);
  }
  return used;
}

}  // namespace plumbline::runtime

#include "runtime/base/group_memory.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>

#include "runtime/base/child_process.hpp"
#include "runtime/base/process_list.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

/// Proportional parts, so that what processes share counts once.
void add_mapped(const fs::path& process, uint64_t& own, uint64_t& shared) {
  std::ifstream stream(process / "smaps_rollup");
  for (std::string line; std::getline(stream, line);) {
    if (line.rfind("Pss_Anon:", 0) == 0) own += 1024 * std::strtoull(line.c_str() + 9, nullptr, 10);
    if (line.rfind("Pss_Shmem:", 0) == 0) shared += 1024 * std::strtoull(line.c_str() + 10, nullptr, 10);
  }
}

void add_memfds(const fs::path& process, std::map<ino_t, uint64_t>& files) {
  std::error_code gone;
  for (fs::directory_iterator entry(process / "fd", gone), end; !gone && entry != end; entry.increment(gone)) {
    std::error_code closed;
    const std::string target = fs::read_symlink(entry->path(), closed).string();
    struct stat info {};
    if (target.rfind("/memfd:", 0) == 0 && target.rfind("/memfd:plumbline-", 0) != 0 &&
        stat(entry->path().c_str(), &info) == 0)
      files[info.st_ino] = 512 * static_cast<uint64_t>(info.st_blocks);
  }
}

int64_t now() {
  using std::chrono::steady_clock;
  return std::chrono::duration_cast<std::chrono::milliseconds>(steady_clock::now().time_since_epoch()).count();
}

}  // namespace

uint64_t memory_of_group(pid_t leader) {
  uint64_t own = 0, mapped = 0, written = 0;
  std::map<ino_t, uint64_t> files;
  for (const ProcessStat& process : running_processes()) {
    if (process.group != leader) continue;
    const fs::path folder = "/proc/" + std::to_string(process.pid);
    add_mapped(folder, own, mapped);
    add_memfds(folder, files);
  }
  for (const auto& [inode, bytes] : files) written += bytes;
  return own + std::max(mapped, written);  // of a memfd that is mapped both tell
}

GroupLimit::GroupLimit(pid_t leader, uint64_t bytes)
    : leader_(leader), limit_(bytes), before_(bytes ? memory_of_group(leader) : 0) {}

std::string GroupLimit::broken() {
  constexpr int64_t pause = 50;
  constexpr uint64_t slack = uint64_t{16} << 20;  // stacks, tables of the allocator
  if (!limit_ || now() < asked_ + pause) return "";
  const uint64_t bytes = memory_of_group(leader_);
  asked_ = now();
  if (bytes <= before_ + limit_ + slack) return "";
  return "it took " + mebibytes_text(bytes - before_) +
         " of memory with all that it started and shared, more than its limit of " + mebibytes_text(limit_) +
         ", and was killed";
}

}  // namespace plumbline::runtime

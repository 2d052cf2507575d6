#include "runtime/base/memory_budget.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>

#include "runtime/base/child_process.hpp"

namespace plumbline::runtime {

uint64_t MemoryBudget::default_limit() {
  uint64_t memory = static_cast<uint64_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<uint64_t>(sysconf(_SC_PAGESIZE));
  uint64_t container = 0;
  if (std::ifstream("/sys/fs/cgroup/memory.max") >> container && container > 0) memory = std::min(memory, container);
  return std::min(memory / 2, uint64_t{3} << 30);
}

std::string MemoryBudget::excess(uint64_t bytes, uint64_t held) const {
  if (bytes <= limit_ - std::min(held, limit_)) return "";
  const std::string takes = "it takes " + mebibytes_text(held + bytes) + " of memory by its own account, and ";
  if (kept_)
    return takes + "--memory allows " + mebibytes_text(limit_) +
           ": raise it, or choose parameters with which the node takes less (plumbline describe KIND)";
  return takes + "the limit is " + mebibytes_text(limit_) +
         " (without --memory half of the machine's, 3 GiB at most; workers of a bench share it): it ran alone";
}

bool MemoryBudget::acquire(uint64_t bytes, uint64_t held, const std::atomic<bool>& cancel) {
  std::unique_lock lock(mutex_);
  // Waiting is cut into slices because the cancelling signal handler cannot notify.
  while (held == 0 && used_ != 0 && (bytes > limit_ || used_ > limit_ - bytes)) {
    if (cancel) return false;
    freed_.wait_for(lock, std::chrono::milliseconds(50));
  }
  if (cancel) return false;
  used_ += bytes;
  return true;
}

void MemoryBudget::release(uint64_t bytes) {
  {
    const std::scoped_lock lock(mutex_);
    used_ -= bytes;
  }
  freed_.notify_all();
}

}  // namespace plumbline::runtime

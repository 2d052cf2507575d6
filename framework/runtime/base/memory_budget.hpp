// Memory that nodes announce before they allocate it, so that a hundred large images are not in memory at once.
#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>

namespace plumbline::runtime {

class MemoryBudget {
 public:
  /// `bytes`: the limit; 0 takes default_limit(). `kept`: somebody asked for it, so nothing may go beyond.
  explicit MemoryBudget(uint64_t bytes, bool kept = false) : limit_(bytes ? bytes : default_limit()), kept_(kept) {}

  /// Half of the machine's (or the container's) memory, at most 3 GiB.
  static uint64_t default_limit();
  uint64_t limit() const { return limit_; }
  bool is_kept() const { return kept_; }

  /// What is to be said where one caller alone would have more than the limit with `bytes` beside what it has; else
  /// empty.
  std::string excess(uint64_t bytes, uint64_t held) const;

  /// Waits until `bytes` fit beside what others hold; a request above the limit waits until nobody holds anything and
  /// then runs alone. `held`: what the caller has already. One that has some does not wait, because two such could wait
  /// for each other. False if `cancel` was set meanwhile.
  bool acquire(uint64_t bytes, uint64_t held, const std::atomic<bool>& cancel);
  void release(uint64_t bytes);

 private:
  const uint64_t limit_;
  const bool kept_;
  std::mutex mutex_;
  std::condition_variable freed_;
  uint64_t used_ = 0;
};

}  // namespace plumbline::runtime

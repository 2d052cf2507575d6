// What a process and all that it started have of memory, shared mappings and memfds included: RLIMIT_DATA knows
// neither, and holds for each process alone.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>

namespace plumbline::runtime {

/// In bytes, of the process group that `leader` leads; rather too little than too much. 0 if it cannot be read.
uint64_t memory_of_group(pid_t leader);

/// Looks from time to time whether the group keeps a limit. It may begin with some memory of its own.
class GroupLimit {
 public:
  GroupLimit(pid_t leader, uint64_t bytes);
  /// Empty as long as it does, else a sentence. Takes milliseconds with many gigabytes; asks at most every 50 ms.
  std::string broken();

 private:
  const pid_t leader_;
  const uint64_t limit_, before_;
  int64_t asked_ = 0;  // milliseconds
};

}  // namespace plumbline::runtime

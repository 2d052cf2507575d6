// Threads that a node starts and leaves running.
#pragma once

#include <sys/types.h>

#include <memory>
#include <string>

namespace plumbline::runtime {

/// Sees the threads that are started from this thread as long as it lives, and those that they start. Scopes nest; the
/// innermost counts. Threads of libraries that keep theirs for whoever comes next (TBB, OpenMP, OpenCV, BLAS) are none
/// of a node's.
class ThreadWatch {
 public:
  struct Started;

  ThreadWatch();
  ~ThreadWatch();
  ThreadWatch(const ThreadWatch&) = delete;
  ThreadWatch& operator=(const ThreadWatch&) = delete;

  /// Those that go on: neither at an end a moment later nor asleep until somebody wakes them. As a sentence; empty:
  /// none.
  std::string what_goes_on() const;

 private:
  const std::shared_ptr<Started> started_;
  const std::shared_ptr<Started> outer_;
};

/// pthread_create() as a node calls it, `real` being libc's and `caller` the place that called.
int start_watched_thread(int (*real)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*), const void* caller,
                         pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*), void* argument);

}  // namespace plumbline::runtime

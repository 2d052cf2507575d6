// A loop over indices on a few threads.
#pragma once

#include <atomic>
#include <exception>
#include <thread>
#include <vector>

#include "plumbline/stop.hpp"

namespace plumbline::bundle {

/// Runs `job(i)` for i in [0, count) on `threads` threads. What a job writes must be its own; the first exception of
/// the lowest thread is thrown on, and ends the others at their next index. Throws Stopped if the work is to end.
template <typename Job>
void for_each_index(int count, int threads, const Job& job) {
  if (threads <= 1 || count <= 1) {
    for (int i = 0; i < count; ++i) stop_point(), job(i);
    return;
  }
  std::atomic<int> next{0};
  std::vector<std::exception_ptr> errors(static_cast<size_t>(threads));
  const auto work = [&](size_t thread) {
    try {
      for (int i = next++; i < count; i = next++) stop_point(), job(i);  // asks in the thread of the scope only
    } catch (...) {
      next = count;
      errors[thread] = std::current_exception();
    }
  };
  std::vector<std::thread> pool;
  for (size_t t = 1; t < static_cast<size_t>(threads); ++t) pool.emplace_back(work, t);
  work(0);
  for (auto& thread : pool) thread.join();
  for (const auto& error : errors)
    if (error) std::rethrow_exception(error);
}

}  // namespace plumbline::bundle

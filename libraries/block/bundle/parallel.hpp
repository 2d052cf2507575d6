// A loop over indices on a few threads.
#pragma once

#include <atomic>
#include <exception>
#include <thread>
#include <vector>

namespace plumbline::bundle {

/// Runs `job(i)` for i in [0, count) on `threads` threads. What a job writes must be its own; the first exception of
/// the lowest thread is thrown on.
template <typename Job>
void for_each_index(int count, int threads, const Job& job) {
  if (threads <= 1 || count <= 1) {
    for (int i = 0; i < count; ++i) job(i);
    return;
  }
  std::atomic<int> next{0};
  std::vector<std::exception_ptr> errors(static_cast<size_t>(threads));
  const auto work = [&](size_t thread) {
    try {
      for (int i = next++; i < count; i = next++) job(i);
    } catch (...) {
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

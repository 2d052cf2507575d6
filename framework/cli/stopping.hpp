// Ctrl-C and SIGTERM: the nodes that run are told, and what does not stop in time is left behind. Nothing is lost by
// that, because results are put into the store whole or not at all.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>

namespace plumbline::cli {

/// Set by the first of these signals; the second ends the program. Installs the handlers when it is first asked for.
const std::atomic<bool>& stop_is_asked_for();

/// As long as it lives: if the work does not end soon after it was asked to, says `last_words` and ends the process
/// with exit code 130.
class EndsInTime {
 public:
  explicit EndsInTime(std::function<void()> last_words);
  ~EndsInTime();
  EndsInTime(const EndsInTime&) = delete;
  EndsInTime& operator=(const EndsInTime&) = delete;

 private:
  void watch();
  const std::function<void()> last_words_;
  std::mutex mutex_;
  std::condition_variable done_changed_;
  bool done_ = false;
  std::thread thread_;
};

}  // namespace plumbline::cli

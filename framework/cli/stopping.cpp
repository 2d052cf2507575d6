#include "stopping.hpp"

#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdio>
#include <exception>

#include "runtime/base/running_nodes.hpp"

namespace plumbline::cli {

namespace {

std::atomic<bool> asked_for = false;
static_assert(std::atomic<bool>::is_always_lock_free, "a signal handler sets it");

/// The first signal asks the nodes to stop and says so at once, the second ends the program.
extern "C" void ask_to_stop(int signal) {
  asked_for = true;
  std::signal(signal, SIG_DFL);
  static constexpr char text[] = "\nstopping as soon as the nodes that run now can; once more to end at once\n";
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text, sizeof text - 1);
}

}  // namespace

const std::atomic<bool>& stop_is_asked_for() {
  static const bool installed = [] {
    std::signal(SIGINT, ask_to_stop);
    std::signal(SIGTERM, ask_to_stop);
    return true;
  }();
  (void)installed;
  return asked_for;
}

EndsInTime::EndsInTime(std::function<void()> last_words)
    : last_words_(std::move(last_words)), thread_([this] { watch(); }) {}

EndsInTime::~EndsInTime() {
  {
    const std::scoped_lock lock(mutex_);
    done_ = true;
  }
  done_changed_.notify_all();
  thread_.join();
}

void EndsInTime::watch() {
  using std::chrono::milliseconds;
  constexpr auto look = milliseconds(25), patience = milliseconds(225);
  std::unique_lock lock(mutex_);
  while (!asked_for)
    if (done_changed_.wait_for(lock, look, [this] { return done_; })) return;
  if (done_changed_.wait_for(lock, patience, [this] { return done_; })) return;
  try {
    last_words_();
  } catch (const std::exception& error) {  // a full disk must not make an abort of it
    std::fprintf(stderr, "the run's end is not told in its record: %s\n", error.what());
  }
  std::fflush(stdout);
  runtime::leave_at_once(130);
}

}  // namespace plumbline::cli

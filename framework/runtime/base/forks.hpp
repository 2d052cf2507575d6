// Processes that a node starts in the program itself: with fork(), posix_spawn() or popen().
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace plumbline::runtime {

/// Sees what this thread starts as long as it lives. Scopes nest; the innermost counts.
class ForkWatch {
 public:
  ForkWatch();
  ~ForkWatch();
  ForkWatch(const ForkWatch&) = delete;
  ForkWatch& operator=(const ForkWatch&) = delete;

  /// A copy of the program that a fork() has made and that came back to us ends here: it would go on as a second one,
  /// with the run's files open.
  void end_if_this_is_a_copy() const;

  /// Ends the processes that were started and that nobody waited for. What they were, as a sentence; empty: none.
  std::string end_what_is_left() const;

  /// Of every process that this one starts.
  static void note(pid_t child);

 private:
  const pid_t process_;
  ForkWatch* const outer_;
  std::vector<pid_t> children_;
};

/// Children that this thread gets while it lives, by what the kernel lists (/proc/thread-self/children).
class NewChildren {
 public:
  NewChildren();
  /// Who watches is told of them.
  std::vector<pid_t> note() const;

 private:
  std::vector<pid_t> before_;
};

}  // namespace plumbline::runtime

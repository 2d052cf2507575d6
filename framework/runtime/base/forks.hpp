// Processes that a node forks in the program itself.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace plumbline::runtime {

/// Sees the fork()s of this thread as long as it lives. Scopes nest; the innermost counts.
class ForkWatch {
 public:
  ForkWatch();
  ~ForkWatch();
  ForkWatch(const ForkWatch&) = delete;
  ForkWatch& operator=(const ForkWatch&) = delete;

  /// A copy of the program that a fork() has made and that came back to us ends here: it would go on as a second one,
  /// with the run's files open.
  void end_if_this_is_a_copy() const;

  /// Ends the processes that were forked and that nobody waited for. What they were, as a sentence; empty: none.
  std::string end_what_is_left() const;

  /// Of every fork() in this process.
  static void note(pid_t child);

 private:
  const pid_t process_;
  ForkWatch* const outer_;
  std::vector<pid_t> children_;
};

}  // namespace plumbline::runtime

// What a node finds when it runs and must leave as it was: in its thread the floating-point mode (rounding, subnormal
// numbers, traps), blocked signals and locale; in the process locale, umask, working folder, environment and what
// signals do, and which processes run.
//
// Each of them may change the numbers of whatever is computed next in the same process, under a key that knows nothing
// of it. So they are set before a run and looked at after it, in the program and in its workers. A locale that is set
// for a while and put back harms only who runs beside it.
#pragma once

#include <fenv.h>
#include <locale.h>
#include <signal.h>
#include <sys/stat.h>

#include <array>
#include <cstdint>
#include <list>
#include <locale>
#include <mutex>
#include <set>
#include <string>
#include <vector>

namespace plumbline::runtime {

/// As long as it lives, this thread computes in the mode that IEEE 754 has by default: to nearest, with subnormal
/// numbers, without traps. Then it has what it had before.
class ThreadConditions {
 public:
  ThreadConditions();
  ~ThreadConditions();
  ThreadConditions(const ThreadConditions&) = delete;
  ThreadConditions& operator=(const ThreadConditions&) = delete;

  /// What was changed since and is changed still, in words; empty: nothing.
  std::string changes() const;

 private:
  fenv_t mode_{};
  sigset_t blocked_{};
  locale_t locale_;
};

/// Those of the process, as they are when it is made.
class ProcessConditions {
 public:
  ProcessConditions();
  ~ProcessConditions();
  ProcessConditions(const ProcessConditions&) = delete;
  ProcessConditions& operator=(const ProcessConditions&) = delete;

  /// Puts back what has changed and returns it in words; empty: nothing. Takes some microseconds.
  std::string restore();

 private:
  std::string restore_environment();
  std::string restore_folder() const;
  std::string restore_locale() const;
  std::string restore_signals() const;

  mode_t umask_ = 022;
  int folder_ = -1;
  struct stat folder_info_ {};
  std::vector<std::string> environment_;
  std::string locale_;
  std::locale cpp_locale_;
  std::array<struct sigaction, 32> actions_{};
};

/// The runs that go on in this process side by side. What one of them changes in the process may have reached all that
/// ran when it was found.
class SharedConditions {
 public:
  struct Finding {
    std::string changes;         ///< in words; empty: nothing
    std::set<std::string> runs;  ///< who may have done it: all that ran then
  };
  using Run = std::list<std::pair<std::string, Finding>>::iterator;

  Run begin(const std::string& name);
  Finding end(Run run);

 private:
  std::mutex mutex_;
  ProcessConditions conditions_;
  uint64_t locale_sets_ = 0;  // times_locale_was_set() when all was in order last
  std::list<std::pair<std::string, Finding>> running_;
};

/// "it left ... changed", with why that counts and what to do.
std::string left_changed_text(const std::string& changes);

}  // namespace plumbline::runtime

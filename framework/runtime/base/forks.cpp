#include "runtime/base/forks.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "runtime/base/running_nodes.hpp"

namespace plumbline::runtime {

namespace {

thread_local ForkWatch* watch = nullptr;

/// Of a child that nobody has waited for, whether it still runs.
bool goes_on(pid_t child) {
  siginfo_t info{};
  return waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0;
}

}  // namespace

ForkWatch::ForkWatch() : process_(getpid()), outer_(watch) { watch = this; }
ForkWatch::~ForkWatch() { watch = outer_; }

void ForkWatch::note(pid_t child) {
  if (child > 0 && watch) watch->children_.push_back(child);
}

void ForkWatch::end_if_this_is_a_copy() const {
  if (getpid() != process_) leave_at_once(1);
}

std::string ForkWatch::end_what_is_left() const {
  std::string left;
  for (const pid_t child : children_) {
    if (!goes_on(child)) continue;
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    left += (left.empty() ? "" : ", ") + std::to_string(child);
  }
  return left.empty() ? ""
                      : "it ended while what it had forked went on (process " + left +
                            ") and might still have written what it gave; wait for it before the end";
}

}  // namespace plumbline::runtime

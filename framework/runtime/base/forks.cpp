#include "runtime/base/forks.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>

#include "runtime/base/running_nodes.hpp"

namespace plumbline::runtime {

namespace {

thread_local ForkWatch* watch = nullptr;

/// Of a child that nobody has waited for, whether it still runs.
bool goes_on(pid_t child) {
  siginfo_t info{};
  return waitid(P_PID, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0 && info.si_pid == 0;
}

/// Of this thread, none if the kernel does not list them.
std::vector<pid_t> children_now() {
  std::vector<pid_t> children;
  std::ifstream list("/proc/thread-self/children");
  for (pid_t child = 0; list >> child;) children.push_back(child);
  return children;
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
                      : "it ended while a process that it had started went on (process " + left +
                            ") and might still have written what it gave; wait for it before the end";
}

NewChildren::NewChildren() : before_(children_now()) {}

std::vector<pid_t> NewChildren::note() const {
  std::vector<pid_t> found;
  for (const pid_t child : children_now())
    if (std::find(before_.begin(), before_.end(), child) == before_.end()) {
      ForkWatch::note(child);
      found.push_back(child);
    }
  return found;
}

}  // namespace plumbline::runtime

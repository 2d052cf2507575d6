#include "runtime/base/orphans.hpp"

#include <spawn.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <iterator>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "runtime/base/process_list.hpp"

extern char** environ;

namespace plumbline::runtime {

namespace {

std::mutex starts;
std::atomic<bool> takes_in = false;
std::set<pid_t>& known_children() {
  static auto& known = *new std::set<pid_t>;  // nodes may start programs while the process ends
  return known;
}

/// Orphans are given to the first thread of the process.
std::vector<pid_t> children_of_first_thread() {
  const std::string self = std::to_string(getpid());
  std::ifstream list("/proc/self/task/" + self + "/children");
  std::vector<pid_t> children;
  for (pid_t child = 0; list >> child;) children.push_back(child);
  return children;
}

/// Whether there is such a child, of whichever thread, that runs or that nobody has waited for; 0: any.
bool has_child(pid_t child = 0) {
  siginfo_t info{};
  return waitid(child ? P_PID : P_ALL, static_cast<id_t>(child), &info, WEXITED | WNOHANG | WNOWAIT) == 0;
}

/// Another may get the number.
void forget_who_has_ended() {
  std::set<pid_t>& known = known_children();
  for (auto child = known.begin(); child != known.end();)
    child = has_child(*child) ? std::next(child) : known.erase(child);
}

/// What they had started in their turn is an orphan afterwards.
std::string end_orphans_of_now() {
  std::string left;
  for (const pid_t child : children_of_first_thread()) {
    if (known_children().count(child)) continue;
    if (waitpid(child, nullptr, WNOHANG) != 0) continue;  // it had ended
    const ProcessStat process = process_stat(child);
    if (process.group != getpgrp()) continue;
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    left += (left.empty() ? "'" : ", '") + process.name + "' (process " + std::to_string(child) + ")";
  }
  return left;
}

/// As long as a command runs, Ctrl-C is for it: of several at a time the first sets that and the last puts it back.
class InterruptsAreForTheCommand {
 public:
  InterruptsAreForTheCommand() {
    const std::scoped_lock lock(mutex_);
    if (count_++ > 0) return;
    struct sigaction ignored {};
    ignored.sa_handler = SIG_IGN;
    sigaction(SIGINT, &ignored, &interrupt_), sigaction(SIGQUIT, &ignored, &quit_);
  }
  ~InterruptsAreForTheCommand() {
    const std::scoped_lock lock(mutex_);
    if (--count_ == 0) sigaction(SIGINT, &interrupt_, nullptr), sigaction(SIGQUIT, &quit_, nullptr);
  }

  static bool any(std::unique_lock<std::mutex>& held) {
    held = std::unique_lock(mutex_);
    return count_ > 0;
  }

 private:
  inline static std::mutex mutex_;
  inline static int count_ = 0;
  inline static struct sigaction interrupt_ { }, quit_{}; };

}  // namespace

StartOfChild::StartOfChild() { starts.lock(); }
StartOfChild::~StartOfChild() { starts.unlock(); }
void StartOfChild::known(pid_t child) const {
  if (child > 0) known_children().insert(child);
}

void take_in_orphans() {
  static const bool once = [] {
    const std::scoped_lock lock(starts);
    forget_who_has_ended();
    for (const pid_t child : children_of_first_thread())
      if (!known_children().count(child)) return false;
    return takes_in = prctl(PR_SET_CHILD_SUBREAPER, 1) == 0;
  }();
  static_cast<void>(once);
}

std::string end_orphans() {
  if (!takes_in || !has_child()) return "";
  const std::scoped_lock lock(starts);
  forget_who_has_ended();
  std::string all;
  for (std::string left; !(left = end_orphans_of_now()).empty();) all += (all.empty() ? "" : ", ") + left;
  return all;
}

bool commands_go_on(std::unique_lock<std::mutex>& held) { return InterruptsAreForTheCommand::any(held); }

int run_command(const char* command) {
  sigset_t before, without_end_of_child;
  sigemptyset(&without_end_of_child), sigaddset(&without_end_of_child, SIGCHLD);
  pthread_sigmask(SIG_BLOCK, &without_end_of_child, &before);
  const InterruptsAreForTheCommand ignored;
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t defaults;
  sigemptyset(&defaults), sigaddset(&defaults, SIGINT), sigaddset(&defaults, SIGQUIT);
  posix_spawnattr_setsigmask(&attributes, &before);
  posix_spawnattr_setsigdefault(&attributes, &defaults);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  std::string shell = "sh", option = "-c", text = command;
  char* const words[] = {shell.data(), option.data(), text.data(), nullptr};
  pid_t child = 0;
  const int error = posix_spawn(&child, "/bin/sh", nullptr, &attributes, words, environ);
  posix_spawnattr_destroy(&attributes);
  int status = error ? 127 << 8 : -1;
  if (!error)
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  return status;
}

}  // namespace plumbline::runtime

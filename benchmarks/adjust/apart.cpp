#include "apart.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>

namespace plumbline {
namespace {

[[noreturn]] void work_and_leave(const char* name, double limit, const std::function<void()>& work) {
  const auto seconds = static_cast<rlim_t>(limit);
  const rlimit allowed{seconds, seconds + 10};
  setrlimit(RLIMIT_CPU, &allowed);
  int code = 0;
  try {
    work();
  } catch (const std::exception& e) {
    std::printf("  %s: %s\n", name, e.what());
    code = 1;
  }
  std::fflush(stdout);
  _exit(code);
}

}  // namespace

Taken run_apart(const char* name, double limit, const std::function<void()>& work) {
  std::fflush(stdout);
  const pid_t child = fork();
  if (child < 0) {
    std::printf("  %s: no process of its own could be started\n", name);
    return {};
  }
  if (child == 0) work_and_leave(name, limit, work);
  int status = 0;
  rusage used{};
  wait4(child, &status, 0, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  Taken taken{seconds(used.ru_utime) + seconds(used.ru_stime), static_cast<double>(used.ru_maxrss) / 1024,
              WIFEXITED(status) && WEXITSTATUS(status) == 0};
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    std::printf("  %s: %s\n", name,
                signal == SIGXCPU   ? "not at its end within the limit"
                : signal == SIGKILL ? "ended from outside, which is what a machine without memory does"
                                    : strsignal(signal));
  }
  return taken;
}

}  // namespace plumbline

// _exit(), the exec family, fork(), posix_spawn(), popen() and system(), as a node may call them; these stand in the
// place of libc's own for all that is loaded into the program. The first two leave the process without a word: no
// handler of exit() runs, and the exit code may be 0. In the process that runs the node they name it; in one that it
// has forked they do what they always do. What is forked or spawned is noted (forks.hpp), and so are threads
// (thread_watch.hpp), and that the locale of the process is set.
#include <dlfcn.h>
#include <locale.h>
#include <pthread.h>
#include <spawn.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cstdarg>
#include <cstdio>
#include <cstdlib>

#include "runtime/base/forks.hpp"
#include "runtime/base/orphans.hpp"
#include "runtime/base/running_nodes.hpp"
#include "runtime/base/thread_watch.hpp"

#define PLUMBLINE_FOR_ALL __attribute__((visibility("default")))  // libraries that are loaded find these first

namespace {

using plumbline::runtime::end_if_a_node_asks;

[[noreturn]] void leave(int code) {
  for (;;) syscall(SYS_exit_group, code);
}

/// libc's own, looked up while the program starts: in a forked child it may be too late for the loader's locks.
template <typename Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
pid_t (*const real_fork)() = next<pid_t()>("fork");
using Spawn = int(pid_t*, const char*, const posix_spawn_file_actions_t*, const posix_spawnattr_t*, char* const*,
                  char* const*);
using WithEnvironment = int(const char*, char* const*, char* const*);
WithEnvironment* const real_execve = next<WithEnvironment>("execve");
WithEnvironment* const real_execvpe = next<WithEnvironment>("execvpe");
int (*const real_fexecve)(int, char* const*, char* const*) = next<int(int, char* const*, char* const*)>("fexecve");
int (*const real_execveat)(int, const char*, char* const*, char* const*,
                           int) = next<int(int, const char*, char* const*, char* const*, int)>("execveat");

int spawn_noted(Spawn* real, pid_t* child, const char* program, const posix_spawn_file_actions_t* files,
                const posix_spawnattr_t* attributes, char* const* arguments, char* const* environment) {
  pid_t started = 0;
  {
    const plumbline::runtime::StartOfChild start;
    if (const int error = real(&started, program, files, attributes, arguments, environment)) return error;
    start.known(started);
  }
  plumbline::runtime::ForkWatch::note(started);
  if (child) *child = started;
  return 0;
}

/// The arguments of an execl(), which end with a null pointer.
struct Words {
  static constexpr size_t most = 4096;
  const char* list[most + 1] = {};
  Words(const char* first, va_list& more) {
    size_t count = 0;
    for (const char* word = first; word && count < most; word = va_arg(more, const char*)) list[count++] = word;
  }
  char* const* get() const { return const_cast<char* const*>(list); }
};

}  // namespace

extern "C" {

[[noreturn]] PLUMBLINE_FOR_ALL void _exit(int code) {
  end_if_a_node_asks("_exit()");
  leave(code);
}

[[noreturn]] PLUMBLINE_FOR_ALL void _Exit(int code) noexcept {
  end_if_a_node_asks("_Exit()");
  leave(code);
}

PLUMBLINE_FOR_ALL pid_t fork() noexcept {
  pid_t child = 0;
  {
    const plumbline::runtime::StartOfChild start;
    child = real_fork();
    start.known(child);
  }
  plumbline::runtime::ForkWatch::note(child);
  return child;
}

PLUMBLINE_FOR_ALL int posix_spawn(pid_t* child, const char* path, const posix_spawn_file_actions_t* files,
                                  const posix_spawnattr_t* attributes, char* const* arguments,
                                  char* const* environment) {
  static Spawn* const real = next<Spawn>("posix_spawn");  // libraries may spawn while they are loaded
  return spawn_noted(real, child, path, files, attributes, arguments, environment);
}

PLUMBLINE_FOR_ALL int posix_spawnp(pid_t* child, const char* file, const posix_spawn_file_actions_t* files,
                                   const posix_spawnattr_t* attributes, char* const* arguments,
                                   char* const* environment) {
  static Spawn* const real = next<Spawn>("posix_spawnp");
  return spawn_noted(real, child, file, files, attributes, arguments, environment);
}

PLUMBLINE_FOR_ALL FILE* popen(const char* command, const char* mode) {
  static auto* const real = next<FILE*(const char*, const char*)>("popen");
  const plumbline::runtime::StartOfChild start;
  const plumbline::runtime::NewChildren children;  // which one it is libc keeps to itself
  FILE* const stream = real(command, mode);
  if (stream)
    for (const pid_t child : children.note()) start.known(child);
  return stream;
}

PLUMBLINE_FOR_ALL int system(const char* command) { return command ? plumbline::runtime::run_command(command) : 1; }

PLUMBLINE_FOR_ALL int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*run)(void*),
                                     void* argument) noexcept {
  // Libraries start threads while they are loaded, before anything here is made.
  static auto* const real = next<int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>("pthread_create");
  return plumbline::runtime::start_watched_thread(real, __builtin_return_address(0), thread, attributes, run, argument);
}

PLUMBLINE_FOR_ALL char* setlocale(int category, const char* name) noexcept {
  static auto* const real = next<char*(int, const char*)>("setlocale");
  if (name) plumbline::runtime::note_that_locale_is_set();
  return real(category, name);
}

PLUMBLINE_FOR_ALL int execve(const char* path, char* const* arguments, char* const* environment) noexcept {
  end_if_a_node_asks("execve()");
  return real_execve(path, arguments, environment);
}

PLUMBLINE_FOR_ALL int execv(const char* path, char* const* arguments) noexcept {
  end_if_a_node_asks("execv()");
  return real_execve(path, arguments, environ);
}

PLUMBLINE_FOR_ALL int execvp(const char* file, char* const* arguments) noexcept {
  end_if_a_node_asks("execvp()");
  return real_execvpe(file, arguments, environ);
}

PLUMBLINE_FOR_ALL int execvpe(const char* file, char* const* arguments, char* const* environment) noexcept {
  end_if_a_node_asks("execvpe()");
  return real_execvpe(file, arguments, environment);
}

PLUMBLINE_FOR_ALL int fexecve(int file, char* const* arguments, char* const* environment) noexcept {
  end_if_a_node_asks("fexecve()");
  return real_fexecve(file, arguments, environment);
}

PLUMBLINE_FOR_ALL int execveat(int folder, const char* path, char* const* arguments, char* const* environment,
                               int flags) noexcept {
  end_if_a_node_asks("execveat()");
  return real_execveat(folder, path, arguments, environment, flags);
}

PLUMBLINE_FOR_ALL int execl(const char* path, const char* first, ...) noexcept {
  end_if_a_node_asks("execl()");
  va_list more;
  va_start(more, first);
  const Words words(first, more);
  va_end(more);
  return real_execve(path, words.get(), environ);
}

PLUMBLINE_FOR_ALL int execlp(const char* file, const char* first, ...) noexcept {
  end_if_a_node_asks("execlp()");
  va_list more;
  va_start(more, first);
  const Words words(first, more);
  va_end(more);
  return real_execvpe(file, words.get(), environ);
}

PLUMBLINE_FOR_ALL int execle(const char* path, const char* first, ...) noexcept {
  end_if_a_node_asks("execle()");
  va_list more;
  va_start(more, first);
  const Words words(first, more);
  char* const* environment = va_arg(more, char* const*);
  va_end(more);
  return real_execve(path, words.get(), environment);
}

}  // extern "C"

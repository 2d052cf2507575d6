#include "runtime/base/thread_watch.hpp"

#include <dlfcn.h>
#include <pthread.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <new>
#include <set>
#include <thread>

namespace plumbline::runtime {

struct ThreadWatch::Started {
  std::mutex mutex;
  std::set<pid_t> running;
  int beginning = 0;  // created, and not yet in `running`
};

namespace {

using Started = ThreadWatch::Started;
using Routine = void* (*)(void*);

thread_local std::shared_ptr<Started> of_this_thread;

/// In the thread itself, also if it ends by pthread_exit(), which unwinds the stack.
struct Presence {
  explicit Presence(std::shared_ptr<Started> among) : started(std::move(among)), id(gettid()) {
    const std::scoped_lock lock(started->mutex);
    started->running.insert(id);
    --started->beginning;
  }
  ~Presence() {
    const std::scoped_lock lock(started->mutex);
    started->running.erase(id);
  }
  const std::shared_ptr<Started> started;
  const pid_t id;
};

struct Beginning {
  std::shared_ptr<Started> started;
  Routine run;
  void* argument;
};

void* begin_watched(void* given) {
  Beginning beginning = std::move(*static_cast<Beginning*>(given));
  delete static_cast<Beginning*>(given);
  of_this_thread = beginning.started;
  const Presence presence(std::move(beginning.started));
  return beginning.run(beginning.argument);
}

/// Whether what called is a library that keeps its threads when it has no more work for them.
bool keeps_threads(const void* caller) {
  Dl_info info{};
  if (!dladdr(caller, &info) || !info.dli_fname) return false;
  const char* slash = std::strrchr(info.dli_fname, '/');
  const std::string name = slash ? slash + 1 : info.dli_fname;
  for (const char* library :
       {"libtbb", "libgomp", "libiomp", "libomp", "libopencv", "libopenblas", "libblis", "libc.so"})
    if (name.rfind(library, 0) == 0) return true;
  return false;
}

/// Asleep in futex(2) until it is woken, without a time: what the kernel tells of the call it is in.
bool sleeps_until_woken(pid_t thread) {
  std::ifstream file("/proc/self/task/" + std::to_string(thread) + "/syscall");
  std::string call, address, operation, value, time;
  if (!(file >> call)) return !file.is_open();  // it has ended, or this kernel does not tell
  if (call != std::to_string(SYS_futex) || !(file >> address >> operation >> value >> time)) return false;
  return std::strtoull(time.c_str(), nullptr, 16) == 0;
}

/// Those that go on, among them -1 for each of which nothing is known yet.
std::multiset<pid_t> going_on(Started& started) {
  const std::scoped_lock lock(started.mutex);
  std::multiset<pid_t> list;
  for (const pid_t thread : started.running)
    if (!sleeps_until_woken(thread)) list.insert(thread);
  for (int i = 0; i < started.beginning; ++i) list.insert(-1);
  return list;
}

}  // namespace

ThreadWatch::ThreadWatch() : started_(std::make_shared<Started>()), outer_(of_this_thread) {
  of_this_thread = started_;
}
ThreadWatch::~ThreadWatch() { of_this_thread = outer_; }

std::string ThreadWatch::what_goes_on() const {
  using std::chrono::milliseconds;
  constexpr auto patience = milliseconds(200), look = milliseconds(2);  // one that was told to end needs a moment
  std::multiset<pid_t> list = going_on(*started_);
  for (auto waited = milliseconds(0); !list.empty() && waited < patience; waited += look) {
    std::this_thread::sleep_for(look);
    list = going_on(*started_);
  }
  if (list.empty()) return "";
  return "it ended while " +
         (list.size() == 1 ? std::string("a thread that it had started")
                           : std::to_string(list.size()) + " threads that it had started") +
         " went on and might still have changed what it gave, or what another node computes; join " +
         (list.size() == 1 ? "it" : "them") + " before the end";
}

int start_watched_thread(int (*real)(pthread_t*, const pthread_attr_t*, Routine, void*), const void* caller,
                         pthread_t* thread, const pthread_attr_t* attributes, Routine run, void* argument) {
  if (!of_this_thread || keeps_threads(caller)) return real(thread, attributes, run, argument);
  auto* beginning = new (std::nothrow) Beginning{of_this_thread, run, argument};
  if (!beginning) return EAGAIN;
  const std::shared_ptr<Started> started = of_this_thread;
  {
    const std::scoped_lock lock(started->mutex);
    ++started->beginning;
  }
  const int failed = real(thread, attributes, &begin_watched, beginning);
  if (failed) {
    delete beginning;
    const std::scoped_lock lock(started->mutex);
    --started->beginning;
  }
  return failed;
}

}  // namespace plumbline::runtime

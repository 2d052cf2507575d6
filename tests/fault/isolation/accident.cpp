// Nodes that take their process down in one way each: for the tests of isolation.
#include <fenv.h>
#include <locale.h>
#include <poll.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <thread>

#include "artifacts/number.hpp"
#include "plumbline/node.hpp"

namespace {

using namespace plumbline;

NumberT number(double value) {
  NumberT result;
  result.value = value;
  return result;
}

/// Waits until another node of the same place is there too: true only if both run at once.
bool meet(const std::string& place) {
  namespace fs = std::filesystem;
  const fs::path folder = place;
  std::ofstream(folder / std::to_string(getpid())) << "here";
  for (int i = 0; i < 2000; ++i) {
    if (std::distance(fs::directory_iterator(folder), {}) >= 2) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return false;
}

/// Stays for a while, and complains of company.
void be_alone(const std::string& place) {
  namespace fs = std::filesystem;
  const fs::path mine = fs::path(place) / std::to_string(getpid());
  std::ofstream(mine) << "here";
  std::this_thread::sleep_for(std::chrono::milliseconds(150));
  const auto present = std::distance(fs::directory_iterator(place), {});
  fs::remove(mine);
  if (present != 1) throw std::runtime_error("it was not alone");
}

void kill_and_wait(pid_t process) {
  pollfd ending{static_cast<int>(syscall(SYS_pidfd_open, process, 0)), POLLIN, 0};
  kill(process, SIGKILL);
  poll(&ending, 1, 20000);
  close(ending.fd);
}

/// A thread that ends when its time is over, one that waits for work for ever, or one that starts such a one.
void leave_thread(const std::string& how) {
  const auto pool = [] {
    static auto& mutex = *new std::mutex;  // never destroyed: that would wait for who waits
    static auto& work = *new std::condition_variable;
    std::unique_lock lock(mutex);
    for (;;) work.wait(lock);
  };
  const auto crash_later = [] {
    std::this_thread::sleep_for(std::chrono::milliseconds(600));
    std::raise(SIGSEGV);
  };
  const auto wait = [](int milliseconds) { std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds)); };
  if (how == "leave_thread") std::thread(crash_later).detach();
  if (how == "leave_grandchild") std::thread([=] { std::thread(wait, 5000).detach(); }).join();
  if (how == "leave_soon") std::thread(wait, 20).detach();
  if (how == "leave_pool") std::thread(pool).detach();
}

/// A program that goes on for half a minute, or one that it waits for.
void start_program(const std::string& how) {
  if (how == "system") {
    if (std::system("sleep 30.125 &") != 0 || std::system("exit 3") != 3 << 8)
      throw std::runtime_error("no such system()");
    return;
  }
  if (how == "system_and_wait") {
    if (std::system("sleep 0.3; exit 3") != 3 << 8) throw std::runtime_error("its command did not end as it should");
    return;
  }
  if (how == "system_of_two") {  // a shell that goes on, with one that goes on
    if (std::system("(sleep 30.125; echo done) &") != 0) throw std::runtime_error("no such system()");
    return;
  }
  if (how == "popen_of_two") {  // the shell stays, and waits for the first of them
    if (!popen("sleep 30.125; echo done", "r")) throw std::runtime_error("cannot start sleep");
    return;
  }
  if (how == "popen") {
    if (!popen("sleep 30", "r")) throw std::runtime_error("cannot start sleep");
    return;
  }
  const bool waits = how == "spawn_and_wait";
  std::string program = "sleep", seconds = waits ? "0.01" : "30";
  char* const words[] = {program.data(), seconds.data(), nullptr};
  pid_t child = 0;
  if (posix_spawnp(&child, "sleep", nullptr, nullptr, words, environ)) throw std::runtime_error("cannot start sleep");
  if (!waits) return;
  waitpid(child, nullptr, 0);
  if (FILE* const stream = popen("exit 3", "r"); !stream || WEXITSTATUS(pclose(stream)) != 3)
    throw std::runtime_error("popen() and pclose() are not those of libc");
}

struct Accident : Node {
  static constexpr Info info{"accident.happens", "", 1, "Ends its process in the way that is asked for"};
  Optional<Number> in{"number", "passed on if nothing happens"};
  Param<std::string> how{
      "how", "not",
      one_of("not", "crash", "abort", "exit", "kill", "hang", "eat", "eat_unchecked", "throw", "shout", "meet", "alone",
             "say_pid", "kill_pid", "share", "memfd", "fork", "fork_and_return", "spawn", "popen", "popen_of_two",
             "system", "system_of_two", "system_and_wait", "spawn_and_wait", "write_input", "leave_thread",
             "leave_grandchild", "leave_pool", "leave_soon"),
      "what happens"};
  Param<std::string> place{"place", "", "folder to meet in"};
  Param<int> mebibytes{"mebibytes", 0, between(0, 4096), "memory to take first"};
  Out<Number> out{"number", "the number"};

  void run(Context& context) override {
    context.reserve_memory(static_cast<uint64_t>(*mebibytes) << 20);
    if (*how != "not") std::fprintf(stderr, "about to %s\n", how->c_str());
    if (*how == "crash") std::raise(SIGSEGV);
    if (*how == "abort") std::abort();
    if (*how == "exit") std::exit(0);
    if (*how == "kill") std::raise(SIGKILL);
    while (*how == "hang") std::this_thread::sleep_for(std::chrono::hours(1));
    while (*how == "shout") std::fprintf(stderr, "%s\n", std::string(1 << 20, 'x').c_str());
    if (*how == "throw") throw std::runtime_error("thrown on purpose");
    if (*how == "meet" && !meet(*place)) throw std::runtime_error("nobody came");
    if (*how == "alone") be_alone(*place);
    std::vector<std::vector<char>> eaten;
    while (*how == "eat") eaten.emplace_back(1 << 24, 'x');
    while (*how == "eat_unchecked") *static_cast<volatile char*>(std::malloc(1 << 24)) = 'x';
    if (*how == "share") {
      constexpr size_t size = size_t{1} << 30;
      void* shared = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
      std::memset(shared, 1, size);
      std::this_thread::sleep_for(std::chrono::seconds(20));
    }
    if (*how == "memfd") {
      const int file = memfd_create("accident", 0);
      const std::string piece(1 << 20, 'x');
      for (int i = 0; i < 1024; ++i)
        if (write(file, piece.data(), piece.size()) < 0) throw std::runtime_error("cannot write");
      std::this_thread::sleep_for(std::chrono::seconds(20));
    }
    if (*how == "fork" && fork() == 0) {
      std::this_thread::sleep_for(std::chrono::seconds(30));
      _exit(0);
    }
    if (*how == "fork_and_return") {
      const pid_t child = fork();
      if (child == 0) return out.commit(number(-1));
      waitpid(child, nullptr, 0);
    }
    if (how->rfind("spawn", 0) == 0 || how->rfind("popen", 0) == 0 || how->rfind("system", 0) == 0) start_program(*how);
    if (how->rfind("leave_", 0) == 0) leave_thread(*how);
    if (*how == "write_input") {
      plumbline_bytes bytes{};
      context.host().get(context.host().context, "number", 0, &bytes);
      *static_cast<volatile char*>(const_cast<void*>(bytes.data)) = 'x';
    }
    if (*how == "say_pid") return out.commit(number(getpid()));
    if (*how == "kill_pid") kill_and_wait(static_cast<pid_t>(in->value()));
    context.metric("seed", static_cast<double>(context.seed() % 1000), "1");
    out.commit(number(in ? in->value() + 1 : 1));
  }
};

void wait_for(const std::filesystem::path& file) {
  for (int i = 0; i < 1000 && !std::filesystem::exists(file); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
}

/// Ends well, but leaves something of its thread or its process other than it was.
struct LeavesChanged : Node {
  static constexpr Info info{"accident.leaves_changed", "", 1, "Changes what a node must leave as it is"};
  Param<std::string> what{"what", required,
                          one_of("rounding", "vector_rounding", "subnormals", "traps", "blocked", "umask", "folder",
                                 "locale", "locale_for_a_while", "environment", "signals", "signals_for_a_while"),
                          "what it changes"};
  Param<std::string> place{"place", "", "folder: it goes on until somebody beside it says there that he has seen it"};
  Out<Number> out{"number", "the number"};

  void run(Context&) override {
    if (*what == "rounding") fesetround(FE_UPWARD);
    if (*what == "vector_rounding" || *what == "subnormals" || *what == "traps") {
#if defined(__x86_64__)
      const unsigned mode = __builtin_ia32_stmxcsr();
      __builtin_ia32_ldmxcsr(*what == "traps"             ? mode & ~0x1000u
                             : *what == "vector_rounding" ? mode | 0x4000u
                                                          : mode | 0x8040u);
#endif
    }
    if (*what == "blocked") {
      sigset_t one;
      sigemptyset(&one);
      sigaddset(&one, SIGTERM);
      pthread_sigmask(SIG_BLOCK, &one, nullptr);
    }
    if (*what == "umask") umask(0);
    if (*what == "folder" && chdir("/") != 0) throw std::runtime_error("cannot go there");
    if (what->rfind("locale", 0) == 0) setlocale(LC_ALL, "C.UTF-8");
    if (*what == "environment") {
      setenv("PATH", "/none", 1);
      setenv("ACCIDENT_WAS_HERE", "1", 1);
    }
    if (*what == "signals") std::signal(SIGCHLD, SIG_IGN);
    if (*what == "signals_for_a_while") {  // as long as a command of it runs, Ctrl-C is for that
      const std::string command = "cd '" + *place +
                                  "' && touch changed && for i in $(seq 1000); do test -e seen && break; sleep 0.01; "
                                  "done; sleep 0.5";
      if (std::system(command.c_str()) != 0) throw std::runtime_error("its command did not end as it should");
    } else if (!place->empty()) {
      std::ofstream(std::filesystem::path(*place) / "changed") << "1";
      wait_for(std::filesystem::path(*place) / "seen");
    }
    if (*what == "locale_for_a_while") setlocale(LC_ALL, "C");
    out.commit(number(1));
  }
};

/// What every mode but the default one changes.
struct Thirds : Node {
  static constexpr Info info{"accident.thirds", "", 1, "1000 thirds and a subnormal number, added up"};
  Param<std::string> place{"place", "", "folder: it goes on until somebody beside it says there what he has changed"};
  Param<int> salt{"salt", 0, between(0, 1000), "not used"};
  Optional<Number> after{"after", "it runs after what gives it"};
  Out<Number> out{"number", "the sum"};
  void run(Context& context) override {
    if (!place->empty()) {
      wait_for(std::filesystem::path(*place) / "changed");
      std::ofstream(std::filesystem::path(*place) / "seen") << "1";
    }
    context.metric("pid", getpid(), "1");
    volatile double one = 1, three = 3, sum = 0, small = 1e-310;
    for (int i = 0; i < 1000; ++i) sum = sum + one / three;
    out.commit(number(sum + (small * 0.5 > 0 ? 1 : 0)));
  }
};

struct Sink : Node {
  static constexpr Info info{"accident.count", "", 1, "Adds one to each of many numbers"};
  Each<Number> in{"number", "a number"};
  Out<Number> out{"number", "one more"};
  void run(Context&) override { out.commit(number(in->value() + 1)); }
};

}  // namespace

PLUMBLINE_PLUGIN("accident", "0.1.0", "MIT", Accident, LeavesChanged, Thirds, Sink)

// Nodes that take their process down in one way each: for the tests of isolation.
#include <poll.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
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

struct Accident : Node {
  static constexpr Info info{"accident.happens", "", 1, "Ends its process in the way that is asked for"};
  Optional<Number> in{"number", "passed on if nothing happens"};
  Param<std::string> how{"how", "not",
                         one_of("not", "crash", "abort", "exit", "kill", "hang", "eat", "eat_unchecked", "throw",
                                "shout", "meet", "alone", "say_pid", "kill_pid"),
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
    if (*how == "say_pid") return out.commit(number(getpid()));
    if (*how == "kill_pid") kill_and_wait(static_cast<pid_t>(in->value()));
    context.metric("seed", static_cast<double>(context.seed() % 1000), "1");
    out.commit(number(in ? in->value() + 1 : 1));
  }
};

struct Sink : Node {
  static constexpr Info info{"accident.count", "", 1, "Adds one to each of many numbers"};
  Each<Number> in{"number", "a number"};
  Out<Number> out{"number", "one more"};
  void run(Context&) override { out.commit(number(in->value() + 1)); }
};

}  // namespace

PLUMBLINE_PLUGIN("accident", "0.1.0", "MIT", Accident, Sink)

#include "runtime/base/running_nodes.hpp"

#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <memory>

namespace plumbline::runtime {

namespace {

// Read by signal handlers: atomics and plain pointers only.
std::array<std::atomic<const char*>, 512> running;
thread_local const char* in_this_thread = nullptr;
SharedNodes* shared = nullptr;
std::atomic<pid_t> process = 0;  // in which they run
std::atomic<int> record = -1;
std::atomic<uint64_t> times_of_locale = 0;

/// The first letter last: whoever reads in between reads nothing.
void share(size_t slot, const std::string& text) {
  if (!shared || slot >= shared->text.size()) return;
  auto& place = shared->text[slot];
  place[0] = 0;
  if (text.empty()) return;
  const size_t size = std::min(text.size(), place.size() - 1);
  std::memcpy(&place[1], text.data() + 1, size - 1);
  place[size] = 0;
  std::atomic_signal_fence(std::memory_order_seq_cst);
  place[0] = text[0];
}

void say(const char* text) { [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text, std::strlen(text)); }

bool any_runs() {
  if (process != getpid()) return false;  // forked by a node: its end is nobody else's
  for (const auto& slot : running)
    if (slot.load()) return true;
  return false;
}

/// The node of this thread; in a thread that a node started, all that run are in question.
template <typename Say>
void name_culprits(const char* what, const char* detail, const Say& say) {
  if (in_this_thread) {
    say(in_this_thread);
  } else {
    const char* joint = "";
    for (const auto& slot : running)
      if (const char* text = slot.load()) {
        say(joint);
        say(text);
        joint = "\nor ";
      }
  }
  say(what);
  say(detail);
}

/// A line of JSON, made in place: a signal handler may take no memory.
class RecordLine {
 public:
  void add(const char* text) {
    for (; *text; ++text) {
      const auto c = static_cast<unsigned char>(*text);
      if (c >= 0x20 && c != '"' && c != '\\') {
        put(*text);
        continue;
      }
      for (const char digit : {'\\', 'u', '0', '0', "0123456789abcdef"[c >> 4], "0123456789abcdef"[c & 15]}) put(digit);
    }
  }
  void add_plain(const char* text) {
    for (; *text; ++text) put(*text);
  }
  void write_to(int file) const { [[maybe_unused]] const ssize_t written = ::write(file, text_, size_); }

 private:
  void put(char c) {
    if (size_ < sizeof text_) text_[size_++] = c;
  }
  char text_[4096];
  size_t size_ = 0;
};

void name_culprits(const char* what, const char* detail) {
  if (const int file = record; file >= 0) {
    RecordLine line;
    line.add_plain("{\"event\": \"killed\", \"by\": \"");
    name_culprits(what, detail, [&](const char* text) { line.add(text); });
    line.add_plain("\"}\n");
    line.write_to(file);
  }
  if (shared) return;
  say("\n");
  name_culprits(what, detail, say);
  say(".\nThe nodes that were done are kept, and the next run goes on from there. Mend the node's plugin or use another"
      " kind.\n");
}

const char* name_of(int signal) {
  switch (signal) {
    case SIGSEGV:
      return "SIGSEGV, access to memory that is not there";
    case SIGBUS:
      return "SIGBUS, access to memory whose file was cut short or whose disk failed";
    case SIGFPE:
      return "SIGFPE, an impossible operation on integers, or floating-point exceptions that a node had trapped";
    case SIGILL:
      return "SIGILL, an instruction this processor does not have";
    default:
      return "SIGABRT, abort() or an exception that nobody caught";
  }
}

/// Nodes ran here before, and one of them may have left a thread that went on.
void say_crash_without_node(const char* what) {
  for (const char* text : {"\nplumbline crashed while no node ran: ", what,
                           ". A thread that a node has left running may have done it; --isolate says which node.\n"})
    say(text);
}

extern "C" void on_fatal_signal(int signal) {
  if (any_runs())
    name_culprits(" crashed: ", name_of(signal));
  else if (process == getpid())
    say_crash_without_node(name_of(signal));
  ::raise(signal);  // SA_RESETHAND has put the default action back
}

void on_exit() {
  if (!any_runs()) return;
  name_culprits(" called exit(), which a node must not do", "");
  leave_at_once(1);
}

/// A stack for signal handlers: a node that has used up its own must still be named.
struct SignalStack {
  std::unique_ptr<char[]> memory;
  SignalStack() {
    stack_t old{};
    if (sigaltstack(nullptr, &old) != 0 || !(old.ss_flags & SS_DISABLE)) return;
    constexpr size_t size = size_t{64} << 10;
    memory = std::make_unique<char[]>(size);
    stack_t mine{};
    mine.ss_sp = memory.get();
    mine.ss_size = size;
    sigaltstack(&mine, nullptr);
  }
  ~SignalStack() {
    if (!memory) return;
    stack_t none{};
    none.ss_flags = SS_DISABLE;
    sigaltstack(&none, nullptr);
  }
};

}  // namespace

void name_nodes_that_end_the_process() {
  static const bool installed = [] {
    std::atexit(on_exit);
    std::at_quick_exit(on_exit);
    struct sigaction action {};
    action.sa_handler = on_fatal_signal;
    action.sa_flags = static_cast<int>(SA_RESETHAND) | SA_ONSTACK | SA_NODEFER;
    for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT}) sigaction(signal, &action, nullptr);
    return true;
  }();
  (void)installed;
}

void name_them_in_record(int file) { record = file; }

void end_if_a_node_asks(const char* call) {
  if (!any_runs()) return;
  name_culprits(" ended the program, which a node must not do: it called ", call);
  leave_at_once(1);
}

uint64_t times_locale_was_set() { return times_of_locale; }
void note_that_locale_is_set() { ++times_of_locale; }

void leave_at_once(int code) {
  for (;;) ::syscall(SYS_exit_group, code);
}

void tell_running_nodes(SharedNodes& memory) {
  memory = {};
  shared = &memory;
}

std::string nodes_in(const SharedNodes& memory) {
  std::string nodes;
  for (const auto& place : memory.text)
    if (place[0])
      nodes += (nodes.empty() ? "" : " or ") + std::string(place.data(), strnlen(place.data(), place.size()));
  return nodes;
}

RunningNode::RunningNode(std::string text) : text_(std::move(text)), slot_(running.size()), outer_(in_this_thread) {
  thread_local const SignalStack stack;
  process = getpid();
  in_this_thread = text_.c_str();
  for (size_t i = 0; i < running.size(); ++i) {
    const char* empty = nullptr;
    if (running[i].compare_exchange_strong(empty, text_.c_str())) {
      slot_ = i;
      share(i, text_);
      break;
    }
  }
}

RunningNode::~RunningNode() {
  if (slot_ < running.size()) {
    share(slot_, "");
    running[slot_] = nullptr;
  }
  in_this_thread = outer_;
}

}  // namespace plumbline::runtime

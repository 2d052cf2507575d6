// plumbline-worker: runs nodes for a host in a process of its own (workers.hpp). Not to be started by hand.
#include <fcntl.h>
#include <oneapi/tbb/global_control.h>
#include <oneapi/tbb/task_arena.h>
#include <poll.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <fstream>
#include <map>
#include <mutex>
#include <thread>

#include "runtime/base/child_process.hpp"
#include "runtime/base/forks.hpp"
#include "runtime/base/running_nodes.hpp"
#include "runtime/base/thread_watch.hpp"
#include "runtime/plugins/library.hpp"
#include "runtime/run/run_conditions.hpp"
#include "runtime/run/worker_messages.hpp"

namespace plumbline::runtime {

namespace {

constexpr auto without_end = [](short) { return true; };

bool send_to_host(const std::string& body) { return send_message(child_channel, body, without_end); }
bool receive_from_host(std::string& body) { return receive_message(child_channel, body, without_end); }

[[noreturn]] void end_without_memory(const char* what) {
  std::fprintf(stderr, "there is no memory for %s\n", what);
  _exit(1);
}

/// plumbline_host of one run: every service is a question to the host.
class RemoteHost {
 public:
  RemoteHost() {
    table_.size = sizeof table_;
    table_.abi_minor = PLUMBLINE_ABI_MINOR;
    table_.context = this;
    table_.log = [](void* c, int level, const char* text) {
      self(c).tell(Ask::log, static_cast<int32_t>(level), text);
    };
    table_.progress = [](void* c, double fraction, const char* text) { self(c).tell(Ask::progress, fraction, text); };
    table_.cancelled = [](void* c) { return self(c).cancelled(); };
    table_.seed = [](void* c) { return self(c).ask<uint64_t>(Ask::seed); };
    table_.metric = [](void* c, const char* name, double value, const char* unit) {
      self(c).tell(Ask::metric, name, value, unit);
    };
    table_.fail = [](void* c, const char* message) { self(c).tell(Ask::fail, message); };
    table_.parameter = [](void* c, const char* name) { return self(c).text(Ask::parameter, name); };
    table_.item_count = [](void* c, const char* port) {
      return static_cast<size_t>(self(c).ask<uint64_t>(Ask::item_count, port));
    };
    table_.get = [](void* c, const char* port, size_t index, plumbline_bytes* out) {
      return self(c).get(port, index, out);
    };
    table_.commit = [](void* c, const char* port, const void* data, size_t size) -> int {
      return self(c).ask<int32_t>(Ask::commit, port, plumbline_bytes{data, size});
    };
    table_.resolve = [](void* c, const char* uri) { return self(c).text(Ask::resolve, uri); };
    table_.make_folder = [](void* c, const char* port, const char** path, const char** uri) {
      return self(c).make_folder(port, path, uri);
    };
    table_.digest = [](void* c, const char* path) { return self(c).text(Ask::digest, path); };
    table_.reserve_memory = [](void* c, uint64_t bytes) -> int {
      return self(c).ask<int32_t>(Ask::reserve_memory, bytes);
    };
  }

  const plumbline_host* table() const { return &table_; }

  /// Copies that a worker has and a node in the program itself has not.
  uint64_t bytes_of_inputs() {
    const std::scoped_lock lock(kept_mutex_);
    uint64_t sum = 0;
    for (const auto& [place, bytes] : items_) sum += bytes.size();
    return sum;
  }

 private:
  static RemoteHost& self(void* context) { return *static_cast<RemoteHost*>(context); }

  static void put(WireWriter& out, const char* text) { out.text(text); }
  static void put(WireWriter& out, plumbline_bytes bytes) { out.bytes(bytes.data, bytes.size); }
  template <typename Number>
  static void put(WireWriter& out, Number value) {
    out.number(value);
  }

  /// A host that is gone ends the process. So does a copy of it that the node has forked: it has the same socket, and
  /// what it gave would be taken for the node's. So does a message that finds no memory: half of it would be in the
  /// socket.
  template <typename... Values>
  void send(Ask what, Values... values) {
    if (getpid() != worker_) leave_at_once(1);
    WireWriter out;
    out.number(what);
    (put(out, values), ...);
    if (!send_to_host(out.take())) _exit(0);
  }
  template <typename... Values>
  void tell(Ask what, Values... values) {
    const std::scoped_lock lock(mutex_);
    try {
      send(what, values...);
    } catch (const std::bad_alloc&) {
      end_without_memory("a message to the host");
    }
  }
  /// One question, one answer.
  template <typename... Values>
  std::string exchange(Ask what, Values... values) {
    const std::scoped_lock lock(mutex_);
    try {
      std::string answer;
      send(what, values...);
      if (!receive_from_host(answer)) _exit(0);
      return answer;
    } catch (const std::bad_alloc&) {
      end_without_memory(what == Ask::get ? "an input" : what == Ask::commit ? "an output" : "a message from the host");
    }
  }
  template <typename Number, typename... Values>
  Number ask(Ask what, Values... values) {
    const std::string answer = exchange(what, values...);
    return WireReader(answer).number<Number>();
  }

  const char* keep(std::string text) {
    const std::scoped_lock lock(kept_mutex_);
    return kept_.emplace_back(std::move(text)).c_str();
  }
  const char* text(Ask what, const char* name) {
    const std::string answer = exchange(what, name);
    WireReader in(answer);
    return in.there() ? keep(in.bytes()) : nullptr;
  }

  int get(const char* port, size_t index, plumbline_bytes* out) {
    {
      const std::scoped_lock lock(kept_mutex_);
      if (const auto found = items_.find({port, index}); found != items_.end()) {
        *out = {found->second.data(), found->second.size()};
        return 0;
      }
    }
    const std::string answer = exchange(Ask::get, port, static_cast<uint64_t>(index));
    WireReader in(answer);
    if (!in.there()) return 1;
    const std::scoped_lock lock(kept_mutex_);
    const std::string& item = items_.try_emplace({port, index}, in.bytes()).first->second;
    *out = {item.data(), item.size()};
    return 0;
  }

  int make_folder(const char* port, const char** path, const char** uri) {
    const std::string answer = exchange(Ask::make_folder, port);
    WireReader in(answer);
    if (!in.there()) return 1;
    *path = keep(in.bytes());
    *uri = keep(in.bytes());
    return 0;
  }

  /// Nodes ask in their innermost loops: a question a millisecond is enough.
  int cancelled() {
    const auto now = std::chrono::steady_clock::now();
    const std::scoped_lock lock(cancel_mutex_);
    if (!cancelled_ && now - asked_ > std::chrono::milliseconds(1)) {
      cancelled_ = ask<int32_t>(Ask::cancelled);
      asked_ = now;
    }
    return cancelled_;
  }

  plumbline_host table_{};
  const pid_t worker_ = getpid();
  std::mutex mutex_, kept_mutex_, cancel_mutex_;
  std::deque<std::string> kept_;
  std::map<std::pair<std::string, size_t>, std::string> items_;
  int cancelled_ = 0;
  std::chrono::steady_clock::time_point asked_{};
};

const plumbline_node* find_node(const std::string& library, const std::string& identity, const std::string& kind) {
  static std::map<std::string, const plumbline_plugin_table*> open;
  if (file_identity(library) != identity)
    throw std::runtime_error(library + " is not the file any more that was looked at; run again");
  auto found = open.find(library);
  if (found == open.end()) found = open.emplace(library, open_table(library)).first;
  const plumbline_plugin_table* table = found->second;
  for (uint32_t i = 0; table && i < table->node_count; ++i)
    if (kind == table->nodes[i]->kind) return table->nodes[i];
  throw std::runtime_error(library + " has no node '" + kind + "' any more; run again");
}

/// Lets this process have so much more memory of its own than it has now; 0: as much as there is.
void limit_memory(uint64_t bytes) {
  rlimit limit{};
  getrlimit(RLIMIT_DATA, &limit);
  limit.rlim_cur = limit.rlim_max;
  if (bytes) {
    uint64_t pages[6] = {};  // the last one: data and stack
    std::ifstream statm("/proc/self/statm");
    for (uint64_t& value : pages) statm >> value;
    limit.rlim_cur = pages[5] * static_cast<uint64_t>(sysconf(_SC_PAGESIZE)) + bytes;
  }
  setrlimit(RLIMIT_DATA, &limit);
}

/// A line of /proc/self/status such as VmHWM, in bytes; 0 if there is none.
uint64_t status_bytes(const char* name) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.rfind(name, 0) == 0) return std::strtoull(line.c_str() + std::strlen(name) + 1, nullptr, 10) * 1024;
  return 0;
}

/// The memory that is resident now, which from now on is the peak, too; 0 where the kernel cannot set that back.
uint64_t begin_to_measure() {
  std::ofstream reset("/proc/self/clear_refs");
  reset << "5" << std::flush;
  return reset ? status_bytes("VmRSS") : 0;
}

/// What the node has forked or left running is seen, as in the program itself.
int32_t run_watched(RemoteHost& host, const plumbline_node& node) {
  const ForkWatch forks;
  const ThreadWatch threads;
  int32_t answer = 1;
  try {
    answer = node.run(host.table(), &node);
  } catch (...) {
    forks.end_if_this_is_a_copy();
    throw;
  }
  forks.end_if_this_is_a_copy();
  for (const std::string& left : {forks.end_what_is_left(), threads.what_goes_on()})
    if (!left.empty()) host.table()->fail(host.table()->context, left.c_str());
  return answer;
}

int32_t serve(const std::string& request, uint64_t& taken) {
  WireReader in(request);
  in.number<Ask>();
  const std::string library = in.text(), identity = in.text(), kind = in.text();
  const auto memory = in.number<uint64_t>();
  const auto threads = in.number<int32_t>();
  RemoteHost host;
  int32_t answer = 1;
  try {
    ProcessConditions process;
    const ThreadConditions thread;
    const plumbline_node* node = find_node(library, identity, kind);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
    tbb::task_arena arena(threads);
    limit_memory(memory);
    std::string changes;
    const uint64_t before = begin_to_measure();
    arena.execute([&] {
      const ThreadConditions of_node;  // the arena may give it another thread
      answer = run_watched(host, *node);
      changes = of_node.changes();
    });
    const uint64_t peak = status_bytes("VmHWM"), own = before + host.bytes_of_inputs();
    if (before > 0 && peak > own) taken = peak - own;
    if (const std::string more = process.restore(); !more.empty()) changes += (changes.empty() ? "" : ", ") + more;
    if (!changes.empty()) throw std::runtime_error(left_changed_text(changes));
  } catch (const std::exception& error) {
    host.table()->fail(host.table()->context, error.what());
  } catch (...) {
    host.table()->fail(host.table()->context, "the plugin threw something that is no std::exception");
  }
  limit_memory(0);
  return answer;
}

/// A host that is gone has no use for what is still computed.
void end_with_the_host() {
  std::thread([] {
    pollfd other{child_channel, POLLRDHUP, 0};
    while (poll(&other, 1, -1) < 0 && errno == EINTR) {
    }
    _exit(0);
  }).detach();
}

}  // namespace

}  // namespace plumbline::runtime

int main() {
  using namespace plumbline::runtime;
  int kind = 0;
  socklen_t size = sizeof kind;
  if (getsockopt(child_channel, SOL_SOCKET, SO_TYPE, &kind, &size) != 0) {
    std::fprintf(stderr, "plumbline-worker is started by plumbline, for nodes with `isolate: process`\n");
    return 2;
  }
  fcntl(child_channel, F_SETFD, FD_CLOEXEC);  // what a node starts has nothing to say to the host
  end_with_the_host();
  for (std::string request; receive_from_host(request);) {
    WireWriter out;
    out.number(Ask::done);
    uint64_t taken = 0;
    out.number(serve(request, taken));
    out.number(taken);
    std::fflush(nullptr);
    if (!send_to_host(out.take())) break;
  }
  _exit(0);  // not the destructors of what libraries hold
}

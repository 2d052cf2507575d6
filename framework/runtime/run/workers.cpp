#include "runtime/run/workers.hpp"

#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "runtime/base/child_process.hpp"
#include "runtime/base/digest.hpp"
#include "runtime/base/group_memory.hpp"
#include "runtime/base/trust.hpp"
#include "runtime/plugins/library.hpp"
#include "runtime/run/worker_messages.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Seconds = std::chrono::duration<double>;

struct Worker {
  ChildProcess process;
  int socket = -1;
  std::string library;  // that it ran last
};

namespace {

constexpr auto patience_after_cancel = std::chrono::milliseconds(125);

Worker start(const fs::path& program, const std::string& library) {
  if (access(program.c_str(), X_OK) != 0)
    throw std::runtime_error("a process of its own needs the program " + program.string() +
                             ", which is not there; build or install plumbline whole");
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw std::runtime_error(std::string("cannot start a worker process: ") + std::strerror(errno));
  Worker worker;
  worker.socket = ends[0];
  worker.library = library;
  ChildStart child;
  child.arguments = {program.string()};
  child.channel = ends[1];
  try {
    worker.process = start_child(child);
  } catch (...) {
    close(ends[0]);
    close(ends[1]);
    throw;
  }
  close(ends[1]);
  return worker;
}

/// Takes its last account; the log stays open.
ChildEnd finish(Worker& worker) {
  close(worker.socket);
  return finish_child(worker.process);
}

void discard(Worker& worker) {
  finish(worker);
  close(worker.process.log);
}

bool has_ended(const Worker& worker) {
  pollfd ending{worker.process.handle, POLLIN, 0};
  return poll(&ending, 1, 0) != 0;
}

/// What the node prints goes where it would go without a process of its own.
void pass_on_print(int log) {
  const std::string text = end_of_log(log, size_t{1} << 20);
  for (size_t at = 0; at < text.size();) {
    const ssize_t count = write(STDERR_FILENO, text.data() + at, text.size() - at);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return;
    at += static_cast<size_t>(count);
  }
}

/// One run of a node in a worker, seen from the host.
class Conversation {
 public:
  Conversation(const plumbline_host& host, const Worker& worker, const Limits& limits)
      : host_(host),
        worker_(worker),
        limit_(limits.seconds),
        memory_(worker.process.pid, limits.memory),
        start_(Clock::now()) {}

  enum class Ending { done, died, late, hungry, cancelled };

  Ending run(const std::string& request) {
    if (!send(request)) return ending_;
    std::string body;
    while (receive(body)) {
      WireReader in(body);
      const auto what = in.number<Ask>();
      if (what == Ask::done) {
        result = in.number<int32_t>();
        taken = in.number<uint64_t>();
        return Ending::done;
      }
      const std::optional<std::string> reply = answer(what, in);
      if (reply && !send(*reply)) break;
    }
    return ending_;
  }

  int result = 1;
  uint64_t taken = 0;
  bool failed = false;  ///< the node gave a reason
  std::string reason, too_much;

 private:
  bool send(const std::string& body) {
    return send_message(worker_.socket, body, [this](short events) { return wait(events); });
  }
  bool receive(std::string& body) {
    return receive_message(worker_.socket, body, [this](short events) { return wait(events); });
  }

  /// Until the socket is ready. False: it never will be, and ending_ says why.
  bool wait(short events) {
    while (true) {
      const double used = Seconds(Clock::now() - start_).count() - waited_;
      if (limit_ > 0 && used > limit_) return end(Ending::late);
      if (too_much = memory_.broken(); !too_much.empty()) return end(Ending::hungry);
      if (!cancelled_ && host_.cancelled(host_.context)) {
        cancelled_ = true;
        cancelled_at_ = Clock::now();
      }
      if (cancelled_ && Clock::now() - cancelled_at_ > patience_after_cancel) return end(Ending::cancelled);
      const double left = limit_ > 0 ? limit_ - used : 1e9;
      pollfd files[2] = {{worker_.socket, events, 0}, {worker_.process.handle, POLLIN, 0}};
      const int ready = poll(files, 2, static_cast<int>(std::ceil(std::min(100.0, 1000 * left))));
      if (ready < 0 && errno != EINTR) return end(Ending::died);
      if (ready > 0 && (files[0].revents & events)) return true;  // also the last words of one that died
      if (ready > 0) return end(Ending::died);
      shorten_log(worker_.process.log);
    }
  }
  bool end(Ending ending) {
    ending_ = ending;
    return false;
  }

  /// What to send back, if anything.
  std::optional<std::string> answer(Ask what, WireReader& in) {
    WireWriter out;
    void* context = host_.context;
    switch (what) {
      case Ask::log: {
        const auto level = in.number<int32_t>();
        host_.log(context, level, in.text().c_str());
        return std::nullopt;
      }
      case Ask::progress: {
        const auto fraction = in.number<double>();
        host_.progress(context, fraction, in.text().c_str());
        return std::nullopt;
      }
      case Ask::cancelled:
        out.number(static_cast<int32_t>(host_.cancelled(context)));
        break;
      case Ask::seed:
        out.number(host_.seed(context));
        break;
      case Ask::metric: {
        const std::string name = in.text();
        const auto value = in.number<double>();
        host_.metric(context, name.c_str(), value, in.text().c_str());
        return std::nullopt;
      }
      case Ask::fail:
        if (!failed) reason = in.text();  // the first is the cause
        failed = true;
        return std::nullopt;
      case Ask::parameter:
        out.text(host_.parameter(context, in.text().c_str()));
        break;
      case Ask::item_count:
        out.number(static_cast<uint64_t>(host_.item_count(context, in.text().c_str())));
        break;
      case Ask::get: {
        const std::string port = in.text();
        plumbline_bytes bytes{};
        const bool good = host_.get(context, port.c_str(), in.number<uint64_t>(), &bytes) == 0;
        out.number(static_cast<uint8_t>(good));
        if (good) out.bytes(bytes.data, bytes.size);
        break;
      }
      case Ask::commit: {
        const std::string port = in.text(), bytes = in.bytes();
        out.number(static_cast<int32_t>(host_.commit(context, port.c_str(), bytes.data(), bytes.size())));
        break;
      }
      case Ask::resolve:
        out.text(host_.resolve(context, in.text().c_str()));
        break;
      case Ask::make_folder: {
        const char *path = nullptr, *uri = nullptr;
        const bool good = host_.make_folder(context, in.text().c_str(), &path, &uri) == 0;
        out.number(static_cast<uint8_t>(good));
        if (good) out.bytes(path, std::strlen(path)), out.bytes(uri, std::strlen(uri));
        break;
      }
      case Ask::digest:
        out.text(host_.digest(context, in.text().c_str()));
        break;
      case Ask::reserve_memory: {
        const auto before = Clock::now();
        out.number(static_cast<int32_t>(host_.reserve_memory(context, in.number<uint64_t>())));
        waited_ += Seconds(Clock::now() - before).count();
        break;
      }
      default:
        throw std::runtime_error("the worker process says what no worker says");
    }
    return out.take();
  }

  const plumbline_host& host_;
  const Worker& worker_;
  const double limit_;
  GroupLimit memory_;
  const Clock::time_point start_;
  double waited_ = 0;  // for memory that others hold: no time of this node
  Ending ending_ = Ending::died;
  bool cancelled_ = false;
  Clock::time_point cancelled_at_;
};

/// The file that the worker is to find: the one that was scanned, or one that was linked anew to the same bytes.
std::string identity_of(const Plugin& plugin) {
  const std::string now = file_identity(plugin.identity.path);
  return now != plugin.file_identity && sha256_of_file(plugin.identity.path) == plugin.sha256 ? now
                                                                                              : plugin.file_identity;
}

}  // namespace

fs::path worker_program() {
  std::error_code failed;
  return fs::read_symlink("/proc/self/exe", failed).parent_path().parent_path() / "lib" / "plumbline" /
         "plumbline-worker";
}

Workers::Workers(fs::path program, int threads) : program_(std::move(program)), threads_(threads) {}

Workers::~Workers() {
  for (Worker& worker : idle_) discard(worker);
}

Worker Workers::take(const std::string& library) {
  while (true) {
    Worker worker;
    {
      const std::scoped_lock lock(mutex_);
      if (idle_.empty()) break;
      const auto same =
          std::find_if(idle_.begin(), idle_.end(), [&](const Worker& idle) { return idle.library == library; });
      const auto best = same == idle_.end() ? idle_.begin() : same;
      worker = *best;
      idle_.erase(best);
    }
    if (has_ended(worker)) {  // killed by somebody while it had nothing to do
      discard(worker);
      continue;
    }
    worker.library = library;
    return worker;
  }
  const fs::path program = program_.empty() ? worker_program() : program_;
  if (const std::string problem = distrust(program); !problem.empty())
    throw std::runtime_error("no worker is started: " + problem);
  return start(program, library);
}

int Workers::run(const plumbline_host& host, const GraphNode& node, uint64_t& taken) {
  try {
    Worker worker = take(fs::absolute(node.kind.plugin->identity.path).string());
    return run_in(worker, host, node, taken);
  } catch (const std::exception& error) {
    host.fail(host.context, error.what());
    return 1;
  }
}

int Workers::run_in(Worker& worker, const plumbline_host& host, const GraphNode& node, uint64_t& taken) {
  WireWriter request;
  request.number(Ask::run);
  request.text(worker.library);
  request.text(identity_of(*node.kind.plugin));
  request.text(node.kind.node->kind);
  request.number(node.limits.memory);
  request.number(static_cast<int32_t>(threads_));
  Conversation conversation(host, worker, node.limits);
  using Ending = Conversation::Ending;
  Ending ending;
  try {
    empty_log(worker.process.log);
    ending = conversation.run(request.take());
  } catch (...) {
    discard(worker);
    throw;
  }
  taken = conversation.taken;
  if (ending == Ending::done && !conversation.failed) {
    pass_on_print(worker.process.log);
    const std::scoped_lock lock(mutex_);
    idle_.push_back(worker);
    return conversation.result;
  }
  std::string reason = conversation.reason;
  const ChildEnd end = finish(worker);
  const int log = worker.process.log;
  if (ending == Ending::done) {
    pass_on_print(log);
    if (node.limits.memory && reason.find("bad_alloc") != std::string::npos)
      reason += ": its limit of memory is " + mebibytes_text(node.limits.memory);
  } else if (ending == Ending::late) {
    reason = lateness_text(node.limits.seconds, log);
  } else if (ending == Ending::hungry) {
    reason = conversation.too_much + "; " + last_words(log);
  } else if (ending == Ending::cancelled) {
    reason = "it did not stop when it was told to, and was killed";
  } else {
    reason = death_text(end, log, node.limits.memory);
  }
  close(log);
  host.fail(host.context, reason.c_str());
  return ending == Ending::done ? conversation.result : 1;
}

}  // namespace plumbline::runtime

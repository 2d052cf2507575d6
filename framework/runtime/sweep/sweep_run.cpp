#include "runtime/sweep/sweep_run.hpp"

#include <fmt/core.h>
#include <malloc.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstring>
#include <deque>
#include <filesystem>
#include <map>
#include <memory>
#include <numeric>
#include <thread>

#include "runtime/base/memory_budget.hpp"
#include "runtime/base/running_nodes.hpp"
#include "runtime/sweep/sweep_job.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

using Clock = std::chrono::steady_clock;

/// Where nodes leave what they hand on if only the results are kept; in memory where there is such a folder. It is the
/// parent's, so that a worker that is killed leaves nothing behind; what a killed parent left, the next one removes.
class Scratch {
 public:
  Scratch() {
    const fs::path base = access("/dev/shm", W_OK) == 0 ? "/dev/shm" : fs::temp_directory_path();
    const std::string prefix = "plumbline-cells-";
    std::error_code ignored;
    for (const auto& entry : fs::directory_iterator(base, ignored)) {
      const std::string name = entry.path().filename();
      if (name.compare(0, prefix.size(), prefix) != 0) continue;
      const long process = std::strtol(name.c_str() + prefix.size(), nullptr, 10);
      if (process > 0 && kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH)
        fs::remove_all(entry.path(), ignored);
    }
    std::string name = (base / (prefix + std::to_string(getpid()) + "-XXXXXX")).string();
    if (!mkdtemp(name.data())) throw StoreError("cannot make a folder in " + base.string() + ": " + strerror(errno));
    folder_ = name;
  }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  ~Scratch() {
    std::error_code ignored;
    fs::remove_all(folder_, ignored);
  }
  const fs::path& folder() const { return folder_; }

 private:
  fs::path folder_;
};

bool send_all(int socket, const void* data, size_t size) {
  const char* at = static_cast<const char*>(data);
  while (size > 0) {
    const ssize_t sent = ::send(socket, at, size, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) return false;
    at += sent, size -= static_cast<size_t>(sent);
  }
  return true;
}

bool receive_all(int socket, void* data, size_t size) {
  char* at = static_cast<char*>(data);
  while (size > 0) {
    const ssize_t got = ::recv(socket, at, size, 0);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    at += got, size -= static_cast<size_t>(got);
  }
  return true;
}

/// How a worker ended, for people.
std::string cause_of_end(bool timed_out, double limit, int status) {
  if (timed_out) return fmt::format("it took longer than {:g} s and was ended", limit);
  if (!WIFSIGNALED(status)) return "its process ended with code " + std::to_string(WEXITSTATUS(status));
  const int signal = WTERMSIG(status);
  return "its process died of signal " + std::to_string(signal) + " (" + strsignal(signal) + ")" +
         (signal == SIGKILL ? "; the system kills so when memory is short" : "");
}

/// Memory that a worker and this process share; it outlives the worker.
SharedNodes* shared_nodes() {
  void* const memory = mmap(nullptr, sizeof(SharedNodes), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  return memory == MAP_FAILED ? nullptr : static_cast<SharedNodes*>(memory);
}

struct Worker {
  SharedNodes* nodes = nullptr;  ///< what it runs
  pid_t process = -1;
  int socket = -1;
  bool busy = false, timed_out = false;
  SweepJob job;
  Clock::time_point started;
};

class Pool {
 public:
  Pool(const SweepPlan& plan, const Registry& registry, Store& store, fs::path scratch, const SweepRunOptions& options,
       SweepProgress& progress, const std::function<void(const SweepProgress&)>& tell)
      : plan_(plan),
        registry_(registry),
        store_(store),
        scratch_(std::move(scratch)),
        options_(options),
        progress_(progress),
        tell_(tell) {}
  Pool(const Pool&) = delete;
  Pool& operator=(const Pool&) = delete;
  ~Pool() {
    for (Worker& worker : workers_) {
      if (worker.socket >= 0) ::close(worker.socket);
      if (worker.process > 0) {
        if (worker.busy) kill(worker.process, SIGKILL);
        waitpid(worker.process, nullptr, 0);
      }
      if (worker.nodes) munmap(worker.nodes, sizeof(SharedNodes));
    }
  }

  void run(std::deque<SweepJob> jobs) {
    const int processors = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
    const int wanted = options_.workers > 0 ? options_.workers : processors;
    const auto count = std::min<size_t>(static_cast<size_t>(wanted), jobs.size());
    threads_ = std::max(1, wanted / static_cast<int>(std::max<size_t>(1, count)));
    memory_ = (options_.memory ? options_.memory : MemoryBudget::default_limit()) / std::max<size_t>(1, count);
    workers_.resize(count);
    for (Worker& worker : workers_) worker.nodes = shared_nodes();
    jobs_ = std::move(jobs);
    while (!failure_ && (!jobs_.empty() || any_busy())) {
      if (cancelled()) jobs_.clear(), progress_.cancelled = true;
      if (!changed_plugin_.empty()) jobs_.clear();
      for (Worker& worker : workers_)
        if (!worker.busy && !jobs_.empty()) give(worker);
      listen();
    }
    if (failure_)
      throw StoreError("a worker could not keep its results; is the disk full? See 'df " + store_.folder().string() +
                       "'");
    if (!changed_plugin_.empty())
      throw std::runtime_error(
          changed_plugin_ +
          " was changed while cells ran; the bench was stopped, because what failed since then says nothing of its "
          "alternatives. Run again: cells that were done are kept, if what computed them is still the same");
  }

 private:
  bool cancelled() const { return options_.cancel && *options_.cancel; }
  bool any_busy() const {
    return std::any_of(workers_.begin(), workers_.end(), [](const Worker& worker) { return worker.busy; });
  }

  void start(Worker& worker) {
    int ends[2];
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
      throw std::runtime_error(std::string("cannot start a worker: ") + strerror(errno));
    const pid_t process = fork();
    if (process < 0) throw std::runtime_error(std::string("cannot start a worker: ") + strerror(errno));
    if (process == 0) {
      ::close(ends[0]);
      for (const Worker& other : workers_)
        if (other.socket >= 0) ::close(other.socket);
      prctl(PR_SET_PDEATHSIG, SIGKILL);  // a node that hangs must not outlive who would end it
      if (getppid() != parent_) _exit(0);
      if (worker.nodes) tell_running_nodes(*worker.nodes);
      serve(ends[1]);
    }
    ::close(ends[1]);
    worker.process = process;
    worker.socket = ends[0];
  }

  /// The worker's life. It leaves without destructors: what the parent owns is the parent's.
  [[noreturn]] void serve(int socket) {
    // Trial after trial takes the same memory: given back to the system in between, each page costs a fault.
    mallopt(M_MMAP_THRESHOLD, 64 << 20);
    mallopt(M_TRIM_THRESHOLD, 256 << 20);
    Store store(store_.folder());  // its own: temporary names are made of the process
    for (;;) {
      size_t count = 0;
      if (!receive_all(socket, &count, sizeof count)) _exit(0);
      SweepJob job;
      job.run = run_;
      job.cells.resize(count);
      if (!receive_all(socket, job.cells.data(), count * sizeof(size_t))) _exit(0);
      SweepAnswer answer;
      try {
        answer = run_sweep_job(plan_, job, registry_, store, scratch_, threads_, memory_, options_.cancel);
      } catch (const std::exception&) {
        answer.store_failed = true;
      }
      if (!send_all(socket, &answer, sizeof answer)) _exit(0);
    }
  }

  void give(Worker& worker) {
    if (worker.process < 0) start(worker);
    worker.job = std::move(jobs_.front());
    jobs_.pop_front();
    worker.busy = true;
    worker.timed_out = false;
    worker.started = Clock::now();
    const size_t count = worker.job.cells.size();
    if (!send_all(worker.socket, &count, sizeof count) ||
        !send_all(worker.socket, worker.job.cells.data(), count * sizeof(size_t)))
      died(worker);
  }

  void listen() {
    std::vector<pollfd> sockets;
    for (const Worker& worker : workers_)
      if (worker.busy) sockets.push_back({worker.socket, POLLIN, 0});
    if (sockets.empty()) return;
    ::poll(sockets.data(), sockets.size(), options_.limit > 0 ? 100 : 1000);
    size_t next = 0;
    for (Worker& worker : workers_) {
      if (!worker.busy) continue;
      if (sockets[next++].revents == 0) {
        enforce_limit(worker);
        continue;
      }
      SweepAnswer answer;
      if (receive_all(worker.socket, &answer, sizeof answer))
        finished(worker, answer);
      else
        died(worker);
    }
  }

  void enforce_limit(Worker& worker) {
    const double seconds = std::chrono::duration<double>(Clock::now() - worker.started).count();
    if (options_.limit > 0 && seconds > options_.limit * static_cast<double>(worker.job.cells.size())) {
      worker.timed_out = true;
      kill(worker.process, SIGKILL);
    }
  }

  void finished(Worker& worker, const SweepAnswer& answer) {
    worker.busy = false;
    failure_ |= answer.store_failed;
    for (const size_t cell : worker.job.cells)
      if (answer.plugins_changed && changed_plugin_.empty()) {
        const std::vector<std::string> changed = changed_plugins(plan_.cells[cell].graph->graph);
        changed_plugin_ = changed.empty() ? "a plugin" : changed.front();
      }
    progress_.nodes += answer.nodes;
    progress_.merged_nodes += answer.merged;
    progress_.executed += answer.executed;
    progress_.cancelled |= answer.cancelled;
    if (answer.cancelled || answer.store_failed || answer.plugins_changed) return;
    progress_.done += worker.job.cells.size();
    progress_.failed += answer.failed;
    tell_(progress_);
  }

  void died(Worker& worker) {
    int status = 0;
    waitpid(worker.process, &status, 0);
    ::close(worker.socket);
    worker.process = worker.socket = -1;
    worker.busy = false;
    if (worker.job.cells.size() > 1) {  // one of them did it: each by itself will tell which
      for (const size_t cell : worker.job.cells) jobs_.push_front({{cell}});
      return;
    }
    CellRecord record;
    record.failed = true;
    record.host = this_host();
    const std::string node = worker.nodes ? nodes_in(*worker.nodes) : "";
    record.error = (node.empty() ? "" : node + ": ") + cause_of_end(worker.timed_out, options_.limit, status);
    CellRecords(store_).put(plan_.cells[worker.job.cells[0]].key, record);
    ++progress_.done;
    ++progress_.failed;
    tell_(progress_);
  }

  const SweepPlan& plan_;
  const Registry& registry_;
  Store& store_;
  const fs::path scratch_;
  const SweepRunOptions& options_;
  SweepProgress& progress_;
  const std::function<void(const SweepProgress&)>& tell_;
  const pid_t parent_ = getpid();
  const std::string run_ = this_host() + " " + std::to_string(parent_) + " " +
                           std::to_string(std::chrono::system_clock::now().time_since_epoch().count());
  int threads_ = 1;
  uint64_t memory_ = 0;
  bool failure_ = false;
  std::string changed_plugin_;  ///< while cells ran
  std::vector<Worker> workers_;
  std::deque<SweepJob> jobs_;
};

}  // namespace

std::vector<size_t> all_cells(const SweepPlan& plan) {
  std::vector<size_t> indices(plan.cells.size());
  std::iota(indices.begin(), indices.end(), size_t{0});
  return indices;
}

SweepProgress run_cells(const SweepPlan& plan, const std::vector<size_t>& indices, const Registry& registry,
                        Store& store, const SweepRunOptions& options,
                        const std::function<void(const SweepProgress&)>& tell) {
  SweepProgress progress;
  progress.cells = indices.size();
  const CellRecords records(store);
  std::map<size_t, SweepJob> by_trial;
  for (const size_t index : indices) {
    const SweepCell& cell = plan.cells[index];
    const auto record = records.find(cell.key);
    if (record && !(record->failed && options.retry)) {
      ++progress.found, ++progress.done;
      progress.failed += record->failed;
    } else if (!cell.graph) {
      CellRecord refused;
      refused.failed = true;
      refused.error = cell.problem;
      refused.host = this_host();
      records.put(cell.key, refused);
      ++progress.done, ++progress.failed;
    } else {
      by_trial[cell.trial].cells.push_back(index);
    }
  }
  tell(progress);
  std::deque<SweepJob> jobs;
  for (auto& [trial, job] : by_trial) jobs.push_back(std::move(job));
  {
    std::unique_ptr<Scratch> scratch;
    if (!plan.file.keep_everything) scratch = std::make_unique<Scratch>();
    Pool pool(plan, registry, store, scratch ? scratch->folder() : fs::path(), options, progress, tell);
    pool.run(std::move(jobs));
  }
  return progress;
}

}  // namespace plumbline::runtime

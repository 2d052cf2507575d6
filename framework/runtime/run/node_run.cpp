#include "runtime/run/node_run.hpp"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <ctime>
#include <deque>
#include <filesystem>
#include <mutex>
#include <set>

#include "runtime/base/digest.hpp"
#include "runtime/base/forks.hpp"
#include "runtime/base/thread_watch.hpp"
#include "runtime/plugins/artifact_rules.hpp"
#include "runtime/plugins/artifact_type.hpp"
#include "runtime/plugins/executable_node.hpp"
#include "runtime/store/used_files.hpp"

namespace plumbline::runtime {

namespace fs = std::filesystem;

namespace {

/// The context behind plumbline_host. Nodes may call from several threads, so all state is under one mutex.
class Host {
 public:
  Host(const NodeCall& call, const NodeServices& services) : call_(call), services_(services) {
    table_.size = sizeof table_;
    table_.abi_minor = PLUMBLINE_ABI_MINOR;
    table_.context = this;
    table_.log = [](void* c, int level, const char* text) { self(c).log(level, text); };
    table_.progress = [](void* c, double fraction, const char* text) { self(c).progress(fraction, text); };
    table_.cancelled = [](void* c) -> int { return self(c).cancelled(); };
    table_.seed = [](void* c) { return self(c).seed(); };
    table_.metric = [](void* c, const char* name, double value, const char* unit) {
      self(c).metric(name, value, unit);
    };
    table_.fail = [](void* c, const char* message) { self(c).fail(message ? message : "no reason given"); };
    table_.parameter = [](void* c, const char* name) { return self(c).parameter(name); };
    table_.item_count = [](void* c, const char* port) { return self(c).item_count(port); };
    table_.get = [](void* c, const char* port, size_t index, plumbline_bytes* out) {
      return self(c).guarded([=](Host& h) { *out = h.get(port, index); });
    };
    table_.commit = [](void* c, const char* port, const void* data, size_t size) {
      return self(c).guarded([=](Host& h) { h.commit(port, {data, size}); });
    };
    table_.resolve = [](void* c, const char* uri) {
      return self(c).text_or_null([=](Host& h) { return h.resolve(uri); });
    };
    table_.make_folder = [](void* c, const char* port, const char** path, const char** uri) {
      return self(c).guarded([=](Host& h) { h.make_folder(port, path, uri); });
    };
    table_.digest = [](void* c, const char* path) {
      return self(c).text_or_null([=](Host& h) { return h.services_.store->file_hashes().of(path); });
    };
    table_.reserve_memory = [](void* c, uint64_t bytes) { return self(c).reserve_memory(bytes); };
  }
  Host(const Host&) = delete;
  Host& operator=(const Host&) = delete;
  ~Host() {
    if (reserved_) services_.memory->release(reserved_);
    std::error_code ignored;
    for (const Folder& folder : folders_) fs::remove_all(folder.path, ignored);
  }

  NodeOutcome run();

 private:
  struct Folder {
    std::string port, name, uri, path;  // `name` stands for the hash of its tree as long as that is not known
  };
  struct Held {
    std::string port;
    std::vector<char> bytes;
  };

  static Host& self(void* context) { return *static_cast<Host*>(context); }

  template <typename Action>
  int guarded(Action action) {
    try {
      action(*this);
      return 0;
    } catch (const std::exception& error) {
      fail(error.what());
      return 1;
    }
  }
  template <typename Action>
  const char* text_or_null(Action action) {
    try {
      std::string text = action(*this);
      const std::scoped_lock lock(mutex_);
      return texts_.emplace_back(std::move(text)).c_str();
    } catch (const std::exception& error) {
      const std::scoped_lock lock(mutex_);
      unanswered_ = error.what();
      return nullptr;
    }
  }

  void log(int level, const char* text);
  void progress(double fraction, const char* text);
  bool cancelled();
  uint64_t seed();
  void metric(const char* name, double value, const char* unit);
  void fail(const std::string& message);
  const char* parameter(const char* name) const;
  size_t item_count(const char* port) const;
  plumbline_bytes get(const std::string& port, size_t index);
  void commit(const std::string& port, plumbline_bytes bytes);
  std::string resolve(const std::string& uri);
  std::string partial_folder();
  void make_folder(const std::string& port, const char** path, const char** uri);
  int reserve_memory(uint64_t bytes);

  int run_it();
  int run_here(const plumbline_node& node);
  const plumbline_port& output(const std::string& port) const;
  void check_outputs() const;
  void commit_folders();
  void check_references() const;

  const NodeCall& call_;
  const NodeServices& services_;
  plumbline_host table_{};
  std::mutex mutex_;
  NodeOutcome outcome_;
  std::map<std::pair<std::string, size_t>, Blob> open_;  // valid until the run ends
  std::deque<std::string> texts_;                        // what const char* answers point into
  std::deque<Folder> folders_;
  std::set<std::string> committed_;                     // outputs of one item
  std::vector<Held> held_;                              // outputs that may name a folder that is not done
  std::vector<std::pair<std::string, fs::path>> used_;  // content hash and place of what was resolved
  fs::path partial_;                                    // asked for by the node
  std::atomic<bool> told_to_stop_ = false;
  std::vector<std::string> said_to_be_used_;  // by an executable, beside what its manifest names
  std::string unanswered_;  // why resolve() or digest() gave nothing: the cause, if the node then fails
  uint64_t reserved_ = 0;
  timespec started_{};  // of an executable, by the clock of files
};

const plumbline_port& Host::output(const std::string& port) const {
  const plumbline_port* found = call_.node->kind.output(port);
  if (!found) throw std::runtime_error("the node has no output '" + port + "'");
  return *found;
}

void Host::log(int level, const char* text) {
  if (level < PLUMBLINE_INFO) return;
  const std::scoped_lock lock(mutex_);
  (level >= PLUMBLINE_WARNING ? outcome_.run.warnings : outcome_.run.messages).emplace_back(text);
}

void Host::progress(double fraction, const char* text) {
  if (services_.progress) services_.progress(fraction, text ? text : "");
}

bool Host::cancelled() {
  if (!services_.cancel->load()) return false;
  told_to_stop_ = true;
  return true;
}

uint64_t Host::seed() {
  const std::scoped_lock lock(mutex_);
  if (!outcome_.drew_seed && services_.seed_drawn) services_.seed_drawn();
  if (!outcome_.drew_seed && !folders_.empty() && outcome_.error.empty())
    outcome_.error =
        "the node asked for its seed after make_folder(); it must ask before, because the folder's name depends on it";
  outcome_.drew_seed = true;
  return call_.seed;
}

void Host::metric(const char* name, double value, const char* unit) {
  const std::scoped_lock lock(mutex_);
  outcome_.run.metrics.push_back({name, value, unit ? unit : ""});
}

/// The first failure is the cause; what follows is mostly its echo.
void Host::fail(const std::string& message) {
  const std::scoped_lock lock(mutex_);
  if (!outcome_.error.empty()) return;
  outcome_.error = message.empty() ? "no reason given" : message;
  if (!unanswered_.empty()) outcome_.error += ": " + unanswered_;
}

const char* Host::parameter(const char* name) const {
  const auto found = call_.node->parameters.find(name);
  return found == call_.node->parameters.end() ? nullptr : found->second.c_str();
}

size_t Host::item_count(const char* port) const {
  const auto found = call_.inputs.find(port);
  return found == call_.inputs.end() ? 0 : found->second.size();
}

plumbline_bytes Host::get(const std::string& port, size_t index) {
  const plumbline_port* declared = call_.node->kind.input(port);
  if (!declared) throw std::runtime_error("the node has no input '" + port + "'");
  const auto items = call_.inputs.find(port);
  if (items == call_.inputs.end()) throw std::runtime_error("input '" + port + "' is not connected");
  if (index >= items->second.size())
    throw std::runtime_error("input '" + port + "' has " + std::to_string(items->second.size()) + " items; item " +
                             std::to_string(index) + " was asked for");
  {
    const std::scoped_lock lock(mutex_);
    if (const auto found = open_.find({port, index}); found != open_.end()) return found->second.bytes();
  }
  const Blob blob = services_.store->get(items->second[index]);
  if (const std::string problem = verify_artifact(call_.node->kind.type_of(*declared), blob.bytes()); !problem.empty())
    throw std::runtime_error("input '" + port + "' is no valid " + declared->type + ": " + problem);
  const std::scoped_lock lock(mutex_);
  return open_.try_emplace({port, index}, blob).first->second.bytes();
}

void Host::commit(const std::string& port, plumbline_bytes bytes) {
  const plumbline_port& declared = output(port);
  const plumbline_type& type = call_.node->kind.type_of(declared);
  if (const std::string problem = verify_artifact(type, bytes); !problem.empty())
    throw std::runtime_error("output '" + port + "' is no valid " + declared.type + ": " + problem);
  if (const std::string problem = broken_rule(type, bytes); !problem.empty())
    throw std::runtime_error("output '" + port + "' is no sound " + declared.type + ": " + problem);
  {
    const std::scoped_lock lock(mutex_);
    if (declared.cardinality != PLUMBLINE_LIST && !committed_.insert(port).second)
      throw std::runtime_error("output '" + port + "' was committed twice; it holds one item");
    if (!folders_.empty()) {
      const char* begin = static_cast<const char*>(bytes.data);
      held_.push_back({port, {begin, begin + bytes.size}});
      return;
    }
  }
  const std::string hash = services_.store->hold(bytes.data, bytes.size);
  const std::scoped_lock lock(mutex_);
  outcome_.run.outputs[port].push_back(hash);
}

/// "partial:" is what a node of this key has done so far: a folder that outlives a run that is killed or stopped, and
/// is removed when the node has its result, or when the store is pruned. Two runs of one key do not work at a time.
std::string Host::partial_folder() {
  const fs::path folder = services_.store->folder() / "partial" / call_.key;
  fs::create_directories(folder);
  const std::scoped_lock lock(mutex_);
  partial_ = folder;
  return folder.string();
}

std::string Host::resolve(const std::string& uri) {
  if (uri == "partial:") return partial_folder();
  {
    const std::scoped_lock lock(mutex_);
    for (const Folder& folder : folders_)  // what this run is still writing
      if (uri == folder.uri || uri.compare(0, folder.uri.size() + 1, folder.uri + "/") == 0)
        return folder.path + uri.substr(folder.uri.size());
  }
  if (FileHashes::names_content(uri)) {
    fs::path place;
    const fs::path path = services_.store->file_hashes().resolve(uri, &place);
    const std::scoped_lock lock(mutex_);
    used_.emplace_back(FileHashes::hash_in(uri), place);
    return path.string();
  }
  const fs::path path = services_.store->resolve(uri);
  if (path.empty() || !fs::exists(path))
    throw std::runtime_error("there is nothing at " + (path.empty() ? uri : path.string()));
  return path.string();
}

void Host::make_folder(const std::string& port, const char** path, const char** uri) {
  output(port);
  const std::scoped_lock lock(mutex_);
  // The folder's name will be the hash of its tree, which nobody knows yet. What is committed until then names it by
  // another hash, which commit_folders() replaces.
  static std::atomic<uint64_t> count = 0;
  const std::string text = call_.key + " " + port + " " + std::to_string(getpid()) + " " + std::to_string(++count);
  const std::string name = sha256_of(text.data(), text.size());
  for (const Folder& folder : folders_)
    if (folder.port == port) throw std::runtime_error("make_folder() was called twice for output '" + port + "'");
  const Folder& made = folders_.emplace_back(Folder{port, name, "store:" + name, services_.store->new_folder()});
  *path = made.path.c_str();
  *uri = made.uri.c_str();
}

int Host::reserve_memory(uint64_t bytes) {
  uint64_t held = 0;
  {
    const std::scoped_lock lock(mutex_);
    held = reserved_;
  }
  const std::string excess = services_.memory->excess(bytes, held);
  if (!excess.empty() && services_.memory->is_kept()) return fail(excess), 1;
  if (!services_.memory->acquire(bytes, held, *services_.cancel)) {
    told_to_stop_ = true;
    return 1;
  }
  const std::scoped_lock lock(mutex_);
  reserved_ += bytes;
  if (!excess.empty()) outcome_.excess = excess;
  return 0;
}

void Host::check_outputs() const {
  const plumbline_node& node = *call_.node->kind.node;
  for (uint32_t i = 0; i < node.output_count; ++i) {
    const plumbline_port& port = *node.outputs[i];
    if (port.cardinality == PLUMBLINE_ONE && !committed_.count(port.name))
      throw std::runtime_error(std::string("the node ended without committing its output '") + port.name + "'");
  }
}

void Host::commit_folders() {
  std::vector<std::pair<std::string, std::string>> names;
  while (!folders_.empty()) {
    const std::string tree = services_.store->commit_folder(folders_.front().path);
    outcome_.run.folders[tree] = tree;
    names.emplace_back(folders_.front().name, tree);
    folders_.pop_front();
  }
  for (Held& held : held_) {
    for (const auto& [name, tree] : names)
      for (auto at = held.bytes.begin();
           (at = std::search(at, held.bytes.end(), name.begin(), name.end())) != held.bytes.end();)
        at = std::copy(tree.begin(), tree.end(), at);
    outcome_.run.outputs[held.port].push_back(services_.store->hold(held.bytes.data(), held.bytes.size()));
  }
  held_.clear();
}

/// A file that changed while the node read it: what came out belongs to neither content.
void Host::check_references() const {
  for (const auto& [hash, place] : used_) {
    std::string now;
    try {
      now = services_.store->file_hashes().of(place);
    } catch (const std::exception&) {  // it is gone
    }
    if (now != hash) throw std::runtime_error(place.string() + " changed while the node worked with it; run again");
  }
}

int Host::run_it() {
  const GraphNode& node = *call_.node;
  if (const auto& executable = node.kind.plugin->executable) {
    started_ = next_tick_of_files();
    return executable->run(table_, *node.kind.node, node.limits, said_to_be_used_);
  }
  if (services_.workers) return services_.workers->run(table_, node, outcome_.memory_taken);
  return run_here(*node.kind.node);
}

/// In this process, where what the node has forked or left running is seen.
int Host::run_here(const plumbline_node& node) {
  const ForkWatch forks;
  const ThreadWatch threads;
  int answer = 1;
  try {
    answer = node.run(&table_, &node);
  } catch (...) {
    forks.end_if_this_is_a_copy();
    throw;
  }
  forks.end_if_this_is_a_copy();
  if (const std::string left = forks.end_what_is_left(); !left.empty()) fail(left);
  if (const std::string left = threads.what_goes_on(); !left.empty()) fail(left);
  return answer;
}

NodeOutcome Host::run() {
  const auto start = std::chrono::steady_clock::now();
  const plumbline_node& node = *call_.node->kind.node;
  outcome_.run.kind = node.kind;
  int answer = 1;
  try {
    answer = run_it();
  } catch (const std::exception& error) {  // a plugin without node.hpp may break the rule that nothing is thrown
    fail(error.what());
  } catch (...) {
    fail("the plugin threw something that is no std::exception");
  }
  if (answer == PLUMBLINE_BAD_INPUT || answer == PLUMBLINE_NOT_CONVERGED)
    outcome_.failure = static_cast<plumbline_answer>(answer);
  if (answer != 0 && outcome_.error.empty())
    outcome_.error = "it returned " + std::to_string(answer) + " without a reason";
  // Told to stop, a node may end with half of its outputs and no error. One that did not ask may be whole, but who
  // stopped the run wants nothing of it any more: it is not stored either way.
  outcome_.cancelled = told_to_stop_ || services_.cancel->load();
  if (outcome_.error.empty() && !outcome_.cancelled)
    guarded([](Host& h) {
      h.check_outputs();
      h.check_references();
      h.outcome_.run.used = hashes_of_used(h.said_to_be_used_, h.started_, h.services_.store->file_hashes());
      h.commit_folders();
      if (std::error_code ignored; !h.partial_.empty()) fs::remove_all(h.partial_, ignored);
    });
  for (uint32_t i = 0; i < node.output_count; ++i) outcome_.run.outputs[node.outputs[i]->name];  // empty lists too
  outcome_.memory_announced = reserved_;
  outcome_.run.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return std::move(outcome_);
}

}  // namespace

NodeOutcome run_node(const NodeCall& call, const NodeServices& services) {
  Host host(call, services);
  return host.run();
}

}  // namespace plumbline::runtime

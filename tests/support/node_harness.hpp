// Runs one node of a built plugin without a pipeline: the tutorial of what a host does, and what the conformance kits
// use.
//
//   NodeHarness node("register.rigid");
//   node.set("scale", "fixed");
//   node.input<Points>("source", points);
//   node.run();                                       // throws NodeFailed with the node's own message
//   TransformT found = node.output<Transform>("transform");
//
// Plugins come from build/lib/plumbline and from $PLUMBLINE_PLUGIN_PATH, so that a plugin from outside meets the same
// kit.
#pragma once

#include <algorithm>
#include <atomic>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "plumbline/artifact.hpp"
#include "plumbline/plugin.h"
#include "runtime/base/digest.hpp"
#include "runtime/plugins/artifact_type.hpp"
#include "runtime/plugins/registry.hpp"
#include "runtime/store/file_hashes.hpp"
#include "test_support.hpp"

namespace plumbline::test {

struct NodeFailed : std::runtime_error {
  using std::runtime_error::runtime_error;
};

inline const runtime::Registry& built_registry() {
  static const runtime::Registry registry = [] {
    auto folders = runtime::Registry::search_path("/nowhere/bin/program");
    folders.push_back(std::filesystem::path(plumbline::test::binary_dir()) / "lib/plumbline");
    return runtime::Registry::discover(folders);
  }();
  return registry;
}

/// All kinds of a role, in alphabetical order: what a conformance kit runs over.
inline std::vector<std::string> kinds_of_role(const std::string& role) {
  std::vector<std::string> kinds;
  for (const auto& [name, kind] : built_registry().kinds())
    if (role == kind.node->role) kinds.push_back(name);
  return kinds;
}

/// Name of a kind as GoogleTest allows it in a parameter.
inline std::string test_name(const testing::TestParamInfo<std::string>& kind) {
  std::string name = kind.param;
  for (char& c : name)
    if (c == '.') c = '_';
  return name;
}

class NodeHarness {
 public:
  explicit NodeHarness(const std::string& kind) {
    const runtime::Kind* found = built_registry().find(kind);
    if (!found) throw std::runtime_error("no built plugin has the node " + kind);
    kind_ = *found;
    for (uint32_t i = 0; i < kind_.node->param_count; ++i)
      if (kind_.node->params[i]->default_text)
        params_[kind_.node->params[i]->name] = kind_.node->params[i]->default_text;
  }

  /// Canonical text of a parameter; items of a list joined by '\x1f'.
  void set(const std::string& param, const std::string& text) {
    if (!kind_.param(param)) throw std::runtime_error(std::string(kind_.node->kind) + " has no parameter " + param);
    params_[param] = text;
  }
  void seed(uint64_t value) { seed_ = value; }
  bool has_input(const std::string& port) const { return kind_.input(port) != nullptr; }

  /// Adds an item to an input port.
  template <typename Table>
  void input(const std::string& port, const typename artifact_traits<Table>::Native& native) {
    flatbuffers::FlatBufferBuilder builder;
    builder.Finish(Table::Pack(builder, &native));
    input_bytes(port, artifact_traits<Table>::name,
                {builder.GetBufferPointer(), builder.GetBufferPointer() + builder.GetSize()});
  }
  void input_bytes(const std::string& port, const std::string& type, std::vector<uint8_t> bytes) {
    const plumbline_port* declared = kind_.input(port);
    if (!declared || type != declared->type)
      throw std::runtime_error(std::string(kind_.node->kind) + " has no input " + port + " of type " + type);
    inputs_[port].push_back(std::move(bytes));
  }

  size_t input_count(const std::string& port) const { return inputs_.count(port) ? inputs_.at(port).size() : 0; }
  /// An item that was added, to be changed.
  std::vector<uint8_t>& input_bytes(const std::string& port, size_t index) { return inputs_.at(port).at(index); }

  void run() {
    outputs_.clear();
    error_.clear();
    announced_ = 0;
    const plumbline_host host = make_host();
    if (kind_.node->run(&host, kind_.node)) throw NodeFailed(error_.empty() ? "(no message)" : error_);
    check_outputs();
  }

  /// Runs the node; all that came of it as one text: outputs, metrics and warnings, or the error after "failed: ".
  std::string outcome() {
    try {
      run();
    } catch (const NodeFailed& error) {
      return std::string("failed: ") + error.what();
    }
    std::string text;
    for (const auto& [port, items] : outputs_)
      for (std::vector<uint8_t> bytes : items) {
        // Where a node's folder is tells nothing of what it does.
        const std::string place = folder_->path().string();
        for (auto at = bytes.begin(); (at = std::search(at, bytes.end(), place.begin(), place.end())) != bytes.end();)
          at = std::fill_n(at, place.size(), '-');
        text += port + " " + runtime::sha256_of(bytes.data(), bytes.size()) + "\n";
      }
    for (const auto& [name, value] : metrics_) text += name + " " + std::to_string(value) + "\n";
    for (const std::string& warning : warnings_) text += warning + "\n";
    return text;
  }

  /// From now on whoever asks whether to stop is told so, after `asks` that were told to go on.
  void stop_after(long asks) { *asks_ = 0, stop_after_ = asks; }
  /// How often the node asked whether it is to stop.
  long asked_to_stop() const { return *asks_; }

  std::vector<const plumbline_param*> declared_parameters() const {
    return {kind_.node->params, kind_.node->params + kind_.node->param_count};
  }
  /// Whether it has the parameter, and `value` is among its choices if it has choices.
  bool has_parameter(const std::string& name, const std::string& value) const {
    const plumbline_param* param = kind_.param(name);
    if (!param || param->choice_count == 0) return param != nullptr;
    return std::find(param->choices, param->choices + param->choice_count, value) !=
           param->choices + param->choice_count;
  }
  /// The value that is set, or the default; empty if there is neither.
  std::string parameter(const std::string& name) const {
    const auto found = params_.find(name);
    return found == params_.end() ? "" : found->second;
  }

  size_t output_count(const std::string& port) const { return outputs_.count(port) ? outputs_.at(port).size() : 0; }
  const std::vector<uint8_t>& output_bytes(const std::string& port, size_t index = 0) const {
    return outputs_.at(port).at(index);
  }
  template <typename Table>
  typename artifact_traits<Table>::Native output(const std::string& port, size_t index = 0) const {
    typename artifact_traits<Table>::Native native;
    flatbuffers::GetRoot<Table>(output_bytes(port, index).data())->UnPackTo(&native);
    return native;
  }
  const std::vector<std::string>& warnings() const { return warnings_; }
  double metric(const std::string& name) const { return metrics_.at(name); }
  /// Bytes of memory that the last run announced, also one that failed.
  uint64_t announced() const { return announced_; }

 private:
  static NodeHarness& self(void* context) { return *static_cast<NodeHarness*>(context); }

  plumbline_host make_host() {
    plumbline_host host{};
    host.size = sizeof host;
    host.abi_minor = PLUMBLINE_ABI_MINOR;
    host.context = this;
    host.log = [](void* c, int level, const char* text) {
      if (level == PLUMBLINE_WARNING) self(c).warnings_.push_back(text);
    };
    host.progress = [](void*, double, const char*) {};
    host.cancelled = [](void* c) { return ++*self(c).asks_ > self(c).stop_after_ ? 1 : 0; };
    host.seed = [](void* c) { return self(c).seed_; };
    host.metric = [](void* c, const char* name, double value, const char*) { self(c).metrics_[name] = value; };
    host.fail = [](void* c, const char* message) { self(c).error_ = message; };
    host.parameter = [](void* c, const char* name) -> const char* {
      const auto found = self(c).params_.find(name);
      return found == self(c).params_.end() ? nullptr : found->second.c_str();
    };
    host.item_count = [](void* c, const char* port) {
      const auto found = self(c).inputs_.find(port);
      return found == self(c).inputs_.end() ? size_t{0} : found->second.size();
    };
    host.get = [](void* c, const char* port, size_t index, plumbline_bytes* out) {
      const auto found = self(c).inputs_.find(port);
      if (found == self(c).inputs_.end() || index >= found->second.size()) return 1;
      *out = {found->second[index].data(), found->second[index].size()};
      return 0;
    };
    host.commit = [](void* c, const char* port, const void* data, size_t size) {
      return self(c).take(port, data, size);
    };
    host.resolve = [](void* c, const char* uri) -> const char* {
      const std::string text = uri;
      try {
        if (text.rfind("sha256:", 0) != 0) return self(c).texts_.insert(text).first->c_str();
        return self(c).texts_.insert(files().locate(text.substr(7, 64)).string()).first->c_str();
      } catch (const std::exception&) {
        return nullptr;
      }
    };
    host.make_folder = [](void* c, const char* port, const char** path, const char** uri) {
      const auto folder = self(c).folder_->path() / port;
      std::filesystem::create_directories(folder);
      *path = *uri = self(c).texts_.insert(folder.string()).first->c_str();
      return 0;
    };
    host.digest = [](void* c, const char* path) -> const char* {
      try {
        return self(c).texts_.insert(files().of(path)).first->c_str();
      } catch (const std::exception&) {
        return nullptr;
      }
    };
    host.reserve_memory = [](void* c, uint64_t bytes) {
      self(c).announced_ += bytes;
      return 0;
    };
    return host;
  }

  /// Where contents were seen, by any harness of the test.
  static runtime::FileHashes& files() {
    static runtime::FileHashes hashes("/dev/null");
    return hashes;
  }

  int take(const std::string& port, const void* data, size_t size) {
    const plumbline_port* declared = kind_.output(port);
    if (!declared) return 1;
    const plumbline_type* type = built_registry().type(declared->type);
    const std::string problem = runtime::verify_artifact(*type, {data, size});
    if (!problem.empty()) {
      error_ = "output '" + port + "' " + problem;
      return 1;
    }
    const auto* bytes = static_cast<const uint8_t*>(data);
    outputs_[port].emplace_back(bytes, bytes + size);
    return 0;
  }

  void check_outputs() const {
    for (uint32_t i = 0; i < kind_.node->output_count; ++i) {
      const plumbline_port& port = *kind_.node->outputs[i];
      if (port.cardinality == PLUMBLINE_ONE && output_count(port.name) != 1)
        throw NodeFailed("output '" + std::string(port.name) + "' was committed " +
                         std::to_string(output_count(port.name)) + " times, must be once");
    }
  }

  runtime::Kind kind_;
  std::map<std::string, std::string> params_;
  std::map<std::string, std::vector<std::vector<uint8_t>>> inputs_, outputs_;
  std::map<std::string, double> metrics_;
  std::vector<std::string> warnings_;
  std::set<std::string> texts_;  // keeps what the host hands out as const char*
  std::string error_;
  uint64_t seed_ = 1, announced_ = 0;
  std::unique_ptr<std::atomic<long>> asks_ = std::make_unique<std::atomic<long>>(0);  // by any thread
  long stop_after_ = std::numeric_limits<long>::max();
  std::unique_ptr<TemporaryFolder> folder_ = std::make_unique<TemporaryFolder>();
};

}  // namespace plumbline::test

// What a node can ask of the host while it runs, beside its ports and parameters.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "plumbline/plugin.h"

namespace plumbline {

/// What the host offers beside ports and parameters.
class Context {
 public:
  Context(const plumbline_host& host, const plumbline_node& node) : host_(host), node_(node) {}
  void info(const std::string& text) const { host_.log(host_.context, PLUMBLINE_INFO, text.c_str()); }
  void warn(const std::string& text) const { host_.log(host_.context, PLUMBLINE_WARNING, text.c_str()); }
  void progress(double fraction, const std::string& text = "") const {
    host_.progress(host_.context, fraction, text.c_str());
  }
  bool cancelled() const { return host_.cancelled(host_.context) != 0; }
  uint64_t seed() const { return host_.seed(host_.context); }
  void metric(const std::string& name, double value, const std::string& unit) const {
    host_.metric(host_.context, name.c_str(), value, unit.c_str());
  }
  /// Path of the file that an artifact names by `uri`. Throws if there is none.
  std::string resolve(const std::string& uri) const {
    const char* path = host_.resolve(host_.context, uri.c_str());
    if (!path) throw std::runtime_error("cannot find '" + uri + "'");
    return path;
  }
  /// SHA-256 of a file as 64 hexadecimal digits. Throws if it cannot be read.
  std::string digest(const std::string& path) const {
    const char* hex = host_.digest(host_.context, path.c_str());
    if (!hex) throw std::runtime_error("cannot read '" + path + "'");
    return hex;
  }
  /// Waits until so much memory is free under the run's limit; it is given back when the node ends. Call it once,
  /// before the allocation, with the whole amount.
  void reserve_memory(uint64_t bytes) const {
    if (host_.reserve_memory(host_.context, bytes)) throw std::runtime_error("cancelled while waiting for memory");
  }
  const plumbline_host& host() const { return host_; }
  const plumbline_node& node() const { return node_; }  ///< the entry that is run

 private:
  const plumbline_host& host_;
  const plumbline_node& node_;
};

}  // namespace plumbline

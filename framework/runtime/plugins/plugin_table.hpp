// A copy of a plugin's table that owns all it points to: what a scan brings home, and what a manifest declares.
#pragma once

#include <deque>
#include <string>
#include <vector>

#include "plumbline/plugin.h"

namespace plumbline::runtime {

class PluginTable {
 public:
  /// Copies a table that check_table() has accepted.
  explicit PluginTable(const plumbline_plugin_table& table);
  /// From the bytes of serialise(). Throws std::runtime_error if they are not.
  explicit PluginTable(const std::string& bytes);
  PluginTable(const PluginTable&) = delete;
  PluginTable& operator=(const PluginTable&) = delete;

  const plumbline_plugin_table& table() const { return table_; }

  /// Makes `run` the function of every node, each with its own user_data.
  void run_by(int (*run)(const plumbline_host*, const plumbline_node*), const std::vector<void*>& user_data);

 private:
  class Parser;
  std::deque<std::string> texts_;  // schemas too
  std::deque<plumbline_port> ports_;
  std::deque<plumbline_param> params_;
  std::deque<plumbline_node> nodes_;
  std::deque<plumbline_type> types_;
  std::deque<std::vector<const plumbline_port*>> port_lists_;
  std::deque<std::vector<const plumbline_param*>> param_lists_;
  std::deque<std::vector<const char*>> choice_lists_;
  std::vector<const plumbline_node*> node_list_;
  std::vector<const plumbline_type*> type_list_;
  plumbline_plugin_table table_{};
};

/// All that the table says, as bytes; functions and user data are left out. Equal tables give equal bytes.
std::string serialise(const plumbline_plugin_table& table);

}  // namespace plumbline::runtime

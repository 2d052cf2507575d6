// What the command line changes of a pipeline's nodes and rounds: node.use=KIND, node.with.PARAMETER=VALUE and the
// like.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "runtime/graph/pipeline_file.hpp"

namespace plumbline::runtime {

/// Replaces the value of a name, or adds it at the end.
template <typename Value>
void set_named(std::vector<std::pair<std::string, Value>>& list, const std::string& key, Value value) {
  for (auto& [name, old] : list)
    if (name == key) {
      old = std::move(value);
      return;
    }
  list.emplace_back(key, std::move(value));
}

/// Texts that are no override of a node (is_node_override()) are passed over.
void apply_node_overrides(const std::vector<std::string>& overrides, PipelineSpec& spec,
                          std::vector<Problem>& problems);

}  // namespace plumbline::runtime

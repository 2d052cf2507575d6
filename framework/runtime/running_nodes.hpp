// Which nodes run in this process, so that a node that ends the process (exit, abort, a crash) is named.
#pragma once

#include <string>

namespace plumbline::runtime {

/// From now on, if the process ends while a node runs in it, standard error names that node, and the exit code is not
/// 0: exit(0) becomes 1, a fatal signal stays what it is.
void name_nodes_that_end_the_process();

/// A node runs in this thread as long as this lives. `text` says which: "p.yaml:3:3: node 'x' (family.kind)".
class RunningNode {
 public:
  explicit RunningNode(std::string text);
  ~RunningNode();
  RunningNode(const RunningNode&) = delete;
  RunningNode& operator=(const RunningNode&) = delete;

 private:
  std::string text_;
  size_t slot_;
  const char* outer_;
};

}  // namespace plumbline::runtime

// Which nodes run in this process, so that a node that ends the process (exit, abort, a crash) is named.
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace plumbline::runtime {

/// What runs in a child process, where its parent reads it after the child's end: memory that both have
/// (MAP_SHARED), all zeros at first. More than eight nodes at once, and what is longer, is cut off.
struct SharedNodes {
  std::array<std::array<char, 400>, 8> text;
};

/// From now on `memory` tells the nodes that run in this process, and standard error does no more: the parent reports.
void tell_running_nodes(SharedNodes& memory);

/// "p.yaml:3:3: node 'x' (family.kind)", joined by " or "; empty if nothing ran.
std::string nodes_in(const SharedNodes& memory);

/// From now on, if the process ends while a node runs in it, standard error names that node, and the exit code is not
/// 0: exit(0) becomes 1, a fatal signal stays what it is.
void name_nodes_that_end_the_process();

/// Where the same is written as a line of a record, {"event": "killed", "by": "..."}; -1: nowhere.
void name_them_in_record(int file);

/// `call` is one that ends this process or puts another program in its place. If a node runs in it, it is that node's
/// work: it is named, and the process ends with exit code 1. Does nothing in a process that a node has forked.
void end_if_a_node_asks(const char* call);

/// How often something here has set the locale of the process, for good or for a while.
uint64_t times_locale_was_set();
void note_that_locale_is_set();

/// Ends the process without a word of any node, whatever runs: for the program itself.
[[noreturn]] void leave_at_once(int code);

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

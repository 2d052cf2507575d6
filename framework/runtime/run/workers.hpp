// Nodes in processes of their own: a crash, a hang past its time limit or a kill for want of memory is an error of that
// node, with the signal and the last lines it printed, and the other branches of the graph go on.
//
// A worker is a small program (worker_main.cpp) that loads the library and runs the node; every service that the node
// asks of its host goes through a socket to the thread that waits for it here, so memory is announced to the one budget
// of the run, and what is committed is verified and stored where it always is. A worker that has done its work is used
// again; one whose node failed, that died or was killed is replaced when the next node needs one.
#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <vector>

#include "runtime/graph/graph.hpp"

namespace plumbline::runtime {

struct Worker;

/// The plumbline-worker of this installation or build, beside the plugins.
std::filesystem::path worker_program();

class Workers {
 public:
  /// `program`: the plumbline-worker to start, empty: worker_program(). Nothing is started before a node needs it, and
  /// never a program that others may write (trust.hpp). `threads`: how many each may use.
  Workers(std::filesystem::path program, int threads);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Runs the node for this host in a worker, within the node's limits. Returns what its run() returned; what went
  /// wrong is told to the host by fail(). `taken`: the memory that it took at most, in bytes; 0 if it is not known.
  int run(const plumbline_host& host, const GraphNode& node, uint64_t& taken);

 private:
  Worker take(const std::string& library);
  int run_in(Worker& worker, const plumbline_host& host, const GraphNode& node, uint64_t& taken);

  const std::filesystem::path program_;
  const int threads_;
  std::mutex mutex_;
  std::vector<Worker> idle_;
};

}  // namespace plumbline::runtime

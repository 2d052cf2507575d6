// Where a node runs: in a worker process if that is asked for, else in this one, watched for what it leaves changed.
//
// A floating-point mode is of the thread that ran the node, so it is known who did it. What belongs to the process may
// be the work of any node that ran at the same time: each of them is then run again in a process of its own, which
// gives the clean result of the innocent and the error of the other. After a mode has leaked, threads that its node has
// started may keep it; from then on all nodes run in processes of their own.
#pragma once

#include "runtime/run/node_run.hpp"
#include "runtime/run/run_conditions.hpp"

namespace plumbline::runtime {

class WatchedRuns {
 public:
  explicit WatchedRuns(Workers& workers) : workers_(workers) {}

  /// `services.workers` set: in a worker.
  NodeOutcome run(const NodeCall& call, NodeServices services);

 private:
  Workers& workers_;
  SharedConditions conditions_;
};

}  // namespace plumbline::runtime

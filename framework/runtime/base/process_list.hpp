// The processes of this machine, as /proc tells of them.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace plumbline::runtime {

struct ProcessStat {
  pid_t pid = 0;
  std::string name;
  char state = 0;  ///< 'Z': it has ended, and its parent has not yet asked how
  pid_t group = 0;
};

/// No pid: it is gone.
ProcessStat process_stat(pid_t process);

/// All that can be seen, in no order; those that end meanwhile may be missing.
std::vector<ProcessStat> running_processes();

/// What goes on although `leader` has ended: the processes of its group, and those that have `setting`, "NAME=VALUE",
/// in their environment, wherever they went. A text for people, "'sleep' (process 123), ..."; empty: none.
std::string left_running(pid_t leader, const std::string& setting);

/// Kills them.
void kill_left_running(pid_t leader, const std::string& setting);

}  // namespace plumbline::runtime
